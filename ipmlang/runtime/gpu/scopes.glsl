// Scopes that their geometry fills: parts of them, faces, extents.

// Of each described geometry 16 numbers: 1 if it fills its scope, 3 if its faces bear tags, then
// the numbers of what a cut across each axis makes of it: 1 where it begins later, 2 ends earlier.

bool fills(double geometry) {
    return geometry >= 1.0lf && geometry < double(geometries)
        && data[geometry_base + uint(geometry) * 16u] > 0.0lf;
}

double cut_geometry(double geometry, uint axis, bool begins, bool ends) {
    uint place = geometry_base + uint(geometry) * 16u;
    return data[place + 1u + axis * 4u + (begins ? 2u : 0u) + (ends ? 1u : 0u)];
}

// The scope's extents and geometry, while an instruction runs; what it makes of them is kept after
// it, once for all instructions.
dvec3 extents;
double geometry;
bool reshaped;

double extent_of(uint axis) {
    return axis == 0u ? extents.x : axis == 1u ? extents.y : extents.z;
}

uint flat_axis() {  // 0: none, 1 to 3: that axis has no extent, 4: more than one has none
    uint found = 0u;
    for (uint axis = 0u; axis < 3u; axis++)
        if (extents[axis] <= 0.0lf) found = found == 0u ? axis + 1u : 4u;
    return found;
}

bool slab(uint axis, double low, double size) {
    double extent = extent_of(axis);
    if (!fills(geometry)) {
        trouble(TROUBLE_GEOMETRY);
        return false;
    }
    if (!(size > 1e-9lf * extent)) {
        if (shown && !is_finite(size)) trouble(TROUBLE_NOT_FINITE);
        if (shown) atomicAdd(counts[COUNT_NOTES + (rule == NONE ? productions : rule)], 1u);
        return false;
    }
    bool begins = low > 1e-9lf * extent;
    bool ends = low + size < extent * (1.0lf - 1e-9lf);
    geometry = cut_geometry(geometry, axis, begins, ends);
    go_by(dvec3(axis == 0u ? low : 0.0lf, axis == 1u ? low : 0.0lf, axis == 2u ? low : 0.0lf));
    if (axis == 0u) extents.x = size;
    else if (axis == 1u) extents.y = size;
    else extents.z = size;
    reshaped = true;
    return true;
}

void resize(dvec3 size) {
    if (!(size.x >= 0.0lf && size.y >= 0.0lf && size.z >= 0.0lf)) {
        trouble(TROUBLE_EXTENT);
        return;
    }
    extents = size;
    reshaped = true;
    if (size.z != 0.0lf && geometry != 0.0lf && !fills(geometry)) trouble(TROUBLE_GEOMETRY);
}

double measured(uint what) {
    double sx = extents.x, sy = extents.y, sz = extents.z;
    if (geometry == 0.0lf) return 0.0lf;
    if (geometry > 1.0lf) {  // its tags may make it anything
        trouble(TROUBLE_GEOMETRY);
        return 0.0lf;
    }
    bool solid = sx > 0.0lf && sy > 0.0lf && sz > 0.0lf;
    if (what == 1u) return sx * sy * sz;
    if (what == 2u) return solid ? 24.0lf : 4.0lf;
    precise double once = sx * sy + sy * sz + sx * sz;
    return solid ? 2.0lf * once : once;
}

void extrude(double height, double made) {
    bool rectangle = extents.z <= 0.0lf && extents.x > 0.0lf && extents.y > 0.0lf;
    if (!rectangle || !fills(geometry) || !is_finite(height) || height == 0.0lf) {
        trouble(TROUBLE_GEOMETRY);
        return;
    }
    if (height < 0.0lf) go_by(dvec3(0.0lf, 0.0lf, height));
    extents.z = abs(height);
    geometry = made;
    reshaped = true;
}

// The faces of a box that a part takes: for each geometry and flat axis 13 numbers, how many they
// are, which, and their geometries.

uint faces_of(uint table) {
    if (!fills(geometry)) {
        trouble(TROUBLE_GEOMETRY);
        return 0u;
    }
    return code[table] + (uint(geometry) * 4u + flat_axis()) * 13u;
}

double face_count(uint table) {
    if (flat_axis() == 4u) return 0.0lf;
    uint place = faces_of(table);
    return given_up ? 0.0lf : data[place];
}

void face(uint table, double number) {
    uint place = faces_of(table);
    if (given_up) return;
    uint which = uint(data[place + 1u + uint(number)]);
    double sx = extents.x, sy = extents.y, sz = extents.z;
    double half_root = sqrt(0.5lf);
    Turn q;
    dvec3 corner = dvec3(0.0lf);
    dvec2 size;
    if (which == 0u) {
        q = Turn(0.0lf, 1.0lf, 0.0lf, 0.0lf);
        corner.y = sy;
        size = dvec2(sx, sy);
    } else if (which == 1u) {
        q = Turn(1.0lf, 0.0lf, 0.0lf, 0.0lf);
        corner.z = sz;
        size = dvec2(sx, sy);
    } else if (which == 2u) {
        q = Turn(half_root, half_root, 0.0lf, 0.0lf);
        size = dvec2(sx, sz);
    } else if (which == 3u) {
        q = Turn(0.5lf, 0.5lf, 0.5lf, 0.5lf);
        corner.x = sx;
        size = dvec2(sy, sz);
    } else if (which == 4u) {
        q = Turn(0.0lf, 0.0lf, half_root, half_root);
        corner.x = sx;
        corner.y = sy;
        size = dvec2(sx, sz);
    } else {
        q = Turn(0.5lf, 0.5lf, -0.5lf, -0.5lf);
        corner.y = sy;
        size = dvec2(sy, sz);
    }
    go_by(corner);
    spin_by(q);
    extents = dvec3(size, 0.0lf);
    geometry = data[place + 7u + uint(number)];
    reshaped = true;
}

// To the point of the scope's box that has these shares of it, or back from there.
void center(uint share, bool back) {
    dvec3 by = extents * dvec3(data[share], data[share + 1u], data[share + 2u]);
    go_by(back ? -by : by);
}

// Mirrored within itself along an axis, but for the handedness, which changes after it.
void flip(uint axis) {
    double extent = extent_of(axis);
    go_by(dvec3(axis == 0u ? extent : 0.0lf, axis == 1u ? extent : 0.0lf,
                  axis == 2u ? extent : 0.0lf));
    spin_by(axis == 0u ? Turn(1.0lf, 0.0lf, 0.0lf, 0.0lf)
            : axis == 1u ? Turn(0.0lf, 0.0lf, 0.0lf, 1.0lf)
                         : Turn(0.0lf, 0.0lf, 1.0lf, 0.0lf));
}
