"""A layout for Foxglove: every panel of it exists, and what it shows is in a session."""

import json

import pytest
import scripted

from imitate.errors import FileError
from imitate.formats.foxglove_layout import layout, write_layout
from imitate.formats.mcap_contents import contents
from imitate.formats.session_writer import SessionWriter


@pytest.fixture(scope="module")
def topics(tmp_path_factory):
    path = tmp_path_factory.mktemp("s") / "s.mcap"
    with SessionWriter(path) as log:
        for event in scripted.session():
            log.write(event)
    return contents(path).topics


def panels(node):
    return [node] if isinstance(node, str) else panels(node["first"]) + panels(node["second"])


def test_every_panel_is_configured_and_placed_once(topics):
    made = layout(topics)
    assert sorted(panels(made["layout"])) == sorted(made["configById"])


def test_what_is_shown_is_in_the_session(topics):
    config = layout(topics)["configById"]
    paths = [p["value"] for p in config["Plot!costs"]["paths"]]
    paths += [panel["topicPath"] for name, panel in config.items() if name.startswith("RawMessages")]
    assert {path.split(".")[0] for path in paths} <= set(topics)
    assert set(config["3D!scene"]["topics"]) == {t for t in topics if t.startswith("/demonstration/")}


def test_it_is_json_and_never_over_an_existing_file(topics, tmp_path):
    path = tmp_path / "l.json"
    write_layout(path, topics)
    assert json.loads(path.read_text()) == layout(topics)
    with pytest.raises(FileError, match="exists already"):
        write_layout(path, topics)
