# SPDX-License-Identifier: Apache-2.0
"""The report: what stands in the page, that nothing from outside gets in, and what a browser shows of it."""

from __future__ import annotations

import base64
import dataclasses
import hashlib
import html.parser
import io
import re
from pathlib import Path

import chromium
import numpy as np
import pytest
from numpy.typing import NDArray
from PIL import Image

from livecl import Options, Result, vectorize
from livecl.drawing import empty_drawing
from livecl.report import format_report, write_report
from livecl.report_markup import number, png_uri, psnr
from livecl.report_measures import differences, layer_facts
from livecl.state import State
from livecl.vectorizer import Vectorizer

SIZE = (48, 48)
OPTIONS = Options(iterations=6, revisions=0, prune=0.0, background="white")
#: A name that would end an attribute, a tag or a title, and start a script.
HOSTILE = """"'></title><script>alert(1)</script>&amp;$style<img src=x onerror=alert(2)>"""
PNG = "data:image/png;base64,"


def two_squares() -> NDArray[np.float32]:
    image = np.ones((*SIZE, 3), np.float32)
    image[6:30, 8:36] = 0.9, 0.1, 0.2
    image[24:42, 20:44] = 0.1, 0.3, 0.8
    return image


def glass() -> NDArray[np.float32]:
    """Return the squares without the white beneath them: (48, 48, 4)."""
    image = two_squares()
    return np.dstack([image, np.where(image.min(axis=2) < 1, 1, 0)]).astype(np.float32)


@pytest.fixture(scope="module")
def result() -> Result:
    return vectorize(two_squares(), paths=2, schedule=[1, 1], options=OPTIONS)


@pytest.fixture(scope="module")
def page(result: Result) -> str:
    return format_report(two_squares(), result, name="Squares", command=["livecl", "two squares.png"])


class Page(html.parser.HTMLParser):
    """The tags of a page with their attributes, and its text."""

    def __init__(self, page: str) -> None:
        super().__init__()
        self.tags: list[tuple[str, dict[str, str | None]]] = []
        self.text = ""
        self.feed(page)
        self.close()

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.tags.append((tag, dict(attrs)))

    def handle_data(self, data: str) -> None:
        self.text += data

    def all(self, tag: str) -> list[dict[str, str | None]]:
        return [attributes for name, attributes in self.tags if name == tag]


def check_stands_alone(page: str) -> None:
    """Assert that nothing is loaded from elsewhere, and that only the page's own script may run."""
    for tag, attributes in Page(page).tags:
        assert tag not in ("link", "iframe", "object", "embed", "base")
        for name, value in attributes.items():
            assert not name.startswith("on")
            if name in ("src", "data-difference"):
                assert value is not None and value.startswith(PNG)
            elif name in ("href", "xlink:href"):
                assert value is not None and value.startswith("#")
            elif name not in ("xmlns", "aria-label", "alt"):
                assert "http:" not in (value or "") and "https:" not in (value or "")
    assert page.count("<script") == page.count("</script>") == 1
    assert "@import" not in page and "url(" not in page
    assert set(re.findall(r"https?://[\w./]+", page)) <= {"http://www.w3.org/2000/svg"}


def test_page_stands_alone(page: str) -> None:
    check_stands_alone(page)


def test_content_policy_names_the_style_and_the_script(page: str) -> None:
    policy = Page(page).all("meta")[1]["content"]
    assert policy is not None and policy.startswith("default-src 'none'")
    for tag in ("style", "script"):
        found = re.search(f"<{tag}>(.*?)</{tag}>", page, re.DOTALL)
        assert found is not None
        digest = base64.b64encode(hashlib.sha256(found[1].encode()).digest()).decode()
        assert f"{tag}-src 'sha256-{digest}'" in policy
    # Inline styles would be refused.
    assert all("style" not in attributes for _, attributes in Page(page).tags)


def test_pictures_have_alternatives(page: str) -> None:
    found = Page(page)
    images = found.all("img")
    assert [image["alt"] for image in images] == [
        "Target: Squares, 48 by 48 pixels",
        "Difference of drawing and target: the stronger the red, the larger",
    ]
    for drawing in found.all("svg"):
        assert drawing.get("aria-label") or drawing.get("aria-hidden") == "true"


def test_target_is_in_the_page(page: str) -> None:
    address = Page(page).all("img")[0]["src"]
    assert address is not None
    shown = np.asarray(Image.open(io.BytesIO(base64.b64decode(address.removeprefix(PNG)))))
    np.testing.assert_array_equal(shown, np.rint(two_squares() * 255))


def test_one_entry_for_each_layer_and_stage(result: Result, page: str) -> None:
    layers = re.search(r'<table id="layers">.*?</table>', page, re.DOTALL)
    stages = re.search(r'<table id="stages">.*?</table>', page, re.DOTALL)
    drawing = re.search(r'<svg [^>]*id="drawing".*?</svg>', page, re.DOTALL)
    assert layers is not None and stages is not None and drawing is not None
    assert result.drawing.num_layers == 2
    assert re.findall(r'<button type="button">(\d+)</button>', layers[0]) == ["0", "1"]
    assert drawing[0].count("<path") == 2
    assert stages[0].count("<tr") == 1 + len(result.stages)
    assert page.count('href="#stage=') == len(result.stages) == 2
    for stage in result.stages:
        assert f"<td>{stage.mse:.3g}</td>" in stages[0]


def test_run_can_be_repeated_from_the_page(page: str) -> None:
    text = Page(page).text
    assert "livecl 'two squares.png'" in text
    assert "6 (default: 200)" in text


def test_hostile_names_are_text(result: Result) -> None:
    page = format_report(two_squares(), result, name=HOSTILE, command=HOSTILE)
    check_stands_alone(page)
    found = Page(page)
    assert len(found.all("img")) == 2
    assert found.all("img")[0]["alt"] == f"Target: {HOSTILE}, 48 by 48 pixels"
    assert found.text.count(HOSTILE) == 3  # title, heading, command


def test_same_result_gives_the_same_bytes(result: Result, page: str, tmp_path: Path) -> None:
    path = tmp_path / "report.html"
    write_report(path, two_squares(), result, name="Squares", command=["livecl", "two squares.png"])
    assert path.read_bytes() == page.encode()


def test_without_background() -> None:
    result = vectorize(glass(), paths=2, options=dataclasses.replace(OPTIONS, background="none"))
    page = format_report(glass(), result)
    assert result.drawing.background is None
    check_stands_alone(page)
    assert "<rect class=" not in page
    assert 'class="pictures tiny clear"' in page


def test_without_layers_and_stages(result: Result) -> None:
    bare = dataclasses.replace(result, drawing=empty_drawing(SIZE), stages=(), mse=0.0)
    page = format_report(np.ones((*SIZE, 3)), bare)
    check_stands_alone(page)
    assert "The drawing has no layers." in page and "There were no stages." in page
    assert "PSNR ∞ dB" in page


def test_picture_of_another_size_is_refused(result: Result) -> None:
    with pytest.raises(ValueError, match=r"image: \(24, 48\) pixels, wanted the drawing's \(48, 48\)"):
        format_report(two_squares()[::2], result)


def test_layers_measured_against_rendering_without_them(result: Result) -> None:
    drawing = result.drawing
    vectorizer = Vectorizer(two_squares(), State.start(drawing, result.options, (1,), 0))
    facts = layer_facts(drawing, result.svg, vectorizer.target, vectorizer.rasterizer)
    whole = vectorizer.mse(drawing)
    for layer, fact in enumerate(facts):
        without = vectorizer.mse(drawing.layer_subset([other for other in range(2) if other != layer]))
        # Single precision of the renders: 1e-6 a pixel's squared error.
        assert fact.removed == pytest.approx(without - whole, abs=1e-6)
        assert fact.area == pytest.approx(fact.area_share * SIZE[0] * SIZE[1])
        assert 0 < fact.num_bytes < len(result.svg)
    # What is seen of all layers is what they cover together: the alpha of the drawing without a background.
    covered = vectorizer.rasterizer.forward(drawing.replace(background=None))[..., 3].sum()
    assert sum(fact.area for fact in facts) == pytest.approx(covered, rel=1e-5)


def test_difference_is_amplified_by_a_power_of_two() -> None:
    # Of an even error of 0.1, 8 times is the most that stays below 1.
    addresses, gain = differences([np.full((8, 8, 3), 0.1, np.float32)])
    assert gain == 8
    picture = Image.open(io.BytesIO(base64.b64decode(addresses[0].removeprefix(PNG)))).convert("RGBA")
    assert {color for _, color in picture.getcolors()} == {(214, 66, 48, round(0.8 * 255))}
    assert differences([np.zeros((8, 8, 3), np.float32)])[1] == 64


def test_figures() -> None:
    assert [number(value, 3) for value in (1.0, -0.0001, 100.0, 2.34567)] == ["1", "0", "100", "2.346"]
    assert number(100.0, 0) == "100"
    assert (psnr(0.01), psnr(0.0)) == ("20.0", "∞")
    assert png_uri(np.zeros((1, 1, 3))).startswith(PNG)


def test_chromium_shows_the_chosen_layers(page: str, tmp_path: Path) -> None:
    path = tmp_path / "report.html"
    path.write_text(page, encoding="utf-8")
    one, both, whole = (chromium.screenshot(path.resolve().as_uri() + end, (600, 1000)) for end in ("#k=1", "#k=2", ""))
    assert np.abs(one - both).max() > 0.5
    # All layers are what the page begins with.
    np.testing.assert_array_equal(both, whole)
