#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Sweep folders of SVG files: count those read right, with a warning, refused, or silently wrong.

Each file is read and rendered, and compared with the PNG of the same name (or name and -ref), or, if there is none,
with resvg's picture; tools/compare_svg.py derives the bounds. The frame that a test suite draws around each picture,
and W3C's line of revision, are removed from the file, and the pixels that they change from the comparison: as text,
they would cause a warning for every file. Prints a table by folder; returns 1 if a file is silently wrong.

Files whose reference is known to be wrong are listed in a file (`--known`), one name per line, `#` begins a comment;
they count as right and are named.
"""

import argparse
import collections
import dataclasses
import re
import sys
import warnings
from collections.abc import Iterable
from pathlib import Path
from typing import Any

import numpy as np
from compare_svg import EDGE, FLAT, differences, premultiplied, shown_by_resvg
from numpy.typing import NDArray
from scipy import ndimage

import livecl
from livecl.arrays import FloatArray
from livecl.drawing import Drawing
from livecl.drawing.assembly import stretched
from livecl.errors import SvgError

#: Largest side compared, px.
MAX_SIDE = 2048

_FRAMES = re.compile(
    r'<rect\b[^<>]*\bid="(?:test-)?frame"[^<>]*?(?:/>|>\s*</rect>)'
    r'|<text\b[^<>]*\bid="revision"[^<>]*>.*?</text>'
    r'|<g\b[^<>]*\bid="draft-watermark"[^<>]*>.*?</g>',
    re.DOTALL,
)


@dataclasses.dataclass(frozen=True, kw_only=True)
class Outcome:
    """A file: its outcome, the reader's message, and the difference of its picture from the reference."""

    path: Path
    kind: str
    message: str = ""
    layers: int = 0
    mse: float = 0.0
    edge: float = 0.0
    flat: float = 0.0

    @property
    def differs(self) -> bool:
        """Whether the pictures differ by more than antialiasing and rounding."""
        return self.edge > EDGE or self.flat > FLAT


def without_frame(data: bytes) -> tuple[bytes, bool]:
    """Return an SVG without its suite's frame, and whether it had one."""
    stripped = _FRAMES.sub("", data.decode("latin-1")).encode("latin-1")
    return stripped, stripped != data


def reference(path: Path, data: bytes) -> FloatArray:
    """Return the PNG beside an SVG, or resvg's picture of `data`, in premultiplied RGBA: (H, W, 4)."""
    for picture in (path.with_suffix(".png"), path.with_name(f"{path.stem}-ref.png")):
        if picture.is_file():
            return premultiplied(livecl.read_image(picture))
    return shown_by_resvg(data, path.parent)


def frame_pixels(path: Path, size: tuple[int, int]) -> NDArray[np.bool_]:
    """Return the pixels that the frame changes, and their neighbours: (H, W)."""
    data = path.read_bytes()
    height, width = size
    shown = [shown_by_resvg(text, path.parent, width, height) for text in (data, without_frame(data)[0])]
    changed = (shown[0] != shown[1]).any(axis=2)[:height, :width]
    mask = np.zeros(size, dtype=bool)
    mask[: changed.shape[0], : changed.shape[1]] = ndimage.binary_dilation(changed, np.ones((3, 3)))
    return mask


def resized(drawing: Drawing, size: tuple[int, int]) -> Drawing:
    """Return a drawing scaled to a canvas of `size` (height, width), px."""
    if np.abs(np.subtract(drawing.size, size)).max() <= 1:
        return drawing
    factors = size[1] / drawing.size[1], size[0] / drawing.size[0]
    return stretched(drawing, factors, size)


def outcome(path: Path) -> Outcome:
    """Read a file and compare it with its reference."""
    data, has_frame = without_frame(path.read_bytes())
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        try:
            drawing = livecl.read_svg(data)
        except SvgError as error:
            return Outcome(path=path, kind="refused", message=str(error).removeprefix("SVG data: "))
    message = "; ".join(str(item.message).removeprefix("SVG data: ") for item in caught)
    facts: dict[str, Any] = {"path": path, "layers": drawing.num_layers, "message": message}
    try:
        picture = reference(path, data)
        if max(picture.shape[:2]) > MAX_SIDE:
            raise ValueError("too large")
        drawing = resized(drawing, picture.shape[:2])
        ignored = frame_pixels(path, picture.shape[:2]) if has_frame else None
        mse, edge, flat = differences(drawing, picture, ignored)
    except ValueError as error:
        return Outcome(
            **facts | {"message": message or f"not compared: {error}"}, kind="warned" if message else "apart"
        )
    found = Outcome(**facts, kind="warned", mse=mse, edge=edge, flat=flat)
    return found if message else dataclasses.replace(found, kind="wrong" if found.differs else "right")


def files(folders: Iterable[Path], every: int) -> list[Path]:
    """Return each `every`-th SVG file of the folders, links left out."""
    found = [
        path
        for folder in folders
        for path in ([folder] if folder.is_file() else sorted(folder.rglob("*.svg")))
        if path.is_file() and not path.is_symlink()
    ]
    return found[::every]


def print_table(found: list[Outcome]) -> None:
    """Print the number of files of each outcome, by folder."""
    print("| folder | files | right | warned (shown right) | refused | silently wrong | not compared |")
    print("|---|--:|--:|--:|--:|--:|--:|")
    folders = collections.defaultdict(list)
    for item in found:
        folders[str(item.path.parent)].append(item)
    rows = [*folders.items(), ("all", found)] if len(folders) > 1 else list(folders.items())
    for folder, items in rows:
        count = collections.Counter(item.kind for item in items)
        agreeing = sum(item.kind == "warned" and not item.differs for item in items)
        warned = f"{count['warned']} ({agreeing})" if count["warned"] else "0"
        print(
            f"| {folder} | {len(items)} | {count['right']} | {warned} | {count['refused']} | {count['wrong']} "
            f"| {count['apart']} |"
        )


def main() -> int:
    """Print the files that went wrong and the table; return 1 if a file is silently wrong."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folders", nargs="+", type=Path, metavar="FOLDER", help="SVG files, or folders of them")
    parser.add_argument("--every", type=int, default=1, metavar="N", help="only each N-th file")
    parser.add_argument("--known", type=Path, metavar="FILE", help="names of files whose reference is wrong")
    parser.add_argument("--verbose", action="store_true", help="a line for each file")
    arguments = parser.parse_args()
    lines = arguments.known.read_text(encoding="utf-8").splitlines() if arguments.known else []
    known = {line.partition("#")[0].strip() for line in lines} - {""}
    found = []
    for path in files(arguments.folders, arguments.every):
        item = outcome(path)
        if item.kind == "wrong" and any(path.match(name) for name in known):
            item = dataclasses.replace(item, kind="right", message="the reference is wrong")
        if arguments.verbose or item.kind in ("wrong", "apart"):
            shown = f"edge {item.edge:.2g}, flat {item.flat:.1f}"
            print(f"{item.kind}: {path} ({item.layers} layers; {shown}) {item.message[:300]}", flush=True)
        found.append(item)
    print_table(found)
    return 1 if any(item.kind == "wrong" for item in found) else 0


if __name__ == "__main__":
    sys.exit(main())
