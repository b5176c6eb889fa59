/* What a rotor system gains and loses: integrals of power, by Gauss's quadrature within a step. */
#include "system_work.h"

/* Places and weights of Gauss's quadrature of twelve points on [0, 1], four to a vector. A product
 * of two series has terms beyond the degree for which this is exact, which are smaller than the
 * tolerance of a step. */
enum { VECTORS = 3, POINTS = 4 * VECTORS, AT_A_TIME = 2 };
static const double PLACES[POINTS] = {
    0.009219682876640378, 0.0479413718147626,  0.11504866290284765, 0.20634102285669126,
    0.31608425050090994,  0.43738329574426554, 0.5626167042557344,  0.6839157494990901,
    0.7936589771433087,   0.8849513370971523,  0.9520586281852375,  0.9907803171233596};
static const double WEIGHTS[POINTS] = {
    0.023587668193255706, 0.05346966299765953, 0.08003916427167321, 0.10158371336153287,
    0.1167462682691773,   0.12457352290670134, 0.12457352290670134, 0.1167462682691773,
    0.10158371336153287,  0.08003916427167321, 0.05346966299765953, 0.023587668193255706};

/* Values at all points. */
struct values {
    vec4 at[VECTORS];
};

/* The points of a step up to one of it, and what they weigh in an integral by the time. */
struct points {
    struct values u, square, weight;
};

COMPILED struct values times_each(struct values a, struct values b)
{
    struct values found;
    for (int i = 0; i < VECTORS; i++)
        found.at[i] = a.at[i] * b.at[i];
    return found;
}

/* The sum over all points of a product. */
COMPILED double summed(struct values a, struct values b)
{
    vec4 sum = spread(0.0);
    for (int i = 0; i < VECTORS; i++)
        sum = fma4(a.at[i], b.at[i], sum);
    return (sum[0] + sum[1]) + (sum[2] + sum[3]);
}

/* A series of `count` coefficients, `apart` in memory, at all points: Horner's rule for even and
 * for odd terms side by side, as one sum would wait for itself. */
COMPILED struct values read(const struct points *points, const double *terms, int apart, int count)
{
    struct values high, low; /* of the parity of the last term, and the other */
    int n = count - 3;
    for (int i = 0; i < VECTORS; i++) {
        high.at[i] = spread(terms[(count - 1) * apart]);
        low.at[i] = spread(terms[(count - 2) * apart]);
    }
    for (; n > 0; n -= 2) {
        for (int i = 0; i < VECTORS; i++) {
            high.at[i] = fma4(high.at[i], points->square.at[i], spread(terms[n * apart]));
            low.at[i] = fma4(low.at[i], points->square.at[i], spread(terms[(n - 1) * apart]));
        }
    }
    for (int i = 0; i < VECTORS; i++) {
        if (n == 0)
            high.at[i] = fma4(high.at[i], points->square.at[i], spread(terms[0]));
        high.at[i] = n == 0 ? fma4(low.at[i], points->u.at[i], high.at[i])
                            : fma4(high.at[i], points->u.at[i], low.at[i]);
    }
    return high;
}

static struct points points_up_to(const struct work *work, double point)
{
    struct points points;
    for (int i = 0; i < VECTORS; i++) {
        points.u.at[i] = spread(point) * load(&PLACES[4 * i]);
        points.square.at[i] = points.u.at[i] * points.u.at[i];
        points.weight.at[i] = spread(point) * load(&WEIGHTS[4 * i]);
    }
    if (work->moves)
        points.weight = times_each(points.weight, read(&points, work->pace, 1, work->order));
    return points;
}

double turned_by(const struct work *work, double point)
{
    const struct points points = points_up_to(work, point);
    return summed(points.weight, read(&points, work->spin, 1, work->order));
}

/* Add, of some coefficients of a, the products with all of b and their moments, in eight columns.
 */
COMPILED void add_products(const struct work *work, const int many, const double *moments,
                           const double *a, const double *b, vec8 *sum)
{
    vec8 even[AT_A_TIME] = {{0.0}}, odd[AT_A_TIME] = {{0.0}};
    int j = 0;
    for (; j + 1 < work->order; j += 2, b += 2 * work->stride) {
        const vec8 first = load8(b), second = load8(b + work->stride);
        for (int k = 0; k < many; k++) {
            even[k] = fma8(moments[k + j], first, even[k]);
            odd[k] = fma8(moments[k + j + 1], second, odd[k]);
        }
    }
    for (int k = 0; k < many; k++) {
        if (j < work->order)
            even[k] = fma8(moments[k + j], load8(b), even[k]);
        *sum += (even[k] + odd[k]) * load8(&a[k * work->stride]);
    }
}

/* The integral of the scalar product of two series of rows, times values: the sum of all products
 * of their coefficients, by the moments of these values. Those of high terms count as well, as the
 * terms of a product fall as those of a motion of twice the frequency. */
static double integral_of_power(const struct work *work, const struct points *points,
                                struct values factor, const double *a, const double *b)
{
    double moments[2 * ORDERS];
    for (int n = 0; n < 2 * work->order - 1; n++) {
        moments[n] = summed(points->weight, factor);
        factor = times_each(factor, points->u);
    }
    vec8 eights = {0.0};
    int64_t i = 0;
    for (; i + 8 <= work->stride; i += 8) {
        int k = 0;
        for (; k + AT_A_TIME <= work->order; k += AT_A_TIME)
            add_products(work, AT_A_TIME, &moments[k], &a[k * work->stride + i], &b[i], &eights);
        for (; k < work->order; k++)
            add_products(work, 1, &moments[k], &a[k * work->stride + i], &b[i], &eights);
    }
    vec4 total = halves_of(eights);
    for (; i < work->stride; i += 4) {
        for (int k = 0; k < work->order; k++) {
            const double *row = &b[i];
            vec4 even = spread(0.0), odd = spread(0.0);
            int j = 0;
            for (; j + 1 < work->order; j += 2) {
                even = fma4(spread(moments[k + j]), load(row), even);
                odd = fma4(spread(moments[k + j + 1]), load(row + work->stride), odd);
                row += 2 * work->stride;
            }
            if (j < work->order)
                even = fma4(spread(moments[k + j]), load(row), even);
            total = fma4(even + odd, load(&a[k * work->stride + i]), total);
        }
    }
    return (total[0] + total[1]) + (total[2] + total[3]);
}

/* The work of the unbalance. */
static double work_of_unbalance(const struct work *work, const struct points *points)
{
    const double *unbalance = work->run->unbalance;
    double by[ORDERS][2]; /* along and across */
    for (int n = 0; n < work->order; n++)
        sums_of_products(unbalance, &work->v[n * work->stride], work->stride, by[n]);
    struct values found = times_each(read(points, &by[0][0], 2, work->order),
                                     read(points, work->by_cosine, 1, work->order));
    const struct values other = times_each(read(points, &by[0][1], 2, work->order),
                                           read(points, work->by_sine, 1, work->order));
    for (int i = 0; i < VECTORS; i++)
        found.at[i] += other.at[i];
    return summed(points->weight, found);
}

/* Keep what an episode of a contact has spent. */
static void keep_episode(const struct work *work, const struct points *points,
                         const struct touching *each, double span)
{
    struct system_run *run = work->run;
    struct episode *episode = &run->open[each - work->touching];
    if (!pushes(each))
        return;
    const double *answers = each->answers[0];
    const struct values push = times_each(
        points->weight, read(points, &answers[ELEMENT_PUSH], ELEMENT_ANSWERS, work->order));
    const double power = summed(
        push, read(points, &answers[ELEMENT_APPROACH], ELEMENT_ANSWERS, work->order));
    struct values one;
    for (int i = 0; i < VECTORS; i++)
        one.at[i] = spread(1.0);
    episode->impulse += summed(push, one);
    episode->work += power;
    run->ledger.normal += power;
    if (each->law->friction == 0.0)
        return;
    double rim[ORDERS];
    for (int n = 0; n < work->order; n++)
        rim[n] = each->law->radius * work->spin[n]
                 - each->law->race_radius * each->series.terms[n][ELEMENT_RACE];
    const struct values drag = times_each(points->weight, read(points, each->drag, 1, work->order));
    run->ledger.tangential -= summed(drag, read(points, rim, 1, work->order));
    if (each->touch->mode == ROLLS) {
        episode->rolling_time += span;
        return;
    }
    const struct values slip = read(points, &answers[ELEMENT_SLIP], ELEMENT_ANSWERS, work->order);
    const double heat = summed(drag, slip);
    episode->heat += heat;
    run->ledger.tangential += heat;
    episode->slip_distance += each->touch->sense * summed(points->weight, slip);
}

/* What bearings whose coefficients change with the speed take. */
static double lost_to_bearings(const struct work *work, const struct points *points)
{
    double lost = 0.0;
    for (int64_t i = 0; i < work->run->bearing_count; i++) {
        const struct bearing_terms *each = &work->bearings->each[i];
        for (int j = 0; j < 2; j++) {
            const struct values force = read(points, &each->force[0][j], 2, work->order);
            const struct values rate = read(points, &each->motion[0][2 + j], 4, work->order);
            lost -= summed(points->weight, times_each(force, rate));
        }
    }
    return lost;
}

void keep_ledger(struct work *work, double point, double span)
{
    struct system_run *run = work->run;
    const int64_t stride = work->stride;
    const struct points points = points_up_to(work, point);
    struct values one;
    for (int i = 0; i < VECTORS; i++)
        one.at[i] = spread(1.0);
    run->ledger.unbalance += work_of_unbalance(work, &points);
    if (run->damping != NULL || run->gyroscopic != NULL)
        run->ledger.damping += integral_of_power(work, &points, one, work->v, work->resisted);
    if (run->circulation != NULL) {
        for (int n = 0; n < work->order; n++) {
            double *pushed = row_of(work, work->turned, n); /* which the step needs no more */
            memset(pushed, 0, sizeof(double) * (size_t)stride);
            multiply(run->circulation, row_of(work, work->y, n), 1.0, run->size, stride, pushed);
        }
        run->ledger.damping += integral_of_power(work, &points, one, work->v, work->turned);
    }
    if (run->stiffness_rate != NULL && work->has_rate)
        run->ledger.stiffness_rate += integral_of_power(
            work, &points, read(&points, work->spin_rate, 1, work->order), work->v,
            work->stiffened);
    run->ledger.bearings += lost_to_bearings(work, &points);
    for (int64_t i = 0; i < run->contact_count; i++) {
        if (is_centred(&work->touching[i]))
            keep_centred(work, &work->touching[i], point);
        else if (is_touching(&work->touching[i]))
            keep_episode(work, &points, &work->touching[i], span);
    }
}
