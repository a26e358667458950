"""The application: holds the state, starts the work, shows the steps."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

from textual import on
from textual.app import App, SystemCommand
from textual.binding import Binding
from textual.screen import Screen

from imitate.formats.output import free_name
from imitate.settings import Settings
from imitate.tui import intents
from imitate.tui.choices import chosen
from imitate.tui.engine import Engine
from imitate.tui.photo import Photo
from imitate.tui.screens import screen_of
from imitate.tui.state import State, Step
from imitate.tui.step import StepScreen
from imitate.tui.teaching import Resumed, Task
from imitate.tui.words import losses_in_words
from imitate.tui.works import Works

if TYPE_CHECKING:
    from rich.console import RenderableType

REDRAW = 0.1
"""s between two drawings: events are folded as they come, but drawn at most so often."""


class ImitateApp(App[None]):
    """The guided session."""

    TITLE = "imitate"
    CSS_PATH = "app.tcss"
    VERTICAL_BREAKPOINTS = [(0, "-short"), (34, "-tall")]
    HORIZONTAL_BREAKPOINTS = [(0, "-narrow"), (110, "-wide")]
    BINDINGS = [
        Binding("f1,question_mark", "help", "help", id="app.help", key_display="?",
                tooltip="What this step is for, and every key"),
        Binding("ctrl+o", "load", "another file", id="app.load", show=False, tooltip="Open another file"),
        Binding("ctrl+p", "command_palette", "commands", id="app.commands", show=False, priority=True,
                tooltip="Find what can be done now by its name"),
        Binding("ctrl+t", "light_or_dark", "theme", id="app.theme", show=False, tooltip="Light or dark"),
        Binding("q", "quit", "quit", id="app.quit", tooltip="Quit; asks first while learning"),
    ]  # fmt: skip

    def __init__(
        self,
        source: Path | None = None,
        settings: Settings | None = None,
        seed: int = 0,
        workers: int = 1,
        engine: Engine | None = None,
        root: Path | None = None,
        photo: Photo | None = None,
        keys: Mapping[str, str] | None = None,
    ) -> None:
        super().__init__()
        self.set_keymap(keys or {})
        self.engine = engine or Engine()
        self.root = root or Path.cwd()
        self.state = State(settings or Settings(), seed, workers)
        self.works = Works(self, self.engine, self.state)
        self._source, self._photo = source, photo
        self.leaving = False
        self._changed = False

    def on_mount(self) -> None:
        """The first step, then the file that was given."""
        self.show("load")
        self.set_interval(REDRAW, self._draw)
        if self._source:
            self.post_message(intents.Open(self._source))

    def exit(self, result: None = None, return_code: int = 0, message: RenderableType | None = None) -> None:
        """Leave; what still arrives from the threads shows no step any more."""
        self.leaving = True
        super().exit(result, return_code, message)

    def show(self, step: Step) -> None:
        """Show a step's screen, made when it is first shown; nothing once the application closes."""
        if self._closing_down:
            return
        if step not in self._installed_screens:
            self.install_screen(screen_of(step, self.state, self.engine, self.root, self._photo), step)
        if len(self.screen_stack) > 1:
            self.switch_screen(step)
        else:
            self.push_screen(step)

    @property
    def _closing_down(self) -> bool:
        # Workers and the timer go on for a moment while the widgets are taken down.
        return self.leaving or not self.is_running

    @property
    def step(self) -> StepScreen | None:
        """The step that is shown; None under a note, and once the application closes."""
        top = self.screen_stack[-1] if self.screen_stack else None
        return top if isinstance(top, StepScreen) else None

    def _draw(self) -> None:
        if self._changed and not self._closing_down:
            self._changed = False
            for screen in self.screen_stack:
                if isinstance(screen, StepScreen):  # under a note, too, the step goes on to live
                    screen.redraw()

    def notice(self, error: str) -> None:
        """An error, as words with a remedy."""
        self.notify(error, title="✗", severity="error", timeout=15, markup=False)

    @on(intents.Go)
    def _go(self, message: intents.Go) -> None:
        if message.step == "load":
            self.works.leave()
            self.state.leave()
        self.show(message.step)

    @on(intents.Open)
    def _open(self, message: intents.Open) -> None:
        if self.state.running:
            self.notice("Learning runs. Stop it first (s in Learn), then open another file.")
        else:
            self.works.read(message.path)

    @on(intents.Opened)
    def _opened(self, message: intents.Opened) -> None:
        if message.kind != "recording":
            self.state.open(message.source, message.kind)
        self.state.show(message.demonstration, message.segments, message.notes)
        self.show("review")
        for note in message.notes:
            self.notify(f"{note}.", title="▲", severity="warning", timeout=15, markup=False)
        if self.state.sighting and (lost := losses_in_words(self.state.sighting, message.demonstration)):
            self.notify(f"{lost} Observe (Esc) shows when.", title="▲", severity="warning", markup=False)

    @on(intents.Recorded)
    def _recorded(self, message: intents.Recorded) -> None:
        self.state.open(message.source, "session")
        for event in message.events:
            self.state.fold(event)
        self.state.show_recorded(message.source)
        self.show("reproduce" if self.state.progress.finished else "learn")

    @on(intents.Recording)
    def _recording(self, message: intents.Recording) -> None:
        self.state.open(message.source, "recording")
        self.show("observe")
        self.works.observe(message.source)

    @on(intents.Wear)
    def _wear(self, message: intents.Wear) -> None:
        if self.state.source is not None and not self.state.running:
            self.state.wear(message.left, message.right)
            self._changed = True
            self.works.observe(self.state.source)

    @on(intents.Sighted)
    def _sighted(self, message: intents.Sighted) -> None:
        self.state.sight(message.sighting)
        self._changed = True

    @on(intents.Tracked)
    def _tracked(self, message: intents.Tracked) -> None:
        self.state.observed = message.share
        self._changed = True

    @on(intents.Decided)
    def _decided(self) -> None:
        self._changed = True

    @on(intents.Learn)
    def _start(self) -> None:
        state = self.state
        if state.running or state.kind == "session" or state.source is None:
            return
        log = free_name(self.root / "sessions", f"{state.source.stem}-{state.seed}", ".mcap")
        state.begin(log)
        self.show("learn")
        self.works.learn(Task(state.source, state.settings, state.seed, state.workers, state.decisions, log))

    @on(intents.GoOn)
    def _go_on(self) -> None:
        state = self.state
        if state.running:
            state.pausing = False
            state.pace.begin()
        elif state.resumable and state.log:
            state.go_on(state.log)
            self.show("learn")
            self.works.learn(Resumed(state.log, state.workers))
        self._changed = True

    @on(intents.Skip)
    def _skip(self) -> None:
        self.state.skip()
        self._changed = True

    @on(intents.Pause)
    def _pause(self) -> None:
        self.state.pausing = self.state.running and not self.state.stopping
        self._changed = True

    @on(intents.Reproduce)
    def _reproduce(self) -> None:
        self.works.reproduce()
        self._changed = True

    @on(intents.Films)
    def _films(self) -> None:
        self.works.films()

    @on(intents.Weigh)
    def _weigh(self) -> None:
        self.works.weigh()

    @on(intents.Weighed)
    def _weighed(self, message: intents.Weighed) -> None:
        if self.state.segments is message.segments:  # else something was decided meanwhile
            self.state.changes, self.state.doubts = message.changes, message.doubts
            self.state.along = message.along
            self._changed = True

    @on(intents.Pictures)
    def _pictures(self) -> None:
        self.works.pictures()

    @on(intents.Verify)
    def _verify(self, message: intents.Verify) -> None:
        self.works.verify(message.depth)
        self._changed = True

    @on(intents.View)
    def _view(self) -> None:
        self.works.view()

    @on(intents.Said)
    def _said(self, message: intents.Said) -> None:
        message.of.take(message.said)
        self._changed = True

    @on(intents.Viewed)
    def _viewed(self, message: intents.Viewed) -> None:
        message.of.viewing = False

    @on(intents.Happened)
    def _happened(self, message: intents.Happened) -> None:
        self.state.fold(message.event)
        self._changed = True

    @on(intents.Choose)
    def _choose(self, message: intents.Choose) -> None:
        state, values = self.state, message.values
        state.settings = chosen(state.settings, values)
        state.workers, state.seed = int(values["workers"]), int(values["seed"])
        self._changed = True

    @on(intents.Stop)
    def _stop(self) -> None:
        self.state.stopping = self.state.running
        self._changed = True

    @on(intents.Ended)
    def _ended(self) -> None:
        self.state.end()
        self._changed = True
        if self.step is None and len(self.screen_stack) > 2:
            self.pop_screen()  # a note over the step; whether to quit need not be asked any more
        if self.step and self.step.STEP == "learn":
            self._after_learning()

    def _after_learning(self) -> None:
        if self.state.progress.finished:
            self.show("reproduce")
        elif not self.state.ended:
            self.show("review")

    @on(intents.Failed)
    def _failed(self, message: intents.Failed) -> None:
        if message.work == "observe":
            self.state.unseen = message.error
            self._changed = True
        else:
            self.notice(message.error)

    def action_help(self) -> None:
        """Help on this step and the focused widget, with the keys that do something now."""
        from imitate.tui.notes import HelpScreen

        if not self.step:
            return
        keys: dict[str, str] = {}
        for active in self.step.active_bindings.values():
            binding = active.binding
            if binding.tooltip:
                keys.setdefault(self.get_key_display(binding), binding.tooltip)
        focused = self.step.focused
        about = (self.step.HELP, focused.HELP if focused else None)
        self.push_screen(HelpScreen("\n\n".join(filter(None, about)), list(keys.items())))

    def get_system_commands(self, screen: Screen[Any]) -> Iterable[SystemCommand]:
        """What can be done now, for the command palette."""
        from imitate.tui.keys import commands

        return commands(self, screen)

    def action_load(self) -> None:
        """The files."""
        if self.step:
            self.post_message(intents.Go("load"))

    def action_light_or_dark(self) -> None:
        """The other theme."""
        self.theme = "textual-light" if self.current_theme.dark else "textual-dark"

    async def action_quit(self) -> None:
        """Quit; while learning, ask first."""
        from imitate.tui.notes import ConfirmScreen

        if not self.state.running:
            self._leave(True)
            return
        question = (
            "Learning runs. Quit after the present trial? The session's file stays valid and can be replayed."
        )
        self.push_screen(ConfirmScreen(question), self._leave)

    def _leave(self, yes: bool | None) -> None:
        if yes:
            self.state.stopping = self.state.running
            self.exit()
