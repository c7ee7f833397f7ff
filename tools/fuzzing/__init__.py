# SPDX-License-Identifier: Apache-2.0
"""Random input for livecl: pictures, SVGs, options, drawings, whole runs."""
