# SPDX-License-Identifier: Apache-2.0
"""Pictures of what Chromium shows, where it is installed."""

from __future__ import annotations

import shutil
import subprocess
import tempfile
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from livecl.image.reading import read_image

#: How it is started: without a window, and without anything from the network.
FLAGS = [
    *("--headless", "--no-sandbox", "--disable-gpu", "--disable-quic", "--no-first-run", "--hide-scrollbars"),
    *("--disable-background-networking", "--disable-component-update", "--disable-sync"),
    "--force-device-scale-factor=1",
]
#: What the window is larger than the picture, px: some versions count the browser's own frame.
_MARGIN = 200


def program() -> str | None:
    """Return Chromium's path, where it is installed."""
    return shutil.which("chromium") or shutil.which("chromium-browser")


def screenshot(
    url_or_path: str | Path, size: tuple[int, int], background: str = "ffffffff", seconds: float = 90
) -> NDArray[np.float32]:
    """Return what Chromium shows of a page or a file, in a window of `size` (height, width): (H, W, 3).

    `background` is the RGBA beneath the page, in hexadecimal. Skips the test where Chromium is absent.
    """
    if (chromium := program()) is None:
        pytest.skip("Chromium is not installed")
    url = url_or_path.resolve().as_uri() if isinstance(url_or_path, Path) else url_or_path
    with tempfile.TemporaryDirectory(ignore_cleanup_errors=True) as folder:
        picture = Path(folder) / "picture.png"
        command = [
            chromium,
            *FLAGS,
            f"--user-data-dir={folder}/profile",
            f"--default-background-color={background}",
            f"--screenshot={picture}",
            f"--window-size={size[1] + _MARGIN},{size[0] + _MARGIN}",
            url,
        ]
        run = subprocess.run(command, capture_output=True, text=True, timeout=seconds, check=False)
        if not picture.is_file():
            pytest.fail(f"Chromium made no picture: {run.stderr[-500:]}")
        image: NDArray[np.float32] = read_image(picture)[: size[0], : size[1], :3]
        return image
