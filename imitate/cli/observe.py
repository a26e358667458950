"""`imitate observe`: an RGB-D recording to the poses of hand and objects, or what a single cloud shows."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from imitate.cli import console, observed

if TYPE_CHECKING:
    from imitate.settings import Settings

Text = str | None


def observe(
    recording: Annotated[
        Path,
        typer.Argument(
            metavar="RECORDING",
            help="An RGB-D recording (MCAP, or a folder with rgb.txt and depth.txt), or a cloud (PCD, PLY).",
        ),
    ],
    output: Annotated[
        Path | None,
        typer.Option("-o", "--output", metavar="FILE", help="The demonstration, as .npz or .mcap."),
    ] = None,
    labels: Annotated[
        Path | None,
        typer.Option(
            metavar="FILE.npy",
            help="For each point of the first view, in input order (pixels row by row): -1 none, 0 table, "
            "1 the first object, and so on.",
        ),
    ] = None,
    preview: Annotated[
        Path | None,
        typer.Option(
            metavar="FILE.png|.mp4", help="What was found, drawn over the first picture or over all."
        ),
    ] = None,
    left_finger: Annotated[
        Text,
        typer.Option(metavar="COLOUR", help="A hue's name, #rrggbb, or U,V: a pixel of the first picture."),
    ] = None,
    right_finger: Annotated[Text, typer.Option(metavar="COLOUR", help="Likewise.")] = None,
    colour_topic: Annotated[
        Text, typer.Option(metavar="TOPIC", help="By default found by its content.")
    ] = None,
    depth_topic: Annotated[Text, typer.Option(metavar="TOPIC", help="Likewise.")] = None,
    calibration_topic: Annotated[
        Text, typer.Option(metavar="TOPIC", help="Of the colour camera; by default the nearest by name.")
    ] = None,
    intrinsics: Annotated[
        Text, typer.Option(metavar="FX,FY,CX,CY", help="In pixels; K1,K2,P1,P2,K3 may follow.")
    ] = None,
    depth_unit: Annotated[
        float | None,
        typer.Option(metavar="METRES", help="One step of the depth, or of a cloud: 0.001 for mm."),
    ] = None,
    sensor: Annotated[
        Text,
        typer.Option(
            metavar="FRAME",
            help="Of a cloud, where it is not found: optical, graphics, body, viewpoint, or "
            "X,Y,Z,QX,QY,QZ,QW, the camera's pose in it.",
        ),
    ] = None,
    colour_from_depth: Annotated[
        Text,
        typer.Option(
            metavar="X,Y,Z,QX,QY,QZ,QW", help="The depth camera's pose in the colour camera's frame."
        ),
    ] = None,
    pair_within: Annotated[
        float | None, typer.Option(metavar="SECONDS", help="The most between a frame's colour and its depth.")
    ] = None,
    salvage: Annotated[bool, typer.Option(help="Use a damaged recording as far as it can be read.")] = False,
    settings_file: console.SettingsFile = None,
    seed: console.Seed = 0,
    as_json: console.Json = False,
    force: console.Force = False,
) -> None:
    """Find table and objects in the first view, and follow hand and objects through the recording.

    Exit code 3 says that something was out of sight for a while, and its poses there are missing; or that
    more than a tenth of the frames are.
    """
    from imitate.formats.kind import kind_of
    from imitate.settings import load_settings

    given = {
        "left_finger": left_finger,
        "right_finger": right_finger,
        "colour_topic": colour_topic,
        "depth_topic": depth_topic,
        "calibration_topic": calibration_topic,
        "intrinsics": _numbers("--intrinsics", intrinsics),
        "depth_unit": depth_unit,
        "sensor": sensor,
        "colour_from_depth": _numbers("--colour-from-depth", colour_from_depth),
        "pair_within": pair_within,
        "salvage": salvage or None,
    }
    overrides = {"perception": {name: value for name, value in given.items() if value is not None}}
    settings = load_settings(settings_file, overrides)
    files = observed.Outputs(output, labels, preview, force)
    files.check()
    if kind_of(recording) == "cloud":
        _observe_cloud(recording, settings, seed, files, as_json)
    else:
        _observe_recording(recording, settings, seed, files, as_json)


def _observe_cloud(path: Path, settings: Settings, seed: int, files: observed.Outputs, as_json: bool) -> None:
    from imitate.errors import FileError
    from imitate.formats.clouds import read_cloud
    from imitate.perception.look import look

    if files.demonstration is not None:
        remedy = "Leave out -o: a single cloud shows no movement to be written."
        raise FileError(files.demonstration, "is not written", remedy)
    cloud = read_cloud(path, settings.perception.depth_unit, settings.perception.sensor)
    for note in cloud.notes:
        console.narrate(f"{path}: {note}")
    with console.progress() as bar:
        bar.add_task(f"looking at {path.name}", total=None)
        first = look(str(path), cloud, settings.perception, seed)
    files.write_labels(first)
    files.preview_cloud(path, cloud, first)
    observed.report_cloud(cloud, first, as_json)


def _observe_recording(
    path: Path, settings: Settings, seed: int, files: observed.Outputs, as_json: bool
) -> None:
    from imitate.formats.frames import MUCH_LEFT_OUT
    from imitate.formats.recordings import open_recording
    from imitate.perception.observe import observe as watch

    recording = open_recording(path, settings.perception)
    with console.progress() as bar:
        task = bar.add_task(f"observing {path.name}", total=None)
        seen = watch(
            recording, settings, seed, lambda done, total: bar.update(task, completed=done, total=total)
        )
        files.write_demonstration(seen)
        files.write_labels(seen.first)
        files.preview_recording(recording, seen, settings.perception, bar)
    for note in recording.notes:
        console.narrate(f"{path}: {note}")
    observed.report_recording(seen, as_json)
    if seen.lost or recording.left_out > MUCH_LEFT_OUT:
        raise typer.Exit(console.Exit.LOSSY)


def _numbers(option: str, text: str | None) -> tuple[float, ...] | None:
    from imitate.errors import UsageError

    try:
        return None if text is None else tuple(float(word) for word in text.replace(",", " ").split())
    except ValueError:
        raise UsageError(f"{option} {text!r}: expected numbers with commas between them.") from None
