"""imitate diff on the command line: exit codes, what it prints, and what it says of a wrong file."""

import json
from dataclasses import replace

import pytest
import recorded
from refiled import cut, flipped, messages, written

from imitate.settings import load_settings, to_toml


@pytest.fixture(scope="module")
def session(tmp_path_factory):
    return written(tmp_path_factory.mktemp("sessions") / "a.mcap", recorded.session())


def test_equal_sessions_are_said_to_be_and_how_much_was_compared(imitate, session, tmp_path):
    code, out, _ = imitate("diff", session, written(tmp_path / "b.mcap", recorded.session()))
    assert code == 0
    assert out == f"equal: all {len(messages(session)):,} messages compared, bit for bit\n"


def test_what_differs_is_a_table_and_an_exit_code(imitate, session, tmp_path):
    started, *rest = recorded.session()
    other = replace(started, settings=to_toml(load_settings(None, {"learning": {"alpha": 0.9}})))
    code, out, _ = imitate("diff", session, written(tmp_path / "b.mcap", [other, *rest]))
    assert code == 3
    rows = [line.split() for line in out.splitlines()]
    assert ["learning.alpha", "0.8", "0.9"] in rows
    assert ["/imitate/session_started", "1", "1", "the", "settings", "above"] in rows


def test_for_machines_the_first_difference_of_each_topic(imitate, session, tmp_path):
    code, out, _ = imitate("diff", session, flipped(session, tmp_path / "b.mcap", "/costs", 2), "--json")
    assert code == 3
    found = json.loads(out)
    assert not found["equal"]
    costs = found["topics"]["/costs"]
    assert (costs["equal"], costs["first"]["message"], costs["first"]["field"]) == (False, 2, "data.3")
    assert all(topic["equal"] for name, topic in found["topics"].items() if name != "/costs")


def test_damage_is_a_warning_and_what_is_there_is_compared(imitate, session, tmp_path):
    code, out, err = imitate("diff", session, cut(session, tmp_path / "b.mcap", 0.6))
    assert code == 3
    assert "those that both have are equal" in out
    assert "b.mcap is damaged: cut at byte" in err
    assert "What could be read was compared." in err


def test_what_is_no_session_is_refused_by_name(imitate, session, tmp_path):
    wrong = tmp_path / "notes.mcap"
    wrong.write_text("hello")
    code, out, err = imitate("diff", session, wrong)
    assert (code, out) == (1, "")
    assert "notes.mcap: is not an MCAP file" in err
