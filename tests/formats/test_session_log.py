"""The session's log: events come back as they went in, whatever happens to the process or the file."""

import os
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import recorded
import scripted
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from mcap.reader import NonSeekingReader, make_reader
from recorded import same
from records import still

from imitate import events
from imitate.errors import FileError, ImitateError
from imitate.events import Event, TrialFinished
from imitate.formats import session_log, session_writer
from imitate.formats.kind import kind_of
from imitate.formats.mcap_contents import contents
from imitate.formats.mcap_file import McapReader
from imitate.formats.session_log import SessionReader, read_session, summarise
from imitate.formats.session_writer import SessionWriter
from imitate.record import Sightings
from imitate.skill import Decision, Grasp, InitiationSet, Miss


def written(path: Path, story: list[Event]) -> Path:
    with SessionWriter(path) as log:
        for event in story:
            log.write(event)
    return path


@pytest.fixture(scope="module")
def story() -> list[Event]:
    events_ = list(recorded.session())
    decision = events.Decided(Decision("relabel", 1, 0.5, scripted.REACH), scripted.segments())
    return [*events_[:2], decision, *events_[2:]]


@pytest.fixture(scope="module")
def session(tmp_path_factory: pytest.TempPathFactory, story: list[Event]) -> Path:
    return written(tmp_path_factory.mktemp("log") / "stack.mcap", story)


def test_every_event_comes_back_bit_for_bit(session: Path, story: list[Event]) -> None:
    read = list(read_session(session))
    assert len(read) == len(story)
    for before, after in zip(story, read, strict=True):
        assert same(before, after), type(before).__name__


def test_records_may_be_left_out(session: Path, story: list[Event]) -> None:
    for before, after in zip(story, read_session(session, steps=False), strict=True):
        if isinstance(before, TrialFinished):
            before = replace(before, record=None)
        assert same(before, after)


def test_odd_numbers_survive(tmp_path: Path) -> None:
    terms = replace(scripted.trial(0, 0, 0, "explore", 0, 1.0, "").cost, terminal=-0.0, acceleration=np.nan)
    nan = np.frombuffer(np.uint64(0x7FF8_0000_0000_1234).tobytes(), np.float64)
    policy = replace(scripted.POLICY, gripper_weights=np.array([-0.0, np.inf, nan[0], 5e-324]))
    trial = replace(scripted.trial(0, 0, 0, "explore", 0, 1.0, "π < 0"), cost=terms, policies=(policy,))
    read = list(read_session(written(tmp_path / "s.mcap", [scripted.started(), trial])))[1]
    assert isinstance(read, TrialFinished)
    assert same(read.policies, trial.policies)
    assert str(read.cost) == str(terms)
    assert np.signbit(read.cost.terminal)


def test_what_was_found_of_a_formulation_comes_back(tmp_path: Path) -> None:
    grasp = Grasp("slipped", 3.2, 5.1, 0.04)
    misses = (Miss("position", "blue ends 90 mm off", "blue", 0.09, 0.1, grasp), Miss("reach", "too far"))
    shortfall = events.Shortfall("blue", "position", "slipped", 20, 0.09, 0.1, "blue ends 90 mm off")
    evidence = events.Evidence(
        0, 20, 0.0, 0.16, 15, (26.0, 25.5), (30.0, 29.0), (shortfall,), scripted.POLICY
    )
    initiation = InitiationSet(
        ("hand", "blue"), "green", np.ones((3, 2, 7)), np.array([1.0, 0, 1]), np.array([0.5, 0.4, -0.0]),
        np.ones((2, 7)), np.eye(12), 1.5, 1.0, 0.5,
    )  # fmt: skip
    story: list[Event] = [
        scripted.started(),
        replace(scripted.trial(1, 0, 0, "evaluate", 0, 1.0, "far"), misses=misses),
        events.Reformulated(1, 0, "why", evidence),
        events.OptionLearned(1, 1, scripted.POLICY, initiation, 20, 19),
        events.Reproduced(1, 2, 0.1, 0.9, False, 1, 1),
        events.SessionFinished(False, "advice", events.Kept(1, 0, 3, 20)),
    ]
    read = list(read_session(written(tmp_path / "s.mcap", story)))
    assert all(same(before, after) for before, after in zip(story, read, strict=True))


@pytest.mark.parametrize("opening", [None, np.full(361, 0.0625), np.full(361, np.nan)])
def test_the_hands_opening_survives(tmp_path: Path, opening: np.ndarray | None) -> None:
    started = scripted.started()
    started = replace(started, demonstration=replace(started.demonstration, opening=opening))
    (read,) = read_session(written(tmp_path / "s.mcap", [started]))
    assert same(read, started)


def test_what_was_seen_of_a_trial_survives(tmp_path: Path) -> None:
    poses = np.arange(42.0).reshape(3, 2, 7)
    poses[1, 0] = np.nan
    seen = Sightings(poses[0], (0, 30, 40), poses)
    watched = replace(scripted.trial(0, 0, 0, "explore", 0, 1.0, ""), record=recorded.record(), seen=seen)
    alone = replace(watched, trial=1, seen=None)
    none, some = (events.Reproduced(0, 2, 0.0, 0.7, False, really=really) for really in (None, 0))
    story = [scripted.started(), watched, alone, none, some]
    read = list(read_session(written(tmp_path / "s.mcap", story)))
    assert all(same(before, after) for before, after in zip(story, read, strict=True))
    assert isinstance(read[1], TrialFinished)
    assert same(read[1].believed, watched.believed)


def test_the_same_session_gives_the_same_bytes(tmp_path: Path, session: Path, story: list[Event]) -> None:
    assert written(tmp_path / "again.mcap", story).read_bytes() == session.read_bytes()


def test_one_clock_of_simulated_time(session: Path) -> None:
    times = [message.time for message in McapReader(session).messages()]
    assert times[0] == 0
    steps = sum(e.record.steps for e in read_session(session) if isinstance(e, TrialFinished) and e.record)
    assert times[-1] == pytest.approx((12 + steps / 240) * 1e9, abs=1000)
    own = [m.time for m in McapReader(session).messages() if m.topic.startswith("/imitate/")]
    assert own == sorted(own)
    assert times == sorted(times)


def test_a_session_is_never_overwritten_unasked(session: Path) -> None:
    before = session.read_bytes()
    with pytest.raises(FileError, match=r"stack.mcap: exists already\. .*--force"):
        SessionWriter(session)
    assert session.read_bytes() == before


def test_a_folder_that_cannot_be_made(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    with pytest.raises(FileError, match="its folder cannot be made"):
        SessionWriter(tmp_path / "file" / "s.mcap")


def test_force_starts_anew(tmp_path: Path) -> None:
    path = tmp_path / "s.mcap"
    path.write_text("something else")
    with SessionWriter(path, force=True) as log:
        log.write(scripted.started())
    assert [type(event).__name__ for event in read_session(path)] == ["SessionStarted"]


def test_a_session_begins_with_its_start(tmp_path: Path) -> None:
    with SessionWriter(tmp_path / "s.mcap") as log, pytest.raises(ValueError, match="first event"):
        log.write(scripted.trial(0, 0, 0, "explore", 0, 1.0, ""))


def test_summary(session: Path, tmp_path: Path) -> None:
    summary = summarise(session)
    assert summary.complete
    assert summarise(session).complete
    assert summary.trials == 130
    assert summary.events["Decided"] == 1
    assert kind_of(session) == "session"
    half = written(tmp_path / "half.mcap", list(recorded.session())[:20])
    assert not summarise(half).complete
    assert kind_of(half) == "session"


KILLED = """
import os, sys, recorded
from imitate.formats.session_writer import SessionWriter
log = SessionWriter(sys.argv[1])
for count, event in enumerate(recorded.session()):
    log.write(event)
    if count == int(sys.argv[2]):
        os.kill(os.getpid(), 9)
"""


@pytest.mark.parametrize("last", [2, 5, 40])
def test_everything_flushed_survives_kill_9(tmp_path: Path, last: int) -> None:
    path = tmp_path / "killed.mcap"
    tests = str(Path(__file__).parents[1])
    run = subprocess.run(
        [sys.executable, "-c", f"import sys; sys.path.insert(0, {tests!r}){KILLED}", str(path), str(last)],
        check=False,
    )
    assert run.returncode == -9
    expected = list(recorded.session())[: last + 1]
    while not isinstance(expected[-1], session_writer._FLUSHED):
        expected.pop()
    reader = SessionReader(path)
    read = list(reader.events())
    assert len(read) == len(expected)
    assert all(same(a, b) for a, b in zip(expected, read, strict=True))
    assert reader.damage == [f"cut at byte {path.stat().st_size:,}: the end of the file is missing"]
    assert not summarise(path).complete
    assert kind_of(path) == "session"


def test_a_cut_file_gives_whole_trials(tmp_path: Path, session: Path, story: list[Event]) -> None:
    whole = session.read_bytes()
    counts = []
    for size in np.linspace(20_000, len(whole) - 1, 12, dtype=int).tolist():
        path = tmp_path / "cut.mcap"
        path.write_bytes(whole[:size])
        reader = SessionReader(path)
        read = list(reader.events())
        assert all(same(a, b) for a, b in zip(story, read, strict=False))
        assert reader.damage
        counts.append(len(read))
    assert counts == sorted(counts)
    assert counts[-1] == len(story)


def test_a_damaged_chunk_is_named_and_the_rest_read(
    tmp_path: Path, session: Path, story: list[Event]
) -> None:
    with session.open("rb") as stream:
        summary = make_reader(stream).get_summary()
    assert summary
    steps = {c.id for c in summary.channels.values() if c.topic in ("/tf", "/imitate/trial_steps")}
    chunks = [chunk for chunk in summary.chunk_indexes if set(chunk.message_index_offsets) == steps]
    chunk = chunks[len(chunks) // 2]
    data = bytearray(session.read_bytes())
    data[chunk.chunk_start_offset + chunk.chunk_length // 2] ^= 0x10
    path = tmp_path / "flipped.mcap"
    path.write_bytes(data)
    reader = SessionReader(path)
    read = list(reader.events())
    lost = [after for before, after in zip(story, read, strict=True) if not same(before, after)]
    assert len(lost) == 1
    assert isinstance(lost[0], TrialFinished)
    assert lost[0].record is None
    assert len(reader.damage) == 1
    assert reader.damage[0].startswith("a damaged chunk that ends at byte ")


def test_a_newer_schema_is_refused_by_name(session: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(session_log, "SCHEMA", 0)
    message = (
        r"stack.mcap: is a session of schema 1, written by imitate 0.1.0; imitate .* reads up to schema 0\."
    )
    with pytest.raises(FileError, match=message):
        next(read_session(session))
    with pytest.raises(FileError, match=message):
        summarise(session)


def test_a_demonstration_is_no_session(tmp_path: Path) -> None:
    from imitate.formats.demonstrations import write_demonstration

    write_demonstration(scripted.demonstration(), tmp_path / "demo.mcap")
    with pytest.raises(FileError, match=r"demo.mcap: is not a session of imitate\. `imitate info` says"):
        list(read_session(tmp_path / "demo.mcap"))


def test_peoples_tools_find_their_topics(session: Path, story: list[Event]) -> None:
    topics = contents(session).topics
    trials = [event for event in story if isinstance(event, TrialFinished)]
    assert topics["/costs"] == ("std_msgs/msg/Float64MultiArray", len(trials))
    assert topics["/tf"][0] == "foxglove.FrameTransforms"
    assert topics["/tf"][1] == sum(-(-t.record.steps // 8) for t in trials if t.record)
    assert topics["/demonstration/hand"] == ("foxglove.PoseInFrame", 361)
    assert topics["/demonstration/objects/blue"] == ("foxglove.PoseInFrame", 361)


def sharing(count: int) -> list[Event]:
    """Trials that differ only after their second option starts."""
    first = recorded.record(400, seed=7)
    trials = []
    for number in range(count):
        velocities = np.array(first.joint_velocities)
        velocities[200:] += number
        record = replace(first, joint_velocities=velocities)
        trials.append(replace(scripted.trial(1, 0, number, "evaluate", 0, 1.0, ""), record=record))
    return [scripted.started(), *trials]


def test_what_trials_have_in_common_is_stored_once(tmp_path: Path) -> None:
    story = sharing(6)
    one = written(tmp_path / "one.mcap", story[:2]).stat().st_size
    two = written(tmp_path / "two.mcap", story[:3]).stat().st_size
    six = written(tmp_path / "six.mcap", story)
    bare = written(tmp_path / "bare.mcap", story[:1]).stat().st_size
    assert two - one < 0.7 * (one - bare)
    assert all(same(before, after) for before, after in zip(story, read_session(six), strict=True))


def test_trials_that_share_lost_steps_lose_them_too_and_say_so(tmp_path: Path) -> None:
    path = written(tmp_path / "s.mcap", sharing(3))
    with path.open("rb") as stream:
        summary = make_reader(stream).get_summary()
    assert summary is not None
    steps = next(key for key, channel in summary.channels.items() if channel.topic == "/imitate/trial_steps")
    first = next(chunk for chunk in summary.chunk_indexes if steps in chunk.message_index_offsets)
    data = bytearray(path.read_bytes())
    data[first.chunk_start_offset + first.chunk_length // 2] ^= 0xFF
    path.write_bytes(data)
    reader = SessionReader(path)
    trials = [event for event in reader.events() if isinstance(event, TrialFinished)]
    assert [trial.record for trial in trials] == [None, None, None]
    assert reader.damage[0].startswith("a damaged chunk")
    assert reader.damage[1:] == [f"the steps of trial {n} of segment 1 are missing" for n in (1, 2)]


@settings(max_examples=100, suppress_health_check=[HealthCheck.function_scoped_fixture], deadline=None)
@given(data=st.data())
def test_damage_is_always_explained(tmp_path: Path, data: st.DataObject) -> None:
    whole = tmp_path / "whole.mcap"
    if not whole.exists():
        written(whole, sharing(2))
    changed = bytearray(whole.read_bytes())
    for _ in range(data.draw(st.integers(1, 3))):
        changed[data.draw(st.integers(0, len(changed) - 1))] = data.draw(st.integers(0, 255))
    changed = changed[: data.draw(st.integers(len(changed) // 2, len(changed)))]
    path = tmp_path / "damaged.mcap"
    path.write_bytes(changed)
    for read in (summarise, lambda path: list(read_session(path)), kind_of):
        try:
            read(path)
        except ImitateError as error:
            assert str(error).startswith(str(path))


FULL = """
import resource, sys, recorded
from imitate.errors import FileError
from imitate.formats.session_writer import SessionWriter
resource.setrlimit(resource.RLIMIT_FSIZE, (int(sys.argv[2]), int(sys.argv[2])))
try:
    with SessionWriter(sys.argv[1]) as log:
        for event in recorded.session():
            log.write(event)
except FileError as error:
    print(error)
"""


def filled(path: Path, room: int) -> str:
    """What is said when a session outgrows ``room`` bytes."""
    tests = str(Path(__file__).parents[1])
    code = f"import sys; sys.path.insert(0, {tests!r}){FULL}"
    command = [sys.executable, "-c", code, str(path), str(room)]
    return subprocess.run(command, capture_output=True, text=True, check=True).stdout


def test_a_full_disk_is_said_and_costs_no_flushed_trial(tmp_path: Path) -> None:
    path = tmp_path / "full.mcap"
    assert filled(path, 300_000) == (
        f"{path}: cannot be written any more (File too large). Every trial before is in it. "
        f"Make room, and go on: imitate resume {path}\n"
    )
    reader = SessionReader(path)
    read = list(reader.events())
    assert len(read) > 10
    assert all(same(before, after) for before, after in zip(recorded.session(), read, strict=False))
    assert reader.damage == []
    with path.open("rb") as stream:
        trials = sum(1 for _ in NonSeekingReader(stream).iter_messages(["/imitate/trial_finished"]))
    assert trials == sum(isinstance(event, TrialFinished) for event in read)


def test_a_disk_that_is_full_from_the_start_is_left_without_a_file(tmp_path: Path) -> None:
    path = tmp_path / "full.mcap"
    said = filled(path, 1000)
    assert said == f"{path}: cannot be written any more (File too large). Choose another place.\n"
    assert not path.exists()


def test_interrupted_amid_a_message_it_is_whole_up_to_the_one_before(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path, written_before = tmp_path / "s.mcap", list(recorded.session())[:6]
    plain = os.write

    def interrupted(file: int, data: bytes) -> int:
        monkeypatch.setattr(os, "write", plain)
        plain(file, data[:100])
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt), SessionWriter(path) as log:
        for event in written_before:
            log.write(event)
        monkeypatch.setattr(os, "write", interrupted)
        log.write(replace(scripted.trial(0, 0, 9, "explore", 0, 1.0, ""), record=recorded.record()))
    reader = SessionReader(path)
    read = list(reader.events())
    assert reader.damage == []
    assert len(read) == 6
    assert all(same(a, b) for a, b in zip(written_before, read, strict=True))


def test_a_session_that_is_being_written_is_not_replaced(tmp_path: Path) -> None:
    path = tmp_path / "s.mcap"
    with SessionWriter(path) as log:
        log.write(scripted.started())
        with pytest.raises(FileError, match=r"s.mcap: is being written by another process\. Wait until"):
            SessionWriter(path, force=True)
    assert len(list(read_session(path))) == 1
    SessionWriter(path, force=True).close()


def test_a_lock_ends_with_its_process(tmp_path: Path) -> None:
    path = tmp_path / "killed.mcap"
    code = f"import sys; sys.path.insert(0, {str(Path(__file__).parents[1])!r}){KILLED}"
    subprocess.run([sys.executable, "-c", code, str(path), "5"], check=False)
    SessionWriter(path, force=True).close()


@pytest.mark.skipif(not Path("/sys").is_dir(), reason="needs a folder in which even root makes no files")
def test_a_folder_that_is_read_only() -> None:
    with pytest.raises(FileError, match=r"/sys/s.mcap: cannot be written \("):
        SessionWriter("/sys/s.mcap")


def test_without_steps_the_trials_are_kept_on_the_same_clock(tmp_path):
    record = still(scripted.demonstration())
    told = [replace(e, record=record) if isinstance(e, TrialFinished) else e for e in scripted.session()]
    for name, steps in (("all", True), ("few", False)):
        with SessionWriter(tmp_path / f"{name}.mcap", steps=steps) as log:
            for event in told:
                log.write(event)
    few = list(read_session(tmp_path / "few.mcap"))
    assert len(few) == len(told)
    assert all(
        same(a, replace(b, record=None) if isinstance(b, TrialFinished) else b)
        for a, b in zip(few, told, strict=True)
    )
    whole, small = (summarise(tmp_path / f"{name}.mcap") for name in ("all", "few"))
    assert (small.seconds, small.trials) == (whole.seconds, whole.trials)
    assert small.seconds > record.steps * record.time_step * small.trials
