# SPDX-License-Identifier: Apache-2.0
"""Description of the machine: device, driver, versions, commit; and the memory of this process."""

from __future__ import annotations

import importlib.metadata
import os
import platform
import re
import resource
import subprocess
from pathlib import Path
from typing import Any

#: Packages whose versions are reported.
PACKAGES = ("numpy", "pyopencl", "pocl-binary-distribution", "scikit-image")


def facts(opened: Any, root: Path) -> dict[str, Any]:
    """Return device, driver, processor, load, versions and the commit of a checkout."""
    installed = {found.metadata["Name"]: found.version for found in importlib.metadata.distributions()}
    return {
        "device": str(opened.info),
        "driver": opened.device.driver_version.strip(),
        "cores": os.cpu_count(),
        "load": os.getloadavg()[0],
        "system": f"{platform.system()} {platform.release()}, Python {platform.python_version()}",
        "packages": {name: installed[name] for name in PACKAGES if name in installed},
        "commit": commit(root),
    }


def commit(root: Path) -> str:
    """Return the commit of a checkout, with a mark where files differ from it."""
    try:
        head, changes = (
            subprocess.run(["git", *words], cwd=root, capture_output=True, text=True, check=True).stdout.strip()
            for words in (["rev-parse", "--short=12", "HEAD"], ["status", "--porcelain", "--untracked-files=no"])
        )
    except (OSError, subprocess.CalledProcessError):
        return "unknown commit"
    return f"{head} with changes" if changes else head


def peak_megabytes() -> float:
    """Return the largest resident memory of this process so far, in 10^6 bytes.

    Linux's own figure for the program that is running now: `getrusage` also counts the process that started it.
    """
    status = Path("/proc/self/status")
    if status.is_file() and (match := re.search(r"VmHWM:\s*(\d+) kB", status.read_text(encoding="utf-8"))):
        return int(match[1]) * 1024e-6
    unit = 1 if platform.system() == "Darwin" else 1024
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * unit * 1e-6
