# SPDX-License-Identifier: Apache-2.0
"""Fills of layers: gradients fitted to pixels, their stops, fills over each other, the choice while training."""
