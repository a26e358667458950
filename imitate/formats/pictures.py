"""One picture as cameras send it: raw encodings, JPEG and PNG, and ROS's compressed depth.

Encodings: sensor_msgs/image_encodings.hpp, REP 118 (depth), and foxglove.RawImage. Compressed: ROS's
compressed_image_transport and compressed_depth_image_transport, foxglove.CompressedImage.
"""

from __future__ import annotations

import struct
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

Pixels = NDArray[Any]
"""(H, W, 3) uint8 red green blue; (H, W) uint8 grey; or depth: (H, W) uint16 steps or float32."""

_PNG = b"\x89PNG"
_COMPRESSED_DEPTH = struct.Struct("<iff")
_RAW: dict[str, tuple[str, int, int | None]] = {
    "rgb8": ("u1", 3, None),
    "8UC3": ("u1", 3, cv2.COLOR_BGR2RGB),
    "bgr8": ("u1", 3, cv2.COLOR_BGR2RGB),
    "rgba8": ("u1", 4, cv2.COLOR_RGBA2RGB),
    "bgra8": ("u1", 4, cv2.COLOR_BGRA2RGB),
    "8UC4": ("u1", 4, cv2.COLOR_BGRA2RGB),
    "mono8": ("u1", 1, None),
    "8UC1": ("u1", 1, None),
    "16UC1": ("u2", 1, None),
    "mono16": ("u2", 1, None),
    "32FC1": ("f4", 1, None),
    "bayer_rggb8": ("u1", 1, cv2.COLOR_BayerRGGB2RGB),
    "bayer_bggr8": ("u1", 1, cv2.COLOR_BayerBGGR2RGB),
    "bayer_gbrg8": ("u1", 1, cv2.COLOR_BayerGBRG2RGB),
    "bayer_grbg8": ("u1", 1, cv2.COLOR_BayerGRBG2RGB),
    "yuv422": ("u1", 2, cv2.COLOR_YUV2RGB_UYVY),
    "uyvy": ("u1", 2, cv2.COLOR_YUV2RGB_UYVY),
    "yuv422_yuy2": ("u1", 2, cv2.COLOR_YUV2RGB_YUY2),
    "yuyv": ("u1", 2, cv2.COLOR_YUV2RGB_YUY2),
}
"""encoding → (type of a band, bands, OpenCV's conversion to red green blue)."""


def is_depth(pixels: Pixels) -> bool:
    """Whether decoded pixels are distances and not colours or greys."""
    return pixels.ndim == 2 and pixels.dtype != np.uint8


def raw(
    encoding: str, width: int, height: int, step: int, data: bytes, big_endian: bool = False
) -> Pixels | None:
    """Pixels of a raw picture whose rows are ``step`` bytes apart; None where it cannot be decoded."""
    form = _RAW.get(encoding)
    if form is None or not (width and height) or len(data) < step * (height - 1):
        return None
    kind, bands, conversion = form
    dtype = np.dtype(kind).newbyteorder(">" if big_endian else "<")
    row = width * bands * dtype.itemsize
    if step < row or len(data) < step * (height - 1) + row:
        return None
    bytes_ = np.frombuffer(data.ljust(step * height, b"\0"), np.uint8)[: step * height]
    packed = np.ascontiguousarray(bytes_.reshape(height, step)[:, :row]).view(dtype)
    pixels = packed.astype(dtype.newbyteorder("="), copy=False).reshape(height, width, bands)
    if conversion is not None:
        return np.asarray(cv2.cvtColor(pixels, conversion))
    return pixels if bands == 3 else pixels[..., 0]


def compressed(form: str, data: bytes) -> Pixels | None:
    """Pixels of a compressed picture; ``form`` as in its message, for instance "jpeg" or
    "16UC1; compressedDepth png". None where it cannot be decoded.
    """
    if "compressedDepth" in form or (_PNG in data[4:16] and not data.startswith(_PNG)):
        return _compressed_depth(form, data)
    pixels = _imdecode(data)
    if pixels is None:
        return None
    if pixels.ndim == 2:
        return pixels if pixels.dtype in (np.uint8, np.uint16, np.float32) else None
    if pixels.dtype != np.uint8:
        return None
    # "rgb8; jpeg compressed rgb8" was handed to an encoder that takes it for blue green red
    swapped = "compressed rgb" in form
    return np.ascontiguousarray(pixels[..., :3] if swapped else pixels[..., 2::-1])


def _compressed_depth(form: str, data: bytes) -> Pixels | None:
    """Twelve bytes of header, then a PNG of steps, or for 32FC1 of inverse depth: a / (step − b)."""
    if len(data) < _COMPRESSED_DEPTH.size or "rvl" in form.lower():
        return None
    _, a, b = _COMPRESSED_DEPTH.unpack_from(data)
    steps = _imdecode(data[_COMPRESSED_DEPTH.size :])
    if steps is None or steps.ndim != 2 or steps.dtype != np.uint16:
        return None
    if not form.startswith("32FC1"):
        return steps
    with np.errstate(divide="ignore"):
        depth = a / (steps.astype(np.float32) - b)
    return np.where((steps > 0) & np.isfinite(depth) & (depth > 0), depth, 0).astype(np.float32)


def _imdecode(data: bytes) -> Pixels | None:
    if not data:
        return None
    try:
        found = cv2.imdecode(np.frombuffer(data, np.uint8), cv2.IMREAD_UNCHANGED)
    except cv2.error:
        return None
    return None if found is None else np.asarray(found)
