# SPDX-License-Identifier: Apache-2.0
"""The folder that tests of the command line work in, and summaries that do not depend on the machine's speed."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest

from livecl.image.reading import save_image


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """An empty current folder with a picture in it: a red square on white, 32x32."""
    image = np.ones((32, 32, 3))
    image[8:24, 10:26] = (0.8, 0.1, 0.1)
    save_image(tmp_path / "in.png", image)
    monkeypatch.chdir(tmp_path)
    return tmp_path


@pytest.fixture(autouse=True)
def no_output_is_slow(monkeypatch: pytest.MonkeyPatch) -> None:
    """Let the summary name no output that took long: on a slow machine any may."""
    monkeypatch.setattr("livecl.cli.picture.SLOW_OUTPUT", math.inf)
