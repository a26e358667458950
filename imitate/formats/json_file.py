"""JSON files that people write, checked against what is expected in them."""

from __future__ import annotations

from pathlib import Path
from typing import TypeVar

from pydantic import TypeAdapter, ValidationError

from imitate.errors import FileError
from imitate.text_file import read_text

T = TypeVar("T")


def read_json(path: Path | str, kind: TypeAdapter[T], missing: str, remedy: str) -> T:
    """What a file holds.

    Args:
        path: the file.
        kind: what it must hold.
        missing: said where there is no such file.
        remedy: what is expected, with an example.

    Raises:
        FileError: missing, unreadable, not JSON, or a field that is wrong; names the first.
    """
    try:
        return kind.validate_json(read_text(path))
    except FileNotFoundError:
        raise FileError(path, missing, remedy) from None
    except OSError as error:
        raise FileError(path, f"cannot be read ({error.strerror or error})") from None
    except UnicodeDecodeError as error:
        raise FileError(path, f"cannot be read as text ({error})", remedy) from None
    except ValidationError as error:
        first = error.errors()[0]
        where = ".".join(map(str, first["loc"]))
        raise FileError(path, f"{where}: {first['msg']}" if where else first["msg"], remedy) from None
