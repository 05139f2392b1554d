"""The inside of a worker process; a module of its own, since every import delays the first item."""

from __future__ import annotations

import os
import pickle
import signal
import sys

# The name alone tells type checkers; the module `typing` would delay every worker.
TYPE_CHECKING = False
if TYPE_CHECKING:
    from typing import Any


def serve() -> None:
    """Answers calls until nobody asks any more; runs in the worker."""
    # The process that has the workers hears Ctrl-C, and ends them.
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    results = os.fdopen(os.dup(1), "wb")
    # Whatever an item prints is no result.
    os.dup2(2, 1)
    while True:
        try:
            function, items = pickle.load(sys.stdin.buffer)
        except EOFError:
            return
        for item in items:
            answer: tuple[Any, Exception | None]
            try:
                answer = function(item), None
            except Exception as error:
                answer = None, error
            results.write(_pickled(answer))
            results.flush()


def _pickled(answer: tuple[Any, Exception | None]) -> bytes:
    try:
        text = pickle.dumps(answer)
        if answer[1] is not None:
            pickle.loads(text)
    except Exception:
        # Some exceptions cannot be sent, and some cannot be received.
        return pickle.dumps((None, RuntimeError(f"{type(answer[1]).__name__}: {answer[1]}")))
    return text
