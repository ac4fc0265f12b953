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

// What an instruction does to the frame is done once, after it: these functions are long, and a
// compiler writes them out wherever they are called.

dvec3 step;     // along the local axes
Turn spin;      // in the local frame
double angle;   // in degrees, of which the circle is needed
uint spin_axis; // of a spin by that angle; 3: the spin is known
bool moves;
bool spins;
bool circles;

void go_by(dvec3 by) {
    step = by;
    moves = true;
    if (planar != 0u) {
        angle = r[2];
        circles = true;
    }
}

void spin_by(Turn q) {
    spin = q;
    spin_axis = 3u;
    spins = true;
}

void rotate_by(uint its_axis, double degrees) {
    if (planar != 0u) {
        r[2] += degrees * hand();
        return;
    }
    spin_axis = its_axis;
    angle = degrees * 0.5lf;
    spins = true;
    circles = true;
}

void orient_by(double w, double x, double y, double z) {
    double size = square_root(w * w + x * x + y * y + z * z);
    spin_by(Turn(w / size, x / size, y / size, z / size));
}

void level() {  // rolled about the heading until the left is horizontal
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
    rotate_by(0u, function_atan2(wx * up.x + wy * up.y, wx * left.x + wy * left.y));
}

void move_and_spin() {
    dvec2 unit = dvec2(1.0lf, 0.0lf);
    if (circles) unit = on_circle(angle);
    double side = hand();
    if (moves) {
        double scale = scale_factor();
        double size = scale * side;
        dvec3 by = dvec3(step.x * scale, step.y * size, step.z * size);
        if (planar != 0u) {
            r[0] += by.x * unit.x - by.y * unit.y;
            r[1] += by.x * unit.y + by.y * unit.x;
        } else {
            by = turned(rotation(), by);
            r[0] += by.x;
            r[1] += by.y;
            r[2] += by.z;
        }
    }
    if (spins) {  // a mirrored frame turns about y and z the other way
        if (spin_axis < 3u)
            spin = Turn(unit.x, spin_axis == 0u ? unit.y : 0.0lf,
                        spin_axis == 1u ? unit.y : 0.0lf, spin_axis == 2u ? unit.y : 0.0lf);
        set_rotation(product(rotation(), Turn(spin.w, spin.x, spin.y * side, spin.z * side)));
    }
}
