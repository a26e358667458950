"""What the events of a session add up to."""

from __future__ import annotations

import json
from collections.abc import Iterable
from dataclasses import replace

import numpy as np
import scripted

from imitate import events
from imitate.session.progress import Progress, learn_report
from imitate.skill import Decision, InitiationSet


def folded(story: Iterable[events.Event]) -> Progress:
    progress = Progress()
    for event in story:
        progress.fold(event)
    return progress


def until(kind: type, count: int = 1) -> Progress:
    """Progress up to and with the ``count``-th event of a kind."""
    progress = Progress()
    for event in scripted.session():
        progress.fold(event)
        count -= isinstance(event, kind)
        if not count:
            break
    return progress


def test_each_skill_keeps_its_formulations_in_order() -> None:
    skills = folded(scripted.session()).skills
    assert [len(skill.attempts) for skill in skills] == [1, 2, 1]
    assert [a.formulation.actions for a in skills[1].attempts] == [("pose",), ("pose", "gripper")]
    assert all(skill.accepted for skill in skills)


def test_a_formulation_given_up_keeps_its_reason_and_does_not_make_the_skill_accepted() -> None:
    progress = until(events.Reformulated)
    (failed,) = [a for skill in progress.skills for a in skill.attempts if a.given_up]
    assert failed.given_up == scripted.FAILED
    assert not progress.skills[1].accepted


def test_only_exploring_trials_count_towards_the_budget() -> None:
    carry = folded(scripted.session()).skills[1].attempts[1]
    assert (carry.explored, len(carry.trials)) == (10, 30)
    assert [update.after for update in carry.updates] == [5, 10]


def test_trials_are_counted_by_purpose_and_reproduction_is_kept_apart() -> None:
    progress = folded(scripted.session())
    assert progress.counts == {"explore": 30, "evaluate": 80, "reproduce": 20}
    assert len(progress.reproduction) == 20
    assert sum(len(a.trials) for skill in progress.skills for a in skill.attempts) == 110


def test_cost_is_the_best_trial_until_the_policy_is_judged() -> None:
    assert until(events.TrialFinished, 2).present.cost == 8.5  # type: ignore[union-attr]
    assert until(events.Evaluated).present.cost == 7.25  # type: ignore[union-attr]
    assert until(events.FormulationStarted).present.cost is None  # type: ignore[union-attr]


def test_going_back_to_a_segment_opens_it_again() -> None:
    progress = until(events.OptionLearned)
    again = replace(progress.skills[0].attempts[0].formulation, index=1, reason="the carry failed")
    progress.fold(events.FormulationStarted(again))
    assert not progress.skills[0].accepted
    assert progress.present is progress.attempt(0, 1)


def test_decisions_replace_the_segments() -> None:
    progress = until(events.Segmented)
    moved = (replace(scripted.segments()[0], end=3.5, human=True), *scripted.segments()[1:])
    progress.fold(events.Decided(Decision("move", 0, 3.5), moved))
    assert [skill.segment.end for skill in progress.skills] == [3.5, 8.0, 12.0]
    assert progress.decisions == [Decision("move", 0, 3.5)]


def test_report_is_the_json_contract() -> None:
    report = learn_report(folded(scripted.session()), "sessions/stack.mcap", 12.5)
    assert json.loads(json.dumps(report)) == report
    assert list(report) == ["session", "seed", "segments", "reproduced", "wall_s"]
    assert (report["session"], report["seed"], report["reproduced"]) == ("sessions/stack.mcap", 3, True)
    assert [segment["index"] for segment in report["segments"]] == [0, 1, 2]
    assert report["segments"][1]["formulations"][1] == {
        "relevant": ["hand", "blue"],
        "reference": "green",
        "actions": ["pose", "gripper"],
        "trials": 10,
        "updates": 2,
        "cost": 14.75,
        "success": {"successes": 19, "trials": 20, "low": 0.8, "high": 1.0, "stopped": ""},
        "accepted": True,
        "failed_of": [],
        "initiation": None,
    }


def test_report_says_what_failed_and_how_good_an_initiation_set_is() -> None:
    shortfall = events.Shortfall("blue", "position", "open", 20, 0.14, 0.2, "blue ends 140 mm off")
    evidence = events.Evidence(0, 20, 0.0, 0.16, 10, (40.0,), (41.0,), (shortfall,), scripted.POLICY)
    initiation = InitiationSet(
        ("hand", "blue"), "green", np.ones((4, 2, 7)),
        np.array([1.0, 1, 1, 0]), np.array([0.9, 0.8, 0.2, 0.6]), np.ones((2, 7)), np.eye(12), 1.5, 1.0, 0.5,
    )  # fmt: skip
    story = []
    for event in scripted.session():
        if isinstance(event, events.Reformulated):
            event = replace(event, evidence=evidence)
        if isinstance(event, events.OptionLearned) and event.segment == 1:
            event = replace(event, initiation=initiation, ends=20, ends_inside=19)
        story.append(event)
    report = learn_report(folded(story), "s.mcap", 1.0)
    assert json.loads(json.dumps(report)) == report
    given_up, accepted = report["segments"][1]["formulations"]
    assert given_up["initiation"] is None
    assert given_up["failed_of"] == [
        {"body": "blue", "term": "position", "grasp": "open", "starts": 20, "distance": 0.14, "angle": 0.2}
    ]
    assert accepted["failed_of"] == []
    assert accepted["initiation"] == {
        "trials": 4, "failures": 1, "precision": [2, 3], "recall": [2, 3], "ends": 20, "ends_inside": 19,
    }  # fmt: skip


def test_report_of_a_session_that_was_stopped_says_nothing_that_was_not_measured() -> None:
    report = learn_report(until(events.FormulationStarted), "s.mcap", 1.0)
    (formulation,) = report["segments"][0]["formulations"]
    assert formulation["cost"] is None
    assert formulation["success"] == {"successes": 0, "trials": 0, "low": 0.0, "high": 1.0, "stopped": ""}
    assert (formulation["accepted"], report["reproduced"]) == (False, False)
