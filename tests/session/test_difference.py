"""What two sessions differ in: each kind of change is found at its topic, message and field."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import recorded
from refiled import cut, flipped, messages, written

from imitate.errors import FileError
from imitate.events import Decided, Event, Segmented, TrialFinished
from imitate.session.difference import Setting, Topic, difference
from imitate.skill import Decision

Change = Callable[[Event], Event]


@pytest.fixture(scope="module")
def session(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return written(tmp_path_factory.mktemp("sessions") / "a.mcap", recorded.session())


def changed(path: Path, number: int, change: Change) -> Path:
    """The same session with one of its events changed."""
    return written(path, (change(e) if k == number else e for k, e in enumerate(recorded.session())))


def differing(first: Path, second: Path) -> list[Topic]:
    return [topic for topic in difference(first, second).topics if not topic.equal]


def test_every_message_of_equal_sessions_is_compared(session: Path, tmp_path: Path) -> None:
    found = difference(session, written(tmp_path / "b.mcap", recorded.session()))
    assert found.equal
    assert (found.settings, found.decisions) == ((), ((), ()))
    assert sum(topic.counts[0] for topic in found.topics) == len(messages(session))


def test_a_bit_of_a_step_is_found_at_its_trial_step_and_field(session: Path, tmp_path: Path) -> None:
    def nudge(event: Event) -> Event:
        assert isinstance(event, TrialFinished)
        assert event.record is not None
        positions = np.array(event.record.joint_positions)
        positions[7, 2] = np.nextafter(positions[7, 2], np.inf)
        return replace(event, record=replace(event.record, joint_positions=positions))

    number = next(
        k for k, e in enumerate(recorded.session()) if isinstance(e, TrialFinished) and e.trial == 2
    )
    (steps,) = differing(session, changed(tmp_path / "b.mcap", number, nudge))
    assert (steps.name, steps.number, steps.where) == ("/imitate/trial_steps", 2, (0, 0, 2))
    assert steps.difference is not None
    assert (steps.difference.field, steps.difference.step) == ("joint_positions[2]", 7)


def test_settings_and_decisions_are_listed(session: Path, tmp_path: Path) -> None:
    def settle(event: Event) -> Event:
        return replace(event, settings=event.settings.replace("alpha = 0.8", "alpha = 0.9"))  # type: ignore[union-attr, call-arg]

    events = [settle(e) if k == 0 else e for k, e in enumerate(recorded.session())]
    cuts = events[1]
    assert isinstance(cuts, Segmented)
    decision = Decision("move", 0, 4.5)
    other = written(tmp_path / "b.mcap", [*events[:2], Decided(decision, cuts.segments), *events[2:]])
    found = difference(session, other)
    assert found.settings == (Setting("learning.alpha", 0.8, 0.9),)
    assert found.decisions == ((), (str(decision),))
    assert {topic.name for topic in found.topics if not topic.equal} >= {
        "/imitate/session_started", "/imitate/decided"
    }  # fmt: skip


@pytest.mark.parametrize(
    ("topic", "field"),
    [("/tf", "transforms.2.rotation.w"), ("/costs", "data.3"), ("/demonstration/hand", "pose.orientation.x")],
)
def test_what_is_kept_for_peoples_tools_is_compared_as_well(
    session: Path, tmp_path: Path, topic: str, field: str
) -> None:
    (found,) = differing(session, flipped(session, tmp_path / "b.mcap", topic, 3))
    assert (found.name, found.number) == (topic, 3)
    assert found.difference is not None
    assert found.difference.field == field


def test_of_a_cut_session_what_there_is_is_compared(session: Path, tmp_path: Path) -> None:
    found = difference(session, cut(session, tmp_path / "b.mcap", 0.6))
    assert not found.equal
    assert all(topic.difference is None for topic in found.topics)
    assert found.damage[0] == ()
    assert "the end of the file is missing" in found.damage[1][0]


def test_what_is_no_session_is_refused_by_name(session: Path, tmp_path: Path) -> None:
    with pytest.raises(FileError, match=r"none\.mcap: no such file"):
        difference(session, tmp_path / "none.mcap")
