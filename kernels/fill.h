// SPDX-License-Identifier: Apache-2.0
// Fill: colour and opacity of a layer with a gradient fill at a pixel centre, and their derivatives.
//
// Built with -DFILLS=1 if some layer of the drawing is not solid; without it, no kernel reads fills at all.
//
// Place.  With q = p - origin and (u, v) = A q, where origin and A come from the host:
//     linear  t = u,  A's first row (p1 - p0) / |p1 - p0|^2, origin p0       radial  t = |(u, v)|,  A = E^-1, origin c
// A fill without an inverse has A = 0 and t = 2 everywhere: the last stop's colour.
//
// Colour.  Stops (o_k, c_k), c straight RGBA, k = 0 .. K - 1, as a telescoping sum, which is constant beyond both ends:
//     s_k = clamp((t - o_k) / w_k, 0, 1),  w_k = o_{k+1} - o_k       c(t) = c_0 + sum_k s_k (c_{k+1} - c_k)
// Where w_k = 0 it is a step: s_k = 1 from o_k on.
//
// Backward.  d_x stands for dL/dx; d = dL/dc at the pixel, in RGB a G' and in A coverage d_a (composite.h).
//     d_c_{k+1} += s_k d,  d_c_k -= s_k d,  d_c_0 += d       d_s_k = d . (c_{k+1} - c_k)
//     d_t = sum_k h_k d_s_k / w_k       d_o_k -= h_k (1 - s_k) d_s_k / w_k       d_o_{k+1} -= h_k s_k d_s_k / w_k
// h_k is 1 between the stops, 0 beyond them and 1/2 exactly at one: the mean of both sides. A step's place has no gradient.
//     linear  d_u = d_t, d_v = 0       radial  (d_u, d_v) = d_t (u, v) / t, and 0 at the centre, the mean over directions
//     d_A = sum_p (d_u, d_v) q^T       d_q = A^T (d_u, d_v), computed on the host from sum_p (d_u, d_v)
// The host continues to the points (livecl/rendering/fills.py).
#ifndef FILLS
#define FILLS 0
#endif

#if FILLS
#define RADIAL 2
// Layout of the fills in `params`, from offset params[0]: reals of a record of d_fills (4); for each layer (12): kind, first
// stop, number of stops, t at the origin, origin (2), A (2, 2), unused (2); for each stop (6): o, 1 / w or 0, RGBA.
// A record: d_u, d_v, d_A (2, 2), and for each stop (5): d_o, d_c.
#define FILL_REALS 12
#define STOP_REALS 6
#define D_GEOMETRY 6
#define D_STOP 5

typedef struct {
    Color color;
    realv opacity;
} Paint;

typedef struct {
    realv x, y, u, v, t;  // q, A q
} Place;

inline __global const real *params_fills(__global const real *params) { return params + (int)params[0]; }
inline int record_reals(__global const real *params) { return (int)params_fills(params)[0]; }
inline __global const real *layer_fill(__global const real *params, int layer)
{
    return params_fills(params) + 4 + FILL_REALS * layer;
}
inline int is_gradient(__global const real *params, int layer) { return layer_fill(params, layer)[0] != 0; }
inline __global const real *fill_stops(__global const real *params, __global const real *fill)
{
    return params_fills(params) + (int)fill[1];
}

inline Place fill_place(__global const real *fill, real column, realv rows)
{
    Place place;
    place.x = (realv)(column - fill[4]);
    place.y = rows - fill[5];
    place.u = fill[6] * place.x + fill[7] * place.y;
    place.v = fill[8] * place.x + fill[9] * place.y;
    place.t = fill[3] + (fill[0] == RADIAL ? sqrt(place.u * place.u + place.v * place.v) : place.u);
    return place;
}

// s_k; `active` receives h_k / w_k.
inline realv stop_share(__global const real *stop, realv t, realv *active)
{
    realv along = t - stop[0];
    if (stop[1] == 0) {
        *active = 0;
        return along < 0 ? (realv)0 : (realv)1;
    }
    along *= stop[1];
    realv inside = (along > 0 && along < 1) ? (realv)1 : (realv)0;
    *active = stop[1] * ((along == 0 || along == 1) ? (realv)0.5 : inside);
    return BETWEEN(along, (realv)0, (realv)1);
}

// Place of a tile on a gradient: t at its pixels, and the intervals between stops, `first` to before `last`, that these may
// lie in. Before them all shares s_k are 1, after them 0, and their slopes 0.
typedef struct {
    realv t[TILE];
    int first, last;
} Stretch;

inline void fill_stretch(__global const real *params, __global const real *fill, real column, realv rows,
                         Stretch *stretch)
{
    realv low = INFINITY, high = -INFINITY;
    for (int j = 0; j < TILE; j++) {
        realv t = stretch->t[j] = fill_place(fill, column + j, rows).t;
        low = LESSER(t, low);
        high = GREATER(t, high);
    }
    real least = least_lane(low), most = -least_lane(-high);
    __global const real *stop = fill_stops(params, fill);
    stretch->first = 0;
    stretch->last = (int)fill[2] - 1;
    while (stretch->first < stretch->last && stop[STOP_REALS * (stretch->first + 1)] < least) stretch->first++;
    while (stretch->last > stretch->first && stop[STOP_REALS * (stretch->last - 1)] > most) stretch->last--;
}

inline Paint fill_paint(__global const real *params, __global const real *fill, const Stretch *stretch, int column)
{
    __global const real *stop = fill_stops(params, fill) + STOP_REALS * stretch->first;
    Paint paint;
    realv active;
    for (int i = 0; i < CHANNELS; i++) paint.color.c[i] = (realv)(i < 3 ? stop[2 + i] : (real)1);
    paint.opacity = (realv)stop[5];
    for (int k = stretch->first; k < stretch->last; k++, stop += STOP_REALS) {
        realv share = stop_share(stop, stretch->t[column], &active);
        for (int i = 0; i < 3; i++) paint.color.c[i] += share * (stop[STOP_REALS + 2 + i] - stop[2 + i]);
        paint.opacity += share * (stop[STOP_REALS + 5] - stop[5]);
    }
    return paint;
}

// Gradient of a layer's stops and geometry in a tile from d, (TILE, 4), into a record.
inline void fill_backward(__global const real *params, __global const real *fill, real column, realv rows,
                          const Stretch *stretch, realv d[TILE][4], __global real *record)
{
    __global const real *stop = fill_stops(params, fill) + STOP_REALS * stretch->first;
    __global real *d_stop = record + D_GEOMETRY;
    realv d_t[TILE], sum[4];
    for (int i = 0; i < 4; i++) sum[i] = 0;
    for (int j = 0; j < TILE; j++) {
        d_t[j] = 0;
        for (int i = 0; i < 4; i++) sum[i] += d[j][i];
    }
    for (int i = 0; i < D_STOP * (int)fill[2]; i++) d_stop[i] = 0;
    d_stop += D_STOP * stretch->first;
    for (int i = 0; i < 4; i++) d_stop[1 + i] = sum_lanes(sum[i]);
    for (int k = stretch->first; k < stretch->last; k++, stop += STOP_REALS, d_stop += D_STOP) {
        realv shared[4], d_low = 0, d_high = 0;
        for (int i = 0; i < 4; i++) shared[i] = 0;
        for (int j = 0; j < TILE; j++) {
            realv active, share = stop_share(stop, stretch->t[j], &active), d_share = 0;
            for (int i = 0; i < 4; i++) {
                d_share += d[j][i] * (stop[STOP_REALS + 2 + i] - stop[2 + i]);
                shared[i] += share * d[j][i];
            }
            realv slope = active * d_share;
            d_t[j] += slope;
            d_low -= (1 - share) * slope;
            d_high -= share * slope;
        }
        d_stop[0] += sum_lanes(d_low);
        d_stop[D_STOP] = sum_lanes(d_high);
        for (int i = 0; i < 4; i++) {
            real part = sum_lanes(shared[i]);
            d_stop[1 + i] -= part;
            d_stop[D_STOP + 1 + i] = part;
        }
    }
    realv d_geometry[D_GEOMETRY];
    for (int i = 0; i < D_GEOMETRY; i++) d_geometry[i] = 0;
    for (int j = 0; j < TILE && stretch->first < stretch->last; j++) {
        Place place = fill_place(fill, column + j, rows);
        realv d_u = d_t[j], d_v = 0;
        if (fill[0] == RADIAL) {
            realv share = place.t > 0 ? d_t[j] / place.t : (realv)0;
            d_u = share * place.u;
            d_v = share * place.v;
        }
        d_geometry[0] += d_u;
        d_geometry[1] += d_v;
        d_geometry[2] += d_u * place.x;
        d_geometry[3] += d_u * place.y;
        d_geometry[4] += d_v * place.x;
        d_geometry[5] += d_v * place.y;
    }
    for (int i = 0; i < D_GEOMETRY; i++) record[i] = sum_lanes(d_geometry[i]);
}
#endif
