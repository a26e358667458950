"""Foxglove's JSON schemas say the same as its Protocol Buffers."""

import base64
import json

import numpy as np
import pytest
import scripted
from mcap.writer import Writer

from imitate.errors import FileError
from imitate.formats.camera_messages import CameraReader
from imitate.formats.demonstrations import read_demonstration
from imitate.formats.kind import kind_of
from imitate.formats.mcap_file import McapReader

START = 1_700_000_000
FRAMES = 40


def written(path, messages, encoding="json"):
    """An MCAP file of (topic, schema, fields, nanoseconds)."""
    with path.open("wb") as stream:
        writer = Writer(stream)
        writer.start()
        channels = {}
        for topic, schema, fields, time in messages:
            if topic not in channels:
                key = writer.register_schema(schema, "jsonschema", b'{"type": "object"}')
                channels[topic] = writer.register_channel(topic, encoding, key)
            data = fields if isinstance(fields, bytes) else json.dumps(fields).encode()
            writer.add_message(channels[topic], log_time=time, publish_time=time, data=data)
        writer.finish()
    return path


def parts(k):
    """The time of a frame, and of each body its place and its orientation, as JSON has them."""
    d = scripted.demonstration()
    ns = round(d.t[k] * 1e9)
    stamp = {"sec": START + ns // 10**9, "nsec": ns % 10**9}
    for name in ("hand", "blue", "green"):
        pose = d.pose_of(name)[k].tolist()
        place = dict(zip("xyz", pose[:3], strict=True))
        yield name, stamp, place, dict(zip("xyzw", pose[3:], strict=True)), START * 10**9 + ns


def poses():
    for k in range(FRAMES):
        for name, stamp, position, orientation, time in parts(k):
            pose = {"position": position, "orientation": orientation}
            fields = {"timestamp": stamp, "frame_id": "world", "pose": pose, "extra": 1}
            yield f"/{name}/pose", "foxglove.PoseInFrame", fields, time


def transforms(together):
    for k in range(FRAMES):
        rows = [
            ({"timestamp": stamp, "parent_frame_id": "world", "child_frame_id": name}
             | {"translation": place, "rotation": turn}, time)
            for name, stamp, place, turn, time in parts(k)
        ]  # fmt: skip
        if together:
            yield "/tf", "foxglove.FrameTransforms", {"transforms": [row for row, _ in rows]}, rows[0][1]
        else:
            yield from (("/tf", "foxglove.FrameTransform", row, time) for row, time in rows)


@pytest.mark.parametrize("messages", [poses, lambda: transforms(True), lambda: transforms(False)])
def test_poses_and_transforms_are_read(tmp_path, messages):
    path = written(tmp_path / "a.mcap", messages())
    assert kind_of(path) == "demonstration"
    read, shown = read_demonstration(path), scripted.demonstration()
    assert read.object_names == ("blue", "green")
    assert np.allclose(read.t - read.t[0], shown.t[:FRAMES], atol=1e-6)
    assert np.array_equal(read.hand, shown.hand[:FRAMES])
    assert np.array_equal(read.objects, shown.objects[:FRAMES])


@pytest.mark.parametrize(
    "wrong",
    [
        b"{",
        b"[]",
        b'{"pose": 3}',
        b'{"timestamp": {"sec": "now", "nsec": 0}}',
        b'{"pose": {"position": {"x": "a"}}}',
    ],
)
def test_what_is_no_such_message_is_named(tmp_path, wrong):
    broken = ("/hand", "foxglove.PoseInFrame", wrong, 0)
    with pytest.raises(FileError, match=r"topic /hand holds a message that is no foxglove\.PoseInFrame"):
        read_demonstration(written(tmp_path / "a.mcap", [broken]))


def test_a_picture_is_read_too(tmp_path):
    image = np.arange(12, dtype=np.uint8).reshape(2, 2, 3)
    fields = {
        "timestamp": {"sec": 1, "nsec": 5}, "frame_id": "camera", "width": 2, "height": 2, "encoding": "rgb8",
        "step": 6, "data": base64.b64encode(image.tobytes()).decode(),
    }  # fmt: skip
    path = written(tmp_path / "a.mcap", [("/image", "foxglove.RawImage", fields, 7)])
    (message,) = McapReader(path).messages()
    picture = CameraReader(path).picture(message)
    assert picture.time == 1_000_000_005
    assert np.array_equal(picture.decode(), image)


def test_an_encoding_that_is_not_read_is_named(tmp_path):
    path = written(tmp_path / "a.mcap", [("/hand", "foxglove.PoseInFrame", b"\0", 0)], encoding="flatbuffer")
    with pytest.raises(FileError, match=r"has poses encoded as flatbuffer, which are not read; it has /hand"):
        read_demonstration(path)
