# SPDX-License-Identifier: Apache-2.0
"""Schedules: the growing one of the paper, lists, and refusals."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from livecl.schedule import growing_schedule, parse_schedule


@pytest.mark.parametrize(
    ("paths", "stages"),
    [
        (1, (1,)),
        (2, (1, 1)),
        (3, (1, 2)),
        (8, (1, 2, 4, 1)),
        (32, (1, 2, 4, 8, 16, 1)),
        (64, (1, 2, 4, 8, 16, 32, 1)),
        (128, (1, 2, 4, 8, 16, 32, 32, 32, 1)),
    ],
)
def test_growing_schedule_doubles_up_to_32_and_is_cut(paths: int, stages: tuple[int, ...]) -> None:
    assert growing_schedule(paths) == stages
    assert parse_schedule("exp", paths) == parse_schedule(None, paths) == stages


def test_growing_schedule_of_any_number_follows_the_rule() -> None:
    for paths in [*range(1, 300), 5000]:
        stages = growing_schedule(paths)
        assert sum(stages) == paths
        assert list(stages[:-1]) == [min(2**i, 32) for i in range(len(stages) - 1)]
        assert 1 <= stages[-1] <= min(2 ** (len(stages) - 1), 32)


def test_a_long_schedule_is_not_slower_than_its_length() -> None:
    stages = growing_schedule(1_000_000)  # 31 250 stages: a power of 2 for each would have thousands of digits
    assert sum(stages) == 1_000_000 and max(stages) == 32


def test_eight_paths_where_nothing_is_said() -> None:
    assert parse_schedule(None) == parse_schedule("exp") == growing_schedule(8)


@pytest.mark.parametrize(
    "schedule", ["1,1,2", " 1 , 1,2 ", [1, 1, 2], (1, 1, 2), np.array([1, 1, 2]), [1.0, 1.0, 2.0], range(1, 3)]
)
def test_lists_in_every_form(schedule: Any) -> None:
    stages = parse_schedule(schedule)
    assert stages == ((1, 2) if isinstance(schedule, range) else (1, 1, 2))
    assert type(stages) is tuple and all(type(stage) is int for stage in stages)


def test_a_list_may_be_given_with_the_number_it_adds_up_to() -> None:
    assert parse_schedule("1,1,2", 4) == (1, 1, 2)
    with pytest.raises(ValueError, match="schedule: 1,1,2 adds 4 paths, but paths is 5"):
        parse_schedule("1,1,2", 5)


UNREADABLE = ["", ",", "1,,2", "1;2", "one", "1.5,2", "0", "1,0", "-1,2", "1,-1,2", "Exp", 3]
UNREADABLE += [[], [1.5], [0], [1, -1], [None], ["a"], [float("nan")], [float("inf")]]


@pytest.mark.parametrize("schedule", UNREADABLE)
def test_what_cannot_be_read_is_refused_by_name(schedule: Any) -> None:
    with pytest.raises(ValueError, match=r"^schedule: got .*wanted 'exp' or positive whole numbers") as caught:
        parse_schedule(schedule)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize("paths", [0, -1, 2.0, "8", True, float("nan")])
def test_number_of_paths_is_a_positive_whole_number(paths: Any) -> None:
    for schedule in (None, "exp", "1,1"):
        with pytest.raises(ValueError, match=r"^paths: got "):
            parse_schedule(schedule, paths)


@pytest.mark.parametrize(
    ("schedule", "paths"), [(None, 10**9), (None, 10**400), ("1,1000000000", None), ([10**6], None)]
)
def test_more_paths_than_can_be_had_are_refused_at_once(schedule: Any, paths: Any) -> None:
    with pytest.raises(ValueError, match=r"^(paths: got .* from 1 to 100000|schedule: .* more than 100000 paths)"):
        parse_schedule(schedule, paths)
