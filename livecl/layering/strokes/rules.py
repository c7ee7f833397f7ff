# SPDX-License-Identifier: Apache-2.0
"""Thresholds that define a stroke."""

from __future__ import annotations

import dataclasses


@dataclasses.dataclass(frozen=True, kw_only=True)
class StrokeRules:
    """Thresholds that define a stroke.

    Values: set by hand on ten line drawings. docs/strokes.md has the errors on those, and on others drawn afterwards.

    Attributes
    ----------
    oversampling : int
        Samples per pixel, in each direction, at which the border of ink is located.
    blur : float
        Standard deviation, px, of the Gaussian that removes noise and pixel steps from coverages and lines.
    slenderness, branch : float
        Least length of a stroke in widths: of one by itself, and of a branch of a shape that has other lines.
    roundness : float
        Least intersection over union of a spot with a dot, or with a short line with round ends.
    clear : float
        Least share of a closed line that must lie on an ellipse for the ellipse to replace it.
    near : int
        Neighbourhood, pixels, whose largest coverage is that of the line's middle; the border is at half of it.
    faint : float
        Least smoothed coverage at a line's border.
    widest : float
        Largest width of a line, as a share of the picture's shorter side, with the option `strokes` auto.
    dot : float
        Largest diameter of a dot, in widths of the widest line, with the option `strokes` auto; larger ones are discs.
    thick : float
        Least radius of a dot, in half widths of the lines that it lies on.
    drawn : float
        Largest share of a dot that lines of its shape may cover.
    tail : float
        Least distance of a line's end to the border, in half widths; the skeleton may run on into a corner.
    evenness : float
        Largest coefficient of variation (standard deviation over mean) of a line's width.
    same_width : float
        Largest ratio of two equal widths.
    one_width, long : float
        The same for lines longer than `long` widths, whose width is known well.
    same_shade : float
        Largest ratio of two equal strengths.
    rounding : float
        Radius of an arc, in half widths of its line, up to which it counts as a corner.
    distance : float
        Largest distance, px, between the centre line of ink and the fitted line.
    step, margin : float
        Sampling step, px, of the coverage profile across a line, and its extent beyond the border, px.
    middle : float
        Quantile, along a line, of the largest coverage near its middle, that is taken as its strength.
    full : float
        Strength from which a line counts as full-strength ink.
    trusted : float
        Largest ratio between the widths by coverage and by distance to the border at which the former is trusted.
    explained : float
        Least intersection over union of strokes and ink for a picture to be line art, with the option `strokes` auto.
    line_art : float
        The same for a picture of which nothing but lines and paper is drawn, with the option `strokes` auto: what is
        left is noise, texture of the paper, and blurred edges.
    paper : float
        Largest difference of the paper's colour from the background for which the background is the paper.
    """

    oversampling: int = 3
    blur: float = 0.5
    slenderness: float = 1.5
    branch: float = 1.0
    roundness: float = 0.85
    clear: float = 0.85
    near: int = 2
    faint: float = 0.25
    widest: float = 0.2
    dot: float = 2.5
    thick: float = 1.6
    drawn: float = 0.5
    tail: float = 0.8
    evenness: float = 0.3
    same_width: float = 1.3
    one_width: float = 1.12
    long: float = 8.0
    same_shade: float = 1.2
    rounding: float = 0.4
    distance: float = 0.35
    step: float = 0.25
    margin: float = 1.5
    middle: float = 0.75
    full: float = 0.88
    trusted: float = 1.5
    explained: float = 0.85
    line_art: float = 0.93
    paper: float = 0.02


RULES = StrokeRules()
