"""Demonstration ⇄ MCAP.

Ours holds one topic of foxglove.PoseInFrame for each object, named by the last part of the topic, and one
that ends in "hand"; its times are whole nanoseconds, its sizes the metadata record "object_sizes". A body has
no message where it was not seen; the times at which none was are the record "unseen". The hand's opening is a
topic of its own, a number at each time. Of others' files see
`imitate.formats.tracks`: poses are taken at the hand's times.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from fractions import Fraction
from pathlib import Path
from typing import IO

import numpy as np
from foxglove_schemas_protobuf.PoseInFrame_pb2 import PoseInFrame

from imitate.demonstration import HAND, Demonstration
from imitate.errors import FileError
from imitate.formats.clock import whose_clock
from imitate.formats.curves import curve_channel, curve_message
from imitate.formats.kind import METADATA, POSE_SCHEMAS, listed
from imitate.formats.mapping import LENGTHS, Body, Mapping
from imitate.formats.mcap_contents import contents
from imitate.formats.mcap_file import McapReader
from imitate.formats.mcap_writer import Channel, McapWriter, protobuf_channel
from imitate.formats.opening import OPENING, in_metres
from imitate.formats.pose_times import check_times, taken
from imitate.formats.table import with_offset
from imitate.formats.track import Times, Track, Tracks
from imitate.formats.tracks import NUMBERS, READERS, read_samples
from imitate.geometry import Array

FRAME = "world"
"""the frame that poses are given in, in our own files."""
TOPIC = "/demonstration"
_OPENING = f"{TOPIC}/opening"
_SIZES = "object_sizes"
_UNSEEN = "unseen"
_WORDLESS = {"pose", "pose_stamped", "transform"}


def pose_channels(names: tuple[str, ...]) -> list[Channel]:
    """The topics of a demonstration with these objects: the hand's, then one an object."""
    return [protobuf_channel(_topic(name), PoseInFrame) for name in (HAND, *names)]


def pose_messages(demonstration: Demonstration) -> Iterator[tuple[str, PoseInFrame, int]]:
    """(topic, message, nanoseconds since t = 0 or since the first frame, whichever is earlier).

    A body has none at a frame in which it was not seen.
    """
    bodies = [(_topic(name), demonstration.pose_of(name)) for name in (HAND, *demonstration.object_names)]
    for k, time in enumerate(_nanoseconds(demonstration.t)):
        for topic, poses in bodies:
            pose = poses[k].tolist()
            if pose[0] != pose[0]:  # NaN
                continue
            message = PoseInFrame(frame_id=FRAME)
            message.timestamp.FromNanoseconds(time)
            message.pose.position.x, message.pose.position.y, message.pose.position.z = pose[:3]
            rotation = message.pose.orientation
            rotation.x, rotation.y, rotation.z, rotation.w = pose[3:]
            yield topic, message, time


def write_mcap(demonstration: Demonstration, stream: IO[bytes]) -> None:
    """Writes a demonstration; names must be without "/"."""
    d = demonstration
    sizes = {name: " ".join(map(repr, d.size_of(name).tolist())) for name in d.object_names}
    metadata = {METADATA: {"kind": "demonstration"}, _SIZES: sizes}
    unseen = ~np.any([d.seen(name) for name in (HAND, *d.object_names)], axis=0)
    if unseen.any():
        times = (time for time, missed in zip(_nanoseconds(d.t), unseen, strict=True) if missed)
        metadata[_UNSEEN] = {"times": " ".join(map(str, times))}
    channels = pose_channels(d.object_names)
    channels += [] if d.opening is None else [curve_channel(_OPENING)]
    with McapWriter(stream, channels, metadata) as writer:
        for topic, message, time in pose_messages(d):
            writer.write(topic, message, time)
        for opening, time in zip([] if d.opening is None else d.opening, _nanoseconds(d.t), strict=False):
            writer.write(_OPENING, curve_message(OPENING, [float(opening)]), time)


def read_mcap(path: Path, mapping: Mapping | None, notes: list[str]) -> Demonstration:
    """A demonstration from poses and transforms, the bodies found by name or as the mapping says.

    Args:
        path: the file.
        mapping: what its topics and frames mean, where their names do not say so.
        notes: gets what the person ought to know.

    Raises:
        FileError: damaged, no hand, no object, or poses in frames that nothing relates.
        DemonstrationError: what it holds is no demonstration.
    """
    mapping = mapping or Mapping()
    reader = McapReader(path)
    if isinstance(mapping.opening, list):
        raise FileError(path, "is MCAP, and the mapping names columns for opening", 'Name its topic = "…".')
    samples = read_samples(reader, mapping.opening)
    if reader.damage:
        raise FileError(path, f"is damaged: {reader.damage[0]}", "Record it again.")
    sizes = reader.metadata.get(_SIZES, {})
    own = reader.metadata.get(METADATA, {}).get("kind") == "demonstration"
    tracks = samples.tracks(0, exactly=own)
    bodies = _bodies(tracks, mapping, list(sizes))
    if not own and whose_clock(taken(tracks, bodies), notes):
        tracks = samples.tracks(1)
        bodies = _bodies(tracks, mapping, list(sizes))
    if own:
        times = _own_times(path, bodies.values(), reader.metadata.get(_UNSEEN, {}).get("times", ""))
    else:
        times = tracks.times(bodies[HAND])
        check_times(tracks, bodies, times, notes)
    root = mapping.root or _root(tracks, bodies)
    said = {HAND: mapping.hand, **mapping.objects}
    poses = {}
    for name, track in bodies.items():
        found = _exactly(track, times) if own else tracks.within(track, root, times)
        found[:, :3] *= LENGTHS[mapping.length_unit]
        poses[name] = with_offset(found, said.get(name, Body()))
    hand = poses.pop(HAND)
    given = [said.get(name, Body()).size or _size(path, name, sizes.get(name)) for name in poses]
    return Demonstration(
        t=np.array([time / 10**9 for time in times.tolist()]),
        hand=hand,
        objects=np.stack(list(poses.values()), axis=1),
        object_names=tuple(poses),
        object_sizes=np.array(given),
        opening=_opening(tracks, mapping, times, own, notes),
    )


def _opening(tracks: Tracks, mapping: Mapping, times: Times, own: bool, notes: list[str]) -> Array | None:
    if mapping.opening and mapping.opening not in tracks.numbers:
        raise FileError(
            tracks.path,
            f"has no topic {mapping.opening!r} with numbers (for opening)",
            f"Expected one of {', '.join(sorted({schema for schema, _ in NUMBERS}))}.",
        )
    for topic, track in tracks.numbers.items():
        poses = _exactly(track, times) if own else track.at(times)
        found = poses[:, 0] * LENGTHS[mapping.length_unit]
        if not (own or mapping.opening or in_metres(topic, found)):
            continue
        if not own and np.isnan(found).all():
            notes.append(f"the opening in {topic} is of no time at which the hand was seen, and is left out")
            continue
        if others := [other for other in tracks.numbers if other != topic]:
            notes.append(
                f"the opening is taken from {topic}, not from {', '.join(others)} (opening in a mapping)"
            )
        if track.logged:
            notes.append(
                f"the opening in {topic} has no stamps of the poses' clock: it is placed by the log's times"
            )
        return np.asarray(found)
    return None


def _topic(name: str) -> str:
    return f"{TOPIC}/hand" if name == HAND else f"{TOPIC}/objects/{name}"


def _nanoseconds(t: Array) -> list[int]:
    origin = min(Fraction(float(t[0])), Fraction(0))
    return [round((Fraction(time) - origin) * 10**9) for time in t.tolist()]


def _own_times(path: Path, tracks: Iterable[Track], unseen: str) -> Times:
    try:
        empty = np.array(unseen.split(), np.int64)
    except ValueError:
        raise FileError(
            path, f'gives no times in its metadata "{_UNSEEN}"', "Expected nanoseconds."
        ) from None
    return np.unique(np.concatenate([*(track.times for track in tracks), empty]))


def _exactly(track: Track, times: Times) -> Array:
    poses = np.full((len(times), 7), np.nan)
    poses[np.searchsorted(times, track.times)] = track.poses
    return poses


def _root(tracks: Tracks, bodies: dict[str, Track]) -> str:
    frames = {track.frame for track in bodies.values()}
    return frames.pop() if len(frames) == 1 else tracks.top(bodies[HAND])


def _bodies(tracks: Tracks, mapping: Mapping, order: list[str]) -> dict[str, Track]:
    """Name → track, the hand first, then objects in the ``order`` that the file gives or as they appear."""
    topics, frames = _named(list(tracks.topics)), {name.rsplit("/", 1)[-1]: name for name in tracks.frames}
    known = {name: tracks.topics[topic] for name, topic in topics.items()} if topics else {}
    if not known or (HAND not in known and HAND in frames):
        known |= {name: tracks.frames[frame] for name, frame in frames.items() if name not in known}
    known = {name: known[name] for name in sorted(known, key=[*order, *known].index)}
    wanted = {HAND: mapping.hand, **(mapping.objects or {name: Body() for name in known if name != HAND})}
    found = {name: _body(tracks, name, body, known) for name, body in wanted.items()}
    if len(found) < 2:
        raise _unrecognised(tracks, "no pose of an object")
    return found


def _body(tracks: Tracks, name: str, body: Body, known: dict[str, Track]) -> Track:
    if body.pose or body.position:
        problem = f"is MCAP, and the mapping names columns for {name}"
        raise FileError(tracks.path, problem, 'Name its topic = "…" or its frame = "…".')
    for kind, wanted, held in (("topic", body.topic, tracks.topics), ("frame", body.frame, tracks.frames)):
        if wanted:
            key = wanted.strip("/") if kind == "frame" else wanted
            if key not in held:
                has = ", ".join(held) or "none"
                raise FileError(
                    tracks.path, f"has no {kind} {wanted!r} with poses (for {name}); it has {has}"
                )
            return held[key]
    if name not in known:
        raise _unrecognised(tracks, f"no pose of the {name}" if name == HAND else f"no pose of {name}")
    return known[name]


def _named(topics: list[str]) -> dict[str, str]:
    """Name → topic: its last part, or the one before where the last only says that it is a pose.

    Topics that would have one name are named in full.
    """
    parts = {topic: [part for part in topic.split("/") if part] for topic in topics}
    names = {
        topic: ([p for p in known if p.lower() not in _WORDLESS] or known)[-1]
        for topic, known in parts.items()
    }
    alike = {name for name in names.values() if list(names.values()).count(name) > 1}
    return {topic.strip("/") if name in alike else name: topic for topic, name in names.items()}


def _unrecognised(tracks: Tracks, lacking: str) -> FileError:
    from imitate.formats.suggestion import suggested_topics

    found = {(m.schema_name, m.encoding) for m in McapReader(tracks.path).messages()}
    if unread := sorted({form for schema, form in found - READERS.keys() if schema in POSE_SCHEMAS}):
        problem = f"has poses encoded as {', '.join(unread)}, which are not read"
        remedy = "Write Foxglove's messages in protobuf or json, or ROS 2's in cdr."
        return FileError(tracks.path, f"{problem}; {listed(contents(tracks.path).topics)}", remedy)
    return FileError(
        tracks.path,
        f"has {lacking}; {listed(contents(tracks.path).topics)}",
        f'A demonstration has a topic of {POSE_SCHEMAS[0]} that ends in "/hand" and one for each object, or '
        "a mapping that says which topics or frames they are (--mapping FILE.toml). One to start from:\n\n"
        + suggested_topics(list(tracks.topics), list(tracks.frames)),
    )


def _size(path: Path, name: str, text: str | None) -> list[float]:
    if text is None:
        return [np.nan] * 3
    try:
        x, y, z = map(float, text.split())
    except ValueError:
        raise FileError(
            path, f'gives {name} the size {text!r} in its metadata "{_SIZES}"', "Expected three metres."
        ) from None
    return [x, y, z]
