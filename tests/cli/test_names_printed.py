"""Names that other people chose are printed as they are: no table, bar or picture takes them for markup."""

import ast
import json
from io import StringIO
from pathlib import Path

import numpy as np
import pytest
import scripted
from rich.console import Console

from imitate import cli
from imitate.cli import console, following
from imitate.formats.npz import write_npz
from imitate.session.progress import Progress
from imitate.skill import Abstraction

NAMES = ("cube[left]", "[/]a", ":cube: $x^$", "_b", "x\x1b[31m\ny")
SHOWN = ("cube[left]", "[/]a", ":cube: $x^$", "_b", r"x\x1b[31m\ny")


@pytest.fixture
def named(tmp_path):
    """A demonstration of two objects called so."""

    def make(*names):
        path = tmp_path / "[red]shown[].npz"
        d = scripted.demonstration()
        object.__setattr__(d, "object_names", names)
        with path.open("wb") as stream:
            write_npz(d, stream)
        return path

    return make


@pytest.mark.parametrize(("one", "other"), [(0, 1), (2, 3), (4, 0)])
def test_segment_and_info_tell_objects_apart(named, imitate, one, other):
    path = named(NAMES[one], NAMES[other])
    code, out, _ = imitate("segment", path)
    assert code == 0
    assert SHOWN[one] in out and SHOWN[other] in out
    code, out, _ = imitate("info", path)
    assert code == 0
    assert f"{SHOWN[one]}, 40 × 40 × 40 mm" in out and f"{SHOWN[other]}, 50 × 50 × 50 mm" in out
    assert "[red]shown[].npz" in out


def test_machines_get_them_unchanged(named, imitate):
    _, out, _ = imitate("info", named(NAMES[4], NAMES[0]), "--json")
    assert [thing["name"] for thing in json.loads(out)["objects"]] == [NAMES[4], NAMES[0]]


def test_a_picture_shows_them_and_no_formula(named, imitate, tmp_path):
    code, _, err = imitate("segment", named(NAMES[2], NAMES[3]), "--plot", tmp_path / "a.svg")
    assert (code, err) == (0, f"picture: {tmp_path / 'a.svg'}\n")
    drawn = (tmp_path / "a.svg").read_text()
    assert ":cube: $x^$" in drawn
    assert drawn.count("_b") > 1, "in the bands and in the legend"


def test_a_session_is_told_with_them(capsys):
    progress = Progress()
    for event in scripted.session():
        progress.fold(event)
    for skill in progress.skills:
        for attempt in skill.attempts:
            named = Abstraction(("hand", "[/]a"), "cube[left]")
            object.__setattr__(attempt.formulation, "abstraction", named)
    following._show(progress, 1.0)
    assert "hand, [/]a" in (out := capsys.readouterr().out)
    assert "cube[left]" in out


def test_a_bar_names_a_file_as_it_is_called(monkeypatch):
    shown = Console(force_terminal=True, width=80, record=True, file=StringIO())
    monkeypatch.setattr(console, "_console", lambda **_: shown)
    with console.progress() as bar:
        bar.add_task("observing [/]a[red].npz", total=1)
    assert "observing [/]a[red].npz" in shown.export_text()


def test_only_one_place_makes_what_could_take_names_for_markup():
    """Every table, bar and console of the verbs comes from `cli.console`, which switches markup off."""
    makers = {"rich.console", "rich.table", "rich.markup", "rich.panel", "rich.tree"}
    for path in Path(cli.__file__).parent.glob("*.py"):
        imports = [n for n in ast.walk(ast.parse(path.read_text())) if isinstance(n, ast.ImportFrom)]
        found = {n.module for n in imports} & makers
        assert not found or path.name == "console.py", path.name
        names = {alias.name for n in imports for alias in n.names}
        assert "TextColumn" not in names or path.name == "console.py", path.name
    made = console._console()
    assert not made._markup and not made._emoji


def test_numbers_stay_numbers(capsys):
    table = console.table("n", right=("n",))
    table.add_row(str(np.float64(1.5)))
    console.show(table)
    assert capsys.readouterr().out.split() == ["n", "1.5"]
