# SPDX-License-Identifier: Apache-2.0
"""The live view: what it shows when, that it renews it in place, and that interrupts end a run with a result."""

from __future__ import annotations

import re
import signal
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from support.results import shaded_drawing

from livecl import LiveclError, Options, vectorize
from livecl.run.callbacks import Step
from livecl.run.result import Result
from livecl.views.notebook import LiveView
from livecl.views.report.markup import drawing_svg

EXAMPLES = Path(__file__).resolve().parents[2] / "examples"


class Handle:
    """Notes what would be displayed."""

    made: list[Handle]

    def __init__(self) -> None:
        self.shown: list[tuple[str, dict[str, str]]] = []
        Handle.made.append(self)

    def display(self, data: dict[str, str], raw: bool) -> None:
        assert raw
        self.shown.append(("display", data))

    def update(self, data: dict[str, str], raw: bool) -> None:
        assert raw
        self.shown.append(("update", data))


@pytest.fixture
def handles(monkeypatch: pytest.MonkeyPatch) -> list[Handle]:
    """Pretend to be in a notebook; the displays made in it."""
    display = pytest.importorskip("IPython.display")
    monkeypatch.setattr("IPython.get_ipython", object)
    monkeypatch.setattr(display, "DisplayHandle", Handle)
    Handle.made = []
    return Handle.made


def run(on_step: Callable[[Step], bool | None]) -> Result:
    image = np.ones((20, 30, 3))
    image[4:15, 5:22] = (0.9, 0.2, 0.1)
    return vectorize(
        image,
        schedule=(1, 1),
        options=Options(placement="region", iterations=6, revisions=0, prune=0.0),
        on_step=on_step,
    )


def test_every_step_in_place(handles: list[Handle]) -> None:
    run(LiveView(interval=0, width=90))
    (handle,) = handles
    assert [kind for kind, _ in handle.shown] == ["display"] + ["update"] * 11
    data = handle.shown[-1][1]
    assert '<svg viewBox="0 0 30 20" width="90"' in data["text/html"]
    assert data["text/html"].count("<path") == 2
    assert "stage 2/2, step 6 of 6, paths 2, loss" in data["text/plain"]
    assert handle.shown[0][1] != data


def test_gradients_of_other_cells_are_not_taken(handles: list[Handle]) -> None:
    one = drawing_svg(shaded_drawing(), 2)
    other = shaded_drawing()
    moved = drawing_svg(other.replace(fills=other.fills.stretched(0.5)), 2)
    names, others = (set(re.findall(r'Gradient id="([^"]*)"', svg)) for svg in (one, moved))
    assert len(names) == len(others) == 2
    assert not names & others
    assert set(re.findall(r"url\(#([^)]*)\)", one)) == names


def test_seldom_but_at_the_end_of_each_stage(handles: list[Handle]) -> None:
    run(LiveView(interval=1000))
    (handle,) = handles
    steps = [data["text/plain"].split("step ")[1][0] for _, data in handle.shown]
    assert steps == ["1", "6", "6"]


def test_another_callback_can_stop(handles: list[Handle]) -> None:
    steps: list[int] = []

    def other(step: Step) -> bool:
        steps.append(step.iteration)
        return step.iteration == 3

    run(LiveView(interval=1000, on_step=other))
    assert steps == [1, 2, 3]
    assert handles[0].shown[-1][1]["text/plain"].endswith(", stopped")


def test_interrupt_ends_the_run_with_a_result(handles: list[Handle]) -> None:
    before = signal.getsignal(signal.SIGINT)

    def interrupt(step: Step) -> None:
        if step.stage == 1 and step.iteration == 2:
            signal.raise_signal(signal.SIGINT)

    with LiveView(on_step=interrupt) as view:
        result = run(view)
    assert view.interrupted
    assert (len(result.stages), result.stages[-1].iterations) == (2, 2)
    assert signal.getsignal(signal.SIGINT) is before


def test_second_interrupt_is_one(handles: list[Handle]) -> None:
    before = signal.getsignal(signal.SIGINT)

    def interrupt(step: Step) -> None:
        signal.raise_signal(signal.SIGINT)
        signal.raise_signal(signal.SIGINT)

    with pytest.raises(KeyboardInterrupt), LiveView(on_step=interrupt) as view:
        run(view)
    assert signal.getsignal(signal.SIGINT) is before


def test_outside_of_a_notebook(monkeypatch: pytest.MonkeyPatch) -> None:
    pytest.importorskip("IPython")
    with pytest.raises(LiveclError, match="a live view needs a notebook"):
        LiveView()
    monkeypatch.setitem(sys.modules, "IPython", None)
    with pytest.raises(LiveclError, match="pip install notebook"):
        LiveView()


@pytest.mark.parametrize(
    ("arguments", "message"), [({"interval": -1}, "interval: got -1"), ({"width": 0}, "width: got 0")]
)
def test_bad_arguments(handles: list[Handle], arguments: dict[str, Any], message: str) -> None:
    with pytest.raises(ValueError, match=message):
        LiveView(**arguments)


@pytest.mark.slow
def test_example_in_a_real_notebook() -> None:
    nbformat, nbclient = pytest.importorskip("nbformat"), pytest.importorskip("nbclient")
    pytest.importorskip("ipykernel")
    kept = nbformat.read(EXAMPLES / "notebook.ipynb", as_version=4)
    assert (EXAMPLES / "notebook.ipynb").stat().st_size < 100_000
    book = nbformat.from_dict(kept)
    nbclient.NotebookClient(book, timeout=240, resources={"metadata": {"path": str(EXAMPLES)}}).execute()
    codes = [cell for cell in book.cells if cell.cell_type == "code"]
    for cell, before in zip(codes, (cell for cell in kept.cells if cell.cell_type == "code"), strict=True):
        kinds, kinds_before = (
            [sorted(output.get("data", {})) for output in c.outputs if output.output_type != "stream"]
            for c in (cell, before)
        )
        assert kinds == kinds_before  # the notebook is kept as it was executed
    # One display, which was renewed up to the last step.
    (shown,) = codes[0].outputs
    assert "step 60 of 60" in shown.data["text/plain"]
    assert "<svg" in shown.data["text/html"]
    assert "image/svg+xml" in codes[1].outputs[0].data


@pytest.mark.slow
def test_interrupt_in_a_real_notebook() -> None:
    nbformat, nbclient = pytest.importorskip("nbformat"), pytest.importorskip("nbclient")
    pytest.importorskip("ipykernel")
    book = nbformat.v4.new_notebook()
    book.cells = [
        nbformat.v4.new_code_cell(
            "import os, signal, livecl, livecl.views.notebook\n"
            "def stop(step):\n"
            "    if step.iteration == 5: os.kill(os.getpid(), signal.SIGINT)\n"
            "with livecl.views.notebook.LiveView(on_step=stop) as view:\n"
            "    result = livecl.vectorize('face.png', paths=4, on_step=view)\n"
            "print(view.interrupted, len(result.stages), result.stages[0].iterations < 200)"
        ),
        nbformat.v4.new_code_cell("print('goes on')"),
    ]
    nbclient.NotebookClient(book, timeout=240, resources={"metadata": {"path": str(EXAMPLES)}}).execute()
    assert book.cells[0].outputs[-1].text == "True 1 True\n"
    assert book.cells[1].outputs[0].text == "goes on\n"
