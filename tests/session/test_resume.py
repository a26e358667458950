"""Resume: a session that was cut ends as it would have ended, and nothing is ever at risk."""

from __future__ import annotations

import shutil
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from mcap.reader import make_reader
from refiled import cut, messages, written

from imitate.errors import FileError, SceneError
from imitate.events import Decided, Event, SessionFinished, SessionStarted, Skipped, TrialFinished
from imitate.formats.session_log import SessionReader, read_session, summarise
from imitate.formats.session_writer import SessionWriter
from imitate.learning.trials import executors
from imitate.session import resume as room
from imitate.session.replay import replay
from imitate.session.rerun import rerun
from imitate.session.resume import Resumption, resume
from imitate.session.session import Request, run
from imitate.settings import load_settings
from imitate.skill import Decision
from imitate.world.engine import data_path
from imitate.world.robot import description_of
from imitate.world.trial import Simulator

HERE = executors(0)
FEW = {"evaluation_starts": 1, "reproduction_starts": 1, "candidates": 1, "candidate_starts": 1}


def resumed(path: Path, should_stop: Callable[[], bool] = lambda: False) -> list[Event]:
    return list(resume(Resumption(path, HERE), should_stop))


@contextmanager
def counted(monkeypatch: pytest.MonkeyPatch) -> Iterator[list[int]]:
    """The steps of each trial that is simulated meanwhile."""
    simulated: list[int] = []
    plain = Simulator.run

    def run_counted(*args, **kwargs):
        outcome = plain(*args, **kwargs)
        simulated.append(outcome.record.steps)
        return outcome

    with monkeypatch.context() as patch:
        patch.setattr(Simulator, "run", run_counted)
        yield simulated


def test_a_cut_session_ends_equal_and_simulates_only_what_is_missing(easy, tmp_path, monkeypatch):
    path = cut(easy, tmp_path / "cut.mcap", 0.6)
    (tmp_path / ".cut.mcap.part").write_bytes(b"what an earlier resume left when it was killed")
    kept = summarise(path).trials
    with counted(monkeypatch) as simulated:
        events = resumed(path)
    assert messages(path) == messages(easy)
    assert summarise(path).complete
    assert 0 < len(simulated) == 4 - kept < 4
    assert isinstance(events[-1], SessionFinished)
    assert [p.name for p in tmp_path.iterdir()] == ["cut.mcap"]


@pytest.mark.slow
@pytest.mark.parametrize("share", [0.15, 0.5, 0.8, 0.999])
def test_cut_anywhere_a_longer_session_ends_equal(hard, tmp_path, monkeypatch, share):
    path = cut(hard, tmp_path / "cut.mcap", share)
    kept = summarise(path).trials
    with counted(monkeypatch) as simulated:
        resumed(path)
    assert messages(path) == messages(hard)
    assert len(simulated) == 8 - kept


@pytest.mark.slow
def test_with_two_workers_it_ends_equal_too(easy, tmp_path):
    path = cut(easy, tmp_path / "cut.mcap", 0.4)
    list(resume(Resumption(path, executors(2))))
    assert messages(path) == messages(easy)


@pytest.mark.slow
def test_one_that_was_stopped_well_is_gone_on_with(easy, tmp_path):
    events = list(read_session(easy))
    path = written(tmp_path / "stopped.mcap", events[:5])
    resumed(path)
    assert messages(path) == messages(easy)


def test_one_that_has_ended_is_left_alone(easy, tmp_path):
    path = tmp_path / "whole.mcap"
    path.write_bytes(easy.read_bytes())
    before = path.stat()
    assert resumed(path) == []
    assert (path.stat().st_mtime_ns, path.stat().st_ino) == (before.st_mtime_ns, before.st_ino)


def test_the_operators_decisions_are_kept(source, tmp_path):
    settings = load_settings(None, {"learning": FEW})
    decisions = (Decision("split", 0, 2.0), Decision("move", 0, 2.2))
    seen: list[Event] = []

    def two_trials() -> bool:
        return sum(isinstance(event, TrialFinished) for event in seen) == 2

    log = tmp_path / "decided.mcap"
    for event in run(Request(source, settings, 3, 0, decisions, log=log), two_trials):
        seen.append(event)
    expected = messages(log)
    path = cut(log, tmp_path / "cut.mcap", 0.5)
    assert summarise(path).trials < 2
    again: list[Event] = []
    for event in resume(
        Resumption(path, HERE), lambda: sum(isinstance(e, TrialFinished) for e in again) == 2
    ):
        again.append(event)
    assert [e.decision for e in again if isinstance(e, Decided)] == list(decisions)
    assert messages(path) == expected


def test_what_does_not_come_out_again_is_refused_and_left_alone(easy, tmp_path):
    events = [
        replace(e, cost=replace(e.cost, terminal=0.5))
        if isinstance(e, TrialFinished) and e.purpose == "choose"
        else e
        for e in read_session(easy)
    ]
    path = written(tmp_path / "s.mcap", events[:-1])
    before = path.read_bytes()
    with pytest.raises(
        FileError, match=r"does not come out again.*TrialFinished\.cost\.terminal is 0\.5 and"
    ):
        resumed(path)
    assert path.read_bytes() == before
    assert [p.name for p in tmp_path.iterdir()] == ["s.mcap"]


def test_another_imitate_is_named_where_it_may_be_the_cause(easy, tmp_path):
    def elsewhere(event: Event) -> Event:
        if isinstance(event, SessionStarted):
            return replace(event, seed=4, versions={**event.versions, "pybullet": "3.0.0"})
        return event

    events = [elsewhere(e) for e in read_session(easy)]
    path = written(tmp_path / "s.mcap", events[:-1])
    with pytest.raises(FileError, match=r"recorded with pybullet 3\.0\.0, replayed with"):
        resumed(path)


def test_trials_recorded_without_steps_are_simulated_and_stay_without(easy, tmp_path):
    events = list(read_session(easy))
    whole = written(tmp_path / "whole.mcap", events, steps=False)
    path = written(tmp_path / "stopped.mcap", events[:5], steps=False)
    assert rerun(path, HERE).first_divergence is None
    resumed(path)
    assert messages(path) == messages(whole)


def test_steps_lost_with_a_damaged_chunk_are_there_again(easy, tmp_path):
    with easy.open("rb") as stream:
        summary = make_reader(stream).get_summary()
    (steps,) = [c.id for c in summary.channels.values() if c.topic == "/imitate/trial_steps"]
    chunk = [c for c in summary.chunk_indexes if steps in c.message_index_offsets][1]
    data = bytearray(easy.read_bytes())
    data[chunk.chunk_start_offset + chunk.chunk_length // 2] ^= 1
    path = tmp_path / "s.mcap"
    path.write_bytes(data[: int(len(data) * 0.97)])
    assert sum(e.record is None for e in read_session(path) if isinstance(e, TrialFinished)) == 1
    resumed(path)
    assert messages(path) == messages(easy)


def test_stopped_before_the_log_is_told_again_the_old_one_stays(easy, tmp_path):
    path = cut(easy, tmp_path / "cut.mcap", 0.6)
    before = path.read_bytes()
    resumed(path, lambda: True)
    assert path.read_bytes() == before
    assert [p.name for p in tmp_path.iterdir()] == ["cut.mcap"]


def test_stopped_later_nothing_of_the_old_one_is_missing(easy, tmp_path):
    path = cut(easy, tmp_path / "cut.mcap", 0.5)
    kept, seen = summarise(path).trials, []
    for event in resume(
        Resumption(path, HERE), lambda: sum(isinstance(e, TrialFinished) for e in seen) > kept
    ):
        seen.append(event)
    assert summarise(path).trials == kept + 1
    assert SessionReader(path).damage == []
    assert messages(path) == messages(easy)[: len(messages(path))]


def test_a_session_that_is_being_written_is_refused(easy, tmp_path):
    path = tmp_path / "s.mcap"
    with SessionWriter(path) as log:
        for event in list(read_session(easy))[:4]:
            log.write(event)
        with pytest.raises(FileError, match=r"s.mcap: is being written by another process\. Wait"):
            resumed(path)
    stream = resume(Resumption(path, HERE))
    next(stream)
    with pytest.raises(FileError, match=r"is being written by another process"):
        resumed(path)
    stream.close()


def test_a_trial_that_stopped_blind_is_told_from_one_that_ended_unseen(easy):
    (trial, *_) = [e for e in read_session(easy) if isinstance(e, TrialFinished)]
    record = trial.record
    assert not room._stopped_blind(record)
    one = replace(record, commands=record.commands[:1], joint_positions=np.zeros((4, 9)))
    assert room._stopped_blind(one)


@pytest.mark.slow
def test_a_session_whose_trials_were_watched_is_resumed_and_replayed(source, tmp_path):
    learning = FEW | {"near": 1.0, "near_angle": 180.0, "observe_trials": True}
    log = tmp_path / "watched.mcap"
    for _ in run(Request(source, load_settings(None, {"learning": learning}), 3, 0, log=log)):
        pass
    assert replay(log, depth="policy").divergent == 0
    assert rerun(log, HERE).divergent == 0
    path = cut(log, tmp_path / "cut.mcap", 0.6)
    resumed(path)
    assert messages(path) == messages(log)


@pytest.mark.slow
def test_with_a_robot_of_ones_own_that_has_moved(source, tmp_path):
    arm, moved = tmp_path / "arm", tmp_path / "moved"
    shutil.copytree(data_path() / "franka_panda", arm)
    text = description_of("panda").replace("franka_panda/panda.urdf", "panda.urdf")
    (arm / "mine.toml").write_text(text)
    learning = FEW | {"near": 1.0, "near_angle": 180.0}
    settings = load_settings(None, {"learning": learning, "world": {"robot": str(arm / "mine.toml")}})
    log = tmp_path / "mine.mcap"
    for _ in run(Request(source, settings, 3, 0, log=log)):
        pass
    path = cut(log, tmp_path / "cut.mcap", 0.6)
    shutil.move(arm, moved)
    with pytest.raises(SceneError, match="the recorded robot is not here"):
        resumed(path)
    robot = str(moved / "mine.toml")
    assert rerun(log, HERE, robot).divergent == 0
    list(resume(Resumption(path, HERE, robot)))
    assert messages(path) == messages(log)


def test_what_was_skipped_stays_so_and_what_comes_after_the_end_is_asked(skipped, tmp_path):
    events = list(read_session(skipped))
    at = next(k for k, e in enumerate(events) if isinstance(e, Skipped))
    begun = written(tmp_path / "begun.mcap", events[: at + 1])
    again = list(resume(Resumption(begun, HERE), skip=lambda *_: True))  # the next one, too
    assert [e.formulation for e in again if isinstance(e, Skipped)] == [0, 1]
    assert [e.formulation for e in read_session(begun) if isinstance(e, Skipped)] == [0, 1]
    before = written(tmp_path / "before.mcap", events[:at])
    assert not [e for e in resumed(before) if isinstance(e, Skipped)]
