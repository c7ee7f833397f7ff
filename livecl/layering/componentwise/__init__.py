# SPDX-License-Identifier: Apache-2.0
"""Component-wise path initialization: the paper's placement, and outlines fitted to regions at any depth."""
