# SPDX-License-Identifier: Apache-2.0
"""Dask clusters: send pictures to the workers as bytes, receive SVGs as text.

Dask reassigns the pictures of a lost worker, and gives up a picture after several workers have died with it. Its
package is the extra ``cluster``.
"""

from __future__ import annotations

import contextlib
import logging
from collections.abc import Generator, Iterable, Iterator
from typing import TYPE_CHECKING, Any

from livecl.batch.pool import MAX_ATTEMPTS, Task, available_cores
from livecl.batch.worker import THREADS_VARIABLE, Made, Request, make
from livecl.errors import LiveclError

if TYPE_CHECKING:
    from distributed import Client

_log = logging.getLogger(__name__)

#: Address of a temporary cluster on this machine.
LOCAL = "local"
#: Seconds in which a scheduler must answer.
CONNECT_SECONDS = 10
#: States of a finished picture whose worker died before its SVG was fetched: Dask repeats it.
TAKEN_BACK = ("lost", "pending")
#: Pictures sent per thread of the cluster, so that no thread waits for its next one.
AHEAD = 2


def check_scheduler(scheduler: str) -> None:
    """Raise the errors of :func:`cluster_client` without starting anything."""
    if scheduler == LOCAL:
        _package()
    else:
        with cluster_client(scheduler):
            pass


@contextlib.contextmanager
def cluster_client(scheduler: str, *, workers: int | None = None, threads: int = 1) -> Iterator[Client]:
    """Context manager: connect to a Dask scheduler.

    Parameters
    ----------
    scheduler : str
        Address, such as ``tcp://192.168.0.10:8786``; or "local" for worker processes on this machine that end with the
        batch.
    workers : int, optional
        Processes of the "local" cluster (default: one per core).
    threads : int
        Cores that PoCL may use in each process of the "local" cluster.

    Raises
    ------
    ValueError
        If no scheduler answers at the address, or Dask's package is not installed.
    """
    distributed = _package()
    import dask

    limits = {
        "distributed.scheduler.allowed-failures": MAX_ATTEMPTS - 1,  # for a scheduler started here
        "distributed.admin.large-graph-warning-threshold": "1 GiB",  # large pictures are sent on purpose
    }
    with contextlib.ExitStack() as stack:
        stack.enter_context(dask.config.set(limits))
        if scheduler == LOCAL:
            cluster = distributed.LocalCluster(
                n_workers=workers or available_cores(),
                threads_per_worker=1,
                processes=True,
                env={THREADS_VARIABLE: str(threads)},
                dashboard_address="127.0.0.1:0",
                silence_logs=logging.ERROR,
            )
            scheduler = stack.enter_context(cluster).scheduler_address
        try:
            client = distributed.Client(scheduler, timeout=CONNECT_SECONDS, set_as_default=False)
        except (OSError, ValueError, TimeoutError) as error:
            raise ValueError(f"scheduler: no Dask scheduler answers at {scheduler!r}: {error}") from error
        yield stack.enter_context(client)


def _package() -> Any:
    """Return Dask's package for clusters."""
    try:
        import distributed
    except ImportError as error:
        raise ValueError(f"scheduler: Dask is needed ({error}); pip install 'livecl[cluster]'") from error
    return distributed


def work_on_cluster(
    tasks: Iterable[Task], request: Request, client: Client
) -> Generator[tuple[int, Made | str], None, None]:
    """Work on pictures with the workers of a cluster; see :func:`livecl.batch.pool.work_locally`.

    Dask cannot tell which of a dead worker's pictures crashed it, and may give up all of them. Those are tried once
    more at the end, one at a time. Raises LiveclError if the scheduler is lost.
    """
    if not client.nthreads():
        _log.warning("the scheduler has no workers yet; waiting for some")
    suspects: list[Task] = []
    for task, answer in _answers(iter(tasks), request, client):
        if answer is None:
            suspects.append(task)
        else:
            yield task.number, answer
    for suspect in suspects:
        _log.warning("%s: worker processes died that had it; it is tried again, alone", suspect.name)
        for task, answer in _answers(iter([suspect]), request, client):
            yield task.number, "the worker processes that had it died" if answer is None else answer


def _answers(tasks: Iterator[Task], request: Request, client: Client) -> Iterator[tuple[Task, Made | str | None]]:
    """Yield the outcome of each task, in order of completion; None if its workers died."""
    from distributed import KilledWorker, as_completed

    sent: dict[Any, Task] = {}
    finished = as_completed(loop=client.loop)

    def send() -> None:
        """Send pictures so that each thread, also of new workers, has one and a further one waiting."""
        threads = sum(client.nthreads().values())
        while len(sent) < AHEAD * max(1, threads) and (task := next(tasks, None)) is not None:
            future = client.submit(make, task.data, task.name, request, pure=False)
            sent[future] = task
            finished.add(future)

    send()
    for future in finished:
        if future.status in TAKEN_BACK:
            finished.add(future)
            continue
        task = sent.pop(future)
        answer: Made | str | None = None
        if future.status == "finished":
            with contextlib.suppress(KilledWorker):  # its worker died with the result, and those that repeated it
                answer = future.result()
        elif future.status != "error":
            raise LiveclError("scheduler: the connection to the Dask scheduler was lost")
        elif not isinstance(error := future.exception(), KilledWorker):
            answer = f"the worker failed: {' '.join(str(error).split())}"
        future.release()
        send()
        yield task, answer
