/* Arithmetic of Taylor coefficients: products, quotients and powers of series, and sums over rows.
 *
 * Coefficient n of a product is a convolution of the coefficients of its factors. All but its two
 * end terms are known as soon as the coefficients below n are: `sum_known` sums these of all
 * products of a system together, each in a lane of its own, which is nearly all of the arithmetic.
 * What is left of order n is written as the equations are (`derived.c`).
 *
 * Jorba and Zou, "A software package for the numerical integration of ODEs by means of high-order
 * Taylor methods", Experimental Mathematics 14, 2005, section 2. */
#ifndef ROTOR_IDA_SERIES_H
#define ROTOR_IDA_SERIES_H

#include <math.h>
#include <string.h>

#include "model.h"
#include DERIVED_HEADER

enum {
    LOWEST_ORDER = 6,
    HIGHEST_ORDER = 24,
    ORDERS = HIGHEST_ORDER + 1,
    WIDTH = SPEED_CHANGES ? 16
    : IS_WHOLE            ? 12
                          : 8, /* columns of a state, with room to spare */
    LANES = SERIES_PRODUCTS,
    FACTORS = SERIES_FACTORS,
    DIFFERENCES = 4, /* followed beside a motion, four components each */
    APART = 16,
    WATCHED = 2, /* what is beside the state */
    WIDEST_ROW = 16
};

/* Coefficients about the beginning of a step, and the factors of which they were made. */
struct series {
    _Alignas(32) double terms[ORDERS][WIDTH];
    _Alignas(32) double left[ORDERS][LANES];
    _Alignas(32) double right[ORDERS][LANES];
    _Alignas(32) double known[LANES];
    _Alignas(32) double apart[ORDERS][APART];  /* of the differences: x of all four, then y, ... */
    _Alignas(32) double steady[ORDERS][APART]; /* what the pace multiplies of their rates */
    double factors[FACTORS][ORDERS];
    double watched[ORDERS][WATCHED];
};

typedef double vec4 __attribute__((vector_size(32)));

static inline vec4 load(const double *from)
{
    vec4 row;
    memcpy(&row, from, sizeof row);
    return row;
}

static inline void store(double *to, vec4 row) { memcpy(to, &row, sizeof row); }

static inline vec4 spread(double number) { return (vec4){number, number, number, number}; }

static inline vec4 fma4(vec4 a, vec4 b, vec4 c)
{
    return (vec4){fma(a[0], b[0], c[0]), fma(a[1], b[1], c[1]), fma(a[2], b[2], c[2]),
                  fma(a[3], b[3], c[3])};
}

/* 1/a, and 0 where there is none. */
static inline double inverse(double a) { return a != 0.0 ? 1.0 / a : 0.0; }

/* a/b, and 0 where there is none. */
static inline double ratio(double a, double b) { return b != 0.0 ? a / b : 0.0; }

/* Make ready for coefficients 0. */
static inline void begin_lanes(struct series *series)
{
    memset(series->left[0], 0, sizeof series->left[0]);
    memset(series->right[0], 0, sizeof series->right[0]);
}

/* Sum what is known of coefficient n of each product: left[k] right[n - k] for k from 1 to n - 1.
 *
 * Outwards from the middle: the rows written last, at the ends, are waited for last. */
static inline __attribute__((always_inline)) void sum_known(struct series *series, int n,
                                                            const int vectors)
{
    vec4 lower[LANES / 4], upper[LANES / 4];
    const int has_middle = n > 1 && n % 2 == 0;
    for (int v = 0; v < vectors; v++) {
        const vec4 middle = load(&series->left[n / 2][4 * v]) * load(&series->right[n / 2][4 * v]);
        lower[v] = has_middle ? middle : spread(0.0);
        upper[v] = spread(0.0);
    }
    for (int k = (n - 1) / 2; k > 0; k--) {
        for (int v = 0; v < vectors; v++) {
            const vec4 first = load(&series->left[k][4 * v]);
            const vec4 last = load(&series->left[n - k][4 * v]);
            lower[v] = fma4(first, load(&series->right[n - k][4 * v]), lower[v]);
            upper[v] = fma4(last, load(&series->right[k][4 * v]), upper[v]);
        }
    }
    for (int v = 0; v < vectors; v++)
        store(&series->known[4 * v], lower[v] + upper[v]);
}

/* Coefficient n of a product, given those of its factors, the one known last first.
 *
 * The rows 0 of the factors are 0 before they get there: a product has one end term then. */
static inline double times(struct series *series, int lane, int n, double a, double b)
{
    series->right[n][lane] = b;
    const double first = fma(series->left[0][lane], b, series->known[lane]);
    const double total = fma(a, series->right[0][lane], first);
    series->left[n][lane] = a;
    return total;
}

/* Coefficient n of b = c/a, given those of c and a, and 1/a_0: that of a b is that of c. */
static inline double over(struct series *series, int lane, int n, double c, double a,
                          double inverse_of_a)
{
    const double b = (c - series->known[lane]) * inverse_of_a
                     - a * (series->right[0][lane] * inverse_of_a);
    series->left[n][lane] = a;
    series->right[n][lane] = b;
    return b;
}

/* Coefficient n of b = a**e, which solves a b' = e a' b, given that of a, b_0 at n = 0, and 1/a_0.
 *
 * That is, n a_0 b_n is the sum over k below n of (e n - (e + 1) k) a_(n - k) b_k: two lanes. */
static inline double raised(struct series *series, int lane, int n, double a, double e,
                            double first, double inverse_of_a)
{
    const double whole = times(series, lane, n, a, 0.0);
    const double part = times(series, lane + 1, n, a, 0.0);
    const double b = first + (e * whole - (e + 1.0) * part / (n > 0 ? n : 1)) * inverse_of_a;
    series->right[n][lane] = b;
    series->right[n][lane + 1] = n * b;
    return b;
}

/* A row of terms, without their signs if so asked. */
static inline vec4 load_row(const double *from, const int absolute)
{
    const vec4 row = load(from);
    return absolute ? (vec4){fabs(row[0]), fabs(row[1]), fabs(row[2]), fabs(row[3])} : row;
}

/* Write the first columns of series at a point: Horner's rule for even and for odd terms, and all
 * columns side by side, as one sum would wait for itself. */
static inline __attribute__((always_inline)) void evaluate(const double *terms, const int width,
                                                           const int columns, int order,
                                                           double point, const int absolute,
                                                           double *values)
{
    const vec4 at = spread(point), square = at * at;
    vec4 high[WIDEST_ROW / 4], low[WIDEST_ROW / 4]; /* of the parity of the order, and the other */
    for (int v = 0; v < (columns + 3) / 4; v++) {
        high[v] = load_row(&terms[order * width + 4 * v], absolute);
        low[v] = load_row(&terms[(order - 1) * width + 4 * v], absolute);
    }
    int n = order - 2;
    for (; n > 0; n -= 2) {
        for (int v = 0; v < (columns + 3) / 4; v++) {
            high[v] = fma4(high[v], square, load_row(&terms[n * width + 4 * v], absolute));
            low[v] = fma4(low[v], square, load_row(&terms[(n - 1) * width + 4 * v], absolute));
        }
    }
    for (int v = 0; v < (columns + 3) / 4; v++) {
        if (n == 0) {
            high[v] = fma4(high[v], square, load_row(&terms[4 * v], absolute));
            store(&values[4 * v], fma4(low[v], at, high[v]));
        } else {
            store(&values[4 * v], fma4(high[v], at, low[v]));
        }
    }
}

/* Values of some components at eight parts of a step, four to a vector. */
enum { AT_ONCE = 2 };
static inline __attribute__((always_inline)) void read_parts(const struct series *series, int order,
                                                             const int *components, const int count,
                                                             const vec4 *parts,
                                                             vec4 (*values)[AT_ONCE])
{
    for (int i = 0; i < count; i++)
        values[i][0] = values[i][1] = spread(0.0);
    for (int n = order; n >= 0; n--) {
        for (int i = 0; i < count; i++) {
            const vec4 term = spread(series->terms[n][components[i]]);
            for (int v = 0; v < AT_ONCE; v++)
                values[i][v] = fma4(values[i][v], parts[v], term);
        }
    }
}

#endif
