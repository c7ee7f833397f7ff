# SPDX-License-Identifier: Apache-2.0
"""Gradients read from SVG: where they lie and which colours they have, against values worked out by hand."""

from __future__ import annotations

import warnings
from collections.abc import Sequence

import numpy as np
import pytest
from numpy.typing import ArrayLike
from support.svg_documents import document, read

from livecl.drawing import LINEAR, RADIAL
from livecl.errors import SvgError
from livecl.svg import format_svg, gradients, quantize, read_svg
from livecl.svg.document import parse_document
from livecl.svg.gradients import Gradient
from livecl.svg.layer import LeftOut, ReadLayer
from livecl.svg.walker import Walker

STOPS = '<stop offset="0" stop-color="red"/><stop offset="1" stop-color="#00f8"/>'
RED, BLUE = (1, 0, 0, 1), (0, 0, 1, 136 / 255)
RECT = '<rect x="10" y="20" width="40" height="50" fill="url(#g)"{}/>'


def walked(body: str) -> tuple[list[ReadLayer], LeftOut]:
    walker = Walker(parse_document(document(body)))
    return walker.layers, walker.left_out


def gradient(body: str, said: Sequence[str] = ()) -> Gradient:
    """Return the gradient of the first layer; nothing is said of it but `said`."""
    layers, left_out = walked(body)
    assert sorted(left_out) == sorted(said)
    assert layers[0].gradient is not None
    return layers[0].gradient


def linear(attributes: str = "", stops: str = STOPS) -> str:
    return f'<linearGradient id="g" {attributes}>{stops}</linearGradient>'


def radial(attributes: str = "", stops: str = STOPS) -> str:
    return f'<radialGradient id="g" {attributes}>{stops}</radialGradient>'


@pytest.mark.parametrize(
    ("attributes", "shape", "points"),
    [
        ("", "", [(10, 20), (50, 20)]),
        ('x1="25%" x2=".5" y2="1"', "", [(20, 20), (20 + 10 * 25 / 26, 20 + 50 / 26)]),
        ('gradientUnits="userSpaceOnUse" x1="5" y1="10%" x2="2em" y2="10"', "", [(5, 10), (32, 10)]),
        ('gradientUnits="userSpaceOnUse" x2="10"', ' transform="translate(1 2) scale(3)"', [(1, 2), (31, 2)]),
        ('gradientUnits="userSpaceOnUse" x2="10" gradientTransform="rotate(90)"', "", [(0, 0), (0, 10)]),
        ('gradientUnits="userSpaceOnUse" x2="10" gradientTransform="skewX(45)"', "", [(0, 0), (5, -5)]),
    ],
)
def test_linear_gradients_lie_where_svg_says(attributes: str, shape: str, points: ArrayLike) -> None:
    """Lines of equal colour stay lines: under skewX(45), x - y is what x was, and (5, -5) is the nearest point of 1."""
    found = gradient(linear(attributes) + RECT.format(shape))
    if "y2=" in attributes and "userSpace" not in attributes:
        t = found.places(np.array([[20.0, 20], [30, 70], [25, 45], [50, 20]]))
        np.testing.assert_allclose(t, [0, 1, 0.5, (0.75 * 0.25) / (0.25**2 + 1)])
    else:
        np.testing.assert_allclose(found.points, points, atol=1e-9)
    np.testing.assert_allclose(found.stops, [[0, *RED], [1, *BLUE]])


@pytest.mark.parametrize(
    ("attributes", "shape", "points"),
    [
        ("", "", [(30, 45), (50, 45), (30, 70)]),
        ('gradientUnits="userSpaceOnUse" cx="5" cy="6" r="7"', "", [(5, 6), (12, 6), (5, 13)]),
        ('gradientUnits="userSpaceOnUse"', "", [(50, 50), (100, 50), (50, 100)]),
        ('gradientUnits="userSpaceOnUse" cx="5" r="7" cy="0"', ' transform="scale(2 1)"', [(10, 0), (24, 0), (10, 7)]),
        ('cx="0" cy="0" r="1" gradientTransform="rotate(90)"', "", [(10, 20), (10, 70), (-30, 20)]),
    ],
)
def test_radial_gradients_lie_where_svg_says(attributes: str, shape: str, points: ArrayLike) -> None:
    found = gradient(radial(attributes) + RECT.format(shape))
    np.testing.assert_allclose(found.points, points, atol=1e-9)
    np.testing.assert_allclose(found.places(np.array(points, dtype=float)), [0, 1, 1])


def test_the_box_is_that_of_the_curve() -> None:
    """An arch of y = 3 t (1 - t) 40 is 30 high, its handles 40."""
    found = gradient(linear('x2="0" y2="1"') + '<path d="M10 20C10 60 50 60 50 20z" fill="url(#g)"/>')
    np.testing.assert_allclose(found.points, [(10, 20), (10, 50)])


def test_stops() -> None:
    sheet = "<style>.a{stop-color:lime;stop-opacity:50%} stop{stop-color:blue}</style>"
    stops = (
        '<stop offset="20%" class="a"/><stop offset=".1" style="stop-color:red"/>'
        '<stop offset="7" stop-color="currentColor" style="stop-color:currentColor"/>'
    )
    found = gradient(sheet + f'<g color="yellow">{linear(stops=stops)}</g><g opacity=".5">{RECT.format("")}</g>')
    np.testing.assert_allclose(found.stops, [[0.2, 0, 1, 0, 0.25], [0.2, 1, 0, 0, 0.5], [1, 1, 1, 0, 0.5]])
    t = np.array([0, 0.1, 0.2, 0.6, 1, 2])
    wanted = [(0, 1, 0, 0.25)] * 2 + [(1, 0, 0, 0.5), (1, 0.5, 0, 0.5), (1, 1, 0, 0.5), (1, 1, 0, 0.5)]
    np.testing.assert_allclose(found.colors(t), wanted)


@pytest.mark.parametrize(
    ("server", "rgba"),
    [
        (linear(stops='<stop stop-color="red" stop-opacity=".5"/>'), (1, 0, 0, 0.5)),
        (linear('x1=".5" x2=".5"'), BLUE),
        (radial('r="0"'), BLUE),
        (linear(stops='<stop stop-color="red"/><stop offset="1" stop-color="#f00"/>'), RED),
        (linear(stops=""), None),
    ],
)
def test_gradients_of_one_colour_are_exact(server: str, rgba: tuple[float, ...] | None) -> None:
    drawing = read(server + RECT.format(""))
    np.testing.assert_allclose(drawing.colors, np.zeros((0, 4)) if rgba is None else [rgba])


def test_what_is_inherited_by_reference() -> None:
    """Stops and common attributes from any gradient, geometry from one of the same kind, the nearest first."""
    others = (
        f'<linearGradient id="a" x1="0" x2="1" y2="5" gradientUnits="userSpaceOnUse" href="#b">{STOPS}</linearGradient>'
        '<radialGradient id="b" cx="9" spreadMethod="reflect" xlink:href="#c"/><linearGradient id="c" y2="0" x2="40"/>'
    )
    found = gradient(others + linear('href="#a" x2="20" y2="0"', "") + RECT.format(""))
    np.testing.assert_allclose(found.points, [(0, 0), (60, 0)])
    np.testing.assert_allclose(found.stops[:, 0], [0, 1 / 3, 2 / 3, 1])
    found = gradient(others + radial('href="#b" r="1" cy="9"', STOPS) + RECT.format(""))
    np.testing.assert_allclose(found.points[0], (10 + 9 * 40, 20 + 9 * 50))
    gradient(linear('href="#g"') + RECT.format(""), ["gradients that refer to themselves"])
    gradient(linear('href="#nothing"') + RECT.format(""), ["references of gradients to nothing"])
    chain = "".join(f'<linearGradient id="c{i}" href="#c{i + 1}"/>' for i in range(40))
    with pytest.raises(SvgError, match="chain of more than 32"):
        read_svg(document(chain + linear('href="#c0"') + RECT.format("")))


@pytest.mark.parametrize("spread", ["reflect", "repeat"])
@pytest.mark.parametrize("kind", ["linear", "radial"])
def test_repeats_are_written_out_as_far_as_the_shape_reaches(kind: str, spread: str) -> None:
    stops = '<stop offset=".25" stop-color="red"/><stop offset="1" stop-color="#00f8"/>'
    where = f'gradientUnits="userSpaceOnUse" spreadMethod="{spread}"'
    if kind == "linear":
        found = gradient(linear(f'{where} x1="20" x2="30"', stops) + RECT.format(""))
        points = np.stack([np.linspace(10.05, 49.95, 400), np.full(400, 40.0)], axis=1)
        t = (points[:, 0] - 20) / 10
    else:
        found = gradient(radial(f'{where} cx="20" cy="40" r="10"', stops) + RECT.format(""))
        points = np.stack([np.linspace(10.05, 49.95, 400), np.linspace(20, 70, 400)], axis=1)
        t = np.linalg.norm(points - (20, 40), axis=1) / 10
    inside = t % 1 if spread == "repeat" else 1 - abs(t % 2 - 1)
    share = np.clip((inside - 0.25) / 0.75, 0, 1)[:, None]
    np.testing.assert_allclose(found.colors(found.places(points)), np.array(RED) * (1 - share) + np.array(BLUE) * share)
    many = f'{where} x2=".1" r=".1"'
    server = linear(many) if kind == "linear" else radial(many)
    gradient(server + RECT.format(""), ["gradients of more than 64 repeats"])


def test_an_inner_radius_is_a_later_start() -> None:
    found = gradient(radial('gradientUnits="userSpaceOnUse" cx="0" cy="0" r="10" fr="4"') + RECT.format(""))
    np.testing.assert_allclose(found.stops, [[0.4, *RED], [1, *BLUE]])
    found = gradient(radial('r=".5" fr=".5"') + RECT.format(""))
    np.testing.assert_allclose(found.colors(np.array([0, 0.99, 1, 2])), [RED, RED, BLUE, BLUE])


def test_focal_points_are_approximated_and_the_error_is_said() -> None:
    """The nearer the focal point to the centre, the less it is; the error in the warning is that of a comparison."""
    errors = []
    for fx in (0.52, 0.6, 0.75):
        layers, left_out = walked(radial(f'fx="{fx}"') + RECT.format(""))
        said = str(left_out).partition("off the centre (1, off by ")[2].partition(" ")[0]
        errors.append(float(said))
        found = layers[0].gradient
        assert found is not None
        x, y = np.meshgrid(np.linspace(0, 1, 40), np.linspace(0, 1, 40))
        t = found.places(np.stack([10 + 40 * x, 20 + 50 * y], axis=-1))
        # The circle about the point between f and c, through (x, y), whose radius has grown in proportion.
        u, v, d = x - fx, y - 0.5, 0.5 - fx
        a, b, c = d * d - 0.25, u * d, u * u + v * v
        exact = (b - np.sqrt(b * b - a * c)) / a
        wanted = gradients.stop_colors(found.stops, exact)
        got = found.colors(t)
        for image in (wanted, got):
            image[..., :3] *= image[..., 3:]
        assert np.sqrt(np.square(got - wanted).mean()) == pytest.approx(errors[-1], rel=0.1)
    assert errors == sorted(errors)
    assert errors[0] < 0.01
    assert errors[-1] < 0.1


def test_gradients_are_read_as_fills_and_saved_ones_equal() -> None:
    rects = RECT.format("") + RECT.format(' id="second"').replace("#g", "#h")
    drawing = read_svg(document(linear() + radial('r=".4"').replace('"g"', '"h"') + rects))
    np.testing.assert_array_equal(drawing.fills.kinds, [LINEAR, RADIAL])
    np.testing.assert_allclose(drawing.fills.geometry[0], [(10, 20), (50, 20), (0, 0)])
    np.testing.assert_allclose(drawing.fills.geometry[1], [(30, 45), (46, 45), (30, 65)])
    np.testing.assert_allclose(drawing.fills.stop_colors, [RED, BLUE] * 2)
    for precision in (0, 3, 9):
        saved = quantize(drawing.replace(fills=drawing.fills.stretched((1.37, 0.9), (0.123456, 2))), precision)
        again = read_svg(format_svg(saved, precision).encode())
        for name in ("kinds", "geometry", "stop_offsets", "stop_positions", "stop_colors"):
            np.testing.assert_array_equal(getattr(again.fills, name), getattr(saved.fills, name), err_msg=name)


def test_origins_of_transforms() -> None:
    """Twice the size about the box's centre."""
    found = gradient(radial('gradientTransform="scale(2)" transform-origin=".5 50%"') + RECT.format(""))
    np.testing.assert_allclose(found.points, [(30, 45), (70, 45), (30, 95)])


def test_a_gradient_without_stops_gives_way_to_the_colour_behind_it() -> None:
    layers, left_out = walked(linear(stops="") + '<rect width="5" height="5" fill="url(#g) lime"/>')
    assert [layer.color for layer in layers] == [(0, 1, 0, 1)]
    assert list(left_out) == ["gradients of nothing, with another colour in their place"]


def test_servers_that_are_not_there() -> None:
    for fill, kind, color in (
        ("url(#none) lime", "references to nothing", [(0, 1, 0, 1)]),
        ("url(#none)", "references to nothing", []),
        ("url(#p) lime", "pattern fills", [(0, 1, 0, 1)]),
    ):
        layers, left_out = walked(f'<pattern id="p"/><rect width="5" height="5" fill="{fill}"/>')
        assert dict(left_out) == {kind: 1}
        assert [layer.color for layer in layers] == color


def test_many_stops_and_numbers_that_overflow_are_refused_or_read() -> None:
    with pytest.raises(SvgError, match="more than 1000 stops"):
        read_svg(document(linear(stops=STOPS * 600) + RECT.format("")))
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        for attributes in ('x1="1e300" x2="-1e300"', 'gradientTransform="scale(1e200)"', 'x2="1e-300"', 'x2="much"'):
            try:
                drawing = read_svg(document(linear(attributes) + RECT.format("")))
            except SvgError:
                continue
            assert np.isfinite(drawing.colors).all()
