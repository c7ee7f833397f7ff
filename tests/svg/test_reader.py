# SPDX-License-Identifier: Apache-2.0
"""Reading foreign SVG: lengths, transforms, colours, documents, warnings, refusals."""

from __future__ import annotations

import gzip
import math
import time
from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import ArrayLike, NDArray
from support.svg_documents import (
    SQUARE,
    assert_points,
    document,
    left_out,
    lines,
    quarter,
    read,
    read_path,
    shifted,
)

from livecl.errors import SvgError
from livecl.geometry import bezier
from livecl.image.reading import over_background, read_image
from livecl.svg import format_svg, read_svg


def test_lengths() -> None:
    """Percentages are of the viewport: of its width, its height, its diagonal over the root of 2."""
    drawing = read('<rect x="1in" y="72pt" width="10%" height="10%"/><circle r="10%"/>', 'width="300" height="400"')
    assert_points(
        drawing,
        lines((96, 96), (126, 96), (126, 136), (96, 136)),
        [quarter(i / 4, (0, 0), [math.hypot(300, 400) / math.sqrt(2) / 10] * 2) for i in range(4)],
    )


@pytest.mark.parametrize(
    ("transform", "corners"),
    [
        ("translate(10)", [(11, 2), (14, 2), (14, 6), (11, 6)]),
        ("translate(10,-2) scale(2)", [(12, 2), (18, 2), (18, 10), (12, 10)]),
        ("scale(2 -1)", [(2, -2), (8, -2), (8, -6), (2, -6)]),
        ("rotate(90)", [(-2, 1), (-2, 4), (-6, 4), (-6, 1)]),
        ("rotate(90 1 2)", [(1, 2), (1, 5), (-3, 5), (-3, 2)]),
        ("skewX(45)", [(3, 2), (6, 2), (10, 6), (7, 6)]),
        ("matrix(0 1 -1 0 5 6)", [(3, 7), (3, 10), (-1, 10), (-1, 7)]),
    ],
)
def test_transforms(transform: str, corners: Sequence[ArrayLike]) -> None:
    rect = '<rect x="1" y="2" width="3" height="4"{}/>'
    assert_points(read(rect.format(f' transform="{transform}"')), lines(*corners))
    assert_points(read(f'<g transform="{transform}"><g>{rect.format("")}</g></g>'), lines(*corners))


def test_transforms_nest_and_bend_curves() -> None:
    drawing = read('<g transform="translate(7 3)"><circle r="2" transform="scale(3 1)"/></g>')
    assert_points(drawing, [quarter(i / 4, (7, 3), (6, 2)) for i in range(4)])


@pytest.mark.parametrize(
    ("attributes", "size", "scale", "shift"),
    [
        ('width="100" height="50"', (50, 100), (1, 1), (0, 0)),
        ('width="99.2" height="50.0005"', (50, 100), (1, 1), (0, 0)),
        ('width="100" height="50" viewBox="0 0 50 25"', (50, 100), (2, 2), (0, 0)),
        ('width="100" height="50" viewBox="10 20 100 50"', (50, 100), (1, 1), (-10, -20)),
        ('width="100" height="50" viewBox="0 0 20 20"', (50, 100), (2.5, 2.5), (25, 0)),
        ('width="100" height="50" viewBox="0 0 20 20" preserveAspectRatio="none"', (50, 100), (5, 2.5), (0, 0)),
        ('width="100" height="50" viewBox="0 0 20 20" preserveAspectRatio="xMaxYMid"', (50, 100), (2.5, 2.5), (50, 0)),
        ('width="100" height="50" viewBox="0 0 20 20" preserveAspectRatio="xMidYMin slice"', (50, 100), (5, 5), (0, 0)),
        ('viewBox="0 0 40 30"', (30, 40), (1, 1), (0, 0)),
        ('width="100%" height="100%" viewBox="0 0 40 30"', (30, 40), (1, 1), (0, 0)),
        ('width="80" viewBox="0,0,40,30"', (60, 80), (2, 2), (0, 0)),
        ('width="1in" height="25.4mm"', (96, 96), (1, 1), (0, 0)),
    ],
)
def test_canvas(attributes: str, size: tuple[int, int], scale: Sequence[float], shift: Sequence[float]) -> None:
    drawing = read('<rect x="1" y="2" width="3" height="4"/>', attributes)
    assert drawing.size == size
    assert drawing.background is None
    assert_points(drawing, shifted(SQUARE * np.array(scale), *shift))


def test_use_symbol_and_nested_svg() -> None:
    drawing = read(
        '<defs><g id="a" fill="red"><rect x="1" y="2" width="3" height="4"/></g>'
        '<symbol id="s" viewBox="0 0 6 8"><rect x="1" y="2" width="3" height="4"/></symbol></defs>'
        '<use xlink:href="#a" x="10" y="20"/><use href="#s" width="12" height="16" fill="#0f0"/>'
        '<svg x="50" y="60" width="60" height="80" viewBox="0 0 6 8" overflow="visible">'
        '<use href="#a" transform="scale(2)"/></svg>'
    )
    assert_points(drawing, shifted(SQUARE, 10, 20), SQUARE * 2, shifted(SQUARE * 20, 50, 60))
    np.testing.assert_array_equal(drawing.colors, [[1, 0, 0, 1], [0, 1, 0, 1], [1, 0, 0, 1]])


RECT = '<rect width="9" height="9" {}/>'


@pytest.mark.parametrize(
    ("attributes", "rgba"),
    [
        ('fill="#336699"', (0.2, 0.4, 0.6, 1)),
        ('fill="#33669980"', (0.2, 0.4, 0.6, 128 / 255)),
        ('fill="rgba(51,102,153,.3)"', (0.2, 0.4, 0.6, 0.3)),
        ('fill="lime" fill-opacity="0.25"', (0, 1, 0, 0.25)),
        ('fill="lime" fill-opacity="25%" opacity="50%"', (0, 1, 0, 0.125)),
        ('fill="lime" opacity="7"', (0, 1, 0, 1)),
        ('fill="lime" style="fill:red; fill-opacity:.5"', (1, 0, 0, 0.5)),
        ('fill="currentColor" color="blue"', (0, 0, 1, 1)),
        ('fill="inherit"', (0, 0.5, 0, 1)),
        ('class="warm"', (1, 0, 0, 1)),
        ('class="cold warm" fill="lime"', (0, 0, 1, 1)),
        ('id="named"', (1, 1, 0, 1)),
        ('id="named" class="cold" style="fill:lime"', (0, 0, 1, 1)),
        ('class="warm" style="fill:lime!important"', (0, 1, 0, 1)),
    ],
)
def test_colours(attributes: str, rgba: Sequence[float]) -> None:
    sheet = "<style>/* {a */ .warm{fill:red} rect.cold, #nothing {fill: blue !important} #named{fill:yellow}</style>"
    drawing = read(f'<g fill="hsl(120 100% 25%)">{sheet}{RECT.format(attributes)}</g>')
    np.testing.assert_allclose(drawing.colors, np.array([rgba]), atol=1e-12)


def test_group_opacity_goes_into_layers() -> None:
    drawing = read(f'<g opacity="0.5"><g opacity=".5" fill-opacity=".5">{RECT.format("")}</g></g>')
    np.testing.assert_allclose(drawing.colors[:, 3], [0.125])
    apart = read('<g opacity="0.5"><rect width="9" height="9"/><rect x="20" width="9" height="9"/></g>')
    np.testing.assert_allclose(apart.colors[:, 3], [0.5, 0.5])
    drawing, names = left_out(f'<g opacity="0.5">{2 * RECT.format("")}</g>')
    assert names == "group opacity over overlapping shapes (1)"
    assert drawing.num_layers == 2


def test_what_is_not_shown_is_not_read() -> None:
    hidden = ('display="none"', 'visibility="hidden"', 'style="display:none"', 'fill="none"')
    shapes = "".join(RECT.format(attribute) for attribute in hidden)
    others = "<clipPath><rect/></clipPath><title>t</title><defs><path/></defs><g display='none'><text>a</text></g>"
    assert read(shapes + others).num_layers == 0


RING = "M0 0H40V40H0z M10 10{}z"


@pytest.mark.parametrize(("inner", "layers_area"), [("H30V30H10", 1200), ("V30H30V10", 1200)])
def test_even_odd_rings_become_nonzero_rings(inner: str, layers_area: float) -> None:
    drawing = read(f'<path fill-rule="evenodd" d="{RING.format(inner)}"/>')
    assert drawing.subpath_offsets.tolist() == [0, 4, 8]
    assert abs(bezier.signed_area(drawing.cubics)) == pytest.approx(layers_area)
    nonzero = read(f'<path d="{RING.format(inner)}"/>')
    assert abs(bezier.signed_area(nonzero.cubics)) == pytest.approx(2000 if inner[0] == "H" else 1200)


def test_even_odd_islands_and_separate_shapes() -> None:
    island = read('<path fill-rule="evenodd" d="M0 0H50V50H0z M10 10H40V40H10z M20 20H30V30H20z"/>')
    assert abs(bezier.signed_area(island.cubics)) == pytest.approx(2500 - 900 + 100)
    apart = read('<path fill-rule="evenodd" d="M1 2h3v4h-3z m10 0v4h3v-4z"/>')
    assert_points(apart, SQUARE, lines((11, 2), (11, 6), (14, 6), (14, 2)))


@pytest.mark.parametrize("data", ["M0 0H40V40H0z M20 20H60V60H20z M10 30H50V50H10z", "M50 5L80 95L5 35H95L20 95z"])
def test_even_odd_of_crossing_outlines_is_named(data: str) -> None:
    drawing, names = left_out(f'<path style="fill-rule:evenodd" d="{data}"/>')
    assert names == "even-odd fills of crossing outlines (1)"
    np.testing.assert_array_equal(drawing.points, read_path(data).points)


def test_what_cannot_be_represented_is_named_once_with_counts() -> None:
    drawing, names = left_out(
        '<pattern id="g"/><text>a</text><text>b</text>'
        '<image href="http://example.org/a.png"/><foreignObject/>'
        + RECT.format('fill="red" stroke-width="0" stroke="red"')
        + RECT.format('fill="url(#g)"')
        + RECT.format('fill="url(#g) lime"')
        + RECT.format('clip-path="url(#c)" mask="url(#m)" style="filter:blur(2px);mix-blend-mode:multiply"')
        + RECT.format('fill="nosuchcolour"')
        + '<rect width="9" height="9"><animate attributeName="x"/></rect><use href="#nothing"/>'
        + "<style>g > line {fill: red} g >> rect {fill: red} @import url(a.css); </style>"
    )
    assert names.split(", ") == sorted(
        [
            "text (2)",
            "images (1)",
            "foreign objects (1)",
            "pattern fills (2)",
            "clips (1)",
            "masks (1)",
            "filters (1)",
            "blend modes (1)",
            "unknown colours (1)",
            "animations (1)",
            "references to nothing (1)",
            "style rules (2)",
        ]
    )
    black, lime = (0, 0, 0, 1), (0, 1, 0, 1)
    np.testing.assert_array_equal(drawing.colors, [(1, 0, 0, 1), lime, black, black, black])


def test_background() -> None:
    cover = '<rect id="background" width="100" height="100" fill="#369" {}/>'
    for body in (cover.format(""), cover.format('transform="translate(-5 -5) scale(1.2)"')):
        drawing = read(body + RECT.format(""))
        assert drawing.background is not None
        np.testing.assert_allclose(drawing.background, [0.2, 0.4, 0.6])
        assert drawing.num_layers == 1
    for body in (
        cover.format('opacity="0.5"'),
        cover.format('transform="scale(.9)"'),
        cover.format('transform="rotate(45) translate(-150 -150) scale(3)"'),
        cover.format('rx="5"'),
        RECT.format("") + cover.format(""),
    ):
        drawing = read(body)
        assert drawing.background is None
        assert drawing.num_layers == body.count("<rect")


def test_stages_survive_an_editor() -> None:
    drawing = read(
        '<g inkscape:groupmode="layer" inkscape:label="stage 3"><g><rect width="5" height="5"/></g></g>'
        '<g inkscape:label="stage 2"><rect width="5" height="5"/></g>',
        'width="9" height="9" xmlns:inkscape="http://www.inkscape.org/namespaces/inkscape"',
    )
    assert drawing.stages.tolist() == [2, 0]


def test_document_without_namespace_and_with_a_public_doctype() -> None:
    doctype = '<!DOCTYPE svg PUBLIC "-//W3C//DTD SVG 1.1//EN" "http://www.w3.org/Graphics/SVG/1.1/DTD/svg11.dtd">'
    data = f'<?xml version="1.0" encoding="UTF-16"?>{doctype}<svg width="9" height="8"><path d="M1 2H4V6H1z"/></svg>'
    drawing = read_svg(data.encode("utf-16"))
    assert drawing.size == (8, 9)
    assert_points(drawing, SQUARE)


@pytest.mark.parametrize(
    "body",
    [
        '<path d="m10 10 20 0 0 20-20 0z m30 0h20v20h-20z" fill="teal"/><path d="M60 60a15 10 30 1 1 20 10z"/>',
        '<rect x="5" y="5" width="30" height="20" rx="6" fill="red"/><circle cx="60" cy="30" r="20" fill="#00f8"/>'
        '<ellipse cx="30" cy="55" rx="20" ry="10" fill="hsl(120,50%,40%)" transform="rotate(20 30 55)"/>',
        '<path fill-rule="evenodd" d="M10 10h60v60h-60zM20 20h40v40h-40zM30 30h10v10h-10z" opacity=".7"/>',
        '<defs><symbol id="s" viewBox="0 0 10 10"><circle cx="5" cy="5" r="5"/></symbol></defs><use href="#s" x="40" '
        'y="40" width="30" height="40" fill="blue" opacity=".5"/><svg x="70" y="5" width="20" height="20" '
        'viewBox="0 0 4 4"><path d="M0 0h4v4z"/></svg>',
        '<path d="M5 80c5-10 10 10 15 0s10 10 15 0v15H5" fill="purple" transform="skewY(10) scale(1.3 1)"/>',
    ],
)
def test_shown_like_the_original(body: str) -> None:
    resvg_py = pytest.importorskip("resvg_py")

    def rendered(svg: str) -> NDArray[np.float32]:
        return over_background(read_image(bytes(resvg_py.svg_to_bytes(svg_string=svg))), (1, 1, 1))

    original = document(body)
    shown, saved = rendered(original.decode()), rendered(format_svg(read_svg(original)))
    assert (shown < 1).any(axis=2).mean() > 0.05
    np.testing.assert_allclose(saved, shown, atol=0.07)  # one step of resvg's 16 levels of coverage


def test_layers_that_leave_their_viewport_are_named() -> None:
    inner = '<svg x="5" y="5" width="20" height="20"{}><rect width="{}" height="20"/></svg>'
    assert read(inner.format("", 20)).num_layers == 1
    assert read(inner.format(' overflow="visible"', 21)).num_layers == 1
    assert left_out(inner.format("", 21))[1] == "clips (1)"
    symbol = (
        '<symbol id="s" viewBox="0 0 9 9"><rect width="10" height="5"/></symbol><use href="#s" width="9" height="9"/>'
    )
    assert left_out(symbol)[1] == "clips (1)"


def test_units_of_the_font_and_the_canvas() -> None:
    drawing = read('<g style="font:bold 20px/1.5 serif"><rect x=".1em" y=".2ex" width=".15em" height=".4ex"/></g>')
    assert_points(drawing, lines((2, 2), (5, 2), (5, 6), (2, 6)))
    drawing = read('<g font-size="xx-large"><g font-size="50%"><rect width="1em" height="2ex"/></g></g>')
    assert_points(drawing, lines((0, 0), (16, 0), (16, 16), (0, 16)))
    drawing, names = left_out('<rect x="1vw" y="2vh" width="3vmin" height="4vmax"/><rect width="1rem" height="1ch"/>')
    assert_points(drawing, SQUARE, lines((0, 0), (16, 0), (16, 8), (0, 8)))
    assert names == "lengths in units of the page or of the font's letters (6)"


@pytest.mark.parametrize(
    ("attributes", "size", "guess"),
    [
        ('height="80"', (80, 300), True),
        ("", (150, 300), True),
        ('width="50%" height="40"', (40, 150), True),
        ('width="2em" height="1em"', (16, 32), False),
        ('width="2em" font-size="10" viewBox="0 0 9 9"', (20, 20), False),
        ('style="width:30px;height:20px"', (20, 30), False),
    ],
)
def test_sizes_by_default(attributes: str, size: tuple[int, int], guess: bool) -> None:
    if guess:
        with pytest.warns(UserWarning, match="sides of the canvas, not stated and taken as 300 by 150 px"):
            assert read_svg(document("", attributes)).size == size
    else:
        assert read("", attributes).size == size


def test_background_color_of_the_root() -> None:
    for style in ("background-color:#369", "background: rgb(51 102 153)", "background-color:currentColor;color:#369"):
        drawing = read(RECT.format(""), f'width="100" height="50" viewBox="5 5 9 9" style="{style}"')
        np.testing.assert_allclose(drawing.background, [0.2, 0.4, 0.6])
        assert drawing.num_layers == 1
    drawing = read(RECT.format(""), 'width="100" height="50" style="background-color:#0000ff80"')
    assert drawing.background is None
    np.testing.assert_allclose(drawing.colors, [[0, 0, 1, 128 / 255], [0, 0, 0, 1]])
    np.testing.assert_allclose(drawing.points[:4], lines((0, 0), (100, 0), (100, 50), (0, 50)), atol=1e-9)
    with pytest.warns(UserWarning, match=r"backgrounds \(1\)"):
        read_svg(document("", 'width="9" height="9" style="background:url(a.png)"'))
    assert read("", 'width="9" height="9" background-color="red"').background is None


@pytest.mark.parametrize(
    ("attribute", "shown"),
    [
        ('systemLanguage="ru"', False),
        ('systemLanguage="ru, en-GB"', True),
        ('systemLanguage=""', False),
        ('requiredExtensions="http://example.org/"', False),
        ('requiredExtensions=""', False),
        ('requiredFeatures="http://www.w3.org/TR/SVG11/feature#Shape"', True),
        ('requiredFeatures="http://www.w3.org/TR/SVG11/feature#Shape nothing"', False),
        ('requiredFeatures="http://www.w3.org/TR/SVG11/feature#Script"', False),
    ],
)
def test_conditions_hold_on_every_element(attribute: str, shown: bool) -> None:
    rect = '<rect width="5" height="5" {}/>'
    assert read(rect.format(attribute)).num_layers == shown
    assert read(f"<g {attribute}>{rect.format('')}</g>").num_layers == shown
    assert read("", f'width="9" height="9" style="background-color:red" {attribute}').background is None or shown
    assert (
        read(f'<defs>{rect.format(attribute + " id=" + chr(34) + "a" + chr(34))}</defs><use href="#a"/>').num_layers
        == shown
    )


def test_a_use_of_itself_is_named_and_left_out() -> None:
    rect = '<rect width="5" height="5"/>'
    drawing, names = left_out(f'<g id="a">{rect}<use href="#a" x="5"/></g>')
    assert (drawing.num_layers, names) == (1, "uses of themselves (1)")
    drawing, names = left_out(f'<g id="a">{rect}<use href="#b"/></g><g id="b">{rect}<use href="#a"/></g>')
    assert (drawing.num_layers, names) == (4, "uses of themselves (2)")
    assert left_out('<use id="a" href="#a"/>')[1] == "uses of themselves (1)"
    assert read(f'<g id="a">{rect}</g><use href="#a"/><use href="#a"/>').num_layers == 3
    assert left_out("<use/>")[1] == "references to nothing (1)"


@pytest.mark.parametrize("encoding", ["utf-8", "utf-16"])
def test_internal_entities(encoding: str) -> None:
    rect = "<rect width='3' height='4' fill='&c;'/>"
    values = {"svg": "http://www.w3.org/2000/svg", "c": "r&e;", "e": "ed", "r": rect}
    entities = "".join(f'<!ENTITY {name} "{value}">' for name, value in values.items())
    body = '<svg xmlns="&svg;" width="9" height="9">&r;<g transform="translate(1 2)">&r;</g></svg>'
    text = f"<!DOCTYPE svg [{entities}]>{body}"
    drawing = read_svg(text.encode(encoding))
    assert_points(drawing, shifted(SQUARE, -1, -2), SQUARE)
    np.testing.assert_array_equal(drawing.colors, [[1, 0, 0, 1]] * 2)


def test_compressed_files(tmp_path: Path) -> None:
    path = tmp_path / "square.svgz"
    data = gzip.compress(document('<path d="M1 2h3v4h-3z"/>'))
    path.write_bytes(data)
    assert_points(read_svg(path), SQUARE)
    assert_points(read_svg(data), SQUARE)
    with pytest.raises(SvgError, match=r"not a whole XML document|damaged"):
        read_svg(data[:-20])
    with pytest.raises(SvgError, match="damaged"):
        read_svg(data[:12] + b"\xff" * 40)


def test_edges_without_antialiasing_are_named() -> None:
    for word in ("crispEdges", "optimizeSpeed"):
        assert left_out(f'<circle r="9" shape-rendering="{word}"/>')[1] == "edges without antialiasing (1)"
        assert read(f'<rect width="9" height="9" shape-rendering="{word}"/>').num_layers == 1
    assert read('<circle r="9" shape-rendering="geometricPrecision"/>').num_layers == 1


def test_many_layers_are_read_in_a_second() -> None:
    """1 856 even-odd rings with arcs, by classes: .6 s on one core; 2 s leave room for a busy machine."""
    ring = "h20v20h-20z m2 2v16h16v-16z m8 2a3 3 0 1 0 1 0z"
    path = '<path class="a{}" fill-rule="evenodd" d="M{} {}{}" transform="scale(.5)"/>'
    paths = "".join(path.format(i % 99, i % 80, i % 70, ring) for i in range(1856))
    sheet = "".join(f".a{i}{{fill:#12{i:02}ff;opacity:.5}}" for i in range(99))
    start = time.process_time()
    assert read(f"<style>{sheet}</style>{paths}").num_layers == 1856
    assert time.process_time() - start < 2


def test_use_states_the_size_of_an_svg() -> None:
    drawing = read(
        '<defs><svg id="s" viewBox="0 0 2 2" width="9"><rect width="2" height="2"/></svg></defs>'
        '<use href="#s" x="1" width="10" height="10"/>'
    )
    assert_points(drawing, lines((1, 0), (11, 0), (11, 10), (1, 10)))


def test_switch_shows_the_first_that_fits() -> None:
    drawing = read(
        '<switch><foreignObject requiredExtensions="x"/><rect systemLanguage="de, fr" width="1" height="1"/>'
        '<rect systemLanguage="de,en-GB" width="2" height="2"/><rect width="3" height="3"/></switch>'
    )
    assert_points(drawing, lines((0, 0), (2, 0), (2, 2), (0, 2)))


@pytest.mark.parametrize(
    ("style", "shift"),
    [
        ("transform-origin:4px 6px", (3, 4)),
        ("transform-origin:100% 50%", (99, 48)),
        ("transform-origin:top right", (99, -2)),
        ("transform-origin:bottom", (49, 98)),
        ("transform-box:view-box;transform-origin:left 6px", (-1, 4)),
    ],
)
def test_transform_origins(style: str, shift: tuple[float, float]) -> None:
    """Half a turn about the origin takes the square's corner (1, 2), whose shift from it is given, to the far side."""
    drawing = read(f'<rect x="1" y="2" width="3" height="4" style="{style};transform:rotate(.5turn)"/>')
    corner = np.add((1, 2), np.multiply(shift, 2))
    assert_points(
        drawing, lines(*(2 * corner - corner - np.subtract(p, (1, 2)) for p in ((1, 2), (4, 2), (4, 6), (1, 6))))
    )
    names = left_out(
        '<rect width="9" height="9" style="transform-box:fill-box;transform-origin:0 0" transform="scale(2)"/>'
    )
    assert names[1] == "transform origins (1)"


def test_at_rules_do_not_swallow_the_rule_behind_them() -> None:
    sheet = '<style>@charset "utf-8"; @import url(a.css); rect {{fill: red}}</style>'
    drawing, names = left_out(sheet.replace("{{", "{").replace("}}", "}") + RECT.format(""))
    assert names == "style rules (1)"
    np.testing.assert_array_equal(drawing.colors, [[1, 0, 0, 1]])


def test_names() -> None:
    """The label, or the title, or the id; without line breaks, and with the spaces of this program's own ids."""
    bodies = {
        '<rect {} id="a" inkscape:label="the &lt;b&gt; layer"><title>t</title></rect>': "the <b> layer",
        '<rect {} id="a"><title> some\n <tspan>title</tspan></title></rect>': "some title",
        '<rect {} id="a"><title> </title></rect>': "a",
        '<rect {} id="layer-07-dark-blue-left"/>': "layer-07 dark blue left",
        "<rect {}/>": "",
    }
    drawing = read(
        "".join(bodies).replace("{}", 'width="5" height="5"'),
        'width="9" height="9" xmlns:inkscape="http://www.inkscape.org/namespaces/inkscape"',
    )
    assert drawing.names == tuple(bodies.values())


def test_errors_and_warnings_name_the_file(tmp_path: Path) -> None:
    with pytest.raises(SvgError, match=r"nowhere\.svg: No such file"):
        read_svg(tmp_path / "nowhere.svg")
    with pytest.raises(SvgError, match="directory"):
        read_svg(tmp_path)
    path = tmp_path / "text.svg"
    path.write_bytes(document("<text>a</text>"))
    with pytest.warns(UserWarning, match=r"text\.svg: .*text \(1\)"):
        read_svg(path)
