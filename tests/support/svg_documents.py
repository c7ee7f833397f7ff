# SPDX-License-Identifier: Apache-2.0
"""Helpers for tests of reading SVG: documents around a body, and comparison of drawings."""

from __future__ import annotations

import math
import warnings
from collections.abc import Sequence

import numpy as np
import pytest
from numpy.typing import ArrayLike, NDArray

from livecl.drawing.drawing import Drawing
from livecl.svg import read_svg

NAMESPACES = 'xmlns="http://www.w3.org/2000/svg" xmlns:xlink="http://www.w3.org/1999/xlink"'


def document(body: str, attributes: str = 'width="100" height="100"') -> bytes:
    return f"<svg {NAMESPACES} {attributes}>{body}</svg>".encode()


def read(body: str, attributes: str = 'width="100" height="100"') -> Drawing:
    """Read a document that nothing is left out of."""
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        return read_svg(document(body, attributes))


def read_path(data: str) -> Drawing:
    return read(f'<path d="{data}"/>')


def left_out(body: str) -> tuple[Drawing, str]:
    """Read a document with one warning, and return what that names."""
    with pytest.warns(UserWarning, match="not representable") as caught:
        drawing = read_svg(document(body))
    assert len(caught) == 1
    return drawing, str(caught[0].message).partition("paths: ")[2]


def lines(*corners: ArrayLike) -> NDArray[np.float64]:
    """Return the closed polygon as rows (anchor, handle, handle)."""
    start = np.array(corners, dtype=np.float64)
    end = np.roll(start, -1, axis=0)
    return np.stack([start, start + (end - start) / 3, end - (end - start) / 3], axis=1)


def assert_points(drawing: Drawing, *wanted: ArrayLike) -> None:
    np.testing.assert_allclose(drawing.points, np.concatenate([np.asarray(part) for part in wanted]), atol=1e-9)


def shifted(points: NDArray[np.float64], x: float, y: float) -> NDArray[np.float64]:
    moved: NDArray[np.float64] = points + np.array([x, y])
    return moved


SQUARE = lines((1, 2), (4, 2), (4, 6), (1, 6))


def quarter(start: float, center: Sequence[float], radii: Sequence[float]) -> NDArray[np.float64]:
    """Return (anchor, handle, handle) of a quarter of an ellipse, clockwise on the screen from an angle in turns."""
    k = 4 / 3 * (math.sqrt(2) - 1)
    u = np.array([math.cos(2 * math.pi * start), math.sin(2 * math.pi * start)])
    v = np.array([-u[1], u[0]])
    return np.array([u, u + k * v, v + k * u]) * radii + center
