# SPDX-License-Identifier: Apache-2.0
"""Parts of tools/check_gradients.py: random drawings, and comparisons of their gradients."""
