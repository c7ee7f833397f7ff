# SPDX-License-Identifier: Apache-2.0
"""What a figure depends on beside the code: device, driver, versions, commit; and the memory of this process."""

from __future__ import annotations

import importlib.metadata
import os
import platform
import re
import resource
import subprocess
from pathlib import Path
from typing import Any

from livecl.opencl.device import OpenDevice

#: Packages whose versions are told.
PACKAGES = ("numpy", "pyopencl", "pocl-binary-distribution", "scikit-image")


def facts(opened: OpenDevice, root: Path) -> dict[str, Any]:
    """Return device, driver, processor, load, versions and the commit of a checkout."""
    import livecl

    return {
        "device": str(opened.info),
        "driver": f"{opened.device.platform.name.strip()} {opened.device.driver_version.strip()}",
        "compute_units": int(opened.device.max_compute_units),
        "processor": _processor(),
        "cores": os.cpu_count(),
        "load": os.getloadavg()[0],
        "system": f"{platform.system()} {platform.release()}",
        "python": platform.python_version(),
        "livecl": livecl.__version__,
        "packages": {name: version for name in PACKAGES if (version := _version(name))},
        "commit": commit(root),
    }


def commit(root: Path) -> str | None:
    """Return the commit of a checkout, with a mark where files differ from it; None where there is none."""
    try:
        head, changes = (
            subprocess.run(["git", *words], cwd=root, capture_output=True, text=True, check=True).stdout.strip()
            for words in (["rev-parse", "--short=12", "HEAD"], ["status", "--porcelain", "--untracked-files=no"])
        )
    except (OSError, subprocess.CalledProcessError):
        return None
    return f"{head} with changes" if changes else head


def peak_megabytes() -> float:
    """Return the largest resident memory of this process so far, in 10^6 bytes.

    Linux's own figure for the program that is running now: `getrusage` also counts the process that started it.
    """
    status = Path("/proc/self/status")
    if status.is_file() and (match := re.search(r"VmHWM:\s*(\d+) kB", status.read_text())):
        return int(match[1]) * 1024e-6
    unit = 1 if platform.system() == "Darwin" else 1024
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * unit * 1e-6


def _processor() -> str:
    info = Path("/proc/cpuinfo")
    match = re.search(r"model name\s*:\s*(.+)", info.read_text()) if info.is_file() else None
    return match[1].strip() if match else platform.processor() or platform.machine()


def _version(package: str) -> str | None:
    try:
        return importlib.metadata.version(package)
    except importlib.metadata.PackageNotFoundError:
        return None
