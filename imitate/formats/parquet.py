"""Demonstration ⇄ Parquet: named columns of numbers or of lists of numbers, as LeRobot's data sets have."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
from numpy.typing import NDArray

from imitate.demonstration import Demonstration
from imitate.errors import FileError
from imitate.formats.frames_in_time import EPISODES, chosen_episode
from imitate.formats.table import Table, columns_of

_EPISODE = EPISODES[0]
_REMEDY = "Write it again."


def parquet_table(path: Path, episode: int | None = None) -> Table:
    """The columns of one episode: the one of that index, or the only one there is.

    Raises:
        FileError: no Parquet, damaged, or several episodes and none chosen.
    """
    first, schema = _first_row(path)
    chosen = _chosen(path, schema, episode)
    widths = {field.name: _width(field.type, first, field.name) for field in schema}

    def load(name: str) -> NDArray[Any]:
        return _values(path, name, _read(path, [name], filters=chosen)[name].combine_chunks())

    return Table(path, widths, load, episode_read=_EPISODE in schema.names)


def write_parquet(demonstration: Demonstration, path: Path) -> None:
    """Writes every number in double precision."""
    pq.write_table(pa.table({name: np.array(v) for name, v in columns_of(demonstration).items()}), path)


def _first_row(path: Path) -> tuple[Any, Any]:
    try:
        with pq.ParquetFile(path) as file:
            schema = file.schema_arrow
            lists = [field.name for field in schema if _is_list(field.type)]
            first = next(file.iter_batches(batch_size=1, columns=lists), None) if lists else None
            return first, schema
    except (pa.ArrowException, OSError, ValueError) as error:
        raise _damaged(path, error) from None


def _read(path: Path, columns: list[str], filters: Any = None) -> Any:
    try:
        return pq.read_table(path, columns=columns, filters=filters)
    except (pa.ArrowException, OSError, ValueError) as error:
        raise _damaged(path, error) from None


def _damaged(path: Path, error: Exception) -> FileError:
    return FileError(path, f"cannot be read as Parquet ({' '.join(str(error).split())})", _REMEDY)


def _chosen(path: Path, schema: Any, episode: int | None) -> list[tuple[str, str, int]] | None:
    if _EPISODE not in schema.names:
        return None
    held = np.unique(_read(path, [_EPISODE])[_EPISODE].to_numpy()).tolist()
    return [(_EPISODE, "==", int(chosen_episode(path, held, episode)))]


def _is_list(kind: Any) -> bool:
    types = pa.types
    return any(is_one(kind) for is_one in (types.is_list, types.is_large_list, types.is_fixed_size_list))


def _is_number(kind: Any) -> bool:
    types = pa.types
    numbers = (types.is_integer, types.is_floating, types.is_boolean, types.is_timestamp)
    return any(is_one(kind) for is_one in numbers)


def _width(kind: Any, first: Any, name: str) -> int | None:
    if not _is_list(kind):
        return 1 if _is_number(kind) else None
    if not _is_number(kind.value_type) or first is None or not first[name][0].is_valid:
        return None
    return len(first[name][0])


def _values(path: Path, name: str, column: Any) -> NDArray[Any]:
    if pa.types.is_timestamp(column.type):
        ticks = column.cast(pa.timestamp("ns")).cast(pa.int64()).to_numpy(zero_copy_only=False)
        return np.asarray((ticks - ticks[0]) / 1e9 if len(ticks) else ticks, float)
    if not _is_list(column.type):
        return np.asarray(column.to_numpy(zero_copy_only=False), float)
    flat = np.asarray(column.flatten().to_numpy(zero_copy_only=False), float)
    if not len(column) or len(flat) % len(column):
        raise FileError(path, f"column {name} holds lists of different lengths", _REMEDY)
    return flat.reshape(len(column), -1)
