# SPDX-License-Identifier: Apache-2.0
"""Float64 NumPy twins of the kernels, written for belief and not for speed.

Each file is named for its stage and takes the same road to the result by other means: coverage clips every line
against every pixel where the kernel walks cells, weights come from de Casteljau's scheme where the kernel has
Bernstein polynomials, and so on. :mod:`reference.differences` and :mod:`reference.rounding` hold what the comparisons
need: numerical derivatives, and how far single precision may lie from double.
"""
