# SPDX-License-Identifier: Apache-2.0
"""Outlines of regions: traced, continued behind occluders, completed to whole shapes, and priced."""
