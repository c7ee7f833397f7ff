# SPDX-License-Identifier: Apache-2.0
"""Caches of compiled kernels: broken ones, those that cannot be written to, and builds that are killed."""

from __future__ import annotations

import itertools
import os
import random
import shutil
import signal
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

import livecl
from livecl.image.reading import save_image
from livecl.opencl import caches

ROOT = Path(__file__).resolve().parents[2]
COMMAND = [sys.executable, "-m", "livecl", "in.png", "-o", "out.svg"]
COMMAND += ["--paths", "1", "--iterations", "2", "--revisions", "0"]
#: Variables that say where caches lie.
FOLDERS = ("HOME", "XDG_CACHE_HOME", "POCL_CACHE_DIR")

pytestmark = pytest.mark.skipif(sys.platform != "linux", reason="the caches looked after are those of PoCL on Linux")


@pytest.fixture(autouse=True)
def only_pocl() -> None:
    if {info.platform for info in livecl.list_devices()} != {"Portable Computing Language"}:
        pytest.skip("the default device is not PoCL, or not alone")


def run(folder: Path, **variables: str) -> subprocess.CompletedProcess[str]:
    """Vectorize a small picture; of the variables for caches only those given are set."""
    save_image(folder / "in.png", np.full((8, 8, 3), (0.2, 0.5, 0.7)))
    return subprocess.run(
        COMMAND, cwd=folder, env=environment(**variables), capture_output=True, text=True, timeout=180, check=False
    )


def environment(**variables: str) -> dict[str, str]:
    kept = {name: value for name, value in os.environ.items() if name not in FOLDERS}
    return {**kept, "PYTHONPATH": str(ROOT), **variables}


def messages(done: subprocess.CompletedProcess[str]) -> list[str]:
    """Return the lines on standard error without the progress bar and the summary."""
    return [line for line in done.stderr.splitlines() if line.startswith("livecl: ")]


@pytest.fixture(scope="module")
def warm(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return a folder with a run's SVG and the caches that it has filled."""
    folder = tmp_path_factory.mktemp("warm")
    done = run(folder, XDG_CACHE_HOME=str(folder / "caches"))
    assert done.returncode == 0 and not messages(done), done.stderr
    return folder


def cached_files(folder: Path) -> list[Path]:
    """Return the program and the libraries in a folder's cache of PoCL."""
    cache = folder / "caches" / "pocl" / "kcache"
    return sorted(cache.glob("*/*/program.bc")) + sorted(cache.glob("*/*/*/*/*.so"))


BREAKAGES: dict[str, Callable[[bytes], bytes]] = {
    "empty": lambda data: b"",
    "first half": lambda data: data[: len(data) // 2],
    "without the last byte": lambda data: data[:-1],
    "zeros": lambda data: bytes(len(data)),
    "other bytes": lambda data: bytes(255 - value for value in data),
}


@pytest.mark.slow
@pytest.mark.parametrize("breakage", BREAKAGES)
def test_whole_and_broken_files_are_told_apart(breakage: str, warm: Path, tmp_path: Path) -> None:
    files = cached_files(warm)
    assert len(files) > 5
    for path in files:
        is_whole = {".bc": caches.is_whole_bitcode, ".so": caches.is_whole_library}[path.suffix]
        assert is_whole(path)
        broken = tmp_path / path.name
        broken.write_bytes(BREAKAGES[breakage](path.read_bytes()))
        assert not is_whole(broken)


@pytest.mark.slow
@pytest.mark.parametrize("breakage", ["empty", "first half", "zeros"])
def test_a_run_recovers_from_a_broken_cache(breakage: str, warm: Path, tmp_path: Path) -> None:
    shutil.copytree(warm, tmp_path, dirs_exist_ok=True)
    (tmp_path / "out.svg").unlink()
    files = cached_files(tmp_path)
    broken = [files[0], *[path for path in files if path.suffix == ".so"][:2]]
    for path in broken:
        path.write_bytes(BREAKAGES[breakage](path.read_bytes()))
    done = run(tmp_path, XDG_CACHE_HOME=str(tmp_path / "caches"))
    assert done.returncode == 0, done.stderr
    assert sorted(messages(done)) == sorted(
        f"livecl: warning: {path} is broken; it is deleted, and its kernel is compiled anew" for path in broken
    )
    assert (tmp_path / "out.svg").read_bytes() == (warm / "out.svg").read_bytes()
    assert cached_files(tmp_path) == files, "broken files have been compiled anew and kept"


@pytest.mark.slow
def test_pyopencl_s_broken_cache_is_replaced(warm: Path, tmp_path: Path) -> None:
    shutil.copytree(warm, tmp_path, dirs_exist_ok=True)
    (database,) = (tmp_path / "caches" / "pytools").iterdir()
    database.write_bytes(b"no database" * 1000)
    done = run(tmp_path, XDG_CACHE_HOME=str(tmp_path / "caches"))
    assert done.returncode == 0, done.stderr
    (message,) = messages(done)
    assert message.startswith("livecl: warning: pyopencl's cache is broken (file is not a database)")


def unusable(variables: dict[str, str]) -> bool:
    """Return whether PoCL's rule leads to a folder that cannot be made; without any, to a folder that can."""
    return "file" in next((variables[name] for name in reversed(FOLDERS) if name in variables), "")


SETTINGS = [
    dict(zip(FOLDERS, words, strict=True)) for words in itertools.product(("", "folder", "file/below"), repeat=3)
]


@pytest.mark.slow
@pytest.mark.parametrize(
    "setting",
    [
        pytest.param(setting, id="-".join(word or "unset" for word in setting.values()), marks=marks)
        for setting in SETTINGS
        for marks in [() if list(setting.values()) == ["file/below"] * 3 else pytest.mark.full]
    ],
)
def test_a_run_succeeds_wherever_caches_cannot_be_kept(setting: dict[str, str], tmp_path: Path) -> None:
    (tmp_path / "file").touch()
    variables = {name: str(tmp_path / word) for name, word in setting.items() if word}
    done = run(tmp_path, **variables, TMPDIR=str(tmp_path))
    assert done.returncode == 0, done.stderr
    told = messages(done)
    assert any(line.startswith("livecl: warning: PoCL cannot keep compiled kernels in ") for line in told) == unusable(
        variables
    )
    for line in told:
        assert line.startswith(("livecl: warning: PoCL cannot keep", "livecl: warning: pyopencl cannot keep")), line
        assert "Not a directory" in line
    assert "Traceback" not in done.stderr
    assert not list(tmp_path.glob("livecl-*")), "the temporary folder is deleted at the end"


def test_a_folder_without_permission_is_replaced(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    monkeypatch.setenv("POCL_CACHE_DIR", str(tmp_path / "cache"))
    monkeypatch.setattr(os, "access", lambda *_: False)  # root may write everywhere
    caches.prepare_pocl_cache.__wrapped__()
    assert os.environ["POCL_CACHE_DIR"] != str(tmp_path / "cache")
    assert Path(os.environ["POCL_CACHE_DIR"]).parent.is_dir()
    (record,) = caplog.records
    assert f"in {tmp_path / 'cache'} (Permission denied)" in record.getMessage()


def test_what_other_processes_are_writing_is_left_alone(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setenv("POCL_CACHE_DIR", str(tmp_path))
    half_done = [tmp_path / "tempfile_abc.so", tmp_path / "tempfile_def"]
    for path in half_done:
        path.write_bytes(b"\x7fELF")
    (tmp_path / "AB" / "CDEF").mkdir(parents=True)
    (tmp_path / "AB" / "CDEF" / "program.bc").write_bytes(b"BC")
    caches.prepare_pocl_cache.__wrapped__()
    assert all(path.exists() for path in half_done) and not (tmp_path / "AB" / "CDEF" / "program.bc").exists()


#: Runs that are killed while they compile.
KILLS = 20


@pytest.mark.full
def test_runs_that_are_killed_while_they_compile_leave_a_cache_that_the_next_one_can_use(
    warm: Path, tmp_path: Path
) -> None:
    rng = random.Random(1)
    expected, num_files = (warm / "out.svg").read_bytes(), len(cached_files(warm))
    save_image(tmp_path / "in.png", np.full((8, 8, 3), (0.2, 0.5, 0.7)))
    for kill in range(KILLS):
        shutil.rmtree(tmp_path / "caches", ignore_errors=True)
        variables = environment(XDG_CACHE_HOME=str(tmp_path / "caches"))
        process = subprocess.Popen(COMMAND, cwd=tmp_path, env=variables, stderr=subprocess.DEVNULL)
        while len(cached_files(tmp_path)) < kill * num_files // KILLS and process.poll() is None:
            time.sleep(0.002)
        time.sleep(rng.uniform(0, 0.3))  # about as long as a kernel takes to compile
        process.send_signal(signal.SIGKILL)
        process.wait()
        done = run(tmp_path, XDG_CACHE_HOME=str(tmp_path / "caches"))
        assert done.returncode == 0, done.stderr
        assert (tmp_path / "out.svg").read_bytes() == expected
