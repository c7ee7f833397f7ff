# SPDX-License-Identifier: Apache-2.0
"""The report's page as text: what it says of a drawing, what it escapes, that it needs nothing else."""

from __future__ import annotations

import base64
import dataclasses
import hashlib
import html
import re
from html.parser import HTMLParser
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from support import drawings
from support.results import NASTY, result_of, sample, sample_drawing, shaded_drawing

from livecl import Rasterizer, read_image
from livecl.drawing.assembly import empty_drawing
from livecl.drawing.strokes import Strokes
from livecl.image.background import target_over
from livecl.image.errors import mse
from livecl.run.result import Stage
from livecl.views.report.markup import drawing_svg, number_text, psnr_text
from livecl.views.report.measures import differences, layer_facts, page_size, with_solid
from livecl.views.report.page import format_report, write_report
from livecl.views.report.plot import error_plot

VOID = {"meta", "img", "input", "br"}


class Page(HTMLParser):
    """Elements of a page, with their attributes; the text of each kind; and the check that elements are closed."""

    def __init__(self, page: str) -> None:
        super().__init__()
        self.elements: list[tuple[str, dict[str, str | None]]] = []
        self.texts: dict[str, list[str]] = {}
        self.open: list[str] = []
        self.feed(page)
        self.close()
        assert self.open == []

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        assert len({name for name, _ in attrs}) == len(attrs)
        self.elements.append((tag, dict(attrs)))
        if tag not in VOID:
            self.open.append(tag)

    def handle_startendtag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.elements.append((tag, dict(attrs)))

    def handle_endtag(self, tag: str) -> None:
        assert self.open.pop() == tag

    def handle_data(self, data: str) -> None:
        if self.open:
            self.texts.setdefault(self.open[-1], []).append(data)

    def of(self, tag: str) -> list[dict[str, str | None]]:
        return [attributes for name, attributes in self.elements if name == tag]


@pytest.mark.parametrize("background", [(0.9, 0.9, 0.8), None])
def test_facts_of_layers(background: Any) -> None:
    image, result = sample(background)
    target = target_over(image, result.drawing.background)
    rasterizer = Rasterizer(result.drawing.size)
    facts = layer_facts(result.drawing, result.svg, target, rasterizer)
    # The rectangle lies on top, on whole pixels.
    assert facts[2].area == pytest.approx(130 * 30)
    assert facts[2].area_share == pytest.approx(130 * 30 / (240 * 200))
    whole = mse(rasterizer.forward(result.drawing), target)
    for layer, fact in enumerate(facts):
        without = result.drawing.layer_subset(np.delete(np.arange(3), layer))
        # Float32 renders: each pixel's error has an absolute error of about eps, the mean's is no larger.
        assert fact.removed == pytest.approx(mse(rasterizer.forward(without), target) - whole, abs=1e-6)
    # What is seen of all layers is what they cover together: the alpha of the drawing without a background.
    covered = rasterizer.forward(result.drawing.replace(background=None))[..., 3].sum()
    assert sum(fact.area for fact in facts) == pytest.approx(covered, rel=1e-5)
    paths = re.findall(ELEMENT, result.svg)
    assert [fact.num_bytes for fact in facts] == [len(path) for path in paths]


#: A layer's element in a file for Inkscape.
ELEMENT = r'<(?:path|circle|ellipse|rect) id="(?!background").*/>'


def test_bytes_of_a_layer_with_any_name() -> None:
    image, result = sample(names=("a>b</path>", "é", ""))
    facts = layer_facts(result.drawing, result.svg, image, Rasterizer(result.drawing.size))
    outside = re.sub(ELEMENT, "", result.svg)
    assert sum(fact.num_bytes for fact in facts) == len(result.svg.encode()) - len(outside.encode())


def test_page_says_what_it_should() -> None:
    image, result = sample()
    page = format_report(image, result, command=["livecl", "my face.png", "-o", "x.svg"], name="my face.png")
    parsed = Page(page)
    assert parsed.texts["title"][:1] == ["my face.png"]
    assert "3 layers · MSE" in page
    assert "livecl &#x27;my face.png&#x27; -o x.svg" in page
    assert "a device" in page
    assert "5 (default: 200)" in page
    facts = [row["data-facts"] or "" for row in parsed.of("tr") if "data-facts" in row]
    assert len(facts) == 3
    assert "#33b333 · visible 3900 px, 8.1 % · removes an error of" in facts[0]  # the topmost is listed first
    assert f" · {result.drawing.segment_offsets[3] - result.drawing.segment_offsets[2]} nodes, " in facts[0]
    assert "at 50.2 %" in facts[1]
    assert [fact.split(" · ")[1] for fact in facts] == ["rectangle", "circle", "path"]
    stages = [link for link in parsed.of("a") if "data-difference" in link]
    assert [link["href"] for link in stages] == ["#stage=1", "#stage=2"]
    assert stages[0]["data-facts"] == f"1 path, MSE {result.stages[0].mse:.3g}"
    assert all(picture.get("alt") for picture in parsed.of("img"))
    labelled = {label.get("for") for label in parsed.of("label")}
    assert "slider" in labelled
    assert len({e["id"] for _, e in parsed.elements if "id" in e}) == sum("id" in e for _, e in parsed.elements)


def test_page_tells_the_groups() -> None:
    image, result = sample()
    grouped = result.drawing.replace(groups=[["head"], ["head", "<eye>"], []])
    page = format_report(image, dataclasses.replace(result, drawing=grouped))
    facts = [row["data-facts"] or "" for row in Page(page).of("tr") if "data-facts" in row]
    assert [fact.split(" · ")[1] for fact in facts] == ["rectangle", "circle in head / <eye>", "path in head"]
    assert "<td>head / &lt;eye&gt;</td>" in page


def test_page_needs_nothing_else(tmp_path: Path) -> None:
    image, result = sample()
    write_report(tmp_path / "r.html", image, result, name="x")
    page = (tmp_path / "r.html").read_text(encoding="utf-8")
    parsed = Page(page)
    addresses = [e[name] or "" for _, e in parsed.elements for name in ("src", "href", "data-difference") if name in e]
    assert addresses
    assert all(address.startswith(("data:image/png;base64,", "#")) for address in addresses)
    assert {tag for tag, _ in parsed.elements}.isdisjoint({"link", "iframe", "object", "base"})
    assert not any(name.startswith("on") for _, e in parsed.elements for name in e)
    (policy,) = [meta["content"] or "" for meta in parsed.of("meta") if "http-equiv" in meta]
    for tag in ("script", "style"):
        digest = base64.b64encode(hashlib.sha256("".join(parsed.texts[tag]).encode()).digest()).decode()
        assert f"{tag}-src 'sha256-{digest}'" in policy
    assert "default-src 'none'" in policy


def test_same_result_same_bytes() -> None:
    image, result = sample()
    assert format_report(image, result, name="x") == format_report(image, result, name="x")


def test_names_are_escaped() -> None:
    image, result = sample(names=(NASTY, "", ""))
    parsed = Page(format_report(image, result, command=NASTY, name=NASTY))
    assert len(parsed.of("script")) == 1
    assert len(parsed.of("img")) == 2
    assert parsed.texts["title"][:1] == [NASTY]
    assert NASTY in parsed.texts["code"]
    assert any(text.startswith("</script><script>window.hacked") for text in parsed.texts["button"])
    assert NASTY in (parsed.of("img")[0]["alt"] or "")


def test_drawing_is_the_saved_one() -> None:
    image, result = sample()
    page = format_report(image, result)
    drawing = re.search(r'<svg [^>]*id="drawing".*?</svg>', page, re.DOTALL)
    assert drawing is not None
    paths = re.findall(r' d="([^"]*)"', drawing[0])
    assert len(paths) == 3
    numbers = [float(number) for path in paths for number in re.findall(r"-?[\d.]+", path)]
    segments = np.diff(result.drawing.subpath_offsets)
    assert len(numbers) == 2 * np.sum(3 * segments + 1)
    first = [*result.drawing.points[:4].ravel(), *result.drawing.points[0, 0]]
    np.testing.assert_array_equal(numbers[: len(first)], first)


def test_transparent_pictures() -> None:
    image, result = sample(None)
    assert image.shape[2] == 4
    page = format_report(image, result)
    assert re.search(r'class="pictures [^"]*clear', page)
    parsed = Page(page)
    target = read_image(base64.b64decode((parsed.of("img")[0]["src"] or "").split(",")[1]))
    np.testing.assert_allclose(target, image, atol=0.5 / 255 + 1e-6)  # rounded to 8 bits
    assert "ground" not in {e.get("class") for e in parsed.of("rect")}


def test_without_layers_and_without_stages() -> None:
    image = np.full((8, 9, 3), 0.5)
    result = result_of(empty_drawing((8, 9)), image)
    page = format_report(image, result)
    assert "The drawing has no layers." in page
    assert re.search(r'class="pictures [^"]*tiny', page)
    Page(page)
    Page(format_report(image, dataclasses.replace(result, stages=())))


def test_large_pictures_are_reduced() -> None:
    drawing = drawings.build([([drawings.rectangle(100, 100, 700, 500)], (1.0, 0.0, 0.0, 1.0))], (600, 1024))
    assert page_size(drawing) == (392, 669)
    image = Rasterizer(drawing.size).forward(drawing)
    parsed = Page(format_report(image, result_of(drawing, image)))
    assert (parsed.of("img")[0]["width"], parsed.of("img")[0]["height"]) == ("669", "392")
    (facts,) = [row["data-facts"] or "" for row in parsed.of("tr") if "data-facts" in row]
    assert "visible 240000 px, 39.1 %" in facts
    many = drawing.layer_subset(np.zeros(2000, int))
    height, width = page_size(many)
    assert height * width * 2000 <= 1 << 26


def test_difference_is_amplified_by_a_power_of_two() -> None:
    error = np.zeros((10, 10, 3), np.float32)
    addresses, gain = differences([error])
    assert gain == 64
    error[:5] = 0.2
    addresses, gain = differences([2 * error, error])
    assert gain == 4
    shown = [read_image(base64.b64decode(address.split(",")[1])) for address in addresses]
    assert [picture[0, 0, 3] for picture in shown] == pytest.approx([1, 0.8], abs=0.5 / 255 + 1e-6)
    assert [picture[9, 9, 3] for picture in shown] == [0, 0]


def test_picture_of_another_size() -> None:
    image, result = sample()
    with pytest.raises(ValueError, match=r"image: .* wanted the drawing's"):
        format_report(image[1:], result)


@pytest.mark.parametrize("errors", [(0.1, 0.02, 0.0003), (0.1, 0.0), (0.5,), (0.0,), (3e-6, 2.9e-6), (0.1, 0.1)])
def test_plot_stays_in_its_frame(errors: tuple[float, ...]) -> None:
    drawing = sample_drawing()
    stages = [Stage(drawing.layer_subset(np.arange(1 + i)), error, 1, 0.1) for i, error in enumerate(errors)]
    plot = error_plot(stages)
    places = np.array([[float(number) for number in found] for found in re.findall(r'cx="(.*?)" cy="(.*?)"', plot)])
    assert len(places) == len(errors)
    assert np.all(places >= 0)
    assert np.all(places <= (544, 230))
    assert np.all(np.diff(places[:, 0]) > 0)
    falls = np.diff(places[:, 1])
    assert np.all(falls[np.diff(errors) < 0] > 0)  # y runs down
    ticks = re.findall(r'text-anchor="end">(.*?)<', plot)
    assert len(ticks) >= 2
    assert html.unescape(plot).count("<svg") == 1


def test_figures() -> None:
    assert [number_text(value, 3) for value in (1.0, -0.0001, 100.0, 2.34567)] == ["1", "0", "100", "2.346"]
    assert number_text(100.0, 0) == "100"
    assert (psnr_text(0.01), psnr_text(0.0)) == ("20.0", "∞")


def test_gradients_are_shown() -> None:
    drawing = shaded_drawing()
    target = Rasterizer(drawing.size).forward(drawing)
    page = Page(format_report(target, result_of(drawing, target)))
    ids = [given["id"] for _, given in page.elements if given.get("id")]
    assert len(ids) == len(set(ids))
    fills = [given.get("fill") or "" for tag, given in page.elements if tag in ("path", "rect")]
    used = {fill[5:-1] for fill in fills if fill.startswith("url(")}
    # Of the finished drawing, of both stages, and of the list's squares, whose stops are the drawing's.
    assert used == {"fill-0", "fill-2", "fill-stage-1-0", "fill-stage-2-0", "fill-stage-2-2", "swatch-0", "swatch-2"}
    assert used <= set(ids)
    assert {given.get("href") for tag, given in page.elements if tag.endswith("gradient")} >= {"#fill-0", "#fill-2"}
    assert "linear, #ffcc00 to #ff0000 at 40 %" in page.texts["td"]
    assert "radial, #3399ff to #003399" in page.texts["td"]


def test_worth_of_a_gradient_is_that_over_one_colour() -> None:
    drawing = shaded_drawing()
    rasterizer = Rasterizer(drawing.size)
    target = rasterizer.forward(drawing)
    facts = layer_facts(drawing, "<path/>" * 3, target, rasterizer)
    assert facts[1].gradient is None
    ring = facts[0].gradient
    assert ring is not None
    # No colour does better than the one compared with; the ring lies partly under others.
    for color in np.random.default_rng(0).uniform(0, 1, (50, 3)):
        solid = rasterizer.forward(with_solid(drawing, 0, color))
        assert mse(solid, target) >= ring
    assert 0 < ring < mse(rasterizer.forward(with_solid(drawing, 0, drawing.colors[0, :3])), target) * (1 + 1e-6)
    # Without a layer, gradients below and above it stay what they are.
    for layer in range(3):
        without = rasterizer.forward(drawing.layer_subset([k for k in range(3) if k != layer]))
        assert facts[layer].removed == pytest.approx(mse(without, target))


def test_strokes_are_shown_as_lines() -> None:
    drawing = sample_drawing()
    strokes = Strokes(widths=[0, 6, 0], caps=[0, 1, 0], is_open=[False, False, True, False])
    drawing = drawing.replace(strokes=strokes)
    path = re.findall(r"<path[^>]*>", drawing_svg(drawing, 2, facts=True))[1]
    assert 'fill="none"' in path and 'stroke="#e64c1a"' in path and 'stroke-opacity="' in path
    assert 'stroke-width="6"' in path and 'stroke-linecap="round"' in path
    assert "a line of 6 px" in path
    data = re.search(r' d="([^"]*)"', path)
    assert data is not None and "Z" not in data[1]
    assert len(re.findall(r"-?[\d.]+", data[1])) == 2 + 6 * 3  # four anchors
