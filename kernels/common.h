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
// index of tile 0 of the strip in the per-tile buffers). Spans are sorted by strip, then by layer, bottom first.

#if LANES == 4
#pragma OPENCL EXTENSION cl_khr_fp64 : enable
#endif
#ifdef __clang__
#pragma clang diagnostic error "-Wshadow"
#endif

// The smaller and the larger of two numbers or vectors. fmin, fmax and clamp of PoCL take three instructions for one, as they
// must give the other number for one that is not a number; here either comes out.
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
// `tile_state`: the winding number of the whole tile, or EDGE where a line of the outline touches it.
#define EDGE 0x7fffffff
// Rounding left over by the sums of one row of one layer: about a hundred deposits of at most 1.
#define SNAP ((real)128 * REAL_EPSILON)

// Bands.
// Where layers need more memory than allowed, the canvas is worked on in bands of strips, one after the other, in the same
// buffers: int4 band = (first span, past-the-last span, first strip, past-the-last strip). Sums go on from band to band.

inline int span_layer(int4 span) { return span.x; }
inline int span_strip(int4 span) { return span.y; }
inline int span_first(int4 span) { return span.z & 0xffff; }
inline int span_last(int4 span) { return (span.z >> 16) & 0xffff; }
inline int span_tile(int4 span, int tile) { return span.w + tile; }

// A layer's strips: int2 (index into layer_spans of strip 0, first strip | past-the-last strip << 16); layer_spans holds the
// number of the span of each.
inline int strips_first(int2 strips) { return strips.y & 0xffff; }
inline int strips_last(int2 strips) { return (strips.y >> 16) & 0xffff; }

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

// Layout of `params`: background (3), where the fills begin (1), colours (N, 4), points (M, 3, 2), fills (fill.h). Layout of `result`: loss and d_background (1 + 3),
// d_colors (N, 4), d_cubics (M, 4, 2).
inline __global const real *params_color(__global const real *params, int layer) { return params + 4 + 4 * layer; }
inline __global const real *params_points(__global const real *params, int num_layers, int segment)
{
    return params + 4 + 4 * num_layers + 6 * segment;
}
inline __global real *result_cubics(__global real *result, int num_layers, int segment)
{
    return result + 4 + 4 * num_layers + 8 * segment;
}
