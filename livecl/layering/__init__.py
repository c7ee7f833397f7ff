# SPDX-License-Identifier: Apache-2.0
"""Which layers there are: placement, amodal completion, merging, pruning."""
