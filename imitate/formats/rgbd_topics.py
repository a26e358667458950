"""Which topics of a recording are its colour, its depth and their calibrations, and how the two lie."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from itertools import product, takewhile
from pathlib import Path

from imitate.errors import FileError
from imitate.formats.camera_messages import CALIBRATIONS, Calibration
from imitate.formats.kind import PICTURES, listed
from imitate.formats.registration import Lens, Registration
from imitate.geometry import IDENTITY, Array
from imitate.rgbd import Intrinsics

_MADE = "`imitate demonstrate stack -o FILE` makes a recording to compare with."
_LOOKED = {
    "colour": f"Looked for 8-bit pictures in messages of {', '.join(sorted(PICTURES))}. {_MADE}",
    "depth": f"Looked for 16-bit or float pictures in messages of {', '.join(sorted(PICTURES))}. {_MADE}",
}
_NO_CALIBRATION = (
    f"Looked for messages of {' and '.join(sorted(CALIBRATIONS))}. Pass the camera's own numbers with "
    f"--intrinsics FX,FY,CX,CY. {_MADE}"
)
_SAME_LENS = 0.5
"""pixels of focal length and centre within which two calibrations are of one camera."""


@dataclass(frozen=True)
class Seen:
    """The first picture of a topic.

    Attributes:
        frame: of the camera.
        shape: (H, W) pixels.
        bands: 3 of colour, 1 of grey, 0 of depth.
    """

    topic: str
    frame: str
    shape: tuple[int, int]
    bands: int
    compressed: bool

    @property
    def infrared(self) -> bool:
        """Whether it is named like an infrared picture, which may be as deep as a depth."""
        words = self.topic.lower().replace("_", "/").split("/")
        return any(word in ("ir", "ir1", "ir2") or word.startswith("infra") for word in words)


@dataclass(frozen=True)
class Found:
    """First pictures and calibrations by topic.

    Attributes:
        topics: all of the recording: topic → (schema, messages).
        unread: topics whose first message cannot be read, and why.
        notes: what was decided, for the operator to know.
    """

    path: Path
    topics: Mapping[str, tuple[str, int]]
    pictures: dict[str, Seen] = field(default_factory=dict)
    calibrations: dict[str, Calibration] = field(default_factory=dict)
    unread: dict[str, FileError] = field(default_factory=dict)
    notes: list[str] = field(default_factory=list)

    @property
    def has_both(self) -> bool:
        """Whether there are both colour and depth, or pictures that may be."""
        kinds = {seen.bands == 0 for seen in self.pictures.values()}
        return len(kinds) == 2 or any(self.topics[topic][0] in PICTURES for topic in self.unread)

    def chosen(self, colour: str, depth: str) -> tuple[Seen, Seen]:
        """The colour and the depth to use: the topics named, else the pair that fits best.

        Colour goes before grey, distances before infrared, pictures of one camera before others, then what
        there is most of, and what is not compressed.

        Raises:
            FileError: no such topic, or none that can be one of the two.
        """
        colours = self._candidates("colour", colour)
        depths = self._candidates("depth", depth)
        best = max(product(colours, depths), key=self._fitness)
        for kind, one, all_ in (("colour", best[0], colours), ("depth", best[1], depths)):
            others = [other.topic for other in all_ if other is not one]
            if others:
                self.notes.append(
                    f"{kind} is taken from {one.topic}, not from {', '.join(others)} (--{kind}-topic)"
                )
        return best

    def lenses(
        self, colour: Seen, depth: Seen, topic: str, numbers: tuple[float, ...]
    ) -> tuple[Lens, Lens | None]:
        """The lenses of colour and depth; None for a depth that is not said to have its own.

        Args:
            colour, depth: the pictures.
            topic: of the colour camera's calibration, where named.
            numbers: fx, fy, cx, cy and any distortion, instead of any calibration.

        Raises:
            FileError: no such topic, no calibration, or only of other sizes.
        """
        if numbers:
            return lens_of(numbers, colour.shape), None
        if topic and topic not in self.calibrations:
            raise self.unread.get(topic) or self._no_topic("calibration", topic, list(self.calibrations))
        if not self.calibrations:
            raise next(
                iter(error for t, error in self.unread.items() if self.topics[t][0] in CALIBRATIONS),
                FileError(
                    self.path, f"has no calibration of its camera; {listed(self.topics)}", _NO_CALIBRATION
                ),
            )
        own = topic or self._nearest(colour)
        others = {t: c for t, c in self.calibrations.items() if t != own}
        other = self._own_calibration(depth, others)
        return self._lens(own, colour), self._lens(other, depth) if other else None

    def registration(
        self,
        colour: Seen,
        depth: Seen,
        lenses: tuple[Lens, Lens | None],
        told: Array | None,
        given: Array | None,
    ) -> Registration:
        """How the two cameras lie.

        Args:
            colour, depth: the pictures.
            lenses: as `lenses` returns them.
            told: (7,) the depth's frame in the colour's, from the recording's transforms; None where unknown.
            given: likewise, from the operator, who is believed.

        Raises:
            FileError: two cameras and nothing that says how they lie, or a distortion that is not known.
        """
        lens, other = lenses
        self._check_known(lens, colour)
        self._check_known(other or lens, depth)
        if given is not None and (other or colour.shape == depth.shape):
            return Registration(lens, other or lens, given)
        one_frame = colour.frame == depth.frame or not (colour.frame and depth.frame)
        if colour.shape == depth.shape and (other is None or _alike(lens, other)):
            if one_frame or other is None or told is None:
                if not one_frame:
                    self.notes.append(
                        f"{depth.topic} (frame {depth.frame}) is taken as registered to {colour.topic} "
                        f"(frame {colour.frame}): they have one lens (--colour-from-depth)"
                    )
                return Registration(lens, other or lens)
        elif other is None:
            raise FileError(
                self.path,
                f"{colour.topic} is {_size(colour)} and {depth.topic} {_size(depth)}, with a calibration "
                "for the first alone",
                "Record the depth camera's calibration too, or depth registered to colour.",
            )
        if told is None and not one_frame:
            raise FileError(
                self.path,
                f"colour ({colour.topic}, frame {colour.frame}) and depth ({depth.topic}, frame "
                f"{depth.frame}) are of two cameras, and no transform leads from one to the other",
                "Record /tf_static, or pass the depth camera's pose in the colour camera's frame: "
                "--colour-from-depth X,Y,Z,QX,QY,QZ,QW.",
            )
        return Registration(lens, other, IDENTITY if told is None else told)

    def _check_known(self, lens: Lens, seen: Seen) -> None:
        if not lens.known:
            raise FileError(
                self.path,
                f"the lens of {seen.topic} is distorted by a model that is not known: {lens.model!r} with "
                f"{len(lens.coefficients)} coefficients",
                "Record rectified pictures, or pass --intrinsics FX,FY,CX,CY,K1,K2,P1,P2,K3.",
            )

    def _candidates(self, kind: str, topic: str) -> list[Seen]:
        depth = kind == "depth"
        fitting = [seen for seen in self.pictures.values() if (seen.bands == 0) == depth]
        if topic:
            named = [seen for seen in fitting if seen.topic == topic]
            if not named:
                raise self.unread.get(topic) or self._no_topic(kind, topic, [seen.topic for seen in fitting])
            return named
        if not fitting:
            lacking = f"has no {kind} pictures; {listed(self.topics)}"
            raise self._why_unread(PICTURES) or FileError(self.path, lacking, _LOOKED[kind])
        return sorted(fitting, key=lambda seen: seen.topic, reverse=True)

    def _why_unread(self, schemas: frozenset[str]) -> FileError | None:
        return next((error for t, error in self.unread.items() if self.topics[t][0] in schemas), None)

    def _no_topic(self, kind: str, topic: str, valid: list[str]) -> FileError:
        found = f"its {kind} topics are {', '.join(sorted(valid))}" if valid else f"it has none of {kind}"
        return FileError(
            self.path, f"has no {kind} in topic {topic!r}: {found}", f"Name one of them with --{kind}-topic."
        )

    def _fitness(self, pair: tuple[Seen, Seen]) -> tuple[int | bool | str, ...]:
        colour, depth = pair
        return (
            colour.bands,
            not colour.infrared,
            not depth.infrared,
            colour.frame == depth.frame and colour.shape == depth.shape,
            colour.shape == depth.shape,
            min(self.topics[colour.topic][1], self.topics[depth.topic][1]),
            not colour.compressed,
            not depth.compressed,
        )

    def _nearest(self, seen: Seen) -> str:
        """The calibration whose size, frame and name fit a picture best."""

        def fitness(topic: str) -> tuple[bool, bool, int]:
            one = self.calibrations[topic]
            return _fits(one.lens, seen), one.frame == seen.frame, _shared(topic, seen.topic)

        best, *others = sorted(sorted(self.calibrations), key=fitness, reverse=True)
        if equal := [topic for topic in others if fitness(topic) == fitness(best)]:
            self.notes.append(
                f"the calibration is taken from {best}, not from {', '.join(equal)} (--calibration-topic)"
            )
        return best

    def _own_calibration(self, depth: Seen, others: Mapping[str, Calibration]) -> str:
        """The calibration that can only be the depth's: of its size, in its frame or beside it; else ''."""
        fitting = [
            topic
            for topic, one in others.items()
            if _fits(one.lens, depth)
            and ((one.frame == depth.frame and one.frame) or _beside(topic, depth.topic))
        ]
        return max(sorted(fitting), key=lambda topic: _shared(topic, depth.topic), default="")

    def _lens(self, topic: str, seen: Seen) -> Lens:
        one = self.calibrations[topic]
        if not _fits(one.lens, seen):
            i = one.lens.intrinsics
            raise FileError(
                self.path,
                f"{seen.topic} holds pictures of {_size(seen)}, its calibration says {i.width}×{i.height} "
                f"({topic})",
                "Register both pictures to one camera and record that camera's calibration, name another "
                "with --calibration-topic, or pass --intrinsics FX,FY,CX,CY.",
            )
        rectified = "rect" in seen.topic.lower()
        lens = one.rectified if rectified else one.lens
        i = lens.intrinsics
        return Lens(
            Intrinsics(seen.shape[1], seen.shape[0], i.fx, i.fy, i.cx, i.cy), lens.model, lens.coefficients
        )


def lens_of(numbers: tuple[float, ...], shape: tuple[int, int]) -> Lens:
    """fx, fy, cx, cy and any distortion as the lens of pictures of (H, W)."""
    return Lens(Intrinsics(shape[1], shape[0], *numbers[:4]), "plumb_bob", tuple(numbers[4:]))


def _fits(lens: Lens, seen: Seen) -> bool:
    i = lens.intrinsics
    return (i.height, i.width) in (seen.shape, (0, 0))


def _alike(a: Lens, b: Lens) -> bool:
    one, other = a.intrinsics, b.intrinsics
    return all(abs(getattr(one, n) - getattr(other, n)) < _SAME_LENS for n in ("fx", "fy", "cx", "cy")) and (
        a.coefficients == b.coefficients or (a.straight and b.straight)
    )


def _shared(topic: str, other: str) -> int:
    """How many leading parts two topics share."""
    parts = zip(topic.split("/"), other.split("/"), strict=False)
    return sum(1 for _ in takewhile(lambda pair: pair[0] == pair[1], parts))


def _beside(calibration: str, picture: str) -> bool:
    """ROS's convention: …/camera_info lies beside the picture, or beside the name a transport is under."""
    folder = calibration.rsplit("/", 1)[0]
    return bool(folder) and picture.startswith(f"{folder}/")


def _size(seen: Seen) -> str:
    return f"{seen.shape[1]}×{seen.shape[0]}"
