"""Folders in LeRobot's layout, before its version 3 and since."""

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import pytest
import scripted

from imitate.errors import FileError
from imitate.formats.demonstrations import read_demonstration
from imitate.formats.kind import kind_of
from imitate.formats.mapping import Body, Mapping
from imitate.session.source import read_source
from imitate.settings import load_settings

MAPPING = Mapping(
    hand=Body(pose="observation.state"),
    objects={
        "blue": Body(pose="observation.environment_state[0:7]"),
        "green": Body(pose="observation.environment_state[7:14]"),
    },
)
EPISODES = 3


def episode(number):
    """The scripted demonstration, a little further off in each episode."""
    d = scripted.demonstration()
    states = np.concatenate([d.objects[:, 0], d.objects[:, 1]], axis=1)
    states[:, 0] += number
    return pa.table({
        "observation.state": d.hand.tolist(),
        "observation.environment_state": states.tolist(),
        "timestamp": d.t,
        "episode_index": np.full(len(d.t), number),
    })  # fmt: skip


@pytest.fixture(params=["v2", "v3"])
def folder(request, tmp_path):
    data = tmp_path / "data" / "chunk-000"
    data.mkdir(parents=True)
    (tmp_path / "meta").mkdir()
    (tmp_path / "meta" / "info.json").write_text('{"codebase_version": "any", "fps": 30}')
    tables = [episode(k) for k in range(EPISODES)]
    if request.param == "v3":
        pq.write_table(pa.concat_tables(tables[:2]), data / "file-000.parquet")
        pq.write_table(tables[2], data / "file-001.parquet")
    else:
        for k, table in enumerate(tables):
            pq.write_table(table, data / f"episode_{k:06d}.parquet")
    return tmp_path


@pytest.mark.parametrize("number", range(EPISODES))
def test_an_episode_is_read(folder, number):
    assert kind_of(folder) == "demonstration"
    read, shown = read_demonstration(folder, MAPPING.model_copy(update={"episode": number})), episode(number)
    assert np.array_equal(read.hand, np.array(shown["observation.state"].to_pylist()))
    assert np.allclose(read.t, scripted.demonstration().t)
    assert read.objects[0, 0, 0] == pytest.approx(scripted.demonstration().objects[0, 0, 0] + number)
    source = read_source(folder, load_settings(), 0, mapping=MAPPING.model_copy(update={"episode": number}))
    assert (source.name, len(source.demonstration.t)) == (folder.name, len(read.t))


@pytest.mark.parametrize(
    ("wanted", "said"),
    [
        (None, "holds 3 episodes, 0 to 2. Choose one in a mapping (--mapping FILE.toml): episode = 0."),
        (7, "holds 3 episodes, 0 to 2, and none of them is 7."),
    ],
)
def test_an_episode_has_to_be_chosen(folder, wanted, said):
    with pytest.raises(FileError) as refused:
        read_demonstration(folder, MAPPING.model_copy(update={"episode": wanted}))
    assert said in str(refused.value)


def test_without_a_mapping_its_columns_are_told(folder):
    with pytest.raises(FileError, match=r"its columns are observation\.state \(7 numbers\)"):
        read_demonstration(folder, Mapping(episode=0))


def test_where_there_are_no_times_its_rate_counts(folder):
    for file in (folder / "data").glob("**/*.parquet"):
        pq.write_table(pq.read_table(file).drop_columns(["timestamp"]), file)
    read = read_demonstration(folder, MAPPING.model_copy(update={"episode": 1}))
    assert np.allclose(np.diff(read.t), 1 / 30)


def test_a_folder_that_was_copied_in_part(folder):
    for file in (folder / "data").glob("**/*.parquet"):
        file.unlink()
    with pytest.raises(FileError, match=r"and no episodes\..*Was the whole folder copied\?"):
        read_demonstration(folder)
    (folder / "meta" / "info.json").write_text("{")
    with pytest.raises(FileError, match=r"info\.json: .*LeRobot writes it\."):
        read_demonstration(folder)


def test_info_lists_what_is_in_it(folder, capsys):
    from imitate import cli

    with pytest.raises(SystemExit) as end:
        cli.main(["info", str(folder)])
    assert end.value.code == 0
    out = capsys.readouterr().out.split()
    assert out[out.index("episodes") + 1] == "3"
    assert "observation.environment_state," in out


def test_a_folder_of_neither_layout_is_told_of_both(tmp_path):
    with pytest.raises(FileError, match=r"is a folder without rgb\.txt and depth\.txt.*LeRobot's layout"):
        kind_of(tmp_path)
