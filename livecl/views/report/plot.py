# SPDX-License-Identifier: Apache-2.0
"""The report's plot: mean squared error against the number of paths, as SVG."""

from __future__ import annotations

import itertools
import math
from collections.abc import Sequence

from livecl.run.result import Stage
from livecl.views.report.markup import number_text, text
from livecl.views.sheet import count_of

#: Size of the plot, px, and its margins: left, right, top, bottom.
_PLOT, _MARGINS = (544, 270), (56, 14, 24, 40)


def error_plot(stages: Sequence[Stage]) -> str:
    """Return the mean squared error against the number of paths as an SVG picture, on a logarithmic scale."""
    counts, errors = [stage.paths for stage in stages], [stage.mse for stage in stages]
    logarithmic = min(errors) > 0
    low, high = (min(errors), max(errors)) if logarithmic else (0.0, max(errors) or 1.0)
    ticks = _log_ticks(low, high) if logarithmic else [high * step / 4 for step in range(5)]
    low, high = min(low, ticks[0]), max(high, ticks[-1])
    left, right, top, bottom = _MARGINS
    x_ticks = _whole_ticks(min(counts), max(counts))
    x_low, x_high = min(counts), max(counts)

    def x_of(count: float) -> str:
        share = (count - x_low) / (x_high - x_low) if x_high > x_low else 0.5
        return number_text(left + 10 + share * (_PLOT[0] - left - right - 20), 1)

    def y_of(error: float) -> str:
        scale = math.log if logarithmic else float
        span = scale(high) - scale(low)
        share = (scale(error) - scale(low)) / span if span else 0.5
        return number_text(_PLOT[1] - bottom - share * (_PLOT[1] - top - bottom), 1)

    floor = _PLOT[1] - bottom
    grid = ['<text x="4" y="10">mean squared error</text>']
    for tick in ticks:
        grid.append(f'<path class="grid" d="M{left} {y_of(tick)}H{_PLOT[0] - right}"/>')
        grid.append(f'<text x="{left - 8}" y="{y_of(tick)}" dy=".35em" text-anchor="end">{tick:.3g}</text>')
    for tick in x_ticks:
        grid.append(f'<text x="{x_of(tick)}" y="{floor + 18}" text-anchor="middle">{tick}</text>')
    grid.append(f'<text x="{(left + _PLOT[0] - right) / 2}" y="{_PLOT[1] - 4}" text-anchor="middle">paths</text>')
    points = [(x_of(count), y_of(error)) for count, error in zip(counts, errors, strict=True)]
    dots = [
        f'<circle cx="{x}" cy="{y}" r="4.5"><title>{count_of(count, "path")}, MSE {error:.3g}</title></circle>'
        for (x, y), count, error in zip(points, counts, errors, strict=True)
    ]
    course = " ".join(f"{x},{y}" for x, y in points)
    said = f"Mean squared error against paths: {errors[0]:.3g} at {counts[0]} to {errors[-1]:.3g} at {counts[-1]}"
    return (
        f'<svg class="plot" viewBox="0 0 {_PLOT[0]} {_PLOT[1]}" role="img" aria-label="{text(said)}">\n'
        f'{"".join(grid)}\n<polyline class="course" points="{course}"/>\n{"".join(dots)}\n</svg>'
    )


def _log_ticks(low: float, high: float) -> list[float]:
    """Return powers of ten that enclose a range, thinned if many; with 2 and 5 times these if few."""
    first, last = math.floor(math.log10(low)), math.ceil(math.log10(high))
    last = max(last, first + 1)
    if last - first > 3:
        step = math.ceil((last - first) / 5)
        return [10.0**power for power in range(last - step * math.ceil((last - first) / step), last + 1, step)]
    every = sorted({round(m * 10.0**power, 12 - power) for power in range(first, last + 1) for m in (1, 2, 5)})
    below = max(tick for tick in every if tick <= low * (1 + 1e-9))
    above = min(tick for tick in every if tick >= high * (1 - 1e-9))
    return [tick for tick in every if below <= tick <= max(above, 2 * below)]


def _whole_ticks(low: int, high: int) -> list[int]:
    step = next(
        factor * 10**power
        for power in itertools.count()
        for factor in (1, 2, 5)
        if high - low <= 8 * factor * 10**power
    )
    inner = range(-(-low // step) * step, high + 1, step)
    return sorted({low, *(tick for tick in inner if low + step / 2 < tick)})
