"""`imitate demonstrate`: film a task in front of the virtual camera."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from imitate.cli import console

if TYPE_CHECKING:
    import numpy as np

    from imitate.settings import Perception
    from imitate.world.demonstrator import Film, Viewpoint
    from imitate.world.look import Look
    from imitate.world.performance import Performance
    from imitate.world.sensor import Sensor

TASKS = ("stack", "box", "push", "unstack", "three", "person")
PERSON = "human_stack.npz"
"""the real motion that the task `person` performs, in fixtures/."""


def demonstrate(
    task: Annotated[str, typer.Argument(metavar="TASK", help=f"What to perform: {', '.join(TASKS)}.")],
    output: Annotated[Path, typer.Option("-o", "--output", metavar="FILE.mcap", help="The recording.")],
    demonstration: Annotated[
        Path | None,
        typer.Option("--demonstration", metavar="FILE", help="Perform this motion instead of the task's."),
    ] = None,
    size: Annotated[str, typer.Option("--size", metavar="WxH", help="Pixels.")] = "640x480",
    rate: Annotated[float, typer.Option("--rate", min=1, max=120, help="Frames per second.")] = 30,
    viewpoint: Annotated[
        str,
        typer.Option(
            "--viewpoint",
            metavar="front|any|A,E,D[,R]",
            help="Where the camera stands: in front, anywhere by the seed, or azimuth, elevation (degrees), "
            "distance (m) and roll (degrees).",
        ),
    ] = "front",
    sensor: Annotated[
        str,
        typer.Option("--sensor", metavar="kinect|axial", help="A Kinect, or its axial noise alone."),
    ] = "kinect",
    room: Annotated[
        str,
        typer.Option("--room", metavar="plain|any", help="Bare, or lamps, wood and wall by the seed."),
    ] = "plain",
    arm: Annotated[
        bool, typer.Option("--arm", help="A bare hand and a sleeve go with the two coloured fingers.")
    ] = False,
    truth: Annotated[
        Path | None,
        typer.Option(
            "--truth",
            metavar="FILE",
            help="Write the true poses here; of a made-up task the true skills to FILE.json.",
        ),
    ] = None,
    settings: console.SettingsFile = None,
    seed: console.Seed = 0,
    force: console.Force = False,
) -> None:
    """Film a task in front of the virtual camera.

    A virtual hand makes up a motion by the seed, or performs a real person's (task "person"); the RGB-D
    camera is as noisy as a Kinect.
    """
    from imitate.errors import UnknownNameError
    from imitate.formats.output import refuse_existing, require_mcap
    from imitate.settings import load_settings

    if task not in TASKS:
        raise UnknownNameError("task", task, TASKS)
    width, height = _pixels(size)
    require_mcap(output)
    for path in (output, *((truth, truth.with_suffix(".json")) if truth else ())):
        refuse_existing(path, force)
    hand = load_settings(settings).perception
    shown = _performance(task, demonstration, seed)

    import numpy as np

    from imitate.world.demonstrator import plan_film

    generator = np.random.default_rng(seed)
    place, look = _viewpoint(viewpoint, generator), _look(room, arm, generator)
    plan = plan_film(shown, width, height, rate, place, _sensor(sensor), look)
    if truth:
        _write_truth(truth, plan, shown, force)
    _film(plan, hand, seed, task, output, force)


def _film(plan: Film, hand: Perception, seed: int, task: str, output: Path, force: bool) -> None:
    from imitate.formats.recordings import write_recording
    from imitate.world.demonstrator import film

    frames, of = len(plan.performance.demonstration.t), plan.camera.intrinsics
    with console.progress() as bar:
        filmed = bar.track(film(plan, hand, seed), total=frames, description=f"filming {task}")
        write_recording(output, of, filmed, force)
    megabytes = output.stat().st_size / 1e6
    console.narrate(f"{output}: {frames} frames of {of.width}×{of.height}, {megabytes:.1f} MB")


def _performance(task: str, demonstration: Path | None, seed: int) -> Performance:
    from imitate.formats.demonstrations import read_demonstration
    from imitate.world.performance import perform

    if demonstration or task == "person":
        file, notes = demonstration or _fixture(PERSON), list[str]()
        shown = read_demonstration(file, None, notes)
        for note in notes:
            console.narrate(f"{file}: {note}")
        return perform(shown)

    from imitate.world.tasks import make_up

    return make_up(task, seed)


def _viewpoint(text: str, generator: np.random.Generator) -> Viewpoint:
    from imitate.errors import UsageError
    from imitate.world.demonstrator import FRONT, Viewpoint, draw_viewpoint

    if text in ("front", "any"):
        return FRONT if text == "front" else draw_viewpoint(generator)
    try:
        numbers = [float(part) for part in text.split(",")]
    except ValueError:
        numbers = []
    if len(numbers) in (3, 4) and 5 <= numbers[1] <= 85 and 0.4 <= numbers[2] <= 3:
        return Viewpoint(*numbers)
    raise UsageError(
        f"--viewpoint {text!r}: expected front, any, or azimuth,elevation,distance[,roll] with an elevation "
        "of 5 to 85 degrees and a distance of 0.4 to 3 m, as in 20,45,0.9."
    )


def _look(room: str, arm: bool, generator: np.random.Generator) -> Look:
    from imitate.errors import UnknownNameError
    from imitate.world.look import Look, draw_look

    if room not in ("plain", "any"):
        raise UnknownNameError("room", room, ("plain", "any"))
    return replace(draw_look(generator) if room == "any" else Look(), arm=arm)


def _sensor(name: str) -> Sensor:
    from imitate.errors import UnknownNameError
    from imitate.world.sensor import SENSORS

    if name not in SENSORS:
        raise UnknownNameError("sensor", name, SENSORS)
    return SENSORS[name]


def _write_truth(path: Path, plan: Film, shown: Performance, force: bool) -> None:
    # The true poses, and the right segmentation as `imitate segment --json` prints one.
    from imitate.formats.demonstrations import write_demonstration
    from imitate.formats.output import new_file

    write_demonstration(plan.performance.demonstration, path, force)
    skills = [
        {
            "start": s.start,
            "end": s.end,
            "relevant": list(s.abstraction.relevant),
            "reference": s.abstraction.reference,
        }
        for s in shown.segments
    ]
    if skills:
        with new_file(path.with_suffix(".json"), force) as temporary:
            temporary.write_text(json.dumps({"segments": skills}, indent=1) + "\n", encoding="utf-8")


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
