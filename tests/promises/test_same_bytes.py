# SPDX-License-Identifier: Apache-2.0
"""The same input, options, device and version give the same SVG, whatever else differs between two runs."""

from __future__ import annotations

import functools
import json
import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest
from support import small_runs

SCRIPT = Path(__file__).resolve().parents[1] / "support" / "small_runs.py"
#: A locale with a decimal comma, from which `localedef` makes what the C library reads.
COMMA = """\
comment_char %
escape_char /
LC_NUMERIC
decimal_point ","
thousands_sep "."
grouping 3;3
END LC_NUMERIC
""" + "".join(
    f'{category}\ncopy "POSIX"\nEND {category}\n'
    for category in ("LC_CTYPE", "LC_COLLATE", "LC_TIME", "LC_MONETARY", "LC_MESSAGES")
)


def threads(count: int) -> dict[str, str]:
    """Return the environment variables that set the threads of the device and of any BLAS of NumPy and SciPy."""
    return dict.fromkeys(
        ("POCL_MAX_PTHREAD_COUNT", "OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"), str(count)
    )


def digests_with(*names: str, cwd: Path | None = None, options: tuple[str, ...] = (), **changes: str) -> dict[str, str]:
    """Return the digests of runs in a process of its own."""
    command = [sys.executable, *options, str(SCRIPT), *names]
    environment = {**os.environ, "PYTHONPATH": str(SCRIPT.parents[1]), **changes}
    done = subprocess.run(command, env=environment, cwd=cwd, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    found: dict[str, str] = json.loads(done.stdout)
    return found


@functools.cache
def digests_here(*names: str) -> dict[str, str]:
    """Return the digests of runs in this process."""
    return small_runs.digests(names)


@pytest.mark.slow
def test_repeated_runs() -> None:
    # Other runs come between, on the same device and in the same kernel and buffer objects.
    assert small_runs.digests(list(small_runs.RUNS)[::-1]) == digests_here(*small_runs.RUNS)


@pytest.mark.slow
def test_one_thread_in_another_process() -> None:
    assert digests_with(**threads(1), PYTHONHASHSEED="1") == digests_here(*small_runs.RUNS)


@pytest.mark.slow
def test_four_threads_elsewhere(tmp_path: Path) -> None:
    found = digests_with(**threads(4), PYTHONHASHSEED="2", TZ="Asia/Tokyo", LC_ALL="C", cwd=tmp_path)
    assert found == digests_here(*small_runs.RUNS)


NAMES = (*small_runs.RUNS, *small_runs.BUSY)


@pytest.mark.full
@pytest.mark.parametrize("count", [1, 2, 3, 4])
def test_threads_of_the_device(count: int) -> None:
    assert digests_with(*NAMES, POCL_MAX_PTHREAD_COUNT=str(count)) == digests_here(*NAMES)


@pytest.mark.full
@pytest.mark.parametrize("count", [1, 2, 4])
def test_threads_of_linear_algebra(count: int) -> None:
    some = {name: value for name, value in threads(count).items() if name != "POCL_MAX_PTHREAD_COUNT"}
    assert digests_with(*NAMES, **some) == digests_here(*NAMES)


@pytest.mark.full
@pytest.mark.parametrize("seed", ["0", "1", "31337", "random"])
def test_hash_seeds(seed: str) -> None:
    assert digests_with(PYTHONHASHSEED=seed) == digests_here(*small_runs.RUNS)


@pytest.mark.full
def test_cold_kernel_caches(tmp_path: Path) -> None:
    changes = {"XDG_CACHE_HOME": str(tmp_path), "POCL_CACHE_DIR": str(tmp_path / "pocl")}
    assert digests_with(**changes) == digests_here(*small_runs.RUNS)


@pytest.mark.full
def test_optimized_python() -> None:
    assert digests_with(options=("-O", "-B")) == digests_here(*small_runs.RUNS)


@pytest.mark.full
def test_a_locale_with_a_decimal_comma(tmp_path: Path) -> None:
    if shutil.which("localedef") is None:
        pytest.skip("localedef is not here")
    (tmp_path / "source").write_text(COMMA, encoding="ascii")
    # localedef warns of the categories that are left out, and ends with 1 then.
    subprocess.run(["localedef", "-c", "-i", "source", "./comma"], cwd=tmp_path, capture_output=True, check=False)
    changes = {"LOCPATH": str(tmp_path), "LC_ALL": "comma"}
    point = "import locale; locale.setlocale(locale.LC_ALL, ''); print(locale.localeconv()['decimal_point'])"
    shown = subprocess.run(
        [sys.executable, "-c", point], env={**os.environ, **changes}, capture_output=True, text=True, check=True
    )
    assert shown.stdout.strip() == ",", "the locale is not in effect, so the test would show nothing"
    assert digests_with(**changes) == digests_here(*small_runs.RUNS)
