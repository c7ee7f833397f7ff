# SPDX-License-Identifier: Apache-2.0
"""Import the package of the measured checkout, and the parts of it that the benchmark uses.

Older checkouts, whose modules were not yet in packages, are supported: their modules are found by today's names.
"""

from __future__ import annotations

import importlib
import importlib.util
import sys
from pathlib import Path
from typing import Any

#: Today's module: its name when `livecl` was flat.
FLAT = {
    "drawing.drawing": "drawing",
    "geometry.bezier": "bezier",
    "image.reading": "image",
    "opencl.device": "device",
    "opencl.launcher": "launcher",
    "opencl.program": "program",
    "rendering.device_drawing": "scene",
    "rendering.rasterizer": "rasterizer",
    "run.loop": "loop",
    "run.phases": "vectorizer",
    "run.run": "vectorizer",
    "training.objective": "objective",
    "training.state": "state",
    "training.step": "training",
    "training.xing": "losses",
}


def use_checkout(root: Path) -> None:
    """Import livecl from a checkout, given by PYTHONPATH.

    Raises
    ------
    RuntimeError
        If it is imported from elsewhere.
    """
    import livecl

    if Path(livecl.__file__).resolve().parent.parent != root.resolve():
        raise RuntimeError(f"livecl was imported from {livecl.__file__}, wanted {root}")
    if not (root / "livecl" / "opencl").is_dir():
        for name, flat in FLAT.items():
            sys.modules[f"livecl.{name}"] = importlib.import_module(f"livecl.{flat}")
        run: Any = sys.modules["livecl.run.run"]
        run.Run = getattr(run, "Vectorizer", None)


def name_processor(root: Path, device: int | str | None = None) -> None:
    """If PoCL's compiler does not know the processor, name one for a checkout that cannot do so itself."""
    if (root / "livecl" / "opencl" / "processor.py").is_file():
        return
    from livecl.opencl.device import open_device

    path = Path(__file__).resolve().parents[2] / "livecl" / "opencl" / "processor.py"
    spec = importlib.util.spec_from_file_location("benchmark_processor", path)
    assert spec is not None and spec.loader is not None
    processor = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(processor)
    processor.name_processor(open_device(device).device)


def compiled(opened: Any, source: str) -> Any:
    """Return a program of the benchmark's own, compiled as livecl compiles its kernels."""
    import pyopencl as cl

    program = importlib.import_module("livecl.opencl.program")
    if hasattr(program, "compile_source"):
        return program.compile_source(opened, source, [])
    return cl.Program(opened.context, source).build()


def training(image: Any, drawing: Any, device: int | str | None) -> Any:
    """Return a run that trains a drawing on an image with the paper's settings.

    Its `step()` does an iteration and returns the loss; `state.drawing` is the drawing.
    """
    from livecl.options import Options
    from livecl.run.run import Run

    try:
        from livecl.run.progress import Progress
    except ImportError:  # an older checkout
        from livecl.training.state import State as Progress

    return Run(image, Progress.start(drawing, Options.paper(), (drawing.num_layers,), 0), device)
