/* The contacts of a rotor system: what ends the mode of one, and what follows. */
#include "system_work.h"

/* Where contacts enter together, or without a radial velocity, flight goes on to an indentation of
 * this part of the clearance. */
static const double PASSED = 1e-11;
/* Error of a displacement after some steps, in parts of their tolerance. */
static const double SLACK = 10.0;
/* Contacts whose roots are less than this part of that of the clearance end together. */
static const double TOGETHER = 1e-7;
/* Nearer to the stator, in clearances, rounding decides on which side a contact is. */
static const double SIDE = 8.0 * 2.220446049250313e-16;
/* Below this part of the scale of velocity, rounding decides whether a contact on the stator
 * opens. */
static const double STILL = 1e-15;
/* Below this part of the largest grip of the contact, the force that rolling needs is lost in
 * rounding. */
static const double HIDDEN = 1e-12;
/* Rounding of a sum, in parts of the sizes of its terms: of a slip, and of a rate of slip. */
static const double ROUNDED = 64.0 * 2.220446049250313e-16;
/* Shortest interval, in steps, in which two zeros are told apart. */
static const double SHORTEST = 1e-15;
/* A correction of a zero is at most this part of its step. */
static const double CORRECTED = 1e-6;
/* A zero is found where rounding hides it: to this part of itself; and the most steps to it. */
static const double CLOSE = 4e-16;
enum { MOST_SWEEPS = 500, MOST_NEWTON = 200, GAP_TERMS = 2 * ORDERS };

void set_element(struct touching *each)
{
    const struct system_law *law = each->law;
    const int slides = each->touch->mode == SLIDES_FORWARDS
                       || each->touch->mode == SLIDES_BACKWARDS;
    each->element = (struct element){
        .clearance = law->clearance,
        .hertz = law->hertz,
        .linear = law->linear,
        .contact_damping = law->contact_damping,
        .loose = pushes(each) ? 0.0 : 1.0,
        .friction = law->friction,
        .sigma = slides ? each->touch->sense : 0.0,
        .radius = law->radius,
        .race_radius = law->race_radius,
        .mobility = each->stator_mobility,
        .holding = each->touch->mode == ROLLS ? inverse(each->stator_mobility) : 0.0,
        .squared = is_spring(each) ? 0.0 : 1.0,
    };
}

/* Write coefficients up to `last` of a b + c d, of series up to an order: eight side by side, as a
 * sum in memory would wait for itself. */
static void write_product(int order, int last, const double *a, const double *b, const double *c,
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

/* ---- Zeros of polynomials ---- */

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

/* ---- Guards ---- */

static double guard_of_gap(const struct work *work, const struct touching *each, double step)
{
    double gap[GAP_TERMS], x[ORDERS] = {0.0}, y[ORDERS] = {0.0};
    const int order = work->order;
    for (int n = 0; n <= order; n++) {
        x[n] = each->series.terms[n][ELEMENT_X];
        y[n] = each->series.terms[n][ELEMENT_Y];
    }
    /* the whole product: cut off at the order it would be less exact than its factors */
    write_product(order, 2 * order, x, x, y, y, gap);
    for (int n = 0; n <= 2 * order; n++)
        gap[n] = (n == 0 ? each->law->clearance * each->law->clearance : 0.0) - gap[n];
    /* beyond the stator by an error of the step, and on the way from it: it has just left */
    const double clearance = each->law->clearance;
    const double apart = 2.0 * clearance * clearance * fmax(PASSED, SLACK * work->run->rtol);
    if (gap[0] < 0.0 && gap[0] >= -apart && gap[1] > 0.0)
        gap[0] = 0.0;
    return first_fall(gap, 1, 2 * order, step, each->touch->zeros[OF_ROOT]);
}

static double guard_of_release(const struct work *work, const struct touching *each, double step)
{
    double factor[ORDERS];
    const double sign = pushes(each) ? 1.0 : -1.0;
    for (int n = 0; n <= work->order; n++)
        factor[n] = sign * element_factor(&each->element, n, each->answers[n][ELEMENT_APPROACH]);
    return first_fall(factor, 1, work->order, step, each->touch->zeros[OF_RELEASE]);
}

static double guard_of_slip(const struct work *work, const struct touching *each, double step)
{
    double left[ORDERS];
    if (each->touch->mode != ROLLS) {
        for (int n = 0; n <= work->order; n++)
            left[n] = each->touch->sense * each->answers[n][ELEMENT_SLIP];
        return first_fall(left, 1, work->order, step, each->touch->zeros[OF_SLIP]);
    }
    double first = INFINITY, size = 0.0, pressed = 0.0, scale = 1.0;
    for (int n = 0; n < work->order; n++) {
        size += fabs(each->drag[n]) * scale;
        pressed += fabs(each->answers[n][ELEMENT_PUSH]) * scale;
        scale *= step;
    }
    const double largest = fmax(work->run->open[each - work->touching].hardest.value, pressed);
    if (size <= fmax(HIDDEN * each->law->friction * largest, each->hidden))
        return INFINITY;
    for (int side = 0; side < 2; side++) {
        for (int n = 0; n < work->order; n++)
            left[n] = grip_of(each, n) - (side ? -1.0 : 1.0) * each->drag[n];
        /* on a stator without mass it has just begun, at this limit */
        const int zeros = (each->touch->sense < 0.0) == side ? each->touch->zeros[OF_SLIP] : 0;
        first = smaller(first, first_fall(left, 1, work->order - 1, step, zeros));
    }
    return first;
}

struct happening first_happening(struct work *work, double step)
{
    struct happening first = {INFINITY, -1, OF_ROOT};
    for (int i = 0; i < (int)work->run->contact_count; i++) {
        const struct touching *each = &work->touching[i];
        double points[GUARDS] = {INFINITY, INFINITY, INFINITY};
        if (!is_touching(each)) {
            points[OF_ROOT] = guard_of_gap(work, each, step);
        } else if (!is_centred(each)) {
            points[OF_ROOT] = first_fall(&each->series.terms[0][ELEMENT_ROOT], WIDTH, work->order,
                                         step, each->touch->zeros[OF_ROOT]);
            if (each->law->contact_damping > 0.0)
                points[OF_RELEASE] = guard_of_release(work, each, step);
            if (each->law->friction > 0.0 && pushes(each))
                points[OF_SLIP] = guard_of_slip(work, each, step);
        }
        for (int guard = 0; guard < GUARDS; guard++) {
            if (points[guard] < first.point)
                first = (struct happening){points[guard], i, guard};
        }
        if (first.point < step) /* no other is looked for beyond it */
            step = first.point;
    }
    return first;
}

/* ---- Rolling and sliding ---- */

/* Write the values of a contact at the state of the run. */
static void values_of_touch(const struct work *work, const struct touching *each, double *answers)
{
    const struct system_run *run = work->run;
    double given[ELEMENT_GIVEN];
    for (int j = 0; j < 2; j++) {
        const double *row = each->rows + j * work->stride;
        given[ELEMENT_X + j] = sum_of_products(row, run->state, work->stride)
                               - each->law->offset[j];
        given[ELEMENT_VX + j] = sum_of_products(row, run->state + work->stride, work->stride);
    }
    given[ELEMENT_ROOT] = is_touching(each) ? each->touch->root : 0.0;
    given[ELEMENT_SPIN] = run->speed;
    given[ELEMENT_RACE] = each->touch->race;
    if (each->stator_mobility == 0.0) {
        element_values(&each->element, given, answers);
        return;
    }
    const double *v = run->state + work->stride;
    for (int64_t i = run->size - run->massless; i < run->size; i++) {
        const double push = drift_of(run, run->state, run->force[i], i) - v[i];
        given[ELEMENT_VX] += each->rows[i] * push;
        given[ELEMENT_VY] += each->rows[work->stride + i] * push;
    }
    massless_values(&each->element, given, answers);
}

double radius_of_touch(const struct work *work, const struct touching *each)
{
    double at[2];
    for (int j = 0; j < 2; j++)
        at[j] = sum_of_products(each->rows + j * work->stride, work->run->state, work->stride)
                - each->law->offset[j];
    return sqrt(at[0] * at[0] + at[1] * at[1]);
}

/* Take the rate of the spin out of what is implicit. */
static void eliminate_spin(struct work *work)
{
    const int s = work->rolls;
    for (int i = 0; i < s && work->has_torque; i++) {
        const double factor = work->matrix[i][s] / work->matrix[s][s];
        for (int j = 0; j < s; j++)
            work->matrix[i][j] -= factor * work->matrix[s][j];
        work->right[i] -= factor * work->right[s];
    }
}

/* The forces, each within its grip, by which the slips of all contacts that do not slide stay 0, or
 * begin in the sense of a force at its limit: the least of F G F/2 - b F in that box. */
static void hold_in_box(const struct work *work, const double *grip, double *force)
{
    for (int i = 0; i < work->rolls; i++)
        force[i] = 0.0;
    for (int sweep = 0; sweep < MOST_SWEEPS; sweep++) {
        double moved = 0.0;
        for (int i = 0; i < work->rolls; i++) {
            double left = work->right[i];
            for (int j = 0; j < work->rolls; j++)
                left -= j != i ? work->matrix[i][j] * force[j] : 0.0;
            const double held = fmin(fmax(ratio(left, work->matrix[i][i]), -grip[i]), grip[i]);
            moved = fmax(moved, fabs(held - force[i]) / (fabs(held) + fabs(force[i]) + 1e-300));
            force[i] = held;
        }
        if (moved <= 1e-15 || work->rolls == 1)
            return;
    }
}

/* The sum of the sizes of the terms of a displacement, or of its rates. */
static double size_across(const struct work *work, const struct touching *each, const double *row)
{
    double size = 0.0;
    for (int64_t i = 0; i < work->stride; i++)
        size += (fabs(each->rows[i]) + fabs(each->rows[work->stride + i])) * fabs(row[i]);
    return size;
}

/* The tangential force below which rounding hides the one that rolling needs. */
static double hidden_hold(const struct work *work, const struct touching *each, double mobility)
{
    const double pull = size_across(work, each, work->acceleration);
    return ROUNDED * ratio(pull + fabs(each->answers[0][ELEMENT_TURNING]), mobility);
}

/* The slip below which rounding hides it. */
static double hidden_slip(const struct work *work, const struct touching *each)
{
    const struct system_run *run = work->run;
    return ROUNDED
           * (size_across(work, each, run->state + work->stride)
              + fabs(each->law->radius * run->speed)
              + fabs(each->law->race_radius * each->touch->race));
}

int settle(struct work *work)
{
    double grip[MOST_CONTACTS], force[MOST_CONTACTS];
    begin_terms(work);
    if (work->rolls == 0)
        return DONE;
    ask_implicit(work);
    eliminate_spin(work);
    for (int i = 0; i < work->rolls; i++) {
        const struct touching *each = &work->touching[work->rolling[i]];
        grip[i] = grip_of(each, 0);
    }
    hold_in_box(work, grip, force);
    for (int i = 0; i < work->rolls; i++) {
        struct touching *each = &work->touching[work->rolling[i]];
        double left = work->right[i]; /* the rate of slip that is not held */
        for (int j = 0; j < work->rolls; j++)
            left -= work->matrix[i][j] * force[j];
        each->hidden = hidden_hold(work, each, work->matrix[i][i]);
        const int is_held = fabs(force[i]) < grip[i]
                            || fabs(left) <= each->hidden * work->matrix[i][i];
        if (is_held)
            continue;
        each->touch->sense = (grip[i] > 0.0 ? force[i] : left) > 0.0 ? 1.0 : -1.0;
        each->touch->mode = each->touch->sense > 0.0 ? SLIDES_FORWARDS : SLIDES_BACKWARDS;
        each->touch->zeros[OF_SLIP] = 1;
    }
    return DONE;
}

/* Settle, and record a slip of every contact that rolled before but for one. */
static int settle_others(struct work *work, int but)
{
    struct system_run *run = work->run;
    int rolled[MOST_CONTACTS];
    for (int i = 0; i < (int)run->contact_count; i++)
        rolled[i] = i != but && run->touches[i].mode == ROLLS;
    const int status = settle(work);
    for (int i = 0; i < (int)run->contact_count; i++) {
        if (rolled[i] && run->touches[i].mode != ROLLS)
            record_system_event(run, SLIP, i);
    }
    return status;
}

/* How a contact with these values, in which it does not rub, goes on that is not loose, but for
 * friction that may hold it. A stator without mass may follow at once. */
static void slide(const struct work *work, struct touching *each, const double *answers)
{
    const double slip = answers[ELEMENT_SLIP], hidden = hidden_slip(work, each);
    const double followed = each->stator_mobility * each->law->friction * answers[ELEMENT_PUSH];
    const int is_still = fabs(slip) <= fmax(hidden, followed);
    each->hidden = ratio(hidden, each->stator_mobility);
    each->touch->sense = slip < 0.0 ? -1.0 : 1.0;
    each->touch->mode = slip < 0.0 ? SLIDES_BACKWARDS : SLIDES_FORWARDS;
    if (is_still && each->law->friction > 0.0)
        each->touch->mode = ROLLS; /* until `settle` says */
}

/* ---- What happens ---- */

static void open_episode(struct work *work, int contact, double entry)
{
    struct system_run *run = work->run;
    run->open[contact] = (struct episode){.contact = contact,
                                          .entry = entry,
                                          .exit = NAN,
                                          .deepest = {run->touches[contact].root, run->time},
                                          .hardest = {0.0, NAN}};
}

/* Let contacts that touch at this very time, or that do not cross the stator at a speed, pass it:
 * the fictitious time would stand still. */
static void pass_edge(struct work *work)
{
    struct system_run *run = work->run;
    double span = 0.0;
    expand_system(work, 1);
    for (int i = 0; i < (int)run->contact_count; i++) {
        const struct touching *each = &work->touching[i];
        if (!may_leave(each) || each->touch->root > 0.0)
            continue;
        const double *answers = each->answers[0], *row = work->acceleration;
        const double approach = fmax(answers[ELEMENT_APPROACH], 0.0);
        const double outwards =
            answers[ELEMENT_NORMAL_X] * sum_of_products(each->rows, row, work->stride)
            + answers[ELEMENT_NORMAL_Y]
                  * sum_of_products(each->rows + work->stride, row, work->stride);
        const double depth = PASSED * each->law->clearance;
        double needed = approach > 0.0 ? depth / approach : INFINITY;
        if (outwards > 0.0)
            needed = smaller(needed, sqrt(2.0 * depth / outwards));
        span = needed < INFINITY ? fmax(span, needed) : span;
    }
    double *y = run->state, *v = run->state + work->stride;
    for (int64_t i = 0; i < run->size; i++) {
        y[i] += (v[i] + 0.5 * work->acceleration[i] * span) * span;
        v[i] += work->acceleration[i] * span;
    }
    if (work->has_torque) {
        run->angle += run->speed * span;
        run->speed += work->spin_rate[0] * span;
    }
    run->time += span;
    if (!work->has_torque)
        turn_as_prescribed(run);
    for (int i = 0; i < (int)run->contact_count; i++) {
        struct touching *each = &work->touching[i];
        if (may_leave(each) && each->touch->root == 0.0) {
            const double depth = radius_of_touch(work, each) - each->law->clearance;
            each->touch->root = root_of(each, fmax(depth, PASSED * PASSED * each->law->clearance));
            each->touch->zeros[OF_ROOT] = 0;
        }
    }
}

/* Begin a contact, where it has reached the stator. */
static void enter_contact(struct work *work, int contact, double entry)
{
    struct touching *each = &work->touching[contact];
    double answers[ELEMENT_ANSWERS];
    set_element(each);
    values_of_touch(work, each, answers);
    each->touch->root = 0.0;
    slide(work, each, answers);
    each->touch->zeros[OF_ROOT] = 1;
    open_episode(work, contact, entry);
    if (!isnan(entry))
        record_system_event(work->run, ENTRY, contact);
}

static int happens_entry(struct work *work, int contact)
{
    struct system_run *run = work->run;
    double answers[ELEMENT_ANSWERS];
    enter_contact(work, contact, run->time);
    values_of_touch(work, &work->touching[contact], answers);
    int together = answers[ELEMENT_APPROACH] <= TOGETHER * run->velocity;
    for (int i = 0; i < (int)run->contact_count; i++) {
        struct touching *each = &work->touching[i];
        if (is_touching(each))
            continue;
        set_element(each);
        values_of_touch(work, each, answers);
        const double gap = each->law->clearance - radius_of_touch(work, each);
        if (gap <= PASSED * each->law->clearance && answers[ELEMENT_APPROACH] > 0.0) {
            enter_contact(work, i, run->time);
            together = 1;
        }
    }
    const int status = settle(work);
    if (status == DONE && together) {
        begin_terms(work);
        pass_edge(work);
    }
    return status;
}

static void leave_contact(struct work *work, int contact)
{
    struct system_run *run = work->run;
    struct touching *each = &work->touching[contact];
    each->touch->mode = FLIES;
    each->touch->root = 0.0;
    each->touch->zeros[OF_ROOT] = 1;
    run->open[contact].exit = run->time;
    run->episodes[run->episode_count++] = run->open[contact];
    record_system_event(run, EXIT, contact);
}

/* Whether a contact is all but at its end. */
static int is_at_end(const struct work *work, const struct touching *each)
{
    if (!is_touching(each)
        || each->touch->root >= root_of(each, TOGETHER * TOGETHER * each->law->clearance))
        return 0;
    double answers[ELEMENT_ANSWERS];
    values_of_touch(work, each, answers);
    return answers[ELEMENT_APPROACH] < 0.0;
}

static int happens_exit(struct work *work, int contact)
{
    leave_contact(work, contact);
    for (int i = 0; i < (int)work->run->contact_count; i++) {
        if (is_at_end(work, &work->touching[i]))
            leave_contact(work, i);
    }
    return settle_others(work, -1);
}

int leave_together(struct work *work)
{
    int count = 0, last = -1;
    for (int i = 0; i < (int)work->run->contact_count; i++) {
        if (is_at_end(work, &work->touching[i])) {
            count++;
            last = i;
        }
    }
    return count > 1 ? happens_exit(work, last) : DONE;
}

/* A contact is loose from here on, or no longer. */
static int release_or_press(struct work *work, int contact)
{
    struct touching *each = &work->touching[contact];
    const int loosens = pushes(each);
    if (loosens) {
        each->touch->mode = IS_LOOSE;
    } else {
        double answers[ELEMENT_ANSWERS];
        values_of_touch(work, each, answers);
        slide(work, each, answers);
    }
    each->touch->zeros[OF_RELEASE] = 1;
    record_system_event(work->run, loosens ? RELEASE : PRESS, contact);
    return settle_others(work, contact);
}

/* Surfaces stop sliding, or a hold gives way. */
static int happens_to_slip(struct work *work, int contact)
{
    struct touching *each = &work->touching[contact];
    struct system_touch *touch = each->touch;
    if (touch->mode == ROLLS) {
        const double drag = polynomial(each->drag, 1, work->order - 1, work->step);
        touch->sense = drag > 0.0 ? 1.0 : -1.0;
        touch->mode = drag > 0.0 ? SLIDES_FORWARDS : SLIDES_BACKWARDS;
        /* its rate is 0 as well, but for a stator without mass */
        each->touch->zeros[OF_SLIP] = each->stator_mobility > 0.0 ? 1 : 2;
        record_system_event(work->run, SLIP, contact);
        return DONE;
    }
    const double sense = touch->sense;
    touch->mode = ROLLS;
    touch->zeros[OF_SLIP] = each->stator_mobility > 0.0 ? 1 : 0;
    const int status = settle_others(work, contact);
    if (touch->mode == ROLLS)
        record_system_event(work->run, ROLL, contact);
    else if (touch->sense != sense)
        record_system_event(work->run, REVERSE, contact);
    return status;
}

static double slope_at(const double *terms, int apart, int order, double point)
{
    double slope = 0.0;
    for (int n = order; n >= 1; n--)
        slope = fma(slope, point, n * terms[n * apart]);
    return slope;
}

/* How fast a guard falls at its zero, by time: the radius or the radial velocity, the slip, or the
 * grip that is left. */
static double rate_of_guard(struct work *work, struct happening what)
{
    struct touching *each = &work->touching[what.contact];
    const double *terms = each->answers[0], point = what.point;
    const int order = work->order;
    if (what.guard == OF_ROOT) { /* the series of an exit has the pace 0 there */
        double answers[ELEMENT_ANSWERS];
        set_element(each);
        values_of_touch(work, each, answers);
        return fabs(answers[ELEMENT_APPROACH]);
    }
    double slope = 0.0;
    if (what.guard == OF_RELEASE) {
        slope = slope_at(&terms[ELEMENT_APPROACH], ELEMENT_ANSWERS, order, point);
    } else if (each->touch->mode != ROLLS) {
        slope = slope_at(&terms[ELEMENT_SLIP], ELEMENT_ANSWERS, order, point);
    } else {
        const double sense = polynomial(each->drag, 1, order - 1, point) > 0.0 ? 1.0 : -1.0;
        slope = each->law->friction
                    * slope_at(&terms[ELEMENT_PUSH], ELEMENT_ANSWERS, order - 1, point)
                - sense * slope_at(each->drag, 1, order - 1, point);
    }
    return fabs(ratio(slope, slope_at(work->time, 1, order, point)));
}

static int happens(struct work *work, struct happening what)
{
    if (what.guard == OF_ROOT)
        return is_touching(&work->touching[what.contact]) ? happens_exit(work, what.contact)
                                                          : happens_entry(work, what.contact);
    return what.guard == OF_RELEASE ? release_or_press(work, what.contact)
                                    : happens_to_slip(work, what.contact);
}

int change_contact(struct work *work, struct happening what)
{
    struct system_run *run = work->run;
    const double rate = rate_of_guard(work, what);
    const int64_t before = run->events;
    work->step = what.point; /* where the series are read by what follows */
    const int status = happens(work, what);
    for (int64_t row = before; row < run->events; row++) {
        if (run->event_contacts[row] == what.contact)
            run->event_rates[row] = rate;
    }
    return status;
}

/* ---- The start ---- */

int begin_contacts(struct work *work)
{
    struct system_run *run = work->run;
    int on_edge = 0;
    for (int i = 0; i < (int)run->contact_count; i++) {
        struct touching *each = &work->touching[i];
        double answers[ELEMENT_ANSWERS];
        const double clearance = each->law->clearance;
        const double depth = radius_of_touch(work, each) - clearance;
        if (is_centred(each)) {
            each->touch->mode = SLIDES_FORWARDS;
            each->touch->root = sqrt(depth);
            open_episode(work, i, NAN);
            continue;
        }
        each->touch->mode = FLIES;
        each->touch->root = 0.0;
        if (depth < -SIDE * clearance)
            continue;
        each->touch->mode = SLIDES_FORWARDS;
        each->touch->root = depth > SIDE * clearance ? root_of(each, depth) : 0.0;
        set_element(each);
        values_of_touch(work, each, answers);
        if (each->touch->root == 0.0) {
            const double approach = answers[ELEMENT_APPROACH];
            each->touch->mode = FLIES;
            each->touch->zeros[OF_ROOT] = fabs(approach) <= STILL * run->velocity ? 2 : 1;
            on_edge += approach >= -STILL * run->velocity;
            continue;
        }
        const double factor = element_factor(&each->element, 0, answers[ELEMENT_APPROACH]);
        slide(work, each, answers);
        if (factor < 0.0)
            each->touch->mode = IS_LOOSE;
        open_episode(work, i, NAN);
    }
    int status = settle(work);
    if (status != DONE || on_edge == 0)
        return status;
    /* those on the stator begin in contact where they move, or are pushed, outwards */
    begin_terms(work);
    expand_system(work, 3);
    int enters[MOST_CONTACTS] = {0};
    for (int i = 0; i < (int)run->contact_count; i++) {
        const struct touching *each = &work->touching[i];
        const double *x = &each->series.terms[0][ELEMENT_X];
        const double *y = &each->series.terms[0][ELEMENT_Y];
        if (is_touching(each) || each->touch->zeros[OF_ROOT] == 0)
            continue;
        const int n = each->touch->zeros[OF_ROOT];
        enters[i] = convolved(x, WIDTH, x, WIDTH, n) + convolved(y, WIDTH, y, WIDTH, n) > 0.0;
    }
    int entered = 0;
    for (int i = 0; i < (int)run->contact_count; i++) {
        if (enters[i]) {
            enter_contact(work, i, NAN);
            entered = 1;
        }
    }
    if (!entered)
        return DONE;
    status = settle(work);
    begin_terms(work);
    pass_edge(work);
    return status;
}

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
