# SPDX-License-Identifier: Apache-2.0
"""Segmentation of pictures of flat or smoothly shaded regions, with anti-aliased borders and noise resolved."""
