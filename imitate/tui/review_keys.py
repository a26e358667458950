"""The keys of Review, and its help."""

from __future__ import annotations

from textual.binding import Binding

REVIEW_HELP = (
    "Review: the demonstration was cut into skills. Each has the bodies that matter (relevant) and "
    "the object in whose frame they are seen (reference). Select a skill with up and down. Left and "
    "right move its end (of the last skill: its start), ▲ below the bands. Enter goes to the ranked "
    "alternatives, with how well each explains the skill (natural log; 0 is the best); Enter there "
    "chooses. Shaded, and beside ▲, is when with 90 % probability the motion changes from a skill to "
    "the next; the rests beside a carry are part of it. ▼ above the bands is the time that you look at: "
    "comma and full stop move it, space plays. Picture, scene and plots are of that time; where there "
    "is no room for all, v shows the next. What you chose has a star, ! where the motion is far less "
    "likely than as found: it is kept all the same. Every change is a decision in the session."
)
REVIEW_KEYS = [
    Binding("left,h", "nudge(-1, 0)", "move", id="review.frame_back", priority=True,
            tooltip="Move the selected boundary by a frame; h and l do the same", key_display="←→"),
    Binding("right,l", "nudge(1, 0)", "frame", id="review.frame_on", priority=True, show=False),
    Binding("shift+left,H", "nudge(0, -1)", "0.1 s", id="review.time_back", priority=True, show=False,
            tooltip="Move it by 0.1 s; shift with the arrows does the same", key_display="HL"),
    Binding("shift+right,L", "nudge(0, 1)", "0.1 s", id="review.time_on", priority=True, show=False),
    Binding("ctrl+left,left_curly_bracket", "nudge(0, -10)", "1 s", id="review.second_back", priority=True,
            show=False, tooltip="Move it by a second; control with the arrows does the same",
            key_display="{}"),
    Binding("ctrl+right,right_curly_bracket", "nudge(0, 10)", "1 s", id="review.second_on", priority=True,
            show=False),
    Binding("b", "here", "here", id="review.here", show=False,
            tooltip="Move the boundary to the time that you look at"),
    Binding("comma", "look(-1, 0)", "time", id="review.look_back", key_display=",.",
            tooltip="Look a frame earlier or later; < and > a second"),
    Binding("full_stop", "look(1, 0)", "time", id="review.look_on", show=False),
    Binding("less_than_sign", "look(0, -1)", "time", id="review.leap_back", show=False),
    Binding("greater_than_sign", "look(0, 1)", "time", id="review.leap_on", show=False),
    Binding("space", "play", "play", id="review.play", show=False, priority=True,
            tooltip="Play the demonstration from the time that you look at, or stop it there"),
    Binding("v", "view", "view", id="review.view",
            tooltip="Show the scene, the distances, what moves along with the hand, or the lists alone"),
    Binding("a", "alternatives", "other", id="review.alternatives", show=False,
            tooltip="Choose another abstraction for the selected skill"),
    Binding("x", "split", "split", id="review.split",
            tooltip="Split the selected skill in two, where that explains most"),
    Binding("X", "split_here", "split here", id="review.split_here", show=False,
            tooltip="Split the skill at the time that you look at"),
    Binding("m", "merge", "merge", id="review.merge",
            tooltip="Merge the selected skill with the next one; the last with the one before"),
    Binding("u", "undo", "undo", id="review.undo", tooltip="Take back the last decision"),
    Binding("r,ctrl+y", "redo", "redo", id="review.redo", tooltip="Do again what was undone last"),
    Binding("R", "reset", "reset", id="review.reset", show=False,
            tooltip="Back to everything as it was found; u takes that back"),
    Binding("w", "write", "write", id="review.write", show=False,
            tooltip="Write your decisions to a file in sessions/, for imitate segment and imitate learn"),
    Binding("e", "settings", "settings", id="review.settings", show=False,
            tooltip="α, C, trials, workers and seed for learning"),
    Binding("s", "learn", "learn", id="review.learn", tooltip="Learn these skills"),
]  # fmt: skip
