# SPDX-License-Identifier: Apache-2.0
"""The beginning of a run: which placement suits the picture, and what then is as it is found."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from support.shapes import build, circle, rectangle

import livecl
from livecl import Options
from livecl.run.beginning import Beginning


def flat(device: int) -> NDArray[np.float32]:
    """Return a picture of two flat shapes, 48 x 48."""
    shapes = [([rectangle(6, 8, 30, 40)], (0.8, 0.1, 0.1, 1)), ([circle((32, 20), 9)], (0.1, 0.3, 0.8, 1))]
    return livecl.render(build(shapes, (48, 48)), device)


def options_of(image: NDArray[np.float32], **given: Any) -> Options:
    return Beginning(paths=4, options=Options(revisions=3, **given)).progress(image).state.options


def test_flat_pictures_stay_as_they_are_found(device: int) -> None:
    options = options_of(flat(device))
    assert options.placement == "structure"
    assert options.revisions == 0 and not options.merge, "which would trade whole shapes for a lower error"
    assert options.color_learning_rate < Options().color_learning_rate / 10 and options.opacity == "opaque"
    assert options_of(flat(device), opacity="train").opacity == "train"


@pytest.mark.parametrize("given", [{"shape": "circle"}, {"new_color": "random"}, {"background": "train"}])
def test_structure_has_outlines_and_colors_of_its_own(given: dict[str, str], device: int) -> None:
    options = options_of(flat(device), **given)
    assert options == Options(revisions=3, placement="region", **given)  # type: ignore[arg-type]


def test_pictures_that_are_not_flat_and_drawings_to_start_from_get_regions(device: int) -> None:
    noise = np.random.default_rng(0).uniform(size=(48, 48, 3)).astype(np.float32)
    assert options_of(noise) == Options(revisions=3, placement="region")
    start = build([([rectangle(6, 8, 30, 40)], (0.8, 0.1, 0.1, 1))], (48, 48))
    begun = Beginning(options=Options(revisions=3), start=start).progress(flat(device))
    assert begun.state.options == Options(revisions=3, placement="region") and begun.schedule == (0,)


@pytest.mark.parametrize("placement", ["region", "component"])
def test_a_placement_that_is_asked_for_is_taken(placement: str, device: int) -> None:
    given = Options(revisions=3, placement=placement)  # type: ignore[arg-type]
    assert Beginning(paths=4, options=given).progress(flat(device)).state.options == given


def test_the_schedule_follows_what_was_asked_for(device: int) -> None:
    image, start = flat(device), build([([rectangle(6, 8, 30, 40)], (0.8, 0.1, 0.1, 1))], (48, 48))
    given = Options(placement="region")
    assert Beginning(paths=3, options=given).progress(image).schedule == (1, 2)
    assert Beginning(schedule=[2, 5], options=given).progress(image).schedule == (2, 5)
    assert Beginning(paths=3, options=given, start=start).progress(image).schedule == (0, 1, 2)
    assert sum(Beginning(options=given.choosing_paths()).progress(image).schedule) == 32
    assert sum(Beginning(paths="auto", options=given).progress(image).schedule) == 256
