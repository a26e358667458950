"""Both views of a trial, and where in it we are: it plays and is scrubbed."""

from __future__ import annotations

from collections.abc import Iterable

from textual.app import ComposeResult
from textual.binding import Binding
from textual.containers import Horizontal, Vertical
from textual.message import Message
from textual.widget import Widget
from textual.widgets import Static

from imitate.events import SessionStarted
from imitate.tui.film import RATE, Film
from imitate.tui.scene_view import SceneView, Stage
from imitate.tui.state import State
from imitate.tui.step import StepScreen
from imitate.tui.words import bar

LEAP = RATE
"""moments that a shifted arrow scrubs by: a second."""


class Player(Vertical):
    """Draws one film at a moment."""

    class Ended(Message):
        """A film was played to its end."""

    def __init__(self, speed: int = 1) -> None:
        super().__init__(id="player")
        self._speed = speed
        self.stage: Stage | None = None
        self.film: Film | None = None
        self.frame = 0
        self.playing = False

    def compose(self) -> ComposeResult:
        """The views, and below them the time."""
        yield Horizontal(SceneView("top"), SceneView("side"), id="views")
        yield Static("", id="clock", markup=False)

    def on_mount(self) -> None:
        """The clock by which it plays."""
        self.set_interval(1 / RATE, self._tick)

    def show(self, stage: Stage | None, film: Film | None) -> None:
        """Another film, from its beginning; the same one stays where it is."""
        if film is not self.film or stage is not self.stage:
            self.stage, self.film, self.frame = stage, film, 0
            self.draw()

    def play(self, playing: bool = True) -> None:
        """Play on from here, or from the beginning where it had ended; or stop."""
        if playing and self.film and self.frame >= self.film.last:
            self.frame = 0
        self.playing = playing and self.film is not None
        self.draw()

    def seek(self, frame: int) -> None:
        """Go to a moment, and stop there."""
        self.playing = False
        if self.film:
            self.frame = min(max(frame, 0), self.film.last)
        self.draw()

    def on_resize(self) -> None:
        """The bar is as long as there is room for it."""
        self.draw()

    def _tick(self) -> None:
        if not (self.playing and self.film and self.screen.is_current):
            return
        self.frame = min(self.frame + self._speed, self.film.last)
        if self.frame == self.film.last:
            self.playing = False
            self.post_message(self.Ended())
        self.draw()

    def draw(self) -> None:
        """The moment as it is now."""
        shown = (self.stage, self.film, self.frame) if self.stage and self.film else None
        for view in self.query(SceneView):
            view.show(shown)
        self.query_one("#clock", Static).update(self._clock())

    def _clock(self) -> str:
        film = self.film
        if film is None:
            return ""
        now, end = float(film.t[self.frame]), float(film.t[-1])
        force = float(film.force[self.frame])
        grip = f"{force:.0f} N" if force > 0 else "open"
        sign = "▶" if self.playing else "■"
        speed = f" ×{self._speed}" if self._speed > 1 else ""
        share = bar(self.frame / max(film.last, 1), max(self.size.width - 44, 5))
        first = film.segment - int(film.skills[-1])
        skill = first + int(film.skills[self.frame]) + 1
        return f"{sign}{speed} {share} {now:4.1f} of {end:.1f} s  skill {skill}, grip {grip}"


class PlayerScreen(StepScreen):
    """A step with a player: the keys that play and scrub."""

    BINDINGS = [
        Binding("space", "play", "play", id="player.play", priority=True,
                tooltip="Play the selected trial, or stop it there"),
        Binding("left,h", "seek(-1)", "scrub", id="player.back", priority=True, key_display="←→",
                tooltip="Scrub through the trial; h and l do the same, shift goes by a second"),
        Binding("right,l", "seek(1)", "scrub", id="player.on", priority=True, show=False),
        Binding("shift+left,H", f"seek(-{LEAP})", "a second back", id="player.leap_back", priority=True,
                show=False),
        Binding("shift+right,L", f"seek({LEAP})", "a second on", id="player.leap_on", priority=True,
                show=False),
    ]  # fmt: skip

    def __init__(self, state: State) -> None:
        super().__init__(state)
        self._stage: tuple[SessionStarted, Stage] | None = None

    @property
    def player(self) -> Player:
        """The player."""
        return self.query_one(Player)

    def stage(self) -> Stage | None:
        """The session's, made once; None before it has started."""
        started = self.state.progress.started
        if started is None:
            return None
        if self._stage is None or self._stage[0] is not started:
            self._stage = started, Stage.of(started.scene, started.demonstration)
        return self._stage[1]

    def action_play(self) -> None:
        """Play, or stop."""
        self.player.play(not self.player.playing)

    def action_seek(self, by: int) -> None:
        """Scrub by so many moments."""
        self.player.seek(self.player.frame + by)

    def check_action(self, action: str, parameters: tuple[object, ...]) -> bool | None:
        """There is something to play once there is a film."""
        if action in ("play", "seek"):
            return True if self.is_mounted and self.player.film else None
        return super().check_action(action, parameters)

    def body(self) -> Iterable[Widget]:
        """The step's own widgets."""
        raise NotImplementedError
