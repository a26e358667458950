"""Formulations, results and files in words, for the operator."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from imitate.demonstration import HAND, Demonstration
from imitate.events import Evaluated, Reproduced
from imitate.session.progress import Attempt, Progress
from imitate.skill import Abstraction, Action

if TYPE_CHECKING:
    from imitate.formats.session_log import SessionSummary
    from imitate.tui.again import Report
    from imitate.tui.film import Film
    from imitate.tui.sighting import Sighting
    from imitate.tui.state import State


def listed(names: tuple[str, ...]) -> str:
    """ "a", "a and b", "a, b and c"; the hand with its article."""
    return _joined([_article(name) for name in names])


def _article(name: str) -> str:
    return f"the {name}" if name == HAND else name


def _joined(words: list[str]) -> str:
    return " and ".join([", ".join(words[:-1]), words[-1]] if len(words) > 1 else words)


def state_in_words(abstraction: Abstraction) -> str:
    """What is observed."""
    bodies = abstraction.relevant
    return f"where {listed(bodies)} {'is' if len(bodies) == 1 else 'are'}, seen from {abstraction.reference}"


def actions_in_words(actions: tuple[Action, ...]) -> str:
    """What may be done."""
    return "move the hand; open and close the gripper" if "gripper" in actions else "move the hand"


def success_in_words(judged: Evaluated | Reproduced) -> str:
    """P with its interval."""
    share = judged.successes / judged.trials if judged.trials else 0.0
    stopped = f", stopped: {judged.stopped}" if isinstance(judged, Evaluated) and judged.stopped else ""
    rate = f"{judged.successes} of {judged.trials} = {share:.2f}"
    return f"{rate} [{judged.low:.2f}, {judged.high:.2f}]{stopped}"


def outcome(attempt: Attempt, present: bool, running: bool) -> str:
    """How a formulation stands, with a sign that needs no colour."""
    if attempt.accepted:
        return "✓ accepted"
    if attempt.given_up:
        return "✗ given up"
    if not (present and running):
        return "✗ rejected" if attempt.evaluated else "■ stopped"
    return "▸ judging" if attempt.trials and attempt.trials[-1].purpose == "evaluate" else "▸ learning"


def duration_in_words(seconds: float) -> str:
    """Seconds below two minutes, then minutes."""
    return f"{seconds:.0f} s" if seconds < 120 else f"{seconds / 60:.0f} min"


def decided_in_words(state: State) -> str:
    """How the segments stand: as found, or what the operator decided."""
    text = "as found; nothing decided yet"
    if state.decisions:
        count = "1 decision" if state.undoable == 1 else f"{state.undoable} decisions"
        text = f"{count} of yours (w writes, R resets), the last: {state.decisions[-1]}"
    if state.running:
        return f"{text}  (learning runs)"
    return text if state.editable else f"{text}  (recorded: open its demonstration to decide)"


def change_in_words(change: tuple[float, float]) -> str:
    """From when to when a change lies."""
    low, high = change
    return f"{low:.2f}–{high:.2f} s"


def verdict(progress: Progress, alpha: float) -> str:
    """The result of a session, in one line."""
    if not progress.finished:
        count = sum(progress.counts.values())
        return f"■ Not finished: the session ends after {count} trials."
    judged = f" {success_in_words(progress.reproduced)}, needed {alpha:.2f}." if progress.reproduced else ""
    if progress.finished.reproduced:
        return f"✓ The task is reproduced.{judged}"
    return f"✗ The task is not reproduced.{judged}"


def demonstration_facts(demonstration: Demonstration) -> tuple[tuple[str, str], ...]:
    """What a demonstration holds, as (name, value) rows."""
    frames = len(demonstration.t)
    rows = [
        ("duration", f"{demonstration.duration:.2f} s"),
        ("frames", f"{frames}, {(frames - 1) / demonstration.duration:.0f} a second"),
    ]
    for name in demonstration.object_names:
        size = " × ".join(f"{1000 * side:.0f}" for side in demonstration.size_of(name))
        rows.append((name, "size unknown" if "nan" in size else f"{size} mm"))
    return tuple(rows)


def demonstration_faults(demonstration: Demonstration) -> tuple[str, ...]:
    """What of a demonstration is missing."""
    frames = len(demonstration.t)
    found = []
    for name in (HAND, *demonstration.object_names):
        unseen = frames - int(demonstration.seen(name).sum())
        if unseen:
            found.append(f"{listed((name,))} was not seen in {unseen} of {frames} frames")
    for name in demonstration.object_names:
        if np.isnan(demonstration.size_of(name)).any():
            found.append(f"the size of {name} is not known, and learning needs it")
    return tuple(found)


def losses_in_words(sighting: Sighting, demonstration: Demonstration) -> str:
    """Who was lost for how long, and who could not be followed; empty where nobody was."""
    seconds = dict(zip(sighting.cast.names, sighting.lost_seconds, strict=True))
    kept = (HAND, *demonstration.object_names)
    lost = [f"{_article(name)} for {seconds[name]:.2f} s" for name in kept if seconds.get(name)]
    gone = [name for name in seconds if name not in kept]
    parts = [f"Not seen: {_joined(lost)}."] if lost else []
    parts += [f"Left out, as it could not be followed: {_joined(gone)}."] if gone else []
    return " ".join(parts)


def session_facts(summary: SessionSummary) -> tuple[tuple[str, str], ...]:
    """What a session's file holds, as (name, value) rows."""
    rows = [
        ("ended", "yes" if summary.complete else "no: it was stopped or cut"),
        ("skills", str(summary.events.get("OptionLearned", 0)) + " learned"),
        ("tried", f"{summary.events.get('FormulationStarted', 0)} formulations, {summary.trials} trials"),
        ("simulated", f"{summary.seconds:.0f} s"),
        ("imitate", summary.version),
    ]
    return (*rows, *(("damage", what) for what in summary.damage))


def short(path: Path, root: Path | None = None) -> str:
    """A path, relative to the present folder when it is inside."""
    try:
        return str(path.resolve().relative_to((root or Path.cwd()).resolve()))
    except ValueError:
        return str(path)


DEPTH_WORDS = {
    "physics": "from the recorded commands",
    "policy": "from the recorded policies",
    "session": "everything anew from seed and decisions",
}
"""what a replay takes from the record."""


def bar(share: float, width: int) -> str:
    """A share, 0 to 1, as a bar of so many cells."""
    full = round(min(max(share, 0.0), 1.0) * width)
    return "━" * full + "╌" * (width - full)


def film_words(film: Film) -> str:
    """A trial, and what went wrong in it."""
    kind = "the whole task" if film.purpose == "reproduce" else f"skill {film.segment + 1}"
    return f"trial {film.trial + 1} of {kind}: " + ("✓ done" if film.success else f"✗ {film.failure}")


def report_in_words(report: Report) -> tuple[bool, str]:
    """Whether a replay found no difference, and what it compared."""
    from imitate.session.rerun import RerunReport  # brings the physics with it

    if isinstance(report, RerunReport):
        what = f"{report.events:,} events with {report.messages:,} messages"
        ended = "" if report.finished else " The session had not ended; it was run again as far as it went."
    else:
        what, ended = f"{report.steps:,} steps of {report.trials:,} trials", ""
    damage = f" The file is damaged: {report.damage[0]}." if report.damage else ""
    first = report.first_divergence
    if first is None:
        return not report.damage, f"✓ 0 divergent: {what} are the same, bit for bit.{ended}{damage}"
    skill = None if first.segment is None else first.segment + 1
    parts = (("step", first.step), ("trial", first.trial), ("skill", skill))
    where = ", ".join(f"{name} {value}" for name, value in parts if value is not None) or first.event
    values = f"{first.field} was recorded as {first.recorded!r}, replayed as {first.replayed!r}"
    machine = f" ({'; '.join(report.machine)})" if report.machine else ""
    return False, f"✗ {report.divergent:,} divergent of {what}. First at {where}: {values}{machine}.{damage}"
