"""What many tests share: the human demonstration, whole and short."""

from dataclasses import replace
from pathlib import Path

import hypothesis
import pytest

from imitate.demonstration import Demonstration, in_table_frame
from imitate.formats.demonstrations import read_demonstration

hypothesis.settings.register_profile("untimed", deadline=None)  # other work on the machine fails no test
hypothesis.settings.register_profile(  # a mutation run asks whether a test fails, not by how little
    "unshrunk",
    deadline=None,
    phases=set(hypothesis.Phase) - {hypothesis.Phase.shrink, hypothesis.Phase.explain},
)
hypothesis.settings.load_profile("untimed")

FIXTURES = Path(__file__).parents[1] / "fixtures"


@pytest.fixture(scope="session")
def human_stack() -> Demonstration:
    """The person's stacking as it was recorded: 13.6 s at 100 Hz."""
    return read_demonstration(FIXTURES / "human_stack.npz")


@pytest.fixture(scope="session")
def short_demonstration(human_stack: Demonstration) -> Demonstration:
    """Its last 5 s: grasp, carry and release, t from 0, in the table's frame."""
    late = human_stack.t > human_stack.t[-1] - 5.4
    d = human_stack
    return in_table_frame(replace(d, t=d.t[late], hand=d.hand[late], objects=d.objects[late]))
