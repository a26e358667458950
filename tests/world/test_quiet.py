"""C code is kept off stdout, and stdout comes back."""

import os

from imitate.world.quiet import quiet


def test_what_c_code_writes_is_gone_and_stdout_comes_back(capfd):
    with quiet(1):
        os.write(1, b"noise")
    os.write(1, b"data")
    assert capfd.readouterr().out == "data"


def test_stdout_comes_back_after_an_error(capfd):
    try:
        with quiet(1):
            raise RuntimeError
    except RuntimeError:
        os.write(1, b"data")
    assert capfd.readouterr().out == "data"
