"""The physics engine's front door: quiet import, headless clients, names of joints and links."""

from __future__ import annotations

import functools
from pathlib import Path
from typing import Any

from imitate.world.quiet import quiet

with quiet(1, 2):  # PyBullet's C code greets on the standard streams, which are the views'
    import pybullet
    import pybullet_data

__all__ = ["Client", "data_path", "open_client", "pybullet"]


class Client:
    """A headless PyBullet server whose calls carry its number: ``client.stepSimulation()``."""

    def __init__(self) -> None:
        with quiet(1):
            self.number = int(pybullet.connect(pybullet.DIRECT))

    def __getattr__(self, name: str) -> Any:
        call = functools.partial(getattr(pybullet, name), physicsClientId=self.number)
        setattr(self, name, call)
        return call

    def names(self, body: int) -> tuple[dict[str, int], dict[str, int]]:
        """Joint name → number and link name → number of a body."""
        joints, links = {}, {}
        for number in range(self.getNumJoints(body)):
            info = self.getJointInfo(body, number)
            joints[info[1].decode()] = number
            links[info[12].decode()] = number
        return joints, links


def data_path() -> Path:
    """The folder of pybullet_data's models."""
    return Path(pybullet_data.getDataPath())


def open_client() -> Client:
    """A new headless server that finds pybullet_data's models."""
    client = Client()
    client.setAdditionalSearchPath(str(data_path()))
    return client
