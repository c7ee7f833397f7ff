# SPDX-License-Identifier: Apache-2.0
"""Elements of foreign SVG: shown and hidden ones, uses and symbols, switches and conditions."""

from __future__ import annotations

import numpy as np
import pytest
from support.svg_documents import (
    SQUARE,
    assert_points,
    left_out,
    lines,
    read,
    shifted,
)

RECT = '<rect width="9" height="9" {}/>'


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


def test_layers_that_leave_their_viewport_are_named() -> None:
    inner = '<svg x="5" y="5" width="20" height="20"{}><rect width="{}" height="20"/></svg>'
    assert read(inner.format("", 20)).num_layers == 1
    assert read(inner.format(' overflow="visible"', 21)).num_layers == 1
    assert left_out(inner.format("", 21))[1] == "clips (1)"
    symbol = (
        '<symbol id="s" viewBox="0 0 9 9"><rect width="10" height="5"/></symbol><use href="#s" width="9" height="9"/>'
    )
    assert left_out(symbol)[1] == "clips (1)"


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
