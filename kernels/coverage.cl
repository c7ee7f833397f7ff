// SPDX-License-Identifier: Apache-2.0
// Coverage: exact share of each pixel's area inside a layer (anti-aliasing), and its gradient with respect to the outline.
//
// Let A(p) be the integral over pixel p of the layer's winding number. Each line from (x0, y0) to (x1, y1) adds to it, in
// the rows it passes, its height dy times the share of the pixel to the right of the line; pixels farther right get dy in
// full. So a line leaves dy (1 - u) in the pixels it crosses, u being the mean distance of its piece from the pixel's left
// border, and a running sum of dy along the row does the rest:
//
//     A(column) = sum_{j < column} height(j) + area(column),   height = sum of dy,   area = sum of dy (1 - u)
//     coverage  = min(|A|, 1)
//
// Exact for the nonzero rule where the winding numbers inside one pixel are all in {0, 1}, all in {0, -1}, all >= 1 or all
// <= -1; elsewhere (a self-crossing, a doubled outline) off by up to .25 (.5) in that pixel, and by up to twice that where
// windings of both signs meet in it.
//
// Only tiles that a line touches are stored by pixel (state EDGE); in any other tile A is the same whole number everywhere.
#include "common.h"
#include "walk.h"

typedef struct {
    int4 span;
    __global int *tile_state;
    __global realv *area, *height;
    int tile, index;  // the tile touched last, and its index, -1 outside the span
} Row;

// Make a tile an EDGE tile, clearing its sums the first time. Returns its index, -1 outside the span.
inline int touch(Row *row, int tile)
{
    if (tile == row->tile) return row->index;
    row->tile = tile;
    row->index = -1;
    if (tile < span_first(row->span) || tile >= span_last(row->span)) return -1;
    int index = row->index = span_tile(row->span, tile);
    if (row->tile_state[index] != EDGE) {
        row->tile_state[index] = EDGE;
        for (int i = 0; i < TILE; i++) row->area[index * TILE + i] = row->height[index * TILE + i] = 0;
    }
    return index;
}

// Touch the pixel's tile, and add to its sums.
inline void deposit(Row *row, int column, int lane, real dy, real share)
{
    if (column < 0) return;
    int index = touch(row, column / TILE);
    if (index < 0 || lane < 0 || lane >= LANES) return;
    int cell = (index * TILE + column % TILE) * LANES + lane;
    ((__global real *)row->area)[cell] += dy * share;
    ((__global real *)row->height)[cell] += dy;
}

// Deposit the part of a line left of the canvas: it counts in full in the first column.
inline void deposit_left(Row *row, real4 part, real top)
{
    for (int lane = 0; lane < LANES; lane++) {
        real low = top + lane, high = low + 1;
        real dy = BETWEEN(part.w, low, high) - BETWEEN(part.y, low, high);
        if (dy != 0) deposit(row, 0, lane, dy, 1);
    }
}

// Work-item: one span (a layer in a strip).
//
// tables, lines  in       cells  out: tile_state, area
inline void cover_span(int id, Grid grid, __global const Tables *tables, __global const real4 *lines,
                       __global realv *cells)
{
    Outlines outlines = outlines_of(tables, lines);
    Cells at = cells_of(tables, cells);
    __global int *tile_state = at.tile_state;
    __global realv *area = at.area, *height = at.scratch;
    int4 span = spans_of(tables)[id];
    Row row = {span, tile_state, area, height, -1, -1};
    int layer = span_layer(span), num_columns = grid_columns(grid);
    real top = grid_top(grid, span_strip(span)), bottom = top + LANES;
    for (int tile = span_first(span); tile < span_last(span); tile++) tile_state[span_tile(span, tile)] = 0;

    for (int segment = outlines.layer_segments[layer]; segment < outlines.layer_segments[layer + 1]; segment++) {
        if (outlines.bounds[segment].w < top || outlines.bounds[segment].y > bottom) continue;
        for (int k = outlines.line_offsets[segment]; k < outlines.line_offsets[segment + 1]; k++) {
            real4 line = outlines.lines[k], part = line;
            if (!clip_y(&part, top, bottom)) continue;
            if (part.x < 0 || part.z < 0) {
                real4 left = part;
                clip_x(&left, -INFINITY, 0);
                deposit_left(&row, left, top);
            }
            if (!clip_x(&part, 0, num_columns)) continue;
            Walk walk = walk_begin(part);
            while (walk_next(&walk)) {
                Piece piece = walk.piece;
                real u = (piece.x0 + piece.x1) / 2 - piece.column;
                deposit(&row, piece.column, piece.row - (int)top, piece.y1 - piece.y0, 1 - u);
                if (part.x == piece.column && part.z == piece.column) touch(&row, (piece.column + TILE - 1) / TILE - 1);
            }
        }
    }

    realv before = 0;  // sum of the heights left of the column
    for (int tile = span_first(span); tile < span_last(span); tile++) {
        int index = span_tile(span, tile);
        if (tile_state[index] != EDGE) {
            tile_state[index] = floor_of(sum_lanes(before) / LANES + (real)0.5);
            before = tile_state[index];
            continue;
        }
        for (int i = index * TILE; i < (index + 1) * TILE; i++) {
            realv a = before + area[i];
            before += height[i];
            area[i] = MAGNITUDE(a) < SNAP ? (realv)0 : a;  // rounding errors must not have a sign
        }
    }
}

__kernel void coverage_forward(Grid grid, __global const Tables *tables, __global const real4 *lines,
                               __global realv *cells)
{
    int id = grid.first_span + get_global_id(0);
    if (id < grid.last_span) cover_span(id, grid, tables, lines, cells);  // global size is padded
}

// The coverage of each single layer, min(|A|, 1), as a plane; 0 outside its spans. Work-item: one layer in one strip.
//
// tables  in       cells  in: tile_state, area, as left by coverage_forward
// planes  (N, num_strips, num_tiles * TILE)  out
__kernel void coverage_planes(Grid grid, __global const Tables *tables, __global realv *cells, __global realv *planes)
{
    int id = get_global_id(0), layer = id % tables->num_layers, strip = grid.first_strip + id / tables->num_layers;
    if (strip >= grid.last_strip) return;
    Cells at = cells_of(tables, cells);
    int2 strips = layer_strips(tables, layer);
    int4 span = 0;
    if (strip >= strips_first(strips) && strip < strips_last(strips)) span = layer_span(tables, strips, strip);
    __global realv *plane = planes + (layer * grid.num_strips + strip) * grid.num_tiles * TILE;
    for (int tile = 0; tile < grid.num_tiles; tile++) {
        int inside = tile >= span_first(span) && tile < span_last(span), index = inside ? span_tile(span, tile) : 0;
        for (int column = 0; column < TILE; column++) {
            realv share = 0;
            if (inside) {
                int whole = at.tile_state[index];
                realv a = at.area[index * TILE + column], size = MAGNITUDE(a);
                share = whole == EDGE ? LESSER(size, (realv)1) : (realv)(whole != 0);
            }
            plane[tile * TILE + column] = share;
        }
    }
}

// The cells of a layer in the strips of a band, looked up by pixel. Strips are counted from the first of the layer's canvas.
typedef struct {
    __global const int4 *spans;
    __global const int *layer_spans;  // of the layer, by strip
    __global const int *tile_state;
    __global const real *area, *d_coverage;
    int first_strip, last_strip;
    int strip, tile, index;  // the tile looked up last, and its index, -1 if it stores no coverage
} Lookup;

inline Lookup lookup_of(Grid grid, __global const Tables *tables, __global realv *cells, int layer)
{
    Cells at = cells_of(tables, cells);
    int2 strips = layer_strips(tables, layer);
    int origin = strips_first(strips) / grid.period * grid.period;
    Lookup lookup = {spans_of(tables),
                     table_at(tables, tables->layer_spans) + strips.x + origin,
                     at.tile_state,
                     (__global const real *)at.area,
                     (__global const real *)at.scratch,
                     max(grid.first_strip, strips_first(strips)) - origin,
                     min(grid.last_strip, strips_last(strips)) - origin,
                     -1,
                     -1,
                     -1};
    return lookup;
}

inline int lookup_tile(Lookup *lookup, int strip, int tile)
{
    if (strip == lookup->strip && tile == lookup->tile) return lookup->index;
    lookup->strip = strip;
    lookup->tile = tile;
    lookup->index = -1;
    if (strip < lookup->first_strip || strip >= lookup->last_strip) return -1;
    int4 span = lookup->spans[lookup->layer_spans[strip]];
    if (tile < span_first(span) || tile >= span_last(span)) return -1;
    int index = span_tile(span, tile);
    return lookup->index = lookup->tile_state[index] == EDGE ? index : -1;
}

// d_coverage times d coverage / dA at a pixel; 0 if no coverage is stored. `direction` is the sign of the change of A for
// one-sided slopes, or 0 for the mean of both at the kinks of min(|A|, 1).
inline real cell_gradient(Lookup *lookup, int column, int row, int direction)
{
    if (column < 0 || row < 0) return 0;
    int index = lookup_tile(lookup, row / LANES, column / TILE);
    if (index < 0) return 0;
    int cell = (index * TILE + column % TILE) * LANES + row % LANES;
    real a = lookup->area[cell], size = MAGNITUDE(a);
    real slope = a > 0 ? 1 : a < 0 ? -1 : direction;                 // of |A|, which can only grow from 0
    if (size > 1 + SNAP) slope = 0;                                   // saturated
    if (size >= 1 - SNAP && a * direction > 0) slope = 0;             // about to be
    if (direction == 0 && MAGNITUDE(size - 1) <= KINK) slope /= 2;  // mean of both directions
    return slope * lookup->d_coverage[cell];
}

// Backward.  Moving a point of a line by (mx, my) changes A of the pixel it lies in by n . (mx, my) per unit of the line's
// parameter s, with n = (-dy, dx), not normalized. A line's ends move it by (1 - s) and s. With g = dL/dA of the pixels that
// the line crosses (dL/dcoverage times the slope of min(|A|, 1), which is sign(A) or, where saturated, 0):
//
//     d_v0 = n sum over pixels of g * integral of (1 - s) ds,      d_v1 = n sum over pixels of g * integral of s ds
//
// This is correct summed over a closed subpath. A line exactly on a border between pixels can move into either: the
// gradient is the mean of the two one-sided ones, g = (g before + g after) / 2, each with the slope for the sign of that
// change of A: sign(n) towards larger coordinates, -sign(n) the other way. (Two opposite lines on one border with nothing
// between them are an exception: |A| is then no sum over lines.)
//
// Work-item: one line.
//
// tables, lines  in       cells  in: tile_state, area and, in scratch, d_coverage, as left by compositing
// d_lines  (num_lines,)  out, loss per px of (x0, y0, x1, y1)
__kernel void coverage_backward(Grid grid, __global const Tables *tables, __global real4 *lines, __global realv *cells,
                                __global real4 *d_lines)
{
    int id = get_global_id(0);
    if (id >= tables->num_lines) return;
    real4 line = lines_of(tables, lines)[id], part = line;
    real2 d = line.zw - line.xy, normal = (real2)(-d.y, d.x);
    real g0 = 0, g1 = 0;
    Lookup lookup = lookup_of(grid, tables, cells, table_at(tables, tables->line_layers)[id]);
    int on_column_border = d.x == 0 && d.y != 0 && line.x == floor_of(line.x);
    int on_row_border = d.y == 0 && d.x != 0 && line.y == floor_of(line.y);
    int steep = MAGNITUDE(d.y) >= MAGNITUDE(d.x), sign_x = normal.x < 0 ? -1 : 1, sign_y = normal.y < 0 ? -1 : 1;
    real start = steep ? line.y : line.x, per_px = 1 / (steep ? d.y : d.x);
    // Rows outside the layer's strips have no cells, those outside the band are processed with theirs.
    int top = lookup.first_strip * LANES, bottom = min(grid.height, lookup.last_strip * LANES);
    int some = top < bottom && (MAGNITUDE(d.x) >= FLAT || MAGNITUDE(d.y) >= FLAT);
    if (some && clip_y(&part, top, bottom) && clip_x(&part, 0, grid.width)) {
        Walk walk = walk_begin(part);
        while (walk_next(&walk)) {
            Piece p = walk.piece;
            real s0 = ((steep ? p.y0 : p.x0) - start) * per_px, s1 = ((steep ? p.y1 : p.x1) - start) * per_px;
            real g;
            if (on_column_border)
                g = (cell_gradient(&lookup, p.column - 1, p.row, -sign_x) + cell_gradient(&lookup, p.column, p.row, sign_x)) / 2;
            else if (on_row_border)
                g = (cell_gradient(&lookup, p.column, p.row - 1, -sign_y) + cell_gradient(&lookup, p.column, p.row, sign_y)) / 2;
            else
                g = cell_gradient(&lookup, p.column, p.row, 0);
            real middle = (s0 + s1) / 2;
            g0 += g * (s1 - s0) * (1 - middle);
            g1 += g * (s1 - s0) * middle;
        }
    }
    real4 d_line = (real4)(normal * g0, normal * g1);
    d_lines[id] = grid.first_strip > 0 ? d_lines[id] + d_line : d_line;
}
