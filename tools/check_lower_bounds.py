#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Run the tests with the oldest versions that setup.cfg allows, in a separate virtual environment.

Each core dependency is at its lower bound; packages needed by the tests only are chosen by pip. Use the oldest
supported Python: `python3.10 tools/check_lower_bounds.py`. Other arguments are passed to pytest.
"""

from __future__ import annotations

import argparse
import configparser
import os
import re
import subprocess
import sys
import tempfile
import venv
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
#: Name, extras (dropped) and lower bound of a requirement; what follows is an upper bound or a marker.
REQUIREMENT = re.compile(r"^\s*(?P<name>[\w.-]+)\s*(?:\[[^\]]*\])?\s*>=\s*(?P<version>[\w.]+)(?P<rest>.*)$")


def core_requirements(setup_cfg: Path = ROOT / "setup.cfg") -> list[str]:
    """Return the lines of `install_requires`."""
    parser = configparser.ConfigParser()
    parser.read(setup_cfg, encoding="utf-8")
    return [line for line in parser["options"]["install_requires"].splitlines() if line.strip()]


def lower_bounds(requirements: list[str]) -> list[str]:
    """Return a constraint `name==version` for each requirement, with its marker.

    Raises
    ------
    ValueError
        If one has no lower bound.
    """
    constraints = []
    for requirement in requirements:
        match = REQUIREMENT.match(requirement)
        if match is None:
            raise ValueError(f"setup.cfg: {requirement!r} has no lower bound, wanted name >=version")
        _, semicolon, marker = match["rest"].partition(";")
        constraints.append(f"{match['name']}=={match['version']}{semicolon}{marker}")
    return constraints


def main() -> int:
    """Make the environment and run the tests; return pytest's exit code."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--keep", type=Path, metavar="DIR", help="make the environment there, and leave it")
    arguments, pytest_arguments = parser.parse_known_args()
    constraints = lower_bounds(core_requirements())
    print(f"Python {sys.version.split()[0]}, with {', '.join(line.split(';')[0] for line in constraints)}", flush=True)
    with tempfile.TemporaryDirectory() as folder:
        environment = arguments.keep or Path(folder) / "venv"
        venv.create(environment, with_pip=True, clear=True)
        python = str(environment / "bin" / "python")
        bounds = Path(folder) / "constraints.txt"
        bounds.write_text("\n".join(constraints) + "\n", encoding="utf-8")
        install = [python, "-m", "pip", "install", "-c", str(bounds), "-e", f"{ROOT}[test]"]
        subprocess.run(install, check=True)
        wanted = pytest_arguments or ["-m", "not slow and not full"]
        # A separate cache, without kernels built by another version of the runtime.
        cache = {**os.environ, "XDG_CACHE_HOME": str(Path(folder) / "cache")}
        return subprocess.run([python, "-m", "pytest", "-q", *wanted], cwd=ROOT, env=cache, check=False).returncode


if __name__ == "__main__":
    sys.exit(main())
