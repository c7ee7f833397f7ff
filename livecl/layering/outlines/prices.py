# SPDX-License-Identifier: Apache-2.0
"""Prices of explanations: the description length of shapes, in radians of turning.

A convex outline turns by 2 pi and costs least; each concavity is paid for twice, by turning in and by turning back
(total absolute curvature). Of the explanations of one picture the cheapest is chosen: minimum description length, with
lengths that follow perception (good continuation, closure, convexity).
"""

from __future__ import annotations

import dataclasses

import numpy as np

from livecl.arrays import FloatArray


@dataclasses.dataclass(frozen=True, kw_only=True)
class Prices:
    """Prices of an explanation, in radians of turning, and weights of evidence for depth order.

    Values: chosen once by the order of regions and the overlap with true layers on flat drawings, docs/quality.md.

    Attributes
    ----------
    layer : float
        An additional layer.
    cut : float
        A cut between two parts of one colour, as long as the side of a square of both.
    simple : float
        Largest price of a part that is cut off for it to count as simple: a full turn, four corners, and a radian of
        bending.
    corner : float
        An additional corner, beside its turning.
    hidden : float
        Hidden area equal to the visible area.
    sliver : float
        Ratio of hidden to visible area beyond which the square of the excess costs `hidden` as well.
    accident : float
        A radian by which an outline turns, or begins to turn, exactly where it disappears behind another.
    primitive : float
        Discount of a circle or an ellipse on its turning.
    saving : float
        Least saving for which a shape is changed.
    better : float
        Least advantage of a more complex kind of curve over a simpler one: line, smooth curve, corner in this order.
    ring : float
        Extra cost allowed for joining an outline with itself, which turns a bay into a hole.
    aligned : float
        Saving for two touching simple parts of one colour, for each outline of theirs that continues exactly across the
        contact.
    sure : float
        Evidence from which a region counts as lying in front.
    before : float
        Mean evidence of the shapes beside another from which they lie in front of it, so that none goes on behind it.
    hull, bay, stem : float
        Evidence of a T-junction: for the region whose outline runs straight through it on its convex hull, or in a bay
        of it (where it may be what surrounds the others), and against the region that ends at another's outline.
    bulge : float
        Evidence for the region that bulges into the other one, by the square of its chord.
    completion : float
        Evidence, per radian, for the region behind which completing the other one saves turning.
    marking : float
        Evidence, per radian, for a region that is marked on a larger one: one outline around both saves turning.
    relation, most_relation : float
        Evidence for the region behind which the other one continues into a third of its colour, per radian saved; its
        upper limit.
    size : float
        Evidence for the smaller region, for each factor e of size.
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
    before: float = 1.25
    hull: float = 0.7
    bay: float = -0.4
    stem: float = 0.65
    bulge: float = 0.5
    completion: float = 0.1
    marking: float = 0.2
    relation: float = 0.3
    most_relation: float = 2.0
    size: float = 0.1


PRICES = Prices()
#: Prices used while fewer layers are found than requested: an additional layer is welcome whatever its parts, and short
#: cuts are preferred (Singh, Seyranian and Hoffman, Perception & Psychophysics 61, 1999).
ASKED = dataclasses.replace(PRICES, layer=-3.5, cut=1.0, simple=np.inf)
#: Turning angle, radians, from which a bend counts partly as a corner, and the width of the transition to a full one.
CORNER_FROM, CORNER_OVER = 0.8, 0.5
#: Points of an outline per vertex at which its turning is summed.
STRIDE = 3


def outline_price(points: FloatArray, prices: Prices = PRICES) -> float:
    """Return the price of a closed outline, points (n, 2) at steps of about 1 px: total turning, plus its corners.

    Angles are averaged over three neighbouring vertices, so that jitter of the border cancels.
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
    """Return the price of the hidden part of a known shape, from its whole and visible areas, of any sign."""
    share = max(0.0, abs(whole) / max(abs(seen), 1e-9) - 1)
    return prices.hidden * float(np.log1p(share)) + sliver_price(share, prices)


def sliver_price(share: float, prices: Prices = PRICES) -> float:
    """Return the extra price of a hidden area, given as a multiple of the visible one.

    Nobody draws a disc to show a sliver of it.
    """
    return prices.hidden * max(0.0, share - prices.sliver) ** 2
