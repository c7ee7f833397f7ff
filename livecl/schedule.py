# SPDX-License-Identifier: Apache-2.0
"""Schedules: number of paths added in each stage."""

from __future__ import annotations

import reprlib
from collections.abc import Sequence

#: Largest number of paths added in a stage of the growing schedule (the paper's implementation details).
MAX_PER_STAGE = 32
#: Default number of paths if they are not chosen by their gain, as in the paper.
DEFAULT_PATHS = 8
#: Largest number of paths if they are chosen by their gain: by default, and with "auto".
MAX_DEFAULT_PATHS, MAX_AUTO_PATHS = 32, 256
#: Largest number of paths in a request: the reader of drawings accepts no more elements.
MAX_PATHS = 100_000


def growing_schedule(paths: int) -> tuple[int, ...]:
    """Return the paper's schedule: stage i adds min(2^(i-1), 32) paths, the last is cut to reach `paths`.

    >>> growing_schedule(8)
    (1, 2, 4, 1)
    """
    stages: list[int] = []
    size, left = 1, paths
    while left:
        stages.append(min(size, left))
        left -= stages[-1]
        size = min(2 * size, MAX_PER_STAGE)
    return tuple(stages)


def parse_schedule(schedule: str | Sequence[int] | None, paths: int | str | None = None) -> tuple[int, ...]:
    """Return the number of paths added by each stage.

    Parameters
    ----------
    schedule : str, sequence of int, or None
        ``"exp"`` or None for the growing schedule, else the paths of each stage, as numbers or as text "1,1,2".
    paths : int, "auto" or None
        Total number of paths; the growing schedule has 8 by default, with "auto" at most 256. A list has its own total.

    Raises
    ------
    ValueError
        If the schedule cannot be read, holds other than positive whole numbers, or does not add up to `paths`.

    >>> parse_schedule("1,1,2")
    (1, 1, 2)
    """
    if paths == "auto":
        if not (schedule is None or (isinstance(schedule, str) and schedule == "exp")):
            raise ValueError("schedule: a list fixes the number of paths, so paths cannot be 'auto'")
        return growing_schedule(MAX_AUTO_PATHS)
    if paths is not None and (isinstance(paths, bool) or not isinstance(paths, int) or not 1 <= paths <= MAX_PATHS):
        raise ValueError(f"paths: got {reprlib.repr(paths)}, wanted a whole number from 1 to {MAX_PATHS}, or 'auto'")
    if schedule is None or (isinstance(schedule, str) and schedule == "exp"):
        return growing_schedule(DEFAULT_PATHS if paths is None else paths)
    parts = schedule.split(",") if isinstance(schedule, str) else schedule
    try:
        stages = tuple(int(part) for part in parts)
        if any(int(part) != float(part) for part in parts):
            raise ValueError
    except (TypeError, ValueError, OverflowError):
        stages = ()
    if not stages or min(stages) < 1:
        raise ValueError(
            f"schedule: got {reprlib.repr(schedule)}, wanted 'exp' or positive whole numbers such as 1,1,2,4"
        )
    if sum(stages) > MAX_PATHS:
        raise ValueError(f"schedule: {reprlib.repr(schedule)} adds more than {MAX_PATHS} paths")
    if paths is not None and sum(stages) != paths:
        listed = reprlib.repr(",".join(map(str, stages))).strip("'")
        raise ValueError(f"schedule: {listed} adds {sum(stages)} paths, but paths is {paths}")
    return stages
