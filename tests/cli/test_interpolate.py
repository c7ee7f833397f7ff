# SPDX-License-Identifier: Apache-2.0
"""The commands that interpolate and vectorize sequences: what they write, and what they refuse."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from PIL import Image
from support.drawings import BLUE, GREEN, RED, build, rectangle
from support.shapes import circle
from support.strokes import DIGITS, HEIGHT, PEN, draw_frames

import livecl
from livecl.cli import interpolate as interpolation
from livecl.cli import sequence
from livecl.image.reading import save_image
from livecl.interpolation.blending import interpolate
from livecl.svg import format_svg, quantize

SIZE = (32, 40)
A = quantize(build([([circle((12, 16), 8)], RED), ([rectangle(26, 10, 34, 20)], BLUE)], SIZE))
B = quantize(build([([circle((20, 16), 10)], GREEN), ([rectangle(4, 10, 12, 20)], BLUE)], SIZE))
#: Arguments of runs that take a moment.
SHORT = ["--paths", "2", "--iterations", "5"]


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """An empty current folder with two SVGs and two pictures in it."""
    monkeypatch.chdir(tmp_path)
    A.save_svg("a.svg")
    B.save_svg("b.svg")
    for name, drawing in (("a.png", A), ("b.png", B)):
        save_image(name, livecl.render(drawing))
    return tmp_path


def refusal(capsys: pytest.CaptureFixture[str], *arguments: str) -> str:
    """Return the line that the interpolation is refused with, nothing being written."""
    before = sorted(Path().iterdir())
    assert interpolation.main(arguments) == 2
    captured = capsys.readouterr()
    assert captured.out == ""
    assert captured.err.endswith("\n")
    assert captured.err.count("\n") == 1
    assert sorted(Path().iterdir()) == before
    assert captured.err.startswith("livecl-interpolate: error: ")
    return captured.err


def test_folder_of_svgs(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert interpolation.main(["a.svg", "b.svg", "--frames", "3", "-o", "out"]) == 0
    files = sorted((folder / "out").iterdir())
    ends = livecl.read_svg("a.svg"), livecl.read_svg("b.svg")
    assert [file.name for file in files] == ["frame-01.svg", "frame-02.svg", "frame-03.svg"]
    for file, drawing in zip(files, interpolate(*ends, [0, 0.5, 1]), strict=True):
        assert file.read_text(encoding="utf-8") == format_svg(drawing)
    assert capsys.readouterr() == ("", "out: 3 drawings of 2 layers\n")


def test_animated_svg(folder: Path) -> None:
    assert interpolation.main(["a.svg", "b.svg", "-o", "out.svg", "-q", "--seconds", "3", "--one-way"]) == 0
    text = (folder / "out.svg").read_text(encoding="utf-8")
    assert text.count("<animate ") == 3  # the disc's shape and colour, the rectangle's shape
    assert 'dur="4s"' in text  # and half a second at either end


def test_gif_and_strip(folder: Path) -> None:
    arguments = ["a.svg", "b.svg", "--frames", "4", "--scale", "0.5"]
    assert interpolation.main([*arguments, "-o", "out.gif"]) == 0
    with Image.open("out.gif") as image:
        assert (image.size, image.n_frames) == ((20, 16), 6)  # two of them on the way back
    assert interpolation.main([*arguments, "-o", "out.png"]) == 0
    assert livecl.read_image("out.png").shape == (16, 4 * 20 + 3 * 2, 3)


def test_options_reach_the_method(folder: Path) -> None:
    assert interpolation.main(["a.svg", "b.svg", "-o", "out.svg", "--match", "nearest", "--lone", "grow"]) == 0
    # The rectangles are paired; the discs differ too much in colour, so one shrinks and the other grows.
    text = (folder / "out.svg").read_text(encoding="utf-8")
    assert text.count("<path ") == 3
    assert "fill-opacity" not in text


def test_pictures_are_vectorized(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert interpolation.main(["a.png", "b.svg", "-o", "out.svg", *SHORT]) == 0
    err = capsys.readouterr().err
    assert "a.png: " in err
    assert "b.svg: " not in err


def test_other_canvas_is_scaled(folder: Path) -> None:
    B.replace(size=(64, 80), points=2 * B.points).save_svg("large.svg")
    assert interpolation.main(["a.svg", "large.svg", "--frames", "2", "-o", "out"]) == 0
    np.testing.assert_allclose(livecl.read_svg("out/frame-02.svg").points, interpolate(A, B, 1).points, atol=1e-3)


@pytest.mark.parametrize("ends", [("a.svg", "clear.svg"), ("clear.svg", "a.svg")])
def test_a_lone_background_is_that_of_both(
    folder: Path, capsys: pytest.CaptureFixture[str], ends: tuple[str, str]
) -> None:
    A.replace(background=(0.2, 0.4, 0.6)).save_svg("a.svg")
    B.replace(background=None).save_svg("clear.svg")
    assert interpolation.main([*ends, "--frames", "3", "-o", "out"]) == 0
    assert "clear.svg has no background, and gets that of a.svg\n" in capsys.readouterr().err
    for number in (1, 2, 3):
        np.testing.assert_allclose(livecl.read_svg(f"out/frame-{number:02}.svg").background, (0.2, 0.4, 0.6))


def test_refusals(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    Path("file").write_text("no picture", encoding="utf-8")
    cases = {
        "there is no such file|No such file": ["none.svg", "b.svg", "-o", "out.svg"],
        "not a picture of a kind": ["a.svg", "file", "-o", "out.svg"],
        "out.mp4: the format .mp4 is not known": ["a.svg", "b.svg", "-o", "out.mp4"],
        "cannot write into nowhere": ["a.svg", "b.svg", "-o", "nowhere/out.svg"],
        "file: is a file, wanted a folder": ["a.svg", "b.svg", "-o", "file"],
        "a.svg: is an input and would be overwritten": ["a.svg", "b.svg", "-o", "a.svg"],
        "--frames: got '1', wanted a whole number of at least 2": ["a.svg", "b.svg", "-o", "o.svg", "--frames", "1"],
        "--seconds: got 'inf'": ["a.svg", "b.svg", "-o", "out.svg", "--seconds", "inf"],
        "device 'warp' names no device": ["a.svg", "b.svg", "-o", "out.gif", "--device", "warp"],
        "the following arguments are required": ["a.svg", "-o", "out.svg"],
    }
    for message, arguments in cases.items():
        line = refusal(capsys, *arguments)
        assert any(part in line for part in message.split("|")), line


def test_sequence(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (folder / "frames").mkdir()
    for index, image in enumerate(draw_frames("2", "3", 3, side=32)):
        save_image(f"frames/{index}.png", image)
    assert sequence.main(["frames", "-o", "out", "--refine-iterations", "5", *SHORT]) == 0
    drawings = [livecl.read_svg(f"out/frame-{number:02}.svg") for number in (1, 2, 3)]
    assert len({drawing.num_segments for drawing in drawings}) == 1
    assert "out: 3 drawings of" in capsys.readouterr().err
    assert sequence.main(["frames/0.png", "frames/2.png", "-q", "-o", "out.svg", *SHORT]) == 0
    assert "<animate " in (folder / "out.svg").read_text(encoding="utf-8")
    assert capsys.readouterr() == ("", "")


def test_sequence_refusals(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (folder / "empty").mkdir()
    save_image("other.png", np.ones((8, 8, 3)))
    for message, frames in (
        ("empty: holds no pictures", ["empty"]),
        ("other.png: is of (8, 8) px, wanted (32, 40) as a.png", ["a.png", "other.png"]),
        ("none.png: there is no such file", ["none.png"]),
    ):
        assert sequence.main([*frames, "-o", "out.svg"]) == 2
        assert message in capsys.readouterr().err


def test_digits_are_pen_strokes() -> None:
    for digit in DIGITS:
        image = draw_frames(digit, "2" if digit != "2" else "3", 2, side=48)[0]
        assert image.shape == (48, 48, 3)
        assert {0.0, 1.0} <= set(np.unique(image))
        # A stroke at least as long as the digit is high, and at most twice as long as the side, as wide as the pen.
        assert 2 * PEN * HEIGHT < image.mean() < 2 * 2 * PEN
