// Terminals as the machine leaves them on the card: rows of a table, column by column, words of 32
// bits, two a number. What each is drawn as, and the box that it fills in the world.

layout(local_size_x = GROUP) in;

layout(std430, binding = 0) readonly buffer Terminals { uint terminals[]; };
layout(std430, binding = 1) readonly buffer Kinds { uint kinds[]; };
layout(std430, binding = 2) readonly buffer Colors { uint colors[]; };
layout(std430, binding = 3) buffer Counts { uint counts[]; };

uniform uint rows;
uniform uint room;         // rows that the table has room for
uniform uint word_place;   // the first word of x; y and z follow
uniform uint word_turn;    // of w; i, j and k follow
uniform uint word_scale;   // these may not be there: NONE
uniform uint word_width;
uniform uint word_color;
uniform dvec3 middle;      // what becomes the origin
uniform float thin;        // the width of segments whose pen sets none

struct Piece {
    uint kind;
    dvec3 place;  // of its mesh's origin, in the world
    dmat3 axes;   // what the mesh's axes become
    uint paint;   // red in the lowest byte, as in a picture; 0: none
    bool unset;   // a segment whose pen sets no width
};

const uint NOTHING = NONE;
const uint SQUARES = 1u;   // across x, y, z; 0 is the cube
const uint CYLINDER = 4u;
const uint ASSETS = 5u;
const uint KIND = 12u;     // numbers of a kind: low, high, its box, the colour, corners

double number(uint word, uint row) {
    return packDouble2x32(uvec2(terminals[word * room + row], terminals[(word + 1u) * room + row]));
}

vec3 of_kind(uint kind, uint first) {
    uint at = kind * KIND + first;
    return uintBitsToFloat(uvec3(kinds[at], kinds[at + 1u], kinds[at + 2u]));
}

uint kind_of(int asset, dvec3 size) {
    if (asset >= 0) return ASSETS + uint(asset);
    if (asset == SEGMENT) return size.x != 0.0lf ? CYLINDER : NOTHING;
    bvec3 none = equal(size, dvec3(0.0lf));
    if (int(none.x) + int(none.y) + int(none.z) > 1) return NOTHING;
    return none.x ? SQUARES : none.y ? SQUARES + 1u : none.z ? SQUARES + 2u : 0u;
}

dmat3 rotation(uint row) {
    dvec4 q = dvec4(number(word_turn, row), number(word_turn + 2u, row),
                    number(word_turn + 4u, row), number(word_turn + 6u, row));
    q /= sqrt(dot(q, q));
    double w = q.x, x = q.y, y = q.z, z = q.w;
    return dmat3(1.0lf - 2.0lf * (y * y + z * z), 2.0lf * (x * y + w * z), 2.0lf * (x * z - w * y),
                 2.0lf * (x * y - w * z), 1.0lf - 2.0lf * (x * x + z * z), 2.0lf * (y * z + w * x),
                 2.0lf * (x * z + w * y), 2.0lf * (y * z - w * x), 1.0lf - 2.0lf * (x * x + y * y));
}

// An asset is fitted into a scope that has a size; along an axis where it or the asset has no
// extent, the asset keeps its own.
void fit(inout Piece piece, dvec3 size) {
    if (size == dvec3(0.0lf)) return;
    dvec3 low = dvec3(of_kind(piece.kind, 0u));
    dvec3 extent = dvec3(of_kind(piece.kind, 3u)) - low;
    dvec3 moved = dvec3(0.0lf);
    for (int axis = 0; axis < 3; axis++) {
        double factor = size[axis] != 0.0lf && extent[axis] > 0.0lf ? size[axis] / extent[axis] : 1.0lf;
        piece.axes[axis] *= factor;
        moved -= piece.axes[axis] * low[axis];
    }
    piece.place += moved;
}

Piece piece_of(uint row) {
    Piece piece;
    int asset = int(terminals[TERMINAL_ASSET * room + row]);
    dvec3 size = dvec3(number(TERMINAL, row), number(TERMINAL + 2u, row), number(TERMINAL + 4u, row));
    piece.kind = kind_of(asset, size);
    piece.unset = false;
    piece.paint = 0u;
    if (piece.kind == NOTHING) return piece;
    piece.place = dvec3(number(word_place, row), number(word_place + 2u, row),
                        number(word_place + 4u, row)) - middle;
    piece.axes = rotation(row);
    double scale = word_scale == NONE ? 1.0lf : number(word_scale, row);
    piece.axes[0] *= sign(scale);
    scale = abs(scale);
    if (asset == SEGMENT) {
        double width = word_width == NONE ? -1.0lf : number(word_width, row);
        piece.unset = !(width >= 0.0lf);
        if (piece.unset) width = double(thin);
        piece.axes = dmat3(piece.axes[0] * (size.x * scale), piece.axes[1] * width, piece.axes[2] * width);
    } else if (asset >= 0) {
        piece.axes *= scale;
        fit(piece, size);
    } else {
        for (int axis = 0; axis < 3; axis++)
            piece.axes[axis] *= scale * (size[axis] != 0.0lf ? size[axis] : 1.0lf);
    }
    int text = word_color == NONE ? -1 : int(number(word_color, row));
    if (text >= 0) piece.paint = colors[text];
    return piece;
}
