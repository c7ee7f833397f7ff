# SPDX-License-Identifier: Apache-2.0
"""Strokes: find centre lines of ink on paper, convert thin layers to strokes, and simplify strokes."""
