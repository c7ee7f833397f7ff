# SPDX-License-Identifier: Apache-2.0
"""How far a run has come is saved and loaded whole, and other files are refused."""

from __future__ import annotations

import dataclasses
import io
import json
import os
import zipfile
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from support.states import assert_equal, disc_and_ring, equal, load, save, start

from livecl import CheckpointError, Drawing, LiveclError, Options
from livecl.drawing import LINEAR, RADIAL, Fills
from livecl.drawing.assembly import empty_drawing
from livecl.run.checkpoint import FORMAT, KIND
from livecl.run.loop import train
from livecl.run.progress import Progress
from livecl.run.run import Run
from livecl.training.adam import Adam
from livecl.training.fills import FillMoments
from livecl.training.state import Fallback, State

# Iterations enough for two looks for loops within a stage; all kinds of loss, placement and chance.


def _full() -> Progress:
    """Return a progress of which every field differs from what a new one has."""
    rng = np.random.default_rng(1)

    def drawing(stages: list[int]) -> Drawing:
        return Drawing(
            points=rng.normal(size=(7, 3, 2)) * 100,
            colors=rng.uniform(size=(2, 4)),
            size=(24, 27),
            background=rng.uniform(size=3),
            subpath_offsets=[0, 3, 5, 7],
            layer_offsets=[0, 1, 3],
            stages=stages,
            fills=Fills(
                kinds=[RADIAL, LINEAR],
                geometry=rng.uniform(0, 20, (2, 3, 2)),
                stop_offsets=[0, 3, 5],
                stop_positions=[0, 0.3, 1, 0, 0.9],
                stop_colors=rng.uniform(size=(5, 4)),
            ),
        )

    def adam(*shape: int) -> Adam:
        return Adam(rng.normal(size=shape), rng.uniform(size=shape), rng.integers(0, 1000, size=shape[0]))

    generator = np.random.default_rng(9)
    generator.normal(size=3)
    generator.integers(0, 5, dtype=np.int32)  # leaves half a number in the generator
    moments = FillMoments(adam(2, 3, 2), adam(5, 5))
    state = State(
        drawing=drawing([0, 3]),
        options=Options.released(iterations=77, xing_weight=0.1 + 0.2, background="#123456", untangle=True),
        stage=5,
        iteration=76,
        length=80,
        losses=(0.5, 0.25),
        points=adam(7, 3, 2),
        colors=adam(2, 4),
        widths=adam(2, 1),
        background=adam(1, 3),
        fills=FillMoments(adam(2, 3, 2), adam(5, 5)),
        pieces=rng.integers(1, 40, size=7).astype(np.int32),
        rng=generator,
        kept_weight=rng.uniform(size=(24, 27)).astype(np.float32),
        hidden=rng.uniform(size=(7, 3)) < 0.5,
        holds=np.array([2, 0], np.int8),
        keeps_colors=True,
    )
    return Progress(
        state=state,
        schedule=(1, 2, 4),
        start_drawing=drawing([2, 1]),
        placed=True,
        asked=3,
        failures=2,
        error=0.1 + 0.7,
        fallback=Fallback(
            drawing([1, 2]), adam(7, 3, 2), adam(2, 4), adam(2, 1), moments, np.array([1, 0], np.int8), 0.125
        ),
    )


@pytest.mark.parametrize("kind", ["full", "new", "transparent"])
def test_what_is_saved_is_loaded_equal_in_every_field(kind: str, tmp_path: Path) -> None:
    progress = _full() if kind == "full" else start(Options())
    if kind == "transparent":
        progress = Progress.start(empty_drawing((3, 5), None), Options.paper(), (4,), 3)
    path = tmp_path / "a checkpoint"
    save(progress, path)
    assert [item.name for item in tmp_path.iterdir()] == ["a checkpoint"], "no other name, and nothing left beside it"
    loaded = load(path)
    assert_equal(loaded, progress)
    assert loaded.state.rng.normal() == progress.state.rng.normal()
    if kind == "full":
        new = start(Options())
        for part, other in ((progress, new), (progress.state, new.state)):
            fields = [field.name for field in dataclasses.fields(part)]
            same = [name for name in fields if equal(getattr(part, name), getattr(other, name))]
            assert not same, "fields that this test would not miss"


def test_a_loaded_run_may_be_trained(device: int, tmp_path: Path) -> None:
    # Adam changes its arrays in place: they must not be read-only, or shared.
    run_ = Run(disc_and_ring(), start(Options(iterations=4, revisions=0)), device)
    train(run_, lambda step: True)
    save(run_.progress, tmp_path / "state")
    first, second = load(tmp_path / "state"), load(tmp_path / "state")
    train(Run(disc_and_ring(), first, device))
    assert_equal(second, run_.progress)


def test_saving_replaces_the_file_whole_or_not_at_all(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = tmp_path / "state"
    save(_full(), path)
    before = path.read_bytes()

    def fail(*arguments: Any) -> None:
        raise OSError("no space left on the device")

    monkeypatch.setattr(Path, "replace", fail)  # on Python 3.10, os.replace is called by another name
    save(start(Options()), path)
    assert path.read_bytes() == before and len(list(tmp_path.iterdir())) == 1


def _refused(path: Path) -> None:
    with pytest.raises(CheckpointError) as caught:
        load(path)
    message = str(caught.value)
    named, _, reason = message.partition(": is no checkpoint that can be read: ")
    assert named == os.fspath(path)
    assert reason and "\n" not in reason and len(reason) < 400


def _saved(path: Path) -> bytes:
    save(_full(), path)
    return path.read_bytes()


def _archive(**arrays: Any) -> bytes:
    buffer = io.BytesIO()
    np.savez(buffer, **arrays)
    return buffer.getvalue()


def _array(array: Any) -> bytes:
    buffer = io.BytesIO()
    np.save(buffer, array)
    return buffer.getvalue()


def _zip(**members: bytes) -> bytes:
    buffer = io.BytesIO()
    with zipfile.ZipFile(buffer, "w") as archive:
        for name, data in members.items():
            archive.writestr(name, data)
    return buffer.getvalue()


FOREIGN = {
    "empty": b"",
    "text": b"not a state\nof anything\n",
    "zeros": bytes(1000),
    "svg": b'<svg xmlns="http://www.w3.org/2000/svg"/>',
    "pickle": b"\x80\x04\x95\x0b\x00\x00\x00\x00\x00\x00\x00}\x94\x8c\x01a\x94K\x01s.",
    "one array": _array(np.arange(5)),
    "other arrays": _archive(points=np.zeros((1, 3, 2))),
    "facts that are no JSON": _archive(facts=np.array("nothing")),
    "facts that are a list": _archive(facts=np.array("[1, 2]")),
    "facts that are a number": _archive(facts=np.array(3)),
    "another format": _archive(facts=np.array(json.dumps({"kind": KIND, "format": 99}))),
    "facts alone": _archive(facts=np.array(json.dumps({"kind": KIND, "format": FORMAT, "identity": {}, "state": {}}))),
    "a zip of text": _zip(facts=b"{}", readme=b"hello"),
}


@pytest.mark.parametrize("name", FOREIGN)
def test_a_foreign_file_is_refused_in_one_line(name: str, tmp_path: Path) -> None:
    path = tmp_path / "foreign"
    path.write_bytes(FOREIGN[name])
    _refused(path)


def test_no_file_and_a_folder(tmp_path: Path) -> None:
    _refused(tmp_path / "missing")
    _refused(tmp_path)


def test_a_truncated_file_is_refused_wherever_it_ends(tmp_path: Path) -> None:
    path = tmp_path / "state"
    data = _saved(path)
    for length in [*range(0, 200, 10), *range(200, len(data) - 1, len(data) // 60), len(data) - 1]:
        path.write_bytes(data[:length])
        _refused(path)


def test_a_changed_byte_is_found_or_does_no_harm(tmp_path: Path) -> None:
    # The archive has a checksum of each member's contents; names, dates and lengths are in its own tables.
    path = tmp_path / "state"
    data, progress = _saved(path), _full()
    rng = np.random.default_rng(0)
    tables = data.index(b"PK\x01\x02")
    places = [*rng.integers(0, tables, size=60), *rng.integers(tables, len(data), size=140)]
    refused = 0
    for place in places:
        changed = bytearray(data)
        changed[place] ^= int(rng.integers(1, 256))
        path.write_bytes(bytes(changed))
        try:
            loaded = load(path)
        except LiveclError as error:
            assert "\n" not in str(error), str(error)
            refused += 1
        else:
            assert equal(loaded.schedule, progress.schedule)
            assert equal(loaded.state.drawing, progress.state.drawing)
            assert equal(loaded.state.points, progress.state.points)
    assert refused > 50


def _with_facts(path: Path, **changes: Any) -> None:
    with np.load(path) as file:
        arrays = dict(file)
    facts = json.loads(str(arrays.pop("facts")))
    facts["state"] |= changes
    path.write_bytes(_archive(facts=np.array(json.dumps(facts)), **arrays))


@pytest.mark.parametrize(
    "changes",
    [
        {"options": {**dataclasses.asdict(Options()), "iterations": 0}},
        {"options": {**dataclasses.asdict(Options()), "of a later version": 1}},
        {"options": None},
        {"schedule": None},
        {"size": [0, 4]},
        {"size": "large"},
        {"rng": {"bit_generator": "MT19937"}},
        {"rng": None},
    ],
)
def test_numbers_that_make_no_run_are_refused(changes: dict[str, Any], tmp_path: Path) -> None:
    path = tmp_path / "state"
    _saved(path)
    _with_facts(path, **changes)
    _refused(path)


def test_missing_arrays_are_refused(tmp_path: Path) -> None:
    path = tmp_path / "state"
    _saved(path)
    with np.load(path) as file:
        arrays = dict(file)
    for name in arrays:
        if name in ("kept_weight", "hidden", "fallback.points", "start.points") or name.endswith("background"):
            continue  # a run may have none of these
        path.write_bytes(_archive(**{other: array for other, array in arrays.items() if other != name}))
        _refused(path)


def test_a_run_of_another_picture_is_refused(device: int) -> None:
    with pytest.raises(ValueError, match=r"^image: \(8, 9\) pixels, wanted the drawing's \(24, 27\)$"):
        Run(np.ones((8, 9, 3)), start(Options()), device)
