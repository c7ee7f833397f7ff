// SPDX-License-Identifier: Apache-2.0
// Joint launches of independent stages: for few paths, launching kernels and waking threads takes longer than the work. Only
// for drawings that fit into one band. All sources are one program: each stage's inline function is in its own file.
#include "common.h"

// Lines for coverage and lines for distances, as in flatten_forward. Work-item: one segment, for one of the two.
__kernel void flatten_both(__global const real *params, __global const Tables *coverage_tables,
                           __global real4 *coverage_lines, __global const Tables *distance_tables,
                           __global real4 *distance_lines)
{
    int id = get_global_id(0), num_segments = coverage_tables->num_segments;
    if (id < num_segments)
        flatten_segment(id, params, distance_tables, distance_lines);
    else if (id < 2 * num_segments)
        flatten_segment(id - num_segments, params, coverage_tables, coverage_lines);
}

// distance_forward and coverage_forward. Work-item: one span, of one of the two.
__kernel void span_both(Grid grid, real tau, __global const Tables *distance_tables,
                        __global const real4 *distance_lines, __global realv *distances,
                        __global const Tables *coverage_tables, __global const real4 *coverage_lines,
                        __global realv *cells)
{
    int id = get_global_id(0), num_distance_spans = distance_tables->num_spans;
    if (id < num_distance_spans)
        measure_span(id, grid, tau, distance_tables, distance_lines, distances);
    else if (id < num_distance_spans + coverage_tables->num_spans)
        cover_span(id - num_distance_spans, grid, coverage_tables, coverage_lines, cells);
}
