"""The right segmentation of a demonstration, in the JSON that `imitate segment --json` prints."""

from __future__ import annotations

from itertools import pairwise
from pathlib import Path

from pydantic import BaseModel, Field, TypeAdapter

from imitate.demonstration import HAND, TABLE
from imitate.errors import FileError
from imitate.formats.json_file import read_json
from imitate.skill import Abstraction, Segment

_REMEDY = (
    'Expected {"segments": [{"start": 0.0, "end": 8.5, "relevant": ["hand"], "reference": "blue"}, …]}, as '
    "`imitate segment FILE --json` prints it."
)


class _Segment(BaseModel):
    start: float = Field(allow_inf_nan=False)
    end: float = Field(allow_inf_nan=False)
    relevant: tuple[str, ...]
    reference: str


class _Truth(BaseModel):
    segments: tuple[_Segment, ...] = Field(min_length=1)


def read_truth(path: Path | str, names: tuple[str, ...]) -> tuple[Segment, ...]:
    """Segments in order; whatever else the file holds is passed over.

    Args:
        names: of the demonstration's objects.

    Raises:
        FileError: missing, not JSON, a field that is wrong, segments out of order, or an unknown object.
    """
    given = read_json(path, TypeAdapter(_Truth), "no such file with the truth", _REMEDY)
    for k, s in enumerate(given.segments):
        if s.end <= s.start:
            raise FileError(path, f"segments.{k}: ends at {s.end:g} s, not after its start at {s.start:g} s")
        for name in (*s.relevant, s.reference):
            if name not in (HAND, TABLE, *names):
                known = ", ".join(names)
                problem = f"segments.{k}: names {name!r}, which the demonstration has not"
                raise FileError(path, problem, f"It has {known}.")
    for k, (a, b) in enumerate(pairwise(given.segments)):
        if b.start < a.end:
            problem = f"segments.{k + 1}: starts at {b.start:g} s, before the one before it ends"
            raise FileError(path, problem, "List them in order, without overlap.")
    return tuple(Segment(s.start, s.end, Abstraction(s.relevant, s.reference)) for s in given.segments)
