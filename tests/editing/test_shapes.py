# SPDX-License-Identifier: Apache-2.0
"""Circles, ellipses and rectangles found in outlines that stray from them, or of which only a part is seen."""

from __future__ import annotations

import numpy as np
import pytest

from livecl.editing.shapes import fitted_shapes
from livecl.editing.trace import SampledOutline, sampled
from livecl.svg.primitives import Primitive, ellipse, rectangle

SHAPES = {
    "circle": ellipse(np.array([60.0, 50.0]), (24.0, 24.0)),
    "small circle": ellipse(np.array([60.0, 50.0]), (4.0, 4.0)),
    "ellipse": ellipse(np.array([60.0, 50.0]), (40.0, 24.0)),
    "turned ellipse": ellipse(np.array([60.0, 50.0]), (40.0, 24.0), 30.0),
    "rectangle": rectangle(np.array([20.0, 30.0]), np.array([90.0, 60.0])),
    "rounded rectangle": rectangle(np.array([20.0, 30.0]), np.array([90.0, 60.0]), 8.0),
}


def traced(shape: Primitive | None, noise: float = 0.0) -> SampledOutline:
    assert shape is not None
    points = shape.points
    result = sampled(np.concatenate([points, np.roll(points[:, :1], -1, axis=0)], axis=1))
    assert result is not None
    result.points[:] += np.random.default_rng(0).normal(0, noise, result.points.shape)
    return result


def traced_through(points: np.ndarray) -> SampledOutline:
    """Trace the polygon through points (n, 2)."""
    steps = np.roll(points, -1, axis=0) - points
    result = sampled(np.stack([points, points + steps / 3, points + 2 * steps / 3, points + steps], axis=1))
    assert result is not None
    return result


def gap(found: Primitive, true: Primitive) -> float:
    """Return the largest difference of their numbers."""
    names = set(true.attributes) | set(found.attributes) - {"transform"}
    names.discard("transform")
    return max(abs(float(found.attributes.get(name, 0)) - float(true.attributes.get(name, 0))) for name in names)


@pytest.mark.parametrize("kind", SHAPES)
def test_is_found_with_its_numbers_in_an_outline_that_strays(kind: str) -> None:
    """By .05 px (standard deviation) of independent samples, some 100 or more."""
    true = SHAPES[kind]
    assert true is not None
    same = [shape for shape in fitted_shapes(traced(true, 0.05)) if shape.tag == true.tag]
    assert same and min(gap(shape, true) for shape in same) < 0.1


def test_circle_half_hidden_is_whole() -> None:
    true = SHAPES["circle"]
    assert true is not None
    trace_ = traced(true)
    hidden = trace_.points[:, 0] > 62
    trace_.points[hidden, 0] = 62  # cut off by a guess at the hidden part
    trace_.weights[hidden] = 0.25
    found = fitted_shapes(trace_)
    assert found[0].tag == "circle" and gap(found[0], true) < 0.05
    trace_.weights[:] = 1
    assert all(shape.tag != "circle" for shape in fitted_shapes(trace_))


def test_what_is_seen_of_a_circle_must_tell_where_the_rest_is() -> None:
    true = SHAPES["circle"]
    assert true is not None
    for share, noise, tags in ((0.4, 0.0, ["circle"]), (0.4, 0.3, []), (0.3, 0.0, ["circle"])):
        trace_ = traced(true, noise)
        x, y = (trace_.points - (60.0, 50.0)).T
        hidden = np.arctan2(y, x) % (2 * np.pi) > share * 2 * np.pi
        trace_.points[hidden] = (60.0, 50.0)
        trace_.weights[hidden] = 0.25
        assert [shape.tag for shape in fitted_shapes(trace_)] == tags


def test_a_quarter_of_a_circle_tells_nothing() -> None:
    trace_ = traced(SHAPES["circle"])
    trace_.weights[(trace_.points[:, 0] > 60) | (trace_.points[:, 1] > 50)] = 0.25
    assert fitted_shapes(trace_) == []


@pytest.mark.parametrize("kind", ["egg", "full ellipse", "drop", "triangle", "star"])
def test_other_shapes_are_not_found(kind: str) -> None:
    angle = np.linspace(0, 2 * np.pi, 400, endpoint=False)
    outlines = {
        "egg": np.stack([40 * np.cos(angle), 24 * np.sin(angle) * (1 + 0.15 * np.cos(angle))], 1),
        "full ellipse": np.stack([np.sign(f(angle)) * np.abs(f(angle)) ** 0.97 * r
                                  for f, r in ((np.cos, 40), (np.sin, 24))], 1),
        "drop": np.stack([40 * np.cos(angle), 24 * np.sin(angle) * np.sin(angle / 2) ** 2], 1),
        "triangle": np.stack([np.interp(angle, [0, 2.1, 4.2, 6.3], [0, 60, 30, 0]),
                              np.interp(angle, [0, 2.1, 4.2, 6.3], [0, 0, 50, 0])], 1),
        "star": np.stack([np.cos(angle), np.sin(angle)], 1) * (30 + 5 * np.cos(5 * angle))[:, None],
    }  # fmt: skip
    assert fitted_shapes(traced_through(outlines[kind] + 80)) == []


@pytest.mark.parametrize(
    ("radius", "wave", "bump", "found"),
    [(24, 0.08, 0, True), (24, 0.12, 0, False), (4, 0.09, 0, True), (4, 0.2, 0, False), (60, 0, 0.5, True),
     (60, 0, 1.1, False)],
)  # fmt: skip
def test_how_far_a_circle_may_be_from_its_outline(radius: float, wave: float, bump: float, found: bool) -> None:
    """.06 px on average without the farthest tenth (waves of 1.6 times that), .75 px at a bump of 6 px."""
    angle = np.linspace(0, 2 * np.pi, 400, endpoint=False)
    away = radius + wave * np.cos(12 * angle) + bump * np.exp(-np.square((angle - 3) * radius / 3))
    points = away[:, None] * np.stack([np.cos(angle), np.sin(angle)], axis=1) + 80
    assert [shape.tag for shape in fitted_shapes(traced_through(points))][:1] == ["circle"] * found
