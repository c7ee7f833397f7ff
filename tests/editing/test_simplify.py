# SPDX-License-Identifier: Apache-2.0
"""The last step of a run: descriptions are taken where they save more than they cost, and stay exact under training."""

from __future__ import annotations

import re

import numpy as np
import pytest

from livecl.drawing import Drawing, Strokes
from livecl.editing import editable, simplify
from livecl.editing.constraints import Constraints
from livecl.editing.simplify import NUMBER_ERROR, numbers_of, price_of
from livecl.editing.tidying import tidied
from livecl.geometry import bezier
from livecl.layering.context import Context
from livecl.options import PRESETS, Options
from livecl.quality import self_crossing
from livecl.rendering import Rasterizer, render
from livecl.svg import format_svg, quantize, read_svg
from livecl.svg.primitives import ellipse, rectangle

SIZE = (90, 120)


def wiggly(points: np.ndarray, count: int = 4, wiggle: float = 0.06) -> np.ndarray:
    """Return an outline in more pieces, their points moved by `wiggle` px (standard deviation)."""
    cubics = np.concatenate([points, np.roll(points[:, :1], -1, axis=0)], axis=1)
    t = np.arange(count) / count
    pieces = np.concatenate([bezier.subsegment(np.repeat(c[None], count, 0), t, t + 1 / count) for c in cubics])
    return pieces[:, :3] + np.random.default_rng(0).normal(0, wiggle, (len(pieces), 3, 2))


def scene() -> tuple[Drawing, Drawing]:
    """Return a drawing of a disc, partly under a box, an ellipse and an egg, and the same in wiggly pieces."""
    disc = ellipse(np.array([40.0, 40.0]), (25.0, 25.0))
    box = rectangle(np.array([50.0, 45.0]), np.array([110.0, 80.0]), 6.0)
    oval = ellipse(np.array([90.0, 20.0]), (20.0, 12.0))
    egg = read_svg(b'<svg width="9" height="9"><path d="M14 80c0-6 4-20 8-20s12 14 12 20-5 9-10 9-10-4-10-9"/></svg>')
    assert disc is not None and box is not None and oval is not None
    outlines = [disc.points, box.points, oval.points, egg.points]
    colors = [(0.9, 0.3, 0.2, 1), (0.2, 0.4, 0.8, 1), (0.1, 0.6, 0.3, 1), (0.8, 0.7, 0.2, 1)]
    true, ours = (
        Drawing.from_outlines([[make(points)] for points in outlines], colors, SIZE)
        for make in (lambda points: points, wiggly)
    )
    return true, ours


def context_of(true: Drawing, **options: bool) -> Context:
    rasterizer = Rasterizer(SIZE)
    return Context(rasterizer, rasterizer.forward(true), Options(**options))


def test_shapes_are_found_and_error_falls() -> None:
    true, ours = scene()
    context = context_of(true)
    found = quantize(editable(context, ours, np.ones(4, bool)))
    svg = format_svg(found)
    tags = [line.split()[0] for line in svg.splitlines() if "inkscape:label" in line and "<g" not in line]
    assert tags == ["<circle", "<rect", "<ellipse", "<path"]
    assert context.visible_mse(found) < context.visible_mse(ours) / 2
    np.testing.assert_allclose(found.subpath_offsets, [0, 4, 12, 16, 16 + found.num_segments - 16])
    assert found.num_segments <= 16 + 6
    np.testing.assert_allclose(found.points[:4, 0].mean(axis=0), (40, 40), atol=0.1)
    np.testing.assert_array_equal(read_svg(svg.encode()).points, found.points)


def test_each_option_does_its_part() -> None:
    true, ours = scene()
    every = np.ones(4, bool)
    nodes = editable(context_of(true, primitives=False), ours, every)
    assert "<circle" not in format_svg(nodes) and nodes.num_segments < ours.num_segments / 2
    shapes = editable(context_of(true, simplify=False), ours, every)
    assert "<circle" in format_svg(shapes) and np.diff(shapes.segment_offsets)[3] == np.diff(ours.segment_offsets)[3]
    assert editable(context_of(true, simplify=False, primitives=False), ours, every) is ours
    for preset in ("paper", "released", "diffvg"):
        options = PRESETS[preset]()
        assert not options.simplify and not options.primitives


def test_locked_layers_stay_as_they_are() -> None:
    true, ours = scene()
    found = editable(context_of(true), ours, np.array([True, False, True, False]))
    for layer in (1, 3):
        rows, before = (slice(*drawing.segment_offsets[layer : layer + 2]) for drawing in (found, ours))
        np.testing.assert_array_equal(found.points[rows], ours.points[before])
    assert found.num_segments < ours.num_segments


def test_what_the_picture_shows_is_not_simplified_away() -> None:
    """A disc with a notch of 3 px stays no circle; and each change is worth its numbers."""
    notched = read_svg(
        b'<svg width="120" height="90"><path d="M60 20a25 25 0 1 1-4 0v6h4z" fill="#c33"/></svg>'
    ).replace(background=(1, 1, 1))
    context = context_of(notched)
    ours = notched.replace(
        points=wiggly(notched.points), subpath_offsets=[0, 4 * notched.num_segments], layer_offsets=[0, 1]
    )
    found = editable(context, ours, np.ones(1, bool))
    assert "<circle" not in format_svg(found)
    saved = price_of([ours.points]) - price_of([found.points])
    rise = (context.visible_mse(found) - context.visible_mse(ours)) * 3 * SIZE[0] * SIZE[1]
    assert saved > 0 and rise <= saved * NUMBER_ERROR


def test_translucent_layers_and_no_background() -> None:
    true, ours = scene()
    changed = {"colors": ours.colors * (1, 1, 1, 0.6), "background": None}
    context = context_of(true.replace(**changed))
    found = editable(context, ours.replace(**changed), np.ones(4, bool))
    assert context.visible_mse(found) < context.visible_mse(ours.replace(**changed))
    assert format_svg(found).count("<circle") == 1


def test_bent_joins_cost_more_and_smooth_ones_less_than_their_numbers() -> None:
    """An outline of three cubics: with corners, with smooth joins, and with one of them level."""
    bent, smooth, level = (
        read_svg(f'<svg width="90" height="90"><path d="{data}"/></svg>'.encode()).points
        for data in (
            "M20 40c5 15 30 20 40 10c-5-10 3-20 1-29c-9-9-30-1-41 19",
            "M20 40c-10 20 30 20 40 10s3-20 1-29s-31 -1-41 19",
            "M20 40c-10 20 10 20 20 20s20-5 21-39s-31 -1-41 19",
        )
    )
    assert [price_of([points]) - numbers_of([points]) for points in (bent, smooth, level)] == [3, -3, -4]


def test_joins_that_hardly_turn_cost_more_than_smooth_ones_and_than_corners() -> None:
    costs = []
    for turn in (0, 2, 10, 40):
        join = f"{60 - 20 * np.cos(np.radians(turn)):.6f} {50 - 20 * np.sin(np.radians(turn)):.6f}"
        path = f"M60 80c-20 0-40-10-40-30C20 30 {join} 60 50C80 50 100 60 100 65C100 75 80 80 60 80Z"
        points = read_svg(f'<svg width="120" height="90"><path d="{path}"/></svg>'.encode()).points
        costs.append(price_of([points]) - numbers_of([points]))
    assert costs[0] < costs[3] < costs[2] < costs[1]


def test_an_ellipse_that_is_nearly_a_circle_costs_more_than_one() -> None:
    circle, oval = (ellipse(np.array([40.0, 40.0]), radii) for radii in ((9.0, 9.0), (9.0, 9.0001)))
    assert circle is not None and oval is not None
    assert (numbers_of([circle.points]), numbers_of([oval.points])) == (3, 4)


def test_what_training_cannot_make_good_is_taken_back(monkeypatch: pytest.MonkeyPatch) -> None:
    """Edited outlines that come out of training far away: the layer has the nodes that it had, others stay edited."""
    true, ours = scene()
    context = context_of(true)

    def worse(context: Context, drawing: Drawing, free: np.ndarray) -> Drawing:
        points = polished(context, drawing, free).points.copy()
        points[: drawing.segment_offsets[1]] += 3.0
        return drawing.replace(points=points)

    polished = simplify.polished
    monkeypatch.setattr(simplify, "polished", worse)
    found = editable(context, ours, np.ones(4, bool))
    first = slice(0, ours.segment_offsets[1])
    as_it_was = tidied(ours.points[first], simplify.FITS[-1].tolerance)
    np.testing.assert_array_equal(found.points[first], as_it_was)
    np.testing.assert_array_equal(as_it_was[:, 0], ours.points[first, 0])
    assert found.num_segments < ours.num_segments / 2


def test_what_is_taken_back_is_tidied(monkeypatch: pytest.MonkeyPatch) -> None:
    """Sides that are nearly level or plumb become so, though the edited outline comes out of training far away."""
    true = read_svg(b'<svg width="120" height="90"><path d="M20 20h60v40h-25l-5 8l-5-8h-25z" fill="#c33"/></svg>')
    true = true.replace(background=(1, 1, 1))
    tilted = true.replace(points=true.points + np.random.default_rng(0).normal(0, 0.02, (true.num_segments, 1, 2)))
    monkeypatch.setattr(simplify, "polished", lambda _, drawing, __: drawing.replace(points=drawing.points + 3.0))
    data = format_svg(editable(context_of(true), tilted, np.ones(1, bool))).split(' d="')[1].split('"')[0]
    assert len(re.findall("[hH]", data)) == 3 and len(re.findall("[vV]", data)) >= 1


def constrained() -> Drawing:
    """Return lines, level and plumb ones, smooth joins, circles and boxes."""
    return read_svg(
        b'<svg width="120" height="90"><path d="M10 10h40v30c0 10-10 20-20 20s-20-5-20-15z"/>'
        b'<circle cx="80" cy="40" r="20"/><rect x="60" y="62" width="40" height="20" rx="5"/>'
        b'<ellipse cx="20" cy="75" rx="12" ry="6" transform="rotate(20 20 75)"/></svg>'
    )


def slanted() -> Drawing:
    """Return smooth joins beside a slanted line and between curves, which turn, and a box with round ends."""
    return read_svg(
        b'<svg width="120" height="90"><path d="M10 10l30 8c12 3.2 18 16 10 26s-22 20-36 12z"/>'
        b'<rect x="60" y="62" width="40" height="20" rx="10"/></svg>'
    )


def random_step(drawing: Drawing, seed: int) -> tuple[np.ndarray, np.ndarray]:
    """Return a step of what may change, all layers constrained, and the points after it; no step changes none."""
    constraints = Constraints(drawing, np.ones(drawing.num_layers, bool))
    np.testing.assert_allclose(constraints.points(constraints.start), drawing.points, atol=1e-8)
    moves = constraints.gradient(constraints.start, np.random.default_rng(seed).normal(0, 1, drawing.points.shape))
    return moves, constraints.points(constraints.start + moves)


@pytest.mark.parametrize("seed", range(3))
def test_slanted_joins_turn_and_stay_smooth_and_round_ends_stay_round(seed: int) -> None:
    drawing = slanted()
    _, moved = random_step(drawing, seed)
    for points, least in ((drawing.points, 0.0), (moved, 0.005)):
        for into, out, was in (
            (points[1, 0] - points[0, 0], points[1, 1] - points[1, 0], (30.0, 8.0)),
            (points[2, 0] - points[1, 2], points[2, 1] - points[2, 0], (-8.0, 10.0)),
        ):
            assert abs(bezier.cross(into, out)) < 1e-9 * np.hypot(*into) * np.hypot(*out)
            assert abs(bezier.cross(out, np.array(was))) >= least * np.hypot(*out) * np.hypot(*was)
    [pill] = re.findall("<rect id=[^>]*>", format_svg(drawing.replace(points=moved)))
    found = dict(re.findall(r'(\w+)="([^"]*)"', pill))
    assert 2 * float(found["rx"]) == pytest.approx(min(float(found["width"]), float(found["height"])), abs=0.02)


@pytest.mark.parametrize("seed", range(3))
def test_constraints_hold_after_any_move(seed: int) -> None:
    """Of coordinates by 1 px along a gradient, which is the same for those that are shared."""
    drawing = constrained()
    moves, points = random_step(drawing, seed)
    moved = drawing.replace(points=points)
    assert np.abs(moved.points - drawing.points).max() > 0.3
    svg = format_svg(moved)
    assert [svg.count(tag) for tag in ("<path", "<circle", "<rect id=", "<ellipse")] == [1, 1, 1, 1]
    data = svg.split(' d="')[1].split('"')[0]
    assert (data.count("h"), data.count("v")) == (1, 1)
    first = moved.points[: drawing.segment_offsets[1]]
    assert first[0, 0, 1] == first[1, 0, 1] and first[1, 0, 0] == first[2, 0, 0]
    into, out = first[3, 0] - first[2, 2], first[3, 1] - first[3, 0]
    assert abs(into[0] * out[1] - into[1] * out[0]) < 1e-9 * np.hypot(*into) * np.hypot(*out)
    some = Constraints(drawing, np.array([False, True, True, True]))
    np.testing.assert_array_equal(some.points(some.start + moves)[:5], drawing.points[:5])
    assert not some.gradient(some.start, np.ones(drawing.points.shape))[:5].any()


@pytest.mark.parametrize("drawing", [constrained(), slanted()], ids=["upright", "slanted"])
def test_derivatives_by_coordinates_agree_with_central_differences(drawing: Drawing) -> None:
    """Along gradients, in which coordinates that are shared are equal; with step h by about h^2 and eps / h."""
    constraints = Constraints(drawing, np.ones(drawing.num_layers, bool))
    rng = np.random.default_rng(0)
    d_points, at, h = rng.normal(0, 1, drawing.points.shape), constraints.start, 1e-5
    found = constraints.gradient(at, d_points)
    ways = [constraints.gradient(at, rng.normal(0, 1, d_points.shape)) for _ in range(40)]
    for way in ways:
        change = constraints.points(at + h * way) - constraints.points(at - h * way)
        assert (d_points * change).sum() / (2 * h) == pytest.approx((found * way).sum(), abs=1e-6)


def test_no_description_is_weighed_twice(monkeypatch: pytest.MonkeyPatch) -> None:
    true, _ = scene()
    weighed: list[list[bytes]] = []
    cheapest = simplify._Editor.cheapest

    def noted(self: simplify._Editor, layer: int, found: list[list[np.ndarray]]) -> list[np.ndarray]:
        weighed.append([b"".join(subpath.tobytes() for subpath in outline) for outline in found])
        return cheapest(self, layer, found)

    monkeypatch.setattr(simplify._Editor, "cheapest", noted)
    editable(context_of(true, primitives=False), true, np.ones(4, bool))  # tidied, most of it is as it was
    assert weighed and all(len(set(found)) == len(found) for found in weighed)


def test_outlines_that_cross_themselves_fall_into_parts_that_show_the_same() -> None:
    """A bow tie keeps both halves; a loop that lies within the rest, and shows nothing, is left out."""
    svg = (
        b'<svg width="120" height="90"><path d="M10 10L50 40V10L10 40z" fill="#c33"/>'
        b'<path d="M60 50H110V80H80V60H90V70H60z" fill="#36c"/></svg>'
    )
    drawing = read_svg(svg).replace(background=(1, 1, 1))
    assert self_crossing(drawing).tolist() == [True, True]
    context = context_of(drawing)
    found = editable(context, drawing, np.ones(2, bool))
    assert not self_crossing(found).any()
    assert np.diff(found.layer_offsets).tolist() == [2, 1] and context.visible_mse(found) < 1e-6
    kept = editable(context_of(drawing, untangle=False), drawing, np.ones(2, bool))
    assert self_crossing(kept).all()


def test_outlines_that_fall_into_parts_beside_strokes() -> None:
    """An outline that crosses itself gets more subpaths; which of the strokes' are open stays right."""
    rows = np.array([(10, 10), (54, 50), (54, 10), (10, 50)], dtype=float)
    after = np.roll(rows, -1, axis=0)
    bow = np.stack([rows, rows + (after - rows) / 3, after - (after - rows) / 3], axis=1)
    line = np.stack([[(8.0, 58.0), (24.0, 58.0), (40.0, 58.0)], [(56.0, 58.0)] * 3])
    drawing = Drawing.from_outlines(
        [[line], [bow]],
        [[0.1, 0.1, 0.1, 1], [0.8, 0.2, 0.1, 1]],
        (64, 64),
        strokes=Strokes(widths=[3, 0], is_open=np.array([True, False])),
    )
    context = Context(Rasterizer((64, 64)), render(drawing), Options())

    found = editable(context, drawing, np.ones(2, bool))

    assert len(found.subpaths(1)) == 2
    assert found.strokes.is_open.tolist() == [True, False, False]
