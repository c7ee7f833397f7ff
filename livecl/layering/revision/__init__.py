# SPDX-License-Identifier: Apache-2.0
"""Revision of placed layers: merging with a neighbour, pruning, trimming to the page."""
