# SPDX-License-Identifier: Apache-2.0
"""Fills of layers: gradients fitted to pixels, their stops, overlaid fills, and the choice of fill during training."""
