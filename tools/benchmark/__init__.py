# SPDX-License-Identifier: Apache-2.0
"""Parts of ``tools/bench.py``; docs/performance.md has the method."""
