# SPDX-License-Identifier: Apache-2.0
"""Curves and closed outlines in NumPy; nothing here knows a drawing."""
