# SPDX-License-Identifier: Apache-2.0
"""Groups, written and read: nested, with any names, and told apart where they follow each other."""

from __future__ import annotations

from xml.etree import ElementTree

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from support import drawings

from livecl.drawing import Drawing
from livecl.svg import format_svg, read_svg
from livecl.svg.groups import told_apart

LABEL = "{http://www.inkscape.org/namespaces/inkscape}label"
GROUP = "{http://www.w3.org/2000/svg}g"


def squares(groups: list[list[str]], stages: list[int] | None = None) -> Drawing:
    layers = [([drawings.rectangle(k, 0, k + 1, 1)], (1, 0, 0, 1)) for k in range(len(groups))]
    return drawings.build(layers, (5, len(groups) + 1)).replace(groups=groups, stages=stages or [0] * len(groups))


def labels(text: str) -> list[tuple[str | None, int]]:
    """Label of each group and how many elements it holds, in the order of the file."""
    root = ElementTree.fromstring(text)
    return [(group.get(LABEL), len(group)) for group in root.iter(GROUP)]


def test_nested_groups_are_written_and_come_back() -> None:
    drawing = squares([["face"], ["face", "eye"], ["face", "eye"], ["face"], [], ["mouth", "eye"]])
    text = format_svg(drawing, groups="thing")
    assert labels(text) == [("face", 3), ("eye", 2), ("mouth", 1), ("eye", 1)]
    assert "groupmode" not in text
    back = read_svg(text.encode())
    assert back.groups == drawing.groups
    assert format_svg(back, groups="thing") == text == format_svg(back)
    ids = [element.get("id") for element in ElementTree.fromstring(text).iter() if "id" in element.attrib]
    assert len(ids) == len(set(ids))


def test_kinds_of_groups() -> None:
    drawing = squares([["a"], ["a"], []], stages=[0, 1, 1])
    assert labels(format_svg(drawing, groups="stage")) == [("stage 1", 1), ("stage 2", 2)]
    assert labels(format_svg(drawing, groups="none")) == []
    assert labels(format_svg(drawing)) == [("a", 2)]
    assert labels(format_svg(drawing.replace(groups=None))) == [("stage 1", 1), ("stage 2", 2)]
    assert labels(format_svg(drawing.replace(groups=None), groups="thing")) == []
    assert labels(format_svg(drawing, layers="plain", groups="thing")) == []
    with pytest.raises(ValueError, match="groups: got 'things', wanted one of thing, stage, none"):
        format_svg(drawing, groups="things")  # type: ignore[arg-type]


def test_groups_of_an_editor() -> None:
    """Labels, titles and ids; nameless groups are none; two of one name that follow each other stay two."""
    body = (
        '<g inkscape:label="head" id="g1"><rect {}/><g id="eye"><rect {}/></g><g id="eye"><rect {}/></g></g>'
        "<g><title>body</title><g><rect {}/></g></g>" + 3 * '<g inkscape:label="arm"><rect {}/></g>'
    ).replace("{}", 'width="5" height="5"')
    namespaces = 'xmlns="http://www.w3.org/2000/svg" xmlns:inkscape="http://www.inkscape.org/namespaces/inkscape"'
    drawing = read_svg(f'<svg {namespaces} width="9" height="9">{body}</svg>'.encode())
    wanted = (("head",), ("head", "eye"), ("head", "eye 2"), ("body",), ("arm",), ("arm 2",), ("arm 3",))
    assert drawing.groups == wanted
    assert read_svg(format_svg(drawing).encode()).groups == wanted


def test_groups_of_one_name_are_told_apart_where_they_meet() -> None:
    a, b, eye = (1, "a"), (2, "a"), (3, "eye")
    assert told_apart([]) == []
    assert told_apart([[a], [a], [b]]) == [("a",), ("a",), ("a 2",)]
    assert told_apart([[a], [], [b]]) == [("a",), (), ("a",)]
    assert told_apart([[a, eye], [b, (4, "eye")]]) == [("a", "eye"), ("a 2", "eye")]


@settings(deadline=None, derandomize=True)
@given(st.lists(st.lists(st.text(), max_size=3), min_size=1, max_size=6))
def test_any_groups_come_back(groups: list[list[str]]) -> None:
    drawing = squares([*groups, ["stage 1", "background", '<&">']])
    text = format_svg(drawing, groups="thing")
    back = read_svg(text.encode())
    assert back.groups == drawing.groups
    assert format_svg(back, groups="thing") == text
    np.testing.assert_array_equal(back.stages, 0)


def test_very_deep_groups_are_cut() -> None:
    drawing = squares([[f"g{depth}" for depth in range(300)]])
    back = read_svg(format_svg(drawing).encode())
    assert 0 < len(back.groups[0]) < 300
