"""Streams and exit codes."""

import json
import os
import subprocess
import sys
from concurrent.futures.process import BrokenProcessPool
from pathlib import Path

import pytest
import typer

from imitate import __version__, cli
from imitate.cli import console
from imitate.errors import ImitateError, UsageError


def raising(error: BaseException) -> object:
    def verb() -> None:
        raise error

    return verb


@pytest.mark.parametrize(
    ("error", "code", "message"),
    [
        (ImitateError("the block is gone. Look for it."), 1, "error: the block is gone. Look for it.\n"),
        (UsageError("no such word."), 2, "error: no such word.\n"),
        (KeyboardInterrupt(), 130, "interrupted\n"),
        (
            KeyError("pose"),
            1,
            "error: unexpected KeyError: 'pose'. This is a fault of imitate; run again with --debug to see "
            "where.\n",
        ),
        (SystemExit(3), 3, ""),
        (SystemExit(None), 0, ""),
    ],
)
def test_whatever_ends_a_verb_becomes_one_message_and_an_exit_code(error, code, message, capsys):
    assert console.run(raising(error)) == code
    captured = capsys.readouterr()
    assert captured.err == message
    assert captured.out == ""


def test_a_verb_that_returns_is_done():
    assert console.run(lambda: None) == 0


def test_debug_shows_where(capsys):
    assert console.run(raising(ImitateError("no.")), debug=True) == 1
    err = capsys.readouterr().err
    assert "Traceback" in err
    assert err.endswith("error: no.\n")


def test_json_is_one_line_and_never_nan(capsys):
    console.write_json({"a": [1, 2.5], "ä": None})
    out = capsys.readouterr().out
    assert out.count("\n") == 1
    assert json.loads(out) == {"a": [1, 2.5], "ä": None}
    with pytest.raises(ValueError, match="JSON compliant"):
        console.write_json(float("nan"))


def test_version(capsys):
    with pytest.raises(SystemExit) as end:
        cli.main(["--version"])
    assert end.value.code == 0
    assert capsys.readouterr().out == f"imitate {__version__}\n"


@pytest.mark.parametrize("words", [["frobnicate"], ["--frobnicate"]])
def test_wrong_words_are_usage_errors_without_a_traceback(words, capsys):
    with pytest.raises(SystemExit) as end:
        cli.main(words)
    captured = capsys.readouterr()
    assert end.value.code == 2
    assert "No such" in captured.err
    assert "Traceback" not in captured.err
    assert captured.out == ""


def test_help_imports_nothing_heavy():
    code = """
import sys
from imitate import cli
try:
    cli.main(["--help"])
except SystemExit as end:
    assert end.code == 0, end.code
heavy = {"textual", "rich", "rerun", "pybullet", "open3d", "numpy", "scipy", "pydantic", "cv2", "mcap"}
assert not heavy & set(sys.modules), heavy & set(sys.modules)
"""
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    assert "Teach a robot" in done.stdout


def test_a_reader_that_has_enough_is_no_error():
    code = (
        "from imitate.cli import console\nconsole.run(lambda: [console.write('x' * 999) for _ in range(999)])"
    )
    process = subprocess.Popen(
        [sys.executable, "-c", code], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
    )
    assert process.stdout is not None
    assert process.stderr is not None
    process.stdout.read(10)
    process.stdout.close()
    assert process.stderr.read() == ""
    process.wait(timeout=20)


def test_an_interrupted_verb_says_so(capsys):
    small = typer.Typer()

    @small.command()
    def long() -> None:
        raise KeyboardInterrupt

    assert console.run(lambda: small([])) == 130
    assert capsys.readouterr().err == "interrupted\n"


def test_a_verb_chooses_its_exit_code():
    small = typer.Typer()

    @small.command()
    def lossy() -> None:
        raise typer.Exit(console.Exit.LOSSY)

    assert console.run(lambda: small([])) == 3


def started(code: str, **how: object) -> subprocess.CompletedProcess[str]:
    """What a process of its own says, which runs ``code`` as a verb."""
    options = {"text": True, "check": False} | how
    return subprocess.run(program(code), **options)  # type: ignore[call-overload]


def program(code: str) -> list[str]:
    """The words that start such a process."""
    verb = f"def verb():\n    {code}\nsys.exit(console.run(verb))"
    return [sys.executable, "-c", f"from imitate.cli import console\nimport os, sys\n{verb}"]


TABLE = "t = console.table('a', 'b'); t.add_row('1.0–2.0', '⟨é⟩'); console.show(t); console.write('⟨done⟩')"


@pytest.mark.parametrize("encoding", ["latin-1", "koi8-r"])
def test_a_terminal_without_our_signs_gets_others_and_ends_no_work(encoding):
    environment = os.environ | {"PYTHONIOENCODING": encoding}
    code = f"console.narrate('⟨hand⟩'); {TABLE}"
    done = started(code, capture_output=True, env=environment, encoding=encoding)
    assert (done.returncode, done.stderr) == (0, "?hand?\n")
    assert "1.0?2.0" in done.stdout
    assert done.stdout.endswith("?done?\n")


def test_json_on_such_a_terminal_says_all():
    environment = os.environ | {"PYTHONIOENCODING": "latin-1"}
    done = started("console.write_json({'a': '⟨é⟩ \\udce9'})", capture_output=True, env=environment)
    assert json.loads(done.stdout) == {"a": "⟨é⟩ \udce9"}


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="there is no /dev/full")
@pytest.mark.parametrize("said", ["console.write('all')", TABLE, "console.write_json([])"])
def test_a_full_disk_is_no_fault_of_ours(said):
    with Path("/dev/full").open("w") as full:
        done = started(said, stdout=full, stderr=subprocess.PIPE)
    assert done.returncode == 1
    assert done.stderr == "error: stdout cannot be written (No space left on device).\n"
    with Path("/dev/full").open("w") as full:
        done = started("console.narrate('lost'); console.write('kept')", stdout=subprocess.PIPE, stderr=full)
    assert (done.returncode, done.stdout) == (0, "kept\n")


def test_closed_streams_are_never_given_to_a_file(tmp_path):
    code = f"new = open({str(tmp_path / 'new')!r}, 'w'); os.write(1, b'as C code does')"
    subprocess.run(["sh", "-c", '"$@" >&- 2>&-', "sh", *program(code)], check=False)
    assert (tmp_path / "new").read_text() == ""


def test_a_closed_stdout_is_named():
    shell = ["sh", "-c", '"$@" >&-', "sh", *program("console.write('data')")]
    done = subprocess.run(shell, stderr=subprocess.PIPE, text=True, check=False)
    assert (done.returncode, done.stderr) == (1, "error: stdout cannot be written (Bad file descriptor).\n")


def test_a_closed_stdin_is_no_terminal():
    shell = ["sh", "-c", '"$@" <&-', "sh", *program("print(sys.stdin.isatty(), sys.stdin.read())")]
    done = subprocess.run(shell, capture_output=True, text=True, check=False)
    assert (done.stdout, done.stderr) == ("False \n", "")


@pytest.mark.parametrize(
    ("error", "message"),
    [
        (PermissionError(13, "Permission denied", "a.npz"), "error: a.npz: Permission denied.\n"),
        (OSError(28, "No space left on device"), "the system refuses to go on: No space left on device."),
        (MemoryError("Unable to allocate 3 TiB"), "error: the memory is full (MemoryError: Unable to"),
        (BrokenProcessPool("terminated abruptly"), "error: a process that ran trials died (terminated"),
        (BrokenPipeError(32, "Broken pipe"), "error: the system refuses to go on: Broken pipe.\n"),
    ],
)
def test_what_the_system_refuses_is_no_fault_of_ours(error, message, capsys, monkeypatch):
    def refuse(*_: object, **__: object) -> None:
        raise error

    monkeypatch.setattr("imitate.formats.mcap_contents.contents", refuse)
    with pytest.raises(SystemExit) as end:
        cli.main(["info", str(Path(__file__))])
    said = capsys.readouterr().err
    assert end.value.code == 1
    assert message in said
    assert "fault" not in said
