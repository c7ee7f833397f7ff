# SPDX-License-Identifier: Apache-2.0
"""Geometry of curves and closed outlines in NumPy, independent of drawings."""
