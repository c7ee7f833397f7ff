# SPDX-License-Identifier: Apache-2.0
"""Every option changes what it is about, in the direction that it is for."""

from __future__ import annotations

import dataclasses
import itertools
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from support.line_art import DRAWINGS
from support.runs import QUICK, SMALL

from livecl import Options, Result, render, vectorize
from livecl.quality.layers import self_crossing
from livecl.run.callbacks import Step
from livecl.svg.writer import primitives
from livecl.training.xing import xing_loss

Image = NDArray[np.float64]


def discs(*about: tuple[float, float, float, tuple[float, float, float]]) -> Image:
    """A picture of discs (x, y, radius, colour) on white."""
    rows, columns = np.indices((24, 24)) + 0.5
    image = np.ones((24, 24, 3))
    for x, y, radius, color in about:
        image[np.hypot(columns - x, rows - y) < radius] = color
    return image


RED, BLUE = (0.8, 0.2, 0.1), (0.1, 0.2, 0.8)
RING = discs((12, 12, 9, RED), (12, 12, 5, (1, 0.85, 0.85)))
TARGET = discs((12, 12, 10, RED), (12, 12, 7, BLUE))
#: A ground that turns from red to blue, from the left to the right.
RAMP = np.broadcast_to(np.linspace(RED, BLUE, 24), (24, 24, 3)).copy()
#: Two that touch, differently far from white.
TWINS = discs((8, 12, 5.5, BLUE), (17, 12, 5, (0.6, 0.6, 0.9)))
ONE = discs((12, 12, 8, RED))
BOX = np.ones((24, 24, 3))
BOX[5:17, 4:20] = RED


@dataclasses.dataclass
class Run:
    """A run, and the drawing after each of its steps."""

    result: Result
    steps: list[Any]
    losses: list[float]

    @property
    def drawing(self) -> Any:
        return self.result.drawing

    def way(self, name: str) -> float:
        """Sum of the changes of an array of the drawing from step to step, while the layers are the same."""
        arrays = [getattr(drawing, name) for drawing in self.steps]
        pairs = itertools.pairwise(arrays)
        return float(sum(np.abs(b - a).sum() for a, b in pairs if a.shape == b.shape))

    def layer(self, index: int = 0) -> NDArray[Any]:
        """The points of a layer as it was after the first step: (M, 3, 2)."""
        drawing = self.steps[0]
        return drawing.points[drawing.segment_offsets[index] : drawing.segment_offsets[index + 1]]


def radii(run: Run) -> NDArray[Any]:
    anchors = run.layer()[:, 0]
    return np.hypot(*(anchors - anchors.mean(axis=0)).T)


def most_segments(run: Run) -> float:
    return float(np.diff(run.drawing.segment_offsets).max())


def mse(run: Run) -> float:
    return run.result.mse


def layers(run: Run) -> float:
    return float(run.drawing.num_layers)


def segments(run: Run) -> float:
    return float(run.drawing.num_segments)


def num_shapes(run: Run) -> float:
    return float(len(primitives(run.drawing)))


def num_colors(run: Run) -> float:
    return float(len(np.unique(run.drawing.colors, axis=0)))


def steps(run: Run) -> float:
    return float(len(run.steps))


def points_way(run: Run) -> float:
    return run.way("points")


def first_color(run: Run) -> NDArray[Any]:
    return run.steps[0].colors[0]


@dataclasses.dataclass(frozen=True)
class Effect:
    """The options before, the change, and the measure that is to become less (-1) or more (1)."""

    options: Options
    changes: dict[str, Any]
    measure: Callable[[Run], float]
    sign: int
    image: Image = dataclasses.field(default_factory=lambda: SMALL)
    schedule: tuple[int, ...] = (1, 2)


AS_TRAINED: dict[str, Any] = {"simplify": False, "primitives": False}
FAST = Options(placement="region", iterations=2, revisions=0)
ON_RIM = Options.paper(iterations=40, radius=10.0, learning_rate=1e-6, color_learning_rate=0.05)
STILL = Options.paper(iterations=1, learning_rate=1e-6)
LARGE = np.kron(SMALL, np.ones((15, 15, 1)))
EFFECTS: dict[str, Effect] = {
    "pixels_per_path": Effect(
        FAST, {"pixels_per_path": 0}, lambda run: float(np.prod(run.steps[0].size)), 1, LARGE, (1,)
    ),
    "iterations": Effect(QUICK, {"iterations": 60}, mse, -1),
    "segments": Effect(dataclasses.replace(QUICK, **AS_TRAINED), {"segments": 5}, most_segments, 1),
    "max_segments": Effect(
        dataclasses.replace(FAST, max_segments=4, **AS_TRAINED), {"max_segments": 12}, most_segments, 1
    ),
    "simplify": Effect(dataclasses.replace(FAST, primitives=False), {"simplify": False}, segments, 1, BOX, (1,)),
    "colors": Effect(FAST, {"colors": 2}, num_colors, -1, TARGET),
    "palette": Effect(FAST, {"palette": "lime"}, lambda run: run.drawing.colors[0, 1], 1, TARGET),
    "primitives": Effect(dataclasses.replace(FAST, simplify=False), {"primitives": False}, num_shapes, -1, BOX, (1,)),
    # As `tau` below, where the paper's loss has the disc's rim count more than its core.
    "loss": Effect(ON_RIM, {"loss": "mse"}, lambda run: run.drawing.colors[0, 0], -1, TARGET, (1,)),
    "xing_weight": Effect(
        Options.diffvg(iterations=40), {"xing_weight": 1.0}, lambda run: xing_loss(run.drawing.cubics)[0], -1
    ),
    # The disc is the largest component of the error, and lies in the middle.
    "placement: random": Effect(
        STILL, {"placement": "random"}, lambda run: np.hypot(*(run.layer()[:, 0].mean(axis=0) - 12)), 1, ONE, (1,)
    ),
    "placement: region": Effect(dataclasses.replace(FAST, placement="component"), {"placement": "region"}, mse, -1),
    "shape: random": Effect(STILL, {"shape": "random"}, lambda run: radii(run).std(), 1),
    "shape: outline": Effect(STILL, {"shape": "outline"}, mse, -1, ONE, (1,)),
    "holes": Effect(FAST, {"holes": False}, lambda run: len(run.drawing.subpath_offsets) - layers(run), -1, RING),
    "settle": Effect(Options.paper(iterations=30), {"settle": 0.1}, points_way, -1),
    "end_early": Effect(
        Options(placement="region", iterations=100, revisions=0, end_early=False),
        {"end_early": True},
        steps,
        -1,
        ONE,
        (1,),
    ),
    "revisions": Effect(Options(placement="region", iterations=10, revisions=0), {"revisions": 3}, mse, -1),
    # Three small circles within one disc.
    "merge": Effect(Options.paper(iterations=10, merge=True), {"merge": False}, layers, 1, ONE),
    "prune": Effect(FAST, {"prune": 0.1}, layers, -1),
    "target_mse": Effect(QUICK, {"target_mse": 0.9}, steps, -1),
    "path_gain": Effect(QUICK, {"path_gain": 0.9}, steps, -1, schedule=(1, 1, 1)),
    "untangle": Effect(
        Options.diffvg(iterations=40, learning_rate=2.0),
        {"untangle": True},
        lambda run: self_crossing(run.drawing).sum(),
        -1,
        schedule=(8,),
    ),
    # A ground that turns from red to blue is drawn by paths that reach beyond the page.
    "trim": Effect(
        Options.paper(iterations=30, radius=20.0),
        {"trim": True},
        lambda run: np.abs(run.drawing.points - 12).max(),
        -1,
        RAMP,
        (1,),
    ),
    "background": Effect(QUICK, {"background": "#0000ff"}, lambda run: run.drawing.background[:2].sum(), -1),
    "radius": Effect(STILL, {"radius": 3.0}, lambda run: radii(run).mean(), -1),
    # A circle on the disc's edge: what lies deeper inside counts less with a shorter reach.
    "tau": Effect(ON_RIM, {"tau": 3.0}, lambda run: run.drawing.colors[0, 0], 1, TARGET, (1,)),
    # Nothing is wrong any more where all differences count as right: the place is no longer that of the disc.
    "color_threshold": Effect(
        STILL, {"color_threshold": 2.0}, lambda run: np.hypot(*(run.layer()[:, 0].mean(axis=0) - 12)), 1, ONE, (1,)
    ),
    # In one bin, both discs are one component, whose middle is further to the right.
    "bins": Effect(STILL, {"bins": 1}, lambda run: run.layer()[:, 0, 0].mean(), 1, TWINS, (1,)),
    "learning_rate": Effect(QUICK, {"learning_rate": 0.5}, points_way, -1),
    "color_learning_rate": Effect(QUICK, {"color_learning_rate": 0.05}, lambda run: run.way("colors"), 1),
    # The canvas is half of that: half of the rate.
    "full_rate_side": Effect(QUICK, {"full_rate_side": 48.0}, points_way, -1),
    "decay": Effect(Options.paper(iterations=30), {"decay": 0.01}, points_way, -1),
    "new_color": Effect(
        STILL, {"new_color": "random"}, lambda run: np.abs(first_color(run) - [*RED, 1]).sum(), 1, ONE, (1,)
    ),
    "opacity": Effect(
        Options.paper(iterations=30), {"opacity": "opaque"}, lambda run: run.drawing.colors[:, 3].min(), 1
    ),
    "fills": Effect(Options(iterations=30, revisions=0, fills="solid"), {"fills": "auto"}, mse, -1, image=RAMP),
    "strokes": Effect(
        QUICK, {"strokes": "only"}, lambda run: (run.drawing.strokes.widths > 0).sum(), 1, render(DRAWINGS["star"])
    ),
    # Of five random loops, the released program has the Xing loss look at the newest only.
    "variant": Effect(
        dataclasses.replace(STILL, shape="random", xing_weight=1e3),
        {"variant": "released"},
        lambda run: run.losses[-1],
        -1,
        schedule=(4, 1),
    ),
}


@pytest.mark.parametrize("name", EFFECTS)
def test_option_does_what_it_is_for(name: str, device: int) -> None:
    effect = EFFECTS[name]
    values = []
    for changes in ({}, effect.changes):
        drawings, losses = [], []

        def look(step: Step, drawings: list[Any] = drawings, losses: list[float] = losses) -> None:
            drawings.append(step.drawing)
            losses.append(step.loss)

        options = dataclasses.replace(effect.options, **changes)
        result = vectorize(effect.image, schedule=effect.schedule, options=options, device=device, on_step=look)
        values.append(float(effect.measure(Run(result, drawings, losses))))
    rise = effect.sign * (values[1] - values[0])
    assert rise > 0, f"{name}: {values[0]} became {values[1]}"


def test_no_option_is_left_out_above() -> None:
    changed = {field for effect in EFFECTS.values() for field in effect.changes}
    assert changed == {field.name for field in dataclasses.fields(Options)}


def test_the_program_s_weight_goes_with_paths_on_top_only() -> None:
    for changes in ({"placement": "region"}, {"revisions": 1}):
        with pytest.raises(ValueError, match=r"^variant: "):
            Options.released(**changes)
