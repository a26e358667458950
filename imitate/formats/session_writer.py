"""A session's file while it is written: appended, flushed after each trial, locked."""

from __future__ import annotations

from collections.abc import Iterator
from heapq import merge
from itertools import chain
from pathlib import Path
from types import TracebackType

from imitate import __version__
from imitate.errors import FileError
from imitate.events import (
    Decided,
    Evaluated,
    Event,
    FormulationStarted,
    OptionLearned,
    Reproduced,
    SessionFinished,
    SessionStarted,
    TrialFinished,
)
from imitate.formats import columns
from imitate.formats.decisions import decisions_json
from imitate.formats.growing import GrowingFile
from imitate.formats.kind import METADATA
from imitate.formats.mcap_writer import ENDING, McapWriter
from imitate.formats.output import refuse_existing
from imitate.formats.session_attachments import DECISIONS, attachments_of, metadata_of
from imitate.formats.session_log import SCHEMA
from imitate.formats.session_messages import SessionMessages, Stamped, channels_of, topic_of
from imitate.formats.session_pictures import picture_channels
from imitate.formats.steps import TrialSteps
from imitate.skill import Decision

_FLUSHED = (FormulationStarted, TrialFinished, Evaluated, OptionLearned, Reproduced, SessionFinished)
"""with the first formulation all that precedes it: no session is cut amid the operator's decisions."""


class SessionWriter:
    """Writes a session while it runs; a listener of the session's events.

    Every finished trial and evaluation is in the file when `write` returns, should the process die; so are
    the segments and decisions from the first formulation on.

    Args:
        path: the new file, in a folder that is made when it does not exist.
        force: replace what is there.
        steps: False keeps what was learned and not how the trials went: such a session cannot be replayed.
        pictures: a recording's messages, which are kept among the demonstration's.

    Raises:
        FileError: the file exists and ``force`` is not given, another process is writing it, or it cannot be
            written.
    """

    def __init__(
        self,
        path: Path | str,
        force: bool = False,
        steps: bool = True,
        pictures: Iterator[Stamped] | None = None,
    ) -> None:
        self.path = Path(path)
        refuse_existing(self.path, force)
        try:
            self.path.parent.mkdir(parents=True, exist_ok=True)
        except OSError as error:
            raise FileError(self.path, f"its folder cannot be made ({error.strerror})") from None
        try:
            self._stream = GrowingFile(self.path, force)
        except FileExistsError:
            raise FileError(self.path, "exists already", "Another session may be writing it.") from None
        except OSError as error:
            raise FileError(self.path, f"cannot be written ({error.strerror})") from None
        self._mcap: McapWriter | None = None
        self._messages = SessionMessages(steps)
        self._steps, self._pictures = steps, pictures
        self._decisions: list[Decision] = []

    def write(self, event: Event) -> None:
        """Appends one event; the first must be SessionStarted.

        Raises:
            FileError: the disk is full or the file cannot be written for another reason; it is closed then,
                and a valid file up to the last trial.
        """
        try:
            if isinstance(event, SessionStarted):
                self._mcap = self._begun(event)
            if self._mcap is None:
                raise ValueError("the first event of a session is SessionStarted")
            self._attach_decisions(self._mcap, event)
            for topic, data, time in self._with_pictures(event):
                self._mcap.write(topic, data, time)
                if topic == topic_of(TrialSteps):
                    self._mcap.flush()  # a chunk of its own, which who wants no steps need not unpack
            if isinstance(event, _FLUSHED):
                self._mcap.flush()
        except OSError as error:
            raise self._given_up(error) from error
        except BaseException:  # Ctrl-C amid a message: what mcap has half done is not gone on with
            self._end_at_last_flush()
            raise

    def take_place_of(self, path: Path) -> None:
        """Puts the file where ``path`` is, and goes on writing it there; nothing of either is ever missing.

        Raises:
            FileError: as in `write`.
        """
        try:
            if self._mcap is not None:
                self._mcap.flush()
            self._stream.settle()
            self.path.replace(path)
        except OSError as error:
            raise self._given_up(error) from error
        self.path = path

    def close(self) -> None:
        """Writes the summary; the file is a whole MCAP file after this, the session complete or not."""
        if self._stream.closed:
            return
        try:
            if self._mcap is not None:
                self._mcap.finish()
                self._stream.flush()
        except OSError as error:
            raise self._given_up(error) from error
        except BaseException:
            self._end_at_last_flush()
            raise
        self._stream.close()

    def __enter__(self) -> SessionWriter:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()

    def _given_up(self, error: OSError) -> FileError:
        why = f"cannot be written any more ({error.strerror})"
        if not self._end_at_last_flush():
            return FileError(self.path, why, "Choose another place.")
        remedy = f"Every trial before is in it. Make room, and go on: imitate resume {self.path}"
        return FileError(self.path, why, remedy)

    def _end_at_last_flush(self) -> bool:
        # What was flushed stays, with an end that needs 50 bytes and no index. Whether there is anything.
        self._mcap = None
        self._stream.cut_back()
        empty = not self._stream.tell()
        try:
            self._stream.write(b"" if empty else ENDING)
            self._stream.flush()
        except OSError:
            pass  # then the end is missing, and every reader of ours reads all the same
        self._stream.close()
        if empty:
            self.path.unlink(missing_ok=True)
        return not empty

    def _with_pictures(self, event: Event) -> Iterator[Stamped]:
        messages = self._messages.of(event)
        if not isinstance(event, SessionStarted) or self._pictures is None:
            return messages
        own = next(messages)
        return chain((own,), merge(messages, self._pictures, key=lambda message: message[2]))

    def _begun(self, event: SessionStarted) -> McapWriter:
        metadata = {
            METADATA: {
                "kind": "session",
                "schema": str(SCHEMA),
                "imitate": __version__,
                "columns": columns.__doc__ or "",
                "steps": "kept" if self._steps else "none",
            }
        }
        channels = channels_of(event) + (picture_channels() if self._pictures is not None else [])
        # a chunk ends where it is flushed: after a trial
        log = McapWriter(self._stream, channels, metadata | metadata_of(event), chunk_size=1 << 26)
        for name, data in attachments_of(event):
            log.attach(name, data)
        return log

    def _attach_decisions(self, log: McapWriter, event: Event) -> None:
        # All of them are there when the first problem is stated.
        if isinstance(event, Decided):
            self._decisions.append(event.decision)
        elif isinstance(event, FormulationStarted) and self._decisions:
            log.attach(DECISIONS, decisions_json(self._decisions).encode())
            self._decisions = []
