"""The engine: the Python package trunnion, called beside the window."""

from __future__ import annotations

import threading
from typing import Any, Callable

from .problem import Problem, words
from .translate import translated

#: Versions of the package that this add-on works with.
_LEAST = (0, 1)


def engine() -> Any:
    """Returns the package trunnion."""
    try:
        import trunnion
    except ImportError as error:
        raise Problem(
            translated("the Python package trunnion cannot be loaded: {error}", error=error),
            translated("install it for the Python of FreeCAD: pip install trunnion"),
        ) from None
    version = tuple(int(part) for part in trunnion.__version__.split(".")[:2])
    if version < _LEAST:
        least = ".".join(map(str, _LEAST))
        raise Problem(
            translated("trunnion {version} is too old", version=trunnion.__version__),
            translated("install {least} or later: pip install -U trunnion", least=least),
        )
    return trunnion


class Cancelled(Exception):
    """The user gave up."""


class Work:
    """One call beside the window: `call(progress)` runs in a thread of its own.

    Attributes:
        stage, done, total: how far it is, for a progress bar.
        result: what the call returned, when `finished`.
        error: words of the error that ended it, or "".
    """

    def __init__(self, call: Callable[[Callable[[str, int, int], None]], Any]) -> None:
        self.stage, self.done, self.total = "", 0, 0
        self.result: Any = None
        self.error = ""
        self.cancelled = False
        self._call = call
        self._thread = threading.Thread(target=self._run, daemon=True)

    def start(self) -> "Work":
        """Starts the thread."""
        self._thread.start()
        return self

    @property
    def finished(self) -> bool:
        """True when the thread has ended."""
        return not self._thread.is_alive() and self._thread.ident is not None

    def cancel(self) -> None:
        """Asks the call to stop at its next report."""
        self.cancelled = True

    def wait(self) -> Any:
        """Waits for the result; raises Problem with the words of an error."""
        self._thread.join()
        if self.error:
            raise Problem(self.error)
        return self.result

    def _report(self, stage: str, done: int, total: int) -> None:
        self.stage, self.done, self.total = stage, done, total
        if self.cancelled:
            raise Cancelled

    def _run(self) -> None:
        try:
            self.result = self._call(self._report)
        except Cancelled:
            self.error = translated("stopped; nothing was changed")
        except Exception as error:  # Whatever it is, the window has to show it.
            self.error = translated("stopped; nothing was changed") if self.cancelled else words(error)
