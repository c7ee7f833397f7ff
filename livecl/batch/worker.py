# SPDX-License-Identifier: Apache-2.0
"""Work of a worker process: bytes of a picture in, text of an SVG out."""

from __future__ import annotations

import dataclasses
import io
import os
import signal
import threading
import warnings
from multiprocessing.connection import Connection

from livecl.run.control import Control
from livecl.run.recipe import Recipe
from livecl.version import __version__

#: Environment variable with PoCL's number of threads, read once, when OpenCL is first used.
THREADS_VARIABLE = "POCL_MAX_PTHREAD_COUNT"
#: A process works on one picture at a time, even if a cluster gives it several threads.
_one_at_a_time = threading.Lock()


@dataclasses.dataclass(frozen=True)
class Request:
    """Settings for each picture; sent to workers once, or with each picture."""

    recipe: Recipe  # how to vectorize
    device: int | str | None = None  # OpenCL device of the worker's machine
    time_limit: float | None = None  # seconds for each picture
    version: str = __version__  # livecl's version here; the worker's must be the same


@dataclasses.dataclass(frozen=True)
class Made:
    """A picture's SVG and figures of its run; sizes are (height, width), px; warnings, and the reason if stopped."""

    svg: str
    paths: int
    mse: float
    seconds: float
    size: tuple[int, int]
    working_size: tuple[int, int]
    warnings: tuple[str, ...]
    stopped: str | None = None


def make(data: bytes, name: str, request: Request) -> Made | str:
    """Vectorize one picture: the bytes of its file, and its name in messages.

    Returns
    -------
    Made or str
        The SVG, or one line with the reason of the failure: no picture may end a batch.
    """
    from livecl.image.reading import read_image

    if request.version != __version__:
        return f"the worker has livecl {__version__}, wanted {request.version}, as where the batch was started"
    control = Control(time_limit=request.time_limit)
    stream = io.BytesIO(data)
    stream.name = name
    try:
        with _one_at_a_time, warnings.catch_warnings(record=True) as caught:
            result = request.recipe.vectorize(read_image(stream), request.device, None, control)
    except Exception as error:
        return " ".join((str(error) or type(error).__name__).split())
    return Made(
        svg=request.recipe.svg(result.drawing),
        paths=result.drawing.num_layers,
        mse=result.mse,
        seconds=result.seconds,
        size=result.drawing.size,
        working_size=result.working_size or result.drawing.size,
        warnings=tuple(str(warning.message) for warning in caught),
        stopped=result.stopped,
    )


def serve(connection: Connection, request: Request, threads: int) -> None:
    """Vectorize the pictures received from a connection until it is closed; the main function of a worker process.

    Sends None when ready, then :func:`make` of each (data, name). A keyboard interrupt, which reaches all processes of
    a terminal, is left to the parent process.
    """
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    os.environ[THREADS_VARIABLE] = str(threads)
    try:
        connection.send(None)
        while True:
            data, name = connection.recv()
            connection.send(make(data, name, request))
    except (EOFError, OSError):  # the connection is closed
        return
