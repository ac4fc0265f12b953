// Numbers by their bits, random words, and arithmetic that is right to the last bit.
//
// GLSL promises correctly rounded sums and products of doubles, but neither quotients nor square
// roots, and it lets a compiler assume that no NaN exists. So what has to agree with numpy bit for
// bit goes by bits, by sums and by products alone, all `precise`: no fused or reordered steps.
// `fma` is of no use: some drivers compute it as a product and a sum.
//
// Not covered: results or operands below 2^-1022 in size where a driver flushes them to zero, and
// the last bit of quotients that are below 2^-1020 or above 2^1020.

#ifndef FIRST_QUOTIENT
#define FIRST_QUOTIENT(a, b) ((a) / (b))
#endif
#ifndef FIRST_ROOT
#define FIRST_ROOT(a) sqrt(a)
#endif

const double SNAP = 1e-9lf;
const double TWO_52 = 4503599627370496.0lf;
const double ULP_OF_ONE = 2.220446049250313080847e-16lf;  // 2^-52
const uint SIGN_BIT = 0x80000000u;
const uint EXPONENT_BITS = 0x7FF00000u;

// ---- bits ---------------------------------------------------------------------------------

double from_words(uint high, uint low) { return packDouble2x32(uvec2(low, high)); }

uint high_word(double a) { return unpackDouble2x32(a).y; }

double no_number() { return from_words(0x7FF80000u, 0u); }

double infinity() { return from_words(EXPONENT_BITS, 0u); }

bool is_nan(double a) {
    uvec2 words = unpackDouble2x32(a);
    uint high = words.y & ~SIGN_BIT;
    return high > EXPONENT_BITS || (high == EXPONENT_BITS && words.x != 0u);
}

bool is_finite(double a) { return (high_word(a) & EXPONENT_BITS) != EXPONENT_BITS; }

// Finite, and neither zero nor below 2^-1022.
bool is_ordinary(double a) {
    uint field = high_word(a) & EXPONENT_BITS;
    return field != EXPONENT_BITS && field != 0u;
}

// All but the two zeros; NaN too, as for numpy.
bool holds(double a) {
    uvec2 words = unpackDouble2x32(a);
    return ((words.y & ~SIGN_BIT) | words.x) != 0u;
}

bool is_negative(double a) { return (high_word(a) & SIGN_BIT) != 0u; }

double truth(bool found) { return found ? 1.0lf : 0.0lf; }

double magnitude(double a) {
    uvec2 words = unpackDouble2x32(a);
    return from_words(words.y & ~SIGN_BIT, words.x);
}

double with_sign_of(double a, double other) {
    uvec2 words = unpackDouble2x32(a);
    return from_words((words.y & ~SIGN_BIT) | (high_word(other) & SIGN_BIT), words.x);
}

// numpy's `a + 0.0`: no zero has a sign.
double without_signed_zero(double a) { return holds(a) ? a : 0.0lf; }

// The exponent of an ordinary number: |a| = m * 2^e with 1 <= m < 2.
int exponent_of(double a) { return int((high_word(a) & EXPONENT_BITS) >> 20) - 1023; }

// An ordinary number with another exponent; its sign stays.
double with_exponent(double a, int exponent) {
    uvec2 words = unpackDouble2x32(a);
    return from_words((words.y & ~EXPONENT_BITS) | (uint(exponent + 1023) << 20), words.x);
}

// 2^e for e from -1022 to 1023.
double power_of_two(int e) { return from_words(uint(e + 1023) << 20, 0u); }

// a * 2^e for e from -2000 to 2000, rounded once if a is between 2^-20 and 2^20.
double scaled(double a, int e) {
    int first = e / 2;
    precise double part = a * power_of_two(first);
    precise double all = part * power_of_two(e - first);
    return all;
}

// ---- random words -------------------------------------------------------------------------

// Jarzynski and Olano, "Hash Functions for GPU Rendering" (2020): three words to three words.
uvec3 pcg3d(uvec3 words) {
    words = words * 1664525u + 1013904223u;
    words.x += words.y * words.z;
    words.y += words.z * words.x;
    words.z += words.x * words.y;
    words ^= words >> 16u;
    words.x += words.y * words.z;
    words.y += words.z * words.x;
    words.z += words.x * words.y;
    return words;
}

// The key with one word mixed in: a child's site, or the number of a repeat's copy.
uvec2 mixed(uvec2 key, uint word) { return pcg3d(uvec3(key, word)).xy; }

// A word as a number, and a whole number from 0 to 2^32 - 1 as a word; conversions are slow, or
// go by way of 32-bit floats, in some drivers.
double from_word(uint word) {
    precise double number = from_words(0x43300000u, word) - TWO_52;
    return number;
}

uint to_word(double a) {
    precise double shifted = a + TWO_52;
    return unpackDouble2x32(shifted).x;
}

// The draw that a mixed key stands for: a multiple of 2^-24 in [0, 1).
double draw_of(uvec2 key) { return from_word(key.x >> 8u) * 5.9604644775390625e-8lf; }

// The draw of a site outside repeats; those in repeats mix their copies' numbers in after it.
double uniform_of(uvec2 key, uint site) { return draw_of(mixed(key, site ^ SIGN_BIT)); }

// ---- exact sums and products --------------------------------------------------------------

// A number as two of 26 bits each (Veltkamp, in Dekker, "A floating-point technique for extending
// the available precision", 1971). |a| < 2^995.
dvec2 halves(double a) {
    precise double spread = 134217729.0lf * a;  // 2^27 + 1
    precise double high = spread - (spread - a);
    precise double low = a - high;
    return dvec2(high, low);
}

// What the rounded product p of a and b leaves out: a * b = p + it (Dekker).
double product_rest(double a, double b, double p) {
    dvec2 x = halves(a);
    dvec2 y = halves(b);
    precise double rest = ((x.x * y.x - p) + x.x * y.y + x.y * y.x) + x.y * y.y;
    return rest;
}

// A sum in two numbers, (rounded, rest); |a| >= |b|, or a is 0 (Dekker).
dvec2 two_sum(double a, double b) {
    precise double total = a + b;
    precise double rest = b - (total - a);
    return dvec2(total, rest);
}

// a - q * b without rounding, for q within a few ulp of a / b.
double quotient_rest(double a, double q, double b) {
    precise double p = q * b;
    precise double rest = (a - p) - product_rest(q, b, p);
    return rest;
}

// ---- quotients, roots and remainders -------------------------------------------------------

// a / b for 1 <= |a|, |b| < 2. A Newton step brings a driver's quotient to within an ulp; then
// the rest, which is exact, tells whether a neighbour is nearer: it is where the rest is over
// half an ulp of the quotient, times b. No quotient lies half way between two numbers.
double near_quotient(double a, double b) {
    precise double q = FIRST_QUOTIENT(a, b);
    q += FIRST_QUOTIENT(quotient_rest(a, q, b), b);
    precise double rest = quotient_rest(a, q, b);
    double ulp = magnitude(a) < magnitude(b) ? 0.5lf * ULP_OF_ONE : ULP_OF_ONE;
    double up = is_negative(rest) == is_negative(b) ? ulp : -ulp;
    return 2.0lf * magnitude(rest) > ulp * magnitude(b) ? q + up : q;
}

// The correctly rounded quotient.
double quotient(double a, double b) {
    if (!is_ordinary(a) || !is_ordinary(b)) return a / b;
    int e = exponent_of(a) - exponent_of(b);
    if (e < -1020 || e > 1020) return a / b;
    return near_quotient(with_exponent(a, 0), with_exponent(b, 0)) * power_of_two(e);
}

// The correctly rounded square root: as `near_quotient`, for a in [1, 4). A square cannot lie
// half way either; its rest is a multiple of the square of an ulp.
double near_root(double a) {
    precise double s = FIRST_ROOT(a);
    s += 0.5lf * FIRST_QUOTIENT(quotient_rest(a, s, s), s);
    precise double rest = quotient_rest(a, s, s);
    if (rest > s * ULP_OF_ONE) return s + ULP_OF_ONE;
    return rest <= -s * ULP_OF_ONE ? s - ULP_OF_ONE : s;
}

double square_root(double a) {
    if (!is_ordinary(a)) return holds(a) ? sqrt(a) : a;
    if (is_negative(a)) return no_number();
    int e = exponent_of(a) >> 1;
    return near_root(with_exponent(a, exponent_of(a) - 2 * e)) * power_of_two(e);
}

// The nearest whole number, halves to even ones; what is 2^52 or more is whole.
double nearest_even(double a) {
    double size = magnitude(a);
    precise double whole = (size + TWO_52) - TWO_52;
    return size < TWO_52 ? with_sign_of(whole, a) : a;
}

// The greatest whole number not above a, not snapped.
double whole_below(double a) {
    double near = nearest_even(a);
    return near > a ? near - 1.0lf : near;
}

// The mantissa and exponent of a finite number that is not 0, small ones included.
double normalised(double a, out int e) {
    bool small = !is_ordinary(a);
    double number = small ? a * 18014398509481984.0lf : a;  // 2^54
    e = exponent_of(number) - (small ? 54 : 0);
    return with_exponent(number, 0);
}

// What a finite a leaves when a finite b that is not 0 is taken away from it as often as it goes,
// with the sign of a (C's fmod). Exact: 48 bits of the quotient at a time, each off by one at most.
double remainder_of(double a, double b) {
    if (magnitude(a) < magnitude(b)) return a;
    int e, left;
    double size = normalised(magnitude(b), e);
    precise double rest = normalised(magnitude(a), left);
    left -= e;
    if (rest >= size) rest -= size;
    while (left > 0) {
        int bits = min(left, 48);
        rest *= power_of_two(bits);
        rest = quotient_rest(rest, whole_below(FIRST_QUOTIENT(rest, size)), size);
        if (rest < 0.0lf) rest += size;
        if (rest >= size) rest -= size;
        left -= bits;
    }
    return with_sign_of(scaled(rest, e), a);
}

// Equal within 1e-9 of the larger one.
bool same(double a, double b) {
    if (is_nan(a) || is_nan(b)) return false;
    precise double gap = magnitude(a - b);
    precise double most = SNAP * max(magnitude(a), magnitude(b));
    return a == b || (gap <= most && is_finite(gap));
}
