// SPDX-License-Identifier: Apache-2.0
// The distance weight of a tile, from the weights that distance.cl found for each layer.

// Index of a span's tile where closeness is stored, -1 where the layer's outline is not within tau.
inline int near_tile(int4 span, __global const int *near, int tile)
{
    if (tile < span_first(span) || tile >= span_last(span)) return -1;
    int index = span_tile(span, tile);
    return near[index] ? index : -1;
}

// Add a layer's share of eq. (1), factor being 1 / (number of layers * sum of the layer's closeness).
inline void add_weight(real factor, __global const realv *closeness, realv *weight)
{
    for (int i = 0; i < TILE; i++) weight[i] += factor * closeness[i];
}
