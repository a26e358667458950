"""Values of each object along a demonstration, as the plots show them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from imitate.demonstration import Demonstration
from imitate.geometry import Array


@dataclass(frozen=True, eq=False)
class Series:
    """Of each object a value (T,) at seconds (T,) since the first frame."""

    names: tuple[str, ...]
    t: Array
    values: tuple[Array, ...]


def distances(demonstration: Demonstration) -> Series:
    """Centimetres from the hand to each object's centre."""
    d = demonstration
    apart = np.linalg.norm(d.objects[..., :3] - d.hand[:, None, :3], axis=-1)
    return Series(d.object_names, d.t - d.t[0], tuple(100 * apart.T))


def letters(names: Sequence[str]) -> tuple[str, ...]:
    """A letter for each name, the first after what all begin with; numbers where those are not distinct."""
    length = max(map(len, names))
    differ = (k for k in range(length) if len({name[k : k + 1] for name in names}) > 1)
    k = next(differ, 0) if len(names) > 1 else 0
    found = tuple(name[k : k + 1] for name in names)
    distinct = all(found) and len(set(found)) == len(names)
    return found if distinct else tuple(str(n + 1) for n in range(len(names)))
