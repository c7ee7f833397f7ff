# SPDX-License-Identifier: Apache-2.0
"""Segmentation of flat or smoothly shaded pictures, resolving anti-aliased borders and noise."""
