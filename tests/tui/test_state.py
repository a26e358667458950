"""What the screens show, folded from events without a screen."""

from __future__ import annotations

from pathlib import Path

import pytest
import scripted
from hypothesis import given
from hypothesis import strategies as st

from imitate import events
from imitate.skill import Decision
from imitate.tui.costs import Curve
from imitate.tui.state import State, moved
from imitate.tui.words import outcome, verdict


def learned(count: int | None = None) -> State:
    state = State()
    state.open(Path("stack.npz"), "demonstration")
    state.show(scripted.demonstration(), scripted.segments())
    state.begin(Path("sessions/stack.mcap"))
    for event in list(scripted.session())[:count]:
        state.fold(event)
    return state


def test_a_step_is_reachable_once_it_has_something_to_show() -> None:
    state = State()
    assert [step for step in state.steps if state.reachable(step)] == ["load"]
    state.show(scripted.demonstration(), scripted.segments())
    assert [step for step in state.steps if state.reachable(step)] == ["load", "review"]
    state.begin(Path("s.mcap"))
    assert [step for step in state.steps if state.reachable(step)] == ["load", "review", "learn"]


def test_a_recording_is_observed_once() -> None:
    state = State()
    state.open(Path("stack.mcap"), "recording")
    assert state.steps == ("load", "observe", "review", "learn", "reproduce", "replay")
    assert state.reachable("observe")
    state.show(scripted.demonstration(), scripted.segments())
    assert not state.reachable("observe")


def test_what_was_tracked_can_be_looked_at_again() -> None:
    state = State()
    state.open(Path("stack.mcap"), "recording")
    state.sight(scripted.sighting(100))
    state.sight(scripted.sighting(begin=100))
    assert state.observed == 1
    state.show(scripted.demonstration(), scripted.segments())
    assert state.reachable("observe")
    state.wear("blue", "green")
    assert state.sighting is None and state.demonstration is None and not state.reachable("review")
    state.sight(scripted.sighting(begin=100))  # what an observation that was left still says
    assert state.sighting is None and state.observed == 0


def test_segments_are_fixed_while_they_are_learned_and_free_afterwards() -> None:
    state = learned(10)
    assert not state.editable
    state.end()
    assert state.editable
    assert state.ended


def test_a_session_that_did_not_start_has_no_result() -> None:
    state = learned(0)
    state.end()
    assert not state.ended
    assert not state.reachable("reproduce")


def test_undo_counts_what_is_left_to_undo() -> None:
    state = learned(0)
    state.decide(Decision("move", 0, 3.9), scripted.segments())
    state.decide(Decision("move", 0, 3.8), scripted.segments())
    state.decide(Decision("undo"), scripted.segments())
    assert state.undoable == 1
    assert [decision.kind for decision in state.decisions] == ["move", "move", "undo"]


def test_opening_another_file_forgets_everything_but_the_settings() -> None:
    state = learned()
    state.seed = 7
    state.open(Path("other.npz"), "demonstration")
    assert (state.seed, state.source, state.demonstration, state.attempts) == (7, Path("other.npz"), None, [])


def test_a_recorded_session_shows_its_own_segments_and_cannot_be_changed() -> None:
    state = State()
    state.open(Path("s.mcap"), "session")
    for event in scripted.session():
        state.fold(event)
    state.show_recorded(Path("s.mcap"))
    assert state.segments == scripted.segments()
    assert state.demonstration is not None
    assert not state.editable
    assert state.reachable("reproduce")


def test_curve_holds_every_trial_once_apart_by_success() -> None:
    carry = learned().attempts[2]
    curve = Curve.of(carry)
    explored = [t for t in carry.trials if t.purpose == "explore"]
    assert sorted(curve.failed + curve.succeeded) == [(t.number + 1, t.cost.total) for t in explored]
    assert all(cost < 20 for _, cost in curve.succeeded)
    assert curve.updates == ((5, 24.5), (10, 14.75))
    assert Curve.of(None) == Curve((), (), ())


def test_outcomes_in_words() -> None:
    state = learned()
    assert [outcome(a, False, False) for a in state.attempts] == [
        "✓ accepted", "✗ given up", "✓ accepted", "✓ accepted",
    ]  # fmt: skip
    stopped = learned(5).attempts[0]
    assert outcome(stopped, True, True) == "▸ learning"
    assert outcome(stopped, True, False) == "■ stopped"


def test_verdict_in_words() -> None:
    assert verdict(learned().progress, 0.8).startswith(
        "✓ The task is reproduced. 18 of 20 = 0.90 [0.75, 0.97]"
    )
    assert verdict(learned(6).progress, 0.8) == "■ Not finished: the session ends after 3 trials."
    failed = State()
    for event in scripted.session(reproduced=False):
        failed.fold(event)
    assert verdict(failed.progress, 0.8).startswith("✗ The task is not reproduced. 4 of 20")


FRAME = 1 / 30


@pytest.mark.parametrize(
    ("frames", "seconds", "expected"),
    [(1, 0.0, 4 + FRAME), (-1, 0.0, 4 - FRAME), (0, 0.1, 4.1), (0, -0.1, 3.9), (0, 0.001, 4 + FRAME)],
)
def test_a_boundary_moves_to_the_time_of_a_frame(frames: int, seconds: float, expected: float) -> None:
    decision = moved(scripted.demonstration(), scripted.segments(), 0, frames, seconds)
    assert decision is not None
    assert (decision.kind, decision.segment) == ("move", 0)
    assert decision.time == pytest.approx(expected)


@given(st.integers(-1, 3), st.integers(-400, 400), st.floats(-15, 15))
def test_a_boundary_never_leaves_its_two_segments(boundary: int, frames: int, seconds: float) -> None:
    demonstration, segments = scripted.demonstration(), scripted.segments()
    decision = moved(demonstration, segments, boundary, frames, seconds)
    if decision is not None:
        assert boundary in (0, 1)
        assert segments[boundary].start < decision.time < segments[boundary + 1].end
        assert decision.time in demonstration.t
        assert decision.time != segments[boundary].end


def test_every_trial_and_update_leaves_a_trace() -> None:
    state = learned()
    story = list(scripted.session())
    trials = sum(isinstance(event, events.TrialFinished) for event in story)
    updates = sum(isinstance(event, events.PolicyUpdated) for event in story)
    assert sum(state.progress.counts.values()) == trials
    assert sum(len(attempt.updates) for attempt in state.attempts) == updates


def test_a_step_is_done_once_what_it_is_for_has_been_done() -> None:
    def done(state: State) -> list[str]:
        return [step for step in state.steps if state.done(step)]

    assert done(State()) == []
    assert done(learned(0)) == ["load", "review"]
    stopped = learned(30)
    stopped.end()
    assert done(stopped) == ["load", "review"]
    assert (stopped.resumable, stopped.whole) == (True, False)
    finished = learned()
    finished.end()
    assert done(finished) == ["load", "review", "learn", "reproduce"]
    assert (finished.resumable, finished.whole) == (False, True)


def test_the_curve_splits_the_cost_into_its_parts() -> None:
    carry = learned().attempts[2]
    parts = dict(Curve.of(carry, ("end", "acceleration", "gripper")).terms)
    whole = Curve.of(carry)
    totals = dict(sorted(whole.failed + whole.succeeded))
    sums = {n: sum(dict(points)[n] for points in parts.values()) for n in totals}
    assert sums == pytest.approx(totals)
    assert Curve.of(carry, ("end",)).failed == ()
