# SPDX-License-Identifier: Apache-2.0
"""Work that uses every kernel, as a digest of its bytes: what tests of devices in trouble compare.

As a program it prints the digests of the cases that are named, in both number types.
"""

from __future__ import annotations

import hashlib
import itertools
import logging
import os
import sys
from pathlib import Path

import numpy as np
import pyopencl as cl

from livecl import Rasterizer
from livecl.drawing import LINEAR, RADIAL, SOLID, Drawing, Fills, Strokes
from livecl.opencl.device import open_device
from livecl.opencl.launcher import Launcher
from livecl.rendering.pipeline import DistanceWeight
from support.drawings import ALL_CASES, Case

TESTS = Path(__file__).resolve().parents[1]


def with_checkout(**variables: str) -> dict[str, str]:
    """Return the environment of a process that imports from this checkout and its tests."""
    return {**os.environ, "PYTHONPATH": f"{TESTS.parent}{os.pathsep}{TESTS}", **variables}


def opencl_error(kind: type[cl.Error], code: int) -> cl.Error:
    """Return an error as pyopencl raises it."""
    return kind(cl._cl._ErrorRecord(msg="", code=code, routine="clEnqueueNDRangeKernel"))


def everything(rasterizer: Rasterizer, case: Case) -> str:
    """Return a digest of all that a rasterizer can be asked for: images, coverages, distance weight, gradients."""
    drawing, pieces = case.drawing, case.pieces
    image = rasterizer.forward(drawing, pieces)
    gradients = [rasterizer.backward(np.linspace(-1, 1, image.size).reshape(image.shape))]
    weighted = rasterizer.distance_weight(drawing, 6.0, pieces)
    closest = rasterizer.download(rasterizer.distance_weight_on_device(drawing, 6.0, pieces, closest_from=1))
    parts = [image, rasterizer.coverages(drawing, pieces), weighted, closest]
    for weight in (np.ones(image.shape[:2]), DistanceWeight(6.0, pieces)):
        again = drawing.replace()  # another object, for which nothing has been kept on the device
        loss, gradient = rasterizer.loss_and_gradients(again, np.full_like(image, 0.5), weight, pieces)
        parts.append(np.array(loss))
        gradients.append(gradient)
    filled = _with_gradients(drawing)
    parts.append(rasterizer.forward(filled, pieces))
    gradients.append(rasterizer.backward(np.linspace(-1, 1, image.size).reshape(image.shape)))
    for weight in (np.ones(image.shape[:2]), DistanceWeight(6.0, pieces)):
        gradients.append(rasterizer.loss_and_gradients(filled, np.full_like(image, 0.5), weight, pieces)[1])
    images, pullback = rasterizer.vjp_all([drawing, _with_strokes(drawing), filled])
    parts.append(images)
    gradients += pullback(np.linspace(-1, 1, images.size).reshape(images.shape))
    for gradient in gradients:
        if gradient.widths is not None:
            parts.append(gradient.widths)
        if gradient.fills is not None:
            parts += [gradient.fills.geometry, gradient.fills.stop_positions, gradient.fills.stop_colors]
        parts += [gradient.points, gradient.colors]
    return hashlib.sha256(b"".join(np.ascontiguousarray(part).tobytes() for part in parts)).hexdigest()


def _with_strokes(drawing: Drawing) -> Drawing:
    """Return a drawing whose outlines are stroked, by all caps and joins in turn."""
    num = drawing.num_layers
    turn = np.arange(num)
    pens = Strokes(
        widths=np.array([2.5, 0.0, 1.0])[turn % 3],
        caps=turn % 3,
        joins=turn // 2 % 3,
        is_open=np.zeros(len(drawing.subpaths()), bool),
    )
    return drawing.replace(strokes=pens)


def _with_gradients(drawing: Drawing) -> Drawing:
    """Return a drawing in which linear, radial and solid fills take turns, with steps and points that are equal."""
    num, rng = drawing.num_layers, np.random.default_rng(3)
    kinds = np.array([LINEAR, RADIAL, SOLID])[np.arange(num) % 3]
    geometry = rng.uniform(0, 20, (num, 3, 2))
    geometry[4::5] = 7.0
    counts = np.where(kinds == SOLID, 0, 2 + np.arange(num) % 2)
    places = [[], [], [0.0, 1.0], [0.25, 0.5, 0.5]]
    fills = Fills(
        kinds=kinds,
        geometry=geometry,
        stop_offsets=np.cumsum([0, *counts]),
        stop_positions=[place for count in counts for place in places[count]],
        stop_colors=np.repeat(drawing.colors[:, ::-1], counts, axis=0),
    )
    return drawing.replace(fills=fills)


def launched_kernels() -> set[str]:
    """Return the names of the kernels launched from now on, as a set that fills."""
    names: set[str] = set()
    launch = Launcher.__call__

    def noting(launcher: Launcher, name: str, num_items: int, scope: str = "") -> None:
        names.add(name)
        launch(launcher, name, num_items, scope)

    Launcher.__call__ = noting  # type: ignore[method-assign]
    return names


def main(names: list[str]) -> None:
    """Print the digests of cases, with the work-groups of processors and of GPUs, at once and in bands of strips."""
    logging.basicConfig(format="%(levelname)s: %(message)s")
    kernels = launched_kernels()
    opened = open_device()
    for name, is_cpu, dtype in itertools.product(names, (True, False), (np.float32, np.float64)):
        vars(opened)["is_cpu"] = is_cpu
        case = ALL_CASES[name]()
        for max_tiles in (1 << 17, 1):
            digest = everything(Rasterizer(case.drawing.size, dtype=dtype, max_tiles=max_tiles), case)
            sys.stdout.write(f"printed: {name} on {opened.info.name}, {is_cpu=}, {dtype=}, {max_tiles=}: {digest}\n")
    sys.stdout.write(f"printed: kernels {' '.join(sorted(kernels))}\n")


if __name__ == "__main__":
    main(sys.argv[1:])
