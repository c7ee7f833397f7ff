# SPDX-License-Identifier: Apache-2.0
"""``python -m livecl``: the command line."""

import sys

from livecl.cli.command import main

if __name__ == "__main__":
    sys.exit(main())
