# SPDX-License-Identifier: Apache-2.0
"""Parts of `tools/evaluate.py`: methods, runs, measures, tables, plots and contact sheets."""
