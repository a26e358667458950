"""Wrong words of the operator, and how Algorithm 1 recovers from them: whole sessions in physics."""

from pathlib import Path

import pytest

from imitate.events import FormulationStarted, OptionLearned, Reformulated, Reproduced
from imitate.session.session import Request, run
from imitate.settings import load_settings
from imitate.skill import Abstraction, Decision

pytestmark = pytest.mark.slow
FIXTURE = Path(__file__).parents[2] / "fixtures" / "human_stack.npz"
REACH = Abstraction(("hand",), "cubeA")
CARRY = Abstraction(("hand", "cubeA"), "cubeB")
WRONG_CARRY = Abstraction(("hand", "cubeB"), "cubeA")
WRONG_REACH = Abstraction(("hand",), "cubeB")


def learned_with(segment, wrong, **learning):
    """The events of a session in which the operator relabelled a skill wrongly."""
    few = {"evaluation_starts": 10, "reproduction_starts": 10}
    settings = load_settings(None, {"learning": few | learning})
    decision = Decision("relabel", segment, abstraction=wrong)
    return list(run(Request(FIXTURE, settings, 0, workers=2, decisions=(decision,))))


def accepted(events):
    """Segment → the abstraction and the actions that its option was learned with in the end."""
    stated = {
        (f.segment, f.index): (f.abstraction, f.actions)
        for f in (e.formulation for e in events if isinstance(e, FormulationStarted))
    }
    return {e.segment: stated[e.segment, e.formulation] for e in events if isinstance(e, OptionLearned)}


def test_a_wrong_abstraction_gives_way_to_the_next_one():
    events = learned_with(1, WRONG_CARRY)
    reasons = [e.reason for e in events if isinstance(e, Reformulated)]
    assert any("trying the next abstraction, ⟨{hand, cubeA}, cubeB⟩" in reason for reason in reasons)
    assert accepted(events) == {0: (REACH, ("pose",)), 1: (CARRY, ("pose", "gripper"))}
    (done,) = [e for e in events if isinstance(e, Reproduced)]
    assert done.reproduced


def test_a_skill_that_ends_in_the_wrong_place_is_gone_back_to():
    # Reached in the other cube's frame, the cube to grasp is missed wherever it was moved by itself.
    events = learned_with(0, WRONG_REACH, shift=0.03)
    reasons = [e.reason for e in events if isinstance(e, Reformulated)]
    assert any("no formulation is left, going back to skill 1" in reason for reason in reasons)
    assert accepted(events) == {0: (REACH, ("pose",)), 1: (CARRY, ("pose", "gripper"))}
    (done,) = [e for e in events if isinstance(e, Reproduced)]
    assert done.reproduced
