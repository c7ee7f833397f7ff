# SPDX-License-Identifier: Apache-2.0
"""Adam for gradient fills: geometry has the learning rate of points, stops that of colours."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from livecl.drawing.fills import Fills
from livecl.rendering.fills import FillGradients
from livecl.training.adam import Adam

#: Learning rate of parameters by their ages.
Rate = Callable[[NDArray[np.int64]], ArrayLike]


@dataclasses.dataclass
class FillMoments:
    """Moments of a drawing's fills."""

    geometry: Adam  # of the gradients' points, by layer: (N, 3, 2)
    stops: Adam  # of the stops' offsets and colours: (S, 5)

    @classmethod
    def start(cls, fills: Fills) -> FillMoments:
        """Return the moments before the first step."""
        return cls(Adam.start(fills.geometry.shape), Adam.start((len(fills.stop_positions), 5)))

    def copy(self) -> FillMoments:
        """Return an independent copy."""
        return FillMoments(self.geometry.subset(slice(None)), self.stops.subset(slice(None)))

    def followed(self, old: Fills, new: Fills, sources: NDArray[Any]) -> FillMoments:
        """Return the moments for changed fills.

        Layers of the same kind, with as many stops, keep theirs; all others start anew. `sources` (N,) has each
        layer's former index, -1 for a new one.
        """
        moments = FillMoments.start(new)
        for layer in new.gradient_layers.tolist():
            source, own = int(sources[layer]), new.stops(layer)
            if source < 0 or old.kinds[source] != new.kinds[layer]:
                continue
            before = old.stops(source)
            if before.stop - before.start != own.stop - own.start:
                continue
            for name in ("mean", "square", "ages"):
                getattr(moments.geometry, name)[layer] = getattr(self.geometry, name)[source]
                getattr(moments.stops, name)[own] = getattr(self.stops, name)[before]
        return moments

    def step(self, fills: Fills, gradients: FillGradients, point_rate: Rate, color_rate: Rate) -> Fills:
        """Return fills moved by one step.

        Stops stay within [0, 1], in their order. A layer's first and last stop keep their offsets: the geometry moves
        them.
        """
        d_stops = np.concatenate([gradients.stop_positions[:, None], gradients.stop_colors], axis=1)
        first, last = fills.end_stops
        d_stops[first, 0] = d_stops[last, 0] = 0
        geometry = fills.geometry + self.geometry.step(gradients.geometry, point_rate(self.geometry.ages))
        stops = np.concatenate([fills.stop_positions[:, None], fills.stop_colors], axis=1)
        stops = np.clip(stops + self.stops.step(d_stops, color_rate(self.stops.ages)), 0, 1)
        positions = stops[:, 0].copy()
        falls = positions[1:] < positions[:-1]
        falls[last[:-1]] = False
        for layer in set(fills.stop_layers[1:][falls].tolist()):
            own = fills.stops(layer)
            positions[own] = np.minimum(np.maximum.accumulate(positions[own]), positions[own.stop - 1])
        return fills.moved(geometry, positions, stops[:, 1:])


def hold_fills(fills: Fills, gradients: FillGradients, locked: NDArray[np.bool_]) -> None:
    """Clear the gradients of locked layers' fills, (N,)."""
    gradients.geometry[locked] = 0
    stops = locked[fills.stop_layers]
    gradients.stop_positions[stops] = 0
    gradients.stop_colors[stops] = 0
