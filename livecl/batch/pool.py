# SPDX-License-Identifier: Apache-2.0
"""Pool of worker processes, each with its own OpenCL context; crashed ones are replaced.

The processes are spawned, because a forked child hangs in its first OpenCL call if the parent has made one, and managed
here, because the standard library's pools give up all work if one process is killed.
"""

from __future__ import annotations

import contextlib
import dataclasses
import logging
import multiprocessing
import os
from collections import deque
from collections.abc import Generator, Iterable, Iterator
from multiprocessing.connection import wait

from livecl.batch.worker import Made, Request, serve
from livecl.errors import LiveclError

#: Attempts per picture when workers crash.
MAX_ATTEMPTS = 3
#: Seconds to wait for a worker to end.
END_SECONDS = 5.0

_log = logging.getLogger(__name__)


@dataclasses.dataclass(frozen=True)
class Task:
    """A task: number, bytes and name of a picture, and the attempts so far."""

    number: int
    data: bytes
    name: str
    attempts: int = 0


class _Worker:
    """A worker process, the connection to it, and its task."""

    def __init__(self, request: Request, threads: int) -> None:
        context = multiprocessing.get_context("spawn")
        self.connection, theirs = context.Pipe()
        self.process = context.Process(target=serve, args=(theirs, request, threads), daemon=True)
        self.process.start()
        theirs.close()  # so that the connection closes when the process ends
        self.task: Task | None = None
        self.ready = False

    def give(self, task: Task) -> None:
        self.task = task
        if self.ready:
            with contextlib.suppress(OSError):  # it has died, which the next receive reports
                self.connection.send((task.data, task.name))

    def end(self) -> int | None:
        """End the process if it is running, and return its exit code."""
        self.connection.close()
        self.process.terminate()
        self.process.join(END_SECONDS)
        if self.process.is_alive():
            self.process.kill()
            self.process.join()
        return self.process.exitcode


def work_locally(
    tasks: Iterable[Task], request: Request, *, workers: int | None = None, threads: int = 1
) -> Generator[tuple[int, Made | str], None, None]:
    """Vectorize pictures in processes on this machine.

    A picture whose worker dies (killed, out of memory, a crash in the driver) is tried by another, up to three times.

    Parameters
    ----------
    tasks : iterable of Task
        The pictures; read one by one when a worker is free.
    request : Request
        Settings for each picture.
    workers : int, optional
        Number of processes (default: one per core available to this process).
    threads : int
        Cores that PoCL may use in each.

    Yields
    ------
    (int, Made or str)
        The number of a picture and its SVG, or the reason of its failure; in the order of completion.

    Raises
    ------
    LiveclError
        If worker processes do not start.
    """
    pool = _Pool(request, workers or available_cores(), threads)
    try:
        yield from pool.run(iter(tasks))
    finally:
        pool.end()


def available_cores() -> int:
    """Return the number of processor cores available to this process."""
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1


class _Pool:
    """Pool of workers, and the tasks of crashed ones."""

    def __init__(self, request: Request, size: int, threads: int) -> None:
        self._request, self._size, self._threads = request, size, threads
        self._workers: list[_Worker] = []
        self._left: deque[Task] = deque()
        self._failed_starts = 0

    def run(self, tasks: Iterator[Task]) -> Iterator[tuple[int, Made | str]]:
        while True:
            self._feed(tasks)
            busy = [(worker, worker.task) for worker in self._workers if worker.task is not None]
            if not busy:
                return
            heard = wait([worker.connection for worker, _ in busy])
            for worker, task in busy:
                if worker.connection not in heard:
                    continue
                try:
                    answer = worker.connection.recv()
                except (EOFError, OSError):
                    reason = self._bury(worker, task)
                    if reason is not None:
                        yield task.number, reason
                    continue
                if answer is None:
                    worker.ready, self._failed_starts = True, 0
                    worker.give(task)
                else:
                    worker.task = None
                    yield task.number, answer

    def _feed(self, tasks: Iterator[Task]) -> None:
        """Give a task to each idle worker, and to new workers up to the wanted number."""
        idle = [worker for worker in self._workers if worker.task is None]
        while idle or len(self._workers) < self._size:
            task = self._left.popleft() if self._left else next(tasks, None)
            if task is None:
                return
            if not idle:
                idle.append(_Worker(self._request, self._threads))
                self._workers.append(idle[0])
            idle.pop().give(task)

    def _bury(self, worker: _Worker, task: Task) -> str | None:
        """Remove a crashed worker; return the reason to give up its picture, or None if it is tried again."""
        self._workers.remove(worker)
        worker.process.join(END_SECONDS)  # to get its exit code
        code = worker.end()
        if not worker.ready:
            self._failed_starts += 1
            if self._failed_starts >= MAX_ATTEMPTS:
                raise LiveclError(
                    f"worker processes do not start (exit code {code}); a script that starts some must do so under "
                    "'if __name__ == \"__main__\":'"
                )
            self._left.appendleft(task)
            return None
        attempts = task.attempts + 1
        if attempts >= MAX_ATTEMPTS:
            return f"the worker process died {attempts} times (exit code {code})"
        _log.warning("%s: the worker process died (exit code %s); the picture is tried again", task.name, code)
        self._left.append(dataclasses.replace(task, attempts=attempts))
        return None

    def end(self) -> None:
        """End all processes."""
        for worker in self._workers:
            worker.process.terminate()
        for worker in self._workers:
            worker.end()
