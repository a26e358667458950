"""The person's carry as a file."""

import pytest

from imitate.formats.demonstrations import write_demonstration


@pytest.fixture(scope="session")
def source(short_demonstration, tmp_path_factory):
    """The carry, its start cut to where the hand already surrounds the block."""
    path = tmp_path_factory.mktemp("source") / "carry.npz"
    write_demonstration(short_demonstration, path)
    return path
