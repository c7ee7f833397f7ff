# SPDX-License-Identifier: Apache-2.0
"""Revision of layers that are placed: merged with a neighbour, pruned, trimmed to the page."""
