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
from livecl.drawing.assembly import empty_drawing
from livecl.run.beginning import PALE, Beginning, priced_for


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


def test_prices_follow_what_a_pale_picture_shows(device: int) -> None:
    white, pale = np.ones(3), (250 / 255,) * 3
    image = livecl.render(build([([rectangle(6, 8, 30, 40)], (*pale, 1))], (48, 48), white), device)
    drawing = empty_drawing((48, 48), white)
    given = Options(path_gain=1e-5)
    priced = priced_for(given, image, drawing)
    assert priced.prune / given.prune == pytest.approx(np.mean(np.square(image - 1)) / PALE, rel=1e-5)
    assert priced.path_gain / given.path_gain == pytest.approx(priced.prune / given.prune)
    assert priced_for(given, flat(device), drawing) == given
    assert priced_for(given, np.ones((48, 48, 3), np.float32), drawing) == given
    noise = np.random.default_rng(0).normal(0.9, 0.01, (48, 48, 3)).astype(np.float32)
    assert priced_for(given, noise, empty_drawing((48, 48), np.full(3, 0.9))) == given, "noise is not drawn"
