// SPDX-License-Identifier: Apache-2.0
// Composite: layers `over` the background in paint order, bottom first, and the gradient with respect to colours,
// opacities, background and coverage. With a background the image has 3 channels; without one it has 4, premultiplied: the
// same recurrence with c = (r, g, b, 1) and nothing below (Porter and Duff 1984).
//
// Work-item: one tile. If it has no outline, all its pixels have one colour, which is computed once; and as the gradient is
// linear in dL/dimage, that is summed over the tile's columns first, and passed down the layers once.
//
// Images are planes of vectors, (CHANNELS, num_strips, num_tiles * TILE). Padding beyond the canvas is rendered and has
// weight (or d_image) 0.
#include "common.h"
#include "composite.h"
#include "distance.h"

__kernel void composite_forward(Grid grid, __global const real *params, __global const Tables *tables,
                                __global realv *cells, __global realv *image)
{
    int strip, tile;
    if (!grid_tile(grid, get_global_id(0), &strip, &tile)) return;
    Site site = site_at(grid, params, tables, cells, strip, tile, 1);
    int row = (strip * grid.num_tiles + tile) * TILE, plane = grid_plane(grid);
    int step = site.edges ? 1 : TILE, span = site.first;
    Stack stack;
    Color color[TILE];
    for (int column = 0; column < TILE; column += step) color[column] = background_color(site.background);
    for (int above = site.num_layers, count = lowest_run(above); above > 0; above -= count, count = DEPTH) {
        span = stack_upwards(site, span, count, &stack);
#if FILLS
        stack_stretches(site, &stack);
#endif
        for (int column = 0; column < TILE; column += step) stack_forward(site, &stack, column, &color[column], 0);
    }
    for (int column = 0; column < TILE; column++)
        for (int i = 0; i < CHANNELS; i++) image[i * plane + row + column] = color[step == 1 ? column : 0].c[i];
}

// Source of dL/dimage: given, or that of a weighted squared error.
typedef struct {
    __global const realv *d_image;                 // (CHANNELS, plane), or null
    __global const realv *target;                  // (CHANNELS, plane)
    realv weight[TILE];                            // of the tile's pixels, times scale
    int plane, row;
} Objective;

inline Objective objective_of(Grid grid, int strip, int tile, __global const realv *d_image,
                              __global const realv *target)
{
    Objective objective;
    objective.d_image = d_image;
    objective.target = target;
    objective.plane = grid_plane(grid);
    objective.row = (strip * grid.num_tiles + tile) * TILE;
    for (int i = 0; i < TILE; i++) objective.weight[i] = 0;
    return objective;
}

// L = sum over pixels of scale * weight * |E|^2. With a background E = C - target, and dL/dC = 2 scale weight E. With the
// distance weight d' and scale 1/3 this is eq. (2), with weight 1 and scale 1 / (3 H W) the mean squared error.
//
// Without one, let e be the error of premultiplied RGBA, C - target. Over a background b the picture is p + (1 - a) b in
// each of R, G and B, so the visible error is e_i - e_a b. Over black and white, the mean of its square is
//     1/2 e_i^2 + 1/2 (e_i - e_a)^2 = (e_i - e_a / 2)^2 + e_a^2 / 4,
// summed over the three: |E|^2 with E_i = e_i - e_a / 2, E_a = sqrt(3) / 2 e_a. As E is linear in e, so is the gradient
// in that by E, h = 2 scale weight E: dL/de_i = h_i, dL/de_a = sqrt(3) / 2 h_a - (h_r + h_g + h_b) / 2.
#define ALPHA_SEEN ((real)0.86602540378443864676)  // sqrt(3) / 2

inline Color visible_error(Color error)
{
    if (CHANNELS == 3) return error;
    for (int i = 0; i < 3; i++) error.c[i] -= (real)0.5 * error.c[CHANNELS - 1];
    error.c[CHANNELS - 1] *= ALPHA_SEEN;
    return error;
}

inline Color visible_error_backward(Color h)
{
    if (CHANNELS == 3) return h;
    h.c[CHANNELS - 1] = ALPHA_SEEN * h.c[CHANNELS - 1] - (real)0.5 * (h.c[0] + h.c[1] + h.c[2]);
    return h;
}

inline void objective_at(const Objective *objective, int column, Color color, Color *g, realv *loss)
{
    int at = objective->row + column;
    if (objective->d_image) {
        for (int i = 0; i < CHANNELS; i++) g->c[i] += objective->d_image[i * objective->plane + at];
        return;
    }
    realv weight = objective->weight[column];
    Color error, h;
    for (int i = 0; i < CHANNELS; i++) error.c[i] = color.c[i] - objective->target[i * objective->plane + at];
    error = visible_error(error);
    for (int i = 0; i < CHANNELS; i++) {
        realv weighted = weight * error.c[i];
        *loss += weighted * error.c[i];
        h.c[i] = weighted + weighted;
    }
    h = visible_error_backward(h);
    for (int i = 0; i < CHANNELS; i++) g->c[i] += h.c[i];
}

// Whether any pixel of the tile has a nonzero weight in the loss.
inline int objective_counts(const Objective *objective)
{
    if (objective->d_image) return 1;
    maskv some = 0;
    for (int i = 0; i < TILE; i++) some |= objective->weight[i] != 0;
    return any(some);
}

// Clear the gradients of the layers of spans `begin` to before `end`: hidden ones, or all in a tile without weight.
inline void clear_layers(Site site, int begin, int end, __global real4 *d_colors, __global real *d_fills)
{
    __global realv *d_coverage = site.scratch;
    for (int k = begin; k < end; k++) {
        int index = site_tile(site, k);
        if (index < 0) continue;
        d_colors[index] = 0;
#if FILLS
        int num_reals = record_reals(site.params);
        if (is_gradient(site.params, span_layer(site.spans[k])))
            for (int i = 0; i < num_reals; i++) d_fills[index * num_reals + i] = 0;
#endif
        if (site.tile_state[index] == EDGE)
            for (int i = 0; i < TILE; i++) d_coverage[index * TILE + i] = 0;
    }
}

// On the way up, keep the colour below each run except the lowest. It is stored in the place of d_coverage of the run's
// lowest layers, which is written only after the colour has been used.
inline void keep_colors(Site site, int step)
{
    __global realv *kept = site.scratch;
    Stack stack;
    Color color[TILE];
    int count = lowest_run(site.num_layers), span = stack_upwards(site, site.first, count, &stack);
    for (int column = 0; column < TILE; column += step) color[column] = background_color(site.background);
    for (int above = site.num_layers - count; above > 0; above -= DEPTH) {
#if FILLS
        stack_stretches(site, &stack);
#endif
        for (int column = 0; column < TILE; column += step) stack_forward(site, &stack, column, &color[column], 0);
        span = stack_upwards(site, span, DEPTH, &stack);
        for (int column = 0; column < TILE; column += step)
            for (int i = 0; i < CHANNELS; i++)
                kept[stack.tile[stack.begin + i] * TILE + column] = color[column].c[i];
    }
}

inline Color kept_color(const Stack *stack, int column, __global const realv *kept)
{
    Color color;
    for (int i = 0; i < CHANNELS; i++) color.c[i] = kept[stack->tile[stack->begin + i] * TILE + column];
    return color;
}

// Run after run, the topmost first: its layers are composited again from the colour kept below it, and the gradient is
// passed down through them.
//
//     d_color = a G'      d_a = G' . (c - C)      d_coverage = opacity d_a      d_opacity = coverage d_a,
// as derived in composite.h, each summed over the tile's pixels, except d_coverage, which is stored in scratch for EDGE
// tiles; G at the bottom is d_background. `d_canvas` is the tile's own.
inline void tile_backward(Site site, const Objective *objective, __global real4 *d_colors, __global real4 *d_canvas,
                          __global real *d_fills)
{
    if (!objective_counts(objective)) {
        clear_layers(site, site.bottom, site.last, d_colors, d_fills);
        *d_canvas = 0;
        return;
    }
    clear_layers(site, site.bottom, site.first, d_colors, d_fills);
    __global realv *d_coverage = site.scratch;
    int step = site.edges ? 1 : TILE;  // columns that share one colour
    if (site.num_layers > DEPTH) keep_colors(site, step);
    Stack stack;
    Kept kept[DEPTH];
    Color d_color[DEPTH], g[TILE];
    realv d_opacity[DEPTH], loss = 0;
#if FILLS
    realv d_paint[DEPTH][TILE][4];
#endif
    int span = site.last, lower = site.num_layers;
    do {
        int topmost = lower == site.num_layers, count = min(lower, DEPTH);
        span = stack_downwards(site, span, count, &stack);
#if FILLS
        stack_stretches(site, &stack);
#endif
        lower -= count;
        for (int k = stack.begin; k < DEPTH; k++) {
            d_opacity[k] = 0;
            for (int i = 0; i < CHANNELS; i++) d_color[k].c[i] = 0;
        }
        for (int column = 0; column < TILE; column += step) {
            Color color = lower > 0 ? kept_color(&stack, column, site.scratch) : background_color(site.background);
            stack_forward(site, &stack, column, &color, kept);
            Color *gradient = &g[column];
            if (topmost) {
                for (int i = 0; i < CHANNELS; i++) gradient->c[i] = 0;
                for (int i = column; i < column + step; i++) objective_at(objective, i, color, gradient, &loss);
            }
            for (int k = DEPTH - 1; k >= stack.begin; k--) {
                int index = stack.tile[k];
                realv coverage = site_coverage(site, index, column);
#if FILLS
                if (is_gradient(site.params, stack.layer[k])) {
                    Paint paint = kept[k].paint;
                    Color d_here;
                    for (int i = 0; i < CHANNELS; i++) d_here.c[i] = 0;
                    realv d_alpha = over_backward(gradient, paint.color, kept[k].below, paint.opacity * coverage, &d_here);
                    for (int i = 0; i < 3; i++) d_paint[k][column][i] = d_here.c[i];
                    d_paint[k][column][3] = coverage * d_alpha;
                    if (site.tile_state[index] == EDGE) d_coverage[index * TILE + column] = paint.opacity * d_alpha;
                    continue;
                }
#endif
                __global const real *rgba = params_color(site.params, stack.layer[k]);
                realv d_a = over_backward(gradient, splat_color(rgba), kept[k].below, rgba[3] * coverage, &d_color[k]);
                d_opacity[k] += coverage * d_a;
                if (site.tile_state[index] == EDGE) d_coverage[index * TILE + column] = rgba[3] * d_a;
            }
        }
        for (int k = stack.begin; k < DEPTH; k++)
            d_colors[stack.tile[k]] = (real4)(sum_lanes(d_color[k].c[0]), sum_lanes(d_color[k].c[1]),
                                              sum_lanes(d_color[k].c[2]), sum_lanes(d_opacity[k]));
#if FILLS
        int num_reals = record_reals(site.params);
        for (int k = stack.begin; k < DEPTH; k++)
            if (is_gradient(site.params, stack.layer[k]))
                fill_backward(site.params, layer_fill(site.params, stack.layer[k]), site_x(site, 0), site_y(site),
                              &stack.stretch[k], d_paint[k], d_fills + stack.tile[k] * num_reals);
#endif
    } while (lower > 0);
    real d_background[3];
    for (int i = 0; i < 3; i++) {
        realv sum = 0;
        for (int column = 0; column < TILE; column += step) sum += g[column].c[i];
        d_background[i] = site.covered ? (real)0 : sum_lanes(sum);
    }
    *d_canvas = (real4)(sum_lanes(loss), d_background[0], d_background[1], d_background[2]);
}

// Backward for a given dL/dimage.
//
// params, tables  in       cells  in: tile_state, area; out, in scratch: d_coverage       d_image  (CHANNELS, plane)  in
// d_tiles  out: d_colors, d_canvas (loss 0), d_fills
__kernel void composite_backward(Grid grid, __global const real *params, __global const Tables *tables,
                                 __global realv *cells, __global const realv *d_image, __global real4 *d_tiles)
{
    int id = get_global_id(0), strip, tile;
    if (!grid_tile(grid, id, &strip, &tile)) return;
    Site site = site_at(grid, params, tables, cells, strip, tile, 2);
    Objective objective = objective_of(grid, strip, tile, d_image, 0);
    TileSums sums = tile_sums_of(grid, tables, d_tiles);
    tile_backward(site, &objective, sums.d_colors, sums.d_canvas + id, sums.d_fills);
}

// Forward, weighted squared error and backward in one kernel; the image stays inside the work-item.
//
// target  (CHANNELS, plane)  in      weight  (plane)  in      the others as in composite_backward, with the loss
__kernel void composite_loss(Grid grid, __global const real *params, __global const Tables *tables,
                             __global realv *cells, __global const realv *target, __global const realv *weight,
                             real scale, __global real4 *d_tiles)
{
    int id = get_global_id(0), strip, tile;
    if (!grid_tile(grid, id, &strip, &tile)) return;
    Site site = site_at(grid, params, tables, cells, strip, tile, 2);
    Objective objective = objective_of(grid, strip, tile, 0, target);
    for (int i = 0; i < TILE; i++) objective.weight[i] = scale * weight[objective.row + i];
    TileSums sums = tile_sums_of(grid, tables, d_tiles);
    tile_backward(site, &objective, sums.d_colors, sums.d_canvas + id, sums.d_fills);
}

// The same with the distance weight, which is computed here from each layer's closeness of distance.cl.
//
// distance_tables, distances  in, as in distance_weight; the factors hold the scale
__kernel void composite_distance_loss(Grid grid, __global const real *params, __global const Tables *tables,
                                      __global realv *cells, __global const Tables *distance_tables,
                                      __global realv *distances, __global const realv *target, __global real4 *d_tiles)
{
    int id = get_global_id(0), strip, tile;
    if (!grid_tile(grid, id, &strip, &tile)) return;
    Site site = site_at(grid, params, tables, cells, strip, tile, 2);
    Objective objective = objective_of(grid, strip, tile, 0, target);
    Distances at = distances_of(distance_tables, distances);
    __global const int4 *spans = spans_of(distance_tables);
    __global const int *strip_spans = table_at(distance_tables, distance_tables->strip_offsets) + strip;
    for (int k = strip_spans[0]; k < strip_spans[1]; k++) {
        int index = near_tile(spans[k], at.near, tile);
        if (index < 0) continue;
        add_weight(at.factors[span_layer(spans[k])], at.closeness + index * TILE, objective.weight);
    }
    TileSums sums = tile_sums_of(grid, tables, d_tiles);
    tile_backward(site, &objective, sums.d_colors, sums.d_canvas + id, sums.d_fills);
}
