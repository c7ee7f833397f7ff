# SPDX-License-Identifier: Apache-2.0
"""Pictures placed by structure: flat or of shaded regions, whose layers show what they show."""

from __future__ import annotations

import dataclasses
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from support.shapes import rectangle

import livecl
from livecl.drawing import LINEAR, SOLID, Drawing, Fills
from livecl.drawing.assembly import empty_drawing
from livecl.drawing.fills import concatenate_fills
from livecl.geometry.outlines import circle
from livecl.layering.fills.ramps import Shading
from livecl.layering.outlines.contours import Outlines
from livecl.layering.segmentation.flat import clean_regions, flatness, noisy_regions
from livecl.layering.structure import finding
from livecl.layering.structure.finding import found_structure
from livecl.layering.structure.layers import Layer
from livecl.layering.structure.placing import place_structure
from livecl.layering.structure.ranking import Structure, mask_of

WHITE, MANY = np.ones(3), 99
SHADING = Shading(("linear", "radial"), 5e-6 / 28)
WARM, COOL = (0.9, 0.2, 0.1, 1.0), (0.1, 0.3, 0.8, 1.0)


def two_squares(level: float) -> NDArray[np.float32]:
    image = np.ones((64, 64, 3), np.float32)
    image[10:40, 10:40] = (level, 0.2, 0.2)
    image[25:55, 25:55] = (0.1, 0.3, 0.8)
    return image


def test_flat_pictures_are_structured_and_ramps_are_not() -> None:
    assert found_structure(two_squares(0.9), WHITE, MANY)
    assert not found_structure(np.ones((64, 64, 3), np.float32), WHITE, MANY)  # nothing but ground
    ramp = np.linspace(0, 1, 64, dtype=np.float32)[None, :, None] * np.ones((64, 1, 3), np.float32)
    assert not found_structure(ramp, WHITE, MANY)


def test_layers_that_hide_what_the_picture_shows_are_no_structure(monkeypatch: pytest.MonkeyPatch) -> None:
    find_layers = finding.find_layers
    monkeypatch.setattr(finding, "mosaic_of", lambda image: None)  # else it would show so small a picture's pixels
    monkeypatch.setattr(finding, "find_layers", lambda *arguments: find_layers(*arguments)[::-1])
    # Reversed, the lower square comes last and is whole: it hides a quarter of the other, 225 of 4096 px.
    assert found_structure(two_squares(0.7), WHITE, MANY)
    monkeypatch.setattr(finding, "find_layers", lambda *arguments: find_layers(*arguments)[:1])
    # Of 64 x 64 px, 900 show the other square: more than a tenth of those within regions.
    assert not found_structure(two_squares(0.6), WHITE, MANY)


def test_with_fewer_paths_than_shapes_the_largest_are_drawn() -> None:
    found = found_structure(two_squares(0.9), WHITE, 1)
    assert found is not None and len(found.ranked) == 1
    new = place_structure(two_squares(0.9), empty_drawing((64, 64), WHITE), 1, 1)
    assert new is not None
    assert not new.weight[10:40, 10:24].any() and new.weight[28:, 28:].all()  # no path is trained on what has none
    np.testing.assert_allclose(found.layers[found.ranked[0]].color, (0.1, 0.3, 0.8), atol=1e-6)  # 900 of 675 px
    speck = two_squares(0.9)
    speck[5:8, 5:8] = 0.5
    for paths, layers in ((3, 3), (2, 2)):
        found = found_structure(speck, WHITE, paths)
        assert found is not None and len(found.ranked) == layers
        assert {int(found.masks[k].sum()) > 100 for k in found.ranked} == ({True, False} if paths == 3 else {True})


def test_with_fewer_paths_than_shapes_near_colors_share_one() -> None:
    image = two_squares(0.9)
    image[5:20, 45:60] = (0.8, 0.2, 0.2)  # 225 px, which white would miss by .2, .8 and .8 and the other red by .1
    found = found_structure(image, WHITE, 2)
    assert found is not None
    colors = {len(found.layers[k].outlines): found.layers[k].color for k in found.ranked}
    np.testing.assert_allclose(colors[1], (0.1, 0.3, 0.8), atol=1e-6)
    np.testing.assert_allclose(colors[2], (0.9, 0.2, 0.2), atol=1e-6)  # that of the larger


def test_a_shape_behind_another_shares_a_path_with_one_before_it_as_far_as_it_is_seen() -> None:
    image = two_squares(0.9)  # the red square goes on below the blue one
    image[45:60, 45:60] = (0.9, 0.2, 0.2)  # a red one that lies across its corner
    apart, shared = (found_structure(image, WHITE, paths) for paths in (3, 2))
    assert apart is not None and shared is not None
    assert [int(apart.masks[k].sum()) for k in np.sort(apart.ranked)] == pytest.approx([900, 900, 225], rel=0.1)
    assert len(shared.ranked) == 2 and shared.error < 1e-3
    areas = [int(shared.masks[k].sum()) for k in np.sort(shared.ranked)]
    assert areas == pytest.approx([900, 675 + 225], rel=0.1)


def test_parts_of_a_layer_that_overlap_count_once() -> None:
    part = np.array([(2, 2), (12, 2), (12, 12), (2, 12)], float)
    layer = Layer([part, part + 5, (part[::-1] - 7) / 5 + 4], np.zeros(3))  # the third runs the other way: a hole
    assert mask_of(layer, (20, 20)).sum() == 100 + 100 - 25 - 4


@pytest.mark.parametrize("helps", [True, False])
def test_of_explanations_that_show_too_little_the_one_of_least_error_is_taken(
    monkeypatch: pytest.MonkeyPatch, helps: bool
) -> None:
    find_layers, calls = finding.find_layers, []

    def reversed_at_first(*arguments: Any) -> list[Layer]:
        calls.append(arguments[3].apart)
        layers = find_layers(*arguments)
        return layers if helps and arguments[3].apart else layers[::-1]

    monkeypatch.setattr(finding, "mosaic_of", lambda image: None)
    monkeypatch.setattr(finding, "find_layers", reversed_at_first)
    # Reversed, the red square hides 225 px of the blue one. A picture for each case: structures are kept.
    found = found_structure(two_squares(0.65 if helps else 0.66), WHITE, MANY)
    assert found is not None and (found.error == 0) == helps
    assert len(calls) == 2 and not calls[0] and calls[1]


def shaded_bars(device: int) -> NDArray[np.float32]:
    """Return two pairs of bars on white; the bars of a pair share a ramp."""
    ramps = [Fills.linear((8, 0), (120, 0), stops) for stops in ([WARM, COOL], [COOL, WARM])]
    pairs = [[rectangle(8, top, 120, top + 14), rectangle(8, top + 20, 120, top + 34)] for top in (8, 52)]
    drawing = Drawing.from_outlines(pairs, WARM, (96, 128), fills=concatenate_fills(ramps))
    return np.asarray(np.round(livecl.render(drawing, device) * 255) / 255, dtype=np.float32)


def test_shaded_regions_are_structured_where_gradients_are_allowed(device: int) -> None:
    image = shaded_bars(device)
    assert found_structure(image, WHITE, MANY) is None
    found = found_structure(image, WHITE, MANY, SHADING)
    assert found is not None
    assert found.shaded
    assert [int(found.fills_of(k).kinds[0]) for k in found.ranked] == [LINEAR] * 4
    assert found_structure(image, WHITE, MANY, Shading(("radial",), 1e-3)) is None


def test_layers_of_one_ramp_are_united_where_paths_are_few(device: int) -> None:
    found = found_structure(shaded_bars(device), WHITE, 2, SHADING)
    assert found is not None
    assert [len(found.layers[k].outlines) for k in found.ranked] == [2, 2]
    one = found_structure(shaded_bars(device), WHITE, 1, SHADING)
    assert one is not None
    assert [len(one.layers[k].outlines) for k in one.ranked] == [2]  # the two ramps are not one


def test_flat_shapes_of_one_color_are_one_path_only_where_paths_are_few() -> None:
    image = np.ones((64, 64, 3), np.float32)
    image[36:60, 4:60] = (0.1, 0.3, 0.8)
    for left, size in ((4, 14), (24, 12), (44, 10)):
        image[8 : 8 + size, left : left + size] = (0.9, 0.2, 0.2)
    outlines = {2: [1, 3], 3: [1, 1, 2], 4: [1, 1, 1, 1]}  # the smallest are united first
    for paths, wanted in outlines.items():
        found = found_structure(image, WHITE, paths)
        assert found is not None
        assert sorted(len(found.layers[k].outlines) for k in found.ranked) == wanted
        if paths == 3:
            united = next(k for k in found.ranked if len(found.layers[k].outlines) == 2)
            assert found.masks[united].sum() == pytest.approx(12**2 + 10**2, rel=0.1)
    found = found_structure(image, WHITE, 1)
    assert found is not None
    assert [len(found.layers[k].outlines) for k in found.ranked] == [1]


def test_what_shows_through_a_sign_is_a_hole_of_it_only_where_paths_are_few() -> None:
    image = np.ones((64, 64, 3), np.float32)
    image[4:60, 4:60] = (0.4, 0.2, 0.7)  # a plate, with a light sign on it that has a small eye
    image[14:50, 14:50] = 0.95
    image[20:32, 20:32] = (0.4, 0.2, 0.7)
    for paths, holes in ((3, 0), (2, 1)):
        found = found_structure(image, WHITE, paths)
        assert found is not None
        assert len(found.ranked) == paths
        plate, sign = sorted(found.ranked)[:2]
        assert [len(found.layers[k].outlines) for k in (plate, sign)] == [1, 1 + holes]
        assert found.masks[plate].sum() == pytest.approx(56**2, rel=0.05)
    image[20:32, 20:32] = (0.9, 0.2, 0.2)  # an eye of a colour of its own is none
    found = found_structure(image, WHITE, 2)
    assert found is not None
    assert [len(found.layers[k].outlines) for k in np.sort(found.ranked)] == [1, 1]


def battery() -> NDArray[np.float32]:
    """Return a battery of one colour: a body and its cap."""
    image = np.ones((64, 64, 3), np.float32)
    image[20:58, 16:48] = image[10:20, 25:39] = (0.4, 0.2, 0.7)
    return image


@pytest.mark.parametrize(("asked", "layers"), [(0, 1), (1, 1), (2, 2), (3, 1)])
def test_a_silhouette_is_cut_for_a_number_of_layers_not_for_a_limit(asked: int, layers: int) -> None:
    found = found_structure(battery(), WHITE, MANY, asked=asked)
    assert found is not None
    assert len(found.ranked) == layers


def test_no_cut_makes_other_shapes_share_a_path(monkeypatch: pytest.MonkeyPatch) -> None:
    # A cut may take apart what had been joined: three layers for two paths, of which two would become one.
    parts = np.ones((64, 64, 3), np.float32)
    parts[10:22, 10:40] = parts[26:38, 10:40] = parts[42:54, 10:40] = (0.4, 0.2, 0.7)
    monkeypatch.setattr(finding, "with_more_parts", lambda *_: Outlines(clean_regions(parts), {0}))
    found = found_structure(battery(), WHITE, 2, asked=2)
    assert found is not None
    assert len(found.ranked) == 1


def test_paths_that_are_asked_for_cut_a_silhouette_and_auto_does_not(device: int) -> None:
    options = livecl.Options(iterations=5)
    for paths, layers in ((2, 2), ("auto", 1)):
        assert livecl.vectorize(battery(), paths, options=options, device=device).drawing.num_layers == layers


def test_flat_pictures_have_no_gradients() -> None:
    found = found_structure(two_squares(0.9), WHITE, MANY, SHADING)
    assert found is not None
    assert not found.shaded
    assert {int(found.fills_of(k).kinds[0]) for k in found.ranked} == {SOLID}


def test_where_no_page_shows_marks_are_no_holes_onto_it(device: int) -> None:
    """White marks on a gradient that fills the canvas are one layer on it, and not some of them holes in it."""
    marks = [rectangle(16, 14, 28, 20), rectangle(34, 14, 48, 20), rectangle(16, 34, 48, 40)]
    layers = [[rectangle(0, 0, 64, 64)], *([mark] for mark in marks)]
    fills = concatenate_fills([Fills.linear((0, 0), (64, 64), [WARM, COOL]), Fills.solid(3)])
    drawing = Drawing.from_outlines(layers, [WARM, *[(1.0, 1.0, 1.0, 1.0)] * 3], (64, 64), fills=fills)
    found = found_structure(livecl.render(drawing, device), WHITE, 2, SHADING)
    assert found is not None
    assert [len(found.layers[k].outlines) for k in sorted(found.ranked)] == [1, 3]


def soft_disc(device: int) -> NDArray[np.float32]:
    """Return a grey disc that fades to white, and two flat ones, at 8 bits."""
    gray = (0.7, 0.75, 0.77, 1.0)
    fills = [Fills.linear((20, 20), (80, 80), [gray, (1.0, 1.0, 1.0, 1.0)]), Fills.solid(2)]
    middles = [((60.0, 60.0), 44.0), ((30.0, 130.0), 8.0), ((120.0, 125.0), 8.0)]
    outlines = [[circle(np.array(middle), radius, 4)] for middle, radius in middles]
    drawing = Drawing.from_outlines(outlines, [gray, WARM, COOL], (160, 160), fills=concatenate_fills(fills))
    return np.asarray(np.round(np.clip(livecl.render(drawing, device), 0, 1) * 255) / 255, dtype=np.float32)


def test_slopes_are_no_noise(device: int) -> None:
    """The noise of flat colours explains a soft slope as well, by bands: gradients explain it by fewer regions."""
    image = soft_disc(device)
    noisy = noisy_regions(image)
    assert noisy is not None and len(noisy.sizes) > 6  # or the slope is not taken for noise, and this tests nothing
    found = found_structure(image, WHITE, MANY, SHADING)
    assert found is not None and len(found.ranked) == 3
    assert sorted(int(found.fills_of(k).kinds[0]) for k in found.ranked) == [SOLID, SOLID, LINEAR]


def test_noise_is_no_slope() -> None:
    """Flat colours with the noise of a camera stay flat colours, though shading is allowed."""
    noise = np.random.default_rng(0).normal(0, 3 / 255, (64, 64, 3))
    found = found_structure(np.clip(two_squares(0.9) + noise, 0, 1).astype(np.float32), WHITE, MANY, SHADING)
    assert found is not None and not found.shaded and len(found.ranked) == 2


def test_borders_of_near_grays_are_no_shading() -> None:
    """Mixed pixels between near colours differ slightly from both sides, as pixels on a slope do."""
    picture = np.ones((60, 60, 3), np.float32)
    stripe = np.repeat([0.80, 0.81, 0.82, 0.81], [5, 1, 5, 1])  # at a border half of each
    picture[6:54, 6:54] = np.tile(stripe, 4)[None, :, None]
    assert flatness(picture).slopes > 0.1
    assert flatness(picture).bands == 0
    found = found_structure(picture, WHITE, MANY)
    assert found is not None and len(found.regions.sizes) == 9


def test_a_noisy_ramp_is_one_gradient() -> None:
    grain = np.random.default_rng(0).uniform(-0.03, 0.03, (64, 64, 3))
    ramp = (np.linspace(0.2, 0.8, 64)[None, :, None] + grain).astype(np.float32)
    found = found_structure(ramp, WHITE, MANY, SHADING)
    assert found is not None and found.shaded and len(found.ranked) == 1


def test_regions_are_not_cut_out_of_what_is_nowhere_smooth(monkeypatch: pytest.MonkeyPatch) -> None:
    grain = np.random.default_rng(0).uniform(-0.03, 0.03, (64, 64, 3))
    waves = 0.3 * np.sin(np.arange(64) / 3)[:, None, None] * np.sin(np.arange(64) / 4)[None, :, None]
    photograph = (0.5 + waves + grain).astype(np.float32)
    monkeypatch.setattr(finding, "noisy_regions", lambda image: None)
    monkeypatch.setattr(finding, "clean_regions", lambda image: pytest.fail("it takes long"))
    monkeypatch.setattr(finding, "smooth_regions", lambda *arguments: pytest.fail("it takes long"))
    assert found_structure(photograph, WHITE, MANY, SHADING) is None


def test_regions_are_not_cut_out_of_a_photograph_with_a_smooth_sky(monkeypatch: pytest.MonkeyPatch) -> None:
    """Between the smooth parts lie pixels that mix nothing: there is no structure, however the sky is cut."""
    ramp = np.linspace(0.3, 0.7, 64)[:, None, None] * np.array((0.6, 0.8, 1.0)) * np.ones((64, 64, 1))
    picture = ramp.astype(np.float32)
    monkeypatch.setattr(finding, "smooth_regions", lambda *arguments: "cut")
    monkeypatch.setattr(finding, "_many_explained", lambda regions: pytest.fail("cut"))
    with pytest.raises(pytest.fail.Exception, match="cut"):
        found_structure(picture, WHITE, MANY, SHADING)
    picture[48:] = np.random.default_rng(0).uniform(0, 1, (16, 64, 3))
    monkeypatch.setattr(finding, "_noisy", lambda *arguments: None)
    monkeypatch.setattr(finding, "_regions", lambda *arguments: pytest.fail("slopes are not flat"))
    monkeypatch.setattr(finding, "MOST_BANDS", 0.0)
    assert found_structure(picture, WHITE, MANY, SHADING) is None


def test_layers_of_a_flat_picture_are_looked_for_once(monkeypatch: pytest.MonkeyPatch) -> None:
    calls, find_layers = [], finding.find_layers
    monkeypatch.setattr(finding, "SOME_SLOPES", -1.0)  # so that gradients are looked for
    monkeypatch.setattr(finding, "find_layers", lambda *arguments: calls.append(0) or find_layers(*arguments))
    assert found_structure(two_squares(0.87), WHITE, MANY, SHADING) is not None
    assert len(calls) == 1


def test_shapes_that_hid_what_shows_are_joined_with_no_others(data_dir: Path) -> None:
    # Waves of one colour in rows, on both sides of a dam: joined below it across rows they would hide the water.
    image = livecl.read_image(data_dir / "layers" / "flat-color-icons_dam.png")
    found = found_structure(image, WHITE, MANY)
    assert found is not None
    assert found.mistaken < 0.002  # .033 with all joins
    assert not found.mistaken_by(0.002)


def test_small_pale_dots_are_layers() -> None:
    """A dot of 16 px that differs by .2 from what lies around it is worth more than `prune`."""
    image = np.full((256, 256, 3), 1.0, np.float32)
    image[40:200, 40:200] = 0.7
    for row in range(60, 180, 20):
        image[row : row + 4, 100:104] = 0.5
    found = found_structure(image, WHITE, MANY)
    assert found is not None and len(found.ranked) == 7
    assert found.gains[found.ranked[-1]] / image.size > livecl.Options().prune


@pytest.mark.parametrize(("hidden", "united"), [(2, True), (12, False)])
def test_shapes_of_one_color_share_a_path_where_little_of_what_lies_between_changes(hidden: int, united: bool) -> None:
    blue, red = np.array((0.1, 0.3, 0.8)), np.array((0.9, 0.2, 0.2))
    lefts, tops, rights, bottoms = (4, 24 - hidden, 44 - hidden), (4, 10, 8), (24, 44, 62), (30, 20, 60)
    image, masks, layers = np.ones((64, 64, 3), np.float32), np.zeros((3, 64, 64), bool), []
    for k, (left, top, right, bottom) in enumerate(zip(lefts, tops, rights, bottoms, strict=True)):
        masks[k, top:bottom, left:right] = True
        image[masks[k]] = red if k == 1 else blue
        corners = [(left, top), (right, top), (right, bottom), (left, bottom)]
        layers.append(Layer([np.array(corners, float)], red if k == 1 else blue))
    regions = clean_regions(image)
    for k, (row, column) in enumerate([(25, 10), (15, 27), (50, 55)]):
        layers[k] = dataclasses.replace(layers[k], shown=frozenset((int(regions.labels[row, column]),)))
    found = Structure.of(regions, layers, WHITE, masks).united(2)
    assert len(found.ranked) == 2
    assert (found.left_out is None) == united
