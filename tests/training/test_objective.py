# SPDX-License-Identifier: Apache-2.0
"""What a run minimizes: the losses of the text and of the authors' program, against their equations."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from reference.distance import distance
from reference.flatten import flatten
from reference.rounding import UNIT
from support.runs import SMALL, new_run

from livecl import Drawing, Options, Rasterizer
from livecl.drawing import Strokes
from livecl.run.run import Run
from livecl.training.objective import DISTANCE_TOLERANCE, Objective
from livecl.training.state import State
from livecl.training.xing import xing_loss


def _closeness(run_: Run, layers: NDArray[Any] | None = None) -> NDArray[np.float64]:
    """Return ReLU(tau - d) of some layers or all, (N, H, W), px, from the same lines that the loop measures with."""
    drawing = run_.state.drawing
    share = np.sqrt(run_.rasterizer.tolerance / DISTANCE_TOLERANCE)
    outlines = flatten(drawing, np.ceil(run_.state.pieces * share).astype(np.int32))
    wanted = range(drawing.num_layers) if layers is None else layers
    tau = run_.state.options.tau
    return np.stack([np.maximum(tau - distance(outlines[layer], drawing.size), 0) for layer in wanted])


def _squared_error(run_: Run, target: NDArray[Any]) -> NDArray[np.float64]:
    image = run_.rasterizer.forward(run_.state.drawing, run_.state.pieces).astype(np.float64)
    return np.square(image - target).sum(axis=-1)


def _pupil() -> NDArray[np.float64]:
    """Return a black disc within a pale one, 24 x 24: of the two the black one holds more error, and it lies on top."""
    away = np.hypot(*(np.indices((24, 24)) - 11.5))
    picture = np.ones((24, 24, 3))
    picture[away < 10], picture[away < 4] = 0.85, 0.0
    return picture


# Sums of 576 pixels' weights and of their weighted errors, in single precision; distances of nearly 0 are off by more,
# but they are few.
LOSS_TOLERANCE = 2 * 576 * UNIT


def test_the_paper_s_loss_is_its_equations_2_and_4(device: int) -> None:
    target = SMALL
    run_ = new_run(Options.paper(iterations=6, xing_weight=0.5), (1, 2), device)
    for _ in range(2):
        run_.begin()
        for _ in range(6):
            drawing = run_.state.drawing
            closeness = _closeness(run_)
            weight = (closeness / closeness.sum(axis=(1, 2), keepdims=True)).mean(axis=0)
            expected = (weight * _squared_error(run_, target)).sum() / 3 + 0.5 * xing_loss(drawing.cubics)[0]
            assert run_.step() == pytest.approx(expected, rel=LOSS_TOLERANCE)
        run_.end()


def test_the_program_s_loss_is_its_map_of_weights(device: int) -> None:
    # w = (10 - min(|d|, 10)) / 10 of the newest stage's paths together, scaled to a maximum of 1, to which the maps of
    # the stages before are added, as they were at their end; the sum is clipped to [0, 1].
    # A shorter reach than 10 px leaves pixels for the later stages to differ in.
    tau, target = 4.0, _pupil()
    run_ = new_run(Options.released(iterations=3, xing_weight=0.5, tau=tau), (1, 1, 2), device, target)
    kept = np.zeros((24, 24))
    for stage in range(3):
        run_.begin()
        for step in range(4):
            drawing = run_.state.drawing
            newest = np.flatnonzero(drawing.stages == stage)
            closeness = _closeness(run_, newest).max(axis=0) / tau
            weight = np.minimum(closeness / closeness.max() + kept, 1)
            if step == 3:
                kept = weight
                break
            error = (weight * _squared_error(run_, target)).mean()
            xing = xing_loss(drawing.cubics[np.isin(drawing.segment_layers, newest)])[0]
            assert run_.step() == pytest.approx(error + 0.5 * xing, rel=LOSS_TOLERANCE)
        run_.end()


def test_the_default_loss_is_the_mean_squared_error_under_the_weight_of_now(device: int) -> None:
    run_ = new_run(Options(), (2,), device)
    run_.begin()
    error = _squared_error(run_, SMALL)
    for weight in (np.ones((24, 24)), np.tri(24), 1 - np.tri(24), None):
        run_.state.kept_weight = weight
        expected = np.mean(error if weight is None else weight * error) / 3
        assert run_.objective.evaluate(run_.state)[0] == pytest.approx(expected, rel=LOSS_TOLERANCE)


def _xing_of(drawing: Drawing, device: int) -> tuple[float, NDArray[np.float64]]:
    """Return the share of the Xing loss in an objective, and of its gradient by points, in single precision."""
    rasterizer = Rasterizer(drawing.size, device)
    objective, found = Objective(rasterizer, SMALL), []
    for weight in (1.0, 0.0):
        state = State.start(drawing, Options(xing_weight=weight), 0)
        state.pieces = rasterizer.pieces(drawing)
        found.append(objective.evaluate(state))
    return found[0][0] - found[1][0], found[0][1].points - found[1][1].points


def test_an_anchor_has_the_xing_loss_of_both_its_segments(device: int) -> None:
    points = np.random.default_rng(3).uniform(2, 22, (5, 3, 2))
    drawing = Drawing.from_outlines([[points]], (1, 0, 0, 1), (24, 24))
    loss, d_cubics = xing_loss(drawing.cubics)
    expected = d_cubics[:, :3].copy()
    expected[:, 0] += np.roll(d_cubics[:, 3], 1, axis=0)
    found, d_points = _xing_of(drawing, device)
    assert loss > 0.1 and found == pytest.approx(loss, abs=1e-5)
    np.testing.assert_allclose(d_points, expected, atol=1e-5)


def test_beyond_the_end_of_an_open_line_nothing_crosses(device: int) -> None:
    """The handles of its last row, which nothing draws, stay behind in training: they make a segment that costs."""
    points = np.array([[(4, 4), (8, 4), (12, 8)], [(16, 8), (20, 20), (20, 4)]], dtype=np.float64)
    strokes = Strokes(widths=[2.0], caps=[0], joins=[0], miter_limits=[4.0], is_open=[True])
    drawing = Drawing.from_outlines([[points]], (1, 0, 0, 1), (24, 24), strokes=strokes)
    drawing = drawing.moved(points, drawing.colors, drawing.background)
    costs = [xing_loss(drawing.cubics[rows])[0] for rows in (slice(0, 1), slice(1, 2))]
    assert costs[0] == 0 and costs[1] > 0.1
    found, d_points = _xing_of(drawing, device)
    assert found == pytest.approx(0, abs=1e-6) and np.abs(d_points).max() < 1e-6
