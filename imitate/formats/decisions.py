"""The operator's decisions ⇄ a JSON file, so that they can be kept and applied again."""

from __future__ import annotations

import json
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from pydantic import ConfigDict, TypeAdapter

from imitate.errors import FileError
from imitate.formats.json_file import read_json
from imitate.formats.output import new_file
from imitate.skill import Decision
from imitate.text_file import read_text

_DECISIONS = TypeAdapter(tuple[Decision, ...], config=ConfigDict(extra="forbid"))
_FIELDS: dict[str, tuple[str, ...]] = {
    "move": ("segment", "time"),
    "split": ("segment", "time"),
    "merge": ("segment",),
    "relabel": ("segment", "abstraction"),
    "reset": (),
    "undo": (),
    "redo": (),
}
_REMEDY = (
    'Expected a list such as [{"kind": "move", "segment": 0, "time": 8.3}, {"kind": "relabel", "segment": 1, '
    '"abstraction": {"relevant": ["hand", "blue"], "reference": "green"}}]; kinds are move, relabel, split, '
    "merge, reset, undo and redo."
)


def read_decisions(path: Path | str) -> tuple[Decision, ...]:
    """Decisions in order, with the fields of `imitate.skill.Decision`.

    Raises:
        FileError: missing, not JSON, or a field that is wrong or lacking; the message names it.
    """
    decisions = read_json(path, _DECISIONS, "no such decisions file", _REMEDY)
    for k, given in enumerate(json.loads(read_text(path))):
        lacking = [field for field in _FIELDS[given["kind"]] if given.get(field) is None]
        if lacking:
            raise FileError(path, f"{k}.{lacking[0]}: missing, and {given['kind']} needs it", _REMEDY)
    return decisions


def write_decisions(path: Path | str, decisions: Sequence[Decision], force: bool = False) -> None:
    """Writes decisions, one a line, each with the fields that its kind needs.

    Raises:
        FileError: the file exists and ``force`` is not given, or it cannot be written.
    """
    with new_file(Path(path), force) as temporary:
        temporary.write_text(decisions_json(decisions), encoding="utf-8")


def decisions_json(decisions: Sequence[Decision]) -> str:
    """What `read_decisions` reads."""
    lines = ",\n ".join(json.dumps(_plain(decision), ensure_ascii=False) for decision in decisions)
    return f"[{lines}]\n"


def _plain(decision: Decision) -> dict[str, Any]:
    plain: dict[str, Any] = {"kind": decision.kind}
    for field in _FIELDS[decision.kind]:
        value = getattr(decision, field)
        if field == "abstraction" and value is not None:
            value = {"relevant": list(value.relevant), "reference": value.reference}
        plain[field] = value
    return plain
