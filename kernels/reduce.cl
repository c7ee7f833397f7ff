// SPDX-License-Identifier: Apache-2.0
// Reduce: the partial sums of the tiles, added in a fixed order, so that the same input gives the same bytes whatever the
// number of threads.
#include "common.h"
#include "composite.h"

// Work-item: one layer; one more for the sums over the whole canvas.
//
// layer_strips, layer_spans, spans  in: where tiles are       tile_state  (num_tiles,)  in: 0 where the layer is not
// d_colors  (num_tiles,)  in         d_tiles  (strips of the band * num_tiles, 4)  in
// result  see common.h  out: loss, d_background, d_colors
__kernel void reduce_tiles(int4 band, int num_layers, int num_tiles, __global const int4 *spans,
                           __global const int2 *layer_strips, __global const int *layer_spans,
                           __global const int *tile_state, __global const real4 *d_colors, __global const real4 *d_tiles,
                           __global real4 *result)
{
    int layer = get_global_id(0);
    if (layer > num_layers) return;
    int slot = layer == num_layers ? 0 : 1 + layer;
    real4 sum = band.z > 0 ? result[slot] : (real4)0;
    if (layer == num_layers) {
        for (int i = 0; i < (band.w - band.z) * num_tiles; i++) sum += d_tiles[i];
        result[slot] = sum;
        return;
    }
    int2 strips = layer_strips[layer];
    int last = min(band.w, strips_last(strips));
    for (int strip = max(band.z, strips_first(strips)); strip < last; strip++) {
        int4 span = spans[layer_spans[strips.x + strip]];
        for (int tile = span_first(span); tile < span_last(span); tile++) {
            int index = span_tile(span, tile);
            if (tile_state[index] != 0) sum += d_colors[index];
        }
    }
    result[slot] = sum;
}

// Work-item: one layer.
//
// params, layer_strips, layer_spans, spans, tile_state  in       d_fills  (num_tiles, reals of a record)  in
// fill_sums  (N, reals of a record)  out: the records' sums, of layers with a gradient
__kernel void reduce_fills(int4 band, int num_layers, __global const real *params, __global const int4 *spans,
                           __global const int2 *layer_strips, __global const int *layer_spans,
                           __global const int *tile_state, __global const real *d_fills, __global real *fill_sums)
{
#if FILLS
    int layer = get_global_id(0), num_reals = record_reals(params);
    if (layer >= num_layers) return;
    __global real *sum = fill_sums + layer * num_reals;
    if (band.z == 0)
        for (int i = 0; i < num_reals; i++) sum[i] = 0;
    if (!is_gradient(params, layer)) return;
    int last_real = D_GEOMETRY + D_STOP * (int)layer_fill(params, layer)[2];
    int2 strips = layer_strips[layer];
    int last = min(band.w, strips_last(strips));
    for (int strip = max(band.z, strips_first(strips)); strip < last; strip++) {
        int4 span = spans[layer_spans[strips.x + strip]];
        for (int tile = span_first(span); tile < span_last(span); tile++) {
            int index = span_tile(span, tile);
            if (tile_state[index] == 0) continue;
            for (int i = 0; i < last_real; i++) sum[i] += d_fills[index * num_reals + i];
        }
    }
#endif
}
