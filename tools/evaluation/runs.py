# SPDX-License-Identifier: Apache-2.0
"""Runs: one picture by one method, in a separate process, kept in a folder with its settings."""

from __future__ import annotations

import concurrent.futures
import dataclasses
import functools
import hashlib
import io
import itertools
import json
import multiprocessing
import os
import shutil
import signal
import time
from collections.abc import Iterator, Sequence
from concurrent.futures.process import BrokenProcessPool
from pathlib import Path
from typing import Any

import numpy as np
from PIL import Image

import livecl
from evaluation.measures import FloatImage, measure, true_drawing, true_svg
from evaluation.methods import VTRACER, Method
from livecl import quality
from livecl.files import write_atomically
from livecl.image.background import WHITE
from livecl.image.reading import over_background, read_image
from livecl.opencl.program import kernel_dir
from livecl.options import Options
from livecl.rendering.rasterizer import Rasterizer
from livecl.schedule import growing_schedule
from livecl.svg import save_svg

#: Parts of the package that do not affect the outcome of a run.
_WITHOUT_EFFECT = {"__init__.py", "__main__.py", "batch", "cli", "vae", "views"}
_RESULT = "result.json"
#: Numbers of paths by name: chosen by the method; the number of things, or of shapes, of the true SVG.
AUTO, THINGS, SHAPES = "auto", "things", "shapes"

Row = dict[str, Any]


@dataclasses.dataclass(frozen=True, kw_only=True)
class Run:
    """One picture by one method.

    Attributes
    ----------
    picture : Path
        The picture's file.
    method : Method
        The method.
    asked : int, str or None
        Requested number of paths, or "auto", "things", "shapes"; None if the method takes none.
    seed : int
        Seed of all random choices.
    device : str or None
        OpenCL device.
    output : Path
        Folder of all runs.
    """

    picture: Path
    method: Method
    asked: int | str | None
    seed: int
    device: str | None
    output: Path

    @property
    def name(self) -> str:
        """Name of the picture, with its folder's."""
        return picture_name(self.picture)

    @property
    def title(self) -> str:
        """Name of the run in messages."""
        return f"{self.method.name} {self.name}" + ("" if self.asked is None else f" at {self.asked}")

    @property
    def folder(self) -> Path:
        """Folder of the run's SVGs and result."""
        return self.output / "runs" / self.method.name / self.name / ("free" if self.asked is None else str(self.asked))

    @property
    def schedule(self) -> tuple[int, ...] | None:
        """Paths added by each stage; None if the method chooses."""
        if self.asked is None or self.asked == AUTO:
            return None
        count = self.asked if isinstance(self.asked, int) else _number(self.asked, self.picture)
        return (count,) if self.method.one_stage else growing_schedule(count)

    def key(self) -> Row:
        """Return everything that determines the outcome; kept results with another key are not used."""
        return {
            "picture": hashlib.sha256(self.picture.read_bytes()).hexdigest(),
            "true": (true := true_svg(self.picture)) and hashlib.sha256(true.read_bytes()).hexdigest(),
            "method": self.method.describe(),
            "schedule": self.schedule and list(self.schedule),
            "seed": self.seed,
            "device": self.device,
            "version": livecl.__version__,
            "source": source_digest(),
        }

    def kept_rows(self) -> list[Row] | None:
        """Return the rows of a finished run, or None."""
        try:
            result = json.loads((self.folder / _RESULT).read_text())
        except (OSError, ValueError):
            return None
        rows: list[Row] = result["rows"]
        return rows if result["key"] == self.key() else None


def picture_name(picture: Path) -> str:
    """Return the picture's name with its folder's."""
    return f"{picture.resolve().parent.name or 'root'}/{picture.name}"


def picture_group(picture: Path) -> str:
    """Return the kind of picture: the part of its name before the first _, or its folder's name.

    >>> picture_group(Path("pics/photo_coffee.png")), picture_group(Path("/data/emoji/1f600.png"))
    ('photo', 'emoji')
    """
    prefix, underscore, _ = picture.stem.partition("_")
    return prefix if underscore and prefix else picture.resolve().parent.name


@functools.cache
def source_digest() -> str:
    """Return a digest of the library, the kernels and the measures: all that can change a result."""
    folders = {Path(livecl.__file__).parent: "*.py", kernel_dir(): "*.[ch]*", Path(__file__).parent: "measures.py"}
    digest = hashlib.sha256()
    for folder, pattern in folders.items():
        for file in sorted(folder.rglob(pattern)):
            name = file.relative_to(folder)
            if name.parts[0] not in _WITHOUT_EFFECT:
                digest.update(name.as_posix().encode() + b"\0" + file.read_bytes())
    return digest.hexdigest()[:16]


def plan(
    pictures: Sequence[Path],
    methods: Sequence[Method],
    asked: Sequence[int | str],
    *,
    seed: int,
    device: str | None,
    output: Path,
) -> list[Run]:
    """Return the runs of every method at every number of paths; VTracer, which takes none, runs once.

    Raises ValueError if a number is that of a true SVG's things or shapes, and there is no such file.
    """
    runs = [
        Run(picture=picture, method=method, asked=count, seed=seed, device=device, output=output)
        for picture, method in itertools.product(pictures, methods)
        for count in ([None] if method.preset == VTRACER else asked)
    ]
    for run in runs:
        if run.asked in (THINGS, SHAPES) and true_svg(run.picture) is None:
            raise ValueError(f"{run.picture}: paths {run.asked!r} need its SVG, {run.picture.stem}.svg beside it")
    return runs


def _number(word: str, picture: Path) -> int:
    """Return the number of things or shapes of a picture's true SVG, at least 1."""
    svg = true_svg(picture)
    if svg is None:
        raise ValueError(f"{picture}: there is no SVG beside it")
    drawing = true_drawing(svg)
    if word == SHAPES:
        return max(1, drawing.num_layers)
    return max(1, len(quality.things_of_drawing(drawing, read_image(picture).shape[:2])))


def execute(run: Run, key: Row) -> list[Row]:
    """Execute a run: write SVG files, then their measures in a JSON file, which marks it as done; return the rows."""
    shutil.rmtree(run.folder, ignore_errors=True)
    run.folder.mkdir(parents=True)
    rows = [_trace(run) if run.method.preset == VTRACER else _vectorize(run, run.method.options())]
    write_atomically(run.folder / _RESULT, json.dumps({"key": key, "rows": rows}, indent=1, allow_nan=False) + "\n")
    return rows


def execute_all(
    runs: Sequence[Run], keys: Sequence[Row], processes: int
) -> Iterator[tuple[Run, list[Row] | BaseException]]:
    """Execute runs in several processes; yield each with its rows, or with its error.

    A process that dies breaks its pool. The remaining runs are then repeated in separate processes, so that only the
    one that kills its process fails.
    """
    left = []
    with _pool(processes) as pool:
        futures = {pool.submit(execute, run, key): (run, key) for run, key in zip(runs, keys, strict=True)}
        for future in concurrent.futures.as_completed(futures):
            run, key = futures[future]
            error = future.exception()
            if isinstance(error, BrokenProcessPool):
                left.append((run, key))
            else:
                yield run, error or future.result()
    for run, key in left:
        with _pool(1) as pool:
            alone = pool.submit(execute, run, key)
            yield run, alone.exception() or alone.result()


def _pool(processes: int) -> concurrent.futures.ProcessPoolExecutor:
    """Return a pool of spawned processes (forked ones hang in OpenCL), which share the processors evenly."""
    threads = str(max(1, (os.cpu_count() or 1) // processes))
    for variable in ("POCL_MAX_PTHREAD_COUNT", "POCL_CPU_MAX_CU_COUNT", "OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS"):
        os.environ.setdefault(variable, threads)
    return concurrent.futures.ProcessPoolExecutor(
        processes, multiprocessing.get_context("spawn"), initializer=_end_with_the_terminal
    )


def _end_with_the_terminal() -> None:
    """Let Ctrl-C end a worker silently; the main process reports it."""
    signal.signal(signal.SIGINT, signal.SIG_DFL)


def _vectorize(run: Run, options: Options) -> Row:
    clean = read_image(run.picture)
    image = quality.disturbed(over_background(clean, WHITE), kind) if (kind := run.method.disturbance) else clean
    number: Row = {"paths": AUTO} if run.asked == AUTO else {"schedule": run.schedule}
    result = livecl.vectorize(image, **number, options=options, device=run.device, seed=run.seed)
    drawings = [*(stage.drawing for stage in result.stages[:-1]), result.drawing]
    for stage, drawing in enumerate(drawings, start=1):
        save_svg(drawing, run.folder / f"stage-{stage}.svg")
    ground = result.drawing.background
    target = over_background(clean, WHITE if ground is None else ground)
    extra = {
        "seconds": result.seconds,
        "compile_seconds": result.compile_seconds,
        "stages": [drawing.num_layers for drawing in drawings],
    }
    return _row(run, run.folder / f"stage-{len(drawings)}.svg", target, extra)


def _trace(run: Run) -> Row:
    import vtracer

    target = over_background(read_image(run.picture), WHITE)
    png = io.BytesIO()
    image = quality.disturbed(target, run.method.disturbance) if run.method.disturbance else target
    Image.fromarray(np.rint(image * 255).astype(np.uint8)).save(png, "PNG")
    start = time.perf_counter()
    text = vtracer.convert_raw_image_to_svg(png.getvalue(), img_format="png", **run.method.changes)
    seconds = time.perf_counter() - start
    svg = run.folder / "stage-1.svg"
    write_atomically(svg, text)
    row = _row(run, svg, target, {"seconds": seconds})
    return {**row, "stages": [row["paths"]]}


def _row(run: Run, svg: Path, target: FloatImage, extra: Row) -> Row:
    return {
        "picture": run.name,
        "group": picture_group(run.picture),
        "method": run.method.name,
        "asked": run.asked,
        **measure(svg, target, Rasterizer(target.shape[:2], run.device), true_svg(run.picture)),
        **extra,
        "svg": svg.relative_to(run.output).as_posix(),
    }
