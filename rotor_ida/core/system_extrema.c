/* What is largest and smallest in a run of a rotor system, between its samples: the peaks of its
 * contacts, and the distances of places. */
#include "system_work.h"

/* A correction of a zero is at most this part of its step. */
static const double CORRECTED = 1e-6;

/* ---- Peaks ---- */

/* Keep the largest value, by its sign, of a series up to a point, which is at a time. */
static void keep_extreme(const struct work *work, const double *terms, int apart, double sign,
                         double point, double until, struct extreme *most)
{
    const int order = work->order;
    /* beyond it by more than rounding, which else decides when it is reached */
    double largest = sign * most->value + ROUNDED * fabs(most->value), where = -1.0;
    double own[ORDERS], slope[ORDERS], points[ORDERS + 2] = {0.0, point};
    double power = 1.0, bound = own[0] = sign * terms[0];
    for (int n = 1; n <= order; n++) {
        own[n] = sign * terms[n * apart];
        slope[n - 1] = n * own[n];
        power *= point;
        bound += fabs(own[n]) * power;
    }
    if (bound <= largest)
        return;
    double way = 0.0;
    const int count = 2 + sign_changes(slope, order - 1, point, &way, &points[2]);
    for (int i = 0; i < count; i++) {
        const double value = polynomial(own, 1, order, points[i]);
        if (value > largest) {
            largest = value;
            where = points[i];
        }
    }
    if (where >= 0.0)
        *most = (struct extreme){sign * largest,
                                 where < point ? polynomial(work->time, 1, order, where) : until};
}

/* Keep the largest root of a radius, without clearance. */
static void keep_farthest(const struct work *work, const struct touching *each, double point,
                          double until, struct extreme *deepest)
{
    double square[ORDERS];
    const double root = deepest->value;
    struct extreme most = {root * root * root * root, deepest->time};
    write_square(work, each, square);
    keep_extreme(work, square, 1, 1.0, point, until, &most);
    if (most.time != deepest->time)
        *deepest = (struct extreme){sqrt(sqrt(most.value)), most.time};
}

void keep_peaks(struct work *work, double point, double until)
{
    struct system_run *run = work->run;
    for (int i = 0; i < (int)run->contact_count; i++) {
        struct touching *each = &work->touching[i];
        struct episode *episode = &run->open[i];
        const double *terms = each->series.terms[0];
        if (each->law->inverse_race_inertia > 0.0) {
            const double *race = &terms[ELEMENT_RACE];
            keep_extreme(work, race, WIDTH, 1.0, point, until, &run->races[i].largest);
            keep_extreme(work, race, WIDTH, -1.0, point, until, &run->races[i].smallest);
        }
        if (!is_touching(each))
            continue;
        if (is_centred(each))
            keep_farthest(work, each, point, until, &episode->deepest);
        else
            keep_extreme(work, &terms[ELEMENT_ROOT], WIDTH, 1.0, point, until, &episode->deepest);
        if (!pushes(each))
            continue;
        if (each->law->contact_damping == 0.0) { /* hardest where it is deepest */
            const double given[ELEMENT_GIVEN] = {[ELEMENT_ROOT] = episode->deepest.value};
            double answers[ELEMENT_ANSWERS];
            element_values(&each->element, given, answers);
            episode->hardest = (struct extreme){answers[ELEMENT_PUSH], episode->deepest.time};
        } else {
            keep_extreme(work, &each->answers[0][ELEMENT_PUSH], ELEMENT_ANSWERS, 1.0, point, until,
                         &episode->hardest);
        }
    }
}

/* ---- Distances of places ---- */

/* Take an extremum of the distance of a place; rounding alone takes the last one back. */
static void take_extremum(struct system_run *run, struct extremum_of_place now)
{
    struct extremum_of_place *last = &run->places[now.place].last;
    if (last->kind != 0 && fabs(now.distance - last->distance) <= ROUNDED * now.distance) {
        last->kind = 0;
        return;
    }
    if (last->kind != 0)
        run->extrema[run->extremum_count++] = *last;
    *last = now;
}

/* The series of a place: its displacement from its centre, and its velocity. */
struct series_of_place {
    double x[ORDERS], y[ORDERS], vx[ORDERS], vy[ORDERS];
};

/* Write it; return a bound of the parts of x x' + y y' up to a point. */
static double write_place(const struct work *work, int number, double point,
                          struct series_of_place *series)
{
    const struct place *place = &work->run->places[number];
    const double *rows = &work->run->place_rows[2 * number * work->stride];
    vec4 bound = spread(0.0);
    double power = 1.0;
    for (int n = 0; n <= work->order; n++) {
        double at[4]; /* displacement and velocity */
        sums_of_products(rows, row_of(work, work->y, n), work->stride, &at[0]);
        sums_of_products(rows, row_of(work, work->v, n), work->stride, &at[2]);
        for (int j = 0; j < 2 && n == 0; j++)
            at[j] -= place->centre[j];
        series->x[n] = at[0];
        series->y[n] = at[1];
        series->vx[n] = at[2];
        series->vy[n] = at[3];
        for (int j = 0; j < 4; j++)
            bound[j] = fma(fabs(at[j]), power, bound[j]);
        power *= point;
    }
    return bound[0] * bound[2] + bound[1] * bound[3];
}

/* Correct where the rate x x' + y y' is 0 for what it lacks beyond the order: Newton's method. */
static double corrected(const struct series_of_place *series, const double *rate, int order,
                        double at, double most)
{
    double slope = 0.0, value = rate[order];
    for (int n = order - 1; n >= 0; n--) {
        slope = fma(slope, at, value);
        value = fma(value, at, rate[n]);
    }
    value = polynomial(series->x, 1, order, at) * polynomial(series->vx, 1, order, at)
            + polynomial(series->y, 1, order, at) * polynomial(series->vy, 1, order, at);
    const double next = at - value / slope;
    return fabs(next - at) <= CORRECTED * most && next > 0.0 && next < most ? next : at;
}

/* Keep the extrema of the distance of a place up to a point, which is at a time: there the rate of
 * its square, but for a factor 2, changes its sign. */
static void keep_extrema_of(struct work *work, int number, double point, double until)
{
    struct system_run *run = work->run;
    const int order = work->order;
    struct series_of_place series = {{0.0}, {0.0}, {0.0}, {0.0}};
    double rate[ORDERS] = {0.0}, points[ORDERS + 1], power = 1.0, largest = 0.0;
    const double bound = write_place(work, number, point, &series);
    write_product(order, order, series.x, series.vx, series.y, series.vy, rate);
    for (int n = 0; n <= order; n++) {
        largest = fma(fabs(rate[n]), power, largest);
        power *= point;
    }
    if (largest <= ROUNDED * bound) /* a circle */
        return;
    double sign = run->places[number].sign;
    const int count = sign_changes(rate, order, point, &sign, points);
    /* they take turns: behind a minimum the rate is above 0 */
    int kind = (count % 2 == 1) == (sign > 0.0) ? -1 : 1;
    for (int i = 0; i < count; i++) {
        const double at = corrected(&series, rate, order, points[i], point);
        const double x = polynomial(series.x, 1, order, at);
        const double y = polynomial(series.y, 1, order, at);
        const double time = at < point ? polynomial(work->time, 1, order, at) : until;
        take_extremum(run, (struct extremum_of_place){time, sqrt(x * x + y * y), number, kind});
        kind = -kind;
    }
    run->places[number].sign = sign;
}

void keep_extrema(struct work *work, double point, double until)
{
    for (int i = 0; i < (int)work->run->place_count; i++)
        keep_extrema_of(work, i, point, until);
}
