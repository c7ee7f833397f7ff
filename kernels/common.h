// SPDX-License-Identifier: Apache-2.0
// Number types and the tiling that all kernels share.
//
// The program is built with  -DREAL=float -DLANES=8 -DMASK=int -DREAL_EPSILON=FLT_EPSILON  or, for the gradient checks,
// -DREAL=double -DLANES=4 -DMASK=long -DREAL_EPSILON=DBL_EPSILON, and with CHANNELS=3 (a background) or 4 (none).
//
// Frame: x to the right, y down, px; pixel (column, row) covers [column, column + 1] x [row, row + 1].
// A strip is LANES rows; a tile is TILE columns of a strip. A vector holds one column of a tile, a lane for each row, so
// that sums along a row are sums of vectors. An image plane is (num_strips, num_tiles * TILE) vectors.
//
// A span is the row of tiles where a layer's box meets a strip: int4 (layer, strip, first tile | past-the-last tile << 16,
// index of tile 0 of the strip among the stored tiles). Spans are sorted by strip, then by layer, bottom first.
//
// Kernels take structs and buffers of one subject each. Their layouts are defined here, their sizes and the host's side in
// livecl/rendering/layout.py.

#if LANES == 4
#pragma OPENCL EXTENSION cl_khr_fp64 : enable
#endif
#ifdef __clang__
#pragma clang diagnostic error "-Wshadow"
#endif

// Minimum, maximum and clamp of numbers or vectors. PoCL's fmin, fmax and clamp take three instructions instead of one, as
// they must return the other operand for a NaN; these may return either.
#define LESSER(a, b) ((a) < (b) ? (a) : (b))
#define GREATER(a, b) ((a) > (b) ? (a) : (b))
#define BETWEEN(a, low, high) ((a) < (low) ? (low) : LESSER(a, high))
#define MAGNITUDE(a) GREATER(a, -(a))

#define CONCAT_(a, b) a##b
#define CONCAT(a, b) CONCAT_(a, b)

typedef REAL real;
typedef CONCAT(REAL, 2) real2;
typedef CONCAT(REAL, 4) real4;
typedef CONCAT(REAL, LANES) realv;
typedef CONCAT(MASK, LANES) maskv;

#define TILE 8
// `tile_state`: the winding number of the whole tile, or EDGE if a line of the outline touches it.
#define EDGE 0x7fffffff
// Bound on the rounding error of one row's sums in one layer: about a hundred deposits of at most 1.
#define SNAP ((real)128 * REAL_EPSILON)
// Bound on the rounding error of A in a full pixel: some ten deposits that add up to 1.
#define KINK ((real)16 * REAL_EPSILON)

// The canvases of one or more drawings, stacked, and the current band. Coordinates are those of the drawing's own canvas:
// strip `period` is the first of the second drawing, at y = 0. If layers need more memory than allowed, the strips are
// processed in bands, one after the other, in the same buffers. Sums continue from band to band.
typedef struct {
    int width, height;            // px, of a canvas
    int num_strips, num_tiles;    // strips of all canvases, tiles of a strip
    int period;                   // strips of a canvas
    int first_span, last_span;    // of the band; the last is past the last
    int first_strip, last_strip;  // likewise
} Grid;

inline int grid_drawings(Grid grid) { return grid.num_strips / grid.period; }
inline int grid_top(Grid grid, int strip) { return strip % grid.period * LANES; }  // y of a strip's first row
inline int grid_columns(Grid grid) { return grid.num_tiles * TILE; }
inline int grid_plane(Grid grid) { return grid.num_strips * grid.num_tiles * TILE; }  // vectors of an image plane

// The tile of a work-item, in kernels with one for each tile. Returns 0 if there is none, as global sizes are padded.
inline int grid_tile(Grid grid, int id, int *strip, int *tile)
{
    *tile = id % grid.num_tiles;
    *strip = grid.first_strip + id / grid.num_tiles;
    return *strip < grid.last_strip;
}

// `tables`: this head, the spans (num_spans, int4), and the other tables at the offsets given here, in ints from the head.
// There is one buffer for coverage, one for distances; they differ in lines and in the reach of the boxes.
typedef struct {
    int num_layers, num_segments, num_lines, num_spans;
    int num_stored;      // tiles stored at a time: the largest number in a band
    int layer_strips;    // (num_layers, int2): index into layer_spans of strip 0, first strip | past-the-last strip << 16
    int layer_spans;     // (num_spans,): numbers of the spans, by layer, then by strip
    int strip_offsets;   // (num_strips + 1,): first span of each strip
    int layer_segments;  // (num_layers + 1,): first segment of each layer
    int next_segments;   // (num_segments,): the segment whose anchor is the end of each
    int line_offsets;    // (num_segments + 1,): first line of each segment
    int line_layers;     // (num_lines,)
} Tables;

inline __global const int4 *spans_of(__global const Tables *tables) { return (__global const int4 *)(tables + 1); }
inline __global const int *table_at(__global const Tables *tables, int begin)
{
    return (__global const int *)tables + begin;
}

inline int span_layer(int4 span) { return span.x; }
inline int span_strip(int4 span) { return span.y; }
inline int span_first(int4 span) { return span.z & 0xffff; }
inline int span_last(int4 span) { return (span.z >> 16) & 0xffff; }
inline int span_tile(int4 span, int tile) { return span.w + tile; }

// The strips of a layer, and its span in one of them.
inline int2 layer_strips(__global const Tables *tables, int layer)
{
    return ((__global const int2 *)table_at(tables, tables->layer_strips))[layer];
}
inline int strips_first(int2 strips) { return strips.y & 0xffff; }
inline int strips_last(int2 strips) { return (strips.y >> 16) & 0xffff; }
inline int4 layer_span(__global const Tables *tables, int2 strips, int strip)
{
    return spans_of(tables)[table_at(tables, tables->layer_spans)[strips.x + strip]];
}

// `lines`: bounds of each segment's lines (num_segments, real4: x_min, y_min, x_max, y_max), and the lines (num_lines,
// real4: x0, y0, x1, y1), px.
inline __global real4 *lines_of(__global const Tables *tables, __global real4 *lines)
{
    return lines + tables->num_segments;
}

// The lines of all layers' segments, for coverage and distances.
typedef struct {
    __global const int *layer_segments, *line_offsets;
    __global const real4 *bounds, *lines;
} Outlines;

inline Outlines outlines_of(__global const Tables *tables, __global const real4 *lines)
{
    Outlines outlines = {table_at(tables, tables->layer_segments), table_at(tables, tables->line_offsets), lines,
                         lines + tables->num_segments};
    return outlines;
}

// `cells`: data of coverage for each tile.
typedef struct {
    __global realv *area;      // (num_stored, TILE): A, in EDGE tiles only
    __global realv *scratch;   // (num_stored, TILE): successively heights, colours below a run of layers, dL/dcoverage
    __global int *tile_state;  // (num_stored,)
} Cells;

inline Cells cells_of(__global const Tables *tables, __global realv *cells)
{
    int num_vectors = tables->num_stored * TILE;
    Cells at = {cells, cells + num_vectors, (__global int *)(cells + 2 * num_vectors)};
    return at;
}

// `d_tiles`: sums of compositing in each tile. A record of d_fills is described in fill.h. Pass the pointers one by one:
// for the whole struct, clang emits an intrinsic that Oclgrind does not support.
typedef struct {
    __global real4 *d_colors;  // (num_stored,): dL/d(r, g, b, opacity) of a layer
    __global real4 *d_canvas;  // (tiles of the band,): loss, dL/dbackground
    __global real *d_fills;    // (num_stored, reals of a record), of layers with a gradient
} TileSums;

inline TileSums tile_sums_of(Grid grid, __global const Tables *tables, __global real4 *d_tiles)
{
    __global real4 *d_canvas = d_tiles + tables->num_stored;
    TileSums at = {d_tiles, d_canvas, (__global real *)(d_canvas + grid.num_strips * grid.num_tiles)};
    return at;
}

// The lanes' row numbers 0, 1, ... as reals.
inline realv lane_rows(void)
{
#if LANES == 8
    return (realv)(0, 1, 2, 3, 4, 5, 6, 7);
#else
    return (realv)(0, 1, 2, 3);
#endif
}

// Sum over the lanes, always in the same order.
inline real sum_lanes(realv v)
{
#if LANES == 8
    real4 half_sum = v.lo + v.hi;
#else
    real4 half_sum = v;
#endif
    real2 quarter_sum = half_sum.lo + half_sum.hi;
    return quarter_sum.x + quarter_sum.y;
}

// The smallest of the lanes.
inline real least_lane(realv v)
{
#if LANES == 8
    real4 half_least = LESSER(v.lo, v.hi);
#else
    real4 half_least = v;
#endif
    real2 quarter_least = LESSER(half_least.lo, half_least.hi);
    return LESSER(quarter_least.x, quarter_least.y);
}

// `params`: offset of the fills (1), unused (3), colours (N, 4), points (M, 3, 2), backgrounds (4 for each drawing: RGB,
// unused), fills (fill.h).
inline __global const real *params_color(__global const real *params, int layer) { return params + 4 + 4 * layer; }
inline __global const real *params_points(__global const real *params, int num_layers, int segment)
{
    return params + 4 + 4 * num_layers + 6 * segment;
}
inline __global const real *params_background(__global const real *params, __global const Tables *tables, int drawing)
{
    return params_points(params, tables->num_layers, tables->num_segments) + 4 * drawing;
}

// `result`: d_colors (N, 4), d_cubics (M, 4, 2), loss and d_background of each drawing (1 + 3), sums of d_fills (N, reals of a
// record).
inline __global real4 *result_colors(__global real *result) { return (__global real4 *)result; }
inline __global real *result_cubics(__global const Tables *tables, __global real *result, int segment)
{
    return result + 4 * tables->num_layers + 8 * segment;
}
inline __global real4 *result_drawings(__global const Tables *tables, __global real *result)
{
    return (__global real4 *)result_cubics(tables, result, tables->num_segments);
}
inline __global real *result_fills(Grid grid, __global const Tables *tables, __global real *result)
{
    return (__global real *)(result_drawings(tables, result) + grid_drawings(grid));
}
