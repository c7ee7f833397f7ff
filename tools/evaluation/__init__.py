# SPDX-License-Identifier: Apache-2.0
"""What `tools/evaluate.py` is made of: methods, runs, measures, tables, plots and contact sheets."""
