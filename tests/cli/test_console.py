"""Streams and exit codes."""

import json
import subprocess
import sys

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
