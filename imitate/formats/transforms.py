"""A tree of frames, as /tf_static tells it."""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass, field

from imitate.geometry import IDENTITY, Array, compose, inverse


@dataclass
class FrameTree:
    """Frames by name and how they lie in each other; the first word about two frames counts."""

    _edges: dict[str, dict[str, Array]] = field(default_factory=dict)

    def add(self, parent: str, child: str, parent_from_child: Array) -> None:
        """``parent_from_child``: pose (7,) of the child's frame in its parent's, metres."""
        self._edges.setdefault(parent, {}).setdefault(child, parent_from_child)
        self._edges.setdefault(child, {}).setdefault(parent, inverse(parent_from_child))

    def between(self, target: str, source: str) -> Array | None:
        """target_from_source (7,); None where nothing leads from one to the other."""
        found = {target: IDENTITY}
        waiting = deque([target])
        while waiting and source not in found:
            at = waiting.popleft()
            for further, pose in self._edges.get(at, {}).items():
                if further not in found:
                    found[further] = compose(found[at], pose)
                    waiting.append(further)
        return found.get(source)
