"""Which rows of a table are frames, and when: one episode, in seconds, by one clock."""

from __future__ import annotations

from collections.abc import Collection
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from imitate.demonstration import LONGEST_GAP, span_in_words
from imitate.errors import FileError
from imitate.formats.clock import (
    ASTRAY,
    MUCH_ASTRAY,
    NAMES,
    astray_note,
    epoch_unit,
    faster_unit,
    gaps_in_words,
    on_one_clock,
    usual_step,
)
from imitate.formats.mapping import TIMES, Mapping
from imitate.geometry import Array

EPISODES = ("episode_index", "episode", "episode_id")
"""columns that may say of which episode a row is."""
SLOW = 5.0
"""s between frames from which on times are in another unit, unless a mapping says that they are not; of whole
numbers, 1 s."""
_MAPPING = "in a mapping (--mapping FILE.toml)"
_UNORDERED = 0.25
"""share of steps back in time from which on the rows are in no order."""
_SHORTEST = 10
"""rows that a part of a table has on average, where it has several."""

Rows = NDArray[np.int_]


def frames_in_time(
    path: Path, ticks: Array, episodes: NDArray[Any] | None, mapping: Mapping, notes: list[str]
) -> tuple[Array, Rows]:
    """Seconds (T,) and the rows that are frames: those of one episode whose times keep to one clock.

    Args:
        path: of the table, for messages.
        ticks: (N,) the times as the table has them.
        episodes: (N,) of which episode each row is; None where nothing says so.
        mapping: says the unit of the times, and which episode.
        notes: gets what the person ought to know.

    Raises:
        FileError: several episodes and none chosen, a clock that was set, or times that are no seconds.
    """
    rows = episode_rows(path, episodes, mapping.episode) if episodes is not None else np.arange(len(ticks))
    if len(rows) < 2 or not np.isfinite(ticks[rows]).all():
        return ticks[rows], rows
    t = _seconds(path, ticks[rows], mapping.time_unit, notes)
    if np.mean(np.diff(t) < 0) > _UNORDERED:
        return t, rows  # in no order at all; what is wrong with that the demonstration says
    off: list[int] = []
    kept = list(on_one_clock(range(len(t)), t.__getitem__, off.append))
    if len(off) > MUCH_ASTRAY * len(t):
        problem = f"{len(off)} of its {len(t)} times are more than {ASTRAY:g} s off those before and after"
        raise FileError(path, problem, f"Mend them, or say the frames a second {_MAPPING}: rate = 30.0.")
    if off:
        notes.append(astray_note("frames", len(off), len(t), f" (frame {off[0]}, at {t[off[0]]:.12g} s)"))
    part = kept if episodes is not None else _part(path, t, kept, mapping.episode)
    notes += gaps_in_words(t[part])
    return t[part], rows[part]


def episode_rows(path: Path, episodes: NDArray[Any], wanted: int | None) -> Rows:
    """The rows of the episode that is wanted, or of the only one there is.

    Raises:
        FileError: several and none chosen, or no such one.
    """
    held = np.unique(episodes).tolist()
    chosen = chosen_episode(path, held, wanted)
    return np.flatnonzero(episodes == chosen)


def chosen_episode(path: Path, held: Collection[float], wanted: int | None) -> float:
    """The number of the episode to read, of those that a file holds.

    Raises:
        FileError: several and none wanted, or no such one.
    """
    numbers = sorted(held)
    if wanted is None and len(numbers) == 1:
        return numbers[0]
    if wanted is None or wanted not in numbers:
        problem = (
            f"holds {len(numbers)} episodes, {numbers[0]:g} to {numbers[-1]:g}"
            if numbers
            else "holds no episodes"
        )
        raise FileError(
            path,
            problem + (f", and none of them is {wanted}" if wanted is not None else ""),
            f"Choose one in a mapping (--mapping FILE.toml): episode = {numbers[0] if numbers else 0:g}.",
        )
    return wanted


def _seconds(path: Path, ticks: Array, said: str | None, notes: list[str]) -> Array:
    if said is not None:
        return ticks if said == "s" else np.asarray((ticks - ticks[0]) * TIMES[said])
    unit, step = epoch_unit(ticks), usual_step(ticks)
    if unit is not None and unit != "s":
        notes.append(
            f"its times are {NAMES[unit]} since 1970 and read as such; time_unit in a mapping says otherwise"
        )
        return np.asarray((ticks - ticks[0]) * TIMES[unit])
    if not step:
        raise FileError(
            path,
            f"has the same time in most of its frames: {len(np.unique(ticks))} times in {len(ticks)}",
            "Times since 1970 need double precision; where there are none, say the frames a second "
            f"{_MAPPING}: rate = 30.0.",
        )
    whole = step >= 1 and bool((ticks == np.round(ticks)).all())
    if step >= SLOW or whole:
        other = faster_unit(step)
        counted = "; rate = 30.0, if they count frames" if whole and step == 1 else ""
        raise FileError(
            path,
            f"has times that are no seconds of a demonstration: {len(ticks)} of them, usually {step:g} apart",
            f'Say their unit {_MAPPING}: time_unit = "{other}", if they are {NAMES[other]}{counted}; or "s", '
            "if they are seconds after all.",
        )
    return ticks


def _part(path: Path, t: Array, kept: list[int], wanted: int | None) -> list[int]:
    """The frames of one part of a table, between the jumps of its clock."""
    steps = np.diff(t[kept])
    jumps = np.flatnonzero((steps < -ASTRAY) | (steps > LONGEST_GAP))
    if len(jumps) and len(kept) < _SHORTEST * (1 + len(jumps)):
        return kept  # in no order at all
    parts = np.split(np.array(kept), jumps + 1)
    if wanted is None and len(parts) > 1:
        raise _jumps(path, t, parts)
    return [int(k) for k in parts[int(chosen_episode(path, range(len(parts)), wanted))]]


def _jumps(path: Path, t: Array, parts: list[NDArray[np.int_]]) -> FileError:
    before, after = parts[0][-1], parts[1][0]
    where = f"at frame {after}, from {t[before]:.12g} s to {t[after]:.12g} s"
    remedy = f"Read one part {_MAPPING}: episode = 0, the first of {len(parts)}."
    lengths = [t[part[-1]] - t[part[0]] for part in parts]
    starts = [abs(t[part[0]] - t[0]) for part in parts]
    if all(start <= max(ASTRAY, 0.1 * length) for start, length in zip(starts, lengths, strict=True)):
        return FileError(path, f"seems to hold {len(parts)} episodes: its times start again {where}", remedy)
    way = "go back" if t[after] < t[before] else "jump"
    return FileError(
        path,
        f"has times that {way} by {span_in_words(abs(t[after] - t[before]))} {where}: its clock was set, "
        "or it goes on another time",
        remedy,
    )
