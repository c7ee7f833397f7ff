# SPDX-License-Identifier: Apache-2.0
"""The floor of a case: the least that an iteration has to compute and to move.

An operation is one addition, multiplication, comparison, division or root of two numbers; a multiply-add is two.
"""

from __future__ import annotations

from benchmark.counts import TILE, Counts
from benchmark.limit import Floor

PIXELS = TILE * TILE

#: A vertex: 3 multiplications and 3 additions for x and for y; backward, 4 control points take shares of its 2 numbers.
LINE = 2 * (3 + 3) + 4 * 2 * 2
#: Forward, where a line crosses a pixel: where it leaves (2) and the other coordinate there (2), its height (1), the
#: mean distance from the left border (3), its share and the product (2), two sums (2).
CELL_FORWARD = 2 + 2 + 1 + 3 + 2 + 2
#: Backward: the same walk (4), two parameters (4), the slope of min(|A|, 1) (2), g times their difference (2), their
#: mean (2), two weighted sums (5).
CELL_BACKWARD = 4 + 4 + 2 + 2 + 2 + 5
#: Coverage of a pixel of a tile that an outline passes: running sum and its use (2), |A| and the minimum with 1 (2).
EDGE_PIXEL = 2 + 2
#: Distance weight of a pixel in a layer's band, had it only one line near: offset (2), parameter along the line (4) and
#: its bounds (2), offset from there (4), square (3), smallest so far (1), tau - root (2), sum (1), factor and sum (2).
BAND_PIXEL = 2 + 4 + 2 + 4 + 3 + 1 + 2 + 1 + 2
#: A layer over what lies below it: alpha (1), and for 3 channels difference, product, sum (9); backward, d_alpha from
#: the same differences (6), d_color (6), what goes on to the layers below (6), d_opacity (2), d_coverage (1).
BLEND_PIXEL = 1 + 9 + 6 + 6 + 6 + 2 + 1
#: Error of a lit pixel: its weight (1); for 3 channels difference, weighted, squared and summed, doubled (5 each).
ERROR_PIXEL = 1 + 3 * 5
#: Xing loss and gradient of a segment: three differences (6), two lengths (8), two directions (4), two products (6),
#: and for the gradient two rejections, scaled and added to four points (22).
XING_SEGMENT = 6 + 8 + 4 + 6 + 22
#: Adam: mean (3), square (4), root, quotient, rate, change (5).
PARAMETER = 3 + 4 + 5

#: Bytes of the target in a lit pixel, three floats.
TARGET_PIXEL = 3 * 4
#: Bytes of closeness in a band pixel, written and read: the weight's sum is known only after all of them.
CLOSENESS_PIXEL = 2 * 4
#: Bytes of a parameter: it goes to the device and its gradient comes back, as floats; Adam reads and writes it and its
#: two moments as doubles.
PARAMETER_BYTES = 2 * 4 + 2 * 3 * 8


def operations(scene: Counts) -> dict[str, float]:
    """Return the operations of an iteration by what they are for."""
    return {
        "flatten": LINE * scene.lines,
        "coverage": CELL_FORWARD * scene.cells + EDGE_PIXEL * PIXELS * scene.edge_tiles,
        "outline gradient": CELL_BACKWARD * scene.cells,
        "distance weight": BAND_PIXEL * PIXELS * scene.band_tiles,
        "compositing": BLEND_PIXEL * (PIXELS * scene.blended_tiles + scene.flat_tiles),
        "error": ERROR_PIXEL * PIXELS * scene.lit_tiles,
        "Xing, Adam": XING_SEGMENT * scene.segments + PARAMETER * _parameters(scene),
    }


def floor(scene: Counts) -> Floor:
    """Return the floor of an iteration on a scene."""
    moved = (
        TARGET_PIXEL * PIXELS * scene.lit_tiles
        + CLOSENESS_PIXEL * PIXELS * scene.band_tiles
        + PARAMETER_BYTES * _parameters(scene)
    )
    return Floor(sum(operations(scene).values()), moved, moved)


def _parameters(scene: Counts) -> int:
    return 6 * scene.segments + 4 * scene.layers
