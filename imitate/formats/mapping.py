"""What a foreign file's columns, topics and frames mean: read from a TOML file that the person writes.

A mapping says which of them are the hand and the objects, in which units and in which order. What it leaves
out is recognised by its name, as in a file without a mapping.
"""

from __future__ import annotations

import math
import tomllib
from pathlib import Path
from typing import Annotated, Literal

from pydantic import BaseModel, ConfigDict, Field, ValidationError, model_validator

from imitate.demonstration import HAND, TABLE
from imitate.errors import FileError
from imitate.geometry import NEARLY
from imitate.text_file import read_text

Columns = str | Annotated[list[str], Field(min_length=1)]
"""One column or dataset, a part of one as "name[3]" or "name[0:3]", or a list of these."""
RotationAs = Literal["xyzw", "wxyz", "rotvec", "rpy"]
"""Quaternions in either order; axis times angle; or roll, pitch, yaw about fixed axes. Radians."""

LENGTHS = {"m": 1.0, "cm": 0.01, "mm": 0.001}
TIMES = {"s": 1.0, "ms": 1e-3, "us": 1e-6, "ns": 1e-9}


class _Part(BaseModel):
    model_config = ConfigDict(frozen=True, extra="forbid")


class Body(_Part):
    """Where one body's poses are. Without pose, position, topic and frame it is recognised by its name.

    Attributes:
        pose: seven columns, x y z and a quaternion.
        position: three columns.
        rotation: four columns, or three; where left out beside ``position``, the body never turns.
        rotation_as: what they are, where this body differs from the file.
        topic, frame: of an MCAP file.
        offset: the body's frame in the file's own, metres: x y z, or x y z qx qy qz qw.
        size: of an object along its x y z, metres.
    """

    pose: Columns | None = None
    position: Columns | None = None
    rotation: Columns | None = None
    rotation_as: RotationAs | None = None
    topic: str | None = None
    frame: str | None = None
    offset: list[float] = Field(default=[0.0, 0.0, 0.0])
    size: Annotated[list[Annotated[float, Field(gt=0)]], Field(min_length=3, max_length=3)] | None = None

    @property
    def named(self) -> bool:
        """Whether the mapping says where the poses are."""
        return any((self.pose, self.position, self.topic, self.frame))

    @model_validator(mode="after")
    def _one_source(self) -> Body:
        given = [name for name in ("pose", "position", "topic", "frame") if getattr(self, name)]
        if len(given) > 1:
            raise ValueError(f"{' and '.join(given)} both say where its poses are; keep one")
        if self.rotation and not self.position:
            raise ValueError("rotation stands beside position; for seven columns in a row use pose alone")
        if len(self.offset) not in (3, 7):
            raise ValueError("offset is x y z, or x y z qx qy qz qw")
        if len(self.offset) == 7 and abs(math.hypot(*self.offset[3:]) - 1) >= NEARLY:
            raise ValueError("offset: its last four numbers are no unit quaternion qx qy qz qw")
        return self


class Mapping(_Part):
    """A mapping file; every entry may be left out.

    Attributes:
        time: the column of times.
        time_unit: of that column; where not said, seconds, or what counts since 1970.
        rate: frames a second, where there is no such column.
        length_unit: of positions and sizes in the file; lengths in the mapping itself are metres.
        rotation_as: see `RotationAs`.
        episode: which one, of a file with several; by its column, else the parts between jumps of its times.
        root: the frame of an MCAP file in which poses are to be given, z up.
        columns: list column → names of its elements, which are columns then.
        opening: of the hand, between the fingertips: the sum of these numbers' absolute values, each finger's
            way; of an MCAP file the topic.
        hand, objects: the bodies; objects by the name that they are to have.
    """

    time: str | None = None
    time_unit: Literal["s", "ms", "us", "ns"] | None = None
    rate: float | None = Field(default=None, gt=0)
    length_unit: Literal["m", "cm", "mm"] = "m"
    rotation_as: RotationAs = "xyzw"
    episode: int | None = Field(default=None, ge=0)
    root: str | None = None
    columns: dict[str, list[str]] = {}
    opening: Columns | None = None
    hand: Body = Body()
    objects: dict[str, Body] = {}

    @model_validator(mode="after")
    def _names(self) -> Mapping:
        if self.hand.size is not None:
            raise ValueError("hand.size: the hand has no size; give one to objects")
        if reserved := {HAND, TABLE} & self.objects.keys():
            raise ValueError(f"objects.{min(reserved)}: this name is reserved; choose another")
        if self.time and self.rate:
            raise ValueError("time and rate both say when; keep one")
        return self


def read_mapping(path: Path | str) -> Mapping:
    """A mapping from its TOML file.

    Raises:
        FileError: missing, not TOML, or an entry that is wrong; the message names it and what is valid.
    """
    path = Path(path)
    try:
        given = tomllib.loads(read_text(path))
    except FileNotFoundError:
        raise FileError(path, "no such mapping file", "Pass a TOML file to --mapping.") from None
    except (OSError, UnicodeDecodeError) as error:
        raise FileError(path, f"cannot be read as text ({error})") from None
    except tomllib.TOMLDecodeError as error:
        raise FileError(path, f"is not TOML ({error})") from None
    try:
        return Mapping.model_validate(given)
    except ValidationError as error:
        raise _readable(path, error) from None


def _readable(path: Path, error: ValidationError) -> FileError:
    first = error.errors()[0]
    where = ".".join(str(part) for part in first["loc"] if not str(part).startswith(("constrained", "list[")))
    what = first["msg"].removeprefix("Value error, ")
    if first["type"] == "extra_forbidden":
        of_body = len(first["loc"]) > 1
        valid = Body.model_fields if of_body else Mapping.model_fields
        return FileError(path, f"{where}: no such entry", f"Valid: {', '.join(valid)}.")
    got = "" if first["type"] == "value_error" else f" = {first['input']!r}"
    return FileError(path, f"{where}{got}: {what}" if where else what)
