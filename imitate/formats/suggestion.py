"""A mapping to start from, for a file whose columns were not recognised."""

from __future__ import annotations

import json
import re
from collections.abc import Collection, Iterable, Mapping, Sequence

import numpy as np

_HAND = re.compile(r"hand|eef|\bee\b|gripper|tcp|tool|palm|wrist", re.IGNORECASE)
_POSITION = re.compile(r"(?P<body>.*?)[._/ ]?(?:position|pos|xyz)", re.IGNORECASE)
_ROTATION = re.compile(r"(?P<body>.*?)[._/ ]?(?:orientation|rotation|quaternion|quat)", re.IGNORECASE)


def suggested(
    widths: Mapping[str, int | None],
    bodies: Mapping[str, Mapping[str, str]],
    times: Collection[str],
    timed: bool = False,
) -> str:
    """A mapping in TOML that names as much as the columns' names tell; the rest is for the person to change.

    Args:
        widths: column → numbers a row, None where it holds none.
        bodies: body → axis → column, as recognised.
        times: names of columns of times, in lower case.
        timed: whether the file says its rate elsewhere.
    """
    time = next((name for name in widths if name.lower() in times), None)
    found = _parts(widths, bodies) or {"hand": _made_up(widths, 0), "cube": _made_up(widths, 7)}
    hand = (
        "hand" if "hand" in found else next((name for name in found if _HAND.search(name)), next(iter(found)))
    )
    said = "".join(found[hand])
    spare = {name: width for name, width in widths.items() if json.dumps(name) not in said}
    objects = {name: part for name, part in found.items() if name != hand} or {"cube": _made_up(spare, 0)}
    lines = [f"time = {json.dumps(time)}"] if time else []
    lines += [] if time or timed else ["rate = 20.0            # frames a second"]
    lines += ['rotation_as = "xyzw"   # or wxyz, rotvec, rpy', "", "[hand]", *found[hand]]
    for name, part in objects.items():
        lines += ["", f"[objects.{_key(name)}]", *part, "size = [0.04, 0.04, 0.04]   # m, where known"]
    return "\n".join(f"    {line}".rstrip() for line in lines)


def _parts(widths: Mapping[str, int | None], bodies: Mapping[str, Mapping[str, str]]) -> dict[str, list[str]]:
    found = {}
    for name, axes in bodies.items():
        if all(axis in axes for axis in "xyz"):
            turning = [axes[axis] for axis in ("qx", "qy", "qz", "qw") if axis in axes]
            found[name] = [f"position = {json.dumps([axes[axis] for axis in 'xyz'])}"]
            found[name] += [f"rotation = {json.dumps(turning)}"] if len(turning) == 4 else []
    for column, width in widths.items():
        position = _POSITION.fullmatch(column)
        if position is None or width != 3:
            continue
        found[position["body"].rsplit("/", 1)[-1] or "cube"] = [f"position = {json.dumps(column)}"] + [
            f"rotation = {json.dumps(other)}"
            for other, count in widths.items()
            if (match := _ROTATION.fullmatch(other)) and match["body"] == position["body"] and count == 4
        ]
    return found


def _made_up(widths: Mapping[str, int | None], first: int) -> list[str]:
    widest = max((name for name in widths if widths[name]), key=lambda name: widths[name] or 0, default=None)
    if widest is None or (widths[widest] or 0) < first + 7:
        return ['position = ["X", "Y", "Z"]', 'rotation = ["QX", "QY", "QZ", "QW"]']
    return [
        f"position = {json.dumps(f'{widest}[{first}:{first + 3}]')}",
        f"rotation = {json.dumps(f'{widest}[{first + 3}:{first + 7}]')}",
    ]


def _key(name: str) -> str:
    return name if re.fullmatch(r"[A-Za-z0-9_-]+", name) else json.dumps(name)


def suggested_topics(topics: Sequence[str], frames: Sequence[str]) -> str:
    """The same for an MCAP file, of topics of poses and frames of transforms."""
    sources = [("topic", name) for name in topics] + [("frame", name) for name in frames]
    if not sources:
        sources = [("topic", "/hand/pose"), ("topic", "/cube/pose")]
    hand = next((source for source in sources if _HAND.search(source[1])), sources[0])
    lines = ["[hand]", f"{hand[0]} = {json.dumps(hand[1])}"]
    for kind, name in [source for source in sources if source != hand][:3] or [("frame", "cube")]:
        parts = [part for part in name.split("/") if part not in ("", "pose")]
        lines += ["", f"[objects.{_key(parts[-1] if parts else 'cube')}]", f"{kind} = {json.dumps(name)}"]
        lines += ["size = [0.04, 0.04, 0.04]   # m, where known"]
    return "\n".join(f"    {line}".rstrip() for line in lines)


def suggested_sizes(sizes: Mapping[str, Iterable[float]]) -> str:
    """The objects with their sizes (3,) in metres, NaN where not known, as a mapping has them."""
    lines = []
    for name, size in sizes.items():
        sides = [float(f"{side:.6g}") for side in size]
        lines += [f"[objects.{_key(name)}]", *([] if np.isnan(sides).any() else [f"size = {sides}"])]
    return "\n".join(f"    {line}" for line in lines)
