"""Demonstration ⇄ CSV: one row a frame, named columns, an empty field where something was not seen.

Fields are parted by commas, semicolons or tabs, whichever the header has most of; lines that start with "#"
are passed over.
"""

from __future__ import annotations

import csv
from pathlib import Path

import numpy as np

from imitate.demonstration import Demonstration
from imitate.errors import FileError
from imitate.formats.table import Table, columns_of
from imitate.geometry import Array
from imitate.text_file import read_text

_REMEDY = "The first line names the columns: t, hand_x … hand_qw, NAME_x … NAME_qw; the others are frames."


def csv_table(path: Path) -> Table:
    """Raises FileError for what is no text, has no header or rows of different lengths."""
    try:
        lines = read_text(path).splitlines()
    except (OSError, UnicodeDecodeError) as error:
        raise FileError(path, f"cannot be read as text ({error})", _REMEDY) from None
    kept = [(k, line) for k, line in enumerate(lines, start=1) if line.strip() and not line.startswith("#")]
    if not kept:
        raise FileError(path, "is empty", _REMEDY)
    delimiter = max(",;\t", key=kept[0][1].count)
    rows = list(csv.reader((line for _, line in kept), delimiter=delimiter, skipinitialspace=True))
    names = [name.strip() for name in rows[0]]
    if all(_is_number(name) for name in names):
        raise FileError(path, "has no header: its first line holds numbers", _REMEDY)
    if doubled := [name for name in names if names.count(name) > 1]:
        raise FileError(path, f"names the column {doubled[0]!r} twice", _REMEDY)
    for (number, _), row in zip(kept, rows, strict=False):
        if len(row) != len(names):
            raise FileError(path, f"line {number} has {len(row)} fields, its header {len(names)}", _REMEDY)
    columns = dict(zip(names, zip(*rows[1:], strict=True), strict=True)) if rows[1:] else {}
    numbers = [number for number, _ in kept[1:]]

    def load(name: str) -> Array:
        return _numbers(path, name, columns[name], numbers, comma=delimiter == ";")

    return Table(path, dict.fromkeys(columns, 1), load)


def write_csv(demonstration: Demonstration, path: Path) -> None:
    """Writes every number so that it is read back bit for bit."""
    columns = columns_of(demonstration)
    with path.open("w", encoding="utf-8", newline="") as stream:
        writer = csv.writer(stream)
        writer.writerow(columns)
        for row in zip(*(column.tolist() for column in columns.values()), strict=True):
            writer.writerow("" if value != value else repr(value) for value in row)


def _numbers(path: Path, name: str, texts: tuple[str, ...], lines: list[int], comma: bool) -> Array:
    # decimal commas stand in files whose fields are parted by semicolons
    plain = [text.strip().replace(",", ".") if comma else text.strip() for text in texts]
    try:
        return np.array([text or "nan" for text in plain], float)
    except ValueError:
        k = next(k for k, text in enumerate(plain) if text and not _is_number(text))
        raise FileError(path, f"line {lines[k]}, column {name}: {texts[k]!r} is not a number") from None


def _is_number(text: str) -> bool:
    try:
        float(text)
    except ValueError:
        return False
    return True
