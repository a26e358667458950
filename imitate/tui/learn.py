"""Learn: what is tried, what it costs, what is believed."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np
from textual import on, work
from textual.binding import Binding
from textual.containers import Horizontal, Vertical
from textual.widget import Widget
from textual.widgets import DataTable, Footer, Label, Static

from imitate.geometry import Array
from imitate.policy.force import forces
from imitate.session.progress import Attempt
from imitate.skill import policy_ticks
from imitate.tui.attempts import AttemptTable
from imitate.tui.choices import TITLE, choices_of
from imitate.tui.costs import TERMS, Curve, Terms
from imitate.tui.curve import SIGNS, CostCurve, ForceCurve
from imitate.tui.form import FormScreen
from imitate.tui.intents import Choose, GoOn, Learn, Pause, Skip, Stop
from imitate.tui.learn_words import attempt_words, banner_words, branch_words, skip_question, threshold
from imitate.tui.notes import ConfirmScreen
from imitate.tui.state import State
from imitate.tui.step import StepScreen
from imitate.world.robot import robot_of


class LearnScreen(StepScreen):
    """Formulations above, cost curve and the shown formulation in words below."""

    STEP = "learn"
    HELP = (
        "Learn: each skill is stated as a problem (what is observed, what may be done, what it costs), "
        "and a movement is improved by trials in simulation. Then its probability of success P is "
        "estimated from disturbed starts. Where P stays under the needed value the problem is stated "
        "anew, and a notice says why. Up and down show another formulation's curve, f follows the present "
        "one again. p pauses and g goes on; stopping finishes the present trial, the session's file stays "
        "valid, and g goes on with it later, too. x gives the present formulation up for the next one. "
        "1 to 4 draw the cost or its parts, 5 the gripper's force once it is learned. Before learning "
        "again, e changes α, C, the trials, workers and seed."
    )
    BINDINGS = [
        Binding(
            "s", "stop", "stop", id="learn.stop", tooltip="Stop after the present trial; the file stays valid"
        ),
        Binding("p", "pause", "pause", id="learn.pause", tooltip="Wait after the present trial"),
        Binding("g", "go_on", "go on", id="learn.go_on",
                tooltip="Go on after a pause, or where the session stopped"),
        Binding("x", "skip", "skip", id="learn.skip",
                tooltip="Give the present formulation up for the next one"),
        Binding("1", "term('total')", "curves", id="learn.total", key_display="1-5",
                tooltip="Total cost in the plot, or not; 2 its end, 3 acceleration, 4 gripper, 5 the force"),
        Binding("2", "term('end')", "end", id="learn.end", show=False),
        Binding("3", "term('acceleration')", "acceleration", id="learn.acceleration", show=False),
        Binding("4", "term('gripper')", "gripper", id="learn.gripper", show=False),
        Binding("5", "force", "force", id="learn.force", show=False),
        Binding("e", "settings", "settings", id="learn.settings", tooltip="α, C, trials, workers, seed"),
        Binding("r", "again", "again", id="learn.again", tooltip="Learn anew, as another session"),
        Binding("f", "follow", "follow", id="learn.follow", tooltip="Show the present formulation again"),
    ]  # fmt: skip

    def __init__(self, state: State) -> None:
        super().__init__(state)
        self._terms: set[Terms] = {"total"}
        self._force = False

    def body(self) -> Iterable[Widget]:
        """Banner, tree, curves, words."""
        yield Static("", id="banner", markup=False)
        yield AttemptTable()
        yield Horizontal(
            Vertical(CostCurve(), ForceCurve(), Label("", id="key", markup=False), id="curves"),
            Static("", id="words", markup=False),
            id="watch",
        )

    def on_mount(self) -> None:
        """The tree has the focus."""
        self.query_one(Footer).compact = True  # all keys fit into 80 columns
        super().on_mount()
        self.query_one(AttemptTable).focus()

    @property
    def shown(self) -> Attempt | None:
        """The formulation whose curve is shown."""
        branch = self.query_one(AttemptTable).chosen
        return branch.attempt if branch else None

    def on_resize(self) -> None:
        """Curves that fit."""
        self.redraw()

    def draw(self) -> None:
        """Everything that changed."""
        super().draw()
        self.query_one(AttemptTable).show(self.state)
        banner = self.query_one("#banner", Static)
        words = banner_words(self.state)
        banner.update(words)
        banner.display = bool(words)
        self._draw_shown()

    def _draw_shown(self) -> None:
        limit = threshold(self.state) if "total" in self._terms or "end" in self._terms else None
        cost, force = self.query_one(CostCurve), self.query_one(ForceCurve)
        profile = force_of(self.shown, self.state)
        tall = self.has_class("-tall")
        force.display = profile is not None and (tall or self._force)
        cost.display = tall or not force.display
        cost.show(Curve.of(self.shown, self._terms), limit)
        force.show(profile)
        self.query_one("#key", Label).update(self._key(limit, profile is not None and not tall))
        branch = self.query_one(AttemptTable).chosen
        words = attempt_words(self.state, self.shown)
        if branch and branch.attempt is None:
            words = branch_words(branch)
        self.query_one("#words", Static).update(words)

    def _key(self, limit: float | None, force: bool) -> str:
        signs = ["○ failed", "● succeeded", "◆ update"] if "total" in self._terms else []
        signs += [
            f"{SIGNS[term][0]} {term[:4].strip()}" for term in TERMS if term in SIGNS and term in self._terms
        ]
        signs += ["╌ C"] * (limit is not None) + ["5 force"] * force
        return "  ".join(signs)

    @on(DataTable.RowHighlighted)
    def _on_row(self) -> None:
        self._draw_shown()

    def action_term(self, term: Terms) -> None:
        """Draw a part of the cost, or leave it out; one always stays."""
        toggled = self._terms ^ {term}
        self._terms = toggled or self._terms
        self._draw_shown()

    def action_force(self) -> None:
        """The force instead of the cost, and back, where there is no room for both."""
        self._force = not self._force
        self._draw_shown()

    @work(exclusive=True, group="form")
    async def action_settings(self) -> None:
        """Change the few settings that matter."""
        values = await self.app.push_screen_wait(FormScreen(TITLE, choices_of(self.state)))
        if values is not None:
            self.post_message(Choose(values))

    def action_again(self) -> None:
        """Learn the same skills once more."""
        self.post_message(Learn())

    def action_follow(self) -> None:
        """Follow the present formulation."""
        self.query_one(AttemptTable).following = True
        self.draw()

    def action_stop(self) -> None:
        """Stop after the present trial."""
        self.post_message(Stop())

    def action_pause(self) -> None:
        """Wait after the present trial."""
        self.post_message(Pause())

    @work(exclusive=True, group="form")
    async def action_skip(self) -> None:
        """Give the present formulation up, once that is confirmed."""
        if await self.app.push_screen_wait(ConfirmScreen(skip_question(self.state))):
            self.post_message(Skip())

    def action_go_on(self) -> None:
        """Go on."""
        self.post_message(GoOn())

    def check_action(self, action: str, parameters: tuple[object, ...]) -> bool | None:
        """Stop and pause are there while it learns, go on where it paused or was stopped."""
        state = self.state
        learns = state.running and not state.stopping
        if action == "stop":
            return learns
        if action == "follow":
            return self.is_mounted and not self.query_one(AttemptTable).following
        if action == "pause":
            return learns and not state.pausing
        if action == "skip":
            return state.skippable
        if action in ("settings", "again"):
            return not state.running and state.kind != "session"
        if action == "go_on":
            return (learns and state.pausing) or state.resumable
        return super().check_action(action, parameters)


def force_of(attempt: Attempt | None, state: State) -> tuple[Array, Array] | None:
    """The force of a formulation's policy, once one is learned or given up: (T,) seconds and newtons."""
    policy = None
    if attempt and attempt.learned:
        policy = attempt.learned.policy
    elif attempt and attempt.evidence:
        policy = attempt.evidence.policy
    started = state.progress.started
    if policy is None or started is None or not len(policy.gripper_weights):
        return None
    settings = state.progress.settings
    ticks = sum(policy_ticks(policy, settings.world.control_rate))
    limit = robot_of(started.scene).closing_force_limit
    return np.arange(ticks) / settings.world.control_rate, forces(policy, ticks, limit, settings.policy)
