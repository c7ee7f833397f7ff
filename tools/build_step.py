# SPDX-License-Identifier: Apache-2.0
"""The build steps of `setup.cfg`: setuptools' own, in a folder of their own that is deleted after them.

Setuptools builds in ``build/`` of the checkout, copies into it and never removes from it: a wheel built twice would
still ship kernels and modules deleted in between, and every checkout that is installed from would keep the folder.
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
