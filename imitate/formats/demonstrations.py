"""Demonstration ⇄ NPZ and MCAP.

NPZ holds t (T,), hand (T, 7), objects (T, K, 7), object_names (K,) and, where known, object_sizes (K, 3).
MCAP holds one topic of foxglove.PoseInFrame for each object, named by the last part of the topic, and one
that ends in "hand"; its times are whole nanoseconds, its sizes the metadata record "object_sizes".
"""

from __future__ import annotations

import zipfile
from collections.abc import Iterator
from fractions import Fraction
from pathlib import Path
from typing import IO, Any

import numpy as np
from foxglove_schemas_protobuf.PoseInFrame_pb2 import PoseInFrame
from google.protobuf.message import DecodeError
from numpy.typing import NDArray

from imitate.demonstration import HAND, Demonstration
from imitate.errors import DemonstrationError, FileError
from imitate.formats.kind import METADATA, POSE_SCHEMA, listed
from imitate.formats.mcap_file import Channel, McapReader, McapWriter, contents, protobuf_channel
from imitate.formats.output import new_file
from imitate.geometry import Array, align_signs, resample

FRAME = "world"
"""the frame that poses are given in, in our own files."""
TOPIC = "/demonstration"
_SIZES = "object_sizes"
_NEEDED = ("t", "hand", "objects", "object_names")


def read_demonstration(path: Path | str) -> Demonstration:
    """A demonstration from NPZ or MCAP, told apart by their content.

    Raises:
        FileError: missing, not readable, or lacking something; the message says what it has.
        DemonstrationError: what it holds is no demonstration; the message names the file and the field.
    """
    path = Path(path)
    if not path.exists():
        raise FileError(path, "no such file", "Give a demonstration as .npz or .mcap.")
    try:
        if path.is_file() and (path.suffix in (".npz", ".npy") or zipfile.is_zipfile(path)):
            return _read_npz(path)
        return _read_mcap(path)
    except DemonstrationError as error:
        raise DemonstrationError(f"{path}: {error}") from None


def write_demonstration(demonstration: Demonstration, path: Path | str, force: bool = False) -> None:
    """Writes NPZ or MCAP, by the suffix of ``path``.

    Raises:
        FileError: the file exists and ``force`` is not given, an unknown suffix, or a folder that cannot be
            written.
    """
    path = Path(path)
    if path.suffix not in (".npz", ".mcap"):
        raise FileError(path, f"cannot be written: unknown suffix {path.suffix!r}", "Use .npz or .mcap.")
    if path.suffix == ".mcap" and (slashed := [n for n in demonstration.object_names if "/" in n]):
        problem = f"cannot hold {', '.join(slashed)}: in MCAP a name is the last part of a topic"
        raise FileError(path, problem, "Write .npz, or rename it.")
    with new_file(path, force) as temporary, temporary.open("wb") as stream:
        if path.suffix == ".mcap":
            _write_mcap(demonstration, stream)
        else:
            _write_npz(demonstration, stream)


def _read_npz(path: Path) -> Demonstration:
    if not zipfile.is_zipfile(path):
        start = path.read_bytes()[:8]
        held_instead = f"it starts with {start!r}" if start else "it is empty"
        raise FileError(path, f"is not an NPZ archive: {held_instead}", _npz_remedy())
    try:
        with path.open("rb") as stream, np.load(stream, allow_pickle=False) as archive:
            held: dict[str, NDArray[Any]] = {name: archive[name] for name in archive.files}
    except Exception as error:  # on damage zipfile, zlib, tokenize and numpy raise nearly everything
        raise FileError(path, f"is not an NPZ archive of plain arrays ({error})", _npz_remedy()) from None
    missing = [name for name in _NEEDED if name not in held]
    if missing:
        has = ", ".join(f"{name} {array.shape}" for name, array in held.items()) or "nothing"
        raise FileError(
            path, f"has no array {' and no '.join(map(repr, missing))}; it has {has}", _npz_remedy()
        )
    names = tuple(str(name) for name in np.atleast_1d(held["object_names"]))
    sizes = held.get(_SIZES, np.full((len(names), 3), np.nan))
    arrays = {**{name: held[name] for name in _NEEDED[:3]}, _SIZES: sizes}
    for name, array in arrays.items():
        if array.dtype.kind not in "fiu":
            raise FileError(path, f"{name} holds {array.dtype}, not numbers", _npz_remedy())
    return Demonstration(object_names=names, **arrays)


def _npz_remedy() -> str:
    return (
        "A demonstration holds t (T,), hand (T, 7), objects (T, K, 7), object_names (K,) and, where known, "
        "object_sizes (K, 3)."
    )


def _write_npz(demonstration: Demonstration, stream: IO[bytes]) -> None:
    np.savez_compressed(
        stream,
        t=demonstration.t,
        hand=demonstration.hand,
        objects=demonstration.objects,
        object_names=np.array(demonstration.object_names),
        object_sizes=demonstration.object_sizes,
    )


def pose_channels(names: tuple[str, ...]) -> list[Channel]:
    """The topics of a demonstration with these objects: the hand's, then one an object."""
    return [protobuf_channel(_topic(name), PoseInFrame) for name in (HAND, *names)]


def pose_messages(demonstration: Demonstration) -> Iterator[tuple[str, PoseInFrame, int]]:
    """(topic, message, nanoseconds since t = 0 or since the first frame, whichever is earlier)."""
    for k, time in enumerate(_nanoseconds(demonstration.t)):
        for name in (HAND, *demonstration.object_names):
            message = PoseInFrame(frame_id=FRAME)
            message.timestamp.FromNanoseconds(time)
            pose = demonstration.pose_of(name)[k].tolist()
            message.pose.position.x, message.pose.position.y, message.pose.position.z = pose[:3]
            rotation = message.pose.orientation
            rotation.x, rotation.y, rotation.z, rotation.w = pose[3:]
            yield _topic(name), message, time


def _topic(name: str) -> str:
    return f"{TOPIC}/hand" if name == HAND else f"{TOPIC}/objects/{name}"


def _nanoseconds(t: Array) -> list[int]:
    origin = min(Fraction(float(t[0])), Fraction(0))
    return [round((Fraction(time) - origin) * 10**9) for time in t.tolist()]


def _write_mcap(demonstration: Demonstration, stream: IO[bytes]) -> None:
    sizes = {
        name: " ".join(map(repr, demonstration.size_of(name).tolist())) for name in demonstration.object_names
    }
    metadata = {METADATA: {"kind": "demonstration"}, _SIZES: sizes}
    with McapWriter(stream, pose_channels(demonstration.object_names), metadata) as writer:
        for topic, message, time in pose_messages(demonstration):
            writer.write(topic, message, time)


def _read_mcap(path: Path) -> Demonstration:
    reader = McapReader(path)
    found: dict[str, list[tuple[int, list[float]]]] = {}
    frames: set[str] = set()
    for message in reader.messages():
        if message.schema_name == POSE_SCHEMA and message.encoding == "protobuf":
            frame, row = _pose_row(path, message.topic, message.data)
            frames.add(frame)
            found.setdefault(message.topic, []).append((message.time, row))
    if reader.damage:
        raise FileError(path, f"is damaged: {reader.damage[0]}", "Record it again.")
    names = _names(path, list(found))
    if len(frames) > 1:
        raise FileError(
            path, f"gives poses in several frames: {', '.join(sorted(frames))}", "Give all in one frame."
        )
    trajectories = {names[topic]: _trajectory(rows) for topic, rows in found.items()}
    hand_times, hand = trajectories.pop(HAND)
    t, poses = _at_common_times(path, hand_times, hand, trajectories)
    sizes = reader.metadata.get(_SIZES, {})
    return Demonstration(
        t=np.array([time / 10**9 for time in t.tolist()]),
        hand=poses[HAND],
        objects=np.stack([poses[name] for name in trajectories], axis=1),
        object_names=tuple(trajectories),
        object_sizes=np.array([_size(path, name, sizes.get(name, "nan nan nan")) for name in trajectories]),
    )


def _pose_row(path: Path, topic: str, data: bytes) -> tuple[str, list[float]]:
    try:
        message = PoseInFrame.FromString(data)
    except DecodeError:
        raise FileError(path, f"topic {topic} holds a message that is no {POSE_SCHEMA}") from None
    p, q = message.pose.position, message.pose.orientation
    return message.frame_id, [p.x, p.y, p.z, q.x, q.y, q.z, q.w]


def _names(path: Path, topics: list[str]) -> dict[str, str]:
    names = {topic: topic.rstrip("/").rsplit("/", 1)[-1] for topic in topics}
    remedy = f'A demonstration has a topic of {POSE_SCHEMA} that ends in "/hand" and one for each object.'
    if len(set(names.values())) < len(names):
        raise FileError(path, f"has topics with the same last part: {', '.join(topics)}", remedy)
    if HAND not in names.values() or len(names) < 2:
        lacking = "no pose of the hand" if HAND not in names.values() else "no pose of an object"
        raise FileError(path, f"has {lacking}; {listed(contents(path).topics)}", remedy)
    return names


def _trajectory(rows: list[tuple[int, list[float]]]) -> tuple[NDArray[np.int64], Array]:
    return np.array([time for time, _ in rows], np.int64), np.array([row for _, row in rows])


def _at_common_times(
    path: Path, times: NDArray[np.int64], hand: Array, others: dict[str, tuple[NDArray[np.int64], Array]]
) -> tuple[NDArray[np.int64], dict[str, Array]]:
    """Every pose at the hand's times: as given where the times are the same, else interpolated."""
    first = max([times[0], *(other[0] for other, _ in others.values())])
    last = min([times[-1], *(other[-1] for other, _ in others.values())])
    kept = (times >= first) & (times <= last)
    if not kept.any():
        raise FileError(path, "has no moment at which the hand and every object have a pose")
    t, poses = times[kept], {HAND: hand[kept]}
    for name, (own, rows) in others.items():
        if np.array_equal(own, times):
            poses[name] = rows[kept]
        elif np.any(np.diff(own) <= 0):
            raise FileError(path, f"gives the times of {name} out of order", "Sort its messages by time.")
        else:
            poses[name] = resample((own - first) / 1e9, align_signs(rows), (t - first) / 1e9)
    return t, poses


def _size(path: Path, name: str, text: str) -> list[float]:
    try:
        x, y, z = map(float, text.split())
    except ValueError:
        raise FileError(
            path, f'gives {name} the size {text!r} in its metadata "{_SIZES}"', "Expected three metres."
        ) from None
    return [x, y, z]
