"""How long cutting takes, beside ruptures, which is given the number of changes, on the same demonstrations.

Run: pytest -m bench -s tests/bench/test_segmentation_speed.py
Seconds are of this process's own work (CPU): other programs on the machine do not count. ruptures sees the
hand's position relative to each object, and cuts where its mean changes, in the middle of moves: as quick,
but the answer to another question. At 10,000 frames and more its exact searches take too long.
"""

import subprocess
import sys
import time

import numpy as np
import pytest
import ruptures
from cycles import cycles_with_changes

from imitate.segmentation import segment
from imitate.segmentation.changepoints import most_probable_cuts
from imitate.segmentation.segments import lattice_of, score_of
from imitate.settings import Segmentation

pytestmark = pytest.mark.bench
ROBUST = Segmentation()
CASES = [(450, 2, 0.010), (10_000, 10, 2.0), (100_000, 10, 60.0)]
"""frames, objects, seconds that the search may take."""


def seconds(call, rounds):
    taken = []
    for _ in range(rounds):
        began = time.process_time()
        result = call()
        taken.append(time.process_time() - began)
    return min(taken), result


def share_found(changes, cuts):
    """The share of true changes with a cut within 0.5 s."""
    cuts = np.asarray(cuts)
    return np.mean([np.any((cuts > low - 0.5) & (cuts < high + 0.5)) for low, high in changes])


def peers(frames, signal, count):
    if frames < 1000:
        yield "Dynp, exact", lambda: ruptures.Dynp("l2", min_size=5, jump=1).fit_predict(signal, count)
        yield (
            "KernelCPD, exact, C",
            lambda: ruptures.KernelCPD("linear", min_size=5).fit_predict(signal, count),
        )
    elif frames < 50_000:
        yield "BottomUp", lambda: ruptures.BottomUp("l2", min_size=5, jump=5).fit_predict(signal, count)
        yield "Window", lambda: ruptures.Window(50, "l2", min_size=5, jump=5).fit_predict(signal, count)
    else:
        yield "Window", lambda: ruptures.Window(50, "l2", min_size=5, jump=5).fit_predict(signal, count)


@pytest.mark.parametrize(("frames", "objects", "limit"), CASES)
def test_cutting_is_quick(frames, objects, limit, capsys):
    rng = np.random.default_rng(1)
    demonstration, changes = cycles_with_changes(frames, objects, 0.003, rng)
    score = score_of(demonstration, ROBUST)
    rounds = 7 if frames < 1000 else 1
    search, _ = seconds(lambda: most_probable_cuts(lattice_of(score, ROBUST)), rounds)
    whole, segments = seconds(lambda: segment(demonstration, ROBUST), rounds)
    found = share_found(changes, [s.start for s in segments[1:]])
    apart = (demonstration.hand[:, None, :3] - demonstration.objects[..., :3]).reshape(frames, -1)
    with capsys.disabled():
        print(f"\n{frames} frames, {objects} objects, {len(changes)} changes")
        print(f"  imitate: search      {search:9.3f} s  (at most {limit:g})")
        print(f"  imitate: all         {whole:9.3f} s  {found:4.0%} of the changes, {len(segments) - 1} cuts")
        for name, call in peers(frames, apart, len(changes)):
            taken, cuts = seconds(call, 1)
            hit = share_found(changes, np.array(cuts[:-1]) / 30)
            print(f"  ruptures: {name:20}{taken:9.3f} s  {hit:4.0%} of the changes, {len(cuts) - 1} cuts")
    assert search <= limit


MEMORY = """
import resource, sys
import numpy as np
sys.path.insert(0, sys.argv[1])
from cycles import cycles
from imitate.segmentation import segment
from imitate.settings import Segmentation
demonstration = cycles(100_000, 10, 0.003, np.random.default_rng(1))
before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
segment(demonstration, Segmentation())
print(before / 1024, resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024)
"""


def test_an_hour_fits_into_a_gigabyte(capsys, pytestconfig):
    command = [sys.executable, "-c", MEMORY, str(pytestconfig.rootpath / "tests")]
    run = subprocess.run(command, capture_output=True, text=True, check=True)
    before, most = map(float, run.stdout.split())
    with capsys.disabled():
        print(f"\n100,000 frames, 10 objects: {most:.0f} MiB at most, {before:.0f} of them before cutting")
    assert most <= 1024
