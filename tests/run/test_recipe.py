# SPDX-License-Identifier: Apache-2.0
"""`Recipe`: what it makes of pictures, in their own coordinates, and what it refuses."""

from __future__ import annotations

import dataclasses
import itertools
import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from support import drawings

import livecl
from livecl.drawing.assembly import scaled
from livecl.drawing.drawing import Drawing
from livecl.image.resizing import reduced
from livecl.options import Options
from livecl.run.recipe import Recipe
from livecl.svg import quantize, read_svg

ROOT = Path(__file__).resolve().parents[2]
QUICK = Options(iterations=4, revisions=0)


def square(side: int, channels: int = 3) -> NDArray[np.float32]:
    """Return a red square on white, or on nothing."""
    image = np.ones((side, side, channels), np.float32)
    if channels == 4:
        image[..., 3] = 0
    image[side // 4 : 3 * side // 4, side // 4 : 3 * side // 4] = (0.8, 0.1, 0.1, 1.0)[:channels]
    return image


def start(size: tuple[int, int]) -> Drawing:
    """Return two squares, drawn with numbers that no rounding leaves as they are."""
    side = min(size)
    third = [side / 3 + 1e-4, side / 3 + 1e-4, side * 0.7, side * 0.7]
    layers = [
        ([drawings.rectangle(side / 7, side / 7, side / 1.3, side / 1.3)], (0.2, 0.4, 0.6, 1.0)),
        ([drawings.rectangle(*third)], (0.8, 0.2, 0.2, 1.0)),
    ]
    return quantize(drawings.build(layers, size))


def test_is_vectorize_where_nothing_is_scaled() -> None:
    image = square(32)
    result = Recipe(paths=2, options=QUICK, seed=3).vectorize(image)
    expected = livecl.vectorize(image, paths=2, options=QUICK, seed=3)
    assert result.svg == expected.svg
    assert (result.mse, result.working_size) == (expected.mse, (32, 32))


@pytest.mark.parametrize("channels", [3, 4])
def test_large_pictures_are_worked_on_small_and_drawn_large(channels: int) -> None:
    image = square(64, channels)
    result = Recipe(paths=2, options=QUICK, size=16).vectorize(image)
    small = livecl.vectorize(reduced(image, (16, 16)), paths=2, options=QUICK)
    assert result.working_size == (16, 16) and result.mse == small.mse
    assert [stage.drawing.size for stage in result.stages] == [(64, 64)] * len(small.stages)
    assert (result.drawing.background is None) == (channels == 4)
    np.testing.assert_allclose(result.drawing.points, 4 * small.drawing.points, atol=0.5e-3)
    assert Recipe(paths=2, options=QUICK, size=0).vectorize(image).working_size == (64, 64)


@pytest.mark.parametrize("precision", [0, 1, 3, 5])
def test_the_error_is_that_of_what_is_saved(precision: int) -> None:
    image = square(40)
    recipe = Recipe(paths=1, options=QUICK, precision=precision)
    result = recipe.vectorize(image)
    difference = livecl.render(result.drawing) - image
    assert result.mse == pytest.approx(np.mean(np.square(difference, dtype=np.float64)), rel=1e-5)
    saved = read_svg(recipe.svg(result.drawing).encode())
    np.testing.assert_allclose(saved.points, result.drawing.points, rtol=0, atol=1e-9)
    np.testing.assert_array_equal(saved.points[:, 0], np.round(saved.points[:, 0], precision))


def test_refines_a_start_on_the_picture_s_canvas() -> None:
    image = square(48)
    result = Recipe(options=QUICK, start=start((24, 24)), size=16).vectorize(image)
    assert result.drawing.size == (48, 48)
    assert result.working_size == (16, 16)
    before = livecl.render(scaled(start((24, 24)), (16, 16))) - reduced(image, (16, 16))
    assert result.mse <= np.mean(np.square(before, dtype=np.float64))


@pytest.mark.parametrize("size", [0, 16])
def test_locked_layers_stay_exactly(size: int) -> None:
    drawing = start((48, 48))
    recipe = Recipe(paths=1, options=QUICK, start=drawing, lock=(1,), size=size)
    result = recipe.vectorize(square(48))
    for stage in result.stages:
        offsets = stage.drawing.segment_offsets
        layers = [stage.drawing.points[first:end] for first, end in itertools.pairwise(offsets)]
        assert any(np.array_equal(layer, drawing.points[4:]) for layer in layers)
        assert not any(np.array_equal(layer, drawing.points[:4]) for layer in layers)
    assert recipe.stages == (0, 1)


def test_a_start_of_other_proportions_is_refused() -> None:
    with pytest.raises(ValueError, match=r"^start: a canvas of 24x24 px, wanted the proportions of the picture, 60x48"):
        Recipe(options=QUICK, start=start((24, 24))).vectorize(np.ones((48, 60, 3)))


@pytest.mark.parametrize(
    ("values", "message"),
    [
        ({"paths": 0}, "paths: got 0"),
        ({"schedule": "1,x"}, "schedule: got"),
        ({"schedule": (1, 1), "paths": 3}, "schedule: 1,1 adds 2"),
        ({"seed": -1}, "seed: got -1"),
        ({"seed": True}, "seed: got True"),
        ({"size": -1}, "size: got -1"),
        ({"size": 1}, "size: got 1, wanted a whole number of pixels, at least 16, or 0"),
        ({"precision": 10}, "precision: got 10"),
        ({"layers": "groups"}, "layers: got 'groups', wanted 'inkscape' or 'plain'"),
        ({"lock": (0,)}, "lock: names layers of a drawing"),
        ({"lock": 3}, "lock: got 3, wanted numbers"),
        ({"start": start((24, 24)), "lock": (2,)}, "lock: got"),
        ({"start": start((24, 24)), "options": Options.released()}, "start: variant 'released'"),
    ],
)
def test_refusals(values: dict[str, Any], message: str) -> None:
    with pytest.raises(ValueError, match=f"^{message}"):
        Recipe(**values)


def test_fingerprints_differ_where_the_outcome_may() -> None:
    drawing = start((24, 24))
    recipes = [
        Recipe(),
        Recipe(paths=9),
        Recipe(paths="auto"),
        Recipe(schedule="1,7"),
        Recipe(seed=1),
        Recipe(size=100),
        Recipe(precision=2),
        Recipe(layers="plain"),
        Recipe(options=Options(tau=9.0)),
        Recipe(start=drawing),
        Recipe(start=drawing.replace(points=drawing.points + 1e-3)),
        Recipe(start=drawing, lock=(0,)),
    ]
    assert len({recipe.fingerprint for recipe in recipes}) == len(recipes)
    paper = Options.paper()
    assert Recipe(options=paper).fingerprint == Recipe(options=paper, paths=8, schedule="exp").fingerprint
    assert Recipe().fingerprint != Recipe(schedule=Recipe().stages).fingerprint  # which does not end early
    assert Recipe().fingerprint == dataclasses.replace(Recipe()).fingerprint


def test_circles_and_boxes_of_larger_pictures_are_such() -> None:
    """Though a picture of 121 x 90 px is worked on at 74 x 55, which are not quite its proportions."""
    rows, columns = np.indices((90, 121)) + 0.5
    image = np.ones((90, 121, 3))
    image[np.hypot(columns - 35, rows - 45) < 24] = (0.8, 0.2, 0.1)
    image[20:70, 75:110] = (0.1, 0.3, 0.8)
    recipe = Recipe(paths=2, size=64, options=Options(iterations=60, revisions=0))
    svg = recipe.svg(recipe.vectorize(image).drawing)
    assert svg.count("<circle") == 1 and svg.count("<rect") == 2 and "<path" not in svg


@pytest.mark.parametrize("radius", [24, 31])
def test_discs_whose_edges_were_never_smooth_are_circles(radius: float) -> None:
    """Their edges are steps of whole pixels, which more numbers could follow a little better."""
    rows, columns = np.indices((90, 121)) + 0.5
    image = np.ones((90, 121, 3))
    image[np.hypot(columns - 42.3, rows - 45) < radius] = (0.8, 0.2, 0.1)
    recipe = Recipe(paths=1, options=Options(iterations=60, revisions=0))
    assert recipe.svg(recipe.vectorize(image).drawing).count("<circle") == 1


def test_ids_are_those_of_a_nearly_equal_picture() -> None:
    """Noise that nobody sees and a shift by a pixel change no ids; of equal things, either may be painted first."""
    image = livecl.read_image(ROOT / "examples" / "face.png")
    noise = np.random.default_rng(0).uniform(-1.5 / 255, 1.5 / 255, image.shape)
    pictures = [image, np.clip(image + noise, 0, 1), np.roll(image, (1, 1), axis=(0, 1))]
    options = livecl.Options(iterations=10)
    texts = [Recipe(options=options).vectorize(picture).svg for picture in pictures]
    ids = [sorted(re.findall(r' id="([^"]+)"', text)) for text in texts]
    assert ids[0] == ids[1] == ids[2]
    assert len(ids[0]) == 8 and "orange-circle-left" in ids[0]  # background, group, six layers
