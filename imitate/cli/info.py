"""imitate info: what is inside a file, ours or another's, whole or damaged."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from imitate.cli import console

if TYPE_CHECKING:
    from imitate.formats.mcap_contents import Contents

_SMALL = 1 << 27
"""bytes up to which a file is read whole, so that damage in its middle is found too."""


def info(
    file: Annotated[
        Path,
        typer.Argument(
            metavar="FILE",
            help="Any MCAP file, a demonstration, a folder of a recording or LeRobot's, or a cloud.",
        ),
    ],
    as_json: console.Json = False,
) -> None:
    """Say what is inside a file.

    Exit code 3 says that it is damaged, or that more than a tenth of a recording's frames are missing.
    """
    from imitate.errors import FileError
    from imitate.formats.frames import MUCH_LEFT_OUT
    from imitate.formats.kind import kind_of
    from imitate.formats.mcap_contents import contents

    found: dict[str, Any] = {"file": str(file), "kind": "other"}
    try:
        inside = contents(file, thorough=file.exists() and file.stat().st_size <= _SMALL)
    except FileError:
        inside = None
    try:
        found["kind"] = kind_of(file)
    except FileError:
        if inside is None:
            raise
    if inside is not None:
        found |= _mcap(file, inside)
    if found["kind"] == "session":
        found |= _session(file)
        found["complete"] &= not found["damage"]
    elif found["kind"] == "demonstration" and not found.get("damage"):
        found |= _demonstration(file)
    elif found["kind"] == "recording" and not found.get("damage"):
        found |= _recording(file)
    elif found["kind"] == "cloud":
        found |= _cloud(file)
    console.write_json(found) if as_json else _show(found)
    if found.get("damage") or found.get("left_out", 0.0) > MUCH_LEFT_OUT:
        raise typer.Exit(console.Exit.LOSSY)


def _mcap(file: Path, inside: Contents) -> dict[str, Any]:
    return {
        "bytes": file.stat().st_size,
        "seconds": (inside.end - inside.start) / 1e9,
        "damage": list(inside.damage),
        "topics": {name: {"schema": s, "messages": count} for name, (s, count) in inside.topics.items()},
        "metadata": sorted(inside.metadata),
        "attachments": list(inside.attachments),
    }


def _session(file: Path) -> dict[str, Any]:
    from imitate.events import SessionStarted
    from imitate.formats.session_log import read_session, summarise

    summary = summarise(file)
    found: dict[str, Any] = {
        "complete": summary.complete,
        "trials": summary.trials,
        "seconds": summary.seconds,
        "imitate": summary.version,
    }
    started = next(iter(read_session(file, steps=False)), None)
    if isinstance(started, SessionStarted):
        found |= {
            "source": started.source,
            "source_hash": started.source_hash,
            "seed": started.seed,
            "objects": list(started.scene.object_names),
            "robot": started.scene.robot,
            "versions": dict(started.versions),
        }
    return found


def _demonstration(file: Path) -> dict[str, Any]:
    import numpy as np

    from imitate.formats.demonstrations import read_demonstration
    from imitate.formats.kind import table_format

    if table_format(file) == "lerobot":
        from imitate.formats.lerobot import facts

        return facts(file)
    notes: list[str] = []
    shown = read_demonstration(file, notes=notes)
    sizes = [None if np.isnan(size).any() else size.tolist() for size in shown.object_sizes]
    seen = shown.opening[~np.isnan(shown.opening)] if shown.opening is not None else np.zeros(0)
    return {
        "frames": len(shown.t),
        "seconds": shown.duration,
        "opening": [float(seen.min()), float(seen.max())] if len(seen) else None,
        "objects": [
            {"name": name, "size": size} for name, size in zip(shown.object_names, sizes, strict=True)
        ],
        "notes": notes,
    }


def _recording(file: Path) -> dict[str, Any]:
    """Its pictures, or what keeps them from being used."""
    from dataclasses import asdict

    from imitate.errors import FileError
    from imitate.formats.recordings import open_recording

    try:
        recording = open_recording(file)
        if _size(file) <= _SMALL:
            recording.survey()
    except FileError as error:
        return {"problem": str(error).removeprefix(f"{file}: ")}
    return {
        "frames": recording.count,
        "camera": asdict(recording.intrinsics),
        "notes": list(recording.notes),
        "left_out": recording.left_out,
    }


def _size(file: Path) -> int:
    # Of a folder, of its lists alone, which are all that is read of it.
    return 0 if file.is_dir() else file.stat().st_size


def _cloud(file: Path) -> dict[str, Any]:
    from imitate.formats.clouds import read_cloud

    cloud = read_cloud(file)
    return {"points": len(cloud.points), "colour": cloud.colour is not None, "shape": cloud.shape}


def _show(found: dict[str, Any]) -> None:
    facts = console.table("", "", header=False)
    for name in (
        "file",
        "kind",
        "source",
        "seed",
        "complete",
        "trials",
        "episodes",
        "frames",
        "bytes",
        "robot",
        "imitate",
        "points",
        "colour",
        "problem",
    ):
        if name in found:
            value = found[name]
            facts.add_row(name, f"{value:,}" if type(value) is int and name != "seed" else str(value))
    if "seconds" in found:
        facts.add_row("seconds", f"{found['seconds']:.3f}")
    if found.get("opening"):
        facts.add_row("hand opens", " to ".join(f"{1000 * width:.0f}" for width in found["opening"]) + " mm")
    if "camera" in found:
        camera = found["camera"]
        size = f"{camera['width']}×{camera['height']}"
        facts.add_row(
            "camera", f"{size}, " + ", ".join(f"{k} {camera[k]:g}" for k in ("fx", "fy", "cx", "cy"))
        )
    for note in found.get("notes", ()):
        facts.add_row("note", note)
    for thing in found.get("objects", ()):
        facts.add_row("object", thing if isinstance(thing, str) else _object(thing))
    for name, width in found.get("columns", {}).items():
        facts.add_row("column", f"{name}, {width or 'no'} number{'' if width == 1 else 's'} a row")
    if found.get("attachments"):
        facts.add_row("attached", ", ".join(found["attachments"]))
    for damage in found.get("damage", ()):
        facts.add_row("damage", damage)
    console.show(facts)
    if found.get("topics"):
        topics = console.table("topic", "messages", "schema", right=("messages",))
        for name, topic in found["topics"].items():
            topics.add_row(name, f"{topic['messages']:,}", topic["schema"])
        console.show(topics)


def _object(thing: dict[str, Any]) -> str:
    size = (
        " × ".join(f"{edge * 1000:.0f}" for edge in thing["size"]) + " mm"
        if thing["size"]
        else "size unknown"
    )
    return f"{thing['name']}, {size}"
