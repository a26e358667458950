"""ROS 2 bags in MCAP, written by mcap-ros2-support for the tests to read."""

from contextlib import contextmanager

import cv2
import numpy as np
from mcap_ros2.writer import Writer

_LINE = "=" * 80
_HEADER = (
    f"{_LINE}\nMSG: std_msgs/Header\nbuiltin_interfaces/Time stamp\nstring frame_id\n"
    f"{_LINE}\nMSG: builtin_interfaces/Time\nint32 sec\nuint32 nanosec\n"
)
_POINT = "float64 x\nfloat64 y\nfloat64 z\n"
DEFINITIONS = {
    "sensor_msgs/msg/Image": (
        "std_msgs/Header header\nuint32 height\nuint32 width\nstring encoding\nuint8 is_bigendian\n"
        f"uint32 step\nuint8[] data\n{_HEADER}"
    ),
    "sensor_msgs/msg/CompressedImage": f"std_msgs/Header header\nstring format\nuint8[] data\n{_HEADER}",
    "sensor_msgs/msg/CameraInfo": (
        "std_msgs/Header header\nuint32 height\nuint32 width\nstring distortion_model\nfloat64[] d\n"
        "float64[9] k\nfloat64[9] r\nfloat64[12] p\nuint32 binning_x\nuint32 binning_y\n"
        f"sensor_msgs/RegionOfInterest roi\n{_HEADER}{_LINE}\nMSG: sensor_msgs/RegionOfInterest\n"
        "uint32 x_offset\nuint32 y_offset\nuint32 height\nuint32 width\nbool do_rectify\n"
    ),
    "sensor_msgs/msg/PointCloud2": (
        "std_msgs/Header header\nuint32 height\nuint32 width\nsensor_msgs/PointField[] fields\n"
        "bool is_bigendian\nuint32 point_step\nuint32 row_step\nuint8[] data\nbool is_dense\n"
        f"{_HEADER}{_LINE}\nMSG: sensor_msgs/PointField\nstring name\nuint32 offset\nuint8 datatype\n"
        "uint32 count\n"
    ),
    "tf2_msgs/msg/TFMessage": (
        f"geometry_msgs/TransformStamped[] transforms\n{_LINE}\nMSG: geometry_msgs/TransformStamped\n"
        f"std_msgs/Header header\nstring child_frame_id\nTransform transform\n{_HEADER}"
        f"{_LINE}\nMSG: geometry_msgs/Transform\nVector3 translation\nQuaternion rotation\n"
        f"{_LINE}\nMSG: geometry_msgs/Vector3\n{_POINT}"
        f"{_LINE}\nMSG: geometry_msgs/Quaternion\n{_POINT}float64 w\n"
    ),
}


class Bag:
    """Messages as plain values; ``t`` (seconds) is the stamp, and the log time unless ``logged`` is given."""

    def __init__(self, stream):
        self._writer = Writer(stream)
        self._schemas = {name: self._writer.register_msgdef(name, text) for name, text in DEFINITIONS.items()}

    def write(self, topic, kind, message, t=0.0, logged=None):
        schema = self._schemas[next(name for name in DEFINITIONS if name.endswith(f"/{kind}"))]
        self._writer.write_message(topic, schema, message, round((t if logged is None else logged) * 1e9))

    def image(self, topic, pixels, encoding, t=0.0, frame="camera", logged=None, padding=0):
        rows = np.ascontiguousarray(pixels).reshape(pixels.shape[0], -1)
        rows = rows.view(np.uint8).reshape(pixels.shape[0], -1)
        rows = np.pad(rows, ((0, 0), (0, padding)))
        message = {
            "header": header(t, frame),
            "height": pixels.shape[0],
            "width": pixels.shape[1],
            "encoding": encoding,
            "is_bigendian": int(pixels.dtype.byteorder == ">"),
            "step": rows.shape[1],
            "data": rows.tobytes(),
        }
        self.write(topic, "Image", message, t, logged)

    def compressed(self, topic, data, form, t=0.0, frame="camera"):
        self.write(topic, "CompressedImage", {"header": header(t, frame), "format": form, "data": data}, t)

    def info(self, topic, i, t=0.0, frame="camera", model="plumb_bob", d=(0.0,) * 5):
        message = {
            "header": header(t, frame),
            "height": i.height,
            "width": i.width,
            "distortion_model": model,
            "d": list(d),
            "k": [i.fx, 0.0, i.cx, 0.0, i.fy, i.cy, 0.0, 0.0, 1.0],
            "r": [1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0],
            "p": [i.fx, 0.0, i.cx, 0.0, 0.0, i.fy, i.cy, 0.0, 0.0, 0.0, 1.0, 0.0],
            "binning_x": 0,
            "binning_y": 0,
            "roi": {"x_offset": 0, "y_offset": 0, "height": 0, "width": 0, "do_rectify": False},
        }
        self.write(topic, "CameraInfo", message, t)

    def transform(self, topic, parent, child, pose, t=0.0):
        x, y, z, qx, qy, qz, qw = map(float, pose)
        held = {
            "translation": {"x": x, "y": y, "z": z},
            "rotation": {"x": qx, "y": qy, "z": qz, "w": qw},
        }
        one = {"header": header(t, parent), "child_frame_id": child, "transform": held}
        self.write(topic, "TFMessage", {"transforms": [one]}, t)

    def cloud(self, topic, points, colour, t=0.0, frame="camera", height=None, logged=None):
        table = np.zeros(len(points), [(n, "<f4") for n in "xyz"] + [("pad", "<u4"), ("rgb", "<u4")])
        for axis, values in zip("xyz", points.T, strict=True):
            table[axis] = values
        table["rgb"] = (colour.astype(np.uint32) << [16, 8, 0]).sum(axis=1)
        rows = height or 1
        offsets = {"x": 0, "y": 4, "z": 8, "rgb": 16}
        message = {
            "header": header(t, frame),
            "height": rows,
            "width": len(points) // rows,
            "fields": [{"name": n, "offset": o, "datatype": 7, "count": 1} for n, o in offsets.items()],
            "is_bigendian": False,
            "point_step": table.itemsize,
            "row_step": table.itemsize * (len(points) // rows),
            "data": table.tobytes(),
            "is_dense": False,
        }
        self.write(topic, "PointCloud2", message, t, logged)


def header(t, frame):
    """std_msgs/Header."""
    nanoseconds = round(t * 1e9)
    return {"stamp": {"sec": nanoseconds // 10**9, "nanosec": nanoseconds % 10**9}, "frame_id": frame}


@contextmanager
def bag(path):
    """A new bag, whole when the block ends."""
    with path.open("wb") as stream:
        made = Bag(stream)
        yield made
        made._writer.finish()


def png(pixels):
    """The bytes of a PNG."""
    return cv2.imencode(".png", pixels)[1].tobytes()
