# SPDX-License-Identifier: Apache-2.0
"""Names of layers: what they are called, how they are kept, how they are found."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from support import drawings, shapes
from support.states import load, save

from livecl.drawing.assembly import concatenate, empty_drawing
from livecl.drawing.checks import MAX_NAME, clean_name
from livecl.drawing.colors import format_rgb, oklab
from livecl.drawing.drawing import Drawing
from livecl.drawing.fills import Fills, concatenate_fills
from livecl.drawing.labels import layer_centers
from livecl.geometry import bezier
from livecl.options import Options
from livecl.run.progress import Progress
from livecl.svg import format_svg, read_svg

ORANGE, WHITE, NAVY = (1.0, 0.5, 0.0, 1.0), (1.0, 1.0, 1.0, 1.0), (0.0, 0.0, 128 / 255, 1.0)


def three_layers() -> Drawing:
    layers = [
        ([drawings.rectangle(0, 0, 90, 60)], WHITE),
        ([shapes.circle((10, 30), 5)], ORANGE),
        ([shapes.circle((80, 55), 5)], NAVY),
    ]
    return drawings.build(layers, (60, 90))


def test_labels_say_colour_shape_and_place() -> None:
    drawing = three_layers()
    assert drawing.names == ("", "", "")
    assert drawing.labels == ("white rectangle center", "orange circle left", "dark blue circle bottom right")
    assert drawing.replace(names=["", "sun", ""]).labels[1] == "sun"
    assert empty_drawing((3, 3)).labels == ()


@pytest.mark.parametrize(
    ("column", "row", "place"),
    [
        (column, row, place)
        for row, places in enumerate(
            [["top left", "top", "top right"], ["left", "center", "right"], ["bottom left", "bottom", "bottom right"]]
        )
        for column, place in enumerate(places)
    ],
)
def test_places(column: int, row: int, place: str) -> None:
    """The thirds of a canvas of 90 x 30 px; beyond its edge counts as at it."""
    center = (15 + 30 * column + 50 * (column - 1), 5 + 10 * row)
    drawing = drawings.build([([shapes.circle(center, 2)], ORANGE)], (30, 90))
    assert drawing.labels == (f"orange circle {place}",)


@pytest.mark.parametrize(
    ("offset", "place"),
    [
        ((0, 0), "center"),
        ((-5, 4), "center"),
        ((-9, 4), "left of center"),
        ((9, -8), "right of center"),
        ((3, -9), "above center"),
        ((-3, 9), "below center"),
        ((17, 0), "right"),
    ],
)
def test_places_about_the_center(offset: tuple[int, int], place: str) -> None:
    drawing = drawings.build([([shapes.circle((45 + offset[0], 45 + offset[1]), 2)], ORANGE)], (90, 90))
    assert drawing.labels == (f"orange circle {place}",)
    saved = read_svg(format_svg(drawing, layers="plain").encode())
    assert saved.names == drawing.labels


def test_equal_labels_are_numbered_and_names_are_not_taken_twice() -> None:
    drawing = drawings.build(4 * [([shapes.circle((15, 15), 5)], ORANGE)], (30, 30))
    assert drawing.labels == (
        "orange circle center",
        "orange circle center 2",
        "orange circle center 3",
        "orange circle center 4",
    )
    named = drawing.replace(names=["", "", "orange circle center 2", ""])
    assert named.labels[1] == "orange circle center 3"
    assert len(set(named.labels)) == 4


def test_labels_stay_where_a_layer_comes_or_goes() -> None:
    """Nothing in a name counts layers, so ids of nearly equal drawings are the same."""
    drawing = three_layers()
    for kept in ([1, 2], [0, 2], [2, 1, 0]):
        assert drawing.layer_subset(kept).labels == tuple(drawing.labels[layer] for layer in kept)


def test_oklab_of_known_colours() -> None:
    """The values that the definition's author gives for white, and for sRGB's red (to the digits given)."""
    np.testing.assert_allclose(oklab([1, 1, 1]), [1, 0, 0], atol=1e-4)
    np.testing.assert_allclose(oklab([1, 0, 0]), [0.628, 0.225, 0.126], atol=5e-4)
    np.testing.assert_allclose(oklab([0.5, 0.5, 0.5])[1:], 0, atol=1e-4)


def test_format_rgb() -> None:
    assert format_rgb([1, 0.5, 0, 0.3]) == "#ff8000"


def test_centers_are_those_of_the_area() -> None:
    half = drawings.polygon([(0, 0), (9, 0), (0, 9)])
    ring = [drawings.rectangle(0, 0, 9, 9), drawings.reverse(drawings.rectangle(6, 0, 9, 9))]
    eight = drawings.polygon([(0, 0), (9, 9), (9, 0), (0, 9)])
    point = np.tile((7.0, 6.0), (4, 3, 1))
    drawing = drawings.build([([half], WHITE), (ring, WHITE), ([eight], WHITE), ([point], WHITE)], (9, 9))
    # A triangle's centre; of a rectangle of 6 x 9; two loops of opposite turn and a point: the box's middle.
    np.testing.assert_allclose(layer_centers(drawing), [[3, 3], [3, 4.5], [4.5, 4.5], [7, 6]], rtol=1e-12)


def test_area_moments_of_curves() -> None:
    """Against the signed area, exactly, and the sum over the triangles of a fine polygon (error about 1/count^2)."""
    cubics = drawings.build([([drawings.blob(3, (20, 30), 9)], WHITE)], (60, 60)).cubics
    area, x_moment, y_moment = bezier.area_moments(cubics).sum(axis=0)
    assert area == pytest.approx(bezier.signed_area(cubics), rel=1e-12)
    corners = bezier.evaluate(cubics, np.arange(1000) / 1000).reshape(-1, 2)
    after = np.roll(corners, -1, axis=0)
    double = corners[:, 0] * after[:, 1] - corners[:, 1] * after[:, 0]
    wanted = ((corners + after) * double[:, None]).sum(axis=0) / 6
    np.testing.assert_allclose([x_moment, y_moment], wanted, rtol=1e-5)


@pytest.mark.parametrize(
    ("text", "name"),
    [
        ("", ""),
        (" a  b ", "a b"),
        ("a\nb\t\x00c\x7f", "a b c"),
        ("\u202eevil", "evil"),
        ("\ud800x", "x"),
        ("ß 目", "ß 目"),
    ],
)
def test_clean_name(text: str, name: str) -> None:
    assert clean_name(text) == name
    assert clean_name(name) == name


def test_long_names_are_cut() -> None:
    assert clean_name("ab " * 10_000_000) == ("ab " * MAX_NAME)[:MAX_NAME].rstrip()


@pytest.mark.parametrize("names", [["a"], ["a", "b", 3], "abc", [None, "b", "c"]])
def test_wrong_names(names: list[str]) -> None:
    with pytest.raises(ValueError, match=r"names: got .*, wanted 3 texts, one for each layer"):
        three_layers().replace(names=names)


def test_names_are_carried() -> None:
    drawing = three_layers().replace(names=["a", "b", "c"])
    assert drawing.layer_subset([2, 0]).names == ("c", "a")
    assert drawing.layer_subset([False, True, False]).names == ("b",)
    assert concatenate(drawing, three_layers()).names == ("a", "b", "c", "", "", "")
    assert drawing.replace(background=None).names == ("a", "b", "c")
    assert drawing.moved(drawing.points + 1, drawing.colors, None).names == ("a", "b", "c")


def test_names_survive_a_checkpoint(tmp_path: Path) -> None:
    for drawing in (three_layers().replace(names=["a", "", "目 <b>"]), empty_drawing((3, 3))):
        save(Progress.start(drawing, Options(), (1,), 0), tmp_path / "run")
        assert load(tmp_path / "run").state.drawing.names == drawing.names


@pytest.mark.parametrize(
    ("spec", "layers"),
    [
        (1, [1]),
        (np.int64(2), [2]),
        ("1", [1]),
        ("002", [2]),
        ("orange circle left", [1]),
        ("Orange Circle", [1]),
        ("circle", [1, 2]),
        ("BLUE", [2]),
        ("#ff8000", [1]),
        ("#FFF", [0]),
        ("navy", [2]),
        ("rgb(0, 0, 128)", [2]),
        ("orange", [1]),
    ],
)
def test_select(spec: int | str, layers: list[int]) -> None:
    selected = three_layers().select(spec)
    assert selected.dtype == np.int64
    assert selected.tolist() == layers


def test_select_prefers_whole_names_and_joins_parts_with_colours() -> None:
    drawing = three_layers().replace(names=["eye", "left eye", "7"], colors=[ORANGE, WHITE, (0, 0.5, 0, 1)])
    assert drawing.select("eye").tolist() == [0]
    assert drawing.select("Eye").tolist() == [0, 1]
    assert drawing.select("7").tolist() == [2]  # no layer has that index
    assert drawing.replace(names=["white eye", "", ""]).select("white").tolist() == [0, 1]
    twice = drawing.replace(names=["eye", "left eye", "eye"])
    assert twice.select("eye").tolist() == [0, 2]


def test_groups_are_carried_and_select_their_layers() -> None:
    drawing = three_layers().replace(groups=[["face"], ["face", " left \n eye"], []])
    assert drawing.groups == (("face",), ("face", "left eye"), ())
    assert drawing.layer_subset([2, 1]).groups == ((), ("face", "left eye"))
    assert concatenate(drawing, three_layers()).groups == (*drawing.groups, (), (), ())
    assert drawing.select("face").tolist() == [0, 1]
    assert drawing.select("left eye").tolist() == [1]
    assert three_layers().groups == ((), (), ())


def test_groups_survive_a_checkpoint(tmp_path: Path) -> None:
    drawing = three_layers().replace(groups=[["a"], ["a", "目 <b>"], []])
    save(Progress.start(drawing, Options(), (1,), 0), tmp_path / "run")
    assert load(tmp_path / "run").state.drawing.groups == drawing.groups


@pytest.mark.parametrize("groups", [["a"], ["a", "b", "c"], [["a"], [3], []], "abc"])
def test_wrong_groups(groups: list[list[str]]) -> None:
    with pytest.raises(ValueError, match=r"groups: got .*, wanted 3 lists of names, one for each layer"):
        three_layers().replace(groups=groups)


@pytest.mark.parametrize("spec", [3, -1, "red", "", " ", "#12", "9"])
def test_select_refuses(spec: int | str) -> None:
    with pytest.raises(ValueError, match="layer: "):
        three_layers().select(spec)


def test_select_lists_the_names() -> None:
    with pytest.raises(ValueError, match="'white rectangle center', 'orange circle left', 'dark blue circle"):
        three_layers().select("nose")
    with pytest.raises(ValueError, match=r"'l11' and 88 more$"):
        drawings.build(100 * [([shapes.circle((5, 5), 2)], ORANGE)], (9, 9)).replace(
            names=[f"l{n}" for n in range(100)]
        ).select("nose")
    with pytest.raises(ValueError, match="there are no layers"):
        empty_drawing((3, 3)).select("nose")


@pytest.mark.parametrize("spec", [1.5, True, None, ["a"]])
def test_select_refuses_other_types(spec: int) -> None:
    with pytest.raises(ValueError, match="wanted an index, a name or a colour"):
        three_layers().select(spec)


def test_gradients_are_named_by_their_stops() -> None:
    yellow, red, blue, clear = (1, 0.9, 0, 1), (0.9, 0, 0, 1), (0, 0, 0.9, 1), (0, 0, 0.9, 0)
    fills = [
        Fills.linear((0, 0), (9, 0), [yellow, red]),
        Fills.radial((10, 30), (15, 30), (10, 35), [yellow, yellow, red, red, clear]),
        Fills.linear((0, 0), (9, 0), [yellow, red, blue, yellow, red]),
    ]
    drawing = three_layers().replace(fills=concatenate_fills(fills))
    assert drawing.labels == (
        "yellow to red rectangle center",
        "yellow to red to transparent circle left",
        "yellow to red circle bottom right",
    )
    assert drawing.replace(names=["", "sun", ""]).labels[1] == "sun"
    saved = read_svg(format_svg(drawing, layers="plain").encode())
    assert saved.labels == drawing.labels
    # By a stop's colour, not by the mean, which is seen nowhere.
    assert drawing.select("#0000e6").tolist() == [1, 2]
    with pytest.raises(ValueError, match="nor filled with that colour"):
        drawing.select(format_rgb(drawing.colors[0]))
