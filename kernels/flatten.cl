// SPDX-License-Identifier: Apache-2.0
// Flatten: cubic segments -> lines at fixed t. Work-item: one segment.
#include "common.h"

// Vertex k of a segment of n pieces lies at t = k / n on
//     P(t) = A + t (3 (B - A) + t (3 (C - 2 B + A) + t (D - A + 3 (B - C)))).
// In this form with differences, a segment whose control points share an x (or y) keeps it exactly: edges on pixel borders
// stay there. The last vertex is D itself, so that neighbouring segments meet.
//
// params, tables  in       lines  out
inline void flatten_segment(int segment, __global const real *params, __global const Tables *tables,
                            __global real4 *lines)
{
    __global const int *line_offsets = table_at(tables, tables->line_offsets);
    int num_layers = tables->num_layers, next = table_at(tables, tables->next_segments)[segment];
    __global const real *p = params_points(params, num_layers, segment), *q = params_points(params, num_layers, next);
    real2 a = (real2)(p[0], p[1]), b = (real2)(p[2], p[3]), c = (real2)(p[4], p[5]), d = (real2)(q[0], q[1]);
    real2 k1 = (real)3 * (b - a), k2 = (real)3 * ((c - b) - (b - a)), k3 = (d - a) + (real)3 * (b - c);
    int begin = line_offsets[segment], pieces = line_offsets[segment + 1] - begin;
    __global real4 *pieces_out = lines_of(tables, lines) + begin;
    real2 low = LESSER(a, d), high = GREATER(a, d), previous = a;
    for (int k = 1; k <= pieces; k++) {
        real t = (real)k / (real)pieces;
        real2 vertex = k == pieces ? d : a + t * (k1 + t * (k2 + t * k3));
        low = LESSER(low, vertex);
        high = GREATER(high, vertex);
        pieces_out[k - 1] = (real4)(previous, vertex);
        previous = vertex;
    }
    lines[segment] = (real4)(low, high);
}

__kernel void flatten_forward(__global const real *params, __global const Tables *tables, __global real4 *lines)
{
    int segment = get_global_id(0);
    if (segment < tables->num_segments) flatten_segment(segment, params, tables, lines);  // global size is padded
}

// Backward.  P(t) = b0(t) A + b1(t) B + b2(t) C + b3(t) D with the Bernstein weights b, so with d_v_k = dL/d(vertex k),
//     d_A = sum_k b0(t_k) d_v_k   ...   d_D = sum_k b3(t_k) d_v_k.
// The vertex between two lines gets a share from each: line k gives its start at t_k and its end at t_{k+1}.
//
// tables  in       d_lines  (num_lines,)  in, loss per px of (x0, y0, x1, y1)
// result  out: d_cubics, loss per px of A, B, C, D
__kernel void flatten_backward(__global const Tables *tables, __global const real4 *d_lines, __global real *result)
{
    int segment = get_global_id(0);
    if (segment >= tables->num_segments) return;
    __global const int *line_offsets = table_at(tables, tables->line_offsets);
    int begin = line_offsets[segment], pieces = line_offsets[segment + 1] - begin;
    real2 d_a = 0, d_b = 0, d_c = 0, d_d = 0;
    for (int k = 0; k <= pieces; k++) {
        real2 d_vertex = 0;
        if (k < pieces) d_vertex += d_lines[begin + k].lo;
        if (k > 0) d_vertex += d_lines[begin + k - 1].hi;
        real t = (real)k / (real)pieces, u = (real)1 - t;
        d_a += u * u * u * d_vertex;
        d_b += 3 * t * u * u * d_vertex;
        d_c += 3 * t * t * u * d_vertex;
        d_d += t * t * t * d_vertex;
    }
    __global real *out = result_cubics(tables, result, segment);
    out[0] = d_a.x, out[1] = d_a.y, out[2] = d_b.x, out[3] = d_b.y;
    out[4] = d_c.x, out[5] = d_c.y, out[6] = d_d.x, out[7] = d_d.y;
}
