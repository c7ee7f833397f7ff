# SPDX-License-Identifier: Apache-2.0
"""The figures of docs/, made by tools/make_figures.py."""
