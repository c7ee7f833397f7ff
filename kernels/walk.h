// SPDX-License-Identifier: Apache-2.0
// Walk along a line from pixel to pixel: the common part of coverage and its gradient.

// A line's piece inside one pixel: from (x0, y0) to (x1, y1), in the line's direction.
typedef struct {
    int column, row;
    real x0, y0, x1, y1;
} Piece;

enum { WALK_BEGUN, WALK_CROSSES_COLUMN, WALK_CROSSES_ROW, WALK_ENDED };

typedef struct {
    real4 line;                 // (x0, y0, x1, y1)
    real inverse_dx, inverse_dy;
    int step_x, step_y;         // direction, -1 or 1
    int columns_left, rows_left;  // borders still to cross
    int state;                  // border at which the piece ends
    Piece piece;
} Walk;

// Lines with a smaller extent in x or y than this, px, are treated as vertical or horizontal in divisions by the extent,
// as quotients by subnormal numbers are infinite. The misplaced part is at most this high or wide.
#define FLAT ((real)1e-30)

// Clip a line to y within [low, high]; returns 0 if nothing is left. Clipped ends lie exactly at the limit.
inline int clip_y(real4 *line, real low, real high)
{
    real4 v = *line;
    if ((v.y < low && v.w < low) || (v.y > high && v.w > high)) return 0;
    if (v.y >= low && v.w >= low && v.y <= high && v.w <= high) return 1;
    real slope = MAGNITUDE(v.w - v.y) < FLAT ? (real)0 : (v.z - v.x) / (v.w - v.y);
    real4 cut = v;
    if (v.y < low) cut.xy = (real2)(v.x + (low - v.y) * slope, low);
    if (v.y > high) cut.xy = (real2)(v.x + (high - v.y) * slope, high);
    if (v.w < low) cut.zw = (real2)(v.x + (low - v.y) * slope, low);
    if (v.w > high) cut.zw = (real2)(v.x + (high - v.y) * slope, high);
    *line = cut;
    return 1;
}

inline int clip_x(real4 *line, real low, real high)
{
    real4 turned = (*line).yxwz;
    int some = clip_y(&turned, low, high);
    *line = turned.yxwz;
    return some;
}

inline int floor_of(real p)
{
    int whole = (int)p;
    return whole - (whole > p);
}
inline int ceil_of(real p)
{
    int whole = (int)p;
    return whole + (whole < p);
}

// The pixel row or column that a point at p enters when it moves by d, and the one that it leaves; a line on a border (d =
// 0) belongs to the pixels after the border.
inline int cell_entered(real p, real d) { return d < 0 ? ceil_of(p) - 1 : floor_of(p); }
inline int cell_left(real p, real d) { return d > 0 ? ceil_of(p) - 1 : floor_of(p); }

inline Walk walk_begin(real4 line)
{
    Walk walk;
    real dx = line.z - line.x, dy = line.w - line.y;
    walk.line = line;
    walk.inverse_dx = MAGNITUDE(dx) < FLAT ? (real)0 : 1 / dx;
    walk.inverse_dy = MAGNITUDE(dy) < FLAT ? (real)0 : 1 / dy;
    walk.step_x = dx < 0 ? -1 : 1;
    walk.step_y = dy < 0 ? -1 : 1;
    walk.piece.column = cell_entered(line.x, dx);
    walk.piece.row = cell_entered(line.y, dy);
    walk.columns_left = abs(cell_left(line.z, dx) - walk.piece.column);
    walk.rows_left = abs(cell_left(line.w, dy) - walk.piece.row);
    walk.piece.x1 = line.x;
    walk.piece.y1 = line.y;
    walk.state = WALK_BEGUN;
    return walk;
}

// Advance to the next piece; returns 0 at the end of the line. The borders to cross are counted beforehand, so rounding can
// neither skip a pixel nor loop for ever; pieces meet exactly, so their heights add up to the line's.
inline int walk_next(Walk *walk)
{
    if (walk->state == WALK_ENDED) return 0;
    Piece *piece = &walk->piece;
    if (walk->state == WALK_CROSSES_COLUMN) piece->column += walk->step_x, walk->columns_left--;
    if (walk->state == WALK_CROSSES_ROW) piece->row += walk->step_y, walk->rows_left--;
    piece->x0 = piece->x1;
    piece->y0 = piece->y1;
    if (walk->columns_left <= 0 && walk->rows_left <= 0) {
        piece->x1 = walk->line.z;
        piece->y1 = walk->line.w;
        walk->state = WALK_ENDED;
        return 1;
    }
    real border_x = piece->column + (walk->step_x > 0), border_y = piece->row + (walk->step_y > 0);
    real s_x = walk->columns_left > 0 ? (border_x - walk->line.x) * walk->inverse_dx : (real)2;
    real s_y = walk->rows_left > 0 ? (border_y - walk->line.y) * walk->inverse_dy : (real)2;
    if (s_x <= s_y) {
        piece->x1 = border_x;
        real y = walk->line.y + s_x * (walk->line.w - walk->line.y);
        piece->y1 = BETWEEN(y, (real)piece->row, (real)(piece->row + 1));
        walk->state = WALK_CROSSES_COLUMN;
    } else {
        real x = walk->line.x + s_y * (walk->line.z - walk->line.x);
        piece->x1 = BETWEEN(x, (real)piece->column, (real)(piece->column + 1));
        piece->y1 = border_y;
        walk->state = WALK_CROSSES_ROW;
    }
    return 1;
}
