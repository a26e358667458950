"""`imitate demonstrate`: film a task in front of the virtual camera."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from imitate.cli import console

TASKS = {"stack": "human_stack.npz"}
"""task → the real human motion that it performs, in fixtures/."""


def demonstrate(
    task: Annotated[str, typer.Argument(metavar="TASK", help=f"What to perform: {', '.join(TASKS)}.")],
    output: Annotated[Path, typer.Option("-o", "--output", metavar="FILE.mcap", help="The recording.")],
    demonstration: Annotated[
        Path | None,
        typer.Option("--demonstration", metavar="FILE", help="Perform this instead of the task's fixture."),
    ] = None,
    size: Annotated[str, typer.Option("--size", metavar="WxH", help="Pixels.")] = "640x480",
    rate: Annotated[float, typer.Option("--rate", min=1, max=120, help="Frames per second.")] = 30,
    settings: console.SettingsFile = None,
    seed: console.Seed = 0,
    force: console.Force = False,
) -> None:
    """Film a task in front of the virtual camera.

    A virtual hand performs a person's motion; the RGB-D camera has a Kinect's noise.
    """
    from imitate.errors import UnknownNameError
    from imitate.formats.demonstrations import read_demonstration
    from imitate.formats.output import refuse_existing, require_mcap
    from imitate.formats.recordings import write_recording
    from imitate.settings import load_settings

    if task not in TASKS:
        raise UnknownNameError("task", task, TASKS)
    width, height = _pixels(size)
    require_mcap(output)
    refuse_existing(output, force)
    hand = load_settings(settings).perception
    shown = read_demonstration(demonstration or _fixture(TASKS[task]))

    from imitate.world.demonstrator import film, plan_film
    from imitate.world.performance import perform

    plan = plan_film(perform(shown), width, height, rate)
    frames = len(plan.performance.demonstration.t)
    with console.progress() as bar:
        filmed = bar.track(film(plan, hand, seed), total=frames, description=f"filming {task}")
        write_recording(output, plan.camera.intrinsics, filmed, force)
    megabytes = output.stat().st_size / 1e6
    console.narrate(f"{output}: {frames} frames of {width}×{height}, {megabytes:.1f} MB")


def _pixels(size: str) -> tuple[int, int]:
    from imitate.errors import UsageError

    width, _, height = size.lower().replace("×", "x").partition("x")
    if not (width.isdigit() and height.isdigit() and 64 <= int(width) <= 1920 and 48 <= int(height) <= 1440):
        raise UsageError(f"--size {size!r}: expected WIDTHxHEIGHT from 64x48 to 1920x1440, as in 640x480.")
    return int(width), int(height)


def _fixture(name: str) -> Path:
    """A file of fixtures/, in the working folder or in the clone that the package runs from."""
    from imitate.errors import FileError

    places = [Path("fixtures"), Path(__file__).parents[2] / "fixtures"]
    for place in places:
        if (place / name).exists():
            return place / name
    raise FileError(
        places[0] / name,
        "no such file, here or beside the package",
        "Run this in a clone of the project, or name a demonstration with --demonstration.",
    )
