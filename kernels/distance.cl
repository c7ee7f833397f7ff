// SPDX-License-Identifier: Apache-2.0
// Distance weight, eq. (1) of the paper: d' = ReLU(tau - d) / sum of ReLU(tau - d), d being the unsigned distance from pixel
// centre to a layer's flattened outline. It is a constant of the loss and has no backward.
//
// `closeness` is ReLU(tau - d), px. Only tiles within tau of the outline are stored; spans are those of the layers' boxes
// grown by tau.
#include "common.h"
#include "distance.h"

// A line, as distances are measured to it: the middle, the direction (of length 1), half the length.
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
// spans  (num_spans,)  in      layer_segments, line_offsets, segment_bounds, lines  in, as in coverage.cl
// near  (num_tiles,)  out: 1 where closeness is stored      closeness  (num_tiles, TILE)  out, px, 0 beyond the canvas
// span_sums  (num_spans,)  out, px
inline void measure_span(int id, int width, int height, real tau, __global const int4 *spans,
                         __global const int *layer_segments, __global const int *line_offsets,
                         __global const real4 *segment_bounds, __global const real4 *lines, __global int *near,
                         __global realv *closeness, __global real *span_sums)
{
    int4 span = spans[id];
    int layer = span_layer(span);
    real top = span_strip(span) * LANES, low = top + (real)0.5 - tau, high = top + LANES - (real)0.5 + tau;
    realv y = top + (real)0.5 + lane_rows();
    real2 half_tile = (real2)(TILE - 1, LANES - 1) / 2;
    real reach = tau + length(half_tile), reach_squared = reach * reach;
    for (int tile = span_first(span); tile < span_last(span); tile++) near[span_tile(span, tile)] = 0;

    for (int segment = layer_segments[layer]; segment < layer_segments[layer + 1]; segment++) {
        if (segment_bounds[segment].w < low || segment_bounds[segment].y > high) continue;
        for (int k = line_offsets[segment]; k < line_offsets[segment + 1]; k++) {
            real4 line = lines[k];
            if ((line.y < low && line.w < low) || (line.y > high && line.w > high)) continue;
            Rod rod = rod_of(line);
            real y_center = top + (real)LANES / 2 - rod.middle.y;
            realv u_rows = (y - rod.middle.y) * rod.along.y, v_rows = (y - rod.middle.y) * rod.along.x;
            real left = LESSER(line.x, line.z) - tau, right = GREATER(line.x, line.z) + tau;
            left = GREATER(left, (real)0), right = LESSER(right, (real)width);
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

    realv sum = 0, inside = select((realv)0, (realv)1, y < (realv)height);
    for (int tile = span_first(span); tile < span_last(span); tile++) {
        int index = span_tile(span, tile);
        if (!near[index]) continue;
        for (int i = 0; i < TILE; i++) {
            realv value = tile * TILE + i < width ? inside * (tau - sqrt(closeness[index * TILE + i])) : (realv)0;
            closeness[index * TILE + i] = value;
            sum += value;
        }
    }
    span_sums[id] = sum_lanes(sum);
}

__kernel void distance_forward(int4 band, int width, int height, real tau, __global const int4 *spans,
                               __global const int *layer_segments, __global const int *line_offsets,
                               __global const real4 *segment_bounds, __global const real4 *lines, __global int *near,
                               __global realv *closeness, __global real *span_sums)
{
    int id = band.x + get_global_id(0);
    if (id >= band.y) return;
    measure_span(id, width, height, tau, spans, layer_segments, line_offsets, segment_bounds, lines, near, closeness,
                 span_sums);
}

// The factor of each layer's closeness in the mean of eq. (1): 1 / (n sum), n being the number of layers whose outline is
// within tau of some pixel; 0 for the others. Work-item: one, alone.
//
// layer_strips, layer_spans  in: the layers' spans      span_sums  (num_spans,)  in, px      factors  (N,)  out, 1/px
__kernel void distance_normalize(int num_layers, __global const int2 *layer_strips, __global const int *layer_spans,
                                 __global const real *span_sums, __global real *factors)
{
    if (get_global_id(0) > 0) return;
    int count = 0;
    for (int layer = 0; layer < num_layers; layer++) {
        int2 strips = layer_strips[layer];
        real sum = 0;
        for (int strip = strips_first(strips); strip < strips_last(strips); strip++)
            sum += span_sums[layer_spans[strips.x + strip]];
        factors[layer] = sum > 0 ? 1 / sum : (real)0;
        count += sum > 0;
    }
    for (int layer = 0; layer < num_layers; layer++) factors[layer] /= max(count, 1);
}

// Mean over layers of d', or, for `released` (the authors' program), the largest closeness among the layers from
// first_layer on. Work-item: one tile.
//
// spans, strip_offsets, near, closeness, factors  in      weight  (plane)  out
__kernel void distance_weight(int4 band, int num_tiles, int first_layer, int released, __global const int4 *spans,
                              __global const int *strip_offsets, __global const int *near,
                              __global const realv *closeness, __global const real *factors, __global realv *weight)
{
    int id = get_global_id(0), tile = id % num_tiles, strip = band.z + id / num_tiles;
    if (strip >= band.w) return;
    realv sum[TILE];
    for (int i = 0; i < TILE; i++) sum[i] = 0;
    for (int k = strip_offsets[strip]; k < strip_offsets[strip + 1]; k++) {
        int index = near_tile(spans[k], near, tile);
        if (index < 0 || span_layer(spans[k]) < first_layer) continue;
        if (released)
            for (int i = 0; i < TILE; i++) sum[i] = GREATER(sum[i], closeness[index * TILE + i]);
        else
            add_weight(factors[span_layer(spans[k])], closeness + index * TILE, sum);
    }
    for (int i = 0; i < TILE; i++) weight[(strip * num_tiles + tile) * TILE + i] = sum[i];
}
