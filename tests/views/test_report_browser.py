# SPDX-License-Identifier: Apache-2.0
"""The report in Chromium: what it shows, and that mouse, keyboard and address steer it."""

from __future__ import annotations

import io
import shutil
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import compare_svg
import numpy as np
import pytest
from numpy.typing import NDArray
from PIL import Image
from support import chromium
from support.results import NASTY, result_of, sample, shaded_drawing

from livecl import Rasterizer, read_image
from livecl.drawing.assembly import empty_drawing
from livecl.run.result import Result
from livecl.views.report.page import write_report

webdriver = pytest.importorskip("selenium.webdriver", reason="selenium is not installed")
from selenium.webdriver.chrome.service import Service  # noqa: E402
from selenium.webdriver.common.action_chains import ActionChains  # noqa: E402
from selenium.webdriver.common.by import By  # noqa: E402
from selenium.webdriver.common.keys import Keys  # noqa: E402
from selenium.webdriver.support.wait import WebDriverWait  # noqa: E402


@pytest.fixture(scope="module")
def browser(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Any]:
    driver = shutil.which("chromedriver")
    if chromium.program() is None or driver is None:
        pytest.skip("Chromium or its chromedriver is not installed")
    options = webdriver.ChromeOptions()
    options.binary_location = chromium.program()
    for flag in chromium.FLAGS:
        options.add_argument(flag)
    options.add_argument(f"--user-data-dir={tmp_path_factory.mktemp('profile')}")
    options.set_capability("goog:loggingPrefs", {"browser": "ALL"})
    started = webdriver.Chrome(options=options, service=Service(driver))
    started.set_window_size(1200, 1000)
    yield started
    started.quit()


@pytest.fixture(scope="module")
def page(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, Result]:
    image, result = sample()
    file = tmp_path_factory.mktemp("report") / "report.html"
    write_report(file, image, result, name="sample")
    return file, result


def visit(browser: Any, file: Path, hash_: str = "") -> None:
    browser.get("about:blank")
    browser.get(f"{file.as_uri()}{hash_}")


def find(browser: Any, selector: str) -> Any:
    return browser.find_element(By.CSS_SELECTOR, selector)


def address(browser: Any) -> str:
    return str(browser.execute_script("return location.hash"))


def shown(browser: Any, size: tuple[int, int]) -> NDArray[np.float32]:
    """Return what the browser shows of the drawing, at its own size, over white."""
    height, width = size
    style = f"position: fixed; inset: 0; width: {width}px; height: {height}px; max-height: none; z-index: 9"
    browser.execute_script(f"document.querySelector('#drawing').style = '{style}; background: white'")
    png = browser.get_screenshot_as_png()
    browser.execute_script("document.querySelector('#drawing').style = ''")
    picture: NDArray[np.float32] = read_image(png)[:height, :width, :3]
    return picture


def layers_shown(picture: NDArray[np.float32], result: Result) -> list[int]:
    """Return the counts of first layers whose own picture, over white, is this one but for a renderer's edges."""
    found = []
    for count in range(result.drawing.num_layers + 1):
        drawing = result.drawing.layer_subset(np.arange(count))
        if drawing.background is None:
            drawing = drawing.replace(background=(1, 1, 1))
        _, edge, flat = compare_svg.differences(drawing, compare_svg.premultiplied(picture))
        if edge < compare_svg.EDGE / 3 and flat < compare_svg.FLAT:
            found.append(count)
    return found


@pytest.mark.parametrize("background", [(0.9, 0.9, 0.8), None])
def test_address_selects_layers(browser: Any, tmp_path: Path, background: Any) -> None:
    image, result = sample(background)
    write_report(tmp_path / "r.html", image, result)
    for count in range(4):
        visit(browser, tmp_path / "r.html", f"#k={count}")
        assert layers_shown(shown(browser, result.drawing.size), result) == [count]
        assert find(browser, "#slider").get_attribute("value") == str(count)
    assert browser.get_log("browser") == []


def test_address_selects_stages(browser: Any, page: tuple[Path, Result]) -> None:
    file, result = page
    visit(browser, file, "#stage=1")
    assert layers_shown(shown(browser, result.drawing.size), result) == [1]
    assert "after stage 1 of 2: 1 path" in find(browser, "#shown").text
    first = find(browser, "#difference").get_attribute("src")
    find(browser, '.strip a[href="#stage=2"]').click()
    assert layers_shown(shown(browser, result.drawing.size), result) == [3]
    assert find(browser, "#difference").get_attribute("src") != first
    assert find(browser, "#stages tr.current th").text == "2"


def test_keyboard_moves_the_slider(browser: Any, page: tuple[Path, Result]) -> None:
    file, result = page
    visit(browser, file)
    slider = find(browser, "#slider")
    slider.send_keys(Keys.ARROW_LEFT)
    assert (slider.get_attribute("value"), address(browser)) == ("2", "#k=2")
    assert slider.get_attribute("aria-valuetext") == "the first 2 of 3 layers"
    assert layers_shown(shown(browser, result.drawing.size), result) == [2]
    slider.send_keys(Keys.HOME)
    assert address(browser) == "#k=0"
    slider.send_keys(Keys.END)
    assert address(browser) == "#k=3"
    assert find(browser, "#shown").text == "Drawing: 3 layers"


def test_keyboard_reaches_everything(browser: Any, page: tuple[Path, Result]) -> None:
    visit(browser, page[0])
    body, reached = find(browser, "body"), []
    for _ in range(12):
        body = browser.switch_to.active_element
        body.send_keys(Keys.TAB)
        reached.append(browser.execute_script("const e = document.activeElement; return e.id || e.name || e.tagName"))
    assert reached[:6] == ["mode", "play", "slider", "zoom", "outlines", "points"]
    assert reached[6] == "BUTTON" and "SUMMARY" in reached


def test_hovering_a_layer_shows_its_facts(browser: Any, page: tuple[Path, Result]) -> None:
    visit(browser, page[0])
    hint = find(browser, "#facts").text
    assert hint.startswith("Point at a layer")
    pointer = ActionChains(browser)
    path = browser.find_elements(By.CSS_SELECTOR, "#drawing .layers path")[2]
    pointer.move_to_element(path).perform()
    said = find(browser, "#facts").text
    for part in ("green bar top", "#33b333", "visible 3900 px, 8.1 %", "removes an error of", "bytes"):
        assert part in said
    assert find(browser, "#facts .swatch rect").get_attribute("fill") == "#33b333"
    assert "green bar top" in find(browser, "#layers tr.lit").text
    assert len(browser.find_elements(By.CSS_SELECTOR, "#drawing .overlay .lit")) == 2
    ActionChains(browser).move_to_element(find(browser, "h1")).perform()
    assert find(browser, "#facts").text == hint
    rows = browser.find_elements(By.CSS_SELECTOR, "#layers tbody tr")
    ActionChains(browser).move_to_element(rows[0]).perform()
    assert "green bar top" in find(browser, "#facts").text  # the topmost is listed first
    assert "lit" in browser.find_elements(By.CSS_SELECTOR, "#drawing .layers path")[2].get_attribute("class")


def test_gradients_in_the_picture_and_its_facts(browser: Any, tmp_path: Path) -> None:
    drawing = shaded_drawing()
    target = Rasterizer(drawing.size).forward(drawing)
    file = tmp_path / "report.html"
    write_report(file, target, result_of(drawing, target))
    visit(browser, file, "#k=3")  # a chosen layer would be lit
    difference = shown(browser, drawing.size) - target
    assert float(np.mean(np.square(difference, dtype=np.float64))) < 1e-4  # edges: 3e-5; of solid colours: 6e-3
    visit(browser, file, "#k=3&layer=2")
    facts = find(browser, "#facts")
    assert "linear, #ffcc00 to #ff0000 at 40 % (one colour instead: +" in facts.text
    square = Image.open(io.BytesIO(find(browser, "#facts .swatch").screenshot_as_png)).convert("RGB")
    left, right = (square.getpixel((int(x * square.width), square.height // 2)) for x in (0.15, 0.85))
    assert left[1] - left[2] > 100  # yellow
    assert right[0] - right[1] > 60  # red
    assert left[1] > right[1] + 30


def test_list_of_layers_by_keyboard(browser: Any, page: tuple[Path, Result]) -> None:
    visit(browser, page[0])
    find(browser, "#points").send_keys(Keys.TAB)
    assert "green bar top" in find(browser, "#facts").text
    browser.switch_to.active_element.send_keys(Keys.ARROW_DOWN)
    assert "orange circle below center" in find(browser, "#facts").text
    browser.switch_to.active_element.send_keys(Keys.ENTER)
    assert browser.switch_to.active_element.get_attribute("aria-pressed") == "true"
    assert address(browser) == "#k=3&layer=1"
    browser.switch_to.active_element.send_keys(Keys.ESCAPE)
    assert address(browser) == "#k=3"


def test_zoom_enlarges_the_pictures_in_their_frames(browser: Any, page: tuple[Path, Result]) -> None:
    visit(browser, page[0])
    size = "const f = document.querySelectorAll('.frame')[%d]; return [f.clientWidth, f.scrollWidth, f.clientHeight]"
    before = [browser.execute_script(size % index) for index in range(3)]
    find(browser, "#zoom").send_keys(Keys.ARROW_RIGHT, Keys.ARROW_RIGHT)
    for index in range(3):
        width, inner, _ = browser.execute_script(size % index)
        assert width <= before[index][0] and inner > 2.5 * width
    browser.execute_script("document.querySelectorAll('.frame')[1].scrollTo(37, 21)")
    ActionChains(browser).pause(0.3).perform()
    places = "return [...document.querySelectorAll('.frame')].map((f) => [f.scrollLeft, f.scrollTop])"
    assert browser.execute_script(places) == [[37, 21]] * 3


def test_outlines_and_control_points(browser: Any, page: tuple[Path, Result]) -> None:
    file, result = page
    visit(browser, file, "#k=2")
    plain = shown(browser, result.drawing.size)
    find(browser, "#outlines").click()
    assert len(browser.find_elements(By.CSS_SELECTOR, "#drawing .overlay .outline")) == 2
    outlined = shown(browser, result.drawing.size)
    find(browser, "#points").click()
    anchors = browser.find_elements(By.CSS_SELECTOR, "#drawing .overlay .anchors")
    counts = [path.get_attribute("d").count("M") for path in anchors]
    assert counts == np.diff(result.drawing.segment_offsets)[:2].tolist()
    assert address(browser) == "#k=2&outlines=1&points=1"
    assert np.mean(np.abs(outlined - plain)) > 0.001
    assert np.mean(np.abs(shown(browser, result.drawing.size) - outlined)) > 0.001
    find(browser, "#outlines").click()
    find(browser, "#points").click()
    np.testing.assert_array_equal(shown(browser, result.drawing.size), plain)


def test_names_do_no_harm(browser: Any, tmp_path: Path) -> None:
    image, result = sample(names=(NASTY, NASTY, ""))
    write_report(tmp_path / "r.html", image, result, name=NASTY, command=NASTY)
    visit(browser, tmp_path / "r.html", "#k=2&layer=0")
    assert browser.title == NASTY
    assert find(browser, "h1").text == NASTY
    assert "<script>" in find(browser, "#facts").text
    visit(browser, tmp_path / "r.html", "#stage=2")
    path = browser.find_elements(By.CSS_SELECTOR, "#drawing .layers path")[2]
    ActionChains(browser).move_to_element(path).perform()
    assert "after stage 2" in find(browser, "#facts").text
    assert browser.execute_script("return window.hacked") is None
    assert browser.get_log("browser") == []


@pytest.mark.parametrize("hash_", ["#k=99", "#k=-4", "#k=x", "#stage=99", "#stage=0", "#layer=7", "#a=%", "#"])
def test_any_address_shows_something(browser: Any, page: tuple[Path, Result], hash_: str) -> None:
    visit(browser, page[0], hash_)
    assert find(browser, "#controls").is_displayed()
    assert find(browser, "#shown").text.startswith("Drawing: ")
    assert browser.get_log("browser") == []


def test_empty_drawing(browser: Any, tmp_path: Path) -> None:
    image = np.full((8, 9, 3), 0.5, np.float32)
    write_report(tmp_path / "r.html", image, result_of(empty_drawing((8, 9)), image))
    visit(browser, tmp_path / "r.html")
    assert find(browser, "#shown").text == "Drawing: 0 layers"
    assert browser.get_log("browser") == []


def test_light_dark_and_narrow(browser: Any, page: tuple[Path, Result]) -> None:
    grounds = {}
    for scheme in ("light", "dark"):
        features = [{"name": "prefers-color-scheme", "value": scheme}]
        browser.execute_cdp_cmd("Emulation.setEmulatedMedia", {"features": features})
        visit(browser, page[0])
        grounds[scheme] = read_image(browser.get_screenshot_as_png())[-3, 3, :3].mean()
    assert grounds["light"] > 0.9
    assert grounds["dark"] < 0.2
    for width in (320, 700, 1600):
        metrics = {"width": width, "height": 800, "deviceScaleFactor": 1, "mobile": True}
        browser.execute_cdp_cmd("Emulation.setDeviceMetricsOverride", metrics)
        visit(browser, page[0])
        assert browser.execute_script("return document.documentElement.scrollWidth") <= width
    browser.execute_cdp_cmd("Emulation.clearDeviceMetricsOverride", {})


def test_play(browser: Any, page: tuple[Path, Result]) -> None:
    visit(browser, page[0], "#k=3")
    find(browser, "#play").click()
    assert find(browser, "#play").get_attribute("aria-pressed") == "true"
    WebDriverWait(browser, 20).until(lambda b: address(b) == "#k=3" and find(b, "#play").text == "Play")
