"""A whole session run again: every message is compared, and the first that differs is named."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from refiled import cut, flipped, written

from imitate.events import (
    Decided,
    Event,
    OptionLearned,
    SessionFinished,
    SessionStarted,
    Skipped,
    TrialFinished,
)
from imitate.formats.mcap_file import McapReader
from imitate.formats.session_log import read_session
from imitate.learning.trials import executors
from imitate.session.rerun import rerun
from imitate.session.session import Request, run
from imitate.settings import load_settings
from imitate.skill import Decision

HERE = executors(0)


@pytest.fixture(scope="module")
def story(easy: Path) -> list[Event]:
    """The first two trials of a session and what came before."""
    return list(read_session(easy))[:5]


def nudged(values: np.ndarray, index: tuple[int, ...]) -> np.ndarray:
    values = np.array(values)
    values[index] = np.nextafter(values[index], np.inf)
    return values


@pytest.mark.parametrize("session", ["easy", pytest.param("hard", marks=pytest.mark.slow)])
def test_nothing_differs_where_nothing_was_changed(session, request):
    path = request.getfixturevalue(session)
    report = rerun(path, HERE)
    assert (report.divergent, report.first_divergence, report.finished) == (0, None, True)
    assert report.events == sum(1 for _ in read_session(path))
    assert report.messages == sum(1 for _ in McapReader(path).messages())
    assert (report.damage, report.machine) == ((), ())


@pytest.mark.slow
def test_two_workers_report_the_same(story, tmp_path):
    path = written(tmp_path / "s.mcap", story)
    done: list[tuple[int, int]] = []
    one = rerun(path, executors(2), progress=lambda trials, of: done.append((trials, of)))
    assert one == rerun(path, HERE)
    assert not one.finished
    assert done == [(1, 2), (2, 2)]


def test_a_bit_of_a_step_is_named(story, tmp_path):
    trial = story[4]
    record = replace(trial.record, contact_forces=nudged(trial.record.contact_forces, (700, 0)))
    path = written(tmp_path / "s.mcap", [*story[:4], replace(trial, record=record)])
    report = rerun(path, HERE)
    first = report.first_divergence
    assert (report.divergent, report.events) == (1, 5)
    assert (first.event, first.number, first.segment, first.trial) == ("TrialFinished", 4, 0, 1)
    assert (first.step, first.field) == (700, "contact_forces[cubeA]")
    assert first.recorded == np.nextafter(first.replayed, np.inf)


def test_a_bit_of_a_policy_is_named_by_its_field(story, tmp_path):
    trial = story[3]
    policy = replace(trial.policies[0], pose_weights=nudged(trial.policies[0].pose_weights, (3, 1)))
    path = written(tmp_path / "policy.mcap", [*story[:3], replace(trial, policies=(policy,))])
    first = rerun(path, HERE).first_divergence
    assert (first.field, first.step) == ("policies[0].pose_weights[3,1]", None)


def test_a_message_for_peoples_tools_is_compared_as_well(story, tmp_path):
    source = written(tmp_path / "s.mcap", story)
    report = rerun(flipped(source, tmp_path / "changed.mcap", "/tf", 9), HERE)
    assert report.divergent == 1
    assert report.first_divergence.field.startswith("/tf at ")
    assert report.first_divergence.event == "TrialFinished"


def test_a_session_that_takes_another_course_is_compared_up_to_there(easy, tmp_path):
    events = [e for e in read_session(easy) if not isinstance(e, OptionLearned)]
    report = rerun(written(tmp_path / "s.mcap", events), HERE)
    first = report.first_divergence
    assert (first.event, first.field) == ("TrialFinished", "event")
    assert (first.recorded, first.replayed) == ("TrialFinished", "OptionLearned")
    assert report.divergent == 1
    assert not report.finished


@pytest.mark.slow
def test_another_seed_is_seen(easy, tmp_path):
    events = [replace(e, seed=4) if isinstance(e, SessionStarted) else e for e in read_session(easy)]
    first = rerun(written(tmp_path / "s.mcap", events), HERE).first_divergence
    assert (first.event, first.field) == ("TrialFinished", "record.start.objects[0,0]")


@pytest.mark.slow
def test_more_than_there_should_be_is_seen(easy, tmp_path):
    events = list(read_session(easy))
    first = rerun(written(tmp_path / "s.mcap", [*events, events[-1]]), HERE).first_divergence
    assert (first.event, first.recorded, first.replayed) == ("SessionFinished", "SessionFinished", "none")


def test_a_cut_session_is_compared_as_far_as_it_goes(easy, tmp_path):
    report = rerun(cut(easy, tmp_path / "cut.mcap", 0.5), HERE)
    assert (report.divergent, report.finished) == (0, False)
    assert 0 < report.events < sum(1 for _ in read_session(easy))
    assert "the end of the file is missing" in report.damage[0]


@pytest.mark.slow
def test_trials_recorded_without_steps_are_compared_without(story, tmp_path):
    assert rerun(written(tmp_path / "s.mcap", story, steps=False), HERE).divergent == 0


def test_decisions_are_made_again(source, tmp_path):
    decisions = (Decision("split", 0, 2.0), Decision("move", 0, 2.4), Decision("undo"))
    log = tmp_path / "decided.mcap"
    few = load_settings(None, {"learning": {"first_rollouts": 2}})
    for event in run(Request(source, few, 3, 0, decisions, log=log)):
        if isinstance(event, TrialFinished):
            break
    events = list(read_session(log))
    moved = next(k for k, e in enumerate(events) if isinstance(e, Decided) and e.decision.kind == "move")
    segments = (replace(events[moved].segments[0], end=2.5), *events[moved].segments[1:])
    events[moved] = replace(events[moved], segments=segments)
    first = rerun(written(tmp_path / "changed.mcap", events), HERE).first_divergence
    assert (first.event, first.field) == ("Decided", "segments[0].end")


@pytest.mark.slow
def test_the_end_names_the_source_and_not_where_it_lies(hard, source):
    (end,) = [e for e in read_session(hard) if isinstance(e, SessionFinished)]
    assert "imitate learn carry.npz --seed 4" in end.advice
    assert str(source.parent) not in end.advice


@pytest.mark.parametrize("workers", [0, pytest.param(2, marks=pytest.mark.slow)])
def test_what_the_operator_skipped_is_skipped_again(skipped, workers):
    events = list(read_session(skipped))
    (skip,) = [e for e in events if isinstance(e, Skipped)]
    assert (skip.segment, skip.formulation) == (0, 0)
    report = rerun(skipped, executors(workers))
    assert (report.divergent, report.first_divergence, report.events) == (0, None, len(events))


def test_a_skip_that_is_taken_out_diverges(skipped, tmp_path):
    events = [e for e in read_session(skipped) if not isinstance(e, Skipped)]
    report = rerun(written(tmp_path / "s.mcap", events), HERE)
    assert report.divergent
