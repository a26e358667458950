"""Algorithm 1: the order of formulations, the step back, and what is said when all fail."""

import pytest

from imitate.events import FormulationStarted, OptionLearned, Reformulated
from imitate.learning import reformulate
from imitate.learning.improve import Learned
from imitate.learning.option import Success
from imitate.learning.reformulate import learn_options, statements
from imitate.record import Start
from imitate.settings import load_settings
from imitate.skill import Abstraction, Candidate, Segment

HAND = Abstraction(("hand",), "cubeA")
CARRY = Abstraction(("hand", "cubeA"), "cubeB")
OTHER = Abstraction(("hand",), "cubeB")


def test_each_abstraction_is_tried_without_and_with_the_gripper():
    ranked = (Candidate(CARRY, -1.0), Candidate(OTHER, -20.0), Candidate(HAND, -500.0))
    assert statements(Segment(0, 1, CARRY, ranked), 50.0) == [
        (CARRY, ("pose",)),
        (CARRY, ("pose", "gripper")),
        (OTHER, ("pose",)),
        (OTHER, ("pose", "gripper")),
    ]


def test_the_operators_choice_comes_first_however_unlikely():
    ranked = (Candidate(CARRY, -1.0), Candidate(OTHER, -20.0))
    first = statements(Segment(0, 1, HAND, ranked), 50.0)[0]
    assert first == (HAND, ("pose",))


class FakeTrials:
    """Settings alone: no trial is run."""

    def __init__(self, formulations=12):
        self.settings = load_settings(None, {"learning": {"formulations": formulations}})


@pytest.fixture
def scripted(monkeypatch, stacking):
    """Runs the search with formulations that succeed or fail, in their order, as a script says."""
    demonstration, segments = stacking

    def run(script, formulations=12):
        outcomes = iter(script)

        class Scripted:
            def __init__(self, problem, *_):
                self.problem = problem

            def run(self, _):
                ok = next(outcomes)
                success = Success(20 if ok else 0, 20)
                why = "" if ok else "cubeA ends 140 mm from where it was shown"
                return Learned(self.problem.imitated, 1.0, success, float(ok), ok, why)
                yield

        monkeypatch.setattr(reformulate, "Improvement", Scripted)
        seen = []
        course = learn_options(
            demonstration, segments, FakeTrials(formulations), Start([0.0], [[0.0] * 7]), 0
        )
        while True:
            try:
                seen.append(next(course))
            except StopIteration as end:
                return seen, end.value

    return run


def stated(seen):
    return [
        (e.formulation.segment, e.formulation.index, len(e.formulation.actions))
        for e in seen
        if isinstance(e, FormulationStarted)
    ]


def test_the_gripper_is_added_when_the_hands_path_alone_fails(scripted):
    seen, search = scripted([False, True, True])
    assert stated(seen) == [(0, 0, 1), (0, 1, 2), (1, 0, 1)]
    (reason,) = [e.reason for e in seen if isinstance(e, Reformulated)]
    assert reason.startswith("cubeA did not follow the hand (0 of 20 starts succeeded")
    assert reason.endswith("adding the gripper's force to the actions")
    assert len(search.options) == 2
    assert not search.given_up


def test_when_nothing_is_left_the_search_goes_back_a_segment(scripted):
    # Carry learned without the gripper, retreat fails both ways; the carry's next formulation mends it.
    seen, search = scripted([True, False, False, True, True])
    assert stated(seen) == [(0, 0, 1), (1, 0, 1), (1, 1, 2), (0, 1, 2), (1, 2, 1)]
    reasons = [e.reason for e in seen if isinstance(e, Reformulated)]
    assert "going back to skill 1, ⟨{hand, cubeA}, cubeB⟩" in reasons[-1]
    assert [e.segment for e in seen if isinstance(e, OptionLearned)] == [0, 0, 1]
    assert [o.problem.formulation.segment for o in search.options] == [0, 1]


def test_giving_up_names_the_skill_and_what_was_tried(scripted):
    _, search = scripted([False] * 12)
    assert search.options == ()
    assert search.given_up == (
        "skill 1, ⟨{hand, cubeA}, cubeB⟩, is not learned: every formulation was tried. Tried: "
        "⟨{hand, cubeA}, cubeB⟩ with pose: 0 of 20 (cubeA ends 140 mm from where it was shown); "
        "⟨{hand, cubeA}, cubeB⟩ with pose + gripper: 0 of 20 (cubeA ends 140 mm from where it was shown)."
    )


def test_the_search_is_bounded(scripted):
    seen, search = scripted([True, False, False], formulations=3)
    assert len(stated(seen)) == 3
    assert "skill 2" in search.given_up
    assert "the limit of 3 formulations is reached" in search.given_up
