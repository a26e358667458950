"""An RGB-D recording in MCAP, with Foxglove's or ROS 2's messages: its frames."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path

from imitate.errors import FileError
from imitate.formats.camera_messages import CALIBRATIONS, TRANSFORMS, CameraReader, Picture
from imitate.formats.clock import whose_clock
from imitate.formats.frames import MILLIMETRE, Pairs, Streams, damaged, undecodable
from imitate.formats.kind import METADATA, PICTURES
from imitate.formats.mcap_contents import Contents, contents
from imitate.formats.mcap_file import McapReader, RawMessage
from imitate.formats.pairing import COLOUR, DEPTH, Stamped, Tally
from imitate.formats.picture_times import peeked
from imitate.formats.pictures import is_depth
from imitate.formats.rgbd_clouds import CloudRecording, open_clouds
from imitate.formats.rgbd_topics import Found, Seen
from imitate.formats.transforms import FrameTree
from imitate.geometry import Array, normalised
from imitate.rgbd import Intrinsics, RgbdFrame
from imitate.settings import Perception


@dataclass
class McapRecording:
    """A recording in MCAP, opened.

    Attributes:
        colour, depth: topics.
        notes: what the operator ought to know, in words; more may come while the frames are read.
        tally: what became of the pictures when they were last read.
    """

    path: Path
    colour: str
    depth: str
    count: int
    streams: Streams
    salvage: bool
    notes: list[str] = field(default_factory=list)
    tally: Tally = field(default_factory=Tally)

    @property
    def left_out(self) -> float:
        """Share of the frames that could be that are not, once they are read."""
        return self.tally.left_out

    @property
    def intrinsics(self) -> Intrinsics:
        """Of every frame."""
        return self.streams.registration.intrinsics

    def frames(self) -> Iterator[RgbdFrame]:
        """Every frame in order, read as it is asked for; t in seconds from the first.

        Raises:
            FileError: as `survey`, or as `Streams.frames`.
        """
        return self.streams.frames(self._pairs())

    def survey(self) -> None:
        """Goes through the stamps alone; ``notes`` and ``left_out`` are known then.

        Raises:
            FileError: as `Streams.pairs`; or damage that shows only now, unless it is to be salvaged.
        """
        for _ in self._pairs():
            pass

    def _pairs(self) -> Pairs:
        self.tally = Tally()
        # each topic by a reader of its own, which costs 1.4 ms a frame and serves files written by topic
        readers = (McapReader(self.path), McapReader(self.path))
        topics, camera = (self.colour, self.depth), CameraReader(self.path)
        read = (
            ((camera.picture(message), message.time) for message in reader.messages({topic}))
            for reader, topic in zip(readers, topics, strict=True)
        )
        (first, colours), (other, depths) = map(peeked, read)
        firsts = [[(picture.time, logged) for picture, logged in one] for one in (first, other)]
        clock = whose_clock(dict(zip(topics, firsts, strict=True)), self.notes)
        streams = _stamped(COLOUR, colours, clock), _stamped(DEPTH, depths, clock)
        yield from self.streams.pairs(*streams, self.tally, self.notes)
        if (damage := readers[0].damage + readers[1].damage) and not self.salvage:
            raise damaged(self.path, damage[0])


def _stamped(kind: int, pictures: Iterator[tuple[Picture, int]], clock: int) -> Iterator[Stamped[Picture]]:
    return (Stamped(kind, (picture.time, logged)[clock], picture) for picture, logged in pictures)


def open_mcap(path: Path, settings: Perception) -> McapRecording | CloudRecording:
    """What a recording holds, from the first messages of its topics: pictures, else clouds in their place.

    Raises:
        FileError: no such file, no MCAP, damaged, or without colour, depth or calibration.
    """
    inside = contents(path)
    if inside.damage and not settings.salvage:
        raise damaged(path, inside.damage[0])
    if inside.metadata.get(METADATA, {}).get("kind") == "session":
        raise FileError(path, "is a session, not a recording", f"To run it again: imitate replay {path}")
    found = _first_messages(path, inside)
    if not found.has_both and (clouds := open_clouds(path, inside, found.calibrations, settings)):
        return clouds
    colour, depth = found.chosen(settings.colour_topic, settings.depth_topic)
    lenses = found.lenses(colour, depth, settings.calibration_topic, settings.intrinsics)
    given = normalised(settings.colour_from_depth) if settings.colour_from_depth else None
    apart = given is None and colour.frame != depth.frame
    told = _frame_tree(path, inside, colour.frame, depth.frame) if apart else None
    registration = found.registration(colour, depth, lenses, told, given)
    count = min(inside.topics[colour.topic][1], inside.topics[depth.topic][1])
    unit = settings.depth_unit
    streams = Streams(
        path,
        colour.topic,
        depth.topic,
        registration,
        unit=unit or MILLIMETRE,
        float_unit=unit or 1.0,
        unit_given=bool(unit),
        within=settings.pair_within,
    )
    notes = found.notes + [f"damaged ({words}); used as far as it can be read" for words in inside.damage]
    return McapRecording(path, colour.topic, depth.topic, count, streams, settings.salvage, notes)


def _first_messages(path: Path, inside: Contents) -> Found:
    """The first picture or calibration of each topic; an unreadable one matters only if it is needed."""
    camera = CameraReader(path)
    found = Found(path, inside.topics)
    kinds = PICTURES | CALIBRATIONS
    waiting = {topic for topic, (schema, count) in inside.topics.items() if count and schema in kinds}
    for message in McapReader(path).messages(set(waiting)) if waiting else ():
        if message.topic in waiting:
            waiting.discard(message.topic)
            try:
                if message.schema_name in CALIBRATIONS:
                    found.calibrations[message.topic] = camera.calibration(message)
                else:
                    found.pictures[message.topic] = _seen(path, message, camera.picture(message))
            except FileError as error:
                found.unread[message.topic] = error
        if not waiting:
            break
    return found


def _seen(path: Path, message: RawMessage, picture: Picture) -> Seen:
    pixels = picture.decode()
    if pixels is None:
        raise undecodable(path, message.topic, picture, "a picture")
    bands = 0 if is_depth(pixels) else 3 if pixels.ndim == 3 else 1
    compressed = message.schema_name.endswith("CompressedImage")
    return Seen(message.topic, picture.frame, (pixels.shape[0], pixels.shape[1]), bands, compressed)


def _frame_tree(path: Path, inside: Contents, colour: str, depth: str) -> Array | None:
    """(7,) the depth camera's frame in the colour camera's, from whatever transforms lead there first."""
    topics = {topic for topic, (schema, count) in inside.topics.items() if count and schema in TRANSFORMS}
    camera, tree = CameraReader(path), FrameTree()
    for message in McapReader(path).messages(topics) if topics else ():
        for one in camera.transforms(message):
            tree.add(one.parent, one.child, one.pose)
        if (found := tree.between(colour, depth)) is not None:
            return found
    return None
