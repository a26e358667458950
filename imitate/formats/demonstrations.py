"""Demonstration ⇄ files: NPZ, CSV, Parquet and MCAP both ways; HDF5 and LeRobot's folders to read."""

from __future__ import annotations

from pathlib import Path

from imitate.demonstration import Demonstration
from imitate.errors import DemonstrationError, FileError
from imitate.formats.kind import table_format
from imitate.formats.lengths import check_lengths
from imitate.formats.mapping import Mapping
from imitate.formats.output import new_file
from imitate.formats.pose_topics import read_mcap, write_mcap
from imitate.formats.table import Table, demonstration_of

SUFFIXES = (".npz", ".csv", ".parquet", ".mcap")
"""of files that can be written."""


def read_demonstration(
    path: Path | str, mapping: Mapping | None = None, notes: list[str] | None = None
) -> Demonstration:
    """A demonstration from its file, whose format its content tells.

    Args:
        path: NPZ, CSV, Parquet, HDF5 or MCAP, or a folder of LeRobot's.
        mapping: what the file's columns, topics and frames mean, where their names do not say so.
        notes: gets what the person ought to know of how it was read, in words.

    Raises:
        FileError: missing, not readable, or lacking something; the message says what it has.
        DemonstrationError: what it holds is no demonstration; the message names the file and the field.
    """
    path, notes = Path(path), [] if notes is None else notes
    if not path.exists():
        raise FileError(path, "no such file", "Give a demonstration as .npz, .csv, .parquet, .hdf5 or .mcap.")
    try:
        read = _read(path, mapping, notes)
    except DemonstrationError as error:
        raise DemonstrationError(f"{path}: {error}") from None
    check_lengths(path, read)
    return read


def _read(path: Path, mapping: Mapping | None, notes: list[str]) -> Demonstration:
    kind = table_format(path)
    if kind == "npz" and mapping is None:
        from imitate.formats.npz import read_npz

        return read_npz(path, notes)
    if kind is not None:
        mapping = mapping or Mapping()
        return demonstration_of(_table(path, kind, mapping), mapping, notes)
    return read_mcap(path, mapping, notes)


def write_demonstration(demonstration: Demonstration, path: Path | str, force: bool = False) -> None:
    """Writes NPZ, CSV, Parquet or MCAP, by the suffix of ``path``.

    Raises:
        FileError: the file exists and ``force`` is not given, an unknown suffix, an object's name that the
            format cannot hold, or a folder that cannot be written.
    """
    path = Path(path)
    if path.suffix not in SUFFIXES:
        problem = f"cannot be written: unknown suffix {path.suffix!r}"
        raise FileError(path, problem, f"Use {', '.join(SUFFIXES[:-1])} or {SUFFIXES[-1]}.")
    if path.suffix == ".mcap" and (slashed := [n for n in demonstration.object_names if "/" in n]):
        problem = f"cannot hold {', '.join(slashed)}: in MCAP a name is the last part of a topic"
        raise FileError(path, problem, "Write .npz, or rename it.")
    try:
        with new_file(path, force) as temporary:
            _write(demonstration, temporary, path.suffix)
    except DemonstrationError as error:
        raise FileError(path, f"cannot be written: {error}", "Write .npz, or rename it.") from None


def _table(path: Path, kind: str, mapping: Mapping) -> Table:
    if kind == "npz":
        from imitate.formats.npz import npz_table

        return npz_table(path)
    if kind == "csv":
        from imitate.formats.csv_file import csv_table

        return csv_table(path)
    if kind == "parquet":
        from imitate.formats.parquet import parquet_table

        return parquet_table(path, mapping.episode)
    if kind == "lerobot":
        from imitate.formats.lerobot import lerobot_table

        return lerobot_table(path, mapping.episode)
    from imitate.formats.hdf5 import hdf5_table

    return hdf5_table(path, mapping.episode)


def _write(demonstration: Demonstration, path: Path, suffix: str) -> None:
    if suffix == ".csv":
        from imitate.formats.csv_file import write_csv

        write_csv(demonstration, path)
    elif suffix == ".parquet":
        from imitate.formats.parquet import write_parquet

        write_parquet(demonstration, path)
    elif suffix == ".npz":
        from imitate.formats.npz import write_npz

        with path.open("wb") as stream:
            write_npz(demonstration, stream)
    else:
        with path.open("wb") as stream:
            write_mcap(demonstration, stream)
