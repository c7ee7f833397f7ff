# SPDX-License-Identifier: Apache-2.0
"""Inputs of a batch: find pictures in files, folders and patterns, and name their SVGs."""

from __future__ import annotations

import dataclasses
import glob
import os
from collections import Counter
from collections.abc import Callable, Iterable, Sequence
from pathlib import Path

from livecl.image.source import SUFFIXES


@dataclasses.dataclass(frozen=True)
class Input:
    """A picture of a batch and the name of its SVG."""

    file: Path  # the picture
    output: str  # its SVG, relative to the output folder, with ``/`` between folders


def is_pattern(text: str) -> bool:
    """Return whether a text is a pattern such as ``photos/*.png``, and not the name of a file."""
    return glob.has_magic(text) and not os.path.lexists(text)


def find_pictures(inputs: Iterable[str | os.PathLike[str]]) -> list[Input]:
    """Return the pictures of files, folders and patterns, each once, in order.

    Folders are searched recursively for pictures, by suffix, without hidden files. The SVG of ``photos/a/b.png`` is
    ``a/b.svg`` if the folder ``photos`` was given, and ``b.svg`` if the file was. Pictures that would share a name,
    ignoring case, are named by their path below the common folder of all inputs; if that does not distinguish them
    (``b.png`` and ``b.jpg``), their suffix is kept: ``b.png.svg``. Raises ValueError if an input is missing or has no
    pictures.
    """
    found: dict[str, tuple[Path, Path]] = {}  # by real path: the file, and its path below the input
    for given in inputs:
        text = os.fspath(given)
        if not text:
            raise ValueError("inputs: got an empty path, wanted pictures or folders of pictures")
        files = _expanded(text)
        if not files:
            kind = "the pattern matches no picture" if is_pattern(text) else "the folder holds no pictures"
            raise ValueError(f"{text}: {kind} ({', '.join(sorted(SUFFIXES))})")
        for file, place in files:
            found.setdefault(os.path.realpath(file), (file, place))
    if not found:
        raise ValueError("inputs: got none, wanted pictures or folders of pictures")
    outputs = _outputs(list(found.values()))
    return [Input(file, output) for (file, _), output in zip(found.values(), outputs, strict=True)]


def _expanded(text: str) -> list[tuple[Path, Path]]:
    path = Path(text)
    if is_pattern(text):
        matches = [Path(match) for match in sorted(glob.glob(text, recursive=True))]  # noqa: PTH207 -- may be absolute
        return [(match, Path(match.name)) for match in matches if match.is_file() and _is_picture(match)]
    if not path.exists():
        raise ValueError(f"{text}: there is no such file; check the path")
    if not path.is_dir():
        return [(path, Path(path.name))]
    return [(file, file.relative_to(path)) for file in sorted(_walk(path))]


def _walk(folder: Path) -> Iterable[Path]:
    for parent, folders, names in os.walk(folder):
        folders[:] = [name for name in folders if not name.startswith(".")]
        yield from (Path(parent, name) for name in names if _is_picture(Path(name)))


def _is_picture(file: Path) -> bool:
    return file.suffix.lower() in SUFFIXES and not file.name.startswith(".")


def _outputs(files: Sequence[tuple[Path, Path]]) -> list[str]:
    absolute = [Path(os.path.abspath(file)) for file, _ in files]  # noqa: PTH100 -- resolve() would follow links
    common = Path(os.path.commonpath([file.parent for file in absolute]))
    namings: list[Callable[[int], Path]] = [
        lambda index: files[index][1].with_suffix(".svg"),
        lambda index: absolute[index].relative_to(common).with_suffix(".svg"),
        lambda index: (place := absolute[index].relative_to(common)).with_name(f"{place.name}.svg"),
    ]
    names = [""] * len(files)
    shared = list(range(len(files)))
    for naming in namings:
        for index in shared:
            names[index] = naming(index).as_posix()
        counts = Counter(name.casefold() for name in names)
        shared = [index for index in shared if counts[names[index].casefold()] > 1]
    taken = {name.casefold() for index, name in enumerate(names) if index not in shared}
    for index in shared:  # names equal apart from case
        stem, number = names[index].removesuffix(".svg"), 1
        while names[index].casefold() in taken:
            number += 1
            names[index] = f"{stem}-{number}.svg"
        taken.add(names[index].casefold())
    return names
