# SPDX-License-Identifier: Apache-2.0
"""The same work on a Dask cluster, of real worker processes on this machine, one of which is killed."""

from __future__ import annotations

import contextlib
import os
import re
import signal
import socket
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from types import SimpleNamespace
from typing import Any, cast

import distributed
import pytest
from distributed import Client, LocalCluster
from support.batches import QUICK, SLOW, Deadly, make_pictures, single_runs, svgs

from livecl.batch import cluster as batch_cluster
from livecl.batch.batch import vectorize_files
from livecl.batch.cluster import cluster_client
from livecl.batch.pool import Task
from livecl.batch.summary import Outcome
from livecl.errors import LiveclError
from livecl.options import PRESETS
from livecl.run.recipe import Recipe

ROOT = Path(__file__).resolve().parents[2]


@pytest.fixture(scope="module")
def cluster() -> Iterator[LocalCluster]:
    """A cluster of two spawned workers of one thread."""
    with LocalCluster(
        n_workers=2,
        threads_per_worker=1,
        processes=True,
        dashboard_address="127.0.0.1:0",
        env={"POCL_MAX_PTHREAD_COUNT": "1"},
        silence_logs=50,
    ) as cluster:
        yield cluster


@pytest.mark.slow
def test_a_killed_worker_loses_no_picture(tmp_path: Path, cluster: LocalCluster) -> None:
    files = make_pictures(tmp_path / "in", 5)
    with Client(cluster, set_as_default=False) as client:
        (victim, *_) = client.run(os.getpid).values()
    killed: list[int] = []

    def kill_once(_: Outcome) -> None:
        if not killed:
            killed.append(victim)
            os.kill(victim, signal.SIGKILL)

    outcomes = vectorize_files(
        files, tmp_path / "out", recipe=SLOW, scheduler=cluster.scheduler_address, on_outcome=kill_once
    )
    assert killed == [victim]
    assert [outcome.status for outcome in outcomes] == ["done"] * 5
    assert [outcome.output for outcome in outcomes] == [f"picture-{index}.svg" for index in range(5)]
    assert svgs(tmp_path / "out") == single_runs(files, SLOW)


@pytest.mark.slow
def test_a_bad_picture_does_not_stop_the_others(tmp_path: Path, cluster: LocalCluster) -> None:
    files = make_pictures(tmp_path / "in", 2)
    bad = tmp_path / "in" / "a-bad.png"
    bad.write_text("no picture")
    outcomes = vectorize_files([bad, *files], tmp_path / "out", recipe=QUICK, scheduler=cluster.scheduler_address)
    assert [outcome.status for outcome in outcomes] == ["failed", "done", "done"]
    assert outcomes[0].message.startswith(f"{bad}: ")
    assert svgs(tmp_path / "out") == single_runs(files, QUICK)


class Future:
    """A picture on a cluster that is reported as done in each of some states, one after the other."""

    def __init__(self, states: list[str], outcome: object) -> None:
        self.states = states
        self.outcome = outcome

    @property
    def status(self) -> str:
        return self.states[0]

    def result(self) -> object:
        if isinstance(self.outcome, Exception):
            raise self.outcome
        return self.outcome

    def exception(self) -> object:
        return self.outcome

    def release(self) -> None:
        pass


class Completed:
    """Stands for Dask's `as_completed`: each time a future is reported again it has gone on to its next state."""

    def __init__(self, loop: object) -> None:
        self.queue: list[Future] = []
        self.seen: set[int] = set()

    def add(self, future: Future) -> None:
        if id(future) in self.seen:
            future.states.pop(0)
        self.seen.add(id(future))
        self.queue.append(future)

    def __iter__(self) -> Iterator[Future]:
        while self.queue:
            yield self.queue.pop(0)


def _answers_of(futures: list[Future], monkeypatch: pytest.MonkeyPatch) -> list[tuple[int, object]]:
    waiting = iter(futures)
    client = SimpleNamespace(nthreads=lambda: {"a": 1}, loop=None, submit=lambda *_, **__: next(waiting))
    monkeypatch.setattr(distributed, "as_completed", Completed)
    tasks = [Task(number, b"", f"{number}.png") for number in range(len(futures))]
    return [
        (task.number, answer)
        for task, answer in batch_cluster._answers(iter(tasks), cast(Any, None), cast(Any, client))
    ]


@pytest.mark.parametrize("state", ["lost", "pending"])
def test_a_result_that_died_with_its_worker_is_waited_for_again(state: str, monkeypatch: pytest.MonkeyPatch) -> None:
    futures = [Future([state, state, "finished"], "svg"), Future(["finished"], "other")]
    assert sorted(_answers_of(futures, monkeypatch)) == [(0, "svg"), (1, "other")]


def test_a_result_whose_makers_all_died_is_suspect(monkeypatch: pytest.MonkeyPatch) -> None:
    killed = distributed.KilledWorker("make", None, 3)
    assert _answers_of([Future(["finished"], killed)], monkeypatch) == [(0, None)]


def test_a_lost_scheduler_ends_the_batch(monkeypatch: pytest.MonkeyPatch) -> None:
    with pytest.raises(LiveclError, match="connection to the Dask scheduler was lost"):
        _answers_of([Future(["cancelled"], None)], monkeypatch)


@pytest.mark.slow
def test_a_cluster_for_the_time_of_the_batch(tmp_path: Path) -> None:
    files = make_pictures(tmp_path / "in", 3)
    deadly = Deadly(paths=QUICK.paths, options=QUICK.options)
    outcomes = vectorize_files(files, tmp_path / "out", recipe=deadly, scheduler="local", workers=2)
    assert [outcome.status for outcome in outcomes] == ["failed", "done", "done"]
    assert outcomes[0].message == "the worker processes that had it died"
    assert svgs(tmp_path / "out") == single_runs(files[1:], QUICK)


@pytest.mark.slow
def test_the_commands_of_the_documentation(tmp_path: Path) -> None:
    (file,) = make_pictures(tmp_path / "photos", 1)
    text = (ROOT / "docs" / "clusters.md").read_text(encoding="utf-8")
    lines = re.findall(r"^ *((?:POCL\S+ )?(?:dask|livecl) .*10\.0\.0\.5.*)$", text, re.MULTILINE)
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        port = str(free.getsockname()[1])
    scheduler, worker, client = (line.replace("10.0.0.5", "127.0.0.1").replace("8786", port).split() for line in lines)
    variable, worker = worker[0].split("=", 1), worker[1:]
    environment = {**os.environ, "PYTHONPATH": str(ROOT), variable[0]: variable[1]}
    with contextlib.ExitStack() as stack:
        for command in (scheduler, worker):
            process = subprocess.Popen(
                [
                    sys.executable,
                    "-m",
                    *command,
                    *(["--dashboard-address", "127.0.0.1:0"] if command is scheduler else []),
                ],
                env=environment,
                cwd=tmp_path,
                stderr=subprocess.DEVNULL,
            )
            stack.callback(process.wait, 30)
            stack.callback(process.terminate)
        done = subprocess.run(
            [sys.executable, "-m", *client, "--paths", "2", "--iterations", "5", "--revisions", "0"],
            env=environment,
            cwd=tmp_path,
            capture_output=True,
            text=True,
            timeout=100,
            check=False,
        )
    assert done.returncode == 0, done.stderr
    assert done.stderr.endswith("svgs: 1 done\n")  # after a warning, where the worker has not joined yet
    recipe = Recipe(paths=2, options=PRESETS["photo"](iterations=5, revisions=0))
    assert svgs(tmp_path / "svgs") == single_runs([file], recipe)


def test_without_dask(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "distributed", None)
    with pytest.raises(ValueError, match=r"pip install 'livecl\[cluster\]'"), cluster_client("local"):
        pass
