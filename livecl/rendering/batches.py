# SPDX-License-Identifier: Apache-2.0
"""`BatchRendering`: render and differentiate many drawings of one size with one launch of each kernel."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from livecl.drawing.canvas import check_canvases
from livecl.drawing.drawing import Drawing
from livecl.opencl.guard import on_device
from livecl.rendering.device_canvas import DeviceCanvas
from livecl.rendering.gradients import Gradients
from livecl.rendering.images import DeviceImage, download, upload
from livecl.rendering.stacks import Stack
from livecl.rendering.strokes import Filled, filled
from livecl.rendering.threads import channels_of

#: Maximum number of strips of a stack: tables hold them in 16 bits.
MAX_STRIPS = (1 << 16) - 1
#: Pixels and segments processed at a time (or a single drawing): enough for many cores. Larger arrays would not fit in
#: the processor's caches: 16 drawings of 512 paths at 512 x 512 px took a quarter more processor time.
MAX_PIXELS, MAX_SEGMENTS = 1 << 20, 1 << 12


@dataclasses.dataclass(frozen=True)
class _Part:
    """Drawings of a batch that are processed together."""

    indices: list[int]
    stack: Stack
    plain: Filled
    pieces: ArrayLike | None


class BatchRendering(DeviceCanvas):
    """Renders lists of drawings on stacked canvases in one launch, so that all cores have work."""

    def forward_all(self, drawings: Sequence[Drawing], pieces: Sequence[ArrayLike] | None = None) -> NDArray[Any]:
        """Render drawings together: the same bytes as :meth:`forward` for each, in less time on many cores.

        Parameters
        ----------
        drawings : sequence of D Drawing
            On canvases of the rasterizer's size, all with a background or all without.
        pieces : sequence of D (M,) array_like of int, optional
            Numbers of lines of each drawing's segments, as for :meth:`forward`.

        Returns
        -------
        (D, H, W, 3) or (D, H, W, 4) array

        Raises
        ------
        TypeError
            If one is no Drawing.
        ValueError
            If there are none, one does not fit the others or the rasterizer, or `pieces` does not fit.
        """
        return self._render_all(*self._parts(drawings, pieces, fixed=False))

    def vjp_all(
        self, drawings: Sequence[Drawing], pieces: Sequence[ArrayLike] | None = None
    ) -> tuple[NDArray[Any], Callable[[ArrayLike], list[Gradients]]]:
        """Render drawings together; return their images and the vector-Jacobian product of rendering.

        The same bytes as :meth:`vjp` for each drawing.

        Parameters
        ----------
        drawings, pieces
            As for :meth:`forward_all`; None chooses `pieces` once, for the images and all products.

        Returns
        -------
        images : (D, H, W, 3) or (D, H, W, 4) array
            As :meth:`forward_all` returns them.
        pullback : callable
            Maps dL/dimages, of the images' shape, to the :class:`Gradients` of each drawing; it can be called any
            number of times.

        Raises
        ------
        TypeError, ValueError
            As :meth:`forward_all` does.

        Examples
        --------
        >>> import numpy as np
        >>> import livecl
        >>> grey = [livecl.drawing.empty_drawing((8, 8), (level, level, level)) for level in (0.25, 0.5)]
        >>> images, pullback = livecl.Rasterizer((8, 8)).vjp_all(grey)
        >>> images.mean(axis=(1, 2, 3)).tolist()
        [0.25, 0.5]
        >>> [gradients.background.tolist() for gradients in pullback(images)]
        [[16.0, 16.0, 16.0], [32.0, 32.0, 32.0]]
        """
        parts, shape = self._parts(drawings, pieces, fixed=True)
        images = self._render_all(parts, shape)

        def pullback(d_images: ArrayLike) -> list[Gradients]:
            array = np.asarray(d_images, dtype=self.dtype)
            if array.shape != shape:
                raise ValueError(f"d_images: shape {array.shape}, wanted {shape}")
            found: dict[int, Gradients] = {}
            for part in parts:
                found.update(zip(part.indices, self._pull_back_part(part, array), strict=True))
            return [found[index] for index in range(len(drawings))]

        return images, pullback

    def _parts(
        self, drawings: Sequence[Drawing], pieces: Sequence[ArrayLike] | None, fixed: bool
    ) -> tuple[list[_Part], tuple[int, ...]]:
        """Return the parts of a batch, and its images' shape; if `fixed`, numbers of lines are chosen now."""
        drawings = list(drawings)
        channels = [channels_of(drawing) for drawing in drawings]
        check_canvases(drawings)
        if len(set(channels)) > 1:
            odd = next(index for index, count in enumerate(channels) if count != channels[0])
            without, having = (odd, 0) if channels[odd] == 4 else (0, odd)
            raise ValueError(f"drawings: {without} has no background, {having} has one; wanted all alike")
        if pieces is not None and len(pieces) != len(drawings):
            raise ValueError(f"pieces: for {len(pieces)} drawings, wanted those of {len(drawings)}")
        parts = []
        for indices in self._cut(drawings):
            stack = Stack.of([drawings[index] for index in indices])
            own = None if pieces is None else np.concatenate([np.asarray(pieces[index]) for index in indices])
            own = self.pieces(stack.drawing) if own is None and fixed else own
            parts.append(_Part(indices, stack, filled(stack.drawing, own, self.tolerance), own))
        return parts, (len(drawings), *self.size, channels[0])

    def _cut(self, drawings: Sequence[Drawing]) -> list[list[int]]:
        """Return the drawings of each part; those with gradient fills separately, as they have other kernels."""
        most = min(MAX_STRIPS // self._grid.period, MAX_PIXELS // (self.size[0] * self.size[1]))
        parts: list[list[int]] = []
        for kind in (False, True):
            room, segments = 0, 0
            for index, drawing in enumerate(drawings):
                if drawing.fills.any_gradients != kind:
                    continue
                room, segments = room - 1, segments + drawing.num_segments
                if room < 0 or segments > MAX_SEGMENTS:
                    parts.append([])
                    room, segments = most - 1, drawing.num_segments
                parts[-1].append(index)
        return parts

    def _render_all(self, parts: Sequence[_Part], shape: tuple[int, ...]) -> NDArray[Any]:
        images = [self._render_part(part, shape) for part in parts]
        if len(images) == 1:
            return images[0]
        together = np.empty(shape, self.dtype)
        for part, own in zip(parts, images, strict=True):
            together[part.indices] = own
        return together

    @on_device
    def _render_part(self, part: _Part, shape: tuple[int, ...]) -> NDArray[Any]:
        pipeline = self._workspace.loaded(part.plain.drawing, part.stack)
        image = DeviceImage(pipeline.render(shape[-1], part.plain.pieces(part.pieces)), shape[-1])
        return download(self.device, pipeline.grid, image, self.dtype).reshape(-1, *shape[1:])

    @on_device
    def _pull_back_part(self, part: _Part, d_images: NDArray[Any]) -> list[Gradients]:
        pipeline = self._workspace.loaded(part.plain.drawing, part.stack)
        own = d_images if len(part.indices) == len(d_images) else d_images[part.indices]
        pipeline.launcher.set(d_image=upload(self.device, pipeline.grid, own).buffer)
        gradients = pipeline.begin_backward(part.plain.pieces(part.pieces))()[1]
        return part.stack.split(part.plain.pull_back(gradients))
