// SPDX-License-Identifier: Apache-2.0
// The distance weight of a tile, from the closeness measured by distance.cl for each layer.

// `distances`: data of distance.cl for each tile, span and layer.
typedef struct {
    __global realv *closeness;  // (num_stored, TILE), px, where near; 0 beyond the canvas
    __global real *span_sums;   // (num_spans,), px
    __global real *factors;     // (num_layers,), loss per px
    __global int *near;         // (num_stored,): 1 if closeness is stored
} Distances;

inline Distances distances_of(__global const Tables *tables, __global realv *distances)
{
    __global real *span_sums = (__global real *)(distances + tables->num_stored * TILE);
    __global real *factors = span_sums + tables->num_spans;
    Distances at = {distances, span_sums, factors, (__global int *)(factors + tables->num_layers)};
    return at;
}

// Index of a span's tile if its closeness is stored; -1 if the layer's outline is not within tau.
inline int near_tile(int4 span, __global const int *near, int tile)
{
    if (tile < span_first(span) || tile >= span_last(span)) return -1;
    int index = span_tile(span, tile);
    return near[index] ? index : -1;
}

// Add a layer's share of eq. (1), factor being scale / (number of layers * sum of the layer's closeness).
inline void add_weight(real factor, __global const realv *closeness, realv *weight)
{
    for (int i = 0; i < TILE; i++) weight[i] += factor * closeness[i];
}
