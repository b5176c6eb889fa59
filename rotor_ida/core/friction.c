/* The modes of a contact: whether it begins loose (`decide_looseness`), sliding or rolling
 * (`settle_friction`), and what follows where a guard ends its mode (`pass_guard`): at a release
 * and a press, and where it begins to roll, to slip or to slide the other way.
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

static void slide(struct motion *motion, double sense)
{
    motion->mode = &rub_mode;
    motion->model.sigma = copysign(1.0, sense);
}

static void roll(struct motion *motion)
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

void settle_friction(struct motion *motion, double *values)
{
    if (!is_rubbing(motion))
        return;
    motion->mode = &rub_mode;
    motion->model.sigma = 0.0;
    if (is_loose(motion))
        return;
    if (fabs(values[RUB_SLIP]) > hidden_slip(motion, values)) {
        slide(motion, values[RUB_SLIP]);
        return;
    }
    const double force = ungripped(motion, values);
    values[RUB_SLIP] = 0.0;
    if (force == 0.0)
        roll(motion);
    else
        slide(motion, force);
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

/* Take back the last event, as another comes at the same time: what rounding hid then is put right.
 * Return what is to be recorded instead, or 0. */
static int put_right(struct run *run, const struct motion *motion, int kind)
{
    const int8_t last = run->event_kinds[run->events - 1];
    if (last == ENTRY || (last == PRESS && kind != RELEASE))
        return 0; /* so it began */
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

/* What a change of friction is called, and what follows; 0 where a margin was touched only. */
static int change_of_friction(struct motion *motion, enum guard guard, double *values)
{
    const double sense = motion->model.sigma;
    values[RUB_SLIP] = 0.0;
    if (guard != SLIDING) {
        slide(motion, guard == GRIPS_FORWARDS ? 1.0 : -1.0);
        return SLIP;
    }
    const double force = ungripped(motion, values);
    if (force == 0.0) {
        roll(motion);
        return ROLL;
    }
    slide(motion, force);
    return force * sense < 0.0 ? REVERSE : 0;
}

int pass_guard(struct motion *motion, enum guard guard, double *values)
{
    if (guard != RELEASE_OR_PRESS)
        return change_of_friction(motion, guard, values);
    const int loosens = !is_loose(motion);
    values[CONTACT_P] = release_velocity(&motion->model);
    motion->model.loose = loosens ? 1.0 : 0.0;
    settle_friction(motion, values);
    return loosens ? RELEASE : PRESS;
}
