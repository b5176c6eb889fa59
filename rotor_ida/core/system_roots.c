/* Series of a rotor system as polynomials: their products, where they first fall through 0, and
 * where they change their signs. It is certain that no zero is missed: on an interval a polynomial
 * has no more zeros than its Bernstein coefficients have changes of sign, and one with more than
 * one change is halved. */
#include "system_work.h"

/* Shortest interval, in steps, within which two zeros are separated. */
static const double SHORTEST = 1e-15;
/* A zero is found where rounding hides it: to this part of itself; and the most steps to it. */
static const double CLOSE = 4e-16;
enum { MOST_NEWTON = 200 };

/* Write coefficients up to `last` of a b + c d, of series up to an order: eight side by side, as a
 * sum in memory would wait for itself. */
void write_product(int order, int last, const double *a, const double *b, const double *c,
                   const double *d, double *product)
{
    enum { EIGHT = 8 };
    double of_b[GAP_TERMS + 2 * EIGHT] = {0.0}, of_d[GAP_TERMS + 2 * EIGHT] = {0.0};
    /* zeros before and behind the coefficients */
    memcpy(&of_b[ORDERS], b, sizeof(double) * (size_t)(order + 1));
    memcpy(&of_d[ORDERS], d, sizeof(double) * (size_t)(order + 1));
    for (int n = 0; n <= last; n += EIGHT) {
        vec8 first = {0.0}, second = {0.0};
        for (int k = n > order ? n - order : 0; k <= order && k <= n + EIGHT - 1; k++) {
            first = fma8(a[k], load8(&of_b[ORDERS + n - k]), first);
            second = fma8(c[k], load8(&of_d[ORDERS + n - k]), second);
        }
        first += second;
        memcpy(&product[n], &first, sizeof(double) * (size_t)smaller(EIGHT, last + 1 - n));
    }
}

/* The one zero of a polynomial between two points at which its signs differ: Newton's method, and
 * the middle of the interval where it leads out of it. */
static double zero_between(const double *terms, int order, double low, double high)
{
    const int falls = polynomial(terms, 1, order, low) > 0.0;
    double point = 0.5 * (low + high);
    for (int i = 0; i < MOST_NEWTON && high - low > CLOSE * high; i++) {
        double value = terms[order], slope = 0.0;
        for (int n = order - 1; n >= 0; n--) {
            slope = fma(slope, point, value);
            value = fma(value, point, terms[n]);
        }
        if (value == 0.0)
            return point;
        if ((value > 0.0) == falls)
            low = point;
        else
            high = point;
        const double next = point - value / slope;
        if (fabs(next - point) <= 0.5 * CLOSE * point)
            return point;
        point = next > low && next < high ? next : 0.5 * (low + high);
    }
    return high;
}

/* Write the Bernstein coefficients of a polynomial on [0, step]: sums of its terms over binomials,
 * by Pascal's triangle. They are summed in reverse, so that each row of it is one pass forwards. */
static void write_bernstein(const double *terms, int order, double step, double *bernstein)
{
    double reverse[GAP_TERMS], scale = 1.0;
    for (int k = 0; k <= order; k++) {
        reverse[order - k] = terms[k] * scale;
        scale *= step * (k + 1) / (order > k ? order - k : 1);
    }
    for (int row = 0; row < order; row++) {
        for (int i = 0; i < order - row; i++)
            reverse[i] += reverse[i + 1];
    }
    for (int j = 0; j <= order; j++)
        bernstein[j] = reverse[order - j];
}

/* How often the sign changes: no less often than a polynomial with these coefficients is 0. */
static int changes_of(const double *bernstein, int order)
{
    int changes = 0;
    double last = bernstein[0];
    for (int j = 1; j <= order; j++) {
        changes += bernstein[j] * last < 0.0;
        last = bernstein[j] != 0.0 ? bernstein[j] : last;
    }
    return changes;
}

/* Write the coefficients on the left half of an interval, and on the right in place of its own: de
 * Casteljau, row k of means from 0 to order - k. */
static void halve(double *right, int order, double *left)
{
    for (int k = 0; k <= order; k++) {
        left[k] = right[0];
        for (int j = 0; j < order - k; j++)
            right[j] = 0.5 * (right[j] + right[j + 1]);
        /* right[order - k] keeps the last of row k: coefficient order - k of the right half */
    }
}

/* Where a polynomial first falls through 0, by its Bernstein coefficients on [low, high]. */
static double fall_within(const double *terms, const double *bernstein, int order, double low,
                          double high, double shortest)
{
    const int changes = changes_of(bernstein, order);
    if (changes == 0)
        return bernstein[0] < 0.0 ? low : INFINITY;
    if (changes == 1 && bernstein[0] > 0.0 && bernstein[order] < 0.0)
        return zero_between(terms, order, low, high);
    if (high - low <= shortest)
        return bernstein[order] < 0.0 ? high : INFINITY;
    double left[GAP_TERMS], right[GAP_TERMS];
    memcpy(right, bernstein, sizeof(double) * (size_t)(order + 1));
    halve(right, order, left);
    const double middle = 0.5 * (low + high);
    const double first = fall_within(terms, left, order, low, middle, shortest);
    return first < INFINITY ? first : fall_within(terms, right, order, middle, high, shortest);
}

double first_fall(const double *terms, int apart, int order, double step, int zeros)
{
    double own[GAP_TERMS], size = 0.0, scale = 1.0;
    while (zeros < order && terms[zeros * apart] == 0.0)
        zeros++;
    const int last = order - zeros;
    for (int n = 0; n <= last; n++) {
        own[n] = terms[(n + zeros) * apart];
        size += n > 0 ? fabs(own[n]) * scale : 0.0;
        scale *= step;
    }
    if (own[0] < 0.0)
        return 0.0;
    if (own[0] > size || last == 0)
        return INFINITY;
    double bernstein[GAP_TERMS];
    write_bernstein(own, last, step, bernstein);
    return fall_within(own, bernstein, last, 0.0, step, SHORTEST * step);
}

/* The points at which a polynomial changes its sign, and the sign behind them; 0 at first. */
struct signs {
    const double *terms;
    int order, count;
    double sign, shortest, *points;
};

static void take_sign(struct signs *signs, double value, double point)
{
    if (value * signs->sign < 0.0 && signs->count <= signs->order)
        signs->points[signs->count++] = point;
    if (value != 0.0)
        signs->sign = value < 0.0 ? -1.0 : 1.0;
}

/* Take the signs between two points, by the Bernstein coefficients there. */
static void signs_within(struct signs *signs, const double *bernstein, double low, double high)
{
    const int order = signs->order, changes = changes_of(bernstein, order);
    const int is_one = changes == 1 && bernstein[0] * bernstein[order] < 0.0;
    if (changes > 0 && !is_one && high - low > signs->shortest) {
        double left[ORDERS], right[ORDERS];
        memcpy(right, bernstein, sizeof(double) * (size_t)(order + 1));
        halve(right, order, left);
        const double middle = 0.5 * (low + high);
        signs_within(signs, left, low, middle);
        signs_within(signs, right, middle, high);
        return;
    }
    for (int j = 0; changes == 0 && j <= order; j++) /* all of one sign */
        take_sign(signs, bernstein[j], low);
    if (changes == 0)
        return;
    if (is_one) {
        take_sign(signs, bernstein[0], low);
        take_sign(signs, bernstein[order], zero_between(signs->terms, order, low, high));
        return;
    }
    take_sign(signs, bernstein[order], high);
}

int sign_changes(const double *terms, int order, double step, double *sign, double *points)
{
    struct signs signs = {terms, order, 0, *sign, SHORTEST * step, points};
    double later = 0.0, power = 1.0;
    for (int n = 1; n <= order; n++) {
        power *= step;
        later += fabs(terms[n]) * power;
    }
    if (fabs(terms[0]) > later) {
        take_sign(&signs, terms[0], 0.0);
    } else {
        double bernstein[ORDERS];
        write_bernstein(terms, order, step, bernstein);
        signs_within(&signs, bernstein, 0.0, step);
    }
    *sign = signs.sign;
    return signs.count;
}
