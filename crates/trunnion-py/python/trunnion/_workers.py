"""Worker processes of this machine: items go in, and results come out, as pickles.

A worker imports what its items need, and nothing else: a script that uses a fleet is not run again in each of them, as it
would be by `multiprocessing`, and needs no `if __name__ == "__main__"`.
"""

from __future__ import annotations

import concurrent.futures as futures
import contextlib
import multiprocessing.spawn
import os
import pickle
import queue
import signal
import subprocess
import sys
from typing import IO, Any, Callable, Generator, Sequence, cast

#: Modules are found where this process finds them.
_BOOT = """
import pickle, sys
sys.path[:] = pickle.load(sys.stdin.buffer)
from trunnion import _workers
_workers.serve()
"""


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

    def call(self, function: Callable[[Any], Any], item: Any) -> Any:
        """Calls the function in the process, and returns or raises what it does."""
        self._send((function, item))
        try:
            result, error = pickle.load(self._results)
        except (EOFError, pickle.UnpicklingError):
            code = self._process.wait()
            by = f"by signal {-code}" if code < 0 else f"with exit code {code}"
            raise WorkerDied(f"the worker process ended {by} in the middle of this item") from None
        if error is not None:
            raise error
        return result

    def stop(self) -> None:
        """Ends the process, whatever it does."""
        self._process.kill()
        self._process.wait()
        with contextlib.suppress(OSError):
            self._items.close()


def serve() -> None:
    """Answers calls until nobody asks any more; runs in the worker."""
    # The process that has the workers hears Ctrl-C, and ends them.
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    results = os.fdopen(os.dup(1), "wb")
    # Whatever an item prints is no result.
    os.dup2(2, 1)
    while True:
        try:
            function, item = pickle.load(sys.stdin.buffer)
        except EOFError:
            return
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
        pickle.loads(text)
    except Exception:
        # Some exceptions cannot be sent, and some cannot be received.
        return pickle.dumps((None, RuntimeError(f"{type(answer[1]).__name__}: {answer[1]}")))
    return text


def each(
    function: Callable[[Any], Any], items: Sequence[Any], workers: int | None, tries: int
) -> Generator[tuple[Any, Any, BaseException | None], None, None]:
    """Calls a function with every item in worker processes, and yields item, result and error as they finish.

    An item in the middle of which a worker ends is tried again in a new one, `tries` times in all. Leaving the loop ends
    the workers at once.
    """
    count = min(workers or os.cpu_count() or 1, len(items))
    idle: queue.SimpleQueue[_Worker | None] = queue.SimpleQueue()
    for _ in range(count):
        idle.put(None)
    started: list[_Worker] = []
    stopped = False

    def called(item: Any) -> Any:
        for trial in range(tries):
            worker = idle.get()
            try:
                if worker is None:
                    worker = _Worker()
                    started.append(worker)
                if stopped:
                    raise WorkerDied("the loop was left")
                return worker.call(function, item)
            except WorkerDied:
                worker = None
                if stopped or trial + 1 == tries:
                    raise
            finally:
                idle.put(worker)

    pool = futures.ThreadPoolExecutor(count)
    try:
        tasks = {pool.submit(called, item): item for item in items}
        for task in futures.as_completed(tasks):
            error = task.exception()
            yield tasks[task], task.result() if error is None else None, error
    finally:
        stopped = True
        pool.shutdown(wait=False, cancel_futures=True)
        for worker in list(started):
            worker.stop()
        pool.shutdown()
        # One more may have been on its way.
        for worker in started:
            worker.stop()
