// SPDX-License-Identifier: Apache-2.0
// Distance weight, eq. (1) of the paper: d' = ReLU(tau - d) / sum of ReLU(tau - d), d being the unsigned distance from pixel
// centre to a layer's flattened outline. It is a constant of the loss and has no backward.
//
// `closeness` is ReLU(tau - d), px. Only tiles within tau of the outline are stored; spans are those of the layers' boxes
// grown by tau.
#include "common.h"

// Squared distances from the pixel centres of one column to a line, px^2.
inline realv distance_squared(real4 line, real inverse_length_squared, real x, realv y)
{
    real2 d = line.zw - line.xy;
    realv px = (realv)(x - line.x), py = y - line.y;
    realv s = clamp((px * d.x + py * d.y) * inverse_length_squared, (realv)0, (realv)1);
    px -= s * d.x;
    py -= s * d.y;
    return px * px + py * py;
}

// Work-item: one span.
//
// spans  (num_spans,)  in      layer_segments, line_offsets, segment_bounds, lines  in, as in coverage.cl
// near  (num_tiles,)  out: 1 where closeness is stored      closeness  (num_tiles, TILE)  out, px, 0 beyond the canvas
// span_sums  (num_spans,)  out, px
__kernel void distance_forward(int4 band, int width, int height, real tau, __global const int4 *spans,
                               __global const int *layer_segments, __global const int *line_offsets,
                               __global const real4 *segment_bounds, __global const real4 *lines, __global int *near,
                               __global realv *closeness, __global real *span_sums)
{
    int id = band.x + get_global_id(0);
    if (id >= band.y) return;
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
            if (fmax(line.y, line.w) < low || fmin(line.y, line.w) > high) continue;
            real2 d = line.zw - line.xy;
            real inverse = 1 / fmax(dot(d, d), (real)1e-12);  // a line of length 0 is a point: s does not matter
            real left = clamp(fmin(line.x, line.z) - tau, (real)0, (real)width);
            real right = clamp(fmax(line.x, line.z) + tau, (real)0, (real)width);
            int last = min((int)(right / TILE) + 1, span_last(span));
            for (int tile = max((int)(left / TILE), span_first(span)); tile < last; tile++) {
                real2 offset = (real2)(tile * TILE, top) + (real2)(TILE, LANES) / 2 - line.xy;
                offset -= clamp(dot(offset, d) * inverse, (real)0, (real)1) * d;
                if (dot(offset, offset) > reach_squared) continue;
                int index = span_tile(span, tile);
                __global realv *squared = closeness + index * TILE;
                if (!near[index]) {
                    near[index] = 1;
                    for (int i = 0; i < TILE; i++) squared[i] = tau * tau;
                }
                for (int i = 0; i < TILE; i++)
                    squared[i] = fmin(squared[i], distance_squared(line, inverse, tile * TILE + i + (real)0.5, y));
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
        int4 span = spans[k];
        if (tile < span_first(span) || tile >= span_last(span) || span_layer(span) < first_layer) continue;
        int index = span_tile(span, tile);
        if (!near[index]) continue;
        real factor = factors[span_layer(span)];
        for (int i = 0; i < TILE; i++) {
            realv value = closeness[index * TILE + i];
            sum[i] = released ? fmax(sum[i], value) : sum[i] + factor * value;
        }
    }
    for (int i = 0; i < TILE; i++) weight[(strip * num_tiles + tile) * TILE + i] = sum[i];
}
