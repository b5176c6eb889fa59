/* A contact, in variables that are smooth through entry and exit: where a step ends, which may be
 * at an exit (`end_of_step`) or where a guard has ended its mode (`ends_by_change`). It then goes
 * on in another mode (`change_mode`: release, press and events of friction) or with the next piece
 * of a speed that changes (`change_piece`). */
#include "events.h"

/* Internal steps without progress in time after which a contact counts as stuck. */
enum { PATIENCE = 10000 };

/* Record that the contact goes on in another mode, and begin it there. */
static int change_mode(struct run *run, struct motion *motion, const struct change *change,
                       double *start, const double *atol, double *reached)
{
    /* the mode ended where it began: nothing is recorded; with friction that may be what rounding
     * hid at the end of a step, found at the next's beginning */
    const int is_none = change->point <= motion->low
                        && (motion->low == 0.0 || motion->mode == &contact_mode);
    const double sense = motion->mode == &rub_mode ? motion->model.sigma : 0.0;
    const int kind = pass_guard(motion, change->guard, reached);
    if (run->event_room > 0) {
        if (run->events + EVENTS_A_CONTACT > run->event_room)
            return FULL_INSIDE;
        record_change(run, motion, kind, is_none, reached);
    }
    observe_phase(run, motion, start, reached);
    observe_jump(run, motion, sense, reached);
    run->evaluations += motion->evaluations(motion);
    double unused[MOST_VALUES];
    copy_values(motion, reached, start);
    put_load_right(motion, start, 0.0);
    begin_differences(motion, start, unused);
    return motion->restart(motion, start, atol);
}

static void take_drive(struct motion *motion, const struct rotor *rotor)
{
    motion->model.rate = rotor->rate;
    motion->model.torque = rotor->torque;
    motion->model.slope = rotor->slope;
    motion->model.inverse_inertia = rotor->inverse_inertia;
}

/* Go on with the next piece of a speed, where its rate jumps: the force with it that rolling needs,
 * so that a disc which rolled may slip from here on. */
static int change_piece(struct run *run, struct motion *motion, double *start, const double *atol,
                        double *reached)
{
    run->piece++;
    begin_piece(run);
    take_drive(motion, &run->rotor);
    reached[CONTACT_SPEED] = run->rotor.omega;
    if (motion->mode == &rolling_mode) {
        decide_friction(motion, reached);
        if (motion->mode == &rub_mode && run->event_room > 0) {
            if (run->events + EVENTS_A_CONTACT > run->event_room)
                return FULL_INSIDE;
            record_change(run, motion, SLIP, 0, reached);
        }
    }
    run->evaluations += motion->evaluations(motion);
    copy_values(motion, reached, start);
    put_load_right(motion, start, 0.0);
    return motion->restart(motion, start, atol);
}

/* A point of the last step at which the rotor is in contact. */
static double inside(struct motion *motion)
{
    double point = motion->low, reach = motion->point - motion->low;
    while (motion->at(motion, point)[CONTACT_Q] <= 0.0 && reach > 1e-14 * motion->point) {
        reach *= 0.125;
        point = motion->low + reach;
    }
    return point;
}

/* Write where the motion stands after a step into `reached`; return the point, NaN where it cannot
 * be found. That is at the end of the step, at an exit, or at the end of the run. */
static double end_of_step(const struct run *run, struct motion *motion, double *reached,
                          int *has_left)
{
    double end = motion->point;
    *has_left = 0;
    copy_values(motion, motion->values, reached);
    if (reached[CONTACT_Q] <= 0.0) {
        end = root_in_step(motion, contact_root_of, 0.0, inside(motion), end);
        if (isnan(end))
            return NAN;
        *has_left = 1;
        copy_values(motion, motion->at(motion, end), reached);
        reached[CONTACT_Q] = 0.0;
    }
    const double duration = phase_left(run);
    const double slack = duration < time_left(run) ? 0.0 : run->slack;
    if (reached[CONTACT_T] > duration + (*has_left ? slack : 0.0)) {
        end = root_in_step(motion, time_of, duration, motion->low, end);
        if (isnan(end))
            return NAN;
        *has_left = 0;
        copy_values(motion, motion->at(motion, end), reached);
        reached[CONTACT_T] = duration;
    } else if (*has_left) {
        reached[CONTACT_T] = larger(reached[CONTACT_T], motion->before[CONTACT_T]);
    }
    return end;
}

/* Keep the values of largest q: at the end of the step, or where p vanishes inside it. On a whirl
 * of constant radius p is rounding noise; there is nothing to look for. */
static void raise_peak_of_contact(struct peak *peak, struct motion *motion, double end,
                                  const double *reached)
{
    const double low = motion->low, q = motion->before[CONTACT_Q], p = motion->before[CONTACT_P];
    if (p > 0.0 && 0.0 > reached[CONTACT_P]
        && q + p * (end - low) > peak->values[CONTACT_Q] * (1.0 + LEAST_RISE)) {
        const double summit = root_in_step(motion, radial_velocity_of, 0.0, low, end);
        if (!isnan(summit) && motion->at(motion, summit)[CONTACT_Q] > peak->values[CONTACT_Q])
            memcpy(peak->values, motion->at(motion, summit),
                   sizeof(double) * (size_t)motion->mode->size);
    }
    if (reached[CONTACT_Q] > peak->values[CONTACT_Q])
        memcpy(peak->values, reached, sizeof(double) * (size_t)motion->mode->size);
}

/* Put what a contact has spent up to the end of a step, which its series do not have, in place. */
static void add_spent(struct motion *motion, double end, double *reached)
{
    if (!IS_WHOLE || motion->spend == NULL)
        return;
    reached[CONTACT_SPENT] = motion->before[CONTACT_SPENT];
    if (is_rubbing(motion))
        reached[RUB_HEAT] = motion->before[RUB_HEAT];
    motion->spend(motion, end, reached);
    motion->values[CONTACT_SPENT] = reached[CONTACT_SPENT];
    if (is_rubbing(motion))
        motion->values[RUB_HEAT] = reached[RUB_HEAT];
    if (SPEED_CHANGES)
        motion->values[CONTACT_WORK] = reached[CONTACT_WORK];
}

/* End a step sooner, where the contact goes on in another mode from there: say whether it does. */
static int ends_by_change(struct motion *motion, double *end, double *reached, int *has_left,
                          struct change *change)
{
    if (!IS_WHOLE || isnan(*end))
        return 0;
    *change = change_in_step(motion, *end);
    const double turn = change->point;
    const int changes = turn < *end || (turn == *end && !*has_left);
    *end = isnan(turn) ? NAN : smaller(turn, *end);
    if (changes) {
        copy_values(motion, motion->at(motion, turn), reached);
        *has_left = 0;
    }
    return changes;
}

/* Integrate one contact until q falls through 0 or the run is at its end. */
int integrate_contact(struct run *run, struct motion *motion, const double *begun,
                      const double *atol, double *reached, struct peak *peak, int *has_left)
{
    int idle = 0;
    double start[MOST_VALUES];
    copy_values(motion, begun, start);
    for (int64_t steps = 1;; steps++) {
        int status = allow_step(run);
        if (status == DONE)
            status = motion->advance(motion);
        if (status != DONE)
            return status;
        double end = end_of_step(run, motion, reached, has_left);
        struct change change = NO_CHANGE;
        const int changes = ends_by_change(motion, &end, reached, has_left, &change);
        if (isnan(end)) {
            copy_values(motion, motion->before, reached);
            return NO_ROOT;
        }
        status = check_speed(motion, &end, reached);
        if (status != DONE)
            return status;
        add_spent(motion, end, reached);
        raise_peak_of_contact(peak, motion, end, reached);
        const struct step step = {motion, end, reached[CONTACT_T], reached};
        status = observe_step(run, &step);
        if (status != DONE)
            return status;
        if (IS_WHOLE) {
            raise_force(peak, motion, end, reached);
            peak->slid += slid_in_step(motion, end);
        }
        if (changes) {
            idle = change.point <= motion->low ? idle + 1 : 0;
            status = change_mode(run, motion, &change, start, atol, reached);
        } else if (*has_left || reached[CONTACT_T] >= time_left(run)) {
            observe_phase(run, motion, start, reached);
            const int balances = !IS_WHOLE
                                 || is_balanced(motion, run->atol, begun, peak->values, reached,
                                                steps);
            return balances ? DONE : UNBALANCED;
        } else if (SPEED_CHANGES && reached[CONTACT_T] >= phase_left(run)) {
            status = change_piece(run, motion, start, atol, reached);
        } else {
            idle = reached[CONTACT_T] <= motion->before[CONTACT_T] ? idle + 1 : 0;
        }
        if (status == DONE && idle > PATIENCE)
            status = STUCK;
        if (status != DONE)
            return status;
    }
}
