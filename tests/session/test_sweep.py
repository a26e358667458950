"""Many sessions: each as if it ran alone, in the order asked for, none lost to another."""

import os
import signal
import subprocess
import sys
import time
from concurrent.futures import BrokenExecutor, Executor, Future
from dataclasses import replace
from functools import partial

import pytest

from imitate import events
from imitate.errors import FileError, ImitateError
from imitate.formats.session_log import read_session
from imitate.session import sweep as module
from imitate.session.progress import Progress
from imitate.session.session import Request, run
from imitate.session.sweep import Board, Swept, session_pool, sweep
from imitate.settings import load_settings, to_toml

MAGIC = b"\x89MCAP0\r\n"
TINY = load_settings(
    None,
    {
        "learning": {
            "evaluation_starts": 1,
            "candidates": 0,
            "first_rollouts": 2,
            "updates": 1,
            "formulations": 1,
            "near": 1e-6,
        },
        "world": {"settle_time": 0.1},
    },
)
"""Three trials, of which none succeeds."""


@pytest.fixture(scope="module")
def alone(source, tmp_path_factory):
    """Seed 3 as one session with a process for its trials: the log's bytes and what was folded."""
    log = tmp_path_factory.mktemp("alone") / "3.mcap"
    progress = Progress()
    for event in run(Request(source, TINY, 3, 1, log=log)):
        progress.fold(event)
    return log.read_bytes(), progress


def outline(progress):
    attempts = [a for skill in progress.skills for a in skill.attempts]
    judged = [(a.formulation, a.trials, a.evaluated.successes, a.evaluated.cost) for a in attempts]
    return judged, progress.finished.advice


def test_each_writes_what_it_writes_alone_and_one_that_fails_is_said(source, alone, tmp_path):
    missing = tmp_path / "none.npz"
    asked = [
        Request(path, TINY, seed, 0, log=tmp_path / f"{name}.mcap")
        for path, seed, name in ((source, 4, "a"), (missing, 3, "b"), (source, 3, "c"))
    ]
    heard = []
    results = sweep(asked, session_pool(2), heard.append)
    assert [swept.request for swept in results] == asked
    assert sorted(swept.request.log for swept in heard) == [request.log for request in asked]
    assert results[1].error.startswith(f"{missing}: no such file")
    assert not asked[1].log.exists()
    assert (tmp_path / "c.mcap").read_bytes() == alone[0]
    assert outline(results[2].progress) == outline(alone[1])
    assert (tmp_path / "a.mcap").read_bytes() != alone[0]
    assert [swept.reproduced for swept in results] == [False] * 3
    assert results[0].wall_s > 0


def test_where_each_session_is_can_be_seen_meanwhile(source, monkeypatch):
    board, seen = Board(3), []
    monkeypatch.setattr(module, "_boards", [board])
    board.note(2, 1, 9)

    class Seen(Progress):
        def fold(self, event):
            seen.append(board.running())
            super().fold(event)

    monkeypatch.setattr(module, "Progress", Seen)
    module.run_session(1, Request(source, TINY, 3, 0))
    assert seen[0] == {2: (1, 9)}
    assert [where[1] for where in seen[3:]] == sorted(where[1] for where in seen[3:])
    assert seen[-1] == {1: (1, 3), 2: (1, 9)}
    assert board.running() == {2: (1, 9)}


def test_a_cluster_runs_whole_sessions_or_the_trials_of_sessions_here(source, alone, tmp_path):
    distributed = pytest.importorskip("distributed", reason="the extra imitate[cluster] is not installed")
    from imitate.learning.cluster import cluster

    there, here = (Request(source, TINY, 3, 0, log=tmp_path / f"{name}.mcap") for name in ("there", "here"))
    with distributed.LocalCluster(
        n_workers=1, threads_per_worker=2, host="127.0.0.1", dashboard_address=":0", protocol="tcp://"
    ) as running:
        address = running.scheduler_address
        results = sweep([there], cluster(address))
        results += sweep([replace(here, cluster=address)], session_pool(1))
    assert [swept.error for swept in results] == ["", ""]
    assert there.log.read_bytes() == alone[0]
    assert here.log.read_bytes() == alone[0]


def test_a_file_that_exists_stops_it_all_before_anything_runs(source, tmp_path):
    there = tmp_path / "there.mcap"
    there.write_bytes(b"precious")
    asked = [Request(source, TINY, k, 0, log=log) for k, log in enumerate((tmp_path / "new.mcap", there))]
    with pytest.raises(FileError, match=r"there.mcap: exists already.*--force"):
        sweep(asked, lambda: pytest.fail("an executor was made"))
    assert sorted(tmp_path.iterdir()) == [there]


def _die_once(folder, _number, request):
    if not (folder / "died").exists():
        (folder / "died").touch()
        os.kill(os.getpid(), signal.SIGKILL)
    return Swept(request, Progress(), f"ran with seed {request.seed}", 0.0)


def test_a_worker_that_dies_costs_only_a_repeat(source, tmp_path, monkeypatch):
    monkeypatch.setattr(module, "run_session", partial(_die_once, tmp_path))
    asked = [Request(source, TINY, seed, 0) for seed in (5, 6, 7)]
    results = sweep(asked, session_pool(1))
    assert [swept.error for swept in results] == [f"ran with seed {seed}" for seed in (5, 6, 7)]
    assert [swept.request for swept in results] == asked
    assert (tmp_path / "died").exists()


class Dying(Executor):
    """Every process of it dies at once."""

    made = 0

    def __init__(self):
        Dying.made += 1

    def submit(self, *_):
        future = Future()
        future.set_exception(BrokenExecutor("terminated abruptly"))
        return future


def test_workers_that_die_again_and_again_are_said(source):
    with pytest.raises(
        ImitateError, match=r"died 4 times \(terminated abruptly\).* 0 of 1 sessions ended before"
    ):
        sweep([Request(source, TINY, 5, 0)], Dying)
    assert Dying.made == 4


def _unexpected(*_, **__):
    raise ZeroDivisionError("seven")


def test_a_fault_of_ours_costs_that_session_alone(source, monkeypatch):
    monkeypatch.setattr(module, "run", _unexpected)
    error = module.run_session(0, Request(source, TINY, 0)).error
    assert error == "unexpected ZeroDivisionError: seven. This is a fault of imitate."


def test_interrupted_it_ends_after_the_present_trial_with_whole_files(source, tmp_path):
    command = "from imitate.cli import main\nif __name__ == '__main__': main()"
    settings = tmp_path / "long.toml"
    longer = TINY.learning.model_copy(update={"first_rollouts": 500})
    settings.write_text(to_toml(TINY.model_copy(update={"learning": longer})))
    words = ["learn", str(source), "-o", "s.mcap", "--seeds", "0-3", "--workers", "1", "--no-rrd"]
    process = subprocess.Popen(
        [sys.executable, "-c", command, *words, "--settings", str(settings)],
        cwd=tmp_path,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        # Tests that run in the background of a shell ignore Ctrl-C, and what they start would as well.
        preexec_fn=lambda: signal.signal(signal.SIGINT, signal.SIG_DFL),
    )
    log = tmp_path / "s-0.mcap"
    deadline = time.monotonic() + 60
    while not log.exists() and process.poll() is None and time.monotonic() < deadline:
        time.sleep(0.05)
    process.send_signal(signal.SIGINT)
    out, narration = process.communicate(timeout=60)
    assert (process.returncode, out, narration) == (130, "", "interrupted\n")
    assert list(tmp_path.glob("*.mcap")) == [log]
    assert log.read_bytes().endswith(MAGIC)
    kinds = [type(event) for event in read_session(log)]
    assert kinds[0] is events.SessionStarted
    assert events.SessionFinished not in kinds
