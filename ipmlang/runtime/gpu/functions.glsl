// The functions of the language, one for each record of the table: function_<name of the record>.
//
// Each gives what the record's numpy body gives: the same bits if the record is exact, else within
// a few ulp. What has no value is NaN; truth values are 1 and 0, and NaN where that hangs on a NaN;
// comparisons snap. Operands of angles are degrees. Here every function takes a fixed number of
// arguments: what a call leaves out, and lists of any length, are laid out by functions.py.

// ---- arithmetic ---------------------------------------------------------------------------

double function_add(double a, double b) {
    precise double found = a + b;
    return found;
}

double function_sub(double a, double b) {
    precise double found = a - b;
    return found;
}

double function_mul(double a, double b) {
    precise double found = a * b;
    return found;
}

double function_div(double a, double b) { return quotient(a, b); }

double function_neg(double a) { return -a; }

// ---- comparison ---------------------------------------------------------------------------

bool is_less(double a, double b) { return !is_nan(a) && !is_nan(b) && a < b && !same(a, b); }

bool is_at_most(double a, double b) { return !is_nan(a) && !is_nan(b) && (a < b || same(a, b)); }

// The truth value of a comparison of a and b: NaN beside a NaN.
double compared(bool found, double a, double b) {
    return is_nan(a) || is_nan(b) ? no_number() : truth(found);
}

double function_lt(double a, double b) { return compared(is_less(a, b), a, b); }

double function_le(double a, double b) { return compared(is_at_most(a, b), a, b); }

double function_gt(double a, double b) { return compared(is_less(b, a), a, b); }

double function_ge(double a, double b) { return compared(is_at_most(b, a), a, b); }

double function_eq(double a, double b) { return compared(same(a, b), a, b); }

double function_ne(double a, double b) { return compared(!same(a, b), a, b); }

double function_and(double a, double b) {
    return holds(a) && holds(b) ? compared(true, a, b) : 0.0lf;
}

double function_not(double a) { return compared(!holds(a), a, a); }

double function_or(double a, double b) {
    return function_not(function_and(function_not(a), function_not(b)));
}

double function_select(double condition, double value, double other) {
    if (is_nan(condition)) return no_number();
    return holds(condition) ? value : other;
}

// ---- numbers ------------------------------------------------------------------------------

double function_min(double a, double b) {
    if (is_nan(a) || is_nan(b)) return no_number();
    return without_signed_zero(a < b ? a : b);
}

double function_max(double a, double b) {
    if (is_nan(a) || is_nan(b)) return no_number();
    return without_signed_zero(a > b ? a : b);
}

double function_abs(double a) { return magnitude(a); }

double function_sign(double a) {
    if (is_nan(a) || !holds(a)) return without_signed_zero(a);
    return is_negative(a) ? -1.0lf : 1.0lf;
}

double function_floor(double a) {
    double near = nearest_even(a);
    return without_signed_zero(same(a, near) ? near : whole_below(a));
}

double function_ceil(double a) { return without_signed_zero(-function_floor(-a)); }

double function_round(double a) {
    precise double half_up = magnitude(a) + 0.5lf;
    return without_signed_zero(with_sign_of(function_floor(half_up), a));
}

// numpy's mod, which has the sign of b, for finite a.
double plain_mod(double a, double b) {
    if (is_nan(b) || !holds(b)) return no_number();
    double rest = is_finite(b) ? remainder_of(a, b) : a;
    precise double other = rest + b;
    return holds(rest) && is_negative(rest) != is_negative(b) ? other : rest;
}

double function_mod(double a, double b) {
    if (!is_finite(a)) return no_number();
    precise double whole = nearest_even(quotient(a, b)) * b;
    return same(a, whole) ? 0.0lf : without_signed_zero(plain_mod(a, b));
}

double function_clamp(double a, double low, double high) {
    return function_min(function_max(a, low), high);
}

double function_lerp(double a, double b, double t) {
    precise double found = a + (b - a) * t;
    return found;
}

double function_tiles(double length, double size) {
    if (!(length > 0.0lf && size > 0.0lf)) {
        double both = length + size;  // compilers make 0 of 0 * NaN
        return is_finite(both) ? with_sign_of(0.0lf, both) : no_number();
    }
    double least = function_max(function_floor(quotient(length, size)), 1.0lf);
    precise double above = least + 1.0lf;
    precise double middle = (quotient(length, least) + quotient(length, above)) * 0.5lf;
    return is_less(size, middle) ? above : least;
}

double function_sqrt(double a) { return square_root(a); }

// ---- trigonometry, powers -------------------------------------------------------------------

const double RADIAN = 0.017453292519943295lf;
const double DEGREE = 57.29577951308232lf;

// The cosine and sine of degrees: a remainder from -45 to 45 and quarters of a turn, which are
// exact.
dvec2 on_circle(double degrees) {
    if (!is_finite(degrees)) return dvec2(no_number());
    double turn = remainder_of(degrees, 360.0lf);
    double count = nearest_even(turn / 90.0lf);
    precise double rest = (turn - 90.0lf * count) * RADIAN;
    dvec2 place = dvec2(cosine_near_0(rest), sine_near_0(rest));
    int quarter = int(count) & 3;
    if ((quarter & 1) != 0) place = dvec2(-place.y, place.x);
    if ((quarter & 2) != 0) place = -place;
    return dvec2(without_signed_zero(place.x), without_signed_zero(place.y));
}

double function_sin(double a) { return on_circle(a).y; }

double function_cos(double a) { return on_circle(a).x; }

double function_tan(double a) {
    dvec2 place = on_circle(a);
    return quotient(place.y, place.x);
}

double function_asin(double a) { return arc_sine(a) * DEGREE; }

double function_acos(double a) { return arc_cosine(a) * DEGREE; }

double function_atan(double a) { return arc_tangent(a) * DEGREE; }

double function_atan2(double y, double x) { return arc_of_point(y, x) * DEGREE; }

double function_pow(double a, double b) { return power_of(a, b); }

double function_exp(double a) { return exponential_of(a, 0.0lf); }

double function_log(double a) { return logarithm_of(a); }

// ---- noise ----------------------------------------------------------------------------------

// A whole number modulo 2^32, as a word; all steps are exact.
uint lattice_word(double a) {
    precise double turns = whole_below(a * 2.3283064365386962890625e-10lf);  // 2^-32
    precise double rest = a - turns * 4294967296.0lf;
    return to_word(rest);
}

// A number from -1 to 1 for a point of the integer lattice.
double lattice_number(dvec3 place) {
    uvec3 words = uvec3(lattice_word(place.x), lattice_word(place.y), lattice_word(place.z));
    precise double found = from_word(pcg3d(words).x >> 8u) * 1.1920928955078125e-7lf - 1.0lf;
    return found;
}

double eased(double t) {
    precise double found = t * t * t * (t * (t * 6.0lf - 15.0lf) + 10.0lf);
    return found;
}

double function_noise(double x, double y, double z) {
    if (!is_finite(x) || !is_finite(y) || !is_finite(z)) return no_number();
    dvec3 cell = dvec3(whole_below(x), whole_below(y), whole_below(z));
    precise dvec3 rest = dvec3(x, y, z) - cell;
    dvec3 ease = dvec3(eased(rest.x), eased(rest.y), eased(rest.z));
    precise double total = 0.0lf;
    for (uint corner = 0u; corner < 8u; ++corner) {
        bvec3 far = bvec3((corner & 1u) != 0u, (corner & 2u) != 0u, (corner & 4u) != 0u);
        precise dvec3 near = 1.0lf - ease;
        precise dvec3 place = cell;
        precise dvec3 shares = near;
        if (far.x) { place.x += 1.0lf; shares.x = ease.x; }
        if (far.y) { place.y += 1.0lf; shares.y = ease.y; }
        if (far.z) { place.z += 1.0lf; shares.z = ease.z; }
        precise double share = shares.x * shares.y * shares.z;
        total += share * lattice_number(place);
    }
    return total;
}

// ---- draws: u is the uniform of the call's site ----------------------------------------------

double function_rand(double u, double low, double high) {
    precise double found = low + (high - low) * u;
    return found;
}

double function_irand(double u, double low, double high) {
    double first = function_ceil(low);
    double last = function_floor(high);
    precise double range = last - first;
    if (!is_finite(range) || !(last >= first)) return no_number();
    precise double steps = u * (range + 1.0lf);
    precise double drawn = first + whole_below(steps);
    return drawn < last ? drawn : last;
}

// One of `count` values, four at a time: the one drawn if it is `a`, which has the number `start`,
// or one of the three after it; else `other`.
double function_pick(
    double u, double count, double start, double other, double a, double b, double c, double d
) {
    precise double steps = u * count;
    precise double place = whole_below(steps) - start;
    if (place == 0.0lf) return a;
    if (place == 1.0lf) return b;
    if (place == 2.0lf) return c;
    return place == 3.0lf ? d : other;
}

// Wichura, Algorithm AS 241 (1988), PPND7: the normal quantile to about 7 digits.
double normal_middle(double offset) {
    precise double r = 0.180625lf - offset * offset;
    precise double p = ((59.109374720lf * r + 159.29113202lf) * r + 50.434271938lf) * r;
    precise double q = ((67.187563600lf * r + 78.757757664lf) * r + 17.895169469lf) * r;
    precise double found = offset * ((p + 3.3871327179lf) / (q + 1.0lf));
    return found;
}

double normal_tail(double depth) {
    precise double r = depth - (depth <= 5.0lf ? 1.6lf : 5.0lf);
    precise double p = 0.017337203997lf;
    precise double q = 0.012258202635lf;
    if (depth <= 5.0lf) {
        p = ((0.17023821103lf * r + 1.3067284816lf) * r + 2.7568153900lf) * r + 1.4234372777lf;
        q = (0.12021132975lf * r + 0.73700164250lf) * r + 1.0lf;
    } else {
        p = ((p * r + 0.42868294337lf) * r + 3.0812263860lf) * r + 6.6579051150lf;
        q = (q * r + 0.24197894225lf) * r + 1.0lf;
    }
    precise double found = p / q;
    return found;
}

double function_gauss(double u, double mean, double deviation) {
    precise double middle = u + 2.98023223876953125e-8lf;  // half a step of u: never 0 or 1
    precise double offset = middle - 0.5lf;
    precise double edge = middle < 1.0lf - middle ? middle : 1.0lf - middle;
    double value = normal_middle(offset);
    if (!(magnitude(offset) <= 0.425lf)) {
        double tail = normal_tail(sqrt(-logarithm_of(edge)));
        value = with_sign_of(tail, offset);
    }
    precise double found = mean + deviation * value;
    return found;
}
