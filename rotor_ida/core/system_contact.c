/* What happens to the contacts of a rotor system: where a guard of system_guards.c falls to 0, here
 * it is recorded and decided how the contact goes on (`change_contact`): entry, exit, release or
 * press, roll, slip or reverse. A change jumps the accelerations of all, so after each it is
 * decided anew for every contact that does not slide whether friction holds it (`decide_rolling`).
 */
#include "system_work.h"

/* Contacts whose roots are less than this part of that of the clearance end together. */
static const double TOGETHER = 1e-7;
/* Nearer to the stator, in clearances, rounding decides on which side a contact is. */
static const double SIDE = 8.0 * 2.220446049250313e-16;
/* Below this part of the scale of velocity, rounding decides whether a contact on the stator
 * opens. */
static const double STILL = 1e-15;
enum { MOST_SWEEPS = 500 };

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

/* Decide for every contact that does not slide, those just begun included, whether friction can
 * hold it: then it rolls on, else it slides in the sense of the force at its limit. */
static int decide_rolling(struct work *work)
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

int decide_rolling_of_others(struct work *work, int but)
{
    struct system_run *run = work->run;
    int rolled[MOST_CONTACTS];
    for (int i = 0; i < (int)run->contact_count; i++)
        rolled[i] = i != but && run->touches[i].mode == ROLLS;
    const int status = decide_rolling(work);
    for (int i = 0; i < (int)run->contact_count; i++) {
        if (rolled[i] && run->touches[i].mode != ROLLS)
            record_system_event(run, SLIP, i);
    }
    return status;
}

/* Let a contact push from here on, with these values that it has without friction: it slides in the
 * sense of its slip. Where the slip is hidden by rounding, or a stator without mass can follow it
 * at once, it counts as rolling until `decide_rolling` has said whether friction holds it. */
static void begin_pushing(const struct work *work, struct touching *each, const double *answers)
{
    const double slip = answers[ELEMENT_SLIP], hidden = hidden_slip(work, each);
    const double followed = each->stator_mobility * each->law->friction * answers[ELEMENT_PUSH];
    const int is_still = fabs(slip) <= fmax(hidden, followed);
    each->hidden = ratio(hidden, each->stator_mobility);
    each->touch->sense = slip < 0.0 ? -1.0 : 1.0;
    each->touch->mode = slip < 0.0 ? SLIDES_BACKWARDS : SLIDES_FORWARDS;
    if (is_still && each->law->friction > 0.0)
        each->touch->mode = ROLLS;
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
    begin_pushing(work, each, answers);
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
    const int status = decide_rolling(work);
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
    return decide_rolling_of_others(work, -1);
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
        begin_pushing(work, each, answers);
    }
    each->touch->zeros[OF_RELEASE] = 1;
    record_system_event(work->run, loosens ? RELEASE : PRESS, contact);
    return decide_rolling_of_others(work, contact);
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
    const int status = decide_rolling_of_others(work, contact);
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
        begin_pushing(work, each, answers);
        if (factor < 0.0)
            each->touch->mode = IS_LOOSE;
        open_episode(work, i, NAN);
    }
    int status = decide_rolling(work);
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
    status = decide_rolling(work);
    begin_terms(work);
    pass_edge(work);
    return status;
}
