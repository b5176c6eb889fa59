/* The modes of a contact: whether it begins loose (`decide_looseness`), sliding or rolling
 * (`decide_friction`); what follows where a guard ends its mode (`pass_guard`), at a release and a
 * press, and where it begins to roll, to slip or to slide the other way; and how that is written
 * down (`record_change`). guards.c finds the place; `change_mode` in contact_phase.c calls both and
 * begins the integration anew in the new mode. The exit, where the contact itself ends, is found by
 * `end_of_step` in contact_phase.c and recorded by `follow_contact` in events.c.
 *
 * Where the slip speed is 0 the disc rolls as long as friction can hold it; else it slides in the
 * sense in which the force drives it that rolling would need. */
#include "events.h"

enum contact_mode contact_mode_of(const struct motion *motion)
{
    if (is_loose(motion))
        return IS_LOOSE;
    if (motion->mode == &rolling_mode)
        return ROLLS;
    return motion->model.sigma < 0.0 ? SLIDES_BACKWARDS : SLIDES_FORWARDS;
}

void decide_looseness(struct motion *motion, const double *start)
{
    motion->model.loose = 0.0;
    if (motion->model.contact_damping == 0.0 || start[CONTACT_Q] == 0.0)
        return;
    double above = start[CONTACT_P] - release_velocity(&motion->model);
    if (above == 0.0) { /* then the force is 0 either way, and the field the same */
        double rate[MOST_VALUES];
        motion->mode->field(&motion->model, start, rate);
        above = rate[CONTACT_P];
    }
    motion->model.loose = above > 0.0 ? 0.0 : 1.0;
}

static void begin_sliding(struct motion *motion, double sense)
{
    motion->mode = &rub_mode;
    motion->model.sigma = copysign(1.0, sense);
}

static void begin_rolling(struct motion *motion)
{
    motion->mode = &rolling_mode;
    motion->model.sigma = 0.0;
}

/* The force at values by which the grip is not enough for the disc to roll; 0 where it is, or where
 * rounding hides that it is not. */
static double ungripped(const struct motion *motion, const double *values)
{
    double watched[WATCHED], rates[WATCHED];
    rolling_mode.watched(&motion->model, values, watched, rates);
    const double beyond = fabs(watched[1]) - watched[0];
    return beyond > hidden_hold(motion, values) ? copysign(beyond, watched[1]) : 0.0;
}

void decide_friction(struct motion *motion, double *values)
{
    if (!is_rubbing(motion))
        return;
    motion->mode = &rub_mode;
    motion->model.sigma = 0.0;
    if (is_loose(motion))
        return;
    if (fabs(values[RUB_SLIP]) > hidden_slip(motion, values)) {
        begin_sliding(motion, values[RUB_SLIP]);
        return;
    }
    const double force = ungripped(motion, values);
    values[RUB_SLIP] = 0.0;
    if (force == 0.0)
        begin_rolling(motion);
    else
        begin_sliding(motion, force);
}

void begin_with_friction(struct motion *motion, double *start, double *atol)
{
    if (!is_rubbing(motion))
        return;
    motion->mode = &rub_mode;
    motion->model.sigma = 0.0;
    start[RUB_SLIP] = start[CONTACT_H]
                      + rim_of(motion, start) * radius_in_contact(&motion->model, start);
    start[RUB_HEAT] = 0.0;
    atol[RUB_HEAT] = atol[CONTACT_WORK];
}

double heat_of(const struct motion *motion, const double *values)
{
    return is_rubbing(motion) ? values[RUB_HEAT] : 0.0;
}

void record_mode(struct run *run, const struct motion *motion)
{
    if (!is_rubbing(motion))
        return;
    if (run->events > 0)
        run->event_modes[run->events - 1] = (int8_t)contact_mode_of(motion);
    else
        run->mode_began = (int)contact_mode_of(motion);
}

/* Another change comes at the time of the last event: rounding hid which of them it is. Take the
 * last back, and return what is recorded for both together, or 0 where they cancel. What follows an
 * entry or a press at once is how the contact goes on from there: the event stays, and nothing is
 * added. */
static int put_right(struct run *run, const struct motion *motion, int kind)
{
    const int8_t last = run->event_kinds[run->events - 1];
    if (last == ENTRY || (last == PRESS && kind != RELEASE))
        return 0;
    run->events--;
    if (last == SLIP && kind == REVERSE)
        return SLIP;
    if (last != -kind)
        return kind;
    if (kind != SLIP)
        return 0;
    const int mode = run->events > 0 ? run->event_modes[run->events - 1] : run->mode_began;
    return mode != (int)contact_mode_of(motion) ? REVERSE : 0;
}

void record_change(struct run *run, const struct motion *motion, int kind, int is_none,
                   const double *values)
{
    const double since = values[CONTACT_T],
                 last = run->events > 0 ? run->event_times[run->events - 1] : -INFINITY;
    if (kind != 0 && last >= run->time + since)
        kind = put_right(run, motion, kind);
    else if (is_none)
        kind = 0;
    if (kind != 0)
        record_event_inside(run, (enum event)kind, since, centre_of(motion, values));
    record_mode(run, motion);
}

/* Go on as friction has it, and return what the change is called; 0 where a margin was touched
 * only.
 */
static int change_of_friction(struct motion *motion, enum guard guard, double *values)
{
    const double sense = motion->model.sigma;
    values[RUB_SLIP] = 0.0;
    if (guard != SLIDING) {
        begin_sliding(motion, guard == GRIPS_FORWARDS ? 1.0 : -1.0);
        return SLIP;
    }
    const double force = ungripped(motion, values);
    if (force == 0.0) {
        begin_rolling(motion);
        return ROLL;
    }
    begin_sliding(motion, force);
    return force * sense < 0.0 ? REVERSE : 0;
}

int pass_guard(struct motion *motion, enum guard guard, double *values)
{
    if (guard != RELEASE_OR_PRESS)
        return change_of_friction(motion, guard, values);
    const int loosens = !is_loose(motion);
    /* here the guard is 0 by definition: the next step would find what rounding has left of it as a
     * change at its beginning (a rotor system says by `zeros` that the guard is 0) */
    values[CONTACT_P] = release_velocity(&motion->model);
    motion->model.loose = loosens ? 1.0 : 0.0;
    decide_friction(motion, values);
    return loosens ? RELEASE : PRESS;
}
