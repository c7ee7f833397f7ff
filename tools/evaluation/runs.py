# SPDX-License-Identifier: Apache-2.0
"""Runs: one picture by one method, in a process of its own, kept in a folder that says how it was made."""

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
from evaluation.measures import FloatImage, measure
from evaluation.methods import VTRACER, Method, schedule_through
from livecl.files import write_atomically
from livecl.image.background import WHITE
from livecl.image.reading import over_background, read_image
from livecl.opencl.program import kernel_dir
from livecl.options import Options
from livecl.rendering.rasterizer import Rasterizer
from livecl.svg import save_svg

#: What changes nothing in the outcome of a run.
_WITHOUT_EFFECT = {"__init__.py", "__main__.py", "batch", "cli", "vae", "views"}
_RESULT = "result.json"

Row = dict[str, Any]


@dataclasses.dataclass(frozen=True, kw_only=True)
class Run:
    """One picture by one method.

    Attributes
    ----------
    picture : Path
        The picture's file.
    method : Method
        What is run on it.
    counts : tuple of int
        Numbers of paths asked for, rising; empty where the method chooses itself.
    seed : int
        Seed of whatever is random.
    device : str or None
        OpenCL device.
    output : Path
        Folder of all runs.
    """

    picture: Path
    method: Method
    counts: tuple[int, ...]
    seed: int
    device: str | None
    output: Path

    @property
    def name(self) -> str:
        """Name of the picture: its folder's and its own."""
        return picture_name(self.picture)

    @property
    def title(self) -> str:
        """What the run is called in messages."""
        return " ".join(
            [self.method.name, self.name, *(["at", ",".join(map(str, self.counts))] if self.counts else [])]
        )

    @property
    def folder(self) -> Path:
        """Where the run's SVGs and its result lie."""
        return self.output / "runs" / self.method.name / self.name / ("-".join(map(str, self.counts)) or "free")

    @property
    def schedule(self) -> tuple[int, ...]:
        """Paths that each stage adds."""
        return self.counts if self.method.one_stage else schedule_through(self.counts)

    def key(self) -> Row:
        """Return everything that decides the outcome; a kept result of another key is not taken."""
        return {
            "picture": hashlib.sha256(self.picture.read_bytes()).hexdigest(),
            "method": self.method.describe(),
            "schedule": list(self.schedule),
            "counts": list(self.counts),
            "seed": self.seed,
            "device": self.device,
            "version": livecl.__version__,
            "source": source_digest(),
        }

    def kept_rows(self, any_source: bool = False) -> list[Row] | None:
        """Return the rows of a run that is finished already, or None.

        With `any_source`, it may have been made by another state of the program.
        """
        try:
            result = json.loads((self.folder / _RESULT).read_text())
        except (OSError, ValueError):
            return None
        key, kept = self.key(), result["key"]
        if any_source:
            for name in ("version", "source"):
                key.pop(name), kept.pop(name, None)
        rows: list[Row] = result["rows"]
        return rows if kept == key else None


def picture_name(picture: Path) -> str:
    """Return the picture's name among all: that of its folder and its own."""
    return f"{picture.resolve().parent.name or 'root'}/{picture.name}"


def picture_group(picture: Path) -> str:
    """Return the kind of picture: what stands before the first _ of its name, or its folder's name.

    >>> picture_group(Path("pics/photo_coffee.png")), picture_group(Path("/data/emoji/1f600.png"))
    ('photo', 'emoji')
    """
    prefix, underscore, _ = picture.stem.partition("_")
    return prefix if underscore and prefix else picture.resolve().parent.name


@functools.cache
def source_digest() -> str:
    """Return a digest of the library, the kernels and the measures: whatever can change a result."""
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
    counts: tuple[int, ...],
    *,
    separate: bool,
    seed: int,
    device: str | None,
    output: Path,
) -> list[Run]:
    """Return the runs that give every method's outcome at every number of paths.

    One run with stages serves all numbers, unless each is run separately; a method of one stage needs a run for
    each; VTracer chooses its number itself, and runs once.
    """
    runs: list[Run] = []
    for picture, method in itertools.product(pictures, methods):
        if method.preset == VTRACER:
            asked: list[tuple[int, ...]] = [()]
        elif separate or method.one_stage:
            asked = [(count,) for count in counts]
        else:
            asked = [counts]
        runs.extend(
            Run(picture=picture, method=method, counts=group, seed=seed, device=device, output=output)
            for group in asked
        )
    return runs


def execute(run: Run, key: Row) -> list[Row]:
    """Do a run: SVG files, then their measures in a JSON file that says that all is done. Returns the rows."""
    shutil.rmtree(run.folder, ignore_errors=True)
    run.folder.mkdir(parents=True)
    rows = _trace(run) if run.method.preset == VTRACER else _vectorize(run, run.method.options())
    write_atomically(run.folder / _RESULT, json.dumps({"key": key, "rows": rows}, indent=1, allow_nan=False) + "\n")
    return rows


def execute_all(
    runs: Sequence[Run], keys: Sequence[Row], processes: int
) -> Iterator[tuple[Run, list[Row] | BaseException]]:
    """Do runs in several processes, and yield each with its rows, or with what made it fail.

    A process that dies takes its pool along. What was left then is done again, each run in a process of its own, so
    that only the one that kills its process fails.
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
    """Let Ctrl-C end a worker at once and without a word; the main process tells of it."""
    signal.signal(signal.SIGINT, signal.SIG_DFL)


def _vectorize(run: Run, options: Options) -> list[Row]:
    image = read_image(run.picture)
    result = livecl.vectorize(image, schedule=run.schedule, options=options, device=run.device, seed=run.seed)
    drawings = [*(stage.drawing for stage in result.stages[:-1]), result.drawing]
    for number, drawing in enumerate(drawings, start=1):
        save_svg(drawing, run.folder / f"stage-{number}.svg")
    seconds = list(itertools.accumulate(stage.seconds for stage in result.stages))
    seconds[-1] = result.seconds
    ground = result.drawing.background
    target = over_background(image, WHITE if ground is None else ground)
    rasterizer = Rasterizer(target.shape[:2], run.device)
    asked_after = list(itertools.accumulate(run.schedule))
    rows = []
    for count in run.counts:
        # A run that ends before its schedule does has reached what it can: its last drawing stands for what follows.
        stage = min(asked_after.index(count), len(drawings) - 1)
        extra = {
            "seconds": seconds[stage],
            "compile_seconds": result.compile_seconds,
            "stages": [drawing.num_layers for drawing in drawings[: stage + 1]],
        }
        rows.append(_row(run, count, run.folder / f"stage-{stage + 1}.svg", target, rasterizer, extra))
    return rows


def _trace(run: Run) -> list[Row]:
    import vtracer

    target = over_background(read_image(run.picture), WHITE)
    png = io.BytesIO()
    Image.fromarray(np.rint(target * 255).astype(np.uint8)).save(png, "PNG")
    start = time.perf_counter()
    text = vtracer.convert_raw_image_to_svg(png.getvalue(), img_format="png", **run.method.changes)
    seconds = time.perf_counter() - start
    svg = run.folder / "stage-1.svg"
    write_atomically(svg, text)
    row = _row(run, None, svg, target, Rasterizer(target.shape[:2], run.device), {"seconds": seconds})
    return [{**row, "stages": [row["paths"]]}]


def _row(run: Run, asked: int | None, svg: Path, target: FloatImage, rasterizer: Rasterizer, extra: Row) -> Row:
    return {
        "picture": run.name,
        "group": picture_group(run.picture),
        "method": run.method.name,
        "asked": asked,
        **measure(svg, target, rasterizer),
        **extra,
        "svg": svg.relative_to(run.output).as_posix(),
    }
