# SPDX-License-Identifier: Apache-2.0
"""A state is saved and loaded whole, a run resumed from one ends as if it had not stopped, and other files fail."""

from __future__ import annotations

import dataclasses
import io
import json
import os
import zipfile
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from livecl import Drawing, LiveclError, Options, State
from livecl.drawing.drawing import empty_drawing
from livecl.run.callbacks import Step
from livecl.run.loop import train
from livecl.run.run import Run
from livecl.svg import format_svg
from livecl.training.adam import Adam
from livecl.training.state import Fallback

SCHEDULE = (1, 2)


def _picture() -> NDArray[np.float32]:
    """Return a disc with a bar across it and a ring beside it, 24 x 27, with soft edges."""
    rows, columns = (np.indices((24 * 4, 27 * 4)) + 0.5) / 4
    picture = np.ones((24 * 4, 27 * 4, 3))
    distance = np.hypot(rows - 11, columns - 10)
    picture[distance < 8] = (0.8, 0.2, 0.1)
    picture[(np.abs(rows - 12) < 2) & (np.abs(columns - 11) < 9)] = (0.1, 0.2, 0.7)
    ring = np.hypot(rows - 17, columns - 20)
    picture[(ring > 2) & (ring < 5)] = (0.2, 0.7, 0.2)
    return picture.reshape(24, 4, 27, 4, 3).mean(axis=(1, 3)).astype(np.float32)


def _start(options: Options, seed: int = 0) -> State:
    return State.start(empty_drawing((24, 27)), options, SCHEDULE, seed)


def _equal(one: Any, other: Any) -> bool:
    """Compare values field by field, arrays with their types and to the last bit."""
    if type(one) is not type(other):
        return False
    if isinstance(one, np.ndarray):
        return one.dtype == other.dtype and one.shape == other.shape and one.tobytes() == other.tobytes()
    if isinstance(one, np.random.Generator):
        return bool(one.bit_generator.state == other.bit_generator.state)
    if dataclasses.is_dataclass(one):
        return all(_equal(getattr(one, f.name), getattr(other, f.name)) for f in dataclasses.fields(one))
    return bool(one == other)


def _assert_equal(one: State, other: State) -> None:
    for field in dataclasses.fields(State):
        assert _equal(getattr(one, field.name), getattr(other, field.name)), field.name


def _copies_during(run_: Run, folder: Path, wanted: Callable[[Step], bool]) -> list[Path]:
    """Run to the end, and return the states saved after the steps wanted."""
    saved: list[Path] = []

    def on_step(step: Step) -> None:
        if wanted(step):
            saved.append(folder / f"{step.stage}-{step.iteration}.state")
            run_.state.save(saved[-1])

    train(run_, on_step)
    return saved


# Iterations enough for two looks for loops within a stage; all kinds of loss, placement and chance.
RUNS = {
    "default": Options(iterations=52, revisions=2),
    "distance weight": Options(iterations=35, revisions=1, loss="udf", xing_weight=0.01),
    "paper": Options.paper(iterations=35),
    "released": Options.released(iterations=35),
    "baseline": Options.diffvg(iterations=20),
    "background": Options(iterations=20, revisions=1, background="train", settle=0.3, decay=0.5),
    "enough": Options(iterations=20, revisions=3, path_gain=1e-4, target_mse=1e-7, opacity="train"),
}


@pytest.mark.parametrize("name", RUNS)
def test_a_resumed_run_ends_as_if_it_had_not_stopped(name: str, device: int, tmp_path: Path) -> None:
    options, picture = RUNS[name], _picture()
    whole = Run(picture, _start(options, seed=5), device)
    rng = np.random.default_rng(len(name))
    num_stages = len(SCHEDULE) + options.revisions
    # In each stage a step anywhere, one where pieces are looked at next, and the last: the stage is still to be closed.
    wanted = {(stage, int(rng.integers(1, options.iterations))) for stage in range(num_stages)}
    wanted |= {(1, 10), (1, 17), (0, options.iterations), (num_stages - 1, options.iterations)}
    saved = _copies_during(whole, tmp_path, lambda step: (step.stage, step.iteration) in wanted)
    assert len(saved) >= 4
    expected = format_svg(whole.state.drawing).encode()
    for path in saved:
        resumed = Run(picture, State.load(path), device)
        train(resumed)
        assert format_svg(resumed.state.drawing).encode() == expected, f"resumed from {path.name}"
        _assert_equal(resumed.state, whole.state)


@pytest.mark.parametrize("name", ["default", "released"])
def test_a_run_resumed_between_stages(name: str, device: int, tmp_path: Path) -> None:
    options, picture = RUNS[name], _picture()
    whole = Run(picture, _start(options), device)
    paths = []
    while not whole.finished:
        paths.append(tmp_path / f"{whole.state.stage}.state")
        whole.state.save(paths[-1])
        whole.begin()
        for _ in range(options.iterations):
            whole.step()
        whole.end()
    assert len(paths) == len(SCHEDULE) + options.revisions
    for path in paths:
        resumed = Run(picture, State.load(path), device)
        train(resumed)
        _assert_equal(resumed.state, whole.state)


def test_stopping_at_every_step_changes_nothing(device: int, tmp_path: Path) -> None:
    options, picture = Options(iterations=6, revisions=1), _picture()
    whole = Run(picture, _start(options), device)
    train(whole)
    state = _start(options)
    for _ in range(100):
        run_ = Run(picture, state, device)
        train(run_, lambda step: True)
        state.save(tmp_path / "state")
        state = State.load(tmp_path / "state")
        if run_.finished:
            break
    _assert_equal(state, whole.state)


def test_the_outcome_of_a_resumed_run_goes_on_from_the_stage(device: int, tmp_path: Path) -> None:
    options, picture = Options.paper(iterations=12), _picture()
    first = Run(picture, _start(options), device)
    (outcome,) = train(first, lambda step: step.iteration == 7)
    assert (outcome.iterations, outcome.paths) == (7, 1)
    first.state.save(tmp_path / "state")
    outcomes = train(Run(picture, State.load(tmp_path / "state"), device))
    assert [(stage.iterations, stage.paths) for stage in outcomes] == [(5, 1), (12, 3)]


def _full_state() -> State:
    """Return a state in which every field differs from what a new one has."""
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
        )

    def adam(*shape: int) -> Adam:
        return Adam(rng.normal(size=shape), rng.uniform(size=shape), rng.integers(0, 1000, size=shape[0]))

    generator = np.random.default_rng(9)
    generator.normal(size=3)
    generator.integers(0, 5, dtype=np.int32)  # leaves half a number in the generator
    return State(
        drawing=drawing([0, 3]),
        options=Options.released(iterations=77, xing_weight=0.1 + 0.2, background="#123456", untangle=True),
        schedule=(1, 2, 4),
        stage=5,
        iteration=76,
        points=adam(7, 3, 2),
        colors=adam(2, 4),
        background=adam(1, 3),
        pieces=rng.integers(1, 40, size=7).astype(np.int32),
        rng=generator,
        kept_weight=rng.uniform(size=(24, 27)).astype(np.float32),
        asked=3,
        error=0.1 + 0.7,
        placed=True,
        failures=2,
        holds=np.array([2, 0], np.int8),
        start_drawing=drawing([2, 1]),
        fallback=Fallback(drawing([1, 2]), adam(7, 3, 2), adam(2, 4), np.array([1, 0], np.int8)),
    )


@pytest.mark.parametrize("kind", ["full", "new", "transparent"])
def test_what_is_saved_is_loaded_equal_in_every_field(kind: str, tmp_path: Path) -> None:
    state = _full_state() if kind == "full" else _start(Options())
    if kind == "transparent":
        state = State.start(empty_drawing((3, 5), None), Options.paper(), (4,), 3)
    path = tmp_path / "a state"
    state.save(path)
    assert [item.name for item in tmp_path.iterdir()] == ["a state"], "no other name, and nothing left beside it"
    loaded = State.load(path)
    _assert_equal(loaded, state)
    _assert_equal(State.load(str(path)), state)
    assert loaded.rng.normal() == state.rng.normal()
    if kind == "full":
        new = _start(Options())
        same = [f.name for f in dataclasses.fields(State) if _equal(getattr(state, f.name), getattr(new, f.name))]
        assert not same, "fields that this test would not miss"


def test_a_loaded_state_may_be_trained(device: int, tmp_path: Path) -> None:
    # Adam changes its arrays in place: they must not be read-only, or shared.
    run_ = Run(_picture(), _start(Options(iterations=4, revisions=0)), device)
    train(run_, lambda step: True)
    run_.state.save(tmp_path / "state")
    first, second = State.load(tmp_path / "state"), State.load(tmp_path / "state")
    train(Run(_picture(), first, device))
    _assert_equal(second, run_.state)


def test_saving_replaces_the_file_whole_or_not_at_all(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = tmp_path / "state"
    _full_state().save(path)
    before = path.read_bytes()

    def fail(*arguments: Any) -> None:
        raise OSError("no space left on the device")

    monkeypatch.setattr(Path, "replace", fail)  # on Python 3.10, os.replace is called by another name
    with pytest.raises(OSError, match="no space"):
        _start(Options()).save(path)
    assert path.read_bytes() == before and len(list(tmp_path.iterdir())) == 1


def _refused(path: Path) -> None:
    with pytest.raises(LiveclError) as caught:
        State.load(path)
    message = str(caught.value)
    assert message.startswith(f"{os.fspath(path)!r} is not a saved state of livecl: ")
    assert "\n" not in message and len(message) < 400


def _saved(path: Path) -> bytes:
    _full_state().save(path)
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
    "another format": _archive(facts=np.array(json.dumps({"format": 99}))),
    "facts alone": _archive(facts=np.array(json.dumps({"format": 1}))),
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
    data, state = _saved(path), _full_state()
    rng = np.random.default_rng(0)
    tables = data.index(b"PK\x01\x02")
    places = [*rng.integers(0, tables, size=60), *rng.integers(tables, len(data), size=140)]
    refused = 0
    for place in places:
        changed = bytearray(data)
        changed[place] ^= int(rng.integers(1, 256))
        path.write_bytes(bytes(changed))
        try:
            loaded = State.load(path)
        except LiveclError as error:
            assert "\n" not in str(error), str(error)
            refused += 1
        else:
            for name in ("drawing", "points", "schedule"):
                assert _equal(getattr(loaded, name), getattr(state, name))
    assert refused > 50


def _with_facts(path: Path, **changes: Any) -> None:
    with np.load(path) as file:
        arrays = dict(file)
    facts = {**json.loads(str(arrays.pop("facts"))), **changes}
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
def test_numbers_that_make_no_state_are_refused(changes: dict[str, Any], tmp_path: Path) -> None:
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
        if name in ("kept_weight", "fallback.points", "start.points") or name.endswith("background"):
            continue  # a state may have none of these
        path.write_bytes(_archive(**{other: array for other, array in arrays.items() if other != name}))
        _refused(path)


def test_a_state_of_another_picture_is_refused(device: int) -> None:
    with pytest.raises(ValueError, match=r"^image: \(8, 9\) pixels, wanted the drawing's \(24, 27\)$"):
        Run(np.ones((8, 9, 3)), _start(Options()), device)
