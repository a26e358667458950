"""What a replay found, for people and for machines."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

from imitate.cli import console

if TYPE_CHECKING:
    from imitate.session.replay import Divergence, ReplayReport
    from imitate.session.rerun import RerunReport


def warn(session: Path, report: ReplayReport | RerunReport) -> None:
    """Says what of the machine or the file may explain a difference."""
    for difference in report.machine:
        console.narrate(f"warning: {session} was {difference}")
    for damage in report.damage:
        console.narrate(f"warning: {session} is damaged: {damage}. What was whole before it was replayed.")


def plain(report: ReplayReport | RerunReport) -> dict[str, Any]:
    """For machines: what was compared, how much of it differs, and the first that does."""
    from imitate.session.rerun import RerunReport

    first, event = report.first_divergence, {}
    found: dict[str, Any]
    if isinstance(report, RerunReport):
        found = {"events": report.events, "messages": report.messages}
        event = {"event": first.event, "number": first.number} if first else {}
    else:
        found = {"steps": report.steps}
    found |= {"divergent": report.divergent, "first_divergence": None}
    if first is not None:
        found["first_divergence"] = event | {
            "step": first.step,
            "segment": first.segment,
            "trial": first.trial,
            "field": first.field,
            "recorded": console.number(first.recorded),
            "replayed": console.number(first.replayed),
        }
    return found


def show(report: ReplayReport | RerunReport) -> None:
    """For people: the same in words."""
    from imitate.session.rerun import RerunReport

    if isinstance(report, RerunReport):
        what, kind = f"{report.events:,} events with {report.messages:,} messages", "events"
        same = "every message is the same"
    else:
        what, kind = f"{report.steps:,} steps of {report.trials:,} trials", "steps"
        same = "every double of every step is the same"
    if report.first_divergence is None:
        console.write(f"{what} replayed: {same}.")
    else:
        console.write(f"{what} replayed: {report.divergent:,} {kind} differ.")
        console.write(_in_words(report.first_divergence))
    if isinstance(report, RerunReport):
        if not report.finished:
            console.write("The session had not ended; it was run again as far as it went.")
    elif report.unrecorded:
        console.write(f"{report.unrecorded:,} trials were recorded without their steps.")


def _in_words(first: Divergence) -> str:
    step = [] if first.step is None else [f"step {first.step}"]
    trial = [] if first.trial is None else [f"trial {first.trial}"]
    segment = [] if first.segment is None else [f"segment {first.segment}, formulation {first.formulation}"]
    where = " of ".join(step + trial + segment)
    if first.number is not None:
        where = f"event {first.number}, {first.event}" + (f", {where}" if where else "")
    values = f"{first.field} was recorded as {first.recorded!r}, replayed as {first.replayed!r}"
    return f"First at {where}: {values}."
