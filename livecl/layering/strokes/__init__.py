# SPDX-License-Identifier: Apache-2.0
"""Strokes: centre lines of inks on paper, thin layers explained by a line and a width, and their revision."""
