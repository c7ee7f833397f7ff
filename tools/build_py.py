# SPDX-License-Identifier: Apache-2.0
"""The build step of `setup.cfg`: setuptools' own, on an empty folder.

Setuptools copies into ``build/lib`` and never removes from it, so that a wheel built twice would still ship kernels and
modules deleted in between.
"""

import shutil
from pathlib import Path

from setuptools.command.build_py import build_py


class FreshBuildPy(build_py):
    """Copy packages and kernels into a folder that holds nothing else of this package."""

    def run(self) -> None:
        """Empty the package's build folder, then build."""
        if not self.editable_mode:
            shutil.rmtree(Path(self.build_lib) / "livecl", ignore_errors=True)
        super().run()
