"""The person's carry as a file, its scene in physics, and sessions from it that take seconds."""

from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import pytest
import scripted

from imitate.demonstration import Demonstration
from imitate.events import SessionStarted
from imitate.formats.demonstrations import write_demonstration
from imitate.learning.trials import Skip, nothing_is_skipped
from imitate.session.session import Request, run
from imitate.session.versions import versions
from imitate.settings import Settings, load_settings, to_toml
from imitate.world.scene import World, scene_of
from imitate.world.trial import Simulator

FEW = {"evaluation_starts": 1, "reproduction_starts": 1, "candidates": 1, "candidate_starts": 1}


@pytest.fixture(scope="session")
def source(short_demonstration, tmp_path_factory):
    """The carry, its start cut to where the hand already surrounds the block."""
    path = tmp_path_factory.mktemp("source") / "carry.npz"
    write_demonstration(short_demonstration, path)
    return path


@pytest.fixture(scope="session")
def started(short_demonstration: Demonstration) -> SessionStarted:
    """The first event of a session of the carry."""
    settings = Settings()
    return replace(
        scripted.started(),
        settings=to_toml(settings),
        versions=versions(),
        demonstration=short_demonstration,
        scene=scene_of(short_demonstration, settings.world),
    )


@pytest.fixture(scope="session")
def simulator(started: SessionStarted) -> Iterator[Simulator]:
    simulator = Simulator(World(started.scene, Settings().world), Settings())
    yield simulator
    simulator.close()


@pytest.fixture(scope="session")
def easy(short_demonstration: Demonstration, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A session of the hand's way alone, everything near enough: four trials, and reproduced."""
    folder = tmp_path_factory.mktemp("easy")
    d = short_demonstration
    write_demonstration(replace(d, objects=d.objects[:1].repeat(len(d.t), axis=0)), folder / "way.npz")
    settings = load_settings(None, {"learning": FEW | {"near": 1.0, "near_angle": 180.0}})
    return _session(folder / "way.npz", settings, folder / "easy.mcap")


@pytest.fixture(scope="session")
def hard(source: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A session in which nothing succeeds: eight trials, stated anew, and given up."""
    short = {"first_rollouts": 3, "updates": 1, "more_updates": 0}
    settings = load_settings(None, {"learning": FEW | short})
    return _session(source, settings, tmp_path_factory.mktemp("hard") / "hard.mcap")


@pytest.fixture(scope="session")
def skipped(source: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """One in which the operator skips the first formulation; without that it is given up all the same."""
    short = {"first_rollouts": 3, "updates": 2, "more_updates": 0, "formulations": 2}
    settings = load_settings(None, {"learning": FEW | short})
    log = tmp_path_factory.mktemp("skipped") / "skipped.mcap"
    return _session(source, settings, log, lambda _, formulation: formulation == 0)


def _session(source: Path, settings: Settings, log: Path, skip: Skip = nothing_is_skipped) -> Path:
    for _ in run(Request(source, settings, 3, workers=0, log=log), skip=skip):
        pass
    return log
