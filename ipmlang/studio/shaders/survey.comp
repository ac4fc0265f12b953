// What a table holds: how many of each kind, which colours, and how far it reaches along each of
// many directions, by the corners of the boxes that pieces fill.

layout(std430, binding = 4) writeonly buffer Reaches { vec4 reaches[]; };

uniform vec3 directions[DIRECTIONS];
uniform uint kinds_known;  // then come the texts that colours are, then whether a width is unset

void main() {
    float most[2 * DIRECTIONS];
    uint which[2 * DIRECTIONS];
    for (uint each = 0u; each < 2u * DIRECTIONS; each++) which[each] = NONE;
    for (uint row = gl_GlobalInvocationID.x; row < rows; row += gl_NumWorkGroups.x * GROUP) {
        Piece piece = piece_of(row);
        if (piece.kind == NOTHING) continue;
        atomicAdd(counts[piece.kind], 1u);
        if (word_color != NONE) {
            int text = int(number(word_color, row));
            if (text >= 0) counts[kinds_known + 1u + uint(text)] = 1u;
        }
        if (piece.unset) counts[kinds_known] = 1u;
        vec3 low = of_kind(piece.kind, 0u);
        vec3 high = of_kind(piece.kind, 3u);
        mat3 axes = mat3(piece.axes);
        vec3 center = vec3(piece.place) + axes * ((low + high) / 2.0);
        vec3 reach = (high - low) / 2.0;
        for (uint each = 0u; each < DIRECTIONS; each++) {
            vec3 way = directions[each];
            float along = dot(center, way);
            float span = dot(abs(way * axes), reach);
            if (which[2u * each] == NONE || along + span > most[2u * each]) {
                most[2u * each] = along + span;
                which[2u * each] = row;
            }
            if (which[2u * each + 1u] == NONE || span - along > most[2u * each + 1u]) {
                most[2u * each + 1u] = span - along;
                which[2u * each + 1u] = row;
            }
        }
    }
    for (uint each = 0u; each < 2u * DIRECTIONS; each++) {
        uint at = gl_GlobalInvocationID.x * 2u * DIRECTIONS + each;
        reaches[at] = vec4(0.0);
        if (which[each] == NONE) continue;
        Piece piece = piece_of(which[each]);
        vec3 way = directions[each / 2u] * ((each & 1u) == 0u ? 1.0 : -1.0);
        mat3 axes = mat3(piece.axes);
        vec3 high = of_kind(piece.kind, 3u);
        vec3 low = of_kind(piece.kind, 0u);
        vec3 corner = mix(low, high, greaterThan(way * axes, vec3(0.0)));
        reaches[at] = vec4(vec3(piece.place) + axes * corner, 1.0);
    }
}
