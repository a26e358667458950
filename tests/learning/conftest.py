"""Problems from the person's carry."""

import pytest
from records import still

from imitate.learning.problem import formulate
from imitate.segmentation import segment
from imitate.settings import Settings
from imitate.skill import Abstraction, Formulation, Segment

SETTINGS = Settings()


@pytest.fixture(scope="session")
def stacking(short_demonstration):
    """The person's carry with a retreat imagined after it: segments by hand, the demonstration as it is."""
    end = short_demonstration.duration
    carry = Abstraction(("hand", "cubeA"), "cubeB")
    retreat = Abstraction(("hand",), "cubeA")
    return short_demonstration, (Segment(0.0, end - 0.5, carry), Segment(end - 0.5, end, retreat))


@pytest.fixture(scope="session")
def carry_problem(short_demonstration):
    """The carry alone, as the last skill."""
    segments = segment(short_demonstration, SETTINGS.segmentation)
    i = next(i for i, s in enumerate(segments) if s.abstraction.carried)
    formulation = Formulation(i, 0, segments[i].abstraction, ("pose", "gripper"), "")
    return formulate(short_demonstration, segments, formulation, SETTINGS)


@pytest.fixture(scope="session")
def perfect(short_demonstration):
    """A record of 2 s in which everything stands where the demonstration ends, the gripper open."""
    return still(short_demonstration)
