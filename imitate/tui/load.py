"""Load: choose what to open."""

from __future__ import annotations

from collections.abc import Iterable
from contextlib import suppress
from pathlib import Path

from PIL import Image
from textual import on, work
from textual.binding import Binding
from textual.containers import Horizontal, Vertical
from textual.content import Content
from textual.widget import Widget
from textual.widgets import DirectoryTree, Label, OptionList, Static, Tree
from textual.widgets.option_list import Option

from imitate.errors import in_words
from imitate.tui.engine import Engine
from imitate.tui.files import Preview
from imitate.tui.intents import Open
from imitate.tui.photo import Photo
from imitate.tui.state import State
from imitate.tui.step import StepScreen
from imitate.tui.words import short

SUFFIXES = (".npz", ".mcap", ".csv", ".parquet", ".hdf5", ".h5")
FOLDERS = ("fixtures", "sessions")


def ready_files(root: Path) -> list[Path]:
    """What lies in fixtures/ and, newest first, in sessions/."""
    found: list[Path] = []
    for name in FOLDERS:
        with suppress(OSError):  # there is no such folder, or one may not read it
            inside = [p for p in (root / name).iterdir() if p.suffix in SUFFIXES and p.is_file()]
            newest_first = name == "sessions"
            inside.sort(key=lambda p: (-p.stat().st_mtime, p.name) if newest_first else (0.0, p.name))
            found += inside
    return found


def can_be_opened(folder: Path) -> bool:
    """Whether a folder is a recording of the TUM kind, or in LeRobot's layout."""
    recording = (folder / "rgb.txt").exists() and (folder / "depth.txt").exists()
    return recording or (folder / "meta" / "info.json").exists()


class Openable(DirectoryTree):
    """Folders, and files that can be opened."""

    HELP = "The folders: Enter opens and closes one; files that hold nothing for this program are left out."

    ICON_NODE = "▸ "
    ICON_NODE_EXPANDED = "▾ "
    ICON_FILE = "  "

    def filter_paths(self, paths: Iterable[Path]) -> Iterable[Path]:
        """No hidden ones, no other files."""
        return [
            path
            for path in paths
            if not path.name.startswith((".", "__")) and (path.suffix in SUFFIXES or path.is_dir())
        ]


class LoadScreen(StepScreen):
    """Files on the left, what the selected one holds on the right."""

    STEP = "load"
    HELP = (
        "Load: choose what to teach from. A demonstration (.npz, .mcap) holds the tracked poses of the "
        "hand and the objects; a recording (.mcap, or a folder with rgb.txt and depth.txt) holds "
        "pictures, which are tracked first; a session (.mcap) shows its result. The right side says what "
        "the selected file holds, with a recording's first picture, and what is wrong with it."
    )
    BINDINGS = [
        Binding("o", "open", "open", id="load.open", tooltip="Open the selected file; Enter does the same"),
        Binding("tab", "app.focus_next", "next list", id="load.next", tooltip="From the list to the folders"),
    ]

    def __init__(self, state: State, engine: Engine, root: Path, photo: Photo | None) -> None:
        super().__init__(state)
        self._photo = photo
        self._engine, self._root = engine, root
        self._ready = ready_files(root)
        self.selected: Path | None = None
        self.preview: Preview | str = ""

    def body(self) -> Iterable[Widget]:
        """Two lists and the preview."""
        options = [Option(short(path, self._root), id=str(i)) for i, path in enumerate(self._ready)]
        tree = Openable(self._root)
        tree.show_root = False
        tree.guide_depth = 2
        yield Horizontal(
            Vertical(
                Label("Ready to open", markup=False),
                OptionList(*options, id="ready", markup=False),
                Label("Folders", markup=False),
                tree,
                id="files",
            ),
            Vertical(
                Label("", id="name", markup=False),
                Static(id="preview", markup=False),
                *([self._photo()] if self._photo else []),
                id="about",
            ),
        )

    def on_mount(self) -> None:
        """Start on the list where it has something, else in the folders."""
        super().on_mount()
        ready = self.query_one("#ready", OptionList)
        ready.display = bool(self._ready)
        (ready if self._ready else self.query_one(Openable)).focus()

    @on(OptionList.OptionHighlighted, "#ready")
    def _on_ready(self, event: OptionList.OptionHighlighted) -> None:
        self._select(self._ready[event.option_index])

    @on(Tree.NodeHighlighted)
    def _on_node(self, event: Tree.NodeHighlighted[object]) -> None:
        path = getattr(event.node.data, "path", None)
        if isinstance(path, Path) and self.query_one(Openable).has_focus:
            self._select(path)

    @on(OptionList.OptionSelected, "#ready")
    def _on_chosen(self, event: OptionList.OptionSelected) -> None:
        self.post_message(Open(self._ready[event.option_index]))

    @on(DirectoryTree.FileSelected)
    def _on_file(self, event: DirectoryTree.FileSelected) -> None:
        self.post_message(Open(event.path))

    def action_open(self) -> None:
        """Open what is selected, a folder that holds something too."""
        if self.selected and (self.selected.is_file() or can_be_opened(self.selected)):
            self.post_message(Open(self.selected))

    def _select(self, path: Path) -> None:
        self.selected = path
        self.query_one("#name", Label).update(short(path, self._root))
        if path.is_dir() and not can_be_opened(path):
            self._show(path, "a folder")
        else:
            self._look(path)

    @work(thread=True, exclusive=True, group="look", exit_on_error=False)
    def _look(self, path: Path) -> None:
        try:
            preview: Preview | str = self._engine.look(path)
        except Exception as error:  # a file of any kind may be selected: say it, and go on
            preview = f"✗ This cannot be opened.\n\n{in_words(error)}"
        self.app.call_from_thread(self._show, path, preview)

    def _show(self, path: Path, preview: Preview | str) -> None:
        if path != self.selected:
            return
        self.preview = preview
        self.query_one("#preview", Static).update(
            Content(preview) if isinstance(preview, str) else preview_text(preview)
        )
        picture = None if isinstance(preview, str) else preview.picture
        for photo in self.query("#photo"):
            photo.display = picture is not None
            if picture is not None:
                photo.image = Image.fromarray(picture)  # type: ignore[attr-defined]


def preview_text(preview: Preview) -> Content:
    """Kind and facts, one a line."""
    width = max((len(name) for name, _ in preview.facts), default=0)
    lines = [Content.styled(f"✓ a {preview.kind}", "bold $text-success"), Content("")]
    lines += [Content.assemble((f"{name:<{width}}  ", "$text-muted"), value) for name, value in preview.facts]
    lines += [Content.assemble(("▲ ", "bold $text-warning"), fault) for fault in preview.wrong]
    return Content("\n").join(lines)
