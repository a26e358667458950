"""How each step looks, at the smallest size and at a comfortable one."""

from __future__ import annotations

from collections.abc import Awaitable, Callable
from dataclasses import replace
from itertools import islice
from pathlib import Path
from typing import Any

import pytest
import scripted
from scripted_app import SAME, Script, at, drawn, scripted_app, until
from textual.command import CommandList, CommandPalette
from textual.pilot import Pilot
from textual.widgets import DirectoryTree, Input, Label, Static

from imitate import events
from imitate.errors import ImitateError
from imitate.session.replay import Divergence
from imitate.skill import Decision
from imitate.tui.app import ImitateApp
from imitate.tui.curve import ForceCurve
from imitate.tui.films import FilmTable
from imitate.tui.fingers import FingersScreen
from imitate.tui.form import FormScreen
from imitate.tui.intents import Pause
from imitate.tui.looking import VIEWS, Looking
from imitate.tui.overlay import Overlay
from imitate.tui.player import Player

SESSION = "sessions/stack-001.mcap"
SMALL, LARGE = (80, 24), (120, 40)
Look = Callable[..., bool]


@pytest.fixture(params=[SMALL, LARGE], ids=["80x24", "120x40"])
def size(request: pytest.FixtureRequest) -> tuple[int, int]:
    chosen: tuple[int, int] = request.param
    return chosen


@pytest.fixture
def look(
    snap_compare: Callable[..., bool],
    size: tuple[int, int],
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
) -> Look:
    """Compare the application's picture once ``ready`` holds and ``keys`` were pressed."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("TEXTUAL_ANIMATIONS", "none")

    def compare(
        ready: Callable[[ImitateApp], Callable[[], bool]],
        keys: str = "",
        then: Callable[[ImitateApp], Callable[[], bool]] | None = None,
        script: Script | None = None,
        between: Callable[[Pilot[None]], Awaitable[None]] | None = None,
        **options: Any,
    ) -> bool:
        app = scripted_app(tmp_path, script, **options)
        app.animation_level = "none"

        async def run(pilot: Pilot[None]) -> None:
            def weighed() -> bool:
                return not at(app, "review")() or bool(app.state.changes)

            await until(pilot, ready(app))
            await until(pilot, weighed)  # keys that come earlier meet another state
            for key in keys.split():
                await pilot.press(key)
                await pilot.pause()
            if between:
                await between(pilot)
            if then:
                await until(pilot, then(app))
            await until(pilot, weighed)
            await until(pilot, lambda: not app._changed)
            await drawn(pilot)

        return snap_compare(app, terminal_size=size, run_before=run)

    return compare


def shown(step: str) -> Callable[[ImitateApp], Callable[[], bool]]:
    return lambda app: at(app, step)


def when(holds: Callable[[ImitateApp], bool]) -> Callable[[ImitateApp], Callable[[], bool]]:
    return lambda app: lambda: holds(app)


def previewed(text: str) -> Callable[[ImitateApp], Callable[[], bool]]:
    def holds(app: ImitateApp) -> bool:
        if not at(app, "load")():
            return False
        tree = app.screen.query_one(DirectoryTree)
        said = str(app.screen.query_one("#preview", Static).render())
        return len(tree.root.children) == 2 and text in said

    return when(holds)


def until_first(kind: type, extra: int) -> list[events.Event]:
    """The scripted session up to ``extra`` events after the first of a kind."""
    story = list(scripted.session())
    first = next(k for k, event in enumerate(story) if isinstance(event, kind))
    return story[: first + 1 + extra]


def test_load(look: Look) -> None:
    ready = previewed("This cannot be opened")
    assert look(ready, "down down", previewed("361"), source=None)


def test_load_shows_a_recordings_first_picture(look: Look) -> None:
    assert look(previewed("This cannot be opened"), "down", previewed("left out"), source=None)


def test_load_says_what_is_wrong_with_a_file(look: Look) -> None:
    assert look(previewed("Record it again"), source=None)


def test_observe(look: Look) -> None:
    ready = when(lambda app: app.state.observed > 0.4)
    assert look(ready, script=Script(hold=True), source="fixtures/stack.mcap")


NO_HAND = ImitateError("stack.mcap: no hand. Wear a red finger on the left and a yellow one on the right.")


@pytest.mark.parametrize("late", [False, True], ids=["at once", "at its end"])
def test_observe_says_why_it_failed(look: Look, late: bool) -> None:
    def failed(app: ImitateApp) -> bool:
        return bool(app.state.unseen) and at(app, "observe")() and app.screen.query_one(Overlay).display

    script = Script(unseen=NO_HAND, late=late)
    assert look(when(failed), source="fixtures/stack.mcap", script=script)


@pytest.mark.parametrize("keys", ["", "H H H H H H H H H H H H L L"], ids=["last frame", "lost"])
def test_observe_afterwards(look: Look, keys: str) -> None:
    back = when(lambda app: app.state.done("observe") and at(app, "observe")())

    async def scrub(pilot: Pilot[None]) -> None:
        await until(pilot, at(pilot.app, "observe"))  # type: ignore[arg-type]
        await pilot.press(*keys.split())

    assert look(shown("review"), "escape", back, between=scrub, source="fixtures/stack.mcap")


def test_observe_without_colour(look: Look, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("NO_COLOR", "1")
    ready = when(lambda app: app.state.observed > 0.4)
    assert look(ready, script=Script(hold=True), source="fixtures/stack.mcap")


def test_pointing_at_the_fingers(look: Look) -> None:
    pointing = when(lambda app: isinstance(app.screen, FingersScreen))
    assert look(shown("observe"), "f", pointing, source="fixtures/stack.mcap", script=Script(hold=True))


def test_review(look: Look) -> None:
    decided = when(lambda app: len(app.state.decisions) == 2)
    assert look(shown("review"), "L right", decided)


def test_review_of_a_recording_with_a_doubted_choice(look: Look) -> None:
    def doubted(app: ImitateApp) -> Callable[[], bool]:
        return lambda: bool(app.state.doubts) and len(app.state.album.shots) == 25

    async def keys(pilot: Pilot[None]) -> None:
        await until(pilot, doubted(pilot.app))  # type: ignore[arg-type]
        await pilot.press("comma", "comma")
        pilot.app.clear_notifications()  # they go by the clock

    source = "fixtures/stack.mcap"
    script = Script(watched=True)
    assert look(shown("review"), "enter down enter", doubted, script, between=keys, source=source)


@pytest.mark.parametrize("size", [SMALL], ids=["80x24"])
@pytest.mark.parametrize("view", ["distances", "along", "lists"])
def test_review_where_there_is_room_for_one_view(look: Look, view: str) -> None:
    turned = when(lambda app: app.screen.query_one(Looking).has_class(view))
    assert look(shown("review"), " ".join("v" * VIEWS.index(view)), turned)


def test_review_after_a_reset(look: Look) -> None:
    reset = when(lambda app: app.state.decisions[-1:] == (Decision("reset"),))
    assert look(shown("review"), "L x R", reset)


def test_review_after_an_undo(look: Look) -> None:
    undone = when(lambda app: app.state.redoable == 1)
    assert look(shown("review"), "L u", undone)


def test_review_of_the_alternatives_in_the_light_theme(look: Look) -> None:
    assert look(shown("review"), "ctrl+t down enter down")


def test_review_without_colour(look: Look, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("NO_COLOR", "1")
    assert look(shown("review"), "down")


def test_review_of_a_refused_decision(look: Look) -> None:
    noticed = when(lambda app: len(app._notifications) == 1)
    assert look(shown("review"), "down right", noticed)


def test_learn_once_a_problem_was_stated_anew(look: Look) -> None:
    story = until_first(events.Reformulated, 11)
    present = when(lambda app: len(app.state.attempts) == 3 and app.state.attempts[2].explored == 9)
    assert look(shown("review"), "s", present, Script(story, hold=True))


def test_learn_with_the_parts_of_the_cost(look: Look) -> None:
    story = until_first(events.Reformulated, 11)
    present = when(lambda app: len(app.state.attempts) == 3 and app.state.attempts[2].explored == 9)
    script = Script(story, hold=True)

    def parted(app: ImitateApp) -> Callable[[], bool]:
        return lambda: app.screen.query_one("#key", Label).render().plain.endswith("g grip")

    async def keys(pilot: Pilot[None]) -> None:
        await until(pilot, present(pilot.app))  # type: ignore[arg-type]
        await pilot.press("2", "4")

    assert look(shown("review"), "s", parted, script, between=keys)


def test_learn_shows_the_force_that_was_learned(look: Look, size: tuple[int, int]) -> None:
    forced = when(lambda app: app.screen.query_one(ForceCurve).display)
    keys = "escape up" if size == LARGE else "escape up 5"
    assert look(shown("reproduce"), keys, forced, source=SESSION)


def test_settings_before_learning(look: Look) -> None:
    asking = when(lambda app: isinstance(app.screen, FormScreen))
    assert look(shown("review"), "e", asking)


def test_learn_before_the_first_trial(look: Look) -> None:
    assert look(shown("review"), "s", shown("learn"), Script([], hold=True))


def test_asking_before_quitting(look: Look) -> None:
    async def quitting(pilot: Pilot[None]) -> None:
        app = pilot.app
        assert isinstance(app, ImitateApp)
        await until(pilot, lambda: bool(app.state.attempts) and app.state.attempts[0].explored == 5)
        await drawn(pilot)  # what lies under a note is not laid out anew
        await pilot.press("q")

    script = Script(list(islice(scripted.session(), 8)), hold=True)
    asked = when(lambda app: app.step is None)
    assert look(shown("review"), "s", asked, script, between=quitting)


def test_reproduce_before_anything_is_run(look: Look) -> None:
    assert look(shown("review"), "s", shown("reproduce"), Script(list(scripted.session())))


def test_reproduce_without_success(look: Look) -> None:
    story = list(scripted.session(reproduced=False))
    assert look(shown("review"), "s", shown("reproduce"), Script(story))


def test_reproduce_while_it_runs(look: Look) -> None:
    running = when(lambda app: len(app.state.trying.films) == 10)
    options = {"source": SESSION, "script": Script(hold=True)}
    assert look(shown("reproduce"), "r", running, **options)


def test_reproduce_from_perturbed_starts(look: Look) -> None:
    def ran(app: ImitateApp) -> Callable[[], bool]:
        return lambda: app.state.trying.result is not None and app.screen.query_one(FilmTable).row_count == 10

    async def keys(pilot: Pilot[None]) -> None:
        await until(pilot, ran(pilot.app))  # type: ignore[arg-type]
        await drawn(pilot)
        await pilot.press("up", "up", *["shift+right"] * 5)

    chosen = when(lambda app: app.screen.query_one(Player).frame > 60)
    assert look(shown("reproduce"), "r", chosen, source=SESSION, between=keys)


def test_a_start_is_typed(look: Look) -> None:
    typing = when(lambda app: isinstance(app.screen, FormScreen))
    assert look(shown("reproduce"), "f end x", typing, source=SESSION)


def test_learning_that_stopped_can_be_gone_on_with(look: Look) -> None:
    story = list(islice(scripted.session(), 8))
    ending = ImitateError("The disk is full. Free some space, then learn again.")
    stopped = when(lambda app: app.state.resumable)
    assert look(shown("review"), "s", stopped, Script(story, ending=ending))


def test_learn_paused(look: Look) -> None:
    story = until_first(events.Reformulated, 11)
    present = when(lambda app: len(app.state.attempts) == 3 and app.state.attempts[2].explored == 9)
    script = Script(story, hold=True)

    def paused(app: ImitateApp) -> Callable[[], bool]:
        def holds() -> bool:
            if present(app)():
                app.post_message(Pause())
            return app.state.pausing

        return holds

    assert look(shown("review"), "s", paused, script)


def read(app: ImitateApp) -> Callable[[], bool]:
    return lambda: app.state.library.read and at(app, "replay")()


def test_replay_before_it_is_verified(look: Look) -> None:
    async def keys(pilot: Pilot[None]) -> None:
        await until(pilot, lambda: pilot.app.screen.query_one(FilmTable).row_count == 6)
        await pilot.press("down")
        await drawn(pilot)
        await pilot.press(*["L"] * 5)

    scrubbed = when(lambda app: app.screen.query_one(Player).frame > 60)
    assert look(shown("reproduce"), "n", scrubbed, source=SESSION, between=keys)


def test_replay_while_it_is_verified(look: Look) -> None:
    verifying = when(lambda app: app.state.checking.share > 0 and read(app)())
    assert look(shown("reproduce"), "n v", verifying, Script(hold=True), source=SESSION)


def test_replay_verified(look: Look) -> None:
    verified = when(lambda app: app.state.checking.report is not None and read(app)())
    assert look(shown("reproduce"), "n v", verified, source=SESSION)


def test_replay_that_diverged_without_colour(look: Look, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("NO_COLOR", "1")
    first = Divergence(17, 1, 0, 3, "hand_poses[0]", 0.25, 0.5)
    report = replace(SAME, divergent=12, first_divergence=first)
    verified = when(lambda app: app.state.checking.report is not None and read(app)())
    assert look(shown("reproduce"), "n v", verified, Script(report=report), source=SESSION)


def test_a_recorded_session(look: Look) -> None:
    assert look(shown("reproduce"), "escape", shown("learn"), source=SESSION)


def test_help(look: Look) -> None:
    assert look(shown("review"), "f1")


def test_commands_that_apply_now(look: Look) -> None:
    async def still(pilot: Pilot[None]) -> None:
        await until(pilot, lambda: isinstance(pilot.app.screen, CommandPalette))
        pilot.app.screen.query_one(Input).cursor_blink = False

    listed = when(lambda app: app.screen.query_one(CommandList).option_count > 10)
    assert look(shown("review"), "ctrl+p", listed, between=still)
