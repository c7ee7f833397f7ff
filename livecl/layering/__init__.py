# SPDX-License-Identifier: Apache-2.0
"""Layering: place, complete, merge and prune the layers of a drawing."""
