// Sines, arcs, logarithms and powers of doubles, which GLSL has for floats only.
//
// Each is within about one ulp of the true value. Polynomials named fdlibm have the coefficients
// of Sun Microsystems' "Freely Distributable LIBM" (1993); the others are plain series. Angles are
// radians here.

const double HALF_PI_HIGH = 1.57079632679489655800lf;
const double HALF_PI_LOW = 6.12323399573676603587e-17lf;
const double LN_2_HIGH = 6.93147180369123816490e-01lf;  // 32 bits: its multiples are exact
const double LN_2_LOW = 1.90821492927058770002e-10lf;
const double INVERSE_LN_2 = 1.44269504088896338700lf;

// ---- products in two numbers, the rounded one and the rest ----------------------------------

// The product of two such pairs.
dvec2 pair_product(dvec2 a, dvec2 b) {
    precise double p = a.x * b.x;
    precise double rest = product_rest(a.x, b.x, p) + (a.x * b.y + a.y * b.x);
    return two_sum(p, rest);
}

// The sum of two pairs; |a| >= |b|.
dvec2 pair_sum(dvec2 a, dvec2 b) {
    dvec2 total = two_sum(a.x, b.x);
    precise double rest = total.y + (a.y + b.y);
    return two_sum(total.x, rest);
}

// ---- sines and arcs -------------------------------------------------------------------------

// The sine for |a| <= pi / 4 (fdlibm).
double sine_near_0(double a) {
    precise double z = a * a;
    precise double rest = 1.58969099521155010221e-10lf;
    rest = -2.50507602534068634195e-08lf + z * rest;
    rest = 2.75573137070700676789e-06lf + z * rest;
    rest = -1.98412698298579493134e-04lf + z * rest;
    rest = 8.33333333332248946124e-03lf + z * rest;
    rest = -1.66666666666666324348e-01lf + z * rest;
    precise double found = a + (z * a) * rest;
    return found;
}

// The cosine for |a| <= pi / 4 (fdlibm): 1 - a * a / 2 in two numbers, and the rest.
double cosine_near_0(double a) {
    precise double z = a * a;
    precise double rest = -1.13596475577881948265e-11lf;
    rest = 2.08757232129817482790e-09lf + z * rest;
    rest = -2.75573143513906633035e-07lf + z * rest;
    rest = 2.48015872894767294178e-05lf + z * rest;
    rest = -1.38888888888741095749e-03lf + z * rest;
    rest = 4.16666666666666019037e-02lf + z * rest;
    precise double half_square = 0.5lf * z;
    precise double most = 1.0lf - half_square;
    precise double found = most + (((1.0lf - most) - half_square) + z * (z * rest));
    return found;
}

// (arcsin(a) - a) / a for a * a = z <= 1/4 (fdlibm).
double arc_rest(double z) {
    precise double p = 3.47933107596021167570e-05lf;
    p = 7.91534994289814532176e-04lf + z * p;
    p = -4.00555345006794114027e-02lf + z * p;
    p = 2.01212532134862925881e-01lf + z * p;
    p = -3.25565818622400915405e-01lf + z * p;
    p = 1.66666666666666657415e-01lf + z * p;
    precise double q = 7.70381505559019352791e-02lf;
    q = -6.88283971605453293030e-01lf + z * q;
    q = 2.02094576023350569471e+00lf + z * q;
    q = -2.40339491173441421878e+00lf + z * q;
    precise double found = (z * p) / (1.0lf + z * q);
    return found;
}

// Half the arc cosine of 1/2 <= a <= 1 in two numbers: the arc sine of sqrt((1 - a) / 2). The
// root is taken with its rest.
dvec2 half_arc_cosine(double a) {
    precise double z = 0.5lf * (1.0lf - a);
    if (z <= 0.0lf) return dvec2(0.0lf);
    precise double s = sqrt(z);
    precise double rest = 0.5lf * quotient_rest(z, s, s) / s;
    precise double low = rest + s * arc_rest(z);
    return two_sum(s, low);
}

double arc_sine(double a) {
    double size = magnitude(a);
    if (!(size <= 1.0lf)) return no_number();
    precise double near = a + a * arc_rest(a * a);
    if (size < 0.5lf) return near;
    dvec2 arc = half_arc_cosine(size);
    precise double far = (HALF_PI_HIGH - 2.0lf * arc.x) - (2.0lf * arc.y - HALF_PI_LOW);
    return with_sign_of(far, a);
}

double arc_cosine(double a) {
    double size = magnitude(a);
    if (!(size <= 1.0lf)) return no_number();
    precise double near = HALF_PI_HIGH - (a - (HALF_PI_LOW - a * arc_rest(a * a)));
    if (size < 0.5lf) return near;
    dvec2 arc = half_arc_cosine(size);
    precise double left = (HALF_PI_HIGH - arc.x) - (arc.y - HALF_PI_LOW);
    return 2.0lf * (is_negative(a) ? left : arc.x + arc.y);
}

// The arc tangent of y / x for y, x >= 0, not both 0 and not both infinite (fdlibm): the quotient
// is turned by an arc that is known in two numbers, so that what is left is small.
double arc_of_quotient(double y, double x) {
    precise double t = y / x;
    dvec2 turn = dvec2(0.0lf);
    precise double above = t;
    precise double below = 1.0lf;
    if (!(t < 2.4375lf)) {
        turn = dvec2(HALF_PI_HIGH, HALF_PI_LOW);
        above = -1.0lf;
        below = t;
    } else if (t >= 1.1875lf) {
        turn = dvec2(9.82793723247329054082e-01lf, 1.39033110312309984516e-17lf);  // of 3/2
        above = t - 1.5lf;
        below = 1.0lf + 1.5lf * t;
    } else if (t >= 0.6875lf) {
        turn = dvec2(7.85398163397448278999e-01lf, 3.06161699786838301793e-17lf);  // of 1
        above = t - 1.0lf;
        below = t + 1.0lf;
    } else if (t >= 0.4375lf) {
        turn = dvec2(4.63647609000806093515e-01lf, 2.26987774529616870924e-17lf);  // of 1/2
        above = 2.0lf * t - 1.0lf;
        below = 2.0lf + t;
    }
    precise double a = above / below;
    precise double z = a * a;
    precise double w = z * z;
    precise double even = 1.62858201153657823623e-02lf;
    even = 4.97687799461593236017e-02lf + w * even;
    even = 6.66107313738753120669e-02lf + w * even;
    even = 9.09088713343650656196e-02lf + w * even;
    even = 1.42857142725034663711e-01lf + w * even;
    even = 3.33333333333329318027e-01lf + w * even;
    precise double odd = -3.65315727442169155270e-02lf;
    odd = -5.83357013379057348645e-02lf + w * odd;
    odd = -7.69187620504482999495e-02lf + w * odd;
    odd = -1.11111104054623557880e-01lf + w * odd;
    odd = -1.99999999998764832476e-01lf + w * odd;
    precise double found = turn.x - ((a * (z * even + w * odd) - turn.y) - a);
    return found;
}

double arc_tangent(double a) {
    return is_nan(a) ? a : with_sign_of(arc_of_quotient(magnitude(a), 1.0lf), a);
}

// The angle of the point (x, y), with C's signs for zeros and infinite numbers.
double arc_of_point(double y, double x) {
    if (is_nan(y) || is_nan(x)) return no_number();
    double up = magnitude(y);
    double along = magnitude(x);
    if (!is_finite(y) && !is_finite(x)) up = along = 1.0lf;
    double angle = holds(up) ? arc_of_quotient(up, along) : 0.0lf;
    precise double turned = 2.0lf * HALF_PI_HIGH - (angle - 2.0lf * HALF_PI_LOW);
    return with_sign_of(is_negative(x) ? turned : angle, y);
}

// ---- exponentials and logarithms ------------------------------------------------------------

// e to the power of a + rest, |rest| small against |a|. With a = k ln 2 + r and |r| <= ln 2 / 2
// it is 2^k times 1 + r + r^2 / 2 + ... + r^13 / 13!, whose next term is below 2^-57.
double exponential_of(double a, double rest) {
    if (is_nan(a)) return a;
    if (a > 709.79lf) return infinity();
    if (a < -745.2lf) return 0.0lf;
    double k = nearest_even(a * INVERSE_LN_2);
    precise double high = a - k * LN_2_HIGH;
    dvec2 r = two_sum(high, rest - k * LN_2_LOW);
    precise double sum = 1.0lf / 6227020800.0lf;
    sum = 1.0lf / 479001600.0lf + r.x * sum;
    sum = 1.0lf / 39916800.0lf + r.x * sum;
    sum = 1.0lf / 3628800.0lf + r.x * sum;
    sum = 1.0lf / 362880.0lf + r.x * sum;
    sum = 1.0lf / 40320.0lf + r.x * sum;
    sum = 1.0lf / 5040.0lf + r.x * sum;
    sum = 1.0lf / 720.0lf + r.x * sum;
    sum = 1.0lf / 120.0lf + r.x * sum;
    sum = 1.0lf / 24.0lf + r.x * sum;
    sum = 1.0lf / 6.0lf + r.x * sum;
    sum = 0.5lf + r.x * sum;
    dvec2 most = two_sum(1.0lf, r.x);
    precise double all = most.x + (most.y + (r.y * (1.0lf + r.x) + (r.x * r.x) * sum));
    return scaled(all, int(k));
}

// The natural logarithm of a finite number above 0, in two numbers with about 65 bits. With
// a = 2^k m and sqrt(1/2) <= m < sqrt(2), and s = (m - 1) / (m + 1), it is k ln 2 and twice
// s + s^3 / 3 + s^5 / 5 + ..., whose terms beyond s^25 are below 2^-66 s.
dvec2 logarithm_pair(double a) {
    int e;
    double m = normalised(a, e);
    if (m >= 1.41421356237309514547lf) {
        m *= 0.5lf;
        e += 1;
    }
    precise double less = m - 1.0lf;
    dvec2 more = two_sum(1.0lf, m);
    if (m > 1.0lf) more = two_sum(m, 1.0lf);
    precise double quotient = less / more.x;
    precise double rest = (quotient_rest(less, quotient, more.x) - quotient * more.y) / more.x;
    dvec2 s = two_sum(quotient, rest);
    dvec2 z = pair_product(s, s);
    precise double sum = 1.0lf / 25.0lf;
    sum = 1.0lf / 23.0lf + z.x * sum;
    sum = 1.0lf / 21.0lf + z.x * sum;
    sum = 1.0lf / 19.0lf + z.x * sum;
    sum = 1.0lf / 17.0lf + z.x * sum;
    sum = 1.0lf / 15.0lf + z.x * sum;
    sum = 1.0lf / 13.0lf + z.x * sum;
    sum = 1.0lf / 11.0lf + z.x * sum;
    sum = 1.0lf / 9.0lf + z.x * sum;
    sum = 1.0lf / 7.0lf + z.x * sum;
    sum = 0.2lf + z.x * sum;
    precise double further = z.x * sum;
    dvec2 third = pair_sum(dvec2(1.0lf / 3.0lf, 1.850371707708594105e-17lf), dvec2(further, 0.0lf));
    dvec2 series = pair_sum(s, pair_product(pair_product(s, z), third));
    precise double k = double(e);
    precise dvec2 twice = 2.0lf * series;
    if (e == 0) return twice;
    precise double high = k * LN_2_HIGH;
    precise double low = k * LN_2_LOW;
    return pair_sum(two_sum(high, low), twice);
}

double logarithm_of(double a) {
    if (is_nan(a) || a <= 0.0lf) return no_number();
    if (!is_finite(a)) return a;
    return logarithm_pair(a).x;
}

// Whether a finite number is whole, and odd.
bool is_whole(double a) { return whole_below(a) == a; }

bool is_odd(double a) { return is_whole(a) && !is_whole(0.5lf * a); }

// a power of 0 or of an infinite number, or an infinite power; `grows`: the size goes to infinity.
double power_at_limits(double base, bool grows, bool odd) {
    double size = grows ? infinity() : 0.0lf;
    return odd && is_negative(base) ? -size : size;
}

// C's pow. An exponent beyond 2^64 gives what 2^64 gives: 0, 1 or an infinite number.
double power_of(double base, double exponent) {
    if (!holds(exponent) || base == 1.0lf) return 1.0lf;
    if (is_nan(base) || is_nan(exponent)) return no_number();
    double size = magnitude(base);
    bool finite = is_finite(exponent);
    bool odd = finite && is_odd(exponent);
    if (!finite && size == 1.0lf) return 1.0lf;
    if (!finite) return power_at_limits(base, (size > 1.0lf) != is_negative(exponent), false);
    if (!holds(base) || !is_finite(base))
        return power_at_limits(base, holds(base) != is_negative(exponent), odd);
    if (is_negative(base) && !is_whole(exponent)) return no_number();
    double most = 18446744073709551616.0lf;
    double times = clamp(exponent, -most, most);
    dvec2 log = logarithm_pair(size);
    precise double high = times * log.x;
    precise double low = product_rest(times, log.x, high) + times * log.y;
    double power = exponential_of(high, low);
    return odd && is_negative(base) ? -power : power;
}
