"""What pictures are drawn with: the library's complaints about a terminal are never on the screen."""

import logging
import sys

import pytest

from imitate.tui.photo import photo_of_terminal


@pytest.fixture
def library(monkeypatch):
    """Stands in for the library while it is imported: logs, or fails."""

    class Module:
        __path__ = ()
        fault = False

        @property
        def renderable(self):
            if self.fault:
                raise ValueError("the terminal answers with what is no size")
            try:
                raise TimeoutError("no answer")
            except TimeoutError as error:
                logging.getLogger("textual_image._terminal").warning("assuming sizes", exc_info=error)
            return self

        Image, UnicodeImage = "sixel", "unicode"

        class widget:
            Image = HalfcellImage = staticmethod(lambda id: id)

    module = Module()
    monkeypatch.setitem(sys.modules, "textual_image", module)
    return module


@pytest.mark.usefixtures("library")
def test_a_terminal_without_pixel_sizes_gets_half_blocks_and_no_traceback(capsys):
    told = []
    photo = photo_of_terminal(told.append)
    assert photo is not None
    assert capsys.readouterr() == ("", "")
    assert told == [
        "pictures are of half blocks, as this terminal does not say how large a character is in pixels"
    ]


def test_a_terminal_that_answers_nonsense_gets_no_pictures(library, capsys):
    library.fault = True
    told = []
    assert photo_of_terminal(told.append) is None
    assert capsys.readouterr() == ("", "")
    assert told == [
        "no pictures are shown, as this terminal does not say how it draws them (the terminal answers with "
        "what is no size)"
    ]
