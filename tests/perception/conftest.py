"""A short recording by the virtual camera, with what was really there."""

from dataclasses import dataclass
from pathlib import Path

import pytest

from imitate.formats.recordings import write_recording
from imitate.geometry import Array
from imitate.perception.observe import Observation, observe
from imitate.settings import Perception
from imitate.world.demonstrator import film, plan_film
from imitate.world.performance import Performance, perform


@dataclass(frozen=True)
class Filmed:
    """A recording's path, the performance at its frames' times, and the camera's pose in its frame."""

    path: Path
    truth: Performance
    world_from_camera: Array


@pytest.fixture(scope="session")
def filmed(short_demonstration, tmp_path_factory) -> Filmed:
    """The grasp, the carry, the release and the retreat at 320×240 and 8 frames per second."""
    path = tmp_path_factory.mktemp("filmed") / "short.mcap"
    plan = plan_film(perform(short_demonstration), 320, 240, 8)
    write_recording(path, plan.camera.intrinsics, film(plan, Perception(), seed=5))
    return Filmed(path, plan.performance, plan.camera.world_from_camera)


@pytest.fixture(scope="session")
def observed(filmed) -> Observation:
    return observe(filmed.path, seed=3)
