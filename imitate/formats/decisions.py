"""The operator's decisions as a JSON file, so that they can be kept and applied again."""

from __future__ import annotations

from pathlib import Path

from pydantic import ConfigDict, TypeAdapter, ValidationError

from imitate.errors import FileError
from imitate.skill import Decision

_DECISIONS = TypeAdapter(tuple[Decision, ...], config=ConfigDict(extra="forbid"))
_REMEDY = (
    'Expected a list such as [{"kind": "move", "segment": 0, "time": 8.3}, {"kind": "relabel", "segment": 1, '
    '"abstraction": {"relevant": ["hand", "blue"], "reference": "green"}}]; kinds are move, relabel, split, '
    "merge and undo."
)


def read_decisions(path: Path | str) -> tuple[Decision, ...]:
    """Decisions in order, with the fields of `imitate.skill.Decision`.

    Raises:
        FileError: missing, not JSON, or a field that is wrong; the message names it.
    """
    try:
        return _DECISIONS.validate_json(Path(path).read_bytes())
    except FileNotFoundError:
        raise FileError(path, "no such decisions file", _REMEDY) from None
    except OSError as error:
        raise FileError(path, f"cannot be read ({error.strerror or error})") from None
    except ValidationError as error:
        first = error.errors()[0]
        where = ".".join(map(str, first["loc"]))
        raise FileError(path, f"{where}: {first['msg']}" if where else first["msg"], _REMEDY) from None
