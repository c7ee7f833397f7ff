# SPDX-License-Identifier: Apache-2.0
"""Synthetic digits, drawn with a round pen along random skeletons: data for the VAE without MNIST."""

from __future__ import annotations

import dataclasses

import numpy as np
from scipy.interpolate import CubicSpline

from livecl.arrays import FloatArray
from livecl.vae.mnist import SIDE, Digits

#: Height of a digit, px, as MNIST's.
HEIGHT = 20.0
#: Standard deviation of each key point, as a share of the height.
JITTER = 0.035
#: Ranges of random parameters: radius of the pen, px; share of the height; width to height; slant, as the tangent of an
#: angle; turn, radians; shift, px.
RADII, SCALES, ASPECTS = (1.0, 1.7), (0.88, 1.0), (0.8, 1.15)
SLANTS, TURNS, SHIFTS = (-0.1, 0.45), (-0.1, 0.1), (-0.5, 0.5)
#: Number of stamps of the pen along a stroke. On the longest, an 8's, they are up to 0.65 px apart, so the scallops
#: between them are at most R - sqrt(R^2 - 0.33^2) = 0.06 px deep, for the thinnest pen, R = 1.
STAMPS = 192

Point = tuple[float, float]


@dataclasses.dataclass(frozen=True)
class Skeleton:
    """One form of a digit.

    Attributes
    ----------
    points : tuple of (x, y)
        Key points; x to the right, y down, the digit's height is 1.
    strokes : tuple of tuple of int
        Key points of each stroke, a smooth curve through them; closed if it ends at its first.
    """

    points: tuple[Point, ...]
    strokes: tuple[tuple[int, ...], ...]

    def stamps(self) -> FloatArray:
        """Return the weights of the key points in the stamps of all strokes, (T, K)."""
        points = np.array(self.points)
        rows = []
        for stroke in self.strokes:
            steps = np.hypot(*np.diff(points[list(stroke)], axis=0).T)
            knots = np.concatenate([[0.0], np.cumsum(steps)])
            times = np.linspace(0, knots[-1], STAMPS)
            choose = np.eye(len(points))[list(stroke)]
            ends = "periodic" if stroke[0] == stroke[-1] else "natural"
            rows.append(CubicSpline(knots, choose, bc_type=ends)(times))
        return np.concatenate(rows)


#: Forms of each digit, 0 to 9.
SKELETONS: tuple[tuple[Skeleton, ...], ...] = (
    (
        Skeleton(
            ((0.0, -0.5), (-0.28, -0.25), (-0.3, 0.2), (0.0, 0.5), (0.29, 0.22), (0.28, -0.24)),
            ((0, 1, 2, 3, 4, 5, 0),),
        ),
    ),
    (
        Skeleton(((0.0, -0.5), (0.0, 0.0), (0.0, 0.5)), ((0, 1, 2),)),
        Skeleton(((0.02, -0.5), (0.02, 0.0), (0.02, 0.5), (-0.2, -0.27)), ((3, 0), (0, 1, 2))),
    ),
    (
        Skeleton(
            ((-0.28, -0.28), (-0.02, -0.5), (0.27, -0.26), (0.08, 0.12), (-0.32, 0.48), (0.34, 0.46)),
            ((0, 1, 2, 3, 4), (4, 5)),
        ),
    ),
    (
        Skeleton(
            ((-0.27, -0.38), (0.0, -0.5), (0.24, -0.28), (-0.06, -0.03), (0.3, 0.23), (0.0, 0.5), (-0.3, 0.36)),
            ((0, 1, 2, 3), (3, 4, 5, 6)),
        ),
    ),
    (
        Skeleton(((0.16, -0.5), (-0.32, 0.17), (0.34, 0.15), (0.16, 0.0), (0.14, 0.5)), ((0, 1), (1, 2), (0, 3, 4))),
        Skeleton(((-0.24, -0.48), (-0.26, 0.02), (0.3, 0.02), (0.22, -0.5), (0.2, 0.5)), ((0, 1), (1, 2), (3, 4))),
    ),
    (
        Skeleton(
            ((0.28, -0.49), (-0.18, -0.47), (-0.24, -0.07), (0.06, -0.14), (0.3, 0.16), (0.02, 0.5), (-0.3, 0.37)),
            ((0, 1), (1, 2), (2, 3, 4, 5, 6)),
        ),
    ),
    (
        Skeleton(
            ((0.16, -0.5), (-0.2, -0.1), (-0.24, 0.28), (0.02, 0.5), (0.26, 0.24), (0.02, 0.02), (-0.25, 0.2)),
            ((0, 1, 2, 3, 4, 5, 6),),
        ),
    ),
    (
        Skeleton(((-0.3, -0.48), (0.3, -0.48), (0.06, 0.0), (-0.06, 0.5)), ((0, 1), (1, 2, 3))),
        Skeleton(
            ((-0.3, -0.48), (0.3, -0.48), (0.06, 0.0), (-0.06, 0.5), (-0.16, 0.02), (0.26, 0.0)),
            ((0, 1), (1, 2, 3), (4, 5)),
        ),
    ),
    (
        Skeleton(
            ((0.0, -0.5), (-0.23, -0.27), (0.0, -0.04), (0.28, 0.25), (0.0, 0.5), (-0.28, 0.25), (0.23, -0.28)),
            ((0, 1, 2, 3, 4, 5, 2, 6, 0),),
        ),
    ),
    (
        Skeleton(
            ((0.24, -0.26), (0.0, -0.5), (-0.24, -0.24), (-0.02, 0.0), (0.22, 0.0), (0.16, 0.5)),
            ((0, 1, 2, 3, 0), (0, 4, 5)),
        ),
    ),
)


def draw_digits(count: int, *, seed: int = 0) -> Digits:
    """Draw digits by moving a round pen along skeletons whose key points, size, slant and pen vary.

    Parameters
    ----------
    count : int
        Number of digits; labels repeat 0, 1 ... 9.
    seed : int
        Same count and seed: same digits.

    Returns
    -------
    Digits
        White on black, each centred by its box and shifted by up to half a pixel.
    """
    if count < 1:
        raise ValueError(f"count: got {count}, wanted at least 1")
    rng = np.random.default_rng(seed)
    stamps = [[(skeleton, skeleton.stamps()) for skeleton in ways] for ways in SKELETONS]
    labels = (np.arange(count) % len(stamps)).astype(np.uint8)
    images = np.empty((count, SIDE, SIDE), np.float32)
    for image, label in zip(images, labels, strict=True):
        skeleton, weights = stamps[label][rng.integers(len(stamps[label]))]
        points = np.array(skeleton.points) + rng.normal(scale=JITTER, size=(len(skeleton.points), 2))
        image[:] = stamped(_placed(weights @ points, rng), rng.uniform(*RADII))
    return Digits(images, labels)


def _placed(stamps: FloatArray, rng: np.random.Generator) -> FloatArray:
    """Return the stamps (T, 2) of a skeleton in the picture, px."""
    slant, turn = rng.uniform(*SLANTS), rng.uniform(*TURNS)
    sheared = np.array(((rng.uniform(*ASPECTS), -slant), (0.0, 1.0)))
    turned = np.array(((np.cos(turn), -np.sin(turn)), (np.sin(turn), np.cos(turn))))
    placed = stamps @ (turned @ sheared).T
    low, high = placed.min(axis=0), placed.max(axis=0)
    size = HEIGHT * rng.uniform(*SCALES) / max(high - low)
    return (placed - (low + high) / 2) * size + SIDE / 2 + rng.uniform(*SHIFTS, size=2)


def stamped(stamps: FloatArray, radius: float, side: int = SIDE) -> FloatArray:
    """Return a picture (side, side) of discs of a radius, px, at the stamps (T, 2).

    It is 1 inside, with a ramp 1 px wide across the edge.
    """
    centers = np.arange(side) + 0.5
    across, down = np.square(centers[:, None] - stamps[:, 0]), np.square(centers[:, None] - stamps[:, 1])
    distance = np.sqrt((down[:, None] + across).min(axis=2))
    return np.clip(radius + 0.5 - distance, 0.0, 1.0)
