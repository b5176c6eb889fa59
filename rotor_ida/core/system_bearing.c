/* Bearings and seals whose stiffness and damping change with the speed: -(K u + C u') on their
 * displacement u.
 *
 * Between two knots each coefficient is a cubic in the speed. In a step it is one in the excess of
 * the speed over that at the beginning, whose powers are series that all bearings share. The third
 * derivative jumps at a knot: where the speed passes one, the step ends. */
#include "system_work.h"

/* So near to a knot, in parts of it and of the interval, rounding decides on which side a speed is.
 */
static const double AT_KNOT = 16.0 * 2.220446049250313e-16;

int64_t core_system_bearing_room(int64_t bearings, int64_t columns)
{
    const int64_t each = (int64_t)(sizeof(struct bearing_terms) / sizeof(double));
    return (int64_t)(sizeof(struct bearings) / sizeof(double))
           + bearings * (each + ROWS_OF_BEARING * ORDERS * columns);
}

struct bearings *open_bearings(const struct system_run *run)
{
    if (run->bearing_count == 0)
        return NULL;
    struct bearings *bearings = (struct bearings *)(void *)run->bearing_room;
    bearings->each = (struct bearing_terms *)(void *)(bearings + 1);
    double *columns = (double *)(void *)(bearings->each + run->bearing_count);
    for (int64_t i = 0; i < run->bearing_count; i++)
        bearings->each[i].columns = columns + i * ROWS_OF_BEARING * ORDERS * run->column_count;
    return bearings;
}

/* Write the cubics of an interval about a speed: Horner's scheme, again and again. */
static void shift_cubics(const struct system_bearing *bearing, double speed,
                         double (*cubics)[BEARING_ENTRIES])
{
    const int64_t last = bearing->knot_count - 2;
    const int64_t interval = bearing->interval < 0      ? 0
                             : bearing->interval > last ? last
                                                        : bearing->interval;
    const double past = speed - bearing->knots[interval];
    memcpy(cubics, &bearing->cubics[interval * BEARING_POWERS * BEARING_ENTRIES],
           sizeof(double) * BEARING_POWERS * BEARING_ENTRIES);
    for (int done = 0; done < BEARING_POWERS - 1; done++) {
        for (int power = BEARING_POWERS - 2; power >= done; power--)
            add_scaled(past, cubics[power + 1], cubics[power], BEARING_ENTRIES);
    }
}

void begin_bearings(struct work *work)
{
    const struct system_run *run = work->run;
    for (int64_t i = 0; i < run->bearing_count; i++)
        shift_cubics(&run->bearings[i], run->speed, work->bearings->each[i].cubics);
}

/* Coefficient n of the first three powers of the excess of the speed. */
static void set_powers(struct work *work, int n)
{
    struct bearings *bearings = work->bearings;
    double (*powers)[ORDERS] = bearings->powers;
    if (n == 0) /* at a constant rate, and without a fictitious time, the excess is linear */
        bearings->degree = !work->has_rate                   ? 0
                           : work->moves || work->has_torque ? ORDERS
                                                             : BEARING_POWERS - 1;
    if (n > bearings->degree)
        return;
    powers[0][n] = n == 0 ? 0.0 : work->spin[n];
    powers[1][n] = convolved(powers[0], 1, powers[0], 1, n);
    powers[2][n] = convolved(powers[1], 1, powers[0], 1, n);
}

/* Write coefficient n of displacement and velocity of a bearing. */
static void see_bearing(const struct work *work, const double *rows, int n, double *motion)
{
    const int64_t stride = work->stride;
    const double *y = &work->y[n * stride], *v = &work->v[n * stride];
    vec4 sums[4] = {{0.0}, {0.0}, {0.0}, {0.0}};
    for (int64_t i = 0; i < stride; i += 4) {
        const vec4 along = load(&rows[i]), aside = load(&rows[stride + i]);
        const vec4 place = load(&y[i]), velocity = load(&v[i]);
        sums[0] = fma4(along, place, sums[0]);
        sums[1] = fma4(aside, place, sums[1]);
        sums[2] = fma4(along, velocity, sums[2]);
        sums[3] = fma4(aside, velocity, sums[3]);
    }
    for (int j = 0; j < 4; j++)
        motion[j] = (sums[j][0] + sums[j][1]) + (sums[j][2] + sums[j][3]);
}

/* Write coefficient n of the coefficients of a bearing. */
static void set_entries(const struct bearings *bearings, struct bearing_terms *each, int n)
{
    double *entries = each->entries[n];
    if (n > bearings->degree)
        return;
    for (int i = 0; i < BEARING_ENTRIES; i += 4) {
        vec4 sum = n == 0 ? load(&each->cubics[0][i]) : spread(0.0);
        for (int power = 1; power < BEARING_POWERS; power++)
            sum = fma4(spread(bearings->powers[power - 1][n]), load(&each->cubics[power][i]), sum);
        store(&entries[i], sum);
    }
}

void push_by_bearings(struct work *work, int n, double *to)
{
    const struct system_run *run = work->run;
    const int64_t stride = work->stride;
    struct bearings *bearings = work->bearings;
    set_powers(work, n);
    const int last = n < bearings->degree ? n : bearings->degree;
    for (int64_t i = 0; i < run->bearing_count; i++) {
        struct bearing_terms *each = &bearings->each[i];
        const double *rows = run->bearings[i].rows;
        set_entries(bearings, each, n);
        see_bearing(work, rows, n, each->motion[n]);
        vec4 along = spread(0.0), aside = spread(0.0);
        for (int k = 0; k <= last; k++) {
            const vec4 motion = load(each->motion[n - k]);
            along = fma4(load(&each->entries[k][0]), motion, along);
            aside = fma4(load(&each->entries[k][4]), motion, aside);
        }
        each->force[n][0] = -((along[0] + along[1]) + (along[2] + along[3]));
        each->force[n][1] = -((aside[0] + aside[1]) + (aside[2] + aside[3]));
        add_scaled(each->force[n][0], rows, to, stride);
        add_scaled(each->force[n][1], rows + stride, to, stride);
    }
}

/* The first point of a step at which the speed passes a knot that bounds the interval of a bearing,
 * below it or above. */
static double passes_knot(const struct work *work, const struct system_bearing *bearing, int above,
                          double step)
{
    const double *ends = &bearing->knots[bearing->interval];
    const double sign = above ? -1.0 : 1.0;
    double left[ORDERS];
    for (int n = 0; n <= work->order; n++)
        left[n] = sign * work->spin[n];
    left[0] = sign * (work->spin[0] - ends[above]);
    const double rounded = AT_KNOT * (fabs(ends[above]) + (ends[1] - ends[0]));
    return first_fall(left, 1, work->order, step, fabs(left[0]) <= rounded);
}

int limit_to_knots(struct work *work)
{
    const struct system_run *run = work->run;
    double first = work->step;
    for (int64_t i = 0; i < run->bearing_count; i++) {
        const struct system_bearing *bearing = &run->bearings[i];
        struct bearing_terms *each = &work->bearings->each[i];
        each->passed = INFINITY;
        if (!work->has_rate)
            continue;
        if (bearing->interval < 0 || bearing->interval > bearing->knot_count - 2)
            return OUT_OF_TABLE;
        for (int above = 0; above < 2; above++) {
            const int64_t knot = bearing->interval + above;
            const int is_end = knot == 0 || knot == bearing->knot_count - 1;
            if (is_end && !work->has_torque) /* a prescribed speed only gets there */
                continue;
            const double point = passes_knot(work, bearing, above, work->step);
            if (point >= each->passed)
                continue;
            each->passed = point;
            each->next = bearing->interval + (above ? 1 : -1);
        }
        first = smaller(first, each->passed);
    }
    work->step = first;
    return DONE;
}

void pass_knots(struct work *work, double point)
{
    for (int64_t i = 0; i < work->run->bearing_count; i++) {
        const struct bearing_terms *each = &work->bearings->each[i];
        if (each->passed <= point)
            work->run->bearings[i].interval = each->next;
    }
}
