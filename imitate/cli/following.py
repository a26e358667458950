"""What is said of a session while it runs, and what came of it."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from itertools import takewhile
from pathlib import Path
from typing import TYPE_CHECKING, Any

import typer

from imitate.cli import console

if TYPE_CHECKING:
    from imitate.events import Event
    from imitate.session.progress import Attempt, Progress


def follow(
    events: Callable[[Callable[[int, int], None]], Iterator[Event]],
    log: Path,
    rrd: Path | None,
    as_json: bool,
) -> None:
    """Shows a session while it runs, and what came of it.

    Args:
        events: the session's; given who hears of (frames done, frames in all) while a recording is observed.
        log, rrd: where it is written.
        as_json: for machines.
    """
    from imitate.session.progress import Progress, learn_report

    began = time.monotonic()
    progress = Progress()
    with console.progress() as bar:
        task = bar.add_task("reading", total=None)

        def watching(done: int, of: int) -> None:
            bar.update(task, description="observing", completed=done, total=of)

        for event in events(watching):
            progress.fold(event)
            bar.update(task, **_state(progress, event))
            _narrate(event)
    report = learn_report(progress, log, round(time.monotonic() - began, 3))
    try:
        console.write_json(report) if as_json else _show(progress, report["wall_s"])
    finally:  # where stdout is full, too, it is said where all that was learned is
        console.narrate(f"session: {log}" + (f", viewer: {rrd}" if rrd else ""))
    if progress.finished and not progress.finished.reproduced:
        console.narrate(progress.finished.advice)
        raise typer.Exit(console.Exit.LOSSY)


def _state(progress: Progress, event: Event) -> dict[str, Any]:
    # What the bar says: the formulation at hand and its share of the trial budget.
    from imitate.events import TrialFinished

    present = progress.present
    if present is None:
        return {"description": "segmenting", "total": None}
    skill = f"skill {present.formulation.segment + 1} of {len(progress.skills)}"
    learning = progress.settings.learning
    if not isinstance(event, TrialFinished):
        return {"description": skill}
    if event.purpose == "reproduce":
        done, total = len(progress.reproduction), learning.reproduction_starts
        return {"description": "reproducing", "completed": done, "total": total}
    if event.purpose in ("evaluate", "choose"):
        total = learning.evaluation_starts if event.purpose == "evaluate" else learning.candidate_starts
        now = takewhile(lambda t: t.purpose == event.purpose, reversed(present.trials))
        done = sum(1 for _ in now) % total or total
        return {"description": f"{skill}: {event.purpose}", "completed": done, "total": total}
    budget = learning.first_rollouts + learning.rollouts * (learning.updates - 1)
    actions = " + ".join(present.formulation.actions)
    return {"description": f"{skill}: {actions}", "completed": present.explored, "total": budget}


def _narrate(event: Event) -> None:
    from imitate.events import OptionLearned, Reformulated, Segmented

    match event:
        case Segmented(segments=segments):
            for number, s in enumerate(segments, start=1):
                console.narrate(f"skill {number}: {s.start:.2f}–{s.end:.2f} s {s.abstraction}")
        case Reformulated():
            console.narrate(f"skill {event.segment + 1}: {event.reason}", wrapped=True)
        case OptionLearned(moved=moved) if moved:
            after = f"skill {event.segment + 2}"
            console.narrate(
                f"skill {event.segment + 1}: its goal is moved by {moved * 1e3:.0f} mm, for {after}"
            )
        case OptionLearned():
            skill = f"skill {event.segment + 1}"
            console.narrate(f"{skill}: learned")
            if event.initiation:
                console.narrate(f"{skill}: {event.initiation}", wrapped=True)
            if outside := event.ends - event.ends_inside:
                ends = f"{outside} of {event.ends} ends of skill {event.segment}"
                console.narrate(f"{skill}: {ends} lie outside its initiation set", wrapped=True)


def _outcome(attempt: Attempt) -> str:
    # What became of a formulation, and why it was not tried from all the starts.
    words = "accepted" if attempt.accepted else "given up"
    stopped = attempt.evaluated.stopped if attempt.evaluated else ""
    return f"{words}; stopped: {stopped}" if stopped else words


def _show(progress: Progress, seconds: float) -> None:
    numbers = ("trials", "cost", "P", "interval")
    table = console.table("skill", "relevant", "reference", "actions", *numbers, "", right=numbers)
    for skill in progress.skills:
        for attempt in skill.attempts:
            f, judged = attempt.formulation, attempt.evaluated
            table.add_row(
                str(skill.index + 1),
                ", ".join(f.abstraction.relevant),
                f.abstraction.reference,
                " + ".join(f.actions),
                str(attempt.explored),
                f"{attempt.cost:.1f}" if attempt.cost is not None else "",
                f"{judged.successes}/{judged.trials}" if judged else "",
                f"{judged.low:.2f}–{judged.high:.2f}" if judged else "",
                _outcome(attempt),
            )
    console.show(table)
    if r := progress.reproduced:
        verdict = "reproduced" if r.reproduced else "not reproduced"
        console.write(
            f"{verdict}: {r.successes} of {r.trials} perturbed starts "
            f"(95 % interval {r.low:.2f}–{r.high:.2f}), {seconds:.0f} s{console.really(r)}"
        )
