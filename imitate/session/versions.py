"""What a session was recorded with, so that a replay elsewhere can name the difference."""

from __future__ import annotations

import platform
from collections.abc import Mapping
from importlib import metadata

_PACKAGES = ("imitate", "numpy", "scipy", "pybullet")
"""those that a trial's numbers depend on."""


def versions() -> dict[str, str]:
    """Package → version, "python" and "platform"."""
    found = {package: metadata.version(package) for package in _PACKAGES}
    return {**found, "python": platform.python_version(), "platform": platform.platform()}


def version_differences(recorded: Mapping[str, str]) -> tuple[str, ...]:
    """What differs here from where a session was recorded, in words."""
    here = versions()
    return tuple(
        f"recorded with {name} {version}, replayed with {here[name]}"
        for name, version in sorted(recorded.items())
        if name in here and here[name] != version
    )
