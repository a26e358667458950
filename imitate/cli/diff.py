"""`imitate diff`: in what two sessions differ."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from imitate.cli import console

if TYPE_CHECKING:
    from imitate.session.difference import SessionDifference, Topic


def diff(
    first: Annotated[Path, typer.Argument(metavar="A", help="A session.")],
    second: Annotated[Path, typer.Argument(metavar="B", help="Another.")],
    steps: Annotated[bool, typer.Option(help="Compare the trials' steps too.")] = True,
    as_json: console.Json = False,
) -> None:
    """Say in what two sessions differ: settings, decisions, and the first difference of each topic.

    Exit code 3 says that they do.
    """
    from imitate.formats.session_log import summarise
    from imitate.session.difference import difference

    total = max(summarise(path).trials for path in (first, second))
    with console.progress() as bar:
        task = bar.add_task("comparing", total=total)
        found = difference(first, second, steps, lambda done: bar.update(task, completed=done))
    for path, damage in zip((first, second), found.damage, strict=True):
        for words in damage:
            console.narrate(f"warning: {path} is damaged: {words}. What could be read was compared.")
    console.write_json(_plain(found)) if as_json else _show(found)
    if not found.equal or any(found.damage):
        raise typer.Exit(console.Exit.LOSSY)


def _plain(found: SessionDifference) -> dict[str, Any]:
    return {
        "equal": found.equal,
        "settings": {s.name: [s.first, s.second] for s in found.settings},
        "decisions": list(found.decisions),
        "topics": {topic.name: _plain_topic(topic) for topic in found.topics},
        "damage": list(found.damage),
    }


def _plain_topic(topic: Topic) -> dict[str, Any]:
    plain: dict[str, Any] = {"equal": topic.equal, "messages": list(topic.counts)}
    if topic.difference:
        d = topic.difference
        segment, formulation, trial = topic.where
        values = [console.number(d.recorded), console.number(d.replayed)]
        plain["first"] = {"message": topic.number, "field": d.field, "values": values, "step": d.step}
        plain["first"] |= {"segment": segment, "formulation": formulation, "trial": trial}
    return plain


def _show(found: SessionDifference) -> None:
    if found.equal:
        messages = sum(topic.counts[0] for topic in found.topics)
        console.write(f"equal: all {messages:,} messages compared, bit for bit")
    if found.settings:
        table = console.table("setting", "A", "B")
        for setting in found.settings:
            table.add_row(setting.name, _value(setting.first), _value(setting.second))
        console.show(table)
    if found.decisions[0] != found.decisions[1]:
        for name, decided in zip("AB", found.decisions, strict=True):
            console.write(f"decisions in {name}: {'; '.join(decided) or 'none'}")
    if not found.equal:
        table = console.table("topic", "A", "B", "first difference", right=("A", "B"))
        for topic in found.topics:
            table.add_row(topic.name, f"{topic.counts[0]:,}", f"{topic.counts[1]:,}", _in_words(topic))
        console.show(table)


def _value(value: Any) -> str:
    return "not there" if value is None else repr(value)


def _in_words(topic: Topic) -> str:
    if topic.difference is None:
        return "" if topic.equal else "those that both have are equal"
    d = topic.difference
    if d.field == "settings":
        return "the settings above"
    segment, formulation, trial = topic.where
    named = (("segment", segment), ("formulation", formulation), ("trial", trial), ("step", d.step))
    places = [f"{name} {number}" for name, number in named if number is not None]
    return f"{', '.join(places) or f'message {topic.number}'}: {d.field} {d.recorded!r} ≠ {d.replayed!r}"
