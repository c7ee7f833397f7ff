# SPDX-License-Identifier: Apache-2.0
"""Saved SVGs in the hands of others: Inkscape opens, edits and saves them, Chromium shows them."""

from __future__ import annotations

import shutil
import subprocess
from pathlib import Path

import compare_svg
import numpy as np
import pytest
from support import chromium, shapes

import livecl
from livecl import Drawing, Options
from livecl.drawing import Fills
from livecl.drawing.fills import concatenate_fills
from livecl.svg import LayerStyle, format_svg, quantize, save_svg
from livecl.svg.writer import layer_kinds

ROOT = Path(__file__).resolve().parents[2]


def sample() -> Drawing:
    """Return a ring, translucent and overlapping layers, of three stages; one with a name that needs escaping."""
    ring = [shapes.circle((120, 110), 70), shapes.reverse(shapes.circle((126, 118), 35))]
    layers = [
        (ring, (0.1, 0.4, 0.8, 1.0)),
        ([shapes.circle((80, 150), 55)], (0.9, 0.3, 0.1, 128 / 255)),
        ([shapes.rectangle(20.5, 30.25, 150, 60)], (0.2, 0.7, 0.3, 1.0)),
        ([shapes.blob(5, (170, 180), 40)], (0.6, 0.2, 0.7, 200 / 255)),
    ]
    drawing = shapes.build(layers, (240, 240), (0.9, 0.9, 0.8))
    return quantize(drawing.replace(stages=[0, 1, 1, 0], names=["", "", "a <b> & \"c\" 'd'", ""]))


def assert_equal(got: Drawing, wanted: Drawing, but: tuple[str, ...] = ()) -> None:
    for name in ("size", "background", "points", "colors", "subpath_offsets", "layer_offsets", "stages"):
        if name not in but:
            np.testing.assert_array_equal(getattr(got, name), getattr(wanted, name), err_msg=name)


def inkscape(*arguments: str) -> None:
    program = shutil.which("inkscape")
    if program is None:
        pytest.skip("Inkscape is not installed")
    run = subprocess.run([program, *arguments], capture_output=True, text=True, timeout=120, check=False)
    assert run.returncode == 0, run.stderr[-500:]


@pytest.mark.parametrize("layers", ["inkscape", "plain"])
@pytest.mark.parametrize("option", ["--export-type=svg", "--export-plain-svg"])
def test_saved_again_by_inkscape(layers: LayerStyle, option: str, tmp_path: Path) -> None:
    """All is unchanged; but as plain SVG, Inkscape drops labels, and with them a name that is no id."""
    drawing, source, target = sample(), tmp_path / "in.svg", tmp_path / "out.svg"
    save_svg(drawing, source, layers=layers)
    inkscape(option, f"--export-filename={target}", str(source))
    assert "sodipodi" in target.read_text(encoding="utf-8") or option == "--export-plain-svg"
    back = livecl.read_svg(target)
    assert_equal(back, drawing, but=("stages",) if layers == "plain" else ())
    drops_names = (layers, option) == ("inkscape", "--export-plain-svg")
    wanted = [drawing.labels[0], drawing.labels[1], "a-b-c-d-" if drops_names else drawing.labels[2], drawing.labels[3]]
    assert list(back.names) == wanted
    if not drops_names:
        assert format_svg(back, layers=layers) == source.read_text(encoding="utf-8")


def test_edited_by_inkscape(tmp_path: Path) -> None:
    """A path is moved by its id, one is deleted, one coloured: the edits are read back, the rest is as it was."""
    drawing, source, target = sample(), tmp_path / "in.svg", tmp_path / "out.svg"
    save_svg(drawing, source)
    moved, deleted, colored = (drawing.labels[layer].replace(" ", "-") for layer in (0, 1, 3))
    actions = (
        f"select-by-id:{moved};transform-translate:10,-5.5;select-clear;select-by-id:{deleted};delete;"
        f"select-by-id:{colored};object-set-property:fill,#102030;export-filename:{target};export-do"
    )
    inkscape(f"--actions={actions}", str(source))
    back = livecl.read_svg(target)
    kept = drawing.layer_subset([0, 2, 3])
    assert back.names == (drawing.labels[0], drawing.labels[2], drawing.labels[3])
    np.testing.assert_array_equal(back.stages, kept.stages)
    # Inkscape writes eight significant digits.
    ring = kept.segment_layers == 0
    np.testing.assert_allclose(back.points[ring], kept.points[ring] + (10, -5.5), atol=1e-5)
    np.testing.assert_array_equal(back.points[~ring], kept.points[~ring])
    np.testing.assert_array_equal(np.rint(back.colors[2, :3] * 255), [16, 32, 48])
    np.testing.assert_array_equal(back.colors[:2], kept.colors[:2])


def in_groups() -> Drawing:
    """Return a head of primitives with two eyes, in groups within a group, and a path of its own."""
    body = (
        '<rect id="background" width="240" height="200" fill="#fff"/><g id="head"><circle cx="100" cy="100" r="80"/>'
        '<g id="eyes" fill="#fff"><ellipse cx="70" cy="80" rx="12" ry="18"/><circle cx="130" cy="80" r="12"/></g>'
        '<rect x="70" y="130" width="60" height="20" rx="6" fill="#c00"/></g>'
        '<path id="nose" d="M200 20 230 70 190 60Z"/>'
    )
    return livecl.read_svg(f'<svg xmlns="http://www.w3.org/2000/svg" width="240" height="200">{body}</svg>'.encode())


@pytest.mark.parametrize("option", ["--export-type=svg", "--export-plain-svg"])
def test_groups_and_primitives_come_back_from_inkscape(option: str, tmp_path: Path) -> None:
    drawing, source, target = in_groups(), tmp_path / "in.svg", tmp_path / "out.svg"
    save_svg(drawing, source, groups="thing")
    inkscape(option, f"--export-filename={target}", str(source))
    back = livecl.read_svg(target)
    assert back.groups == drawing.groups == (("head",), ("head", "eyes"), ("head", "eyes"), ("head",), ())
    assert layer_kinds(back) == ["circle", "ellipse", "circle", "rectangle", "path"]
    np.testing.assert_allclose(back.points, drawing.points, atol=1e-4)  # eight significant digits


def test_things_are_edited_in_one_step_and_a_run_goes_on_from_them(tmp_path: Path) -> None:
    """A group is moved, a circle's radius and a swatch's colour are changed; the run keeps groups and shapes."""
    drawing, source, target = in_groups(), tmp_path / "in.svg", tmp_path / "out.svg"
    save_svg(drawing, source, groups="thing", swatches=True)
    name = drawing.labels[2].replace(" ", "-")
    actions = (
        f"select-by-id:eyes;transform-translate:5,-3;select-clear;select-by-id:{name};object-set-attribute:r,20;"
        f"export-filename:{target};export-do"
    )
    inkscape(f"--actions={actions}", str(source))
    text = target.read_text(encoding="utf-8")
    assert text.count("#cc0000") == 1
    target.write_text(text.replace("#cc0000", "#00cc00"), encoding="utf-8")
    edited = livecl.read_svg(target)
    assert edited.groups == drawing.groups
    assert layer_kinds(edited) == layer_kinds(drawing)
    eye = edited.points[edited.subpaths(2)[0], 0]
    np.testing.assert_allclose([*eye.mean(axis=0), np.ptp(eye, axis=0)[0]], [135, 77, 40], atol=1e-4)
    np.testing.assert_allclose(edited.colors[3, :3], (0, 0.8, 0))
    result = livecl.vectorize(livecl.render(edited)[..., :3], start=edited, options=Options(iterations=5))
    assert result.drawing.groups == drawing.groups
    assert result.drawing.names == edited.names
    assert layer_kinds(result.drawing) == layer_kinds(drawing)


def check_chromium(drawing: Drawing, layers: LayerStyle, path: Path) -> None:
    save_svg(drawing, path, layers=layers)
    picture = compare_svg.premultiplied(chromium.screenshot(path, drawing.size))
    _, edge, flat = compare_svg.differences(drawing, picture)
    assert edge < compare_svg.EDGE / 3  # skia, like resvg, samples coverage on a grid of 4 x 4 a pixel
    assert flat < compare_svg.FLAT


@pytest.mark.parametrize("layers", ["inkscape", "plain"])
def test_shown_by_chromium(layers: LayerStyle, tmp_path: Path) -> None:
    check_chromium(sample(), layers, tmp_path / "sample.svg")


def shaded() -> Drawing:
    """Return `sample` with gradients: linear, of a translucent stop; radial, of an ellipse; and a solid layer."""
    fills = [
        Fills.linear((60, 50), (180, 170), [(0.1, 0.4, 0.8, 1), (0.9, 0.9, 0.2, 1), (0.5, 0, 0.1, 1)], [0.1, 0.4, 0.9]),
        Fills.radial((80, 150), (140, 160), (70, 190), [(1, 1, 1, 1), (0.9, 0.3, 0.1, 0.2)]),
        Fills.solid(1),
        Fills.radial((170, 180), (210, 180), (170, 220), [(0.6, 0.2, 0.7, 0.8), (0, 0, 0, 1)]),
    ]
    return quantize(sample().replace(fills=concatenate_fills(fills)))


@pytest.mark.parametrize("layers", ["inkscape", "plain"])
def test_gradients_shown_by_chromium(layers: LayerStyle, tmp_path: Path) -> None:
    check_chromium(shaded(), layers, tmp_path / "shaded.svg")


def test_gradients_saved_again_by_inkscape(tmp_path: Path) -> None:
    """Inkscape writes eight significant digits, and opacities with fewer."""
    drawing, source, target = shaded(), tmp_path / "in.svg", tmp_path / "out.svg"
    save_svg(drawing, source)
    inkscape("--export-type=svg", f"--export-filename={target}", str(source))
    back = livecl.read_svg(target).fills
    np.testing.assert_array_equal(back.kinds, drawing.fills.kinds)
    for name in ("geometry", "stop_positions", "stop_colors"):
        np.testing.assert_allclose(getattr(back, name), getattr(drawing.fills, name), atol=1e-4)


@pytest.mark.parametrize("name", ["face", "logo"])
def test_vectorized_samples_shown_by_chromium(name: str, tmp_path: Path) -> None:
    if chromium.program() is None:
        pytest.skip("Chromium is not installed")
    image = livecl.read_image(ROOT / "examples" / f"{name}.png")
    drawing = livecl.vectorize(image, paths=5, options=Options(iterations=40, revisions=0)).drawing
    check_chromium(drawing, "inkscape", tmp_path / f"{name}.svg")
