"""Frames a second of `observe` at 640×480, and where the time goes.

Run: pytest -m bench -s tests/bench/test_tracking_speed.py
IMITATE_FILMS=FOLDER keeps the recording there for the next run.
"""

import cProfile
import os
import pstats
import time
from pathlib import Path

import pytest
from seeing import film_to

from imitate.formats.recordings import open_recording
from imitate.perception.observe import observe
from imitate.settings import Perception
from imitate.tui.watcher import Watcher

pytestmark = pytest.mark.bench
PARTS = {
    "hand": ("hand_tracker.py", "follow"),
    "blocks": ("tracker.py", "follow"),
    "windows to hues": ("eye.py", "pixels"),
    "surfaces predicted": ("shapes.py", "box_nearness", "cylinder_nearness"),
    "agreement scored": ("evidence.py", "score"),
}


class Kept:
    """A recording's frames in memory, so that reading them costs nothing."""

    def __init__(self, recording):
        self.intrinsics, self._frames = recording.intrinsics, list(recording.frames())
        self.count = len(self._frames)

    def frames(self):
        return iter(self._frames)


def timed(source):
    """(wall, processor) seconds a frame between the first and the last, with all of the process's threads."""
    stamps = []
    observe(source, progress=lambda *_: stamps.append((time.perf_counter(), time.process_time())))
    (wall, processor), (wall_end, processor_end) = stamps[0], stamps[-1]
    count = len(stamps) - 1
    return (wall_end - wall) / count, (processor_end - processor) / count


def test_frames_a_second(tmp_path, capsys):
    folder = Path(os.environ.get("IMITATE_FILMS", tmp_path))
    recording = open_recording(film_to(folder, "stack", 1))
    began = time.perf_counter()
    kept = Kept(recording)
    reading = (time.perf_counter() - began) / kept.count
    whole = timed(recording)
    tracking = timed(kept)
    profile = cProfile.Profile()
    profile.enable()
    observe(kept)
    profile.disable()
    spent = pstats.Stats(profile).stats
    with capsys.disabled():
        print(f"\n{kept.count} frames of {kept.intrinsics.width}×{kept.intrinsics.height}")
        print(
            f"whole pipeline  {1 / whole[0]:.0f} frames/s: {1000 * whole[0]:.1f} ms a frame, "
            f"{1000 * whole[1]:.1f} ms of processor"
        )
        print(f"reading alone   {1000 * reading:.1f} ms a frame")
        print(f"tracking alone  {1000 * tracking[0]:.1f} ms a frame, of which, under a profiler,")
        for part, (file, *names) in PARTS.items():
            seconds = sum(
                row[3]
                for (path, _, name), row in spent.items()
                if path.endswith(f"perception/{file}") and name in names
            )
            print(f"    {part:18} {1000 * seconds / kept.count:5.1f} ms")
    assert 1 / whole[1] >= 30  # by the processor: what else runs on the machine does not count


def test_being_watched_costs_little(tmp_path, capsys):
    """What the guided session keeps of each frame, in the tracker's own thread, as a share of tracking it."""
    folder = Path(os.environ.get("IMITATE_FILMS", tmp_path))
    kept = Kept(open_recording(film_to(folder, "stack", 1)))
    tellings, spent = [], []
    watcher = Watcher(Perception(), tellings.append)

    def watch(moment):
        began = time.thread_time()
        watcher(moment)
        spent.append(time.thread_time() - began)

    began = time.thread_time()
    observe(kept, watch=watch)
    whole = time.thread_time() - began
    pictures = [len(picture) for telling in tellings for picture in telling.pictures]
    share = sum(spent) / (whole - sum(spent))
    with capsys.disabled():
        print(
            f"\nwatched: {1000 * sum(spent) / kept.count:.2f} ms a frame, {100 * share:.1f} % of tracking; "
            f"{len(tellings)} tellings, {sum(pictures) / len(pictures) / 1000:.1f} kB a picture"
        )
    assert share < 0.05
