# SPDX-License-Identifier: Apache-2.0
"""Structure of flat pictures: which shapes there are, who lies in front, and what they are as wholes."""

from livecl.layering.structure.placing import place_structure, structured

__all__ = ["place_structure", "structured"]
