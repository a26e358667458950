"""MCAP files of other programs, valid ones that trip readers, and damaged ones."""

import json
from collections import Counter
from pathlib import Path

import pytest
from foxglove_schemas_protobuf.PoseInFrame_pb2 import PoseInFrame
from hypothesis import given, settings
from hypothesis import strategies as st
from mcap.writer import Writer

from imitate.errors import FileError
from imitate.formats.kind import kind_of
from imitate.formats.mcap_contents import contents
from imitate.formats.mcap_file import McapReader
from imitate.formats.mcap_writer import McapWriter, protobuf_channel

SHARED = Path(__file__).parents[2].parent / "shared" / "data" / "mcap"
needs_shared = pytest.mark.skipif(not SHARED.is_dir(), reason="shared data is not beside the project")


@pytest.fixture(scope="module")
def whole(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Six chunks of ten messages on two topics, with metadata at both ends."""
    path = tmp_path_factory.mktemp("mcap") / "whole.mcap"
    channels = [protobuf_channel(topic, PoseInFrame) for topic in ("/even", "/odd")]
    with path.open("wb") as stream, McapWriter(stream, channels, {"first": {"a": "1"}}) as writer:
        for k in range(60):
            writer.write(("/even", "/odd")[k % 2], PoseInFrame(frame_id=str(k)), k)
            if k % 10 == 9:
                writer.flush()
        writer.add_metadata("last", {"b": "2"})
    return path


def times(reader: McapReader, topics: set[str] | None = None) -> list[int]:
    return [message.time for message in reader.messages(topics)]


def test_messages_come_in_the_order_of_the_file(whole: Path) -> None:
    reader = McapReader(whole)
    read = list(reader.messages())
    assert [message.time for message in read] == list(range(60))
    assert [PoseInFrame.FromString(message.data).frame_id for message in read] == [str(k) for k in range(60)]
    assert {message.schema_name for message in read} == {"foxglove.PoseInFrame"}
    assert reader.metadata == {"first": {"a": "1"}, "last": {"b": "2"}}
    assert reader.damage == []
    assert times(McapReader(whole), {"/odd"}) == list(range(1, 60, 2))


def test_contents_agree_with_and_without_the_index(whole: Path) -> None:
    assert contents(whole) == contents(whole, thorough=True)
    assert contents(whole).topics == {
        "/even": ("foxglove.PoseInFrame", 30),
        "/odd": ("foxglove.PoseInFrame", 30),
    }


def test_a_cut_file_gives_its_whole_chunks(tmp_path: Path, whole: Path) -> None:
    data = whole.read_bytes()
    cut = tmp_path / "cut.mcap"
    seen = set()
    for size in range(8, len(data), 37):
        cut.write_bytes(data[:size])
        reader = McapReader(cut)
        read = times(reader)
        assert read == list(range(len(read)))
        assert len(read) % 10 == 0
        assert reader.damage == [f"cut at byte {size:,}: the end of the file is missing"]
        seen.add(len(read))
    assert seen == set(range(0, 61, 10))


@settings(max_examples=150, deadline=None)
@given(data=st.data())
def test_no_flipped_bit_goes_unnoticed_or_raises(
    data: st.DataObject, whole: Path, tmp_path_factory: pytest.TempPathFactory
) -> None:
    original = whole.read_bytes()
    last_chunk = original.rindex(b"last")  # what follows is an index, which reading does without
    at = data.draw(st.integers(8, last_chunk - 30))
    changed = bytearray(original)
    changed[at] ^= 1 << data.draw(st.integers(0, 7))
    path = tmp_path_factory.mktemp("flip") / "flipped.mcap"
    path.write_bytes(changed)
    reader = McapReader(path)
    read = [message.data for message in reader.messages()]
    if not reader.damage:  # a bit that carries no message: a time in an index, say
        assert read == [message.data for message in McapReader(whole).messages()]
    contents(path)


def test_an_index_taken_for_a_message_is_noticed(whole: Path, tmp_path: Path) -> None:
    data = bytearray(whole.read_bytes())
    index, message = b"\x07", b"\x05"
    for at in [k for k in range(8, len(data)) if data[k : k + 1] == index]:
        changed = bytes(data[:at]) + message + bytes(data[at + 1 :])
        path = tmp_path / "flipped.mcap"
        path.write_bytes(changed)
        reader = McapReader(path)
        count = len(list(reader.messages()))
        assert reader.damage or count == 60
        if any("where its summary counts" in words for words in reader.damage):
            break
    else:
        pytest.fail("no index was taken for a message")


@settings(max_examples=150, deadline=None)
@given(junk=st.binary(max_size=300), keep=st.integers(8, 400))
def test_random_bytes_are_explained(
    junk: bytes, keep: int, whole: Path, tmp_path_factory: pytest.TempPathFactory
) -> None:
    path = tmp_path_factory.mktemp("junk") / "junk.mcap"
    path.write_bytes(whole.read_bytes()[:keep] + junk)
    reader = McapReader(path)
    assert len(list(reader.messages())) <= 60
    assert reader.damage
    with pytest.raises(FileError, match=r"junk.mcap: holds no recording, demonstration or session"):
        kind_of(path)


@needs_shared
@pytest.mark.parametrize("path", sorted((SHARED / "conformance").glob("*.mcap")), ids=lambda path: path.stem)
def test_conformance(path: Path) -> None:
    expected = json.loads(path.with_suffix(".json").read_text())["records"]
    count = Counter(record["type"] for record in expected)
    reader = McapReader(path)
    read = list(reader.messages())
    assert len(read) == count["Message"]
    assert len(reader.attachments) == count["Attachment"]
    assert len(reader.metadata) == count["Metadata"]
    assert reader.damage == []
    for message, record in zip(read, (r for r in expected if r["type"] == "Message"), strict=True):
        fields = dict(record["fields"])
        assert message.time == int(fields["log_time"])
        assert list(message.data) == [int(byte) for byte in fields["data"]]
    for inside in (contents(path), contents(path, thorough=True)):
        assert sum(messages for _, messages in inside.topics.values()) == count["Message"]
        assert len(inside.attachments) == count["Attachment"]
        assert len(inside.metadata) == count["Metadata"]


@needs_shared
@pytest.mark.parametrize(
    ("name", "message"),
    [
        (
            "foreign/talker.mcap",
            r"talker.mcap: holds no recording, demonstration or session: it has /rosout ",
        ),
        ("foreign/cdr_test_0.mcap", r"it has /test_topic \(test_msgs/msg/BasicTypes\)"),
        ("foreign/only_services.mcap", r"it has /add_two_ints/_service_event"),
        ("damaged/empty.mcap", r"empty.mcap: is empty\."),
        ("damaged/magic_only_7bytes.mcap", r"7bytes.mcap: is not an MCAP file: it starts with"),
        ("damaged/sqlite_renamed.mcap", r"renamed.mcap: is not an MCAP file: it starts with b'SQLite f'"),
        ("damaged/wbag_0_cut_1_4.mcap", r"it has no messages; it is cut at byte 7,946"),
    ],
)
def test_foreign_and_damaged_files_are_refused_in_words(name: str, message: str) -> None:
    with pytest.raises(FileError, match=message):
        kind_of(SHARED / name)


def test_a_folder_and_a_missing_file(tmp_path: Path) -> None:
    with pytest.raises(FileError, match=r"is a folder, not an MCAP file\. Name the \.mcap file inside it\."):
        McapReader(tmp_path)
    with pytest.raises(FileError, match=r"none.mcap: no such file"):
        McapReader(tmp_path / "none.mcap")


def test_what_is_of_ros_1_is_refused_by_name(tmp_path: Path) -> None:
    bag = tmp_path / "a.bag"
    bag.write_bytes(b"#ROSBAG V2.0\n")
    with pytest.raises(FileError, match=r"is not an MCAP file.*ROS 1 is not read; rosbags-convert"):
        McapReader(bag)
    path = tmp_path / "a.mcap"
    with path.open("wb") as stream:
        writer = Writer(stream)
        writer.start()
        schema = writer.register_schema("geometry_msgs/PoseStamped", "ros1msg", b"")
        writer.add_message(writer.register_channel("/hand", "ros1", schema), 0, b"", 0)
        writer.finish()
    with pytest.raises(FileError, match=r"/hand \(geometry_msgs/PoseStamped\)\. ROS 1 is not read"):
        kind_of(path)
