# SPDX-License-Identifier: Apache-2.0
"""Sections of the report: layers, stages, settings of the run."""

from __future__ import annotations

import dataclasses
import importlib.metadata
import platform
import shlex
from collections.abc import Sequence

from livecl.drawing.drawing import Drawing
from livecl.drawing.labels import layer_labels
from livecl.options import Options
from livecl.run.result import Result
from livecl.svg.writer import layer_kinds, quantize
from livecl.version import __version__
from livecl.views.report import markup
from livecl.views.report.measures import LayerFacts
from livecl.views.report.plot import error_plot

_PACKAGES = ("numpy", "scipy", "scikit-image", "pyopencl")


def layer_section(drawing: Drawing, facts: Sequence[LayerFacts]) -> str:
    """Return the list of layers, topmost first, as in editors."""
    if not facts:
        return "<p>The drawing has no layers.</p>"
    rows = []
    shown = quantize(drawing, markup.PRECISION)
    kinds = layer_kinds(drawing, markup.PRECISION)
    for layer, (label, stage, fact) in enumerate(zip(layer_labels(drawing), drawing.stages, facts, strict=True)):
        group = " / ".join(drawing.groups[layer])
        fill = markup.fill_of(shown, layer)
        worth = "" if fact.gradient is None else f" (one colour instead: {fact.gradient:+.3g})"
        area, share = f"{fact.area:.0f}", f"{100 * fact.area_share:.1f} %"
        said = (
            f"{label} · {kinds[layer]}{f' in {group}' if group else ''} · {fill}{worth} · visible {area} px, {share} · "
            f"removes an error of {fact.removed:.3g} · "
            f"{fact.num_nodes} nodes, {fact.num_bytes} bytes"
        )
        cells = [
            f'{markup.swatch(shown, layer)} <button type="button">{markup.text(label)}</button>',
            kinds[layer],
            markup.text(fill),
            area,
            share,
            f"{fact.removed:.3g}",
            "" if fact.gradient is None else f"{fact.gradient:.3g}",
            str(fact.num_nodes),
            str(fact.num_bytes),
            markup.text(group),
            str(stage + 1),
        ]
        rows.append((f' data-facts="{markup.text(said)}"', cells))
    measures = ("Visible, px", "Visible", "Error removed", "By its gradient", "Nodes", "Bytes")
    head = ("Layer", "Shape", "Fill", *measures, "Group", "Stage")
    listed = markup.table(head, rows[::-1], 'id="layers"')
    return f'<div class="scroll">{listed}</div>'


def stage_section(result: Result, differences: Sequence[str]) -> str:
    """Return the stages as pictures, as a plot and as a table."""
    if not result.stages:
        return "<p>There were no stages.</p>"
    strip = markup.stage_strip(result.stages, differences)
    course = markup.stage_table(result.stages)
    return f'<div>{strip}\n<div class="scroll">{course}</div></div>\n{error_plot(result.stages)}'


def run_section(result: Result, command: str | Sequence[str] | None, size: tuple[int, int]) -> str:
    """Return the settings of the run, and the command that repeats it."""
    packages = {package: importlib.metadata.version(package) for package in _PACKAGES}
    facts = {
        "Device": result.device,
        "Time": f"{result.seconds:.2f} s, and {result.compile_seconds:.2f} s to build the kernels",
        **({} if result.stopped is None else {"Stopped before its end": result.stopped}),
        "Worked on": _pixels(result.working_size or result.drawing.size),
        "Layers are measured on": _pixels(size),
        "Versions": f"livecl {__version__}, Python {platform.python_version()}, "
        + ", ".join(f"{package} {version}" for package, version in packages.items()),
    }
    options, defaults = dataclasses.asdict(result.options), dataclasses.asdict(Options())
    changed = {
        name: f"{value} (default: {defaults[name]})" for name, value in options.items() if value != defaults[name]
    }
    changed["layers after each stage"] = ", ".join(str(stage.paths) for stage in result.stages) or "none"
    parts = []
    if command is not None:
        line = command if isinstance(command, str) else shlex.join(command)
        parts.append(f"<p>To repeat it:</p>\n<pre><code>{markup.text(line)}</code></pre>")
    parts.append(markup.facts_table(facts))
    parts.append("<h3>Options that differ from the defaults</h3>")
    parts.append(markup.facts_table(changed))
    parts.append(f"<details><summary>All options</summary>{markup.facts_table(options)}</details>")
    return "\n".join(parts)


def _pixels(size: tuple[int, int]) -> str:
    return f"{size[1]} × {size[0]} px"
