"""A session from the person's carry, for real, but small."""

import json
import subprocess
import sys
from dataclasses import replace

import numpy as np
import pytest

from imitate import events
from imitate.errors import FileError, ImitateError, SceneError, UsageError
from imitate.formats.demonstrations import write_demonstration
from imitate.formats.session_log import read_session, summarise
from imitate.session.replay import replay
from imitate.session.session import Request, run
from imitate.settings import load_settings, to_toml
from imitate.skill import Decision

SMALL = load_settings(
    None,
    {
        "learning": {
            "evaluation_starts": 2,
            "reproduction_starts": 2,
            "candidate_starts": 1,
            "candidates": 1,
            "alpha": 0.5,
            "first_rollouts": 12,
            "updates": 1,
        }
    },
)


@pytest.fixture(scope="module")
def sessions(source, tmp_path_factory):
    """The same session with one worker and with two."""
    folder = tmp_path_factory.mktemp("sessions")
    made = {}
    for workers in (1, 2):
        log = folder / f"w{workers}.mcap"
        made[workers] = log, list(run(Request(source, SMALL, 3, workers, log=log)))
    return made


def messages(path):
    """Every decoded message in words that compare bit for bit."""
    return [repr_of(event) for event in read_session(path)]


def repr_of(value):
    if isinstance(value, np.ndarray):
        return value.shape, value.tobytes()
    if hasattr(value, "__dataclass_fields__"):
        return type(value).__name__, [repr_of(getattr(value, f)) for f in value.__dataclass_fields__]
    if isinstance(value, dict):
        return sorted(value.items())
    if isinstance(value, tuple):
        return [repr_of(v) for v in value]
    return repr(value)


def test_any_number_of_workers_gives_the_same_messages(sessions):
    one, two = messages(sessions[1][0]), messages(sessions[2][0])
    assert one == two


def test_the_log_holds_the_events_as_they_were_seen(sessions):
    log, seen = sessions[1]
    assert messages(log) == [repr_of(event) for event in seen]


def test_the_carry_fails_without_the_gripper_and_is_restated_with_it(sessions):
    _, seen = sessions[1]
    first, second = [e.formulation.actions for e in seen if isinstance(e, events.FormulationStarted)][:2]
    assert (first, second) == (("pose",), ("pose", "gripper"))
    judged = next(e for e in seen if isinstance(e, events.Evaluated))
    assert (judged.successes, judged.accepted) == (0, False)
    reason = next(e.reason for e in seen if isinstance(e, events.Reformulated))
    assert reason.startswith("cubeA did not follow the hand")


def test_a_session_begins_and_ends_as_events_say(sessions):
    _, seen = sessions[1]
    assert isinstance(seen[0], events.SessionStarted)
    assert isinstance(seen[1], events.Segmented)
    assert isinstance(seen[-1], events.SessionFinished)
    assert seen[0].settings == to_toml(SMALL)
    trials = [e for e in seen if isinstance(e, events.TrialFinished)]
    numbers = {}
    for e in trials:
        if e.purpose != "reproduce":
            key = e.segment, e.formulation
            assert e.trial == numbers.get(key, 0)
            numbers[key] = e.trial + 1


def test_it_replays_bit_for_bit(sessions):
    report = replay(sessions[1][0])
    assert report.steps > 10_000
    assert (report.divergent, report.first_divergence) == (0, None)


@pytest.mark.slow
def test_a_session_whose_trials_are_watched_is_the_same_with_any_workers_and_replays(source, tmp_path):
    watched = SMALL.model_copy(
        update={"learning": SMALL.learning.model_copy(update={"observe_trials": True, "first_rollouts": 4})}
    )
    logs = [tmp_path / f"w{workers}.mcap" for workers in (1, 2)]
    for workers, log in enumerate(logs, start=1):
        seen = list(run(Request(source, watched, 3, workers, log=log)))
        assert all(e.seen is not None for e in seen if isinstance(e, events.TrialFinished))
    assert messages(logs[0]) == messages(logs[1])
    assert replay(logs[0]).divergent == 0


def test_stopping_leaves_a_valid_file(source, tmp_path):
    log = tmp_path / "stopped.mcap"
    seen = []

    def enough():
        return sum(isinstance(e, events.TrialFinished) for e in seen) >= 2

    for event in run(Request(source, SMALL, 3, log=log), enough):
        seen.append(event)
    assert messages(log) == [repr_of(event) for event in seen]
    assert not any(isinstance(e, events.SessionFinished) for e in seen)
    assert summarise(log)


def test_a_decision_is_in_the_stream_and_changes_the_segments(source):
    decisions = (Decision("split", 0, 2.0), Decision("undo"))
    stream = run(Request(source, SMALL, 3, decisions=decisions))
    found, split, undone = (next(stream), next(stream), next(stream), next(stream))[1:]
    stream.close()
    assert len(split.segments) == len(found.segments) + 1
    assert undone.segments == found.segments


def test_an_existing_session_is_left_alone(source, tmp_path):
    log = tmp_path / "there.mcap"
    log.write_bytes(b"precious")
    with pytest.raises(FileError, match=r"there.mcap: exists already.*--force"):
        next(run(Request(source, SMALL, 3, log=log)))
    assert log.read_bytes() == b"precious"


def test_bad_input_leaves_no_file_behind(short_demonstration, tmp_path):
    d = short_demonstration
    objects = d.objects.copy()
    objects[:, 1, 0] += 3
    path, log = tmp_path / "far.npz", tmp_path / "far.mcap"
    write_demonstration(replace(d, objects=objects), path)
    with pytest.raises(SceneError, match="cubeB is out of reach"):
        next(run(Request(path, SMALL, 0, log=log)))
    assert not log.exists()


def test_a_session_is_not_a_source(sessions):
    with pytest.raises(FileError, match=r"is a session.*imitate replay"):
        next(run(Request(sessions[1][0], SMALL, 0)))


def test_a_session_killed_in_the_middle_leaves_no_process_and_a_readable_log(source, tmp_path):
    log = tmp_path / "killed.mcap"
    command = "from imitate.cli import main\nif __name__ == '__main__': main()"
    words = ["learn", str(source), "-o", str(log), "--no-rrd", "--workers", "1", "--json"]
    settings = tmp_path / "small.toml"
    settings.write_text(to_toml(SMALL))
    process = subprocess.Popen(
        [sys.executable, "-c", command, *words, "--settings", str(settings)],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )
    narration = ""
    for line in process.stderr:
        narration += line
        if "did not follow" in line:
            process.kill()
            break
    assert "did not follow" in narration
    # The worker shares the pipe: it closes only when the worker has ended as well.
    assert process.stdout.read() == ""
    process.wait()
    kinds = [type(event).__name__ for event in read_session(log)]
    assert kinds.count("Evaluated") == 1


def test_learn_prints_its_contract(source, tmp_path):
    from typer.testing import CliRunner

    from imitate.cli import app

    settings = tmp_path / "small.toml"
    settings.write_text(to_toml(SMALL))
    log = tmp_path / "out.mcap"
    words = [
        "learn",
        str(source),
        "-o",
        str(log),
        "--no-rrd",
        "--json",
        "--seed",
        "3",
        "--settings",
        str(settings),
    ]
    result = CliRunner().invoke(app, words)
    report = json.loads(result.stdout)
    assert set(report) == {"session", "seed", "segments", "reproduced", "wall_s"}
    formulation = report["segments"][0]["formulations"][0]
    assert set(formulation) == {
        "relevant", "reference", "actions", "trials", "updates", "cost", "success", "accepted", "failed_of",
        "initiation",
    }  # fmt: skip
    assert result.exit_code == (0 if report["reproduced"] else 3)


def test_a_symmetric_object_that_is_not_there_is_named(source):
    settings = load_settings(None, {"learning": {"symmetric": ["cubeC"]}})
    with pytest.raises(UsageError, match=r"unknown symmetric object of carry.npz: 'cubeC'.*cubeA, cubeB"):
        next(run(Request(source, settings, 0)))


def test_a_cluster_that_does_not_answer_leaves_no_file(source, tmp_path):
    pytest.importorskip("distributed", reason="the extra imitate[cluster] is not installed")
    log = tmp_path / "none.mcap"
    with pytest.raises(ImitateError, match="no scheduler answers"):
        next(run(Request(source, SMALL, 3, log=log, cluster="nowhere://x")))
    assert not log.exists()
