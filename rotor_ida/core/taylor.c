/* A motion led by Taylor series: one polynomial a step, read anywhere inside it.
 *
 * Order and step follow from the tolerance. A step of a contact is cut where one of its guards
 * would vanish inside it more than once, so no exit and no extremum is hidden. */
#include "motion.h"

/* The part of rounding below which a variable that should vanish is noise. */
static const double NOISE = 1e-13;
/* A step turns the fastest of the motions that the terms cannot show by no more than this part of
 * the order: beyond, a series that has died away to rounding would grow again. */
static const double FARTHEST = 0.25;
/* Of the sizes of the terms: a flight begins on the ring, with no radial velocity or acceleration,
 * where the square of the radius, or what its changes come from, adds up to less than this part. */
static const double FROM_THE_RING = 32.0 * ROUNDING;
enum { ROOTS_AT_A_START = 3 };
/* The logarithm of a step that nothing limits, as in a free fall: the highest power of such a step
 * is finite. */
static const double UNLIMITED = 23.0;
/* Terms fall by a factor exp(2) where the order is best; so many are looked at, as some may vanish:
 * the series of a radial entry has but every fifth. */
static const double FALL = 2.0, RATIO = 7.38905609893065;
enum { LOOKED_AT = 6, MOST_CUTS = 60 };
/* The moment of the slip counts as no more than so many times the angular momentum: of less a step
 * would become shorter, for digits that a series has anyway. */
static const double OF_MOMENTUM = 32.0;
/* After so many steps the load is put where it points. */
enum { STEPS_OF_LOAD = 4 };
/* The first columns of a contact: its guards, and all but the integrals that are behind its time.
 */
enum {
    GUARDS = CONTACT_P + 1,
    TO_BE_SEEN = 1 + (SPEED_CHANGES ? (int)CONTACT_ANGLE : (int)CONTACT_T)
};

/* The largest of the coefficients n, each in parts of its tolerance. */
static double worst_of(const struct taylor *taylor, int n, int components)
{
    double worst = 0.0, total = 0.0;
    for (int i = 0; i < components; i++) {
        const double part = fabs(taylor->series.terms[n][i]) * taylor->inverse[i];
        worst = larger(part, worst);
        total += part; /* NaN where one of them is */
    }
    return isnan(total) ? NAN : worst;
}

static double whole_power(double base, int exponent)
{
    double power = 1.0;
    for (; exponent > 0; exponent /= 2) {
        power *= exponent % 2 ? base : 1.0;
        base *= base;
    }
    return power;
}

/* The step at which the last terms of the first components reach their tolerances; NaN where a
 * term is not finite. Jorba and Zou 2005, section 3.2. */
static inline double longest_step(struct taylor *taylor, const int components, double rate)
{
    const int order = taylor->order;
    const double last = worst_of(taylor, order, components);
    const double before = worst_of(taylor, order - 1, components);
    if (!isfinite(last + before))
        return NAN;
    double longest = UNLIMITED;
    if (last > 0.0)
        longest = -log(last) / order;
    if (before > 0.0)
        longest = smaller(longest, (FALL - log(before)) / (order - 1));
    double step = exp(longest);
    if (rate > 0.0)
        step = smaller(step, FARTHEST * order / rate);
    /* others in case these vanish */
    const int first = order - LOOKED_AT + 1;
    const double growth = RATIO * step;
    evaluate(taylor->series.terms[first], WIDTH, components, LOOKED_AT - 3, growth, 1,
             taylor->sizes);
    const double scale = whole_power(growth, first) * taylor->fallen;
    int exceeds = 0; /* also where a power overflows, and a vanishing term makes it NaN */
    for (int i = 0; i < components; i++)
        exceeds |= !(scale * taylor->sizes[i] * taylor->inverse[i] <= 1.0);
    if (exceeds) {
        for (int n = first; n < order - 1; n++) {
            const double worst = worst_of(taylor, n, components);
            if (worst > 0.0)
                step = smaller(step, exp((FALL * (order + 1 - n) - log(worst)) / n));
        }
    }
    return step;
}

/* Whether a polynomial's own size of terms shows that it is monotonic on (0, step]: where the first
 * term of its slope outweighs all others. */
static int is_monotonic(const struct taylor *taylor, const double *terms, int apart, double step)
{
    double others = 0.0, scale = step;
    for (int n = 2; n <= taylor->order; n++) {
        scale *= step;
        others += n * scale * fabs(terms[n * apart]);
    }
    return others < step * fabs(terms[apart]);
}

/* Write what each power of a polynomial on (0, 1] adds to its Bernstein coefficients: power k adds
 * binomial(j, k)/binomial(order, k) to coefficient j. */
static void write_basis(struct taylor *taylor)
{
    const int order = taylor->order;
    for (int j = 0; j <= order; j++) {
        double share = 1.0;
        for (int k = 0; k <= j; k++) {
            taylor->basis[k][j] = share;
            share *= (double)(j - k) / (order > k ? order - k : 1);
        }
    }
    taylor->has_basis = 1;
}

/* How often the Bernstein coefficients of a polynomial on (0, step] change sign.
 *
 * By Descartes' rule it vanishes at most as often, or fewer times by an even number. None means no
 * root, one means one. Collins and Akritas, SYMSAC 1976. */
static int sign_changes(const struct taylor *taylor, const double *terms, int apart, double step)
{
    const int orders = taylor->order + 1;
    _Alignas(32) double total[32];
    for (int v = 0; v < orders; v += 4) {
        vec4 sum = spread(0.0);
        double scale = 1.0;
        for (int n = 0; n < orders; n++) {
            const vec4 power = spread(terms[n * apart] * scale);
            sum = fma4(power, load(&taylor->basis[n][v]), sum);
            scale *= step;
        }
        store(&total[v], sum);
    }
    int changes = 0;
    double last = 0.0;
    for (int j = 0; j < orders; j++) {
        if (total[j] != 0.0) {
            changes += total[j] * last < 0.0;
            last = total[j];
        }
    }
    return changes;
}

/* A step, cut so that a series, of which `size` is the sum of the terms at its end without their
 * signs, vanishes inside it at most once. Its terms are so far apart. */
static double with_one_zero(struct taylor *taylor, const double *terms, int apart, double size,
                            double step)
{
    if (size < 2.0 * fabs(terms[0]) || is_monotonic(taylor, terms, apart, step))
        return step;
    if (!taylor->has_basis)
        write_basis(taylor);
    for (int cut = 0; cut < MOST_CUTS && sign_changes(taylor, terms, apart, step) > 1; cut++)
        step *= 0.5;
    return step;
}

/* The same of a component. */
static double with_one_root(struct taylor *taylor, int component, double size, double step)
{
    return with_one_zero(taylor, &taylor->series.terms[0][component], WIDTH, size, step);
}

/* The fastest motion or decay of which a contact is capable, by u. */
static double rate_of_contact(const struct taylor *taylor)
{
    const struct parameters *model = &taylor->motion.model;
    const double q = fabs(taylor->series.terms[0][CONTACT_Q]);
    const double stiffening = damping_factor(model, fabs(taylor->series.terms[0][CONTACT_P]));
    return q
           * (speed_of(&taylor->motion, taylor->motion.before) + 2.0 * model->zeta
              + model->contact_damping * spring_of_root(model, q)
              + sqrt(model->shaft_stiffness + slope_of_root(model, q) * stiffening));
}

/* A step, cut so that the contact is released, or presses again, inside it at most once. */
static double with_one_release(struct taylor *taylor, double step)
{
    const struct parameters *model = &taylor->motion.model;
    if (model->contact_damping == 0.0)
        return step;
    double *first = &taylor->series.terms[0][CONTACT_P];
    const double velocity = *first, rest = taylor->sizes[CONTACT_P] - fabs(velocity);
    *first = velocity - release_velocity(model);
    step = with_one_root(taylor, CONTACT_P, rest + fabs(*first), step);
    *first = velocity;
    return step;
}

/* A step, cut so that the disc begins to slip inside it at most once in either sense. */
static double with_one_slip(struct taylor *taylor, double step)
{
    struct series *series = &taylor->series;
    const int order = taylor->order;
    double left[WATCHED][ORDERS] = {{0.0}}, sizes[WATCHED] = {0.0}, scale = 1.0, hold = 0.0;
    for (int n = 0; n < order; n++) { /* the last is not there */
        for (int i = 0; i < WATCHED; i++) {
            const double with_sign = (i == 0 ? -1.0 : 1.0) * series->watched[n][1];
            left[i][n] = series->watched[n][0] + with_sign;
            sizes[i] += fabs(left[i][n]) * scale;
        }
        hold += fabs(series->watched[n][1]) * scale;
        scale *= step;
    }
    if (hold <= hidden_hold(&taylor->motion, taylor->motion.before))
        return step;
    for (int i = 0; i < WATCHED; i++)
        step = with_one_zero(taylor, left[i], 1, sizes[i], step);
    return step;
}

/* The same for all that friction adds. */
static double with_one_change(struct taylor *taylor, double step)
{
    const struct motion *motion = &taylor->motion;
    if (HAS_FRICTION && motion->mode == &rolling_mode)
        return with_one_slip(taylor, step);
    if (HAS_FRICTION && motion->mode == &rub_mode && motion->model.sigma != 0.0)
        return with_one_root(taylor, RUB_ROLL_GUARD, taylor->sizes[RUB_ROLL_GUARD], step);
    return step;
}

/* How far the series of a contact may be followed. */
static double contact_step(struct taylor *taylor)
{
    const double q = fabs(taylor->series.terms[0][CONTACT_Q]);
    double step = longest_step(taylor, CONTACT_T, rate_of_contact(taylor));
    evaluate(taylor->series.terms[0], WIDTH, GUARDS, taylor->order, step, 1, taylor->sizes);
    /* on a whirl of constant radius p is rounding, and what a step leaves open */
    const double noise = larger(NOISE, taylor->motion.rtol) * q / step;
    step = with_one_root(taylor, CONTACT_EXIT_GUARD, taylor->sizes[CONTACT_EXIT_GUARD], step);
    if (taylor->sizes[CONTACT_EXTREMUM_GUARD] > noise)
        step = with_one_root(taylor, CONTACT_EXTREMUM_GUARD, taylor->sizes[CONTACT_EXTREMUM_GUARD],
                             step);
    return IS_WHOLE ? with_one_change(taylor, with_one_release(taylor, step)) : step;
}

/* A step, cut so that a speed that a torque drives, if it may fall to 0, turns at most once. */
static double with_one_turn(struct taylor *taylor, double step)
{
    const struct motion *motion = &taylor->motion;
    if (!is_driven(motion) || isnan(step))
        return step;
    const int column = is_contact(motion) ? (int)CONTACT_SPEED : (int)CARTESIAN_SPEED;
    double rates[ORDERS] = {0.0}, size = 0.0, change = 0.0, scale = 1.0;
    for (int n = 0; n < taylor->order; n++) {
        rates[n] = (n + 1) * taylor->series.terms[n + 1][column];
        size += fabs(rates[n]) * scale;
        scale *= step;
        change += fabs(taylor->series.terms[n + 1][column]) * scale;
    }
    return change < speed_of(motion, motion->before) ? step
                                                     : with_one_zero(taylor, rates, 1, size, step);
}

/* A radius inside which the force changes the velocity by less than the tolerance.
 *
 * The time inside is at most r/speed or sqrt(2 r/push), and the force below r**1.5. */
static double unfelt(const struct taylor *taylor)
{
    const double *state = taylor->motion.values, part = 1e-2 * taylor->motion.rtol;
    const double square = state[CARTESIAN_VX] * state[CARTESIAN_VX]
                          + state[CARTESIAN_VY] * state[CARTESIAN_VY];
    const double omega = speed_of(&taylor->motion, state);
    const double push = part * omega * omega + part * taylor->motion.model.load;
    if (taylor->motion.model.linear > 0.0) /* a force of r is felt farther in */
        return larger(sqrt(part * square), push);
    return larger(to_power(part * square, 0.4), to_power(push, 2.0 / 3.0));
}

/* How far the series of a rotor without clearance may be followed. */
static double cartesian_step(struct taylor *taylor, double inner)
{
    const double *state = taylor->motion.before;
    const struct parameters *model = &taylor->motion.model;
    const double radius = length((struct vector){state[CARTESIAN_X], state[CARTESIAN_Y]});
    const double speed = length((struct vector){state[CARTESIAN_VX], state[CARTESIAN_VY]});
    const double slope = slope_of_root(model, sqrt(radius));
    const double rate = speed_of(&taylor->motion, state) + 2.0 * model->zeta
                        + sqrt(model->shaft_stiffness + slope);
    const double more = model->load + model->shaft_stiffness * radius
                        + (radius > inner ? slope * radius : 0.0);
    double step = longest_step(taylor, CARTESIAN_SIZE, rate);
    double within = radius <= inner ? inner : 0.0;
    /* nor beyond the axis: where the rotor comes to rest there, under a load, its series goes on
     * through it, but as if the force repelled */
    if (HAS_LOAD && model->hertz > 0.0 && radius > inner)
        within = radius;
    if (within > 0.0) {
        const double omega = speed_of(&taylor->motion, state);
        const double push = omega * omega + 2.0 * model->zeta * speed + more;
        step = smaller(step, 2.0 * within / (speed + sqrt(speed * speed + 2.0 * push * within)));
    }
    return step;
}

/* Write the series of the state, and the factors of differences; or by the fewest products. */
static void expand(struct taylor *taylor)
{
    const struct parameters *m = &taylor->motion.model;
    const struct mode *mode = taylor->motion.mode;
    if (HAS_NEIGHBOURS && taylor->motion.tangents)
        mode->expand_with_factors(m, &taylor->series, taylor->order);
    else if (!SPEED_CHANGES || m->inverse_inertia > 0.0)
        mode->expand(m, &taylor->series, taylor->order);
    else if (is_plain(m))
        mode->expand_plain(m, &taylor->series, taylor->order);
    else
        mode->expand_prescribed(m, &taylor->series, taylor->order);
}

/* How far the series of a flight may be followed: so that the radius passes that of the ring inside
 * it at most once after its beginning, which may lie there, and turns at most once. */
static double flight_step(struct taylor *taylor)
{
    const struct parameters *model = &taylor->motion.model;
    const double delta0 = model->delta0;
    const double rate = speed_of(&taylor->motion, taylor->motion.before) + 2.0 * model->zeta
                        + sqrt(model->shaft_stiffness);
    double step = longest_step(taylor, CARTESIAN_SIZE, rate);
    if (isnan(step))
        return NAN;
    /* |z|**2 - delta0**2, the same after its roots at 0, and its rate of change after those */
    double square[ORDERS] = {0.0}, later[ORDERS] = {0.0}, turning[ORDERS] = {0.0};
    double terms[ORDERS][2], sizes[2] = {0.0}, scale = 1.0;
    int on_ring = 0;
    for (int n = 0; n <= taylor->order; n++) {
        double size = n == 0 ? delta0 * delta0 : 0.0;
        memcpy(terms[n], &taylor->series.terms[n][CARTESIAN_X], sizeof terms[n]);
        square[n] = -size;
        for (int k = 0; k <= n; k++) {
            const double product[] = {terms[k][0] * terms[n - k][0], terms[k][1] * terms[n - k][1]};
            square[n] += product[0] + product[1];
            size += fabs(product[0]) + fabs(product[1]);
        }
        if (on_ring == n && n < ROOTS_AT_A_START && fabs(square[n]) <= FROM_THE_RING * size)
            on_ring++;
    }
    const int at_rest = on_ring > 1 ? on_ring - 1 : 0;
    for (int n = 0; n < taylor->order - at_rest; n++) {
        later[n] = square[n + on_ring];
        turning[n] = (n + 1 + at_rest) * square[n + 1 + at_rest];
        sizes[0] += fabs(later[n]) * scale;
        sizes[1] += fabs(turning[n]) * scale;
        scale *= step;
    }
    /* on a whirl of constant radius all this is rounding */
    const double farthest = square[0] + delta0 * delta0;
    const double noise = larger(NOISE, taylor->motion.rtol) * farthest / step;
    if (sizes[0] > (on_ring ? noise : NOISE * farthest))
        step = with_one_zero(taylor, later, 1, sizes[0], step);
    if (sizes[1] > noise)
        step = with_one_zero(taylor, turning, 1, sizes[1], step);
    return step;
}

/* Write the series of the differences; return the step at which the last two terms of each reach
 * its tolerance. */
static double step_of_differences(struct taylor *taylor)
{
    struct series *series = &taylor->series;
    const int order = taylor->order;
    const struct motion *motion = &taylor->motion;
    memcpy(series->apart[0], &motion->values[motion->mode->size], sizeof series->apart[0]);
    motion->mode->expand_differences(&motion->model, series, order);
    double last = 0.0, before = 0.0;
    for (int i = 0; i < DIFFERENCES; i++) {
        double size = 0.0, terms = 0.0, lower = 0.0;
        for (int j = i; j < APART; j += DIFFERENCES) {
            size = larger(size, larger(fabs(series->apart[0][j]), fabs(series->apart[1][j])));
            terms = larger(terms, fabs(series->apart[order][j]));
            lower = larger(lower, fabs(series->apart[order - 1][j]));
        }
        if (size > 0.0) {
            last = larger(last, terms / (motion->rtol * size));
            before = larger(before, lower / (motion->rtol * size));
        }
    }
    double step = INFINITY;
    if (last > 0.0)
        step = to_power(last, -1.0 / order);
    if (before > 0.0)
        step = smaller(step, to_power(before, -1.0 / (order - 1)));
    return step;
}

/* Write the values at a part of the step; there is room for more than the state. */
static inline void read(const struct taylor *taylor, const int columns, double part, double *values)
{
    const struct motion *motion = &taylor->motion;
    evaluate(taylor->series.terms[0], WIDTH, columns, taylor->order, part, 0, values);
    if (motion->tangents)
        evaluate(taylor->series.apart[0], APART, APART, taylor->order, part, 0,
                 &values[motion->mode->size]);
}

static int restart(struct motion *motion, const double *start, const double *atol)
{
    struct taylor *taylor = taylor_of(motion);
    motion->low = motion->point = 0.0;
    copy_values(motion, start, motion->values);
    copy_values(motion, start, motion->before);
    memcpy(taylor->atol, atol, sizeof(double) * (size_t)motion->mode->size);
    taylor->orders = taylor->steps = 0;
    return DONE;
}

static void begin_step(struct taylor *taylor)
{
    struct motion *motion = &taylor->motion;
    const int size = motion->mode->size;
    motion->low = motion->point;
    taylor->orders += taylor->order;
    if (motion->tangents) {
        for (int j = 0; j < APART; j++)
            motion->values[size + j] = j % (DIFFERENCES + 1) == 0 ? 1.0 : 0.0;
    }
    copy_values(motion, motion->values, motion->before);
    for (int i = 0; i < size; i++)
        taylor->series.terms[0][i] = motion->values[i];
    /* no step is chosen by the integrals of a contact */
    const int chosen_by = is_contact(motion) ? (int)CONTACT_T : size;
    for (int i = 0; i < chosen_by; i++)
        taylor->inverse[i] = 1.0 / (motion->rtol * fabs(motion->values[i]) + taylor->atol[i]);
    if (HAS_FRICTION && motion->mode == &rub_mode) {
        const double slip = size_of_slip(motion, motion->values, OF_MOMENTUM);
        taylor->inverse[RUB_SLIP] = 1.0 / (motion->rtol * slip + taylor->atol[RUB_SLIP]);
    }
}

/* Put the direction of a contact back on the unit circle, off which each step carries it a little:
 * with its length the unbalance would change. What is left is the square of how far it was. */
static void put_on_circle(double *direction)
{
    const double c = direction[0], s = direction[1];
    const double nearer = 1.5 - 0.5 * (c * c + s * s);
    direction[0] = nearer * c;
    direction[1] = nearer * s;
}

static int advance(struct motion *motion)
{
    struct taylor *taylor = taylor_of(motion);
    const struct mode *mode = motion->mode;
    begin_step(taylor);
    double inner = 0.0;
    const int flies = !HAS_CLOSED_FLIGHT && mode == &cartesian_mode && motion->model.delta0 > 0.0;
    if (mode == &cartesian_mode && !flies) {
        inner = unfelt(taylor);
        const struct vector here = {motion->values[CARTESIAN_X], motion->values[CARTESIAN_Y]};
        motion->model.felt = length(here) > inner ? 1.0 : 0.0;
    }
    expand(taylor);
    double step = flies                ? flight_step(taylor)
                  : is_contact(motion) ? contact_step(taylor)
                                       : cartesian_step(taylor, inner);
    step = with_one_turn(taylor, step);
    if (HAS_NEIGHBOURS && motion->tangents && !isnan(step))
        step = smaller(step, step_of_differences(taylor));
    if (isnan(step))
        return NOT_FINITE;
    motion->point = motion->low + step;
    if (motion->point <= motion->low)
        return STUCK;
    read(taylor, WIDTH, motion->point - motion->low, motion->values);
    if (is_contact(motion))
        put_on_circle(&motion->values[CONTACT_C]);
    if (HAS_LOAD && ++taylor->steps % STEPS_OF_LOAD == 0)
        put_load_right(motion, motion->values, motion->point);
    double total = 0.0;
    for (int i = 0; i < values_of(motion); i++)
        total += motion->values[i];
    if (!isfinite(total)) {
        copy_values(motion, motion->before, motion->values);
        return NOT_FINITE;
    }
    return DONE;
}

static const double *glance_at(struct motion *motion, double point)
{
    struct taylor *taylor = taylor_of(motion);
    read(taylor, TO_BE_SEEN, point - motion->low, taylor->reading);
    return taylor->reading;
}

static const double *at(struct motion *motion, double point)
{
    if (point >= motion->point)
        return motion->values;
    if (point <= motion->low)
        return motion->before;
    struct taylor *taylor = taylor_of(motion);
    read(taylor, WIDTH, point - motion->low, taylor->reading);
    return taylor->reading;
}

static const double *rate(struct motion *motion) { return taylor_of(motion)->series.terms[1]; }

static int64_t evaluations(struct motion *motion) { return taylor_of(motion)->orders; }

/* The order at which a given accuracy takes the least work: 1 - ln(eps)/2 [Jorba and Zou 2005]. */
static int order_for(double rtol)
{
    const double order = ceil(1.0 - 0.5 * log(rtol));
    return (int)fmin(fmax(order, LOWEST_ORDER), HIGHEST_ORDER);
}

void open_taylor(struct taylor *taylor, const struct mode *mode, struct parameters model,
                 double rtol, int tangents)
{
    memset(taylor, 0, sizeof *taylor);
    const int order = taylor->order = order_for(rtol);
    taylor->fallen = 1.0 / whole_power(RATIO, order + 1);
    taylor->motion = (struct motion){.mode = mode,
                                     .model = model,
                                     .rtol = rtol,
                                     .tangents = tangents,
                                     .begins_anew = 1,
                                     .restart = restart,
                                     .advance = advance,
                                     .at = at,
                                     .glance_at = glance_at,
                                     .rate = rate,
                                     .evaluations = evaluations,
                                     .spend = IS_WHOLE ? spend : NULL};
}

/* The step of the secant or of inverse quadratic interpolation, as p/q with p > 0. */
static void interpolated(const double x[3], const double f[3], double *p, double *q)
{
    const double a = x[0], b = x[1], c = x[2], s = f[1] / f[0];
    if (a == c) {
        *p = (c - b) * s;
        *q = 1.0 - s;
    } else {
        const double t = f[0] / f[2], r = f[1] / f[2];
        *p = s * ((c - b) * t * (t - r) - (b - a) * (r - 1.0));
        *q = (t - 1.0) * (r - 1.0) * (s - 1.0);
    }
    if (*p > 0.0)
        *q = -*q;
    else
        *p = -*p;
}

/* What is sought: a function of the values and its level, or a guard. */
struct sought {
    double (*function)(const double *values);
    double level;
    int guard;
};

static inline __attribute__((always_inline)) double
value_of(struct motion *motion, const struct sought *sought, double point)
{
    if (IS_WHOLE && sought->function == NULL)
        return margin_of(motion, (enum guard)sought->guard, motion->at(motion, point), NULL);
    return sought->function(motion->at(motion, point)) - sought->level;
}

static double root_of(struct motion *motion, const struct sought sought, double low, double high)
{
    double a = low, b = high;
    double fa = value_of(motion, &sought, a);
    double fb = value_of(motion, &sought, b);
    if (fa == 0.0)
        return a;
    if (fa * fb > 0.0 || isnan(fa) || isnan(fb))
        return NAN;
    double c = a, fc = fa, step = b - a, last = step;
    for (int i = 0; i < 200; i++) {
        if (fb * fc > 0.0) {
            c = a;
            fc = fa;
            step = last = b - a;
        }
        if (fabs(fc) < fabs(fb)) {
            a = b;
            b = c;
            c = a;
            fa = fb;
            fb = fc;
            fc = fa;
        }
        const double tolerance = 2.0 * ROUNDING * fabs(b), half = 0.5 * (c - b);
        if (fabs(half) <= tolerance || fb == 0.0)
            break;
        double p = 0.0, q = 0.0;
        int taken = 0;
        if (fabs(last) >= tolerance && fabs(fa) > fabs(fb)) {
            interpolated((double[]){a, b, c}, (double[]){fa, fb, fc}, &p, &q);
            taken = 2.0 * p < smaller(3.0 * half * q - fabs(tolerance * q), fabs(last * q));
        }
        last = taken ? step : half;
        step = taken ? p / q : half;
        a = b;
        fa = fb;
        b += fabs(step) > tolerance ? step : copysign(tolerance, half);
        fb = value_of(motion, &sought, b);
    }
    return b;
}

double root_in_step(struct motion *motion, double (*function)(const double *values), double level,
                    double low, double high)
{
    return root_of(motion, (struct sought){function, level, 0}, low, high);
}

double root_of_guard(struct motion *motion, enum guard guard, double low, double high)
{
    return root_of(motion, (struct sought){NULL, 0.0, (int)guard}, low, high);
}
