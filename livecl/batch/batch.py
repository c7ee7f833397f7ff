# SPDX-License-Identifier: Apache-2.0
"""Batches: vectorize many pictures into a folder of SVGs, on this machine or on a cluster."""

from __future__ import annotations

import contextlib
import dataclasses
import hashlib
import logging
import os
from collections.abc import Callable, Generator, Iterable, Iterator
from pathlib import Path
from typing import TYPE_CHECKING

from livecl.batch.inputs import Input, find_pictures
from livecl.batch.pool import Task, work_locally
from livecl.batch.summary import Outcome, Summary
from livecl.batch.worker import Made, Request
from livecl.drawing.checks import check_whole
from livecl.files import check_folder, write_atomically
from livecl.run.recipe import Recipe

if TYPE_CHECKING:
    from distributed import Client

_log = logging.getLogger(__name__)


@dataclasses.dataclass(frozen=True)
class Workers:
    """Workers of a batch: number, cores of each, and the address of a Dask scheduler, if any.

    Raises ValueError if a number is not usable; the message names it.
    """

    count: int | None = None
    threads: int = 1
    scheduler: str | None = None

    def __post_init__(self) -> None:
        for name, value in (("workers", self.count), ("threads", self.threads)):
            if value is not None:
                check_whole(name, value, 1)


class Batch:
    """A batch whose arguments have been checked; see :func:`vectorize_files`.

    Arguments as of that function; `request` has recipe, device and time limit.

    Attributes
    ----------
    pictures : list of Input
        The pictures, and the name of each one's SVG.
    recipe : Recipe
        Settings for each picture.
    """

    def __init__(
        self,
        inputs: Iterable[str | os.PathLike[str]] | str | os.PathLike[str],
        output_folder: str | os.PathLike[str],
        request: Request,
        workers: Workers | None = None,
        *,
        skip_done: bool = True,
    ) -> None:
        self.pictures = find_pictures([inputs] if isinstance(inputs, (str, os.PathLike)) else inputs)
        self._folder = Path(output_folder)
        _check_output_folder(self._folder)
        self._summary = Summary(self._folder)
        self.recipe = request.recipe
        self._fingerprint = self.recipe.fingerprint
        self._request, self._workers = request, Workers() if workers is None else workers
        # A picture that was stopped counts as done for the same time limit only.
        self._stopped_fingerprint = _digest(f"{self._fingerprint} {request.time_limit}".encode())
        self._skip_done = skip_done
        self._written: Outcome | None = None
        if self._workers.scheduler is None:
            from livecl.opencl.device import choose_device

            choose_device(request.device)
        else:
            from livecl.batch.cluster import check_scheduler

            check_scheduler(self._workers.scheduler)

    def run(self, on_outcome: Callable[[Outcome], None] | None = None) -> list[Outcome]:
        """Vectorize the pictures; see :func:`vectorize_files`."""
        outcomes: dict[int, Outcome] = {}
        digests: dict[int, str] = {}

        def note(number: int, outcome: Outcome) -> None:
            outcomes[number] = outcome
            self._summary.add(outcome)
            if on_outcome is not None:
                on_outcome(outcome)

        def tasks() -> Iterator[Task]:
            """Read the pictures one by one on demand; those that need no worker are settled at once."""
            for number, picture in enumerate(self.pictures):
                try:
                    data = picture.file.read_bytes()
                except OSError as error:
                    note(number, _failed(picture, f"cannot be read ({error.strerror or error})"))
                    continue
                digests[number] = _digest(data)
                if self._skip_done and (done := self._done(picture, digests[number])):
                    note(number, done)
                else:
                    yield Task(number, data, _shown(picture.file))

        with contextlib.ExitStack() as stack:
            client = self._connect(stack)
            self._folder.mkdir(exist_ok=True)
            stack.callback(self._close)
            answers = stack.enter_context(contextlib.closing(self._answers(tasks(), client)))
            for number, answer in answers:
                note(number, self._settled(self.pictures[number], digests[number], answer))
        return [outcomes[number] for number in sorted(outcomes)]

    def _close(self) -> None:
        """Write the summary, with the row of a picture between whose SVG and row an interruption came."""
        if self._written is not None and self._has(self._written):
            self._summary.add(self._written)
        self._summary.write()

    def _has(self, row: Outcome) -> bool:
        """Whether the SVG of a row is in the folder as the row says."""
        try:
            return _digest((self._folder / row.output).read_bytes()) == row.svg
        except OSError:
            return False

    def _connect(self, stack: contextlib.ExitStack) -> Client | None:
        workers = self._workers
        if workers.scheduler is None:
            return None
        from livecl.batch.cluster import cluster_client

        return stack.enter_context(cluster_client(workers.scheduler, workers=workers.count, threads=workers.threads))

    def _answers(self, tasks: Iterator[Task], client: Client | None) -> Generator[tuple[int, Made | str], None, None]:
        if client is None:
            return work_locally(tasks, self._request, workers=self._workers.count, threads=self._workers.threads)
        from livecl.batch.cluster import work_on_cluster

        return work_on_cluster(tasks, self._request, client)

    def _done(self, picture: Input, digest: str) -> Outcome | None:
        """Return the outcome of a picture that is already done: its SVG exists, as it would be made now."""
        row = self._summary.get(picture.output)
        if row is None or row.picture != digest or row.recipe not in (self._fingerprint, self._stopped_fingerprint):
            return None
        return dataclasses.replace(row, file=_shown(picture.file), status="skipped") if self._has(row) else None

    def _settled(self, picture: Input, digest: str, answer: Made | str) -> Outcome:
        """Write the SVG, and return the picture's outcome."""
        if isinstance(answer, str):
            return _failed(picture, answer)
        for warning in answer.warnings:
            _log.warning("%s", warning)
        (height, width), (working_height, working_width) = answer.size, answer.working_size
        self._written = Outcome(
            file=_shown(picture.file),
            output=picture.output,
            status="done",
            paths=answer.paths,
            mse=answer.mse,
            seconds=answer.seconds,
            width=width,
            height=height,
            working_width=working_width,
            working_height=working_height,
            picture=digest,
            message=answer.stopped or "",
            recipe=self._fingerprint if answer.stopped is None else self._stopped_fingerprint,
            svg=_digest(answer.svg.encode()),
        )
        target = self._folder / picture.output
        try:
            target.parent.mkdir(parents=True, exist_ok=True)
            write_atomically(target, answer.svg)
        except OSError as error:
            return _failed(picture, f"{target}: cannot be written ({error.strerror or error})")
        return self._written


def vectorize_files(
    inputs: Iterable[str | os.PathLike[str]] | str | os.PathLike[str],
    output_folder: str | os.PathLike[str],
    *,
    recipe: Recipe | None = None,
    device: int | str | None = None,
    workers: int | None = None,
    threads: int = 1,
    scheduler: str | None = None,
    skip_done: bool = True,
    time_limit: float | None = None,
    on_outcome: Callable[[Outcome], None] | None = None,
) -> list[Outcome]:
    """Vectorize pictures into a folder of SVGs, several at a time.

    Each SVG is the same, to the last byte, as that of a run of its picture alone. It is written as soon as its picture
    is done, and ``summary.csv`` has a row for each picture. A picture that fails does not stop the others; nor does a
    crashed worker: its picture is tried up to three times. A script must call this under
    ``if __name__ == "__main__":``, as it starts processes.

    Parameters
    ----------
    inputs : path, or iterable of paths
        Pictures, folders of pictures, patterns such as ``photos/*.png``; see
        :func:`livecl.batch.inputs.find_pictures` for how the SVGs are named.
    output_folder : path
        Folder for the SVGs; created if its parent exists.
    recipe : Recipe, optional
        Paths, options and size for each picture.
    device : int, str or None
        OpenCL device, of each worker's machine.
    workers : int, optional
        Number of worker processes (default: one per core).
    threads : int
        Cores that PoCL may use in each worker.
    scheduler : str, optional
        Address of a Dask scheduler whose workers do the work (workers and threads are then the cluster's), or "local"
        for a temporary Dask cluster on this machine. Needs the extra ``cluster``.
    skip_done : bool
        Skip pictures whose SVG exists as written by a batch, from the same bytes, with the same recipe and the same
        version of livecl.
    time_limit : float, optional
        Seconds after which the run of a picture ends with its best drawing so far.
    on_outcome : callable, optional
        Called with the outcome of each picture.

    Returns
    -------
    list of Outcome
        The outcome of each picture, in the order of the inputs.

    Raises
    ------
    ValueError
        If an argument is not usable, an input is missing, or no scheduler answers, before any work.
    DeviceError
        If the device is not available on this machine, before any work.
    LiveclError
        If worker processes do not start, or the scheduler is lost.
    """
    request = Request(Recipe() if recipe is None else recipe, device, time_limit)
    return Batch(inputs, output_folder, request, Workers(workers, threads, scheduler), skip_done=skip_done).run(
        on_outcome
    )


def _check_output_folder(folder: Path) -> None:
    if folder.is_dir():
        check_folder(folder, folder)
    elif folder.exists():
        raise ValueError(f"{folder}: is a file, wanted a folder for the SVGs")
    else:
        check_folder(folder.parent, folder)


def _failed(picture: Input, message: str) -> Outcome:
    return Outcome(file=_shown(picture.file), output=picture.output, status="failed", message=message)


def _digest(data: bytes) -> str:
    return hashlib.sha256(data).hexdigest()


def _shown(path: Path) -> str:
    """Return a file's name as printable text, whatever its bytes."""
    return os.fsencode(path).decode("utf-8", "replace")
