"""Exceptions and warnings of the package."""

from __future__ import annotations

import os
import re
import sys

# The name alone tells type checkers; the module `typing` would delay every worker.
TYPE_CHECKING = False
if TYPE_CHECKING:
    from typing import Iterable

_PLACE = re.compile(r"^(?P<file>(?:[A-Za-z]:[\\/])?.*?):(?:(?P<line>\d+)(?::(?P<column>\d+))?:)? (?P<text>.*)$", re.S)
#: Path of a file: an ending, or a folder before a name without spaces; sentences with figures have a full stop as well.
_PATH = re.compile(r"[^=()]*(\.[A-Za-z]\w{0,7}|[/\\][^/\\ ]*)")

#: Note on exceptions of arguments, by PyO3.
_NOTE = re.compile(r"while processing '(\w+)'")


class TrunnionError(Exception):
    """Something could not be done. Base of all exceptions of this package.

    Attributes:
        message: the reason with values and units, first of `messages`.
        remedy: how to put it right; empty if the message suffices.
        file: the file concerned, or None.
        line: its line, counted from 1, or None.
        column: its column, counted from 1, or None.
        messages: everything that was found, each complete in itself.
    """

    def __init__(self, *messages: str) -> None:
        super().__init__("\n".join(messages))
        self.messages: tuple[str, ...] = messages
        first, _, remedy = (messages[0] if messages else "").partition("\n  help: ")
        self.remedy: str = remedy
        self.file: str | None = None
        self.line: int | None = None
        self.column: int | None = None
        found = _PLACE.match(first)
        # A colon alone is no place: words may have one too.
        if found and (found["line"] or _PATH.fullmatch(found["file"])):
            self.file = found["file"]
            self.line = int(found["line"]) if found["line"] else None
            self.column = int(found["column"]) if found["column"] else None
            first = found["text"]
        self.message: str = first


class InputError(TrunnionError, ValueError):
    """A file, text, table or option cannot be used."""


class ArgumentError(InputError):
    """An argument of a call cannot be used.

    Attributes:
        argument: its name.
        index: index of the wrong entry, or None if the argument as a whole is wrong.
        value: the wrong entry, shape or type.
    """

    def __init__(
        self,
        message: str,
        argument: str = "",
        index: tuple[int, ...] | None = None,
        value: object = None,
    ) -> None:
        super().__init__(message)
        self.argument = argument
        self.index = index
        self.value = value

    def add_note(self, note: str) -> None:
        """Takes the name of the argument, which the native module knows last, from its note; keeps every other note."""
        found = _NOTE.fullmatch(note)
        if found and not self.argument:
            # The message begins with the name that was not known.
            ArgumentError.__init__(self, found[1] + self.messages[0], found[1], self.index, self.value)
        elif hasattr(super(), "add_note"):
            # Python 3.10 has no notes.
            super().add_note(note)

    def __reduce__(self) -> tuple[type, tuple[object, ...]]:
        return (type(self), (self.messages[0], self.argument, self.index, self.value))


class UnfinishedError(TrunnionError, RuntimeError):
    """The work could not be finished; `messages` names what was kept."""


class InternalError(TrunnionError, RuntimeError):
    """Something failed that is not the caller's fault."""


class StoppedError(TrunnionError, RuntimeError):
    """The work was stopped on request."""


class TrunnionWarning(UserWarning):
    """A remark about an input or a result."""


class UnreachableWarning(TrunnionWarning):
    """Some poses have no axis position."""


def warn(messages: Iterable[str], category: type[Warning] = TrunnionWarning) -> None:
    """Warns of each message, at the line outside this package that called it."""
    import warnings

    own = os.path.dirname(os.path.abspath(__file__)) + os.sep
    frame, level = sys._getframe(1), 2
    while frame.f_back is not None and os.path.abspath(frame.f_code.co_filename).startswith(own):
        frame, level = frame.f_back, level + 1
    for message in messages:
        warnings.warn(message, category, stacklevel=level)
