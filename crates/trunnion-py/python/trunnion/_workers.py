"""Worker processes of this machine: items go in, and results come out, as pickles.

A worker imports what its items need, and nothing else: a script that uses a fleet is not run again in each of them, as it
would be by `multiprocessing`, and needs no `if __name__ == "__main__"`.
"""

from __future__ import annotations

import collections
import concurrent.futures as futures
import contextlib
import multiprocessing.spawn
import os
import pickle
import queue
import subprocess
import sys
import threading
from typing import IO, Any, Callable, Generator, Sequence, cast

#: Modules are found where this process finds them.
_BOOT = """
import pickle, sys
sys.path[:] = pickle.load(sys.stdin.buffer)
from trunnion import _serve
_serve.serve()
"""


#: Item, result and error.
_Found = tuple[Any, Any, Exception | None]

#: Items that a worker takes at once, at most.
_AT_ONCE = 8


class WorkerDied(Exception):
    """A worker process ended in the middle of an item."""


class _Worker:
    """Process that calls functions, one after another."""

    def __init__(self) -> None:
        # As many workers as cores: threads of their own would only wait for each other.
        surroundings = {**os.environ, "RAYON_NUM_THREADS": "1"}
        pipe = subprocess.PIPE
        words = [os.fsdecode(multiprocessing.spawn.get_executable() or sys.executable), "-c", _BOOT]
        self._process = subprocess.Popen(words, stdin=pipe, stdout=pipe, env=surroundings)
        self._items = cast("IO[bytes]", self._process.stdin)
        self._results = cast("IO[bytes]", self._process.stdout)
        self._send(sys.path)

    def _send(self, value: Any) -> None:
        try:
            self._items.write(pickle.dumps(value))
            self._items.flush()
        except OSError:
            # It has ended; that is found where its answer is waited for.
            pass

    def answers(
        self, function: Callable[[Any], Any], items: Sequence[Any]
    ) -> Generator[tuple[Any, Exception | None], None, None]:
        """Calls the function in the process with one item after another; yields results and errors as they come."""
        self._send((function, items))
        for _ in items:
            try:
                yield pickle.load(self._results)
            except (EOFError, pickle.UnpicklingError):
                code = self._process.wait()
                by = f"by signal {-code}" if code < 0 else f"with exit code {code}"
                raise WorkerDied(f"the worker process ended {by} in the middle of this item") from None

    def stop(self) -> None:
        """Ends the process, whatever it does."""
        self._process.kill()
        self._process.wait()
        with contextlib.suppress(OSError):
            self._items.close()

    def close(self) -> None:
        """Ends the process; nobody may be waiting for its results any more."""
        self.stop()
        self._results.close()


def each(
    function: Callable[[Any], Any], items: Sequence[Any], workers: int | None, tries: int
) -> Generator[_Found, None, None]:
    """Calls a function with every item in worker processes, and yields item, result and error as they finish.

    An item in the middle of which a worker ends is tried again in a new one, `tries` times in all. Leaving the loop ends
    the workers at once.
    """
    count = min(workers or os.cpu_count() or 1, len(items))
    waiting = collections.deque((item, 1) for item in items)
    found: queue.SimpleQueue[_Found] = queue.SimpleQueue()
    crew: list[_Worker] = []
    left = threading.Event()

    def taken() -> list[tuple[Any, int]]:
        # Several at once, so that no worker waits for this process between short items; one by one towards the end, so
        # that none has a long queue while others have nothing to do.
        size = max(1, min(_AT_ONCE, len(waiting) // (4 * count)))
        batch = []
        with contextlib.suppress(IndexError):
            for _ in range(size):
                batch.append(waiting.popleft())
        return batch

    def drive() -> None:
        worker = None
        while not left.is_set() and (batch := taken()):
            if worker is None:
                worker = _Worker()
                crew.append(worker)
            answered = 0
            try:
                for result, error in worker.answers(function, [item for item, _ in batch]):
                    found.put((batch[answered][0], result, error))
                    answered += 1
            except WorkerDied as death:
                worker = None
                item, trial = batch[answered]
                if trial < tries:
                    waiting.append((item, trial + 1))
                else:
                    found.put((item, None, death))
                waiting.extendleft(reversed(batch[answered + 1 :]))

    with futures.ThreadPoolExecutor(count) as pool:
        drivers = [pool.submit(drive) for _ in range(count)]
        try:
            for _ in items:
                yield _next(found, drivers)
        finally:
            left.set()
            for worker in list(crew):
                worker.stop()
    # One more may have been on its way.
    for worker in crew:
        worker.close()


def _next(found: queue.SimpleQueue[_Found], drivers: Sequence[futures.Future[None]]) -> _Found:
    """Returns the next result, or raises what keeps workers from starting."""
    while True:
        try:
            # Waiting without end would not hear Ctrl-C everywhere.
            return found.get(timeout=0.2)
        except queue.Empty:
            for driver in drivers:
                if driver.done():
                    driver.result()
