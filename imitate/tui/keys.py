"""Keys of one's own in place of ours, and what keys do as commands that can be searched for."""

from __future__ import annotations

import tomllib
from collections.abc import Iterator, Mapping
from functools import partial
from importlib import import_module
from pathlib import Path
from pkgutil import iter_modules
from typing import Any

from textual.app import App, SystemCommand
from textual.binding import Binding
from textual.dom import DOMNode
from textual.keys import Keys, key_to_character
from textual.screen import Screen

import imitate.tui
from imitate.errors import FileError, UnknownNameError
from imitate.settings import dotted
from imitate.text_file import read_text

_NAMED = {key.value for key in Keys}
_MODIFIERS = {"ctrl", "shift", "alt"}
_EVERYWHERE = {"app", "step"}
"""first parts of ids of the keys that act in every step."""
_NOTES = {"confirm", "fingers", "form", "help", "picture"}
"""of those that act over a step, where its own do not."""
_BESIDE = {"player": {"reproduce", "replay"}, "picture": {"fingers"}}
"""of those that act together with others."""
_REMEDY = 'Expected such as learn.stop = "S", or "f5,ctrl+s" for two keys; ? and ctrl+p tell the keys.'


def bindings() -> dict[str, Binding]:
    """Every key that can be another, by its id: "learn.stop"."""
    for module in iter_modules(imitate.tui.__path__):
        import_module(f"imitate.tui.{module.name}")
    found: dict[str, Binding] = {}
    kinds = [DOMNode]
    while kinds:
        kind = kinds.pop()
        kinds += kind.__subclasses__()
        if kind.__module__.startswith("imitate."):
            own = kind.__dict__.get("BINDINGS", ())
            found |= {b.id: b for b in own if isinstance(b, Binding) and b.id}
    return dict(sorted(found.items()))


def read_keys(path: Path) -> dict[str, str]:
    """A TOML file's keys by id, as Textual's keymap: `[learn]` and `stop = "S"` is {"learn.stop": "S"}.

    Raises:
        FileError: missing, not TOML, what is no key, or one that means something else at the same time.
        UnknownNameError: an id that no key has; names those that there are.
    """
    try:
        given = dotted(tomllib.loads(read_text(path)))
    except FileNotFoundError:
        raise FileError(path, "no such file of keys", _REMEDY) from None
    except (OSError, UnicodeDecodeError, tomllib.TOMLDecodeError) as error:
        raise FileError(path, f"cannot be read ({error})", _REMEDY) from None
    ours = bindings()
    for name, keys in given.items():
        if name not in ours:
            raise UnknownNameError(f"key in {path}:", name, ours)
        if not (isinstance(keys, str) and all(_is_key(key) for key in _keys(keys))):
            raise FileError(path, f"{name}: {keys!r} is no key", _REMEDY)
    for name, keys in given.items():
        for key in _keys(keys):
            if other := _taken(key, name, {k: given.get(k, b.key) for k, b in ours.items()}):
                problem = f"{name}: {key} is the key of {other} there ({ours[other].description})"
                raise FileError(path, problem, "Choose another, or give that one another key too.")
    return given


def commands(app: App[Any], screen: Screen[Any]) -> Iterator[SystemCommand]:
    """What the keys do that do something now, each with its key and its id."""
    told = {"app.commands"}
    for active in screen.active_bindings.values():
        binding = active.binding
        if not (active.enabled and binding.id and binding.tooltip) or binding.id in told:
            continue
        told.add(binding.id)
        if len(binding.key_display or "") != 2:  # those in pairs, as ←→, move rather than do
            shown = f"{app.get_key_display(binding)} · {binding.id}"
            act = partial(app.run_action, binding.action, active.node)
            yield SystemCommand(binding.tooltip.partition(";")[0], shown, act)


def _keys(text: str) -> list[str]:
    return [key.strip() for key in text.split(",")]


def _is_key(text: str) -> bool:
    *modifiers, key = text.split("+") if len(text) > 1 else [text]
    known = key in _NAMED or key_to_character(key) is not None
    return known and set(modifiers) <= _MODIFIERS


def _taken(key: str, name: str, keymap: Mapping[str, str]) -> str:
    # The id of another key that is the same in the same place; empty where there is none.
    place = name.partition(".")[0]
    for other, keys in keymap.items():
        if (
            other != name
            and _together({place, other.partition(".")[0]})
            and _one(key) in map(_one, _keys(keys))
        ):
            return other
    return ""


def _together(places: set[str]) -> bool:
    if places & _NOTES:
        return len(places) == 1 or any({place, *others} >= places for place, others in _BESIDE.items())
    beside = any(place in places and places & others for place, others in _BESIDE.items())
    return len(places) == 1 or bool(places & _EVERYWHERE) or beside


def _one(key: str) -> str:
    # "?" and "question_mark" are one key.
    return key_to_character(key) or key
