"""When the poses of a file's bodies were taken, and whether by one clock."""

from __future__ import annotations

from collections.abc import Sequence

from imitate.errors import FileError
from imitate.formats.clock import ASTRAY, MUCH_ASTRAY, SECOND, Both, astray_note, gaps_in_words
from imitate.formats.track import Times, Track, Tracks


def taken(tracks: Tracks, bodies: dict[str, Track]) -> dict[str, Sequence[Both]]:
    """Stamps and log times of what moves each body, as far as it moves."""
    found: dict[str, Sequence[Both]] = {}
    for name, body in bodies.items():
        for number, link in enumerate(tracks.links(body)):
            if link.moves:
                found[name if number == 0 else f"{name}'s frame {link.frame}"] = link.taken
    return found


def check_times(tracks: Tracks, bodies: dict[str, Track], times: Times, notes: list[str]) -> None:
    """Says in ``notes`` what was left out, and where the hand's ``times`` have gaps.

    Raises:
        FileError: a body is nowhere at any time of the hand's, or much of it is off its clock.
    """
    for name, body in bodies.items():
        for link in tracks.links(body):
            of = len(link.taken)
            if link.astray > MUCH_ASTRAY * of:
                problem = f"{link.astray} of {of} poses of {name} are more than {ASTRAY:g} s off those around"
                raise FileError(tracks.path, problem, "Record it again with one clock.")
            notes += [astray_note(f"poses of {name}", link.astray, of)] if link.astray else []
        if body.moves and (body.times[0] > times[-1] or body.times[-1] < times[0]):
            raise _apart(tracks, name, body.times, times)
    notes += gaps_in_words((times - times[0]) / SECOND)


def _apart(tracks: Tracks, name: str, times: Times, hand: Times) -> FileError:
    spans = [f"{at[0] / SECOND:.3f} to {at[-1] / SECOND:.3f} s" for at in (hand, times)]
    return FileError(
        tracks.path,
        f"mixes two clocks: the hand is stamped {spans[0]}, {name} {spans[1]}, and the log's times do not "
        "relate them",
        "Record both by one clock, or name the objects to read in a mapping (--mapping FILE.toml).",
    )
