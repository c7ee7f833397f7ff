// SPDX-License-Identifier: Apache-2.0
// Reduce: add the partial sums of the tiles in a fixed order, so that the same input gives the same bytes for any number of
// threads.
#include "common.h"
#include "composite.h"

// Work-item: one layer; one more for the sums over each drawing's canvas.
//
// tables, cells, d_tiles  in       result  out: loss, d_background, d_colors
__kernel void reduce_tiles(Grid grid, __global const Tables *tables, __global realv *cells, __global real4 *d_tiles,
                           __global real *result)
{
    int layer = get_global_id(0), drawing = layer - tables->num_layers;
    if (drawing >= grid_drawings(grid)) return;
    TileSums sums = tile_sums_of(grid, tables, d_tiles);
    __global real4 *out = drawing >= 0 ? result_drawings(tables, result) + drawing : result_colors(result) + layer;
    real4 sum = grid.first_strip > 0 ? *out : (real4)0;
    if (drawing >= 0) {
        int first = max(grid.first_strip, drawing * grid.period) - grid.first_strip;
        int end = min(grid.last_strip, (drawing + 1) * grid.period) - grid.first_strip;
        for (int i = first * grid.num_tiles; i < end * grid.num_tiles; i++) sum += sums.d_canvas[i];
        *out = sum;
        return;
    }
    __global const int *tile_state = cells_of(tables, cells).tile_state;
    int2 strips = layer_strips(tables, layer);
    int last = min(grid.last_strip, strips_last(strips));
    for (int strip = max(grid.first_strip, strips_first(strips)); strip < last; strip++) {
        int4 span = layer_span(tables, strips, strip);
        for (int tile = span_first(span); tile < span_last(span); tile++) {
            int index = span_tile(span, tile);
            if (tile_state[index] != 0) sum += sums.d_colors[index];
        }
    }
    *out = sum;
}

// Work-item: one layer.
//
// params, tables, cells, d_tiles  in       result  out: sums of d_fills, of layers with a gradient
__kernel void reduce_fills(Grid grid, __global const real *params, __global const Tables *tables, __global realv *cells,
                           __global real4 *d_tiles, __global real *result)
{
#if FILLS
    int layer = get_global_id(0), num_reals = record_reals(params);
    if (layer >= tables->num_layers) return;
    __global real *sum = result_fills(grid, tables, result) + layer * num_reals;
    if (grid.first_strip == 0)
        for (int i = 0; i < num_reals; i++) sum[i] = 0;
    if (!is_gradient(params, layer)) return;
    __global const int *tile_state = cells_of(tables, cells).tile_state;
    __global const real *d_fills = tile_sums_of(grid, tables, d_tiles).d_fills;
    int last_real = D_GEOMETRY + D_STOP * (int)layer_fill(params, layer)[2];
    int2 strips = layer_strips(tables, layer);
    int last = min(grid.last_strip, strips_last(strips));
    for (int strip = max(grid.first_strip, strips_first(strips)); strip < last; strip++) {
        int4 span = layer_span(tables, strips, strip);
        for (int tile = span_first(span); tile < span_last(span); tile++) {
            int index = span_tile(span, tile);
            if (tile_state[index] == 0) continue;
            for (int i = 0; i < last_real; i++) sum[i] += d_fills[index * num_reals + i];
        }
    }
#endif
}
