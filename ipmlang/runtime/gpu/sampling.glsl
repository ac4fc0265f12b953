// Contexts: pictures and fields over a rectangle of the ground, bit for bit as numpy samples them.
//
// No texture of the card: those interpolate by 8 bits of the distance, and what is fetched may
// decide. In the data stand left, bottom, width, height, columns, rows, 1 where single texels are
// given, and from TEXELS on what the texels stand for, the lowest row first.

const uint TEXELS = 7u;

// The texel, from 0 to count - 1, at or before a place along one axis, with the part of the way to
// the next one.
dvec2 texel_before(double place, double begin, double extent, double count, bool nearest) {
    precise double spread = (place - begin) * count;
    precise double texels = quotient(spread, extent);
    if (!nearest) texels -= 0.5lf;
    if (texels < 0.0lf) texels = 0.0lf;
    if (texels > count - 1.0lf) texels = count - 1.0lf;
    double first = whole_below(texels);
    precise double part = texels - first;
    return dvec2(first, part);
}

double texel_between(double first, double second, double part) {
    precise double value = first + (second - first) * part;
    return value;
}

double sampled(uint at, double x, double y) {
    if (is_nan(x) || is_nan(y)) return no_number();
    double across = data[at + 4u], down = data[at + 5u];
    bool nearest = data[at + 6u] != 0.0lf;
    dvec2 column = texel_before(x, data[at], data[at + 2u], across, nearest);
    dvec2 row = texel_before(y, data[at + 1u], data[at + 3u], down, nearest);
    uint width = to_word(across);
    uint lower = at + TEXELS + to_word(row.x) * width + to_word(column.x);
    if (nearest) return data[lower];
    uint right = column.x < across - 1.0lf ? 1u : 0u;
    uint upper = row.x < down - 1.0lf ? lower + width : lower;
    return texel_between(
        texel_between(data[lower], data[lower + right], column.y),
        texel_between(data[upper], data[upper + right], column.y), row.y);
}
