# SPDX-License-Identifier: Apache-2.0
"""The parts of tools/check_gradients.py: random drawings, and what their gradients are compared with."""
