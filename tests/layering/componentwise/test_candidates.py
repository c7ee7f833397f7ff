# SPDX-License-Identifier: Apache-2.0
"""Candidates for new paths: which regions are worth one, in which outline, and how long their trials are remembered."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from conftest import RasterizerFor
from numpy.typing import NDArray
from support import drawings
from support.placing import Placer

from livecl import Options
from livecl.arrays import Window
from livecl.geometry.outlines import circle
from livecl.layering.componentwise import candidates
from livecl.layering.componentwise.candidates import SEARCH, Candidate
from livecl.layering.componentwise.painting import Painting, Trial
from livecl.layering.context import Context
from livecl.layering.regions import Region
from livecl.layering.stack import LayerStack

FloatArray = NDArray[np.float64]

RED, GREEN, BLUE = (0.9, 0.1, 0.2), (0.1, 0.8, 0.3), (0.2, 0.3, 0.9)


@pytest.fixture
def place(rasterizer_for: RasterizerFor) -> Placer:
    return Placer(rasterizer_for)


@pytest.mark.parametrize(
    ("premultiplied", "fill"),
    [
        ((0.2, 0.4, 0.6), (0.2, 0.4, 0.6, 1)),
        ((0.1, 0.2, 0.4, 0.5), (0.2, 0.4, 0.8, 0.5)),
        ((0.22, 0.44, 0.66, 0.88), (0.25, 0.5, 0.75, 0.88)),
        ((0.23, 0.46, 0.69, 0.92), (0.25, 0.5, 0.75, 1)),
        ((0, 0, 0, 0), (0, 0, 0, 0.02)),
    ],
)
def test_the_fill_that_shows_a_color_over_nothing(premultiplied: tuple[float, ...], fill: tuple[float, ...]) -> None:
    np.testing.assert_allclose(candidates.paint_of(premultiplied), fill, atol=1e-12)


def test_clear_regions_are_not_looked_at(rasterizer_for: RasterizerFor) -> None:
    # Paint where the picture is clear cannot be taken away by more paint.
    target = np.zeros((24, 24, 4))
    target[2:8, 2:8] = 1
    alphas = np.zeros((1, 24, 24))
    alphas[0, 10:22, 10:22] = 0.5
    image = alphas[0][..., None] * np.array([0, 0, 1, 1.0])
    stack = LayerStack(np.zeros(4), alphas, np.array([[0, 0, 1, 1.0]]), image)
    context = Context(rasterizer_for((24, 24), np.float32), target, Options(placement="region", background="none"))
    judge = candidates._Judge(context, Painting(target, stack), np.random.default_rng(0))
    judge._error = judge._painting.error.astype(np.float64)
    colors = [region.color for region in judge._regions()]
    assert colors and min(color[3] for color in colors) > 0.02
    assert any(region.color[3] < 0.02 for region in judge._finder.best(judge._error, 12)), "there is one"


def test_a_region_gets_more_segments_where_its_outline_needs_them(place: Placer) -> None:
    rows, columns = np.indices((40, 40)) + 0.5
    cross = np.ones((40, 40, 3))
    cross[16:24, 4:36] = cross[4:36, 16:24] = 0.1
    disc = np.ones((40, 40, 3))
    disc[np.hypot(columns - 20, rows - 20) < 14] = 0.1
    assert place(disc, 1, Options(placement="region")).num_segments == 4
    more = place(cross, 1, Options(placement="region", max_segments=8))
    assert 4 < more.num_segments <= 8
    four = place(cross, 1, Options(placement="region", max_segments=4))
    assert four.num_segments == 4
    assert place.error(cross, more) < place.error(cross, four)
    assert place(cross, 1, Options(placement="region", segments=6, max_segments=4)).num_segments == 6


def test_an_error_that_no_region_would_lessen_gets_no_path(place: Placer) -> None:
    # No pixel has a neighbour of its colour: whatever region is painted in its mean colour, more is lost than the one
    # wrong pixel is off.
    rows, columns = np.indices((8, 9))
    palette = np.array([(0, 0, 0), (1, 0, 0), (0, 1, 1), (1, 1, 0), (0, 0, 1.0)])
    target = palette[(columns + 2 * rows) % 5]
    colors = np.concatenate([target, np.ones((8, 9, 1))], axis=-1)
    colors[3, 5, :3] = 1 - target[3, 5]
    pixels = [([drawings.rectangle(x, y, x + 1, y + 1)], colors[y, x]) for y in range(8) for x in range(9)]
    options = Options(placement="region", radius=0.6)
    placement = place.on(drawings.build(pixels, (8, 9)), target, 1, options)
    assert placement.drawing.num_layers == 0 and placement.order.tolist() == list(range(72))


def test_a_first_path_that_no_region_is_worth_is_a_circle_at_the_largest_error(place: Placer) -> None:
    rows, columns = np.indices((8, 9))
    target = np.ones((8, 9, 3)) - 0.01 * ((columns + 2 * rows) % 5)[..., None]
    target[3, 5] = 0.9
    drawing = place(target, 3, Options(placement="region", radius=0.6, prune=1e-2))
    np.testing.assert_allclose(drawing.points, circle((5.5, 3.5), 0.6, 4), atol=1e-12)
    np.testing.assert_allclose(drawing.colors, [(0.9, 0.9, 0.9, 1)], atol=1e-7)


@pytest.mark.parametrize(("prune", "count"), [(0.0, 2), (1e-3, 2), (0.04, 2), (0.06, 1)])
def test_no_more_paths_than_regions_that_are_worth_one(place: Placer, prune: float, count: int) -> None:
    # Of 400 pixels the large square is 100, black on white: a mean squared error of .25; the small one is 4, .01, which
    # is a fifth of .05.
    target = np.ones((20, 20, 3))
    target[2:12, 2:12], target[15:17, 15:17] = 0, 0
    assert place(target, 2, Options(placement="region", prune=prune)).num_layers == count


def test_a_region_is_found_though_the_first_outlines_fail(place: Placer, monkeypatch: pytest.MonkeyPatch) -> None:
    # Six squares: the outlines of the five that hold most error come to nothing, as those of intricate regions may.
    target = np.ones((48, 48, 3))
    corners = [(4 + 14 * (k % 3), 6 + 22 * (k // 3)) for k in range(6)]
    for k, (left, top) in enumerate(corners):
        target[top : top + 9, left : left + 9] = 0.1 + 0.1 * k
    outlined, failed = candidates._Judge._outlined, []

    def failing(judge: Any, guess: Any) -> Any:
        if len(failed) < 5:
            failed.append(guess)
            return judge._candidates([[circle((24, 24), 0.1, 4)]], guess.rgba)[0]
        return outlined(judge, guess)

    monkeypatch.setattr(candidates._Judge, "_outlined", failing)
    drawing = place(target, 1, Options(placement="region"))
    assert len(failed) == 5
    center = drawing.points.reshape(-1, 2).mean(axis=0)
    assert min(np.hypot(center[0] - left - 4.5, center[1] - top - 4.5) for left, top in corners) < 2
    assert place.error(target, drawing) < np.square(1 - target).sum()


def _many_shapes(seed: int = 5) -> FloatArray:
    """Return bars and discs of several colours across each other, with a ring: some lie behind others."""
    rng = np.random.default_rng(seed)
    rows, columns = np.indices((72, 80)) + 0.5
    target = np.ones((72, 80, 3))
    for _ in range(12):
        x, y, radius = rng.uniform((5, 5, 4), (75, 67, 16))
        target[np.hypot(columns - x, rows - y) < radius] = rng.choice([RED, GREEN, BLUE])
    target[34:38] = (0.1, 0.1, 0.1)
    return target


def test_what_is_remembered_of_regions_is_what_trying_again_gives(
    place: Placer, monkeypatch: pytest.MonkeyPatch
) -> None:
    target, options = _many_shapes(), Options(placement="region", prune=1e-7)
    remembered = place(target, 14, options)
    accept = candidates._Judge.accept

    def forgetting(judge: Any, candidate: Any) -> None:
        accept(judge, candidate)
        judge._tried.clear()

    monkeypatch.setattr(candidates._Judge, "accept", forgetting)
    again = place(target, 14, options)
    assert remembered.num_layers == 14
    assert np.array_equal(remembered.points, again.points) and np.array_equal(remembered.colors, again.colors)


def test_only_holes_that_are_better_as_they_are_stay_open(place: Placer) -> None:
    # A window shows the white canvas; a spot of dark red is nearer to red than to the canvas: it is painted over.
    target = np.ones((48, 48, 3))
    target[4:44, 4:44] = RED
    target[10:20, 10:20] = 1.0
    target[28:38, 28:38] = (0.6, 0.1, 0.2)
    first = place(target, 1, Options(placement="region"))
    coverage = place.alphas(first)[0]
    assert coverage[12:18, 12:18].max() < 0.1 and coverage[30:36, 30:36].min() > 0.9
    without = place(target, 1, Options(placement="region", holes=False))
    assert place.alphas(without)[0][12:18, 12:18].max() < 0.1  # where it shows the ground


def test_without_holes_a_hole_is_filled_that_shows_anything_but_the_ground(place: Placer) -> None:
    target = np.ones((48, 48, 3))
    target[4:44, 4:44] = RED
    target[10:30, 10:30] = (1.0, 0.8, 0.8)
    for holes in (True, False):
        first = place(target, 1, Options(placement="region", holes=holes))
        assert (place.alphas(first)[0][12:28, 12:28].max() < 0.1) == holes


def _judge(
    target: FloatArray, rasterizer_for: RasterizerFor, alphas: FloatArray, colors: FloatArray
) -> candidates._Judge:
    """Return a judge for layers on white, all hidden ones among them."""
    image = np.ones(target.shape)
    for alpha, color in zip(alphas, colors, strict=True):
        image += alpha[..., None] * (color - image)
    stack = LayerStack(np.ones(3), alphas, colors, image)
    context = Context(rasterizer_for(target.shape[:2], np.float32), target, Options(placement="region", prune=1e-7))
    return candidates._Judge(context, Painting(target, stack), np.random.default_rng(0))


def _region(judge: candidates._Judge, color: tuple[float, ...]) -> Region:
    """Return the region of a colour that holds most error."""
    judge._error = judge._painting.error.astype(np.float64)
    return next(region for region in judge._regions() if np.allclose(region.color, color))


def _painted(window: Window, color: tuple[float, ...], depth: int, alpha: float = 1.0) -> Candidate:
    """Return a layer that paints a window."""
    size = window[0].stop - window[0].start, window[1].stop - window[1].start
    trial = Trial(depth, window, np.full(size, alpha, np.float32), np.array(color), 0.0)
    return Candidate([], np.array([*color, alpha]), trial)


@pytest.mark.parametrize("seed", [0, 3])
def test_what_is_remembered_of_a_region_is_what_is_found_anew(seed: int, rasterizer_for: RasterizerFor) -> None:
    target = _many_shapes(seed)
    judge = _judge(target, rasterizer_for, np.zeros((0, 72, 80)), np.zeros((0, 3)))
    remembered = 0
    for _ in range(10):
        best = judge.best(0.0)
        assert best is not None
        judge.accept(best)
        known = dict(judge._tried)
        judge._tried.clear()
        judge._error = judge._painting.error.astype(np.float64)
        for region in judge._regions():
            judge._as_it_is(region)
        for key in known.keys() & judge._tried.keys():
            for old, new in zip(known[key].guesses, judge._tried[key].guesses, strict=True):
                remembered += 1
                assert old.gain == new.gain and old.window == new.window and np.array_equal(old.mask, new.mask)
                if old.candidate is not None:
                    anew = judge._outlined(new).trial
                    assert (anew.gain, anew.depth) == (old.candidate.trial.gain, old.candidate.trial.depth)
        judge._tried = known
    assert remembered >= 10


def test_a_trial_is_forgotten_where_the_picture_changes(rasterizer_for: RasterizerFor) -> None:
    # A translucent layer, which hides nothing.
    target = np.ones((24, 24, 3))
    target[4:16, 6:18] = BLUE
    judge = _judge(target, rasterizer_for, np.zeros((0, 24, 24)), np.zeros((0, 3)))
    region = _region(judge, BLUE)
    before = judge._as_it_is(region).guesses[0].gain
    judge.accept(_painted((slice(4, 16), slice(6, 18)), BLUE, 0, alpha=0.9))
    assert judge._as_it_is(region).guesses[0].gain == pytest.approx(0.1**2 * before, rel=1e-4)


def test_a_trial_is_forgotten_where_pixels_beside_it_become_hidden(rasterizer_for: RasterizerFor) -> None:
    # A bar with a block across it. Once the block is painted, the bar may run on behind it.
    target = np.ones((24, 40, 3))
    target[8:14, 2:38] = GREEN
    target[2:20, 16:24] = BLUE
    judge = _judge(target, rasterizer_for, np.zeros((0, 24, 40)), np.zeros((0, 3)))
    region = _region(judge, GREEN)
    assert [guess.mask.sum() for guess in judge._as_it_is(region).guesses] == [6 * 14]
    judge.accept(_painted((slice(2, 20), slice(16, 24)), BLUE, 0))
    assert [guess.mask.sum() for guess in judge._as_it_is(region).guesses] == [6 * 14, 6 * 36]


def test_a_region_that_was_estimated_a_little_too_low_is_tried(
    rasterizer_for: RasterizerFor, monkeypatch: pytest.MonkeyPatch
) -> None:
    judge = _judge(np.zeros((8, 8, 3)), rasterizer_for, np.zeros((0, 8, 8)), np.zeros((0, 3)))
    whole = slice(0, 8), slice(0, 8)
    mask = np.ones((8, 8), bool)
    estimates = {100.0: 99.0, 99.1 / SEARCH.roughness: 102.0, 98.9 / SEARCH.roughness: 103.0}
    guesses = [candidates._Guess(whole, mask, np.ones(4), gain) for gain in estimates]

    def outlined(guess: Any) -> Candidate:
        return Candidate([], np.ones(4), Trial(0, whole, mask, np.ones(3), estimates[guess.gain]))

    monkeypatch.setattr(judge, "_outlined", outlined)
    monkeypatch.setattr(judge, "_regions", lambda: iter([None]))
    monkeypatch.setattr(judge, "_as_it_is", lambda region: candidates._Tried(guesses, whole, whole))
    best = judge.best(0.0)
    assert best is not None and best.trial.gain == 102.0
