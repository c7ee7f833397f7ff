# SPDX-License-Identifier: Apache-2.0
"""The build steps of `setup.cfg`: setuptools' own, in a temporary folder.

Setuptools builds in ``build/`` of the checkout and never removes files from it: a wheel built twice would still ship
kernels and modules deleted in between, and installing from a checkout would leave the folder.
"""

import atexit
import shutil
import tempfile

from setuptools.command.build import build


class TemporaryBuild(build):
    """Build in a temporary folder, unless the caller names one."""

    def finalize_options(self) -> None:
        """Choose the folder."""
        if self.build_base == "build":
            self.build_base = tempfile.mkdtemp(prefix="livecl-build-")
            atexit.register(shutil.rmtree, self.build_base, ignore_errors=True)
        super().finalize_options()
