# SPDX-License-Identifier: Apache-2.0
"""Render a drawing once, without keeping a rasterizer."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from livecl.drawing.drawing import Drawing
from livecl.image.errors import unpremultiplied
from livecl.rendering.rasterizer import Rasterizer
from livecl.rendering.threads import channels_of


def render(drawing: Drawing, device: int | str | None = None, *, straight: bool = False) -> NDArray[Any]:
    """Render a drawing once.

    Parameters
    ----------
    drawing : Drawing
        Any drawing.
    device : int, str or None
        OpenCL device, see :func:`livecl.opencl.device.choose_device`.
    straight : bool
        Return straight RGBA, as :func:`livecl.read_image` does and :func:`livecl.image.save_image` expects, instead of
        premultiplied RGBA.

    Returns
    -------
    (H, W, 3) float32
        RGB; or (H, W, 4), RGBA, if the drawing has no background.

    Examples
    --------
    >>> from livecl.drawing import empty_drawing
    >>> render(empty_drawing((2, 3), (1, 0.5, 0)))[0, 0].tolist()
    [1.0, 0.5, 0.0]
    """
    channels_of(drawing)
    image = Rasterizer(drawing.size, device).forward(drawing)
    return unpremultiplied(image).astype(np.float32) if straight and image.shape[2] == 4 else image
