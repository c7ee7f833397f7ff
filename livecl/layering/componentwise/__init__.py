# SPDX-License-Identifier: Apache-2.0
"""Component-wise path initialization: the paper's, and regions with outlines fitted to them, tried at any depth."""
