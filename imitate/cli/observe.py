"""`imitate observe`: an RGB-D recording to the poses of the hand and the objects."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from imitate.cli import console

if TYPE_CHECKING:
    from imitate.perception.observe import Observation


def observe(
    recording: Annotated[Path, typer.Argument(metavar="RECORDING", help="An RGB-D recording in MCAP.")],
    output: Annotated[
        Path | None,
        typer.Option("-o", "--output", metavar="FILE", help="The demonstration, as .npz or .mcap."),
    ] = None,
    settings_file: console.SettingsFile = None,
    seed: console.Seed = 0,
    as_json: console.Json = False,
    force: console.Force = False,
) -> None:
    """Follow hand and blocks through a recording.

    Exit code 3 says that something was out of sight for a while; its poses there are missing.
    """
    from imitate.formats.demonstrations import write_demonstration
    from imitate.formats.output import refuse_existing
    from imitate.perception.observe import observe as watch
    from imitate.settings import load_settings

    settings = load_settings(settings_file)
    if output is not None:
        refuse_existing(output, force)
    with console.progress() as bar:
        task = bar.add_task(f"observing {recording.name}", total=None)
        seen = watch(
            recording, settings, seed, lambda done, total: bar.update(task, completed=done, total=total)
        )
    if output is not None:
        write_demonstration(seen.demonstration, output, force)
    _report(seen, as_json)
    for name, frames in seen.lost_frames.items():
        spans = ", ".join(f"{start:.1f}–{end:.1f}" for start, end in seen.lost[name])
        console.narrate(f"{name}: not seen in {frames} of {len(seen.demonstration.t)} frames, at {spans} s")
    if seen.lost:
        raise typer.Exit(console.Exit.LOSSY)


def _report(seen: Observation, as_json: bool) -> None:
    d = seen.demonstration
    if as_json:
        objects = [
            {"name": name, "size": d.size_of(name).tolist(), "pose": d.pose_of(name)[0].tolist()}
            for name in d.object_names
        ]
        console.write_json({"frames": len(d.t), "objects": objects, "lost": seen.lost})
        return
    console.write(f"{len(d.t)} frames, {d.duration:.1f} s")
    for name in d.object_names:
        size = " × ".join(f"{1000 * side:.0f}" for side in d.size_of(name))
        x, y, z = 1000 * d.pose_of(name)[0, :3]
        console.write(f"{name}: {size} mm, first at x {x:.0f} y {y:.0f} z {z:.0f} mm")
