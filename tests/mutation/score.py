"""How many small changes to the core its ordinary tests see: a mutation run, and its score.

    python tests/mutation/score.py --sample 200 --seed 0

mutmut makes the changes in a copy of the package under mutants/, and runs of each the tests that call what
was changed; [tool.mutmut] in pyproject.toml says of which files and with which tests. A change is killed when
a test fails or never ends. mutmut leaves functions with decorators as they are: hand_made.toml has some of
those. All changes take days; a sample gives the score with its 95 % interval. Survivors go to
mutants/survivors.diff. Those that cannot matter are in equivalent.toml, each with a reason, and do not count.
"""

from __future__ import annotations

import argparse
import random
import re
import subprocess
import sys
import tomllib
from collections import defaultdict
from collections.abc import Iterable, Sequence
from pathlib import Path

from imitate.learning.option import Success

ROOT = Path(__file__).parents[2]
SURVIVORS = ROOT / "mutants" / "survivors.diff"
EQUIVALENT = Path(__file__).with_name("equivalent.toml")
FIRST = "imitate.policy.power.*"
"""changes that are tried quickly: mutmut tells the names of all of them only after a first run."""
KILLED = ("killed", "timeout", "suspicious", "segfault")

Change = tuple[str, ...]
"""a file and its lines that go and come, with − and +."""


def mutmut(*arguments: str) -> str:
    """What it prints. Its progress rewrites a line and is not shown."""
    command = [sys.executable, "-m", "mutmut", *arguments]
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=False)
    if done.returncode:
        what = f"mutmut {' '.join(arguments)[:60]} … ended with {done.returncode}"
        sys.exit(f"{what}:\n{done.stdout[-3000:]}{done.stderr}")
    return done.stdout


def outcomes() -> dict[str, str]:
    """Every change by mutmut's name of it, and what came of it."""
    told = (line.strip().split(": ") for line in mutmut("results", "--all", "true").splitlines())
    return {name: outcome for name, outcome in told if "__mutmut_" in name}


def change_of(name: str) -> tuple[Change, str]:
    """What a change is, and its diff."""
    diff = mutmut("show", name)
    path, *lines = (line for line in diff.splitlines() if line.startswith(("---", "+", "-")))
    changed = (line[0] + line[1:].strip() for line in lines if not line.startswith("+++"))
    return (path.split()[-1], *changed), diff


def cannot_matter(change: Change) -> bool:
    """Whether it is among those in equivalent.toml."""
    known = tomllib.loads(EQUIVALENT.read_text())
    file, *lines = change
    if any((one["file"], one["lines"]) == (file, lines) for one in known["change"]):
        return True
    for kind in known["kind"]:
        gone, come = ([re.sub(kind["matches"], "", x[1:]) for x in lines if x[0] == sign] for sign in "-+")
        if gone == come:
            return True
    return False


def room_of(name: str) -> str:
    """The part of the package that a change is in, as --room names it."""
    room, file = name.split(".")[1:3]
    return f"{room}.{file}" if room in ("session", "formats") else room


def print_score(names: Iterable[str], found: dict[str, str]) -> None:
    """A line for each room, and one for all."""
    rooms: dict[str, list[bool]] = defaultdict(list)
    for name in names:
        for room in (room_of(name), "all"):
            rooms[room].append(found[name] in KILLED)
    for room, killed in sorted(rooms.items(), key=lambda r: r[0] == "all"):
        score = Success(sum(killed), len(killed))
        low, high = score.interval
        of = f"{score.successes:5} of {score.trials:5} killed"
        print(f"{room:16} {of}  {score.rate:6.1%}  ({low:.1%}–{high:.1%})")


def run(count: int, seed: int, jobs: int, only: Sequence[str]) -> None:
    """Tries the changes and prints what came of them."""
    mutmut("run", "--max-children", str(jobs), FIRST)
    every = sorted(name for name in outcomes() if not only or room_of(name) in only)
    chosen = random.Random(seed).sample(every, min(count or len(every), len(every)))
    print(f"{len(chosen)} of {len(every)} changes, seed {seed}", flush=True)
    mutmut("run", "--max-children", str(jobs), *chosen)
    found = outcomes()
    survivors = {name: change_of(name) for name in chosen if found[name] not in KILLED}
    real = {name: diff for name, (change, diff) in survivors.items() if not cannot_matter(change)}
    SURVIVORS.write_text("\n".join(real.values()))
    print_score([name for name in chosen if name in real or name not in survivors], found)
    print(f"{len(survivors) - len(real)} that cannot matter are left out; survivors: {SURVIVORS}")


def main() -> None:
    """Reads the command line."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--sample", type=int, default=0, help="how many changes are tried; 0 for all")
    parser.add_argument("--seed", type=int, default=0, help="of the sample")
    parser.add_argument("--jobs", type=int, default=2, help="processes")
    parser.add_argument(
        "--room", action="append", default=[], help="policy, segmentation, learning, session.compare, …"
    )
    given = parser.parse_args()
    run(given.sample, given.seed, given.jobs, given.room)


if __name__ == "__main__":
    main()
