"""Text files as people's editors write them."""

from __future__ import annotations

from codecs import BOM_UTF16_BE, BOM_UTF16_LE
from pathlib import Path


def read_text(path: Path | str) -> str:
    """The text of a file in UTF-8, or in UTF-16 where its byte-order mark says so; without the mark.

    Raises:
        OSError: missing, or not readable.
        UnicodeDecodeError: no such text.
    """
    data = Path(path).read_bytes()
    return data.decode("utf-16" if data.startswith((BOM_UTF16_LE, BOM_UTF16_BE)) else "utf-8-sig")
