#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Compare the results of OpenCL devices: a drawing's image and gradients, and a vectorized picture.

Prints a table in which each device is compared with the first one: largest and root-mean-square difference of the
image (colours from 0 to 1), of the gradients of a squared error, relative to the largest one, then both drawings'
errors, and the largest and the median difference of their control points, px, where both have the same paths.
"""

from __future__ import annotations

import argparse
import dataclasses
from typing import Any

import numpy as np
from numpy.typing import NDArray

import livecl
from livecl.options import PRESETS
from livecl.rendering.pipeline import DistanceWeight


def rendered(drawing: livecl.Drawing, device: int) -> tuple[NDArray[Any], NDArray[Any]]:
    """Return the image, and the gradients with respect to points and colours as one array."""
    rasterizer = livecl.Rasterizer(drawing.size, device)
    image = rasterizer.forward(drawing)
    _, gradients = rasterizer.loss_and_gradients(drawing, np.full_like(image, 0.5), DistanceWeight())
    return image, np.concatenate([gradients.points.ravel(), gradients.colors.ravel()])


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("picture", help="picture to vectorize")
    parser.add_argument("--paths", type=int, default=6, help="number of paths (default: %(default)s)")
    parser.add_argument("--iterations", type=int, default=60, help="of each stage (default: %(default)s)")
    parser.add_argument("--preset", choices=PRESETS, default="default", help="options (default: %(default)s)")
    arguments = parser.parse_args()
    devices = livecl.list_devices()
    for device in devices:
        print(device)
    image = livecl.read_image(arguments.picture)
    options = dataclasses.replace(PRESETS[arguments.preset](), iterations=arguments.iterations, revisions=0)
    results = [livecl.vectorize(image, arguments.paths, options=options, device=device.index) for device in devices]
    drawing = results[0].drawing
    images, gradients = zip(*(rendered(drawing, device.index) for device in devices), strict=True)
    print("| device | image: max | rms | gradient: max | rms | MSE | control points: max, px | median, px |")
    print("|---|--:|--:|--:|--:|--:|--:|--:|")
    for device, result, picture, gradient in zip(devices, results, images, gradients, strict=True):
        of_image = np.abs(picture - images[0])
        of_gradient = np.abs(gradient - gradients[0]) / np.abs(gradients[0]).max()
        figures = [
            f"{value:.2g}" for difference in (of_image, of_gradient) for value in (difference.max(), rms(difference))
        ]
        moved = "other paths | "
        if result.drawing.points.shape == drawing.points.shape:
            distances = np.abs(result.drawing.points - drawing.points)
            moved = f"{distances.max():.3g} | {np.median(distances):.2g}"
        print(f"| [{device.index}] | {' | '.join(figures)} | {result.mse:.4g} | {moved} |")


def rms(values: NDArray[Any]) -> float:
    """Return the root of the mean square."""
    return float(np.sqrt(np.mean(np.square(values, dtype=np.float64))))


if __name__ == "__main__":
    main()
