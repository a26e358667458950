"""Review: the segments, and the operator's say in them."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path

from textual import on, work
from textual.containers import Horizontal, Vertical
from textual.widget import Widget
from textual.widgets import Footer, Label, Static

from imitate.errors import ImitateError, in_words
from imitate.formats.output import free_name
from imitate.skill import Decision, Segment
from imitate.tui.choices import TITLE, choices_of
from imitate.tui.chosen import DOUBTED, Chosen, chosen_of
from imitate.tui.engine import Engine
from imitate.tui.form import FormScreen
from imitate.tui.intents import Choose, Decided, Failed, Go, Learn, Pictures, Weigh
from imitate.tui.looking import Looking
from imitate.tui.review_keys import REVIEW_HELP, REVIEW_KEYS
from imitate.tui.skill_table import Alternatives, SkillTable
from imitate.tui.state import State, moved
from imitate.tui.step import StepScreen
from imitate.tui.timeline import Timeline
from imitate.tui.words import decided_in_words, short

NUDGE = 0.1  # s
SAID = 5
"""s that a doubt is shown as a notice; then it stands below the lists."""
CHANGES = ("nudge", "here", "alternatives", "split", "split_here", "merge", "undo", "redo", "reset")
"""actions that decide something."""


class ReviewScreen(StepScreen):
    """Timeline, table, ranked alternatives, and what is to be seen at one time."""

    STEP = "review"
    HELP = REVIEW_HELP
    BINDINGS = list(REVIEW_KEYS)

    def __init__(self, state: State, engine: Engine, root: Path) -> None:
        super().__init__(state)
        self.engine = engine
        self.root = root
        self._said: frozenset[tuple[int, int]] = frozenset()
        self._marked = (0, -1, 0.0)

    def body(self) -> Iterable[Widget]:
        """Timeline above, table and alternatives in the middle, what is looked at below."""
        yield Timeline()
        yield Horizontal(
            Vertical(SkillTable(), id="cut"),
            Vertical(Label("", id="ranked", markup=False), Alternatives(), id="others"),
            id="middle",
        )
        yield Looking()
        yield Static("", id="doubts", markup=False)
        yield Static("", id="decided", markup=False)

    def on_mount(self) -> None:
        """The first picture."""
        self.query_one(Footer).compact = True  # all keys fit into 80 columns
        super().on_mount()
        self.query_one(SkillTable).focus()

    def on_resize(self) -> None:
        """Columns that fit."""
        self.redraw()

    @property
    def selected(self) -> int:
        """Index of the selected segment."""
        row = self.query_one(SkillTable).cursor_row
        return min(max(row, 0), max(len(self.state.segments) - 1, 0))

    @property
    def boundary(self) -> int:
        """The boundary that keys move: the selected segment's end, the last one's start."""
        return min(self.selected, len(self.state.segments) - 2)

    @property
    def chosen(self) -> tuple[Chosen, ...]:
        """What of each segment the operator chose."""
        state = self.state
        doubted = {k for doubt in state.doubts or () for k in range(doubt.first, doubt.last + 1)}
        return chosen_of(state.found, state.segments, doubted)

    def draw(self) -> None:
        """Everything."""
        super().draw()
        state = self.state
        if state.demonstration is not None:
            self.post_message(Pictures())
            self.post_message(Weigh())
        self.query_one(SkillTable).show(state.segments, state.changes, self.chosen)
        self._draw_selection()
        self._say_doubts()
        self.query_one("#decided", Static).update(f" {decided_in_words(state)}")

    def _draw_selection(self) -> None:
        state, segments = self.state, self.state.segments
        self.query_one(Timeline).show(segments, self.selected, self.boundary, state.changes, self.chosen)
        self.query_one("#ranked", Label).update(f"skill {self.selected + 1} may be")
        self.query_one(Alternatives).show(segments[self.selected] if segments else None)
        self._draw_doubts()
        if state.demonstration is None:
            return
        cuts = [s.end for s in segments[:-1]]
        look = (state.demonstration, state.album, state.along, cuts, self.boundary)
        self.query_one(Looking).show(*look)
        self._look_at_boundary()
        self._draw_time()

    def _look_at_boundary(self) -> None:
        # The boundary that the keys move is what is looked at, from when it is another or elsewhere.
        if len(self.state.segments) > 1:
            cut = self.state.segments[self.boundary].end
            marked = (id(self.state.demonstration), self.boundary, cut)
            if marked != self._marked:
                self._marked = marked
                self.query_one(Looking).go(cut)

    def _draw_doubts(self) -> None:
        doubts = sorted(self.state.doubts or (), key=lambda d: not d.first <= self.selected <= d.last)
        more = f" ({len(doubts) - 1} more)" if len(doubts) > 1 else ""
        line = self.query_one("#doubts", Static)
        line.display = bool(doubts)
        line.update(f" {DOUBTED} {doubts[0]}{more}" if doubts else "")

    def _say_doubts(self) -> None:
        # Each once, as long as it stands.
        doubts = self.state.doubts
        if doubts is None:
            return
        for doubt in doubts:
            if self.state.editable and (doubt.first, doubt.last) not in self._said:
                self.notify(f"{doubt}.", title=DOUBTED, severity="warning", timeout=SAID, markup=False)
        self._said = frozenset((doubt.first, doubt.last) for doubt in doubts)

    @on(Looking.Moved)
    def _draw_time(self) -> None:
        looking = self.query_one(Looking)
        self.query_one(Timeline).point(looking.now, looking.seen)

    @on(Timeline.Pointed)
    def _on_pointed(self, event: Timeline.Pointed) -> None:
        self.query_one(Looking).go(event.seconds)

    def action_look(self, frames: int, seconds: int) -> None:
        """Look at another time."""
        self.query_one(Looking).step(frames, seconds)

    def action_play(self) -> None:
        """Play the demonstration, or stop."""
        self.query_one(Looking).play()

    def action_view(self) -> None:
        """The next of the views that share the room."""
        self.query_one(Looking).turn()

    @on(SkillTable.RowHighlighted)
    def _on_row(self) -> None:
        self._draw_selection()

    @on(SkillTable.RowSelected)
    def action_alternatives(self) -> None:
        """To the ranked alternatives of the selected skill."""
        options = self.query_one(Alternatives)
        if options.option_count:
            self.set_focus(options)  # at once: a key may follow
            options.highlighted = 0

    @on(Alternatives.OptionSelected)
    def _on_alternative(self, event: Alternatives.OptionSelected) -> None:
        chosen = self.state.segments[self.selected].alternatives[event.option_index].abstraction
        self.set_focus(self.query_one(SkillTable))
        self._decide(Decision("relabel", self.selected, abstraction=chosen))

    def action_nudge(self, frames: int, tenths: int) -> None:
        """Move the selected boundary."""
        state = self.state
        if state.demonstration is not None:
            by = (self.boundary, frames, tenths * NUDGE)
            decision = moved(state.demonstration, state.segments, *by)
            if decision:
                self._decide(decision)

    def action_here(self) -> None:
        """Move the selected boundary to the time that is looked at."""
        if len(self.state.segments) > 1:
            self._decide(Decision("move", self.boundary, self.query_one(Looking).now))

    def action_split_here(self) -> None:
        """Split the skill at the time that is looked at."""
        now = self.query_one(Looking).now
        k = max((k for k, s in enumerate(self.state.segments) if s.start <= now), default=0)
        self._decide(Decision("split", k, now))

    def action_reset(self) -> None:
        """Everything as it was found."""
        if self.state.segments != self.state.found:
            self._decide(Decision("reset"))

    def action_merge(self) -> None:
        """Merge the segments on either side of the selected boundary."""
        self._decide(Decision("merge", self.boundary))

    def action_undo(self) -> None:
        """Take back the last decision."""
        if self.state.undoable:
            self._decide(Decision("undo"))

    def action_redo(self) -> None:
        """Do again what was undone last."""
        if self.state.redoable:
            self._decide(Decision("redo"))

    def _decide(self, decision: Decision) -> None:
        state = self.state
        if not state.editable or state.demonstration is None:
            return
        decisions = (*state.decisions, decision)
        try:
            segments = self.engine.decide(state.found, decisions, state.demonstration, state.settings)
        except ImitateError as error:
            self.post_message(Failed("decide", str(error)))
            return
        state.decide(decision, segments)
        self._look_at_boundary()  # now: keys may look elsewhere before the next redraw
        self.post_message(Decided())

    def action_split(self) -> None:
        """Split the selected segment, where that explains most."""
        if self.state.editable and self.state.segments:
            self._split(self.state.segments, self.selected)

    @work(thread=True, exclusive=True, group="split", exit_on_error=False)
    def _split(self, segments: tuple[Segment, ...], k: int) -> None:
        state = self.state
        try:
            assert state.demonstration is not None
            time = self.engine.split_time(state.demonstration, segments[k], state.settings)
        except Exception as error:
            self.post_message(Failed("split", in_words(error)))
            return
        if state.segments is segments:  # else something was decided meanwhile
            self.app.call_from_thread(self._decide, Decision("split", k, time))

    def action_write(self) -> None:
        """Write the decisions to a file."""
        state = self.state
        if not state.decisions or state.source is None:
            return
        path = free_name(self.root / "sessions", f"{state.source.stem}.decisions", ".json")
        try:
            self.engine.write_decisions(path, state.decisions)
        except ImitateError as error:
            self.post_message(Failed("write", str(error)))
            return
        file = short(path, self.root)
        self.notify(
            f"Your decisions are in {file}. imitate segment and imitate learn take them with "
            f"--decisions {file}.",
            title="✓",
            timeout=15,
            markup=False,
        )

    @work(exclusive=True, group="form")
    async def action_settings(self) -> None:
        """Change the few settings that matter for learning."""
        values = await self.app.push_screen_wait(FormScreen(TITLE, choices_of(self.state)))
        if values is not None:
            self.post_message(Choose(values))

    def action_learn(self) -> None:
        """Learn these skills; while they are learned, look."""
        self.post_message(Go("learn") if self.state.running else Learn())

    def check_action(self, action: str, parameters: tuple[object, ...]) -> bool | None:
        """Keys that would change a session which cannot be changed are greyed."""
        if action == "settings":
            return self.state.editable
        if action == "view":
            return self.has_class("-short")
        if action == "learn" and self.state.kind == "session":
            return False
        if action == "merge" and len(self.state.segments) < 2:
            return False
        if action in ("redo", "undo") and not (
            self.state.redoable if action == "redo" else self.state.undoable
        ):
            return False
        if action == "reset" and self.state.segments == self.state.found:
            return False
        if action == "write" and not self.state.decisions:
            return False
        return (
            None
            if action in CHANGES and not self.state.editable
            else super().check_action(action, parameters)
        )
