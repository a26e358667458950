"""What a session's file says of itself to tools that know no message of ours: metadata and attachments.

All of it is in the session's messages too, from which sessions are read, replayed and resumed.
"""

from __future__ import annotations

import tomllib
from collections.abc import Iterator
from hashlib import sha256

from imitate.events import SessionStarted

SETTINGS, ROBOT, DECISIONS = "settings.toml", "robot.toml", "decisions.json"
"""names of attachments."""

Attachment = tuple[str, bytes]
"""a file's name and what is in it."""


def metadata_of(started: SessionStarted) -> dict[str, dict[str, str]]:
    """Records of the session, the versions of packages, the constants of physics, and the robot's files.

    Returns:
        name → key → value; of each file the SHA-256, hexadecimal.
    """
    versions = dict(sorted(started.versions.items()))
    scene = started.scene
    files = {ROBOT: sha256(scene.description.encode()).hexdigest()} if scene.description else {}
    return {
        "session": {
            "source": started.source,
            "source_sha256": started.source_hash,
            "seed": str(started.seed),
            "platform": versions.pop("platform", ""),
        },
        "versions": versions,
        "physics": {name: str(value) for name, value in tomllib.loads(started.settings)["world"].items()},
        "robot": {"name": scene.robot} | files | {file.name: file.sha256 for file in scene.robot_files},
    }


def attachments_of(started: SessionStarted) -> Iterator[Attachment]:
    """The settings as resolved, and the robot's description with the URDF of one's own."""
    yield SETTINGS, started.settings.encode()
    if started.scene.description:
        yield ROBOT, started.scene.description.encode()
    for file in started.scene.robot_files:
        if file.text:
            yield file.name, file.text.encode()
