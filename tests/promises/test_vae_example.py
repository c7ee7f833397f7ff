# SPDX-License-Identifier: Apache-2.0
"""The tool that vectorizes what lies between digits, on a model that is hardly trained."""

from __future__ import annotations

import struct
from pathlib import Path

import numpy as np
import pytest
import vae_interpolation as tool

import livecl
from livecl.vae.drawn_digits import draw_digits
from livecl.vae.mnist import IMAGES_MAGIC, LABELS_MAGIC
from livecl.vae.model import Vae

QUICK = ("--frames", "3", "--grid", "2", "--paths", "2", "--iterations", "5", "--size", "32", "-q")


@pytest.fixture(autouse=True)
def _few_digits(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(tool, "DRAWN", 600)


@pytest.fixture
def mnist(tmp_path: Path) -> Path:
    """Return a folder with 560 drawn digits in MNIST's files."""
    digits = draw_digits(560, seed=7)
    folder = tmp_path / "mnist"
    folder.mkdir()
    grey = np.rint(digits.images * 255).astype(np.uint8)
    head = struct.pack(">4I", IMAGES_MAGIC, *grey.shape)
    (folder / "train-images-idx3-ubyte").write_bytes(head + grey.tobytes())
    head = struct.pack(">2I", LABELS_MAGIC, len(digits))
    (folder / "train-labels-idx1-ubyte").write_bytes(head + digits.labels.tobytes())
    return folder


def test_writes_model_curve_and_figures(tmp_path: Path, mnist: Path) -> None:
    for name in ("a", "b"):
        assert tool.main(["-o", str(tmp_path / name), "--mnist", str(mnist), "--steps", "30", *QUICK]) == 0
    output = tmp_path / "a"
    assert Vae.load(output / "vae.npz").size == (28, 28)
    curve = np.loadtxt(output / "vae-loss.csv", delimiter=",", skiprows=1)
    assert curve.shape == (30, 3)
    assert curve[-1, 1] < curve[0, 1]
    # Two rows of three pictures of 32 px, and two of two, with lines of 2 px between.
    assert livecl.read_image(output / "vae-strip.png").shape == (66, 100, 3)
    assert livecl.read_image(output / "vae-grid.png").shape == (66, 66, 3)
    assert sorted(file.name for file in (output / "vae-strip").iterdir()) == ["01.svg", "02.svg", "03.svg"]
    assert sorted(file.name for file in (output / "vae-grid").iterdir()) == [
        f"{row}-{column}.svg" for row in ("01", "02") for column in ("01", "02")
    ]
    first = livecl.read_svg(output / "vae-strip" / "01.svg")
    assert first.size == (32, 32)
    assert first.background.tolist() == [0, 0, 0]
    for file in (file for file in output.rglob("*") if file.is_file() and file.name != "vae-loss.png"):
        assert file.read_bytes() == (tmp_path / "b" / file.relative_to(output)).read_bytes()


def test_takes_a_model(tmp_path: Path) -> None:
    Vae.start((28, 28), (8,), 3, np.random.default_rng(0)).save(tmp_path / "vae.npz")
    arguments = ["-o", str(tmp_path / "out"), "--model", str(tmp_path / "vae.npz"), "--ends", "17", *QUICK]
    # Of a model without training the pictures are grey all over: not black, so there is a layer.
    assert tool.main(arguments) == 0
    assert not (tmp_path / "out" / "vae.npz").exists()
    assert (tmp_path / "out" / "vae-strip.svg").is_file()


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["--ends", "3"], "argument --ends: got '3', wanted 2 digits one after the other"),
        (["--corners", "12x4"], "argument --corners: got '12x4', wanted 4 digits"),
        (["--mnist", "nowhere"], "nowhere: there is no train-images-idx3-ubyte"),
        (["--model", "nowhere.npz"], "'nowhere.npz' is not a saved VAE"),
        (["--model", "small.npz"], "small.npz: a model of pictures of (4, 4) px, wanted (28, 28)"),
        (["--steps", "0"], "argument --steps: got '0'"),
    ],
)
def test_bad_input(
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
    arguments: list[str],
    message: str,
) -> None:
    monkeypatch.chdir(tmp_path)
    Vae.start((4, 4), (8,), 3, np.random.default_rng(0)).save("small.npz")
    assert tool.main(["-o", "out", *arguments]) == 2
    assert message in capsys.readouterr().err
    assert not Path("out").exists()


def test_too_few_digits(
    tmp_path: Path, mnist: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(tool, "HELD_OUT", 560)
    assert tool.main(["-o", str(tmp_path / "out"), "--mnist", str(mnist)]) == 2
    assert "560 digits, wanted more than the 560 held out" in capsys.readouterr().err


def test_frame_covers_the_border_only() -> None:
    framed = tool.framed(np.zeros((8, 8, 3), np.float32))
    assert not framed[2:-2, 2:-2].any()
    border = np.ones((8, 8), bool)
    border[2:-2, 2:-2] = False
    np.testing.assert_array_equal(framed[border], np.broadcast_to(np.float32(tool.FRAME_COLOR), (48, 3)))
