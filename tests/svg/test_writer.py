# SPDX-License-Identifier: Apache-2.0
"""Saving a `Drawing` as SVG: what the file says, what it loses, what comes back, what another renderer shows."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any, get_args
from xml.etree import ElementTree

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from livecl.drawing.assembly import empty_drawing
from livecl.drawing.colors import parse_color
from livecl.drawing.drawing import Drawing
from livecl.image.reading import over_background, read_image
from livecl.svg import LayerStyle, format_svg, quantize, read_svg, save_svg

SVG = "{http://www.w3.org/2000/svg}"
INKSCAPE = "{http://www.inkscape.org/namespaces/inkscape}"


def drawing_of(**arguments: Any) -> Drawing:
    """Return a drawing of whatever converts to the arrays."""
    return Drawing(**arguments)


def random_drawing(seed: int, background: bool = True, spread: float = 300.0) -> Drawing:
    """Return five layers of one to three subpaths, of one to eight segments each, in stages 0, 0, 1, 0 and 7."""
    rng = np.random.default_rng(seed)
    subpaths = rng.integers(1, 4, 5)
    segments = rng.integers(1, 9, subpaths.sum())
    return drawing_of(
        points=rng.normal(scale=spread, size=(segments.sum(), 3, 2)),
        colors=rng.random((5, 4)),
        size=(53, 47),
        background=rng.random(3) if background else None,
        subpath_offsets=np.cumsum([0, *segments]),
        layer_offsets=np.cumsum([0, *subpaths]),
        stages=np.array([0, 0, 1, 0, 7]),
    )


def square(x: float, y: float, side: float) -> NDArray[np.float64]:
    corners = np.array([[x, y], [x + side, y], [x + side, y + side], [x, y + side]])
    step = np.roll(corners, -1, axis=0) - corners
    return np.stack([corners, corners + step / 3, corners + 2 * step / 3], axis=1)


def assert_equal(got: Drawing, wanted: Drawing) -> None:
    assert got.size == wanted.size
    for name in ("points", "colors", "subpath_offsets", "layer_offsets", "stages"):
        np.testing.assert_array_equal(getattr(got, name), getattr(wanted, name), err_msg=name)
    assert (got.background is None) == (wanted.background is None)
    if got.background is not None and wanted.background is not None:
        np.testing.assert_array_equal(got.background, wanted.background)


def test_exact_text() -> None:
    drawing = drawing_of(
        points=np.concatenate([square(1, 2, 3), [[[-0.0001, 5.5], [6.25, 7], [8.12345, 9]]]]),
        colors=[[1, 0, 0, 1], [0.2, 0.4, 0.6, 0.5]],
        size=(20, 30),
        background=(1, 1, 1),
        subpath_offsets=[0, 4, 5],
        layer_offsets=[0, 1, 2],
        stages=[0, 1],
        names=["", 'it\'s <"mine">'],
    )
    assert format_svg(drawing) == (
        '<svg xmlns="http://www.w3.org/2000/svg" xmlns:inkscape="http://www.inkscape.org/namespaces/inkscape" '
        'width="30" height="20" viewBox="0 0 30 20">\n'
        '  <rect id="background" width="30" height="20" fill="#ffffff"/>\n'
        '  <g inkscape:groupmode="layer" inkscape:label="stage 1" id="stage-1">\n'
        '    <rect id="red-square-top-left" inkscape:label="red square top left" fill="#ff0000" '
        'x="1" y="2" width="3" height="3"/>\n'
        "  </g>\n"
        '  <g inkscape:groupmode="layer" inkscape:label="stage 2" id="stage-2">\n'
        '    <path id="it-s-mine-" inkscape:label="it\'s &lt;&quot;mine&quot;&gt;" '
        'fill="#336699" fill-opacity=".50196" d="M0 5.5c6.25 1.5 8.123 3.5 0 0Z"/>\n'
        "  </g>\n"
        "</svg>\n"
    )
    assert format_svg(drawing, 1, "plain") == (
        '<svg xmlns="http://www.w3.org/2000/svg" width="30" height="20" viewBox="0 0 30 20">\n'
        '  <rect id="background" width="30" height="20" fill="#ffffff"/>\n'
        '  <rect id="red-square-top-left" fill="#ff0000" '
        'x="1" y="2" width="3" height="3"/>\n'
        '  <path id="it-s-mine-" fill="#336699" fill-opacity=".50196" d="M0 5.5c6.2 1.5 8.1 3.5 0 0Z">'
        '<title>it\'s &lt;"mine"&gt;</title></path>\n'
        "</svg>\n"
    )


def test_structure_of_a_larger_drawing() -> None:
    drawing = random_drawing(1)
    root = ElementTree.fromstring(format_svg(drawing))
    assert (root.get("width"), root.get("height"), root.get("viewBox")) == ("47", "53", "0 0 47 53")
    assert [child.tag for child in root] == [f"{SVG}rect"] + 4 * [f"{SVG}g"]
    groups = root.findall(f"{SVG}g")
    assert [group.get(f"{INKSCAPE}label") for group in groups] == ["stage 1", "stage 2", "stage 1", "stage 8"]
    assert {group.get(f"{INKSCAPE}groupmode") for group in groups} == {"layer"}
    paths = root.findall(f".//{SVG}path")
    assert [path.get(f"{INKSCAPE}label") for path in paths] == list(drawing.labels)
    assert [path.get("id") for path in paths] == [label.replace(" ", "-") for label in drawing.labels]
    data = [path.get("d", "") for path in paths]
    assert [d.count("M") for d in data] == [d.count("Z") for d in data] == np.diff(drawing.layer_offsets).tolist()
    ids = [element.get("id") for element in root.iter() if "id" in element.attrib]
    assert len(ids) == len(set(ids))


@pytest.mark.parametrize("precision", range(10))
@pytest.mark.parametrize("background", [True, False])
def test_round_trip_is_exact(precision: int, background: bool) -> None:
    for seed in range(4):
        drawing = random_drawing(seed, background, spread=10.0 ** (seed + 1))
        held = quantize(drawing, precision)
        text = format_svg(drawing, precision)
        back = read_svg(text.encode())
        assert_equal(back, held)
        assert back.names == held.labels
        assert format_svg(back, precision) == text
        assert format_svg(held, precision) == text


@pytest.mark.parametrize("precision", range(10))
def test_round_trip_of_plain_files_keeps_all_but_stages(precision: int) -> None:
    drawing = random_drawing(precision, spread=99).replace(names=["", "eye", "eye", " left  eye ", "layer-3-x"])
    text = format_svg(drawing, precision, "plain")
    assert "inkscape" not in text and "<g" not in text
    back = read_svg(text.encode())
    held = quantize(drawing, precision)
    assert_equal(back, held.replace(stages=np.zeros(5)))
    assert back.names == held.labels
    assert format_svg(back, precision, "plain") == text


@settings(deadline=None, derandomize=True)
@given(st.lists(st.text(), min_size=1, max_size=5), st.sampled_from(["inkscape", "plain"]))
def test_any_name_comes_back(names: list[str], layers: LayerStyle) -> None:
    """Names of hostile files: quotes, markup, control characters, surrogates, and the forms of this program's ids."""
    names += [
        "background",
        "stage-1",
        "red-circle-left",
        "red circle left",
        "red-circle-left-2",
        "]]><x/>",
        "a\0\n\ud800b",
    ]
    drawing = drawing_of(
        points=np.tile(square(1, 1, 5), (len(names), 1, 1)),
        colors=len(names) * [(1, 0, 0, 1)],
        size=(9, 9),
        names=names,
    )
    text = format_svg(drawing, layers=layers)
    back = read_svg(text.encode())
    assert back.names == drawing.labels
    assert back.background is not None
    assert format_svg(back, layers=layers) == text
    ids = [element.get("id") for element in ElementTree.fromstring(text).iter() if "id" in element.attrib]
    assert len(ids) == len(set(ids))


def test_a_layer_called_background_stays_a_layer() -> None:
    drawing = drawing_of(
        points=square(0, 0, 9), colors=[[1, 1, 1, 1]], size=(9, 9), background=None, names=["background"]
    )
    for layers in get_args(LayerStyle):
        back = read_svg(format_svg(drawing, layers=layers).encode())
        assert (back.background, back.names) == (None, ("background",))


def test_long_and_far_outlines_are_written_absolute() -> None:
    """Where sums in float64 could stray from the written decimal, and only there."""
    rng = np.random.default_rng(0)
    for count, far, letter in ((2000, 100, "c"), (2000, 1e4, "C"), (3, 1e6, "C"), (30, 1e4, "c")):
        drawing = drawing_of(points=rng.uniform(-far, far, (count, 3, 2)), colors=[[0, 0, 0, 1]], size=(9, 9))
        text = format_svg(drawing)
        assert re.findall("[cC]", re.findall(' d="([^"]*)"', text)[0]) == [letter]
        assert_equal(read_svg(text.encode()), quantize(drawing))


def test_every_opacity_and_level_comes_back() -> None:
    levels = np.arange(256) / 255
    drawing = drawing_of(
        points=np.tile(square(1, 1, 5), (256, 1, 1)),
        colors=np.stack([levels, levels[::-1], levels, levels], axis=1),
        size=(9, 9),
    )
    np.testing.assert_array_equal(read_svg(format_svg(drawing).encode()).colors, drawing.colors)


def test_degenerate_outlines_come_back() -> None:
    """All points equal, no turn at all, a single segment, zero segments of zero length: kept as they are."""
    point, line = np.full((2, 3, 2), 4.5), np.array([[[1, 1], [2, 2], [3, 3]], [[4, 4], [3, 3], [2, 2]]])
    drawing = drawing_of(
        points=np.concatenate([point, line, point[:1]]),
        colors=np.full((3, 4), 0.2),
        size=(9, 9),
        subpath_offsets=[0, 2, 4, 5],
        layer_offsets=[0, 1, 2, 3],
    )
    assert_equal(read_svg(format_svg(drawing).encode()), quantize(drawing))


def test_largest_coordinates_come_back() -> None:
    points = np.array([[[1e6, -1e6], [999999.999999, 123456.789012], [-0.0004, 1e-9]]])
    drawing = drawing_of(points=points, colors=[[0, 0, 0, 1]], size=(9, 9))
    for precision in range(10):
        assert_equal(read_svg(format_svg(drawing, precision).encode()), quantize(drawing, precision))


def test_empty_drawings() -> None:
    for background in (None, (0.2, 0.4, 0.6)):
        drawing = empty_drawing((3, 5), background)
        assert_equal(read_svg(format_svg(drawing).encode()), drawing)


def test_layer_that_looks_like_the_background_stays_a_layer() -> None:
    drawing = drawing_of(points=square(0, 0, 9), colors=[[1, 1, 1, 1]], size=(9, 9), background=None)
    assert_equal(read_svg(format_svg(drawing).encode()), quantize(drawing))


def test_quantize() -> None:
    drawing = random_drawing(2)
    held = quantize(drawing, 2)
    assert np.abs(held.points - drawing.points).max() <= 0.005 + 1e-12
    assert np.abs(held.colors - drawing.colors).max() <= 0.5 / 255 + 1e-12
    np.testing.assert_array_equal(np.round(held.colors * 255) / 255, held.colors)
    assert_equal(quantize(held, 2), held)
    assert not np.any(np.signbit(quantize(drawing.replace(points=drawing.points * 0 - 1e-5)).points))


@pytest.mark.parametrize("precision", [-1, 10, 2.5])
def test_wrong_precision(precision: int) -> None:
    with pytest.raises(ValueError, match="precision"):
        format_svg(random_drawing(0), precision)


def test_wrong_layers() -> None:
    with pytest.raises(ValueError, match="layers: got 'flat', wanted one of inkscape, plain"):
        format_svg(random_drawing(0), layers="flat")  # type: ignore[arg-type]


def test_save(tmp_path: Path) -> None:
    drawing, path = random_drawing(3), tmp_path / "out.svg"
    path.write_text("old")
    save_svg(drawing, path, precision=1)
    assert path.read_bytes() == format_svg(drawing, 1).encode()
    assert_equal(read_svg(path), quantize(drawing, 1))
    assert_equal(read_svg(str(path)), quantize(drawing, 1))
    drawing.save_svg(path, 2, "plain")
    assert path.read_text(encoding="utf-8") == format_svg(drawing, 2, "plain")
    drawing.save_svg(path)
    assert path.read_text(encoding="utf-8") == drawing._repr_svg_() == format_svg(drawing)
    assert list(tmp_path.iterdir()) == [path]


def rendered(svg: str) -> NDArray[np.float32]:
    """Return what resvg shows, over white."""
    resvg_py = pytest.importorskip("resvg_py")
    return over_background(read_image(bytes(resvg_py.svg_to_bytes(svg_string=svg))), (1, 1, 1))


def test_shown_by_another_renderer() -> None:
    """A hole, a translucent layer above it, the background around."""
    hole = square(8, 8, 8)[::-1]
    hole = np.stack([hole[:, 0], hole[:, 0], np.roll(hole[:, 0], -1, axis=0)], axis=1)
    drawing = drawing_of(
        points=np.concatenate([square(4, 4, 16), hole, square(12, 12, 20)]),
        colors=[[1, 0, 0, 1], [0, 0, 1, 0.4]],
        size=(30, 40),
        background=(0.2, 0.8, 0.2),
        subpath_offsets=[0, 4, 8, 12],
        layer_offsets=[0, 2, 3],
    )
    image = rendered(format_svg(drawing))
    assert image.shape == (30, 40, 3)
    green, red, blue = np.array([0.2, 0.8, 0.2]), np.array([1.0, 0, 0]), np.array([0, 0, 1.0])
    expected = {
        (1, 1): green,
        (5, 5): red,
        (10, 10): green,
        (14, 14): 0.4 * blue + 0.6 * green,
        (18, 18): 0.4 * blue + 0.6 * red,
        (25, 25): 0.4 * blue + 0.6 * green,
        (25, 38): green,
    }
    for (row, column), color in expected.items():
        np.testing.assert_allclose(image[row, column], color, atol=1.5 / 255, err_msg=f"{row}, {column}")


@pytest.mark.parametrize(
    ("text", "rgb"),
    [
        ("white", (1, 1, 1)),
        (" Black ", (0, 0, 0)),
        ("rebeccapurple", (102 / 255, 51 / 255, 153 / 255)),
        ("#369", (0.2, 0.4, 0.6)),
        ("#336699", (0.2, 0.4, 0.6)),
        ("#336699FF", (0.2, 0.4, 0.6)),
        ("rgb(51, 102, 153)", (0.2, 0.4, 0.6)),
        ("rgb(20% 40% 60% / 100%)", (0.2, 0.4, 0.6)),
        ("hsl(120, 100%, 25%)", (0, 0.5, 0)),
    ],
)
def test_parse_color(text: str, rgb: tuple[float, float, float]) -> None:
    for _ in range(2):  # Pillow changes its table of names when one is looked up
        np.testing.assert_allclose(parse_color(text), rgb, atol=1e-12)


@pytest.mark.parametrize(
    "text",
    ["", "none", "whiteish", "#12", "#12345", "#ggg", "123", "rgb(1,2)", "rgb(1,nan,3)", "rgb(a,b,c)", "url(#a)"],
)
def test_parse_color_refuses(text: str) -> None:
    with pytest.raises(ValueError, match=re.escape(f"color: got {text!r}")):
        parse_color(text)


def test_parse_color_refuses_translucent_and_other_types() -> None:
    for text in ("transparent", "#3698", "rgba(1,2,3,0.5)"):
        with pytest.raises(ValueError, match="opaque"):
            parse_color(text)
    with pytest.raises(ValueError, match="color: got 3"):
        parse_color(3)  # type: ignore[arg-type]


def test_plain_svg_keeps_no_ids_for_groups_that_it_does_not_have() -> None:
    drawing = Drawing(
        points=np.zeros((2, 3, 2)), colors=np.ones((2, 4)), size=(9, 9), stages=[0, 1], names=["stage-2", "a"]
    )
    text = format_svg(drawing, layers="plain")
    assert '<path id="stage-2" ' in text
    assert format_svg(read_svg(text.encode()), layers="plain") == text
