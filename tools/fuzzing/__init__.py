# SPDX-License-Identifier: Apache-2.0
"""Random input for what livecl takes from outside: pictures, SVGs, options, drawings, whole runs."""
