# SPDX-License-Identifier: Apache-2.0
"""Animated SVG and GIF: what they hold, when, and what they leave out."""

from __future__ import annotations

import io
import warnings
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pytest
from PIL import Image, ImageSequence
from support import chromium, line_art
from support.drawings import BLUE, GREEN, RED, build, many_layers, rectangle
from support.shapes import circle

import livecl
from livecl.drawing import Strokes
from livecl.drawing.colors import format_rgb
from livecl.drawing.drawing import Drawing
from livecl.drawing.fills import Fills, concatenate_fills
from livecl.interpolation.blending import interpolate
from livecl.svg import format_svg, quantize
from livecl.svg.animated import format_animated_svg, save_animated_svg
from livecl.views.films import save_gif
from livecl.views.frames import encode_gif, render_frames

SIZE = (24, 32)
SVG = "{http://www.w3.org/2000/svg}"


def square(x: float, color: tuple[float, ...] = RED, background: tuple[float, ...] | None = (1, 1, 1)) -> Drawing:
    """Return a still disc and, above it, a square at x."""
    layers = [([circle((8, 12), 5)], BLUE), ([rectangle(x, 4, x + 6, 10)], color)]
    return build(layers, SIZE, background).replace(names=["disc", "square"])


def animations(text: str) -> dict[str, dict[str, str]]:
    """Return the attributes of each animation by the id of what it moves and the attribute's name."""
    root = ElementTree.fromstring(text)
    return {
        f"{parent.get('id')} {child.get('attributeName')}": dict(child.attrib)
        for parent in root.iter()
        for child in parent.findall(f"{SVG}animate")
    }


def path_data(drawing: Drawing, layer: int) -> str | None:
    return list(ElementTree.fromstring(format_svg(drawing, cubics=True)).iter(f"{SVG}path"))[layer].get("d")


def test_what_stands_still_is_not_animated() -> None:
    found = animations(format_animated_svg([square(4), square(20)], bounce=False))
    assert list(found) == ["square d"]
    assert found["square d"]["dur"] == "2s"
    assert found["square d"]["repeatCount"] == "indefinite"
    assert found["square d"]["keyTimes"] == "0;1"
    assert found["square d"]["values"].split(";") == [path_data(square(4), 1), path_data(square(20), 1)]


def test_reads_as_its_first_drawing() -> None:
    text = format_animated_svg([square(4), square(20, GREEN)])
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # that animations are not read
        still = livecl.read_svg(text.encode())
    first = quantize(square(4), cubics=True)
    np.testing.assert_array_equal(still.points, first.points)
    np.testing.assert_array_equal(still.colors, first.colors)


def test_goes_back_the_way_it_came() -> None:
    found = animations(format_animated_svg([square(4), square(10), square(28)], seconds=2, hold=1))["square d"]
    assert found["dur"] == "6s"
    # Half a stand, two seconds with a change of pace in the middle, a whole stand, and back.
    times = np.array([0, 0.5, 1.5, 2.5, 3.5, 4.5, 5.5, 6]) / 6
    np.testing.assert_allclose([float(time) for time in found["keyTimes"].split(";")], times, atol=1e-6)
    order = [path_data(square(x), 1) for x in (4, 4, 10, 28, 28, 10, 4, 4)]
    assert found["values"].split(";") == order


def test_one_way_stands_at_both_ends() -> None:
    found = animations(format_animated_svg([square(4), square(20)], seconds=2, hold=1, bounce=False))["square d"]
    assert (found["dur"], found["keyTimes"]) == ("4s", "0;0.25;0.75;1")


def test_drawings_on_the_way_add_nothing() -> None:
    few = format_animated_svg(interpolate(square(4), square(20, GREEN), [0, 1]))
    many = format_animated_svg(interpolate(square(4), square(20, GREEN), np.linspace(0, 1, 33).tolist()))
    assert few == many


def test_premultiplied_colors_need_more_keys() -> None:
    a, b = square(4, (1, 0, 0, 1)), square(4, (0, 0, 1, 0.2))
    found = animations(format_animated_svg(interpolate(a, b, np.linspace(0, 1, 9).tolist()), bounce=False))
    assert found["square fill-opacity"]["keyTimes"] == "0;1"
    assert found["square fill-opacity"]["values"] == "1;.2"
    times = np.array([float(time) for time in found["square fill"]["keyTimes"].split(";")])
    values = [int(value[1:3], 16) for value in found["square fill"]["values"].split(";")]
    # Red is 255 (1 - w), w = 0.2 t / (1 - 0.8 t); keys leave out values within half a level of the lines between.
    t = np.linspace(0, 1, 9)
    red = 255 * (1 - 0.2 * t / (1 - 0.8 * t))
    np.testing.assert_allclose(np.interp(t, times, values), red, atol=1)
    assert len(times) > 2


def test_background_is_animated() -> None:
    a, b = square(4, background=(1, 1, 1)), square(4, background=(0, 0, 0))
    assert animations(format_animated_svg([a, b], bounce=False))["background fill"]["values"] == "#ffffff;#000000"
    assert animations(format_animated_svg([square(4, background=None), square(9, background=None)]))


def test_one_drawing_stands_still() -> None:
    assert animations(format_animated_svg([square(4)])) == {}


def test_structures_must_agree() -> None:
    with pytest.raises(ValueError, match="drawings: got none"):
        format_animated_svg([])
    with pytest.raises(ValueError, match="drawings: 1 has other layers or segments than 0"):
        format_animated_svg([square(4), square(4).layer_subset([0])])
    with pytest.raises(ValueError, match=r"drawings: 1 has a canvas of \(9, 9\) px, wanted \(24, 32\) as 0 has"):
        format_animated_svg([square(4), square(4).replace(size=(9, 9))])
    with pytest.raises(ValueError, match="drawings: of 0 and 1 one has a background and the other none"):
        format_animated_svg([square(4), square(4, background=None)])
    with pytest.raises(ValueError, match=r"seconds: got 0, wanted a finite number of at least 0\.02"):
        format_animated_svg([square(4), square(5)], seconds=0)
    with pytest.raises(ValueError, match="hold: got -1"):
        format_animated_svg([square(4), square(5)], hold=-1)


def test_save(tmp_path: Path) -> None:
    save_animated_svg(tmp_path / "out.svg", [square(4), square(20)], seconds=3)
    assert (tmp_path / "out.svg").read_text(encoding="utf-8") == format_animated_svg([square(4), square(20)], seconds=3)


def gif_frames(path: Path) -> tuple[list[np.ndarray], list[int]]:
    with Image.open(path) as image:
        found = [(np.array(frame.convert("RGB")), frame.info["duration"]) for frame in ImageSequence.Iterator(image)]
    return [frame for frame, _ in found], [duration for _, duration in found]


def test_gif(tmp_path: Path, device: int) -> None:
    drawings = [square(4), square(10), square(20)]
    save_gif(tmp_path / "out.gif", drawings, seconds_per_frame=0.25, hold=0.5, bounce=True, device=device)
    frames, durations = gif_frames(tmp_path / "out.gif")
    assert durations == [750, 250, 750, 250]
    np.testing.assert_array_equal(frames[1], frames[3])
    for frame, image in zip(frames, render_frames(drawings, device=device), strict=False):
        np.testing.assert_array_equal(frame, np.rint(image * 255))  # so few colours all have a place in the palette
    save_gif(tmp_path / "again.gif", drawings, seconds_per_frame=0.25, hold=0.5, bounce=True, device=device)
    assert (tmp_path / "out.gif").read_bytes() == (tmp_path / "again.gif").read_bytes()


def test_gif_of_drawings_that_differ(tmp_path: Path, device: int) -> None:
    save_gif(tmp_path / "out.gif", [square(4).layer_subset([0]), square(4)], scale=2.0, device=device)
    frames, durations = gif_frames(tmp_path / "out.gif")
    assert [frame.shape for frame in frames] == [(48, 64, 3)] * 2
    assert durations == [100, 100]
    np.testing.assert_array_equal(frames[0][10, 10], (255, 255, 255))
    np.testing.assert_array_equal(frames[1][10, 10], np.rint(255 * np.array(RED[:3])))


def test_flat_colors_are_exact_in_a_gif() -> None:
    rng = np.random.default_rng(0)
    frame = np.ones((64, 64, 3))
    frame[:32, :32] = (200 / 255, 30 / 255, 77 / 255)
    frame[40:] = rng.uniform(size=(24, 64, 3))  # 1536 colours, far more than the palette holds
    image = Image.open(io.BytesIO(encode_gif([frame], [0.1]))).convert("RGB")
    levels = np.array(image).astype(int)
    np.testing.assert_array_equal(levels[:40], np.rint(frame[:40] * 255))
    # 128 medians of a cube of 256 levels: boxes of about 256 / 128^(1/3) = 51 levels, so about 13 from the middle in
    # each channel on average.
    assert np.abs(levels[40:] - frame[40:] * 255).mean() < 20


def test_frames_over_white(device: int) -> None:
    (over_white,) = render_frames([square(4)], device=device)
    (clear,) = render_frames([square(4, background=None)], device=device)
    np.testing.assert_allclose(clear, over_white, atol=4 * np.finfo(np.float32).eps)


def test_scaled_frame_is_the_mean_of_a_finer_one(device: int) -> None:
    drawing = many_layers((24, 32), 0, 12, 3).drawing
    (coarse,) = render_frames([drawing.layer_subset([0])], device=device)
    (fine,) = render_frames([drawing.layer_subset([0])], 4, device)
    # One layer's coverage is exact area, so its mean is too; both are flattened to within 0.02 of their pixels.
    np.testing.assert_allclose(fine.reshape(24, 4, 32, 4, 3).mean(axis=(1, 3)), coarse, atol=0.03)


def test_frames_refuse(tmp_path: Path) -> None:
    for scale in (0, -1, float("nan"), 1e6):
        with pytest.raises(ValueError, match="scale: got"):
            next(render_frames([square(4)], scale))
    with pytest.raises(ValueError, match="seconds_per_frame: got 0"):
        save_gif(tmp_path / "out.gif", [square(4)], seconds_per_frame=0)
    with pytest.raises(ValueError, match="hold: got 1000, wanted a finite number of at least 0 and at most 599"):
        save_gif(tmp_path / "out.gif", [square(4)], hold=1000)  # more hundredths than a GIF can count
    with pytest.raises(ValueError, match="drawings: got none"):
        save_gif(tmp_path / "out.gif", [])
    assert not list(tmp_path.iterdir())


def shaded(fills: Fills, x: float = 4) -> Drawing:
    drawing = square(x)
    return drawing.replace(fills=concatenate_fills([Fills.solid(1), fills]))


def test_gradients_are_animated() -> None:
    ends = [(1, 0, 0, 1), (0, 0, 1, 1)]
    a = shaded(Fills.linear((4, 0), (14, 0), ends))
    b = shaded(Fills.linear((4, 0), (24, 0), [(1, 0, 0, 1), (0, 1, 0, 0.5)]))
    text = format_animated_svg(interpolate(a, b, [0, 1]), bounce=False)
    root = ElementTree.fromstring(text)
    (gradient,) = root.iter(f"{SVG}linearGradient")
    assert list(root.iter(f"{SVG}path"))[1].get("fill") == f"url(#{gradient.get('id')})"
    found = {(e.get("attributeName"), e.get("values")) for e in gradient.iter(f"{SVG}animate")}
    assert found == {("x2", "14;24"), ("stop-color", "#0000ff;#00ff00"), ("stop-opacity", "1;.50196")}


def test_gradients_read_as_those_of_the_first_drawing() -> None:
    ends = [(1, 0, 0, 1), (0, 0, 1, 1)]
    a = shaded(Fills.linear((4, 0), (14, 0), ends))
    b = shaded(Fills.radial((10, 10), (20, 10), (10, 16), ends), 20)
    drawings = interpolate(a, b, np.linspace(0, 1, 5).tolist())
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # that animations are not read
        still = livecl.read_svg(format_animated_svg(drawings).encode())
    np.testing.assert_allclose(livecl.render(still), livecl.render(drawings[0]), atol=1 / 255)


def test_an_ellipse_turns_the_short_way() -> None:
    ends = [(1, 0, 0, 1), (0, 0, 1, 1)]
    turns = np.radians([85, 95, 175, 185])
    frames = []
    for turn in turns:
        axis = np.array([np.cos(turn), np.sin(turn)])
        frames.append(shaded(Fills.radial((10, 10), 10 + 8 * axis, 10 + 3 * np.array([-axis[1], axis[0]]), ends)))
    root = ElementTree.fromstring(format_animated_svg(frames, bounce=False))
    (rotation,) = (e for e in root.iter(f"{SVG}animateTransform") if e.get("type") == "rotate")
    angles = [float(value) for value in str(rotation.get("values")).split(";")]
    np.testing.assert_allclose(np.diff(angles), np.diff([85, 95, 175, 185])[: len(angles) - 1], atol=0.1)
    (scale,) = (e for e in root.iter(f"{SVG}animateTransform") if e.get("type") == "scale")
    assert len(set(str(scale.get("values")).split(";"))) == 1


def test_refuses_other_kinds_of_fills() -> None:
    a = shaded(Fills.linear((4, 0), (14, 0), [(1, 0, 0, 1), (0, 0, 1, 1)]))
    with pytest.raises(ValueError, match="fills of other kinds"):
        format_animated_svg([a, square(4)])


def test_strokes_are_animated() -> None:
    wide = Strokes(widths=[0, 4], caps=1, joins=1, is_open=np.array([False, False]))
    thin = Strokes(widths=[0, 2], caps=1, joins=0, miter_limits=7, is_open=np.array([False, False]))
    a, b = square(4).replace(strokes=wide), square(20, (*GREEN[:3], 0.5)).replace(strokes=thin)

    found = animations(format_animated_svg(interpolate(a, b, [0, 1]), bounce=False))

    assert {name: attributes["values"] for name, attributes in found.items() if name != "square d"} == {
        "square stroke-width": "4;2",
        "square stroke-linejoin": "round;miter",
        "square stroke-miterlimit": "4;7",
        "square stroke": ";".join(map(format_rgb, (RED, GREEN))),
        "square stroke-opacity": "1;.50196",
    }
    assert found["square stroke-linejoin"]["calcMode"] == "discrete"
    assert found["square stroke-linejoin"]["keyTimes"] == "0;0.5"
    with pytest.raises(ValueError, match="drawings: 1 has other strokes or open lines than 0"):
        format_animated_svg([a, square(4)])


def test_gradients_of_strokes_are_animated() -> None:
    pen = Strokes(widths=[0, 4], is_open=np.array([False, False]))
    fills = [Fills.linear((4, 0), (x, 0), [(1, 0, 0, 1), (0, 0, 1, 1)]) for x in (14, 24)]

    root = ElementTree.fromstring(format_animated_svg([shaded(fill).replace(strokes=pen) for fill in fills]))

    path = list(root.iter(f"{SVG}path"))[1]
    (gradient,) = root.iter(f"{SVG}linearGradient")
    assert path.get("stroke") == f"url(#{gradient.get('id')})"
    assert path.get("fill") == "none"


@pytest.mark.full
def test_chromium_shows_strokes_on_their_way(tmp_path: Path) -> None:
    """Caps, joins, widths, cut and lone lines: at each moment as a still SVG of the drawing in between."""
    a, b = line_art.DRAWINGS["house"], line_art.DRAWINGS["flower"]
    text = format_animated_svg(interpolate(a, b, [0, 1]), seconds=1, hold=0)
    for time in (0.25, 0.75, 1.4):
        page = tmp_path / "page.html"
        script = f"const s = document.querySelector('svg'); s.pauseAnimations(); s.setCurrentTime({time})"
        page.write_text(f"<body style='margin:0'>{text}<script>{script}</script></body>")
        between = interpolate(a, b, min(time, 2 - time))
        between.save_svg(tmp_path / "still.svg")

        moving = chromium.screenshot(page, line_art.SIZE)

        still = chromium.screenshot(tmp_path / "still.svg", line_art.SIZE)
        assert np.mean((moving - still) ** 2) < 1e-6  # coordinates are rounded before they are mixed, or after
