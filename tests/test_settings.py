"""Settings: complete sets, TOML in and out, and messages that name the field."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from imitate.errors import FileError, UsageError
from imitate.settings import Settings, dotted, load_settings, settings_from_toml, to_toml


@pytest.mark.parametrize("mode", ["robust", "faithful", "cst"])
def test_every_setting_survives_toml(mode):
    settings = load_settings(overrides={"mode": mode})
    assert settings_from_toml(to_toml(settings)) == settings


@given(
    robot=st.text(st.characters(exclude_categories=["Cs", "Cc"]), max_size=20),
    alpha=st.floats(1e-9, 1),
    starts=st.integers(1, 10**6),
)
def test_odd_values_survive_toml(robot, alpha, starts):
    learning = {"alpha": alpha, "evaluation_starts": starts}
    settings = load_settings(overrides={"world": {"robot": robot}, "learning": learning})
    assert settings_from_toml(to_toml(settings)) == settings


def test_the_faithful_mode_is_faithful_throughout():
    assert load_settings() == Settings()
    faithful = load_settings(overrides={"mode": "faithful"})
    assert faithful.segmentation.mode == "faithful"
    assert faithful.segmentation.rest_limit == 0


def test_a_file_changes_what_it_names_and_overrides_change_the_file(tmp_path):
    file = tmp_path / "mine.toml"
    file.write_text('mode = "faithful"\n[segmentation]\nthreshold = 0.05\nrest_limit = 0.1\n')
    settings = load_settings(file, {"segmentation": {"rest_limit": 0.2}})
    assert settings.segmentation.mode == "faithful"
    assert settings.segmentation.threshold == 0.05
    assert settings.segmentation.rest_limit == 0.2
    assert settings.learning == load_settings(overrides={"mode": "faithful"}).learning


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (
            "[segmentation]\nwindw = 3",
            r"mine.toml \[segmentation\]: 'windw'. Did you mean 'window'\? Valid:",
        ),
        ("mod = 'robust'", "mine.toml: 'mod'. Did you mean 'mode'"),
        ("mode = 'fast'", "mode = 'fast': input should be 'robust', 'faithful' or 'cst'"),
        ("[learning]\nalpha = 1.5", "learning.alpha = 1.5: input should be less than or equal to 1"),
        (
            "mode = 'faithful'\n[learning]\ngripper_from_opening = true",
            r"mine.toml: learning.gripper_from_opening is true, and in the faithful mode the gripper",
        ),
        ("[learning]\nalpha = 'high'", "learning.alpha = 'high': input should be a valid number"),
    ],
)
def test_a_wrong_setting_is_named(tmp_path, text, message):
    file = tmp_path / "mine.toml"
    file.write_text(text)
    with pytest.raises(UsageError, match=message) as caught:
        load_settings(file)
    assert caught.value.exit_code == 2


def test_a_file_that_is_none(tmp_path):
    with pytest.raises(FileError, match=r"no such settings file. Pass a TOML file to --settings"):
        load_settings(tmp_path / "none.toml")
    (tmp_path / "odd.toml").write_text("mode == robust")
    with pytest.raises(FileError, match="is not TOML"):
        load_settings(tmp_path / "odd.toml")
    (tmp_path / "binary.toml").write_bytes(b"\xff\xfe\x00")
    with pytest.raises(FileError, match="cannot be read as text"):
        load_settings(tmp_path / "binary.toml")


def test_settings_recorded_by_an_earlier_version_are_read():
    recorded = to_toml(load_settings(None, {"learning": {"alpha": 0.7}}))
    older = recorded.replace("alpha = 0.7", "alpha = 0.7\nterminal_first = true").replace(
        "more_updates = 2\n", ""
    )
    assert older != recorded
    assert settings_from_toml(older) == settings_from_toml(recorded)


def test_a_recorded_setting_out_of_range_is_still_an_error():
    text = to_toml(Settings()).replace("alpha = 0.8", "alpha = 8.0\ngone = 1")
    with pytest.raises(UsageError, match=r"learning.alpha = 8.0"):
        settings_from_toml(text)


def test_a_table_by_dotted_names():
    assert dotted({"a": 1, "b": {"c": [2], "d": {"e": ""}}, "f": {}}) == {"a": 1, "b.c": [2], "b.d.e": ""}
