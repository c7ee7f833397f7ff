# SPDX-License-Identifier: Apache-2.0
"""Checkpoints: save and resume a run; the resumed run gives the same result as an uninterrupted one."""

from __future__ import annotations

import dataclasses
import hashlib
import logging
import os
import time
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from livecl.errors import CheckpointError
from livecl.files import remove_leftovers
from livecl.run.progress import Progress
from livecl.run.record import Record
from livecl.run.result import Stage
from livecl.training.archive import UNREADABLE, drawing_arrays, drawing_from, read_archive, write_archive
from livecl.version import __version__

if TYPE_CHECKING:
    from livecl.opencl.device import DeviceInfo

#: Magic words of a checkpoint, and the version of its format.
KIND, FORMAT = "livecl checkpoint", 1
#: Least time between two writings: seconds, and as a multiple of the time that the last one took.
PERIOD, MIN_RATIO = 5.0, 100

_log = logging.getLogger(__name__)


def identity_of(progress: Progress, target: NDArray[Any], seed: int, device: DeviceInfo) -> dict[str, Any]:
    """Return all inputs that determine the numbers of a run, as JSON can hold them."""
    start, state = progress.start_drawing, progress.state
    return {
        "version": __version__,
        "device": f"{device.name} ({device.platform}, {device.version})",
        "pixels": f"{target.shape[1]}x{target.shape[0]} px, {target.shape[2]} channels",
        "picture": _digest(target),
        "seed": seed,
        "schedule": list(progress.schedule),
        "start": None if start is None else _digest(*drawing_arrays("", start).values()),
        "lock": np.flatnonzero(state.locked).tolist(),
        **dataclasses.asdict(state.options),
    }


def load_checkpoint(path: str | os.PathLike[str], identity: dict[str, Any]) -> tuple[Progress, Record]:
    """Read a checkpoint of :class:`Checkpoints`, of a run of the same identity.

    Raises CheckpointError if the file is no checkpoint, or belongs to another run; the message names the difference.
    """
    name = os.fspath(path)
    try:
        facts, arrays = read_archive(path)
        if facts["kind"] != KIND or facts["format"] != FORMAT:
            raise ValueError(f"{facts['kind']}, format {facts['format']}, wanted {KIND}, format {FORMAT}")
        known = dict(facts["identity"])
        if known == identity:
            progress = Progress.of_parts(facts["state"], arrays)
            size = progress.state.drawing.size
            stages = [
                Stage(drawing_from(_prefix(number), arrays, size), **numbers)
                for number, numbers in enumerate(facts["stages"])
            ]
            return progress, Record(stages, facts["iterations"], facts["seconds"])
    except UNREADABLE as error:
        raise CheckpointError(f"{name}: is no checkpoint that can be read: {error}") from error
    raise CheckpointError(f"{name}: is a checkpoint of another run: {_differences(known, identity)}")


def is_checkpoint(path: str | os.PathLike[str]) -> bool:
    """Return whether a file is a checkpoint of any run and version, which may be overwritten."""
    try:
        facts, _ = read_archive(path)
    except UNREADABLE:
        return False
    return facts.get("kind") == KIND


class Checkpoints:
    """Writes the checkpoint of a run periodically; the first failure to write logs a warning, and the run goes on.

    Without a path it writes nothing. See :func:`identity_of` and :class:`livecl.run.control.Control`.
    """

    def __init__(self, path: str | os.PathLike[str] | None, identity: dict[str, Any], period: float | None) -> None:
        self._path, self._identity, self._period = path, identity, period
        self._next = time.monotonic() + (PERIOD if period is None else period)
        self._warned = False
        #: Whether the file exists and is of this run.
        self.written = False

    @property
    def due(self) -> bool:
        """Whether it is time to write."""
        return self._path is not None and time.monotonic() >= self._next

    def write(self, progress: Progress, record: Record) -> None:
        """Replace the file by the state of this progress."""
        if self._path is None:
            return
        begin = time.monotonic()
        facts, arrays = progress.parts()
        for number, stage in enumerate(record.stages):
            arrays |= drawing_arrays(_prefix(number), stage.drawing)
        whole = {
            "kind": KIND,
            "format": FORMAT,
            "identity": self._identity,
            "state": facts,
            "stages": [
                {"mse": stage.mse, "iterations": stage.iterations, "seconds": stage.seconds} for stage in record.stages
            ],
            "iterations": record.iterations,
            "seconds": record.seconds,
        }
        try:
            write_archive(self._path, whole, arrays)
            self.written = True
        except OSError as error:
            if not self._warned:
                reason = error.strerror or error
                _log.warning("%s: cannot be written (%s); the run goes on without", os.fspath(self._path), reason)
            self._warned = True
        now = time.monotonic()
        self._next = now + (max(PERIOD, MIN_RATIO * (now - begin)) if self._period is None else self._period)


def discard_checkpoint(path: str | os.PathLike[str]) -> None:
    """Delete a checkpoint, and temporary files of killed writes."""
    Path(path).unlink(missing_ok=True)
    remove_leftovers(path)


def _prefix(number: int) -> str:
    return f"stages.{number}."


def _differences(known: dict[str, Any], identity: dict[str, Any]) -> str:
    """Describe the difference of two identities."""
    names = [name for name in identity if known.get(name) != identity[name]]
    if "pixels" in names:  # then the picture differs as well
        names.remove("picture")
    return "; ".join(_difference(name, known.get(name), identity[name]) for name in names) or "it has other options"


def _difference(name: str, was: Any, wanted: Any) -> str:
    if name in ("picture", "start"):
        return f"another {'picture' if name == 'picture' else 'drawing to start from'}"
    return f"{name} was {was}, is {wanted}"


def _digest(*arrays: Any) -> str:
    digest = hashlib.sha256()
    for array in arrays:
        values = np.ascontiguousarray(array)
        digest.update(f"{values.dtype.str} {values.shape} ".encode() + values.tobytes())
    return digest.hexdigest()
