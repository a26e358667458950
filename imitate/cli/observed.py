"""What `imitate observe` gives: files, and on stdout a table for people or JSON for machines."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from imitate.cli import console

if TYPE_CHECKING:
    from rich.progress import Progress

    from imitate.formats.recordings import Recording
    from imitate.perception.first_view import FirstView, SeenObject
    from imitate.perception.observe import Observation
    from imitate.rgbd import PointCloud
    from imitate.settings import Perception


@dataclass(frozen=True)
class Outputs:
    """The files that were asked for, each None where not.

    Attributes:
        demonstration: .npz or .mcap.
        labels: .npy, (N,) int32 in input order.
        preview: a picture, or .mp4.
    """

    demonstration: Path | None
    labels: Path | None
    preview: Path | None
    force: bool

    def check(self) -> None:
        """Before the work begins: raises FileError for what could not be written after it."""
        from imitate.errors import FileError
        from imitate.formats.output import refuse_existing

        for path, suffixes in ((self.labels, (".npy",)), (self.preview, (".png", ".jpg", ".mp4"))):
            if path is not None and path.suffix not in suffixes:
                problem = f"cannot be written: unknown suffix {path.suffix!r}"
                raise FileError(path, problem, f"Use {' or '.join(suffixes)}.")
        for path in (self.demonstration, self.labels, self.preview):
            if path is not None:
                refuse_existing(path, self.force)

    def write_demonstration(self, seen: Observation) -> None:
        """The demonstration."""
        from imitate.formats.demonstrations import write_demonstration

        if self.demonstration is not None:
            write_demonstration(seen.demonstration, self.demonstration, self.force)

    def write_labels(self, first: FirstView) -> None:
        """The label of each point of the first view."""
        import numpy as np

        from imitate.formats.output import new_file

        if self.labels is not None:
            with new_file(self.labels, self.force) as temporary, temporary.open("wb") as stream:
                np.save(stream, first.labels)

    def preview_recording(
        self, recording: Recording, seen: Observation, settings: Perception, bar: Progress
    ) -> None:
        """The first frame with the tracks over it, or a film of all frames, read a second time."""
        import numpy as np

        from imitate.perception import preview

        if self.preview is None:
            return
        frames = recording.frames()
        if self.preview.suffix != ".mp4":
            image = preview.draw_tracks(next(frames), recording.intrinsics, seen, settings)
            preview.write_picture(self.preview, image, self.force)
            return
        t = seen.demonstration.t
        drawn = (
            preview.draw_frame(frame, recording.intrinsics, seen, k, settings)
            for k, frame in enumerate(bar.track(frames, len(t), description=f"drawing {self.preview.name}"))
        )
        preview.write_film(self.preview, drawn, 1 / float(np.median(np.diff(t))), self.force)

    def preview_cloud(self, path: Path, cloud: PointCloud, first: FirstView) -> None:
        """The cloud's picture with what was found in it."""
        from imitate.errors import FileError
        from imitate.formats.organised import fitted_intrinsics
        from imitate.perception import preview

        if self.preview is None:
            return
        camera = fitted_intrinsics(cloud.points.reshape(*cloud.shape, 3)) if cloud.shape else None
        if camera is None or self.preview.suffix == ".mp4":
            problem = "is one moment" if camera else "has its points in no picture's order"
            remedy = "Give a .png." if camera else "Leave out --preview; --labels has what belongs to what."
            raise FileError(path, f"{problem}, so that {self.preview.name} cannot be drawn", remedy)
        picture = preview.picture_of_cloud(cloud)
        preview.write_picture(self.preview, preview.draw_first_view(picture, camera, first), self.force)


def report_cloud(cloud: PointCloud, first: FirstView, as_json: bool) -> None:
    """What a single cloud shows."""
    if as_json:
        console.write_json(_view(first) | {"cloud_from_camera": cloud.cloud_from_camera.tolist()})
    else:
        _show_view(first)
    _warn(first)


def report_recording(seen: Observation, as_json: bool) -> None:
    """What a recording shows: its first view, and how the tracks went."""
    d = seen.demonstration
    if as_json:
        found = _view(seen.first)
        confidence = dict(zip(("hand", *d.object_names), seen.confidence.mean(axis=0).tolist(), strict=True))
        found |= {"frames": len(d.t), "seconds": d.duration, "confidence": confidence, "lost": seen.lost}
        console.write_json(found)
    else:
        console.write(f"{len(d.t)} frames, {d.duration:.1f} s")
        _show_view(seen.first)
    _warn(seen.first)
    for name, frames in seen.lost_frames.items():
        spans = ", ".join(f"{start:.1f}–{end:.1f}" for start, end in seen.lost[name])
        console.narrate(f"{name}: not seen in {frames} of {len(d.t)} frames, at {spans} s")


def _view(first: FirstView) -> dict[str, Any]:
    return {
        "table": {
            "plane": first.table.plane.tolist(),
            "inliers": first.table.inliers,
            "table_from_camera": first.table.table_from_camera.tolist(),
            "doubt": first.table.doubt,
        },
        "objects": [_thing(first, thing) for thing in first.objects],
        "frames_of": {"plane": "camera", "pose": "camera", "pose_in_table": "table"},
    }


def _thing(first: FirstView, thing: SeenObject) -> dict[str, Any]:
    from imitate.geometry import compose, inverse

    camera_from_table = inverse(first.table.table_from_camera)
    return {
        "name": thing.name,
        "points": thing.points,
        "size": _numbers(thing.block.size),
        "size_std": _numbers(thing.size_std),
        "pose": _numbers(compose(camera_from_table, thing.block.pose)),
        "pose_in_table": _numbers(thing.block.pose),
        "uncertain": thing.uncertain,
        "reason": thing.reason,
    }


def _numbers(values: Any) -> list[float | None]:
    return [value if abs(value) < float("inf") else None for value in values.tolist()]


def _show_view(first: FirstView) -> None:
    a, b, c, d = first.table.plane
    console.write(
        f"table: {a:+.4f} x {b:+.4f} y {c:+.4f} z {d:+.4f} m = 0 for the camera, "
        f"{first.table.inliers:,} points on it"
    )
    right = ("points", "size mm", "± mm", "x", "y", "z mm", "turn °")
    table = console.table("object", *right, "", right=right)
    for thing in first.objects:
        size, std = (
            " × ".join(f"{1000 * side:.{digits}f}" for side in sides)
            for sides, digits in ((thing.block.size, 0), (thing.size_std, 1))
        )
        x, y, z = (f"{1000 * value:.0f}" for value in thing.block.pose[:3])
        turn = f"{_yaw(thing.block.pose):.0f}"
        doubt = "uncertain" if thing.uncertain else ""
        table.add_row(thing.name, f"{thing.points:,}", size, std, x, y, z, turn, doubt)
    if first.objects:
        console.show(table)
    else:
        console.write("nothing stands on it")


def _yaw(pose: Any) -> float:
    """Degrees about the table's normal."""
    from math import atan2, degrees

    x, y, z, w = pose[3:].tolist()
    return degrees(atan2(2 * (w * z + x * y), 1 - 2 * (y * y + z * z)))


def _warn(first: FirstView) -> None:
    for doubt in first.doubts:
        console.narrate(doubt)
