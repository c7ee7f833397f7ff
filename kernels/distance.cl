// SPDX-License-Identifier: Apache-2.0
// Distance weight, eq. (1) of the paper: d' = ReLU(tau - d) / sum of ReLU(tau - d), with d the unsigned distance from a
// pixel centre to a layer's flattened outline. It is a constant in the loss and has no backward.
//
// `closeness` is ReLU(tau - d), px. Only tiles within tau of the outline are stored; spans are those of the layers' boxes
// grown by tau.
#include "common.h"
#include "distance.h"

// A line as middle, unit direction and half length, for measuring distances.
typedef struct {
    real2 middle, along;
    real half_length;
} Rod;

inline Rod rod_of(real4 line)
{
    real2 d = line.zw - line.xy;
    real size = sqrt(d.x * d.x + d.y * d.y);
    Rod rod = {(line.xy + line.zw) / 2, size > 0 ? d / size : (real2)(1, 0), size / 2};
    return rod;
}

// Squared distance to a point that lies u along the line and v across it, seen from the middle:
//     d^2 = v^2 + max(|u| - half_length, 0)^2
#define DEFINE_DISTANCE_SQUARED(name, type)                    \
    inline type name(Rod rod, type u, type v)                  \
    {                                                          \
        type beyond = MAGNITUDE(u) - rod.half_length;          \
        beyond = GREATER(beyond, (type)0);                     \
        return v * v + beyond * beyond;                        \
    }
DEFINE_DISTANCE_SQUARED(distance_squared, real)
DEFINE_DISTANCE_SQUARED(distances_squared, realv)

// Work-item: one span.
//
// tables, lines  in      distances  out: closeness, near, span_sums
inline void measure_span(int id, Grid grid, real tau, __global const Tables *tables, __global const real4 *lines,
                         __global realv *distances)
{
    Outlines outlines = outlines_of(tables, lines);
    __global realv *closeness = distances_of(tables, distances).closeness;
    __global int *near = distances_of(tables, distances).near;
    int4 span = spans_of(tables)[id];
    int layer = span_layer(span);
    real top = span_strip(span) * LANES, low = top + (real)0.5 - tau, high = top + LANES - (real)0.5 + tau;
    realv y = top + (real)0.5 + lane_rows();
    real2 half_tile = (real2)(TILE - 1, LANES - 1) / 2;
    real reach = tau + length(half_tile), reach_squared = reach * reach;
    for (int tile = span_first(span); tile < span_last(span); tile++) near[span_tile(span, tile)] = 0;

    for (int segment = outlines.layer_segments[layer]; segment < outlines.layer_segments[layer + 1]; segment++) {
        if (outlines.bounds[segment].w < low || outlines.bounds[segment].y > high) continue;
        for (int k = outlines.line_offsets[segment]; k < outlines.line_offsets[segment + 1]; k++) {
            real4 line = outlines.lines[k];
            if ((line.y < low && line.w < low) || (line.y > high && line.w > high)) continue;
            Rod rod = rod_of(line);
            real y_center = top + (real)LANES / 2 - rod.middle.y;
            realv u_rows = (y - rod.middle.y) * rod.along.y, v_rows = (y - rod.middle.y) * rod.along.x;
            real left = LESSER(line.x, line.z) - tau, right = GREATER(line.x, line.z) + tau;
            left = GREATER(left, (real)0), right = LESSER(right, (real)grid.width);
            int last = min((int)(right / TILE) + 1, span_last(span));
            for (int tile = max((int)(left / TILE), span_first(span)); tile < last; tile++) {
                real x = tile * TILE + (real)TILE / 2 - rod.middle.x;
                real u_center = x * rod.along.x + y_center * rod.along.y;
                real v_center = x * rod.along.y - y_center * rod.along.x;
                if (distance_squared(rod, u_center, v_center) > reach_squared) continue;
                int index = span_tile(span, tile);
                __global realv *squared = closeness + index * TILE;
                if (!near[index]) {
                    near[index] = 1;
                    for (int i = 0; i < TILE; i++) squared[i] = tau * tau;
                }
                x -= (real)(TILE - 1) / 2;  // first column
                realv u_first = x * rod.along.x + u_rows, v_first = x * rod.along.y - v_rows;
#pragma unroll
                for (int i = 0; i < TILE; i++) {
                    realv found = distances_squared(rod, u_first + i * rod.along.x, v_first + i * rod.along.y);
                    realv before = squared[i];
                    squared[i] = LESSER(found, before);
                }
            }
        }
    }

    realv sum = 0, inside = select((realv)0, (realv)1, y < (realv)grid.height);
    for (int tile = span_first(span); tile < span_last(span); tile++) {
        int index = span_tile(span, tile);
        if (!near[index]) continue;
        for (int i = 0; i < TILE; i++) {
            realv value = tile * TILE + i < grid.width ? inside * (tau - sqrt(closeness[index * TILE + i])) : (realv)0;
            closeness[index * TILE + i] = value;
            sum += value;
        }
    }
    distances_of(tables, distances).span_sums[id] = sum_lanes(sum);
}

__kernel void distance_forward(Grid grid, real tau, __global const Tables *tables, __global const real4 *lines,
                               __global realv *distances)
{
    int id = grid.first_span + get_global_id(0);
    if (id < grid.last_span) measure_span(id, grid, tau, tables, lines, distances);
}

// The factor of each layer's closeness in `factor_scale` times the mean of eq. (1): factor_scale / (n sum), with n the
// number of layers whose outline is within tau of some pixel; 0 for the others. A single work-item.
//
// tables  in      distances  in: span_sums; out: factors
__kernel void distance_normalize(real factor_scale, __global const Tables *tables, __global realv *distances)
{
    if (get_global_id(0) > 0) return;
    Distances at = distances_of(tables, distances);
    int count = 0;
    for (int layer = 0; layer < tables->num_layers; layer++) {
        int2 strips = layer_strips(tables, layer);
        __global const int *spans = table_at(tables, tables->layer_spans) + strips.x;
        real sum = 0;
        for (int strip = strips_first(strips); strip < strips_last(strips); strip++) sum += at.span_sums[spans[strip]];
        at.factors[layer] = sum > 0 ? 1 / sum : (real)0;
        count += sum > 0;
    }
    for (int layer = 0; layer < tables->num_layers; layer++) {
        real factor = at.factors[layer] / max(count, 1);
        at.factors[layer] = factor_scale * factor;
    }
}

// Mean over layers of d', or, if `released` (the authors' program), the largest closeness of the layers from first_layer
// on. Work-item: one tile.
//
// tables, distances  in      weight  (plane)  out
__kernel void distance_weight(Grid grid, int first_layer, int released, __global const Tables *tables,
                              __global realv *distances, __global realv *weight)
{
    int strip, tile;
    if (!grid_tile(grid, get_global_id(0), &strip, &tile)) return;
    Distances at = distances_of(tables, distances);
    __global const int4 *spans = spans_of(tables);
    __global const int *strip_spans = table_at(tables, tables->strip_offsets) + strip;
    realv sum[TILE];
    for (int i = 0; i < TILE; i++) sum[i] = 0;
    for (int k = strip_spans[0]; k < strip_spans[1]; k++) {
        int index = near_tile(spans[k], at.near, tile);
        if (index < 0 || span_layer(spans[k]) < first_layer) continue;
        if (released)
            for (int i = 0; i < TILE; i++) sum[i] = GREATER(sum[i], at.closeness[index * TILE + i]);
        else
            add_weight(at.factors[span_layer(spans[k])], at.closeness + index * TILE, sum);
    }
    for (int i = 0; i < TILE; i++) weight[(strip * grid.num_tiles + tile) * TILE + i] = sum[i];
}
