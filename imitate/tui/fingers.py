"""Fingers: point at the two coloured fingers in the first picture."""

from __future__ import annotations

from textual import on
from textual.app import ComposeResult
from textual.binding import Binding
from textual.containers import Vertical
from textual.content import Content
from textual.screen import ModalScreen
from textual.widgets import Footer, Static

from imitate.tui.picture import Image, Picture

Picked = tuple[str, str]
"""left and right finger as the settings take them: "U,V", a pixel of the first picture."""


class FingersScreen(ModalScreen[Picked]):
    """The first picture with a cursor; Enter picks the left finger, then the right one."""

    BINDINGS = [
        Binding(
            "enter,space",
            "pick",
            "pick",
            id="fingers.pick",
            tooltip="The colour under the cursor",
            priority=True,
        ),
        Binding("u", "again", "left again", id="fingers.again", tooltip="Pick the left finger anew"),
        Binding("escape", "dismiss", "leave", id="fingers.leave", tooltip="Leave the colours as they are"),
    ]

    def __init__(self, image: Image) -> None:
        super().__init__()
        self._image = image
        self.left: tuple[int, int] | None = None

    def compose(self) -> ComposeResult:
        """What to do, the picture, the keys."""
        with Vertical(id="fingers"):
            yield Static(id="ask", markup=False)
            yield Picture(self._image)
        yield Footer(show_command_palette=False)

    def on_mount(self) -> None:
        """Start in the middle of the picture."""
        picture = self.query_one(Picture)
        picture.focus()
        self.call_after_refresh(picture.point, self._image.shape[1] // 2, self._image.shape[0] // 2)
        self._ask()

    @on(Picture.Pointed)
    def _ask(self) -> None:
        side = "left" if self.left is None else "right"
        u, v = self.query_one(Picture).pixel
        red, green, blue = self._image[v, u].tolist()
        self.query_one("#ask", Static).update(
            Content.assemble(
                f"Point at the {side} finger (arrows, mouse), then Enter.  ",
                ("██", f"rgb({red},{green},{blue})"),
                f" #{red:02x}{green:02x}{blue:02x} at {u},{v}",
            )
        )

    def action_pick(self) -> None:
        """The left finger first, then the right one."""
        pixel = self.query_one(Picture).pixel
        if self.left is None:
            self.left = pixel
            self._ask()
        else:
            self.dismiss((_text(self.left), _text(pixel)))

    def action_again(self) -> None:
        """The left finger anew."""
        self.left = None
        self._ask()


def _text(pixel: tuple[int, int]) -> str:
    return f"{pixel[0]},{pixel[1]}"
