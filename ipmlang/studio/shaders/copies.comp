// Copies of meshes for one camera, made of terminals: far ones that a picture cannot show are left
// out at random while those that stay grow, so that as much is covered (stochastic simplification,
// Cook, Halstead, Planck and Ryu 2007); meshes of a few pixels become boxes of the same mean size.

layout(std430, binding = 4) writeonly buffer Copies { uint copies[]; };

uniform bool counting;   // how many there will be, instead of making them
uniform float size;      // of the world, which becomes 1
uniform vec3 eye;
uniform vec3 forward;
uniform float near;
uniform float focal;     // pixels that a length of 1 is long at a distance of 1

const uint COPY = 13u;   // words: three rows of a matrix, the paint
const uint BOX = 0u;

float chance(uint row) {
    return float(terminals[TERMINAL_KEY0 * room + row] >> 8) / 16777216.0;
}

// The sides of a piece in pixels, largest first.
vec3 seen(Piece piece, vec3 extent, vec3 center) {
    float scale = focal / (size * max(dot(center / size - eye, forward), near));
    vec3 sides = vec3(length(vec3(piece.axes[0])), length(vec3(piece.axes[1])),
                      length(vec3(piece.axes[2]))) * extent * scale;
    float largest = max(sides.x, max(sides.y, sides.z));
    float least = min(sides.x, min(sides.y, sides.z));
    return vec3(largest, sides.x + sides.y + sides.z - largest - least, least);
}

void put(uint at, dvec3 place, dmat3 axes, uint paint) {
    for (int line = 0; line < 3; line++) {
        for (int axis = 0; axis < 3; axis++)
            copies[at++] = floatBitsToUint(float(axes[axis][line]));
        copies[at++] = floatBitsToUint(float(place[line]));
    }
    copies[at] = paint;
}

void main() {
    uint row = gl_GlobalInvocationID.x + gl_GlobalInvocationID.y * gl_NumWorkGroups.x * GROUP;
    if (row >= rows) return;
    Piece piece = piece_of(row);
    if (piece.kind == NOTHING || (piece.paint != 0u && piece.paint >> 24 == 0u)) return;
    vec3 low = of_kind(piece.kind, 0u);
    vec3 extent = of_kind(piece.kind, 3u) - low;
    dvec3 center = piece.place + piece.axes * dvec3(low + extent / 2.0);
    vec3 sides = seen(piece, extent, vec3(center));
    float grown = 1.0;
    if (sides.x < LEAST) {
        float share = max(sides.x * sides.x / (LEAST * LEAST), 1.0 / 65536.0);
        if (chance(row) >= share) return;
        grown = inversesqrt(share);
    }
    dmat3 axes = piece.axes * double(grown / size);
    bool boxed = piece.kind >= CYLINDER && sides.y * grown < FEW;
    uint kind = boxed ? BOX : piece.kind;
    uint place = atomicAdd(counts[kind], 1u);
    if (counting) return;
    if (boxed) {
        vec3 part = of_kind(piece.kind, 6u) * extent;
        for (int axis = 0; axis < 3; axis++) axes[axis] *= double(part[axis]);
        if (piece.paint == 0u) piece.paint = kinds[piece.kind * KIND + 9u];
    } else {
        axes *= double(uintBitsToFloat(kinds[kind * KIND + 10u]));
    }
    // Meshes lie around their own middles, the cube too.
    put(place * COPY, center / double(size), axes, piece.paint);
}
