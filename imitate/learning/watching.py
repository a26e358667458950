"""Trials watched: the camera films them, the tracker says where the objects are."""

from __future__ import annotations

import numpy as np

from imitate.geometry import Array
from imitate.perception.known_blocks import KnownBlocks
from imitate.perception.tracker import Motion
from imitate.record import SceneSpec, Sightings
from imitate.settings import Settings
from imitate.world.trial_camera import TrialCamera


class Watcher:
    """Watches the trials of one scene, one after another, as the simulator asks.

    Before each trial `begin`; after it `sightings`. A trial's noise follows from its own seed alone.
    """

    def __init__(self, spec: SceneSpec, settings: Settings) -> None:
        self._spec, self._settings = spec, settings
        self._camera = TrialCamera(spec, settings.learning.observe_width)
        self.begin(None, np.random.SeedSequence(0))

    def close(self) -> None:
        """Puts the camera away."""
        self._camera.close()

    def begin(self, expected: Array | None, seed: np.random.SeedSequence) -> None:
        """A new trial.

        Args:
            expected: (K, 7) where the objects were seen last; None: it is not known, they are looked for.
            seed: of the camera's noise and the tracker's draws.
        """
        noise, draws = seed.spawn(2)
        known = self._spec.object_poses if expected is None else expected
        camera = self._camera.camera
        self._generator = np.random.default_rng(noise)
        self._blocks = KnownBlocks(
            camera.intrinsics,
            camera.world_from_camera,
            self._camera.hues,
            self._spec.object_sizes,
            known,
            self._settings.perception,
            draws,
            sought=expected is None,
        )
        self._expected, self._ever = known, np.full(len(known), expected is not None)
        self._steps: list[int] = []
        self._poses: list[Array] = []
        self._hand: Array | None = None

    def look(self, step: int, joints: Array, hand: Array, objects: Array) -> None:
        """One look at the scene; see `imitate.world.trial.Watch`."""
        motion = None if self._hand is None else Motion(self._hand, hand)
        t = step / self._settings.world.physics_rate
        # Before a trial everything rests, and several pictures tell more than one.
        for _ in range(1 if self._steps else self._settings.perception.still_frames):
            frame = self._camera.picture(t, joints, objects, self._generator)
            poses = self._blocks.follow(frame, motion)
        self._steps.append(step)
        self._poses.append(poses)
        self._ever |= ~np.isnan(poses[:, 0])
        self._hand = hand

    def pose_of(self, index: int) -> Array | None:
        """(7,) where an object was seen last; None where it never was."""
        return np.asarray(self.sightings.believed[-1, index]) if self._ever[index] else None

    @property
    def sightings(self) -> Sightings:
        """What was seen of the present trial."""
        poses = np.array(self._poses).reshape(-1, *self._expected.shape)
        return Sightings(self._expected, tuple(self._steps), poses)
