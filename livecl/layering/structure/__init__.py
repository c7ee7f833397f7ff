# SPDX-License-Identifier: Apache-2.0
"""Structure of pictures of flat or shaded regions: which shapes there are, their depth, and their whole outlines."""

from livecl.layering.structure.placing import place_structure, structure_kind

__all__ = ["place_structure", "structure_kind"]
