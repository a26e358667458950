"""Films of made-up tasks by seed, and how far an observation is from what was filmed."""

from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from scipy.spatial.transform import Rotation

from imitate.demonstration import HAND
from imitate.formats.recordings import write_recording
from imitate.geometry import angle_between, compose, quaternion_multiply
from imitate.segmentation import segment
from imitate.settings import Perception, Settings
from imitate.world.demonstrator import Film, draw_viewpoint, film, plan_film, visible
from imitate.world.look import draw_look
from imitate.world.sensor import KINECT
from imitate.world.tasks import TASKS, make_up

ALIKE = 0.008
"""m by which a side may be mistaken without the block's sides being confused."""
IN_VIEW = 0.25
"""share of an outline from which a body counts as being in view."""
TOLERANCE = 0.5
"""s between a boundary and the right one, at most."""


def plan(task: str, seed: int, arm: bool = False, rate: float = 20) -> Film:
    """A task from anywhere, in any room, through a Kinect of 640×480; all by the seed."""
    generator = np.random.default_rng([sorted(TASKS).index(task), seed])
    viewpoint, look = draw_viewpoint(generator), replace(draw_look(generator), arm=arm)
    return plan_film(make_up(task, seed), 640, 480, rate, viewpoint, KINECT, look)


def film_to(folder: Path, task: str, seed: int, arm: bool = False) -> Path:
    """The recording of a task, filmed unless it is in the folder already."""
    path = folder / f"{task}-{seed}{'-arm' if arm else ''}.mcap"
    if not path.exists():
        planned = plan(task, seed, arm)
        write_recording(path, planned.camera.intrinsics, film(planned, Perception(), seed))
    return path


@dataclass(frozen=True)
class Errors:
    """Of one body: (F,) metres and degrees in the frames in which it was seen; longest loss in view, s."""

    away: np.ndarray
    turned: np.ndarray
    lost: float


def errors(planned: Film, seen) -> dict[str, Errors]:
    """Of the hand and each object by name; objects that were not found at all are left out."""
    truth, d = planned.performance.demonstration, seen.demonstration
    world_from_table = compose(planned.camera.world_from_camera, seen.camera_from_table)
    found = {}
    for k, name in enumerate((HAND, *truth.object_names)):
        if name not in (HAND, *d.object_names):
            continue
        real, there = truth.pose_of(name), d.seen(name)
        pose = compose(world_from_table, d.pose_of(name)[there])
        away = np.linalg.norm(pose[:, :3] - real[there, :3], axis=1)
        turns = [[0, 0, 0, 1.0]] if name == HAND else same_turns(truth.size_of(name), d.size_of(name))
        turned = min(
            (angle_between(quaternion_multiply(pose[:, 3:], turn), real[there]) for turn in turns),
            key=np.median,
        )
        found[name] = Errors(away, np.rad2deg(turned), _longest_loss(planned, k, there))
    return found


def same_turns(real, measured) -> np.ndarray:
    """(N, 4) the turns from a box's measured axes to its real ones after which its sides agree."""
    group = Rotation.create_group("O")
    off = np.abs(np.abs(np.einsum("nij,j->ni", group.as_matrix(), real)) - measured).max(axis=1)
    return group.as_quat()[off <= max(ALIKE, off.min() + 1e-3)]


def _longest_loss(planned: Film, k: int, there) -> float:
    """Seconds of the longest stretch in which body ``k`` was in view and not seen."""
    missing = np.flatnonzero(~there)
    if not len(missing):
        return 0.0
    in_view = np.zeros(len(there), bool)
    in_view[missing] = visible(planned, Perception(), missing)[:, k] >= IN_VIEW
    longest = run = 0
    for frame in in_view:
        run = run + 1 if frame else 0
        longest = max(longest, run)
    return longest * float(np.median(np.diff(planned.performance.demonstration.t)))


def is_right(planned: Film, demonstration) -> tuple[bool, str]:
    """Whether the robust segmentation of tracks is the right one, and what it is."""
    cut = segment(demonstration, Settings().segmentation)
    words = "; ".join(f"{s.end:.2f} {s.abstraction}" for s in cut)
    right = planned.performance.segments
    same = [s.abstraction for s in cut] == [s.abstraction for s in right]
    near = all(abs(a.end - b.end) <= TOLERANCE for a, b in zip(cut[:-1], right[:-1], strict=False))
    return same and near, words
