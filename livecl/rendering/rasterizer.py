# SPDX-License-Identifier: Apache-2.0
"""The differentiable rasterizer: from a drawing to an image, and gradients back to the drawing."""

from __future__ import annotations

import dataclasses
import functools
from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from livecl import interruption
from livecl.drawing.drawing import Drawing
from livecl.opencl.guard import on_device
from livecl.rendering.batches import BatchRendering
from livecl.rendering.gradients import Gradients
from livecl.rendering.images import DeviceImage
from livecl.rendering.pipeline import DistanceWeight
from livecl.rendering.strokes import Filled, filled
from livecl.rendering.threads import channels_of

__all__ = ["DeviceImage", "DistanceWeight", "Gradients", "Rasterizer"]


#: Largest number of coverage values fetched at once: 0.1 s of work, after which a run may be interrupted.
MOST_COVERAGES = 1 << 22


class Rasterizer(BatchRendering):
    """Renders drawings on one canvas size and differentiates losses of the result.

    Coverage is exact area coverage under the nonzero rule (exceptions: kernels/coverage.cl), layers are composited
    `over` in paint order. All sums have a fixed order: the same input gives the same bytes.

    Threads may share an object: each has its own buffers, and differentiates the drawing that it rendered.

    Parameters
    ----------
    size : (int, int)
        Height and width of the canvas, px.
    device : int, str or None
        OpenCL device, see :func:`livecl.opencl.device.choose_device`.
    dtype : float32 or float64
        Number type of the kernels; float64 is for checking gradients.
    tolerance : float
        Flattening tolerance: largest distance between a curve and its lines, px.
    max_tiles : int
        Number of tiles (of 8 columns by 32 bytes) processed at a time; bounds the memory.

    Raises
    ------
    DeviceError, KernelBuildError
        If the device is not available, or does not compile the kernels. All methods raise DeviceError once it has
        failed, and DeviceMemoryError if it runs out of memory, after which smaller work may succeed.
    """

    @on_device
    def forward(self, drawing: Drawing, pieces: ArrayLike | None = None) -> NDArray[Any]:
        """Render a drawing.

        Parameters
        ----------
        drawing : Drawing
            On a canvas of the rasterizer's size.
        pieces : (M,) array_like of int, optional
            Number of lines of each segment, at equal steps of its parameter. None chooses it by the tolerance. For
            differentiation, pass fixed numbers: gradients do not account for changes.

        Returns
        -------
        (H, W, 3) array
            RGB; or (H, W, 4), premultiplied RGBA, if the drawing has no background; :func:`livecl.render` also returns
            straight RGBA.

        Raises
        ------
        TypeError
            If `drawing` is no Drawing.
        ValueError
            If the drawing is of another size, or `pieces` does not fit it.
        """
        channels_of(drawing)
        return self._render(filled(drawing, pieces, self.tolerance), pieces)

    @on_device
    def coverages(self, drawing: Drawing, pieces: ArrayLike | None = None) -> NDArray[Any]:
        """Render the coverage of each layer separately.

        Parameters
        ----------
        drawing : Drawing
            On a canvas of the rasterizer's size; colours and opacities are ignored.
        pieces : (M,) array_like of int, optional
            Number of lines of each segment; see :meth:`forward`.

        Returns
        -------
        (N, H, W) array
            Share of each pixel inside each layer, in [0, 1].
        """
        plain = filled(drawing, pieces, self.tolerance)
        drawing, pieces = plain.drawing, plain.pieces(pieces)
        together = self.max_tiles // (self._grid.num_strips * self._grid.num_tiles)  # layers on the device at a time
        together = max(1, min(together, MOST_COVERAGES // (self.size[0] * self.size[1])))
        if drawing.num_layers <= together:
            return self._coverages(drawing, pieces)
        coverages = np.empty((drawing.num_layers, *self.size), self.dtype)
        for first in range(0, drawing.num_layers, together):
            interruption.check()
            layers = np.arange(first, min(first + together, drawing.num_layers))
            start, end = drawing.segment_offsets[[layers[0], layers[-1] + 1]]
            some = None if pieces is None else np.asarray(pieces)[start:end]
            planes = DeviceImage(self._workspace.loaded(drawing.layer_subset(layers)).cover(some), len(layers))
            interruption.check()
            coverages[first : layers[-1] + 1] = np.moveaxis(self.download(planes), -1, 0)
        return coverages

    def _coverages(self, drawing: Drawing, pieces: ArrayLike | None) -> NDArray[Any]:
        planes = DeviceImage(self._workspace.loaded(drawing).cover(pieces), drawing.num_layers)
        return np.ascontiguousarray(np.moveaxis(self.download(planes), -1, 0))

    @on_device
    def backward(self, d_image: ArrayLike) -> Gradients:
        """Gradient of a scalar loss with respect to the drawing last rendered by :meth:`forward`.

        Parameters
        ----------
        d_image : (H, W, 3) or (H, W, 4) array_like
            dL/dimage, loss per unit of colour; of the shape that :meth:`forward` returned.

        Returns
        -------
        Gradients
            ``points`` (M, 3, 2), loss per pixel of displacement; ``colors`` (N, 4); ``background`` (3,); for gradient
            fills and strokes, ``fills`` and ``widths`` (N,).

        Raises
        ------
        ValueError
            If `d_image` is not of the rendered image's shape.
        RuntimeError
            If nothing has been rendered.

        Notes
        -----
        Derivations: kernels/composite.h (colour), kernels/coverage.cl (outline), kernels/flatten.cl (control points),
        livecl/geometry/strokes.py (centre lines and widths).
        """
        if self._workspace.rendered is None:
            raise RuntimeError("backward needs a drawing: call forward first")
        return self._pull_back(*self._workspace.rendered, d_image)

    def vjp(
        self, drawing: Drawing, pieces: ArrayLike | None = None
    ) -> tuple[NDArray[Any], Callable[[ArrayLike], Gradients]]:
        """Render a drawing; return its image and the vector-Jacobian product of rendering.

        The product belongs to this drawing, whatever is rendered later, and may be called in any thread.

        Parameters
        ----------
        drawing, pieces
            As for :meth:`forward`; None chooses `pieces` once, for the image and all products.

        Returns
        -------
        image : (H, W, 3) or (H, W, 4) array
            As :meth:`forward` returns it.
        pullback : callable
            Maps dL/dimage, of the image's shape, to :class:`Gradients`, as :meth:`backward`; it can be called any
            number of times.

        Raises
        ------
        TypeError, ValueError
            As :meth:`forward` does.

        Examples
        --------
        >>> import numpy as np
        >>> import livecl
        >>> a = np.array([[8, 8], [8, 24], [24, 24], [24, 8]])
        >>> square = np.stack([a, a, np.roll(a, -1, axis=0)], axis=1)  # straight sides: anchor, handle, handle
        >>> drawing = livecl.Drawing.from_outlines([[square]], [0, 0, 0, 1], size=(32, 32))
        >>> image, pullback = livecl.Rasterizer((32, 32)).vjp(drawing)
        >>> pullback(np.ones_like(image)).colors.round().tolist()  # of the sum of all pixels
        [[256.0, 256.0, 256.0, -768.0]]
        """
        channels_of(drawing)
        chosen = self.pieces(drawing) if pieces is None else np.array(pieces)
        plain = filled(drawing, chosen, self.tolerance)
        return self._render(plain, chosen), functools.partial(self._pull_back, plain, chosen)

    @on_device
    def _render(self, plain: Filled, pieces: ArrayLike | None) -> NDArray[Any]:
        channels = channels_of(plain.drawing)
        image = self._workspace.loaded(plain.drawing).render(channels, plain.pieces(pieces))
        self._workspace.rendered = plain, pieces
        return self.download(DeviceImage(image, channels))

    @on_device
    def _pull_back(self, plain: Filled, pieces: ArrayLike | None, d_image: ArrayLike) -> Gradients:
        pipeline = self._workspace.loaded(plain.drawing)
        pipeline.launcher.set(d_image=self._uploaded("d_image", d_image, channels_of(plain.drawing)).buffer)
        return plain.pull_back(pipeline.begin_backward(plain.pieces(pieces))()[1])

    def loss_and_gradients(
        self,
        drawing: Drawing,
        target: ArrayLike | DeviceImage,
        weight: ArrayLike | DeviceImage | DistanceWeight,
        pieces: ArrayLike | None = None,
        scale: float = 1.0,
    ) -> tuple[float, Gradients]:
        """Weighted squared error of a drawing and its gradient.

        The loss is the sum over pixels of ``scale * weight`` times the sum over R, G and B of (image - target)^2. If
        the drawing has no background, that sum is the mean of those over black and over white
        (:mod:`livecl.image.errors`).

        Parameters
        ----------
        drawing, pieces
            As for :meth:`forward`.
        target : (H, W, 3) or (H, W, 4) array_like, or DeviceImage
            Target; premultiplied RGBA if the drawing has no background.
        weight : (H, W) array_like, DeviceImage or DistanceWeight
            Weight of each pixel, a constant in the gradient.
        scale : float
            Factor of all weights.

        Returns
        -------
        (float, Gradients)

        Raises
        ------
        ValueError
            If the drawing is of another size, or another argument does not fit it.
        """
        return self.begin_loss(drawing, target, weight, pieces, scale)()

    @on_device
    def begin_loss(
        self,
        drawing: Drawing,
        target: ArrayLike | DeviceImage,
        weight: ArrayLike | DeviceImage | DistanceWeight,
        pieces: ArrayLike | None = None,
        scale: float = 1.0,
    ) -> Callable[[], tuple[float, Gradients]]:
        """Like :meth:`loss_and_gradients`, but without waiting for the device.

        Returns
        -------
        callable
            Waits and returns loss and gradients. Call it before any other method of the rasterizer.
        """
        plain = filled(drawing, pieces, self.tolerance)
        pipeline = self._workspace.loaded(plain.drawing)
        pipeline.launcher.set(target=self._uploaded("target", target, channels_of(drawing)).buffer)
        distances = None
        if isinstance(weight, DistanceWeight):
            distances = weight
            if plain.drawing is not drawing:
                distances = dataclasses.replace(weight, pieces=plain.pieces(weight.pieces))
        else:
            pipeline.launcher.set(weight=self._uploaded("weight", weight, 1).buffer)
        end = pipeline.begin_loss(distances, plain.pieces(pieces), float(scale))
        return functools.partial(self._end_loss, plain, end)

    @on_device
    def _end_loss(self, plain: Filled, end: Callable[[], tuple[float, Gradients]]) -> tuple[float, Gradients]:
        loss, gradients = end()
        return loss, plain.pull_back(gradients)

    def distance_weight(self, drawing: Drawing, tau: float = 10.0, pieces: ArrayLike | None = None) -> NDArray[Any]:
        """Return the distance weight of eq. (1), averaged over all layers with an outline within `tau` of a pixel.

        Parameters
        ----------
        drawing, pieces
            As for :meth:`forward`.
        tau : float
            Reach of the weight, px.

        Returns
        -------
        (H, W) array
            d', with sum 1; or 0 everywhere if no outline is near.
        """
        return self.download(self.distance_weight_on_device(drawing, tau, pieces))[..., 0]

    @on_device
    def distance_weight_on_device(
        self, drawing: Drawing, tau: float, pieces: ArrayLike | None = None, closest_from: int | None = None
    ) -> DeviceImage:
        """Like :meth:`distance_weight`, but left on the device; the next call overwrites it.

        With `closest_from`, the image is instead the largest ReLU(tau - d), px, of the layers from that one on, from
        which the weight of the authors' program is made.
        """
        plain = filled(drawing, pieces, self.tolerance)
        weight = DistanceWeight(tau, plain.pieces(pieces))
        return DeviceImage(self._workspace.loaded(plain.drawing).weigh(weight, closest_from), 1)
