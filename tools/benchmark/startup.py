# SPDX-License-Identifier: Apache-2.0
"""Start-up of new processes: ``import livecl``, and the command line up to its first iteration."""

from __future__ import annotations

import os
import subprocess
import sys
import tempfile
import time
from pathlib import Path

from benchmark.checks import CheckError
from benchmark.scenes import FACE

#: Environment variables of the caches of PoCL, pyopencl and NVIDIA's driver.
CACHES = ("POCL_CACHE_DIR", "XDG_CACHE_HOME", "CUDA_CACHE_PATH")
#: A compiled copy of Python's files, as an installed package has: without one, each start would compile the checkout.
_COMPILED = {
    "PYTHONDONTWRITEBYTECODE": "",
    "PYTHONPYCACHEPREFIX": str(Path(tempfile.gettempdir()) / "livecl-bench-pyc"),
}
_IMPORT = "import time; start = time.perf_counter(); import livecl; print(time.perf_counter() - start)"


def import_seconds(root: Path) -> float:
    """Return the time of ``import livecl`` in a new interpreter, its own start left out."""
    found = subprocess.run(
        [sys.executable, "-c", _IMPORT],
        cwd=tempfile.gettempdir(),
        env={**os.environ, "PYTHONPATH": str(root), **_COMPILED},
        capture_output=True,
        text=True,
        check=True,
    )
    return float(found.stdout)


def first_iteration_seconds(root: Path, device: str | None, *, cold: bool) -> float:
    """Return the time that the command line takes for one path and one iteration, from its start to its end.

    Writing the file and ending are part of it, so that it is a little more than the time to the first iteration.

    Parameters
    ----------
    root : path
        The checkout.
    device : str or None
        OpenCL device.
    cold : bool
        Start with empty caches, so that the kernels are compiled. The files of Python and its packages stay in memory.

    Raises
    ------
    CheckError
        If it fails, or does not write a drawing of one path.
    """
    with tempfile.TemporaryDirectory() as folder:
        output = Path(folder) / "out.svg"
        command = [sys.executable, str(root / "tools" / "vectorize.py"), str(FACE), "-o", str(output), "--quiet"]
        command += ["--preset", "paper", "--paths", "1", "--iterations", "1"]
        command += ["--device", device] if device is not None else []
        environment = os.environ | _COMPILED
        if cold:
            caches = Path(folder) / "caches"
            caches.mkdir()
            environment |= dict.fromkeys(CACHES, str(caches))
        start = time.perf_counter()
        ended = subprocess.run(command, cwd=folder, env=environment, capture_output=True, text=True, check=False)
        seconds = time.perf_counter() - start
        if ended.returncode:
            reason = ended.stderr.strip().splitlines()[-1:] or ["no message"]
            raise CheckError(f"tools/vectorize.py ended with {ended.returncode}: {reason[0]}")
        if output.read_text(encoding="utf-8").count("<path") != 1:
            raise CheckError("tools/vectorize.py did not write a drawing of one path")
    return seconds
