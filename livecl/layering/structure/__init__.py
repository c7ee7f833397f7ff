# SPDX-License-Identifier: Apache-2.0
"""Structure of flat or shaded pictures: their shapes, depth order, and complete outlines."""

from livecl.layering.structure.placing import place_structure, structure_kind

__all__ = ["place_structure", "structure_kind"]
