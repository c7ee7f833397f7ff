# SPDX-License-Identifier: Apache-2.0
"""Reading foreign SVG: documents, colours, backgrounds, names, warnings, refusals."""

from __future__ import annotations

import gzip
import time
from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray
from support.svg_documents import (
    SQUARE,
    assert_points,
    document,
    left_out,
    lines,
    read,
    shifted,
)

from livecl.errors import SvgError
from livecl.image.reading import over_background, read_image
from livecl.svg import format_svg, read_svg

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


def test_the_time_to_read_layers_grows_with_their_number() -> None:
    """Even-odd rings with arcs, by classes: four times as many take four times as long, not sixteen times."""
    ring = "h20v20h-20z m2 2v16h16v-16z m8 2a3 3 0 1 0 1 0z"
    path = '<path class="a{}" fill-rule="evenodd" d="M{} {}{}" transform="scale(.5)"/>'
    sheet = "".join(f".a{i}{{fill:#12{i:02}ff;opacity:.5}}" for i in range(99))
    seconds = []
    for count in (464, 464, 1856):  # the first time, modules are loaded
        paths = "".join(path.format(i % 99, i % 80, i % 70, ring) for i in range(count))
        start = time.process_time()
        assert read(f"<style>{sheet}</style>{paths}").num_layers == count
        seconds.append(time.process_time() - start)
    assert seconds[2] < 8 * seconds[1]


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
        '<rect {} id="dark-blue-to-red-circle-top-left-2"/>': "dark blue to red circle top left 2",
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
