# SPDX-License-Identifier: Apache-2.0
"""HTML report of a run: one interactive page, without network or libraries."""

from __future__ import annotations

import base64
import hashlib
import os
import string
from collections.abc import Callable, Sequence
from pathlib import Path

from numpy.typing import ArrayLike

from livecl.drawing.assembly import scaled
from livecl.files import write_atomically
from livecl.image.background import TRAIN, WHITE, target_over
from livecl.image.resizing import reduced
from livecl.run.result import Result
from livecl.views.report import markup
from livecl.views.report.measures import differences, layer_facts, page_size
from livecl.views.report.sections import layer_section, run_section, stage_section
from livecl.views.sheet import checked_image, count_of

#: Pictures with a longer side below this, px, are enlarged without smoothing.
TINY = 100


def write_report(
    path: str | os.PathLike[str],
    image: ArrayLike,
    result: Result,
    *,
    command: str | Sequence[str] | None = None,
    name: str | None = None,
    device: int | str | None = None,
    progress: Callable[[int, int], object] | None = None,
) -> None:
    """Write the page of :func:`format_report`, replacing an existing file atomically; arguments as there."""
    write_atomically(path, format_report(image, result, command=command, name=name, device=device, progress=progress))


def format_report(
    image: ArrayLike,
    result: Result,
    *,
    command: str | Sequence[str] | None = None,
    name: str | None = None,
    device: int | str | None = None,
    progress: Callable[[int, int], object] | None = None,
) -> str:
    """Return a page that shows a result: target, drawing and difference, layers and stages, settings.

    The page is self-contained. ``#k=3`` at the end of its address selects the first 3 layers, ``#stage=2`` the drawing
    after the second stage; ``&outlines=1``, ``&points=1`` and ``&layer=0`` may follow.

    Parameters
    ----------
    image : (H, W, 3) or (H, W, 4) array_like
        The target, as for :func:`livecl.image.as_image`. Pictures of more than 512 x 512 px are reduced to that area
        for the page and its measures.
    result : Result
        The run.
    command : str or sequence of str, optional
        The command that repeats it, as a line or as a list of arguments.
    name : str, optional
        Name of the picture.
    device : int, str or None
        OpenCL device that renders.
    progress : callable, optional
        Called with the number of pictures rendered and that of all.

    Returns
    -------
    str
        HTML; the same for the same result.

    Raises
    ------
    ValueError
        If the picture is not of the drawing's size.
    """
    from livecl.rendering.rasterizer import Rasterizer

    pixels = checked_image(image, result.drawing)
    size = page_size(result.drawing)
    shown = reduced(pixels, size)
    rasterizer = Rasterizer(size, device)
    ground = WHITE if result.options.background == TRAIN else result.drawing.background
    target = target_over(shown, ground)
    facts = layer_facts(result.drawing, result.svg, target, rasterizer)
    drawings = [stage.drawing for stage in result.stages] or [result.drawing]
    errors = []
    for done, drawing in enumerate(drawings, start=1):
        errors.append(rasterizer.forward(scaled(drawing, size)) - target)
        if progress is not None:
            progress(done, len(drawings))
    pictures, gain = differences(errors)
    title = name or "Vectorized picture"
    classes = {"tiny": max(size) < TINY, "clear": result.drawing.background is None, "wide": size[1] > 2 * size[0]}
    height, width = result.drawing.size
    difference_alt = "Difference of drawing and target: the stronger the red, the larger"
    style, script = _resource("page.css"), _resource("page.js")
    return string.Template(_resource("page.html")).substitute(
        title=markup.text(title),
        style=style,
        script=script,
        style_hash=_content_hash(style),
        script_hash=_content_hash(script),
        picture_classes=" ".join(word for word, holds in classes.items() if holds),
        summary=markup.text(_summary(result)),
        target=_img(markup.png_uri(shown), f"Target: {title}, {width} by {height} pixels", size),
        drawing=markup.drawing_svg(
            result.drawing,
            markup.PRECISION,
            f'id="drawing" role="img" aria-label="{markup.text(f"Drawing of {title}")}"',
            prefix=markup.PREFIX,
        ),
        difference=_img(pictures[-1], difference_alt, size, 'id="difference"'),
        gain=gain,
        layer_count=count_of(result.drawing.num_layers, "layer"),
        layers=layer_section(result.drawing, facts),
        stages=stage_section(result, pictures),
        run=run_section(result, command, size),
    )


def _img(address: str, alt: str, size: tuple[int, int], attributes: str = "") -> str:
    height, width = size
    return f'<img {attributes} src="{address}" width="{width}" height="{height}" alt="{markup.text(alt)}">'


def _summary(result: Result) -> str:
    height, width = result.drawing.size
    parts = [
        count_of(result.drawing.num_layers, "layer"),
        f"MSE {result.mse:.3g}",
        f"PSNR {markup.psnr_text(result.mse)} dB",
        f"{len(result.svg.encode()):,} bytes of SVG".replace(",", "\N{NO-BREAK SPACE}"),
        f"{width} × {height} px",
        f"{result.seconds:.1f} s",
    ]
    return " · ".join(parts)


def _resource(name: str) -> str:
    return (Path(__file__).resolve().parent / name).read_text(encoding="utf-8")


def _content_hash(content: str) -> str:
    """Return the hash of an inline style or script for a content security policy."""
    return f"sha256-{base64.b64encode(hashlib.sha256(content.encode()).digest()).decode('ascii')}"
