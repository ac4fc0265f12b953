// The frame of a turtle or of a scope: how moves and turns change it.

struct Turn { double w; double x; double y; double z; };

Turn product(Turn a, Turn b) {
    return Turn(
        a.w * b.w - a.x * b.x - a.y * b.y - a.z * b.z,
        a.w * b.x + a.x * b.w + a.y * b.z - a.z * b.y,
        a.w * b.y - a.x * b.z + a.y * b.w + a.z * b.x,
        a.w * b.z + a.x * b.y - a.y * b.x + a.z * b.w);
}

dvec3 turned(Turn q, dvec3 v) {
    double tx = 2.0lf * (q.y * v.z - q.z * v.y);
    double ty = 2.0lf * (q.z * v.x - q.x * v.z);
    double tz = 2.0lf * (q.x * v.y - q.y * v.x);
    return dvec3(
        v.x + q.w * tx + (q.y * tz - q.z * ty),
        v.y + q.w * ty + (q.z * tx - q.x * tz),
        v.z + q.w * tz + (q.x * ty - q.y * tx));
}

Turn rotation() { return Turn(r[3], r[4], r[5], r[6]); }

void set_rotation(Turn q) {
    r[3] = q.w;
    r[4] = q.x;
    r[5] = q.y;
    r[6] = q.z;
}

double scale_factor() { return slot_scale == NONE ? 1.0lf : r[slot_scale]; }

double hand() { return mirrors == 0u || scale_factor() >= 0.0lf ? 1.0lf : -1.0lf; }

void move_by(dvec3 step) {
    double scale = scale_factor();
    double size = scale * hand();
    step = dvec3(step.x * scale, step.y * size, step.z * size);
    if (planar != 0u) {
        dvec2 unit = on_circle(r[2]);
        r[0] += step.x * unit.x - step.y * unit.y;
        r[1] += step.x * unit.y + step.y * unit.x;
        return;
    }
    dvec3 by = turned(rotation(), step);
    r[0] += by.x;
    r[1] += by.y;
    r[2] += by.z;
}

void turn_by(Turn q) {  // in the local frame; a mirrored one turns about y and z the other way
    double side = hand();
    set_rotation(product(rotation(), Turn(q.w, q.x, q.y * side, q.z * side)));
}

void rotate_by(uint axis, double degrees) {
    if (planar != 0u) {
        r[2] += degrees * hand();
        return;
    }
    dvec2 unit = on_circle(degrees * 0.5lf);
    turn_by(Turn(unit.x, axis == 0u ? unit.y : 0.0lf, axis == 1u ? unit.y : 0.0lf,
                 axis == 2u ? unit.y : 0.0lf));
}

void orient_by(double w, double x, double y, double z) {
    double size = sqrt(w * w + x * x + y * y + z * z);
    turn_by(Turn(w / size, x / size, y / size, z / size));
}

void level() {
    if (planar != 0u) return;
    Turn q = rotation();
    double side = hand();
    dvec3 heading = turned(q, dvec3(side, 0.0lf, 0.0lf));
    double size = sqrt(heading.x * heading.x + heading.y * heading.y);
    if (size <= 1e-12lf) return;
    dvec3 left = turned(q, dvec3(0.0lf, 1.0lf, 0.0lf));
    dvec3 up = turned(q, dvec3(0.0lf, 0.0lf, 1.0lf));
    double wx = -heading.y / size * side;
    double wy = heading.x / size * side;
    double angle = function_atan2(wx * up.x + wy * up.y, wx * left.x + wy * left.y);
    dvec2 unit = on_circle(angle * 0.5lf);
    set_rotation(product(q, Turn(unit.x, unit.y, 0.0lf, 0.0lf)));
}
