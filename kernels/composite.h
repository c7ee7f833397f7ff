// SPDX-License-Identifier: Apache-2.0
// Composite one layer over the colour below it, and its gradient; list the visible layers of a tile.

typedef struct {
    realv c[CHANNELS];
} Color;

// Forward, for a layer of straight colour c, opacity o and coverage v over the colour C below:
//     a = o v      C' = C + a (c - C)
inline void over_forward(Color *below, Color color, realv a)
{
    for (int i = 0; i < CHANNELS; i++) below->c[i] += a * (color.c[i] - below->c[i]);
}

// Backward.  d_x stands for dL/dx; G' = dL/dC'.
//     d_c = a G'      d_a = G' . (c - C)      G = dL/dC = (1 - a) G'      d_v = o d_a      d_o = v d_a
// C is kept from the forward pass: recovering it as (C' - a c) / (1 - a) fails for opaque layers, where a = 1.
// Returns d_a, turns G' into G, adds a G' to d_color.
inline realv over_backward(Color *g, Color color, Color below, realv a, Color *d_color)
{
    realv d_a = 0;
    for (int i = 0; i < CHANNELS; i++) {
        d_a += g->c[i] * (color.c[i] - below.c[i]);
        d_color->c[i] += a * g->c[i];
        g->c[i] -= a * g->c[i];
    }
    return d_a;
}

inline Color splat_color(__global const real *rgb)
{
    Color color;
    for (int i = 0; i < CHANNELS; i++) color.c[i] = (realv)(i < 3 ? rgb[i] : (real)1);
    return color;
}

inline Color background_color(__global const real *rgb)
{
    Color color;
    for (int i = 0; i < CHANNELS; i++) color.c[i] = (realv)(CHANNELS == 3 ? rgb[i] : (real)0);
    return color;
}

#include "fill.h"

typedef struct {
    __global const real *params, *background;
    __global const int4 *spans;
    __global const int *tile_state;
    __global const realv *area;
    __global realv *scratch;
    int top, tile;
    int bottom, first, last;  // spans of the strip; those before `first` are hidden
    int covered;      // whether layer `first` is opaque all over the tile, and hides those below
    int num_layers;   // number of layers in the tile, hidden ones excluded
    int edges;        // whether one of them has an outline in the tile, or a gradient
} Site;

// Index of a span's tile at the site, or -1 if the layer is not there.
inline int site_tile(Site site, int span_id)
{
    int4 span = site.spans[span_id];
    if (site.tile < span_first(span) || site.tile >= span_last(span)) return -1;
    int index = span_tile(span, site.tile);
    return site.tile_state[index] == 0 ? -1 : index;
}

// Describe a tile. Hidden are all layers below the num_opaque-th from the top that is opaque all over the tile. For
// colours one such layer is enough; the gradient of its opacity needs the layers below, down to the next.
inline Site site_at(Grid grid, __global const real *params, __global const Tables *tables, __global realv *cells,
                    int strip, int tile, int num_opaque)
{
    __global const int *strip_spans = table_at(tables, tables->strip_offsets) + strip;
    Cells at = cells_of(tables, cells);
    __global const real *background = params_background(params, tables, strip / grid.period);
    Site site = {params, background, spans_of(tables), at.tile_state,  at.area, at.scratch, grid_top(grid, strip),
                 tile,   strip_spans[0],   strip_spans[0], strip_spans[1], 0, 0, 0};
    for (int k = site.last - 1; k >= site.first; k--) {
        int index = site_tile(site, k);
        if (index < 0) continue;
        site.num_layers++;
        site.edges |= site.tile_state[index] == EDGE;
#if FILLS
        site.edges |= is_gradient(params, span_layer(site.spans[k]));
#endif
        if (site.tile_state[index] == EDGE || params_color(params, span_layer(site.spans[k]))[3] != 1) continue;
        if (--num_opaque == 0) {
            site.first = k;
            site.covered = 1;
        }
    }
    return site;
}

// A run of a site's visible layers, bottom first: entries `begin` to DEPTH - 1. All runs have DEPTH layers except the
// lowest, which has the rest.
#define DEPTH 32
typedef struct {
    int begin;
    int layer[DEPTH], tile[DEPTH];
#if FILLS
    Stretch stretch[DEPTH];  // of gradients
#endif
} Stack;

inline int lowest_run(int num_layers) { return num_layers > 0 ? (num_layers - 1) % DEPTH + 1 : 0; }

// Fill the stack with the next `count` layers from span k upwards; returns the span after them.
inline int stack_upwards(Site site, int k, int count, Stack *stack)
{
    stack->begin = DEPTH - count;
    for (int i = stack->begin; i < DEPTH; k++) {
        int index = site_tile(site, k);
        if (index < 0) continue;
        stack->layer[i] = span_layer(site.spans[k]);
        stack->tile[i++] = index;
    }
    return k;
}

// Fill the stack with the next `count` layers below span k; returns the span of the lowest.
inline int stack_downwards(Site site, int k, int count, Stack *stack)
{
    stack->begin = DEPTH - count;
    for (int i = DEPTH; i > stack->begin;) {
        int index = site_tile(site, --k);
        if (index < 0) continue;
        stack->layer[--i] = span_layer(site.spans[k]);
        stack->tile[i] = index;
    }
    return k;
}

inline realv site_coverage(Site site, int tile, int column)
{
    if (site.tile_state[tile] != EDGE) return 1;
    realv a = site.area[tile * TILE + column], size = MAGNITUDE(a);
    return LESSER(size, (realv)1);
}

#if FILLS
// Pixel centres of a tile's column.
inline real site_x(Site site, int column) { return (real)(site.tile * TILE + column) + (real)0.5; }
inline realv site_y(Site site) { return lane_rows() + ((real)site.top + (real)0.5); }

// Find the tile's place on the gradients of the stack.
inline void stack_stretches(Site site, Stack *stack)
{
    for (int i = stack->begin; i < DEPTH; i++)
        if (is_gradient(site.params, stack->layer[i]))
            fill_stretch(site.params, layer_fill(site.params, stack->layer[i]), site_x(site, 0), site_y(site),
                         &stack->stretch[i]);
}

inline Paint layer_paint(Site site, const Stack *stack, int i, int column)
{
    __global const real *fill = layer_fill(site.params, stack->layer[i]);
    if (fill[0] != 0) return fill_paint(site.params, fill, &stack->stretch[i], column);
    __global const real *rgba = params_color(site.params, stack->layer[i]);
    Paint paint = {splat_color(rgba), (realv)rgba[3]};
    return paint;
}
#endif

// Values of the forward that the backward needs, of a layer in one column: the colour below it and, with gradients, its
// paint.
typedef struct {
    Color below;
#if FILLS
    Paint paint;
#endif
} Kept;

// Composite the stack over `color` in one column of the tile; `kept` (may be null) is filled for the backward.
inline void stack_forward(Site site, const Stack *stack, int column, Color *color, Kept *kept)
{
    for (int i = stack->begin; i < DEPTH; i++) {
        if (kept) kept[i].below = *color;
#if FILLS
        Paint paint = layer_paint(site, stack, i, column);
        if (kept) kept[i].paint = paint;
        over_forward(color, paint.color, paint.opacity * site_coverage(site, stack->tile[i], column));
#else
        __global const real *rgba = params_color(site.params, stack->layer[i]);
        over_forward(color, splat_color(rgba), rgba[3] * site_coverage(site, stack->tile[i], column));
#endif
    }
}
