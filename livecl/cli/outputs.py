# SPDX-License-Identifier: Apache-2.0
"""Output files of a run: their list, the checks before the work, and the writing after it."""

from __future__ import annotations

import dataclasses
import importlib.util
import json
import os
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from livecl.cli.facts import facts
from livecl.cli.messages import write_standard
from livecl.cli.progress import OutputProgress
from livecl.files import check_file, check_folder, write_atomically
from livecl.run.recipe import Recipe
from livecl.run.result import Result

if TYPE_CHECKING:
    from livecl.views.course import Course

#: The name that stands for standard input and output.
STANDARD = "-"


@dataclasses.dataclass(frozen=True)
class Finished:
    """A finished run, as the outputs need it."""

    name: str  # the picture's name
    image: NDArray[np.float32]  # (H, W, 3) or (H, W, 4), the picture
    recipe: Recipe  # paths, options and size of the run
    result: Result  # result of the run
    command: tuple[str, ...] = ("livecl",)  # the command line, word by word
    course: Course | None = None  # drawings during the training, if an output shows them
    device: int | str | None = None  # OpenCL device that renders for the outputs, as it did for the run
    quiet: bool = True  # show no progress


@dataclasses.dataclass(frozen=True)
class Output:
    """A kind of output beside the SVG; an entry in `OUTPUTS` adds one."""

    name: str  # its argument, without the dashes
    #: For ``--help``.
    metavar: str
    help: str
    write: Callable[[Path, Finished], None]  # writes it to a path
    #: If the output is a folder: the files in it, from the folder and the number of stages.
    parts: Callable[[Path, int], list[Path]] | None = None
    suffixes: tuple[str, ...] = ()  # allowed suffixes of the file; empty for any
    extra: tuple[str, str] | None = None  # a module that it needs, and the extra that installs it
    shows_course: bool = False  # whether it shows drawings during the training

    def check(self, path: Path) -> None:
        """Raise ValueError for a path that it cannot be written to, or if a module that it needs is missing."""
        if self.suffixes and path.suffix.lower() not in self.suffixes:
            raise ValueError(f"--{self.name}: got {path}, wanted a name that ends in {' or '.join(self.suffixes)}")
        if self.extra is not None and importlib.util.find_spec(self.extra[0]) is None:
            raise ValueError(f"--{self.name}: needs {self.extra[0]}: pip install 'livecl[{self.extra[1]}]'")


def stage_files(folder: Path, num_stages: int) -> list[Path]:
    """Return the files of all stages."""
    return [folder / f"stage-{index + 1}.svg" for index in range(num_stages)]


def write_stages(folder: Path, finished: Finished) -> None:
    """Write the drawing after each stage."""
    folder.mkdir(exist_ok=True)
    stages = finished.result.stages
    for file, stage in zip(stage_files(folder, len(stages)), stages, strict=True):
        write_atomically(file, finished.recipe.svg(stage.drawing))


def write_json(file: Path, finished: Finished) -> None:
    """Write size, options, error and seconds."""
    write_atomically(file, json.dumps(facts(finished.result, finished.recipe), indent=2, allow_nan=False) + "\n")


def write_html(file: Path, finished: Finished) -> None:
    """Write an HTML page with the result's layers, stages and errors."""
    from livecl.views.report.page import write_report

    with OutputProgress(file.name, "picture", quiet=finished.quiet) as progress:
        write_report(
            file,
            finished.image,
            finished.result,
            command=finished.command,
            name=finished.name,
            device=finished.device,
            progress=progress.show,
        )


def write_sheet(file: Path, finished: Finished) -> None:
    """Write picture and stages side by side."""
    from livecl.views.sheet import save_sheet

    with OutputProgress(file.name, "picture", quiet=finished.quiet) as progress:
        save_sheet(file, finished.image, finished.result, device=finished.device, progress=progress.show)


def write_plot(file: Path, finished: Finished) -> None:
    """Write the error against the number of paths."""
    from livecl.views.sheet import save_plot

    with OutputProgress(file.name, "plot", quiet=finished.quiet) as progress:
        save_plot(file, finished.result)
        progress.show(1, 1)


def write_film(file: Path, finished: Finished) -> None:
    """Write the course of the training as a GIF or an MP4, by the suffix."""
    assert finished.course is not None
    save = finished.course.save_gif if file.suffix.lower() == ".gif" else finished.course.save_mp4
    with OutputProgress(file.name, "frame", quiet=finished.quiet) as progress:
        save(file, result=finished.result, device=finished.device, progress=progress.show)


#: Outputs beside the SVG, in the order of writing.
OUTPUTS = (
    Output("stages", "DIR", "also write the drawing after each stage: DIR/stage-1.svg ...", write_stages, stage_files),
    Output("json", "FILE", "also write size, options, error, layers and seconds as JSON", write_json),
    Output("report", "OUT.html", "also write an HTML page with layers, stages and errors", write_html),
    Output("sheet", "OUT.png", "also write the picture and its stages side by side", write_sheet, suffixes=(".png",)),
    Output(
        "plot",
        "OUT.png",
        "also plot the error against the number of paths, as PNG or SVG (extra: plots)",
        write_plot,
        suffixes=(".png", ".svg"),
        extra=("matplotlib", "plots"),
    ),
    Output(
        "gif",
        "OUT.gif",
        "also write the course of the training as a GIF",
        write_film,
        suffixes=(".gif",),
        shows_course=True,
    ),
    Output(
        "mp4",
        "OUT.mp4",
        "also write the course of the training as a film (extra: video)",
        write_film,
        suffixes=(".mp4",),
        extra=("imageio_ffmpeg", "video"),
        shows_course=True,
    ),
)


def write_svg(file: str, finished: Finished) -> None:
    """Write the SVG to a file, or to standard output."""
    text = finished.recipe.svg(finished.result.drawing)
    if file == STANDARD:
        write_standard(text.encode())
    else:
        write_atomically(file, text)


def check_outputs(
    source: str,
    output: str,
    chosen: Sequence[tuple[Output, Path]],
    num_stages: int,
    checkpoint: str | os.PathLike[str] | None = None,
) -> None:
    """Raise ValueError for outputs that cannot be written, or would overwrite the picture or each other."""
    files = [] if output == STANDARD else [Path(output)]
    if checkpoint is not None:
        files.append(Path(checkpoint))
    for kind, path in chosen:
        kind.check(path)
        if kind.parts is None:
            files.append(path)
            continue
        if not path.exists():
            check_folder(path.parent, path)
        elif not path.is_dir():
            raise ValueError(f"{path}: is a file, wanted a folder for the {kind.name}")
        files += kind.parts(path, num_stages)
    for file in files:
        if file.parent.exists() or file.parent not in [path for _, path in chosen]:
            check_file(file)
    places = [os.path.realpath(file) for file in files]
    for file, place in zip(files, places, strict=True):
        if source != STANDARD and file.exists() and file.samefile(source):
            raise ValueError(f"{file}: is the picture itself and would be overwritten")
        if places.count(place) > 1 and not file.is_char_device():
            raise ValueError(f"{file}: two outputs would go to this file")
