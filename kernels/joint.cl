// SPDX-License-Identifier: Apache-2.0
// Stages that do not wait for each other, in one launch: for few paths, launches and the waking of threads take longer than
// the work. For drawings that need only one band. The sources make one program: what a stage does for one work-item is the
// inline function of its own file.
#include "common.h"

// Lines for coverage and lines for distances, as in flatten_forward. Work-item: one segment, for one of the two.
//
// params, next_segments  in, as there        coverage_x, distance_x  the line_offsets, lines, segment_bounds of each
__kernel void flatten_both(int num_segments, int num_layers, __global const real *params,
                           __global const int *next_segments, __global const int *coverage_line_offsets,
                           __global real4 *coverage_lines, __global real4 *coverage_segment_bounds,
                           __global const int *distance_line_offsets, __global real4 *distance_lines,
                           __global real4 *distance_segment_bounds)
{
    int id = get_global_id(0);
    if (id < num_segments)
        flatten_segment(id, num_layers, params, next_segments, distance_line_offsets, distance_lines,
                        distance_segment_bounds);
    else if (id < 2 * num_segments)
        flatten_segment(id - num_segments, num_layers, params, next_segments, coverage_line_offsets, coverage_lines,
                        coverage_segment_bounds);
}

// distance_forward and coverage_forward. Work-item: one span, of one of the two.
//
// num_distance_spans, num_coverage_spans  in        the others as in the two kernels
__kernel void span_both(int num_distance_spans, int num_coverage_spans, int width, int height, int num_columns, real tau,
                        __global const int *layer_segments, __global const int4 *distance_spans,
                        __global const int *distance_line_offsets, __global const real4 *distance_segment_bounds,
                        __global const real4 *distance_lines, __global int *near, __global realv *closeness,
                        __global real *span_sums, __global const int4 *coverage_spans,
                        __global const int *coverage_line_offsets, __global const real4 *coverage_segment_bounds,
                        __global const real4 *coverage_lines, __global int *tile_state, __global realv *area,
                        __global realv *d_coverage)
{
    int id = get_global_id(0);
    if (id < num_distance_spans)
        measure_span(id, width, height, tau, distance_spans, layer_segments, distance_line_offsets,
                     distance_segment_bounds, distance_lines, near, closeness, span_sums);
    else if (id < num_distance_spans + num_coverage_spans)
        cover_span(id - num_distance_spans, num_columns, coverage_spans, layer_segments, coverage_line_offsets,
                   coverage_segment_bounds, coverage_lines, tile_state, area, d_coverage);
}
