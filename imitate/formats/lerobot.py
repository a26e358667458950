"""A folder in LeRobot's layout → columns of one episode.

meta/info.json says what there is. Since version 3 of the layout a file in data/ holds many episodes, and
before it one: data/chunk-000/episode_000000.parquet.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pyarrow as pa
import pyarrow.parquet as pq
from pydantic import BaseModel, Field, TypeAdapter

from imitate.errors import FileError
from imitate.formats.frames_in_time import EPISODES, chosen_episode
from imitate.formats.json_file import read_json
from imitate.formats.kind import LEROBOT
from imitate.formats.parquet import parquet_table
from imitate.formats.table import Table

_EPISODE = EPISODES[0]


class _Info(BaseModel):
    fps: float | None = Field(default=None, gt=0)


def lerobot_table(folder: Path, episode: int | None = None) -> Table:
    """The columns of the episode of that number, or of the only one there is.

    Raises:
        FileError: no data, damaged, or several episodes and none chosen.
    """
    rate = read_json(folder / LEROBOT, TypeAdapter(_Info), "no such file", "LeRobot writes it.").fps
    held = _episodes(folder)
    chosen = int(chosen_episode(folder, held, episode))
    table = parquet_table(held[chosen], chosen)
    return Table(folder, table.widths, table.load, rate, episode_read=True)


def facts(folder: Path) -> dict[str, Any]:
    """What there is to know of the folder before an episode is chosen."""
    held = _episodes(folder)
    columns = lerobot_table(folder, next(iter(held))).widths
    return {"episodes": len(held), "columns": dict(columns)}


def _episodes(folder: Path) -> dict[int, Path]:
    """Episode → the file that holds it."""
    files = sorted((folder / "data").glob("**/*.parquet"))
    try:
        numbers = [pq.read_table(file, columns=[_EPISODE])[_EPISODE].unique().to_pylist() for file in files]
    except (pa.ArrowException, OSError, ValueError, KeyError) as error:
        raise FileError(
            folder, f"cannot be read ({' '.join(str(error).split())})", "Copy it again."
        ) from None
    if not any(numbers):
        remedy = "In LeRobot's layout they are in data/chunk-000. Was the whole folder copied?"
        raise FileError(folder, "has meta/info.json and no episodes", remedy)
    return {number: file for file, held in zip(files, numbers, strict=True) for number in held}
