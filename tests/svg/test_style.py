# SPDX-License-Identifier: Apache-2.0
"""The cascade: selectors, at-rules, importance, values that CSS ignores, words for all properties."""

from __future__ import annotations

import numpy as np
import pytest
from support.svg_documents import left_out, read

from livecl.drawing import Drawing

COLORS = {"red": (1, 0, 0, 1), "lime": (0, 1, 0, 1), "blue": (0, 0, 1, 1), "black": (0, 0, 0, 1)}
BODY = (
    '<g id="a" class="big"><rect width="5" height="5" class="warm x"/><circle r="5" data-n="one two"/></g>'
    '<g id="b"><rect width="5" height="5" class="cold"/><rect width="6" height="5"/></g>'
)


def assert_colors(drawing: Drawing, *names: str) -> None:
    np.testing.assert_array_equal(drawing.colors, [COLORS[name] for name in names])


@pytest.mark.parametrize(
    ("selector", "matching"),
    [
        ("rect", "0 2 3"),
        ("g rect", "0 2 3"),
        ("svg > rect", ""),
        ("g > .cold", "2"),
        ("#a rect", "0"),
        ("rect + rect", "3"),
        ("rect ~ circle", "1"),
        ("rect:first-child", "0 2"),
        ("#b > :nth-child(2)", "3"),
        ("g > :last-child:not(circle)", "3"),
        ("[data-n]", "1"),
        ("[data-n~=two]", "1"),
        ("[width='6']", "3"),
        (".warm.x, .none, circle", "0 1"),
        ("*", "0 1 2 3"),
        (".WARM", ""),
        ("/* a comment */ .warm", "0"),
        ("rect:hover, rect::before", ""),
        ("g:has(circle) rect", "0"),
        (":root rect:is(.warm, .cold)", "0 2"),
    ],
)
def test_selectors(selector: str, matching: str) -> None:
    drawing = read(f"<style>{selector.replace('>', '&gt;')} {{fill: red}}</style>{BODY}")
    assert [i for i in range(4) if drawing.colors[i, 0] == 1] == [int(i) for i in matching.split()]


def test_specificity_order_and_importance() -> None:
    rect = '<rect id="i" class="c" width="5" height="5" fill="black" {}/>'
    for sheet, attribute, color in (
        ("#i{fill:red} .c{fill:lime} rect{fill:blue}", "", "red"),
        (".c{fill:red} .c{fill:lime}", "", "lime"),
        (".c{fill:lime;fill:nosuch}", "", "lime"),
        ("rect{fill:lime!important} #i{fill:red}", "", "lime"),
        ("#i{fill:red}", 'style="fill:lime"', "lime"),
        ("#i{fill:red ! important}", 'style="fill:lime"', "red"),
        ("#i{fill:red!important}", 'style="fill:lime!important"', "lime"),
        ("g #i{fill:red} svg #i{fill:lime} #i{fill:blue}", "", "lime"),
    ):
        if "nosuch" in sheet:
            drawing, names = left_out(f"<style>{sheet}</style><g>{rect.format(attribute)}</g>")
            assert names == "unknown colours (1)"
        else:
            drawing = read(f"<style>{sheet}</style><g>{rect.format(attribute)}</g>")
        assert_colors(drawing, color)


def test_comments_and_semicolons_in_style_attributes() -> None:
    for style in (
        "/* brand */fill:lime",
        "fill:/**/lime/**/",
        ";;fill : lime;",
        "fill:lime;/*",
        "FILL:LIME",
        "o:;fill:lime",
    ):
        assert_colors(read(f'<rect width="5" height="5" style="{style}"/>'), "lime")
    assert_colors(read('<rect width="5" height="5" style="fill:rgb(/* r */ 0 255 0)"/>'), "lime")


@pytest.mark.parametrize(
    ("attributes", "applies"),
    [
        ("", True),
        ('type="text/css"', True),
        ('type="text/css; charset=utf-8"', True),
        ('type=""', True),
        ('type="text/x-other"', False),
        ('media="screen"', True),
        ('media="all"', True),
        ('media="print"', False),
        ('media="print, screen"', True),
    ],
)
def test_types_and_media_of_sheets(attributes: str, applies: bool) -> None:
    drawing = read(f'<style {attributes}>rect{{fill:lime}}</style><rect width="5" height="5" fill="red"/>')
    assert_colors(drawing, "lime" if applies else "red")


def test_at_rules() -> None:
    rect = '<rect width="5" height="5"/>'
    sheet = '@charset "utf-8"; @font-face{src:url(a)} @media screen{rect{fill:lime}} @media print{rect{fill:red}}'
    assert_colors(read(f"<style>{sheet} @media (prefers-color-scheme:dark){{rect{{fill:red}}}}</style>{rect}"), "lime")
    namespace = "@namespace s url(http://www.w3.org/2000/svg); s|rect{fill:lime}"
    assert_colors(read(f"<style>{namespace}</style>{rect}"), "lime")
    unknown = (
        "@import url(a.css); @supports (fill:red){rect{fill:red}} @media (width>9px){rect{fill:red}} rect{fill:lime}"
    )
    drawing, names = left_out(f"<style><![CDATA[{unknown} rect{{&amp; g{{fill:red}}}}]]></style>{rect}")
    assert names == "style rules (4)"
    assert_colors(drawing, "lime")
    assert left_out(f"<style>@keyframes a{{from{{fill:red}}}}</style>{rect}")[1] == "animations (1)"


def test_words_for_all_properties() -> None:
    """inherit, initial and unset, of a property that is inherited and of one that is not."""
    rect = '<g fill="lime" opacity=".5"><rect width="5" height="5" {}/></g>'
    for attributes, rgba in (
        ('fill="inherit"', (0, 1, 0, 0.5)),
        ('style="fill:initial"', (0, 0, 0, 0.5)),
        ('style="fill:unset"', (0, 1, 0, 0.5)),
        ('style="opacity:inherit"', (0, 1, 0, 0.25)),
        ('opacity=".1" style="opacity:initial"', (0, 1, 0, 0.5)),
        ('fill="blue" style="fill:Inherit"', (0, 1, 0, 0.5)),
    ):
        np.testing.assert_allclose(read(rect.format(attributes)).colors, [rgba])


def test_words_are_read_in_capitals_too() -> None:
    square = '<path d="M0 0h9v9h-9z M2 2h4v4h-4z" style="{}"/>'
    assert read(square.format("display:NONE")).num_layers == read(square.format("visibility:Hidden")).num_layers == 0
    even_odd = read(square.format("fill-rule:EvenOdd"))
    assert np.array_equal(even_odd.points, read(square.format("fill-rule:evenodd")).points)
    assert not np.array_equal(even_odd.points, read(square.format("")).points)
    assert_colors(read(f'<g color="RED">{square.format("fill:CurrentColor")}</g>'), "red")


def test_unknown_values_are_ignored_and_named() -> None:
    """As CSS has it, an inherited or earlier value stays."""
    for attributes, kind in (
        ('fill="nosuch"', "unknown colours"),
        ('style="fill:lime;fill:rgb(1,2)"', "unknown colours"),
        ('fill="rgba(0, 50%, 0, .5)"', "unknown colours"),
        ('style="fill-opacity:much"', "unknown values of properties"),
    ):
        drawing, names = left_out(f'<g fill="lime"><rect width="5" height="5" {attributes}/></g>')
        assert names == f"{kind} (1)"
        assert_colors(drawing, "lime")


def test_geometry_in_css() -> None:
    drawing = read('<style>rect{width:3px;height:4px;x:1px}</style><rect x="9" y="2" width="1"/>')
    np.testing.assert_allclose(drawing.points[:, 0], [[1, 2], [4, 2], [4, 6], [1, 6]])
    assert read('<polygon points="0 0 5 0 5 5" style="points:1"/>').num_layers == 1
    drawing, names = left_out('<rect width="5" height="5" style="width:much;height:;x:1;y:2"/>')
    np.testing.assert_allclose(drawing.points[:, 0], [[1, 2], [6, 2], [6, 7], [1, 7]])
    assert names == "unknown values of properties (2)"
