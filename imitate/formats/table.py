"""Named columns → Demonstration, whatever file they are from.

Without a mapping a body is recognised by its columns' names: NAME_x NAME_y NAME_z and NAME_qx NAME_qy NAME_qz
NAME_qw, also with "." "/" or a space, and with words such as "position" between; one called "hand" is the
hand. NAME_size_x … hold an object's size, the same in every row; "opening", "gripper_width" and the like the
hand's opening.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from imitate.demonstration import HAND, Demonstration
from imitate.errors import DemonstrationError, FileError
from imitate.formats.frames_in_time import EPISODES, Rows, episode_rows, frames_in_time
from imitate.formats.mapping import LENGTHS, Body
from imitate.formats.mapping import Mapping as FileMapping
from imitate.formats.opening import OPENING, in_metres, is_opening
from imitate.formats.rotations import quaternions, rotation_width
from imitate.geometry import Array, compose, nearly_normalised

TIME_NAMES = ("t", "time", "timestamp", "time_s", "seconds")
AXES = ("x", "y", "z", "qx", "qy", "qz", "qw")
SIZES = ("size_x", "size_y", "size_z")
_NAMED = re.compile(
    r"(?P<body>.+?)[._/ ](?P<part>(?:(?:pose|position|pos|translation|orientation|rotation|rot|quaternion"
    r"|quat|size)[._/ ])*)(?P<axis>q[xyzw]|p?[xyz]|w)",
    re.IGNORECASE,
)
_TURNING = re.compile(r"orientation|rotation|rot|quat", re.IGNORECASE)
_PART = re.compile(r"(?P<name>.+)\[(?P<first>\d+)(?P<to>:(?P<last>\d+))?\]")
_LISTED = 24
"""columns that a message lists at most."""


@dataclass(frozen=True)
class Table:
    """Columns of one length, read when they are asked for.

    Attributes:
        path: the file.
        widths: column → how many numbers it holds a row; None where it holds no numbers.
        load: a column's values (T,) or (T, width).
        rate: frames a second, where the file says so elsewhere.
        episode_read: whether the columns are those of the one episode that the mapping chooses.
    """

    path: Path
    widths: Mapping[str, int | None]
    load: Callable[[str], NDArray[Any]]
    rate: float | None = None
    episode_read: bool = False


def demonstration_of(table: Table, mapping: FileMapping, notes: list[str]) -> Demonstration:
    """The demonstration that a table holds.

    Args:
        table: of one file.
        mapping: what its columns mean, where their names do not say so.
        notes: gets what the person ought to know.

    Raises:
        FileError: no hand, no objects or no times; the message lists the columns and shows a mapping.
        DemonstrationError: what the columns hold is no demonstration.
    """
    table = _with_named_elements(table, mapping.columns)
    known = recognised(table.widths)
    objects = mapping.objects or {
        name: Body() for name, axes in known.items() if name != HAND and "x" in axes
    }
    if not objects:
        raise _unrecognised(table, "names no object")
    poses = {
        name: _poses(table, name, body, known.get(name, {}), mapping)
        for name, body in {HAND: mapping.hand, **objects}.items()
    }
    t, rows = _times(table, mapping, len(poses[HAND]), notes)
    opening = _opening(table, mapping)
    return Demonstration(
        t=t,
        hand=poses.pop(HAND)[rows],
        objects=np.stack(list(poses.values()), axis=1)[rows],
        object_names=tuple(poses),
        object_sizes=np.array([_size(table, objects[name], known.get(name, {}), mapping) for name in poses]),
        opening=None if opening is None else opening[rows],
    )


def columns_of(demonstration: Demonstration) -> dict[str, Array]:
    """The columns (T,) that `demonstration_of` makes the same demonstration of.

    Raises:
        DemonstrationError: an object's name that would not be recognised in a column's.
    """
    d = demonstration
    columns = {"t": d.t}
    for name in (HAND, *d.object_names):
        columns |= {f"{name}_{axis}": d.pose_of(name)[:, k] for k, axis in enumerate(AXES)}
        if name != HAND and not np.isnan(d.size_of(name)).all():
            columns |= {f"{name}_{s}": np.full(len(d.t), d.size_of(name)[k]) for k, s in enumerate(SIZES)}
        back = recognised(dict.fromkeys((f"{name}_{part}" for part in (*AXES, *SIZES)), 1))
        if name != name.strip() or list(back) != [name] or len(back[name]) != 10:
            raise DemonstrationError(f"object_names: {name!r} would not be recognised in a column's name.")
    return columns if d.opening is None else {**columns, OPENING: d.opening}


def recognised(names: Mapping[str, int | None]) -> dict[str, dict[str, str]]:
    """Body → axis ("x" … "qw", "size_x" …) → column, of columns whose names say so."""
    found: dict[str, dict[str, str]] = {}
    for name, width in names.items():
        match = _NAMED.fullmatch(name)
        if match is None or width != 1:
            continue
        axis, part = match["axis"].lower().removeprefix("p"), match["part"].lower()
        if "size" in part:
            axis = f"size_{axis}"
        elif _TURNING.search(part) and len(axis) == 1:
            axis = f"q{axis}"
        if axis in AXES or axis in SIZES:
            found.setdefault(match["body"], {})[axis] = name
    short = {body: body.rstrip("/").rsplit("/", 1)[-1] for body in found}
    if len(set(short.values())) < len(found):
        short = dict(zip(found, found, strict=True))
    return {HAND if short[b].lower() == HAND else short[b]: axes for b, axes in found.items()}


def _poses(table: Table, name: str, body: Body, known: dict[str, str], mapping: FileMapping) -> Array:
    if body.topic or body.frame:
        raise FileError(
            table.path,
            f"holds columns, and the mapping names a {'topic' if body.topic else 'frame'} for {name}",
            "Name columns: position = …, rotation = ….",
        )
    order = body.rotation_as or mapping.rotation_as
    turned: Array | None
    if body.pose:
        width = 3 + rotation_width(order)
        both = _values(table, body.pose, width, name)
        position, turned = both[:, :3], both[:, 3:]
    elif body.position:
        position = _values(table, body.position, 3, name)
        turned = _values(table, body.rotation, rotation_width(order), name) if body.rotation else None
    else:
        if lacking := [axis for axis in AXES if axis not in known]:
            what = f"has no {' '.join(lacking)} of {name}" if known else f"names no {name}"
            raise _unrecognised(table, what)
        both = _values(table, [known[axis] for axis in AXES], 7, name)
        position, turned, order = both[:, :3], both[:, 3:], "xyzw"
    scaled = position if mapping.length_unit == "m" else position * LENGTHS[mapping.length_unit]
    poses = np.column_stack([scaled, quaternions(scaled, turned, order)])
    return with_offset(nearly_normalised(poses), body)


def with_offset(poses: Array, body: Body) -> Array:
    """Poses (T, 7) of the body itself, where the file gives those of another frame fixed to it."""
    if not any(body.offset[:3]) and len(body.offset) == 3:
        return poses
    offset = np.array(body.offset if len(body.offset) == 7 else [*body.offset, 0, 0, 0, 1])
    return compose(poses, nearly_normalised(offset))


def _times(table: Table, mapping: FileMapping, frames: int, notes: list[str]) -> tuple[Array, Rows]:
    """Seconds of the rows that are frames, and which these are."""
    column = mapping.time or next((n for n in table.widths if n.lower() in TIME_NAMES), None)
    rate = mapping.rate or (None if column else table.rate)
    names = (n for n, width in table.widths.items() if width == 1 and n.lower() in EPISODES)
    numbered = None if table.episode_read else next(names, None)
    episodes = None if numbered is None else _column(table, numbered, "episode")[:, 0]
    chosen = mapping.model_copy(update={"episode": None}) if table.episode_read else mapping
    if rate:
        rows = np.arange(frames) if episodes is None else episode_rows(table.path, episodes, chosen.episode)
        return np.arange(len(rows)) / rate, rows
    if column is None:
        raise FileError(
            table.path,
            f"has no column of times; {_listed(table)}",
            'Say in a mapping (--mapping FILE.toml) which one it is, time = "NAME", or how many frames a '
            "second there are: rate = 20.0.",
        )
    return frames_in_time(table.path, _values(table, column, 1, "time")[:, 0], episodes, chosen, notes)


def _size(table: Table, body: Body, known: dict[str, str], mapping: FileMapping) -> list[float]:
    if body.size is not None:
        return body.size
    if not all(axis in known for axis in SIZES):
        return [np.nan] * 3
    sizes = _values(table, [known[axis] for axis in SIZES], 3, "size")
    return [float(column[np.argmin(np.isnan(column))]) for column in sizes.T * LENGTHS[mapping.length_unit]]


def _opening(table: Table, mapping: FileMapping) -> Array | None:
    # the sum over the fingers, whichever way each one counts
    unit = LENGTHS[mapping.length_unit]
    if mapping.opening is not None:
        names = [mapping.opening] if isinstance(mapping.opening, str) else mapping.opening
        fingers = np.concatenate([_column(table, name, OPENING) for name in names], axis=1)
        return np.asarray(unit * np.abs(fingers).sum(axis=1))
    for name in (name for name, width in table.widths.items() if width == 1 and is_opening(name)):
        found = unit * _column(table, name, OPENING)[:, 0]
        if in_metres(name, found):
            return np.asarray(found)
    return None


def _values(table: Table, wanted: str | Sequence[str], width: int, body: str) -> Array:
    names = [wanted] if isinstance(wanted, str) else wanted
    parts = [_column(table, name, body) for name in names]
    if len({len(part) for part in parts}) > 1:
        lengths = ", ".join(f"{name}: {len(part)}" for name, part in zip(names, parts, strict=True))
        raise FileError(table.path, f"{body}: columns of different lengths ({lengths})")
    together = np.concatenate(parts, axis=1)
    if together.shape[1] != width:
        raise FileError(
            table.path,
            f"{body}: {', '.join(names)} hold {together.shape[1]} numbers a row; expected {width}",
            'Name a part of a column as "name[0:3]".',
        )
    return together


def _column(table: Table, name: str, body: str) -> Array:
    part = _PART.fullmatch(name) if name not in table.widths else None
    whole = part["name"] if part else name
    if whole not in table.widths:
        raise FileError(table.path, f"has no column {whole!r} (for {body}); {_listed(table)}")
    if table.widths[whole] is None:
        raise FileError(table.path, f"column {whole!r} (for {body}) holds no numbers")
    values = np.asarray(table.load(whole), float)
    values = values.reshape(len(values), -1)
    if part is None:
        return values
    first = int(part["first"])
    last = int(part["last"]) if part["to"] else first + 1
    if not first < last <= values.shape[1]:
        raise FileError(table.path, f"{name} (for {body}): {whole!r} holds {values.shape[1]} numbers a row")
    return values[:, first:last]


def _with_named_elements(table: Table, named: Mapping[str, list[str]]) -> Table:
    elements: dict[str, tuple[str, int]] = {}
    for column, names in named.items():
        width = table.widths.get(column)
        if column not in table.widths:
            raise FileError(table.path, f"has no column {column!r} (in [columns]); {_listed(table)}")
        if width != len(names):
            problem = f"{column!r} holds {width or 'no'} numbers a row, and [columns] names {len(names)}"
            raise FileError(table.path, problem)
        elements |= {name: (column, k) for k, name in enumerate(names)}

    def load(name: str) -> NDArray[Any]:
        if name not in elements:
            return table.load(name)
        column, k = elements[name]
        values = table.load(column)
        return values.reshape(len(values), -1)[:, k]

    return replace(table, widths={**table.widths, **dict.fromkeys(elements, 1)}, load=load)


def _listed(table: Table) -> str:
    words = [
        name if width == 1 else f"{name} ({width or 'no'} numbers)" for name, width in table.widths.items()
    ]
    more = f" and {len(words) - _LISTED} more" if len(words) > _LISTED else ""
    return "its columns are " + ", ".join(words[:_LISTED]) + more if words else "it has no columns"


def _unrecognised(table: Table, problem: str) -> FileError:
    from imitate.formats.suggestion import suggested

    return FileError(
        table.path,
        f"{problem}; {_listed(table)}",
        "Say what they mean in a mapping, and pass it with --mapping FILE.toml. One to start from:\n\n"
        + suggested(table.widths, recognised(table.widths), TIME_NAMES, table.rate is not None),
    )
