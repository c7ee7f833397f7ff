# SPDX-License-Identifier: Apache-2.0
"""Price list of explanations: what a shape costs to describe, in one unit.

The unit is a radian by which an outline turns. A convex outline turns by 2 pi and costs least; each concavity is paid
for twice, by turning in and by turning back (total absolute curvature). Of explanations of one picture the cheapest is
taken: the minimum description length, with lengths that follow perception (good continuation, closure, convexity).
"""

from __future__ import annotations

import dataclasses

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]


@dataclasses.dataclass(frozen=True, kw_only=True)
class Prices:
    """Prices of an explanation, radians of turning, and the evidence for one region in front of another.

    Values: chosen once by the order of regions and the overlap with true layers on flat drawings, docs/quality.md.

    Attributes
    ----------
    layer : float
        One layer more.
    cut : float
        A cut between two parts of one colour, as long as the side of a square of both.
    simple : float
        Price up to which a part that is cut off is simple: a turn, four corners, and as much bending as an arc of 60
        degrees has twice.
    corner : float
        One corner more, beside its turning.
    hidden : float
        Hidden area as large as the visible one.
    sliver : float
        Hidden area, as a multiple of the visible one, beyond which it costs `hidden` times the square besides.
    accident : float
        A radian by which an outline turns, or begins to, just where it disappears below another.
    primitive : float
        What a circle or an ellipse costs less than its turning.
    saving : float
        Least saving for which a shape is changed.
    better : float
        By which a less simple kind of curve must be cheaper: of line, smooth curve and corner the first comes first.
    ring : float
        What joining an outline with itself may cost more: it makes a hole of a bay.
    aligned : float
        What two simple parts of one colour that touch save for each whose outline goes on exactly where they do.
    sure : float
        Evidence from which on a region counts as lying in front.
    hull, bay, stem : float
        Evidence of a T-junction: for the region whose outline runs straight through it, on its convex hull or in a bay
        of it (where it may be what lies around the others), and against the region that ends at another's outline.
    bulge : float
        Evidence for the region that bulges into the other by its square chord.
    completion : float
        Evidence for the region under which the other saves a radian.
    relation, most_relation : float
        Evidence for the region below which the other goes on in a third of its colour, for a radian saved; at most.
    size : float
        Evidence for the smaller region, for each factor e.
    """

    layer: float = 1.5
    cut: float = 0.0
    simple: float = 2 * np.pi + 3.0
    corner: float = 0.5
    hidden: float = 0.3
    sliver: float = 4.0
    accident: float = 0.5
    primitive: float = 0.5
    saving: float = 0.2
    better: float = 0.05
    ring: float = 0.8
    aligned: float = 1.5
    sure: float = 0.25
    hull: float = 0.7
    bay: float = -0.4
    stem: float = 0.65
    bulge: float = 0.5
    completion: float = 0.1
    relation: float = 0.3
    most_relation: float = 2.0
    size: float = 0.1


PRICES = Prices()
#: Prices while fewer layers are found than are asked for: one more is welcome, whatever its parts; of all cuts short
#: ones are preferred (Singh, Seyranian and Hoffman, Perception & Psychophysics 61, 1999).
ASKED = dataclasses.replace(PRICES, layer=-3.5, cut=1.0, simple=np.inf)
#: Angles, radians, at which a bend starts to count as a corner, and over which it becomes one.
CORNER_FROM, CORNER_OVER = 0.8, 0.5
#: Points of an outline for each of its vertices whose turning is added up.
STRIDE = 3


def outline_price(points: FloatArray, prices: Prices = PRICES) -> float:
    """Return the price of a closed outline, points (n, 2) at steps of about 1 px: total turning, and its corners.

    Angles are averaged over three neighbouring vertices, so that what a border jitters by cancels.
    """
    count = len(points)
    if count < 6:
        return 2 * np.pi
    z = points[:, 0] + 1j * points[:, 1]
    if count >= 14:
        for _ in range(2):
            wide = np.concatenate([z[-2:], z, z[:2]])
            z = (wide[:-4] + wide[4:] + 4 * (wide[1:-3] + wide[3:-1]) + 6 * z) / 16
    vertices = max(8, count // STRIDE)
    z = z[(np.arange(vertices) * count) // vertices]
    steps = np.concatenate([z[1:], z[:1]]) - z
    steps[steps == 0] = 1e-9
    angles = np.angle(np.concatenate([steps[1:], steps[:1]]) / steps)
    bends = np.concatenate([angles[1:], angles[:1]]) + angles + np.concatenate([angles[-1:], angles[:-1]])
    sizes = np.abs(bends)
    rises = sizes >= np.concatenate([sizes[-1:], sizes[:-1]])
    peaks = rises & (sizes > np.concatenate([sizes[1:], sizes[:1]]))
    corners = np.clip((sizes[peaks] - CORNER_FROM) / CORNER_OVER, 0, 1).sum()
    return float(sizes.sum() / 3 + prices.corner * corners)


def hidden_price(whole: float, seen: float, prices: Prices = PRICES) -> float:
    """Return the price of what is hidden of a known shape, from its whole and its visible area, of any sign."""
    share = max(0.0, abs(whole) / max(abs(seen), 1e-9) - 1)
    return prices.hidden * float(np.log1p(share)) + sliver_price(share, prices)


def sliver_price(share: float, prices: Prices = PRICES) -> float:
    """Return what a hidden area, as a multiple of the visible one, costs besides.

    Nobody draws a disc to show a sliver of it.
    """
    return prices.hidden * max(0.0, share - prices.sliver) ** 2
