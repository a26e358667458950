"""HDF5 → columns: robomimic's and robosuite's data/demo_K groups, or any file of arrays (T,) and (T, n)."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import h5py
import numpy as np
from numpy.typing import NDArray

from imitate.errors import FileError
from imitate.formats.table import Table

_PREFIX = "demo_"


def hdf5_table(path: Path, episode: int | None = None) -> Table:
    """The arrays of one demonstration, named by their path within its group.

    Its rate is robosuite's control frequency, where the file's ``env_args`` say it.

    Raises:
        FileError: no HDF5, damaged, or several demonstrations and none chosen.
    """
    try:
        with h5py.File(path, "r") as file:
            group = _chosen(path, file, episode)
            rate = _rate(file)
            widths: dict[str, int | None] = {}
            file[group].visititems(lambda name, item: _describe(widths, name, item))
    except (OSError, RuntimeError, KeyError, ValueError) as error:
        raise _damaged(path, error) from None

    def load(name: str) -> NDArray[Any]:
        try:
            with h5py.File(path, "r") as file:
                return np.asarray(file[group][name][()])
        except (OSError, RuntimeError, KeyError, ValueError) as error:
            raise _damaged(path, error) from None

    return Table(path, widths, load, rate, episode_read=group != "/")


def _describe(widths: dict[str, int | None], name: str, item: Any) -> None:
    if isinstance(item, h5py.Dataset) and item.ndim in (1, 2) and item.shape[0] > 1:
        widths[name] = (item.shape[1] if item.ndim == 2 else 1) if item.dtype.kind in "fiub" else None


def _chosen(path: Path, file: Any, episode: int | None) -> str:
    data = file.get("data")
    held = [name for name in data if name.startswith(_PREFIX)] if isinstance(data, h5py.Group) else []
    if not held and episode is None:
        return "/"
    wanted = held[0] if episode is None and len(held) == 1 else f"{_PREFIX}{episode}"
    if wanted not in held:
        numbers = sorted(int(name.removeprefix(_PREFIX)) for name in held if name[len(_PREFIX) :].isdecimal())
        problem = f"holds {len(held)} demonstrations" if held else f"has no group data/{_PREFIX}0"
        problem += f", {_PREFIX}{numbers[0]} to {_PREFIX}{numbers[-1]}" if numbers else ""
        raise FileError(
            path,
            problem + (f", and none of them is {wanted}" if episode is not None and held else ""),
            f"Choose one in a mapping (--mapping FILE.toml): episode = {numbers[0] if numbers else 0}.",
        )
    return f"data/{wanted}"


def _rate(file: Any) -> float | None:
    try:
        return float(json.loads(file["data"].attrs["env_args"])["env_kwargs"]["control_freq"])
    except (KeyError, TypeError, ValueError):
        return None


def _damaged(path: Path, error: Exception) -> FileError:
    return FileError(path, f"cannot be read as HDF5 ({' '.join(str(error).split())})", "Copy it again.")
