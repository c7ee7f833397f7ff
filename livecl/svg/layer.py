# SPDX-License-Identifier: Apache-2.0
"""Layers as read from an SVG: outline, paint, pen, name, stage, groups."""

from __future__ import annotations

import collections
import dataclasses
import functools
import re
from xml.etree.ElementTree import Element

import numpy as np

from livecl.arrays import FloatArray
from livecl.drawing.colors import Rgba
from livecl.drawing.labels import name_from_id
from livecl.geometry import bezier
from livecl.svg.gradients import Gradient
from livecl.svg.pens import Pen
from livecl.svg.writer import INKSCAPE_NAMESPACE, SVG_NAMESPACE

#: Largest number of layers of a translucent group that are tested for overlaps; more count as overlapping.
MAX_COMPARED = 1000

_STAGE_LABEL, _STAGE_ID = re.compile(r"stage (-?\d{1,9})"), re.compile(r"stage-(-?\d{1,9})(-\d+)?")


class LeftOut(collections.Counter[str]):
    """Counter of unsupported features of an SVG by kind, and the errors of approximations."""

    def __init__(self) -> None:
        super().__init__()
        self._errors: dict[str, float] = {}

    def approximate(self, kind: str, error: float) -> None:
        """Count an approximation with the root mean square error `error` in RGBA."""
        self[kind] += 1
        self._errors[kind] = max(error, self._errors.get(kind, 0.0))

    def __str__(self) -> str:
        """Return the kinds in order, with their counts, and the largest errors where there are some."""
        return ", ".join(
            f"{kind} ({count}{f', off by {self._errors[kind]:.2g} at most' if kind in self._errors else ''})"
            for kind, count in sorted(self.items())
        )


@dataclasses.dataclass(frozen=True, kw_only=True)
class ReadLayer:
    """A shape: subpaths (n, 4, 2), px; straight RGBA, or a gradient; stage; id; name; pen, if it is stroked.

    `groups` are those around it, the outermost first, each an element's number in the walk and a name.
    """

    outline: list[FloatArray]
    color: Rgba
    stage: int
    identifier: str
    name: str
    gradient: Gradient | None = None
    pen: Pen | None = None
    is_open: list[bool] | None = None  # of each subpath; None where all are closed
    groups: tuple[tuple[int, str], ...] = ()

    @functools.cached_property
    def bounds(self) -> FloatArray:
        """(x_min, y_min, x_max, y_max) of the control points, and of the pen around them."""
        bounds = bezier.outline_bounds(self.outline)
        return bounds if self.pen is None else bounds + self.pen.width / 2 * np.array([-1, -1, 1, 1])


def layer_name(element: Element, identifier: str) -> str:
    """Return the name of a shape or group: its Inkscape label, or its title, or its id."""
    title = element.find(f"{{{SVG_NAMESPACE}}}title")
    texts = (
        element.get(f"{{{INKSCAPE_NAMESPACE}}}label", ""),
        "" if title is None else "".join(title.itertext()),
        name_from_id(identifier),
    )
    return next((text for text in texts if text.strip()), "")


def stage_match(element: Element) -> re.Match[str] | None:
    """Match a group's stage in Inkscape's label, or, without Inkscape's attributes, in its id."""
    label = element.get(f"{{{INKSCAPE_NAMESPACE}}}label")
    if label is None:
        return _STAGE_ID.fullmatch(element.get("id", ""))
    is_layer = element.get(f"{{{INKSCAPE_NAMESPACE}}}groupmode") == "layer"
    return _STAGE_LABEL.fullmatch(label) if is_layer else None


def is_upright(outline: list[FloatArray]) -> bool:
    """Whether all edges of an outline are horizontal or vertical lines."""
    edges = np.concatenate(outline)
    along = np.abs(edges - edges[:, :1]).max(axis=1)
    return bool((along.min(axis=1) <= 1e-6).all())


def overlap(layers: list[ReadLayer]) -> bool:
    """Whether the boxes of any two layers overlap."""
    if len(layers) > MAX_COMPARED:
        return True
    bounds = np.array([layer.bounds for layer in layers]).reshape(-1, 4)
    for i, box in enumerate(bounds[:-1]):
        later = bounds[i + 1 :]
        if np.any(np.all((later[:, :2] < box[2:]) & (later[:, 2:] > box[:2]), axis=1)):
            return True
    return False


def reach_over(layers: list[ReadLayer], matrix: FloatArray, width: float, height: float) -> bool:
    """Whether a layer extends beyond the rectangle of `width` by `height` px that `matrix` maps to the canvas."""
    if not layers or not np.linalg.det(matrix):
        return False
    cubics = np.concatenate([subpath for layer in layers for subpath in layer.outline])
    points = bezier.evaluate(cubics, np.linspace(0, 1, 9)).reshape(-1, 2)
    x, y = (np.linalg.inv(matrix) @ np.column_stack([points, np.ones(len(points))]).T)[:2]
    slack = 1e-6 * max(width, height)
    return bool(min(x.min(), y.min()) < -slack or x.max() > width + slack or y.max() > height + slack)
