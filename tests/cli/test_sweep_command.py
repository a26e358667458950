"""imitate learn --seeds: what is asked for, and what is shown of it."""

import json
from pathlib import Path

import pytest
import scripted

from imitate import cli
from imitate.cli.sweep import seeds_of
from imitate.errors import UsageError
from imitate.session import sweep as module
from imitate.session.progress import Progress
from imitate.session.source import Source
from imitate.session.sweep import Swept

DEMONSTRATION = Path(__file__).parents[2] / "fixtures" / "human_stack.npz"


@pytest.mark.parametrize(
    ("text", "seeds"),
    [
        ("7", (7,)),
        ("0-3", (0, 1, 2, 3)),
        ("5,1-2, 9", (5, 1, 2, 9)),
        ("1-3,2,0", (1, 2, 3, 0)),
        ("4-4", (4,)),
    ],
)
def test_seeds_are_written_singly_and_as_ranges(text, seeds):
    assert seeds_of(text) == seeds


@pytest.mark.parametrize("text", ["x", "1-", "-1", "3-1", "1,,2", "1-2-3", "1.5", "²"])
def test_what_is_no_seed_is_named(text):
    with pytest.raises(UsageError, match=r"is no seed. Write them as 0-19 or 3,7,10-12"):
        seeds_of(text)


@pytest.mark.parametrize("text", ["0-1000", "0-999,1000", "0-99999999999999", str(2**63)])
def test_more_than_a_sweep_takes_is_refused(text):
    with pytest.raises(UsageError, match=r"at most 1000 sessions in one sweep"):
        seeds_of(text)


def story(reproduced):
    progress = Progress()
    for event in scripted.session(reproduced):
        progress.fold(event)
    return progress


@pytest.fixture
def learn(capsys, tmp_path, monkeypatch):
    """Runs `imitate learn` where sessions take no time; ``fate`` says what becomes of each seed."""
    monkeypatch.chdir(tmp_path)

    def run(*words, fate):
        asked = []

        def pretended(requests, _factory, finished):
            asked.extend(requests)
            results = tuple(
                Swept(r, *fate[r.seed][:2], wall_s=61.2, source=[*fate[r.seed], None][2]) for r in requests
            )
            for swept in reversed(results):
                finished(swept)
            return results

        monkeypatch.setattr(module, "sweep", pretended)
        with pytest.raises(SystemExit) as end:
            cli.main(["learn", str(DEMONSTRATION), *words])
        captured = capsys.readouterr()
        return end.value.code, captured.out, captured.err, asked

    return run


GOOD, BAD, FAILED = (story(True), ""), (story(False), ""), (Progress(), "it is broken.")


def test_a_table_has_a_row_for_each_seed_in_order(learn):
    code, out, err, asked = learn("--seeds", "2,0-1", "--workers", "2", fate=[GOOD, BAD, FAILED])
    assert code == 3
    lines = [line.split() for line in out.splitlines()]
    assert [line[:2] for line in lines[1:4]] == [["2", "failed"], ["0", "yes:"], ["1", "no:"]]
    assert "it is broken." in out.splitlines()[1]
    assert " 5 | 10 + 10 | 5 " in out.splitlines()[2]
    assert out.splitlines()[-1].startswith("1 of 3 sessions reproduced the task, ")
    assert "seed 2: it is broken.\n" in err
    assert [(r.seed, r.workers, r.log) for r in asked] == [
        (k, 0, Path("sessions") / f"human_stack-{k}.mcap") for k in (2, 0, 1)
    ]


def test_json_is_the_reports_of_single_sessions(learn):
    code, out, _, asked = learn("--seeds", "0-2", "-o", "there/a.b.mcap", "--json", fate=[GOOD, BAD, FAILED])
    report = json.loads(out)
    assert code == 3
    assert set(report) == {"sessions", "reproduced", "wall_s"}
    assert report["reproduced"] == 1
    assert [s["seed"] for s in report["sessions"]] == [0, 1, 2]
    assert set(report["sessions"][0]) == {"session", "seed", "segments", "reproduced", "wall_s"}
    assert report["sessions"][2]["error"] == "it is broken."
    assert [str(r.rrd) for r in asked] == [f"there/a.b-{k}.rrd" for k in range(3)]


def test_all_reproduced_is_done_and_no_viewer_file_is_asked_for(learn):
    code, out, err, asked = learn("--seeds", "0", "--no-rrd", fate=[GOOD])
    assert (code, err) == (0, "seed 0: reproduced, 61 s\n")
    assert "1 of 1 sessions reproduced the task" in out
    assert asked[0].rrd is None


@pytest.mark.parametrize(("left_out", "code"), [(0.5, 3), (0.05, 0)])
def test_what_a_recording_lost_is_told_once_and_counts(learn, left_out, code):
    lost = Source("film", "", scripted.demonstration(), notes=("half is gone",), left_out=left_out)
    ends, _, err, _ = learn("--seeds", "0-1", fate=[(*GOOD, lost), (*GOOD, lost)])
    assert ends == code
    assert err.count(f"{DEMONSTRATION}: half is gone\n") == 1


def test_where_every_session_fails_that_is_the_error(learn):
    code, out, err, _ = learn("--seeds", "0-1", fate=[FAILED, FAILED])
    assert (code, out) == (1, "")
    assert err.endswith("error: it is broken.\n")


def test_a_seed_and_seeds_do_not_go_together(learn):
    code, out, err, asked = learn("--seeds", "0-1", "--seed", "4", fate=[])
    assert (code, out, asked) == (2, "", [])
    assert err == "error: --seed 4 and --seeds 0-1: give one of them.\n"


def test_names_that_are_taken_are_passed_over(learn, tmp_path):
    (tmp_path / "sessions").mkdir()
    (tmp_path / "sessions" / "human_stack-1.mcap").touch()
    *_, asked = learn("--seeds", "0-1", fate=[GOOD, GOOD])
    assert [r.log.name for r in asked] == ["human_stack-0.mcap", "human_stack-1-2.mcap"]


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["none.npz"], "error: none.npz: no such file"),
        (
            [str(DEMONSTRATION), "--cluster", "nowhere://x"],
            "error: --cluster nowhere://x: no scheduler answers",
        ),
    ],
)
def test_what_fails_every_session_is_said_once_before_any(words, message, capsys, tmp_path, monkeypatch):
    pytest.importorskip("distributed", reason="the extra imitate[cluster] is not installed")
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(module, "sweep", lambda *_: pytest.fail("sessions were begun"))
    with pytest.raises(SystemExit) as end:
        cli.main(["learn", *words, "--seeds", "0-9"])
    captured = capsys.readouterr()
    assert (end.value.code, captured.out) == (1, "")
    assert captured.err.startswith(message)
    assert captured.err.count("\n") == 1
