# SPDX-License-Identifier: Apache-2.0
"""The scripts of examples/: each runs, writes what it says, and leaves nothing in the repository."""

from __future__ import annotations

import re
import subprocess
import sys
from pathlib import Path

import pytest

from livecl import read_image, read_svg

EXAMPLES = Path(__file__).resolve().parents[2] / "examples"
WRITTEN = {
    "logo": {"logo.svg", "logo.html", "stages.png"},
    "photograph": {"photograph.svg", "photograph.gif"},
    "custom_loss": {"before.svg", "after.svg"},
    "scipy_optimizer": {"face.svg"},
    "strokes": {"strokes.svg"},
    "sketch": {"sketch.svg"},
    "letters": {"letters.svg"},
    "refine": {"traced.svg", "refined.svg"},
}


def present() -> list[Path]:
    """Return the files of the folder, compiled modules apart."""
    return [file for file in sorted(EXAMPLES.rglob("*")) if "__pycache__" not in file.parts]


@pytest.mark.slow
@pytest.mark.parametrize("name", WRITTEN)
def test_script(name: str, tmp_path: Path) -> None:
    files = present()
    command = [sys.executable, EXAMPLES / f"{name}.py", tmp_path]
    done = subprocess.run(command, capture_output=True, text=True, timeout=240, check=False)
    assert done.returncode == 0, done.stderr
    assert {file.name for file in tmp_path.iterdir()} == WRITTEN[name]
    for file in tmp_path.iterdir():
        if file.suffix == ".svg":
            assert read_svg(file).num_layers > 0
        elif file.suffix in (".png", ".gif"):
            assert read_image(file).std() > 0.1
    assert present() == files
    improved = re.search(r"MSE (\S+) -> ([^\s:]+)", done.stdout)
    if name not in ("logo", "photograph"):
        assert improved is not None
        assert float(improved[2]) < float(improved[1]) / 2


def test_all_scripts_are_tested() -> None:  # `make` in test_packaging.py, the autoencoder in test_vae_example.py
    assert {file.stem for file in EXAMPLES.glob("*.py")} == {*WRITTEN, "make", "vae_interpolation"}
