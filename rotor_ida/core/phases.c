/* The phases of a run that are integrated: contacts, in variables that are smooth through entry and
 * exit, and where there is nothing to smooth displacement and velocity themselves. */
#include "events.h"

/* A rise by less than this part is rounding. */
static const double NOISE = 1e-13;
/* Internal steps without progress in time after which a contact counts as stuck. */
enum { PATIENCE = 10000 };

/* Add the unit matrix as differences behind the state of a motion, with their tolerances. */
void begin_differences(const struct motion *motion, double *start, double *atol)
{
    for (int j = 0; motion->tangents && j < APART; j++) {
        start[motion->mode->size + j] = j % (DIFFERENCES + 1) == 0 ? 1.0 : 0.0;
        atol[motion->mode->size + j] = motion->rtol;
    }
}

/* ---- A contact, in its regularised variables ---- */

#ifdef WHOLE_MODEL
/* Most points at which the largest force is sought. */
enum { MOST_NARROWING = 60 };

void begin_pressed(struct motion *motion, const double *start)
{
    motion->model.pressed = 1.0;
    if (motion->model.contact_damping == 0.0 || start[CONTACT_Q] == 0.0)
        return;
    double above = start[CONTACT_P] - release_velocity(motion);
    if (above == 0.0) { /* then the force is 0 either way, and the field the same */
        double rate[MOST_VALUES];
        motion->mode->field(&motion->model, start, rate);
        above = rate[CONTACT_P];
    }
    motion->model.pressed = above > 0.0 ? 1.0 : 0.0;
}

double lost_of(const struct motion *motion, const double *start, const double *values)
{
    const struct parameters *m = &motion->model;
    if (m->contact_damping == 0.0)
        return 0.0;
    return values[CONTACT_WORK] - held_by(m, values[CONTACT_Q]) + held_by(m, start[CONTACT_Q]);
}

/* What the motion has of the energy on the rotating axes, but for the ring: there the unbalance
 * pulls with a constant force. Its largest part is kept in `scale`. */
static double energy_of(const struct motion *motion, const double *values, double *scale)
{
    const struct parameters *m = &motion->model;
    const double radius = m->delta0 + values[CONTACT_Q] * values[CONTACT_Q];
    const double p = values[CONTACT_P], momentum = momentum_of(motion, values);
    const double around = momentum / radius;
    const double moving = 0.5 * (p * p + around * around);
    const double bent = 0.5 * m->shaft_stiffness * radius * radius;
    const double lifted = m->load * radius * values[CONTACT_DOWN_R];
    const double omega = speed_of(motion, values), turning = omega * momentum;
    const double pulled = omega * omega * radius * values[CONTACT_C];
    *scale = larger(*scale, moving + bent + fabs(lifted) + fabs(turning) + fabs(pulled));
    return moving + bent - lifted - turning - pulled;
}

/* The error of energy allowed a step, in tolerances. A step's own is up to one of them. */
static const double ENERGY_ERROR = 100.0;
/* Steps that are allowed for beginning and end. */
enum { STEPS_AT_ENDS = 10 };

/* Whether energy balances over a contact of so many steps: what the motion has lost went into the
 * ring, into damping, and into the work of the load that turns on these axes. It is measured by the
 * largest energies at the ends and where the contact is deepest, and by what the ring holds: a
 * start deep in it that only creeps back has next to none beside that. */
static int is_balanced(const struct motion *motion, double absolute, const double *start,
                       const double *deepest, const double *reached, int64_t steps)
{
    const struct parameters *m = &motion->model;
    double scale = 0.0;
    energy_of(motion, deepest, &scale);
    scale += fabs(deepest[CONTACT_WORK]) + fabs(deepest[CONTACT_SPENT])
             + fabs(reached[CONTACT_WORK]) + fabs(reached[CONTACT_SPENT])
             + fabs(heat_of(motion, reached)) + held_by(m, start[CONTACT_Q])
             + held_by(m, reached[CONTACT_Q]);
    const double before = energy_of(motion, start, &scale);
    const double after = energy_of(motion, reached, &scale);
    const double missing = after - before + reached[CONTACT_WORK] - start[CONTACT_WORK]
                           + reached[CONTACT_SPENT] - start[CONTACT_SPENT]
                           + heat_of(motion, reached) - heat_of(motion, start);
    /* what errors of angular momentum and of directions come to that are allowed by themselves */
    const double radius = m->delta0 + reached[CONTACT_Q] * reached[CONTACT_Q];
    const double spin = fabs(momentum_of(motion, reached)) / (radius * radius);
    const double omega = larger(speed_of(motion, start), speed_of(motion, reached));
    const double apart = omega + spin + (omega * omega + m->load) * radius;
    /* so much of the angular momentum is lost in the moment of the slip of a large disc */
    const double rounded = ROUNDING * rim_of(motion, reached) * radius;
    const double allowed = ENERGY_ERROR * (double)(steps + STEPS_AT_ENDS);
    return fabs(missing) <= allowed * (motion->rtol * scale + (absolute + rounded) * apart);
}

/* The normal force of a pressed contact at values, and how fast it grows. */
struct push {
    double force, growth;
};

static double force_at(const struct motion *motion, const double *values)
{
    const struct parameters *m = &motion->model;
    const double q = values[CONTACT_Q], spring = q * q * (m->hertz * q + m->linear);
    return larger(spring * (1.0 + m->contact_damping * values[CONTACT_P]), 0.0);
}

static struct push push_of(const struct motion *motion, const double *values, const double *rate)
{
    const struct parameters *m = &motion->model;
    const double q = values[CONTACT_Q], damping = m->contact_damping;
    const double stiffening = q * (3.0 * m->hertz * q + 2.0 * m->linear) * rate[CONTACT_Q];
    const double more = q * q * (m->hertz * q + m->linear) * damping * rate[CONTACT_P];
    return (struct push){force_at(motion, values),
                         stiffening * (1.0 + damping * values[CONTACT_P]) + more};
}

static struct push push_within(struct motion *motion, const double *values)
{
    double rate[MOST_VALUES];
    motion->mode->field(&motion->model, values, rate);
    return push_of(motion, values, rate);
}

/* Keep the largest force of a step up to `end`: with damping it comes before the largest
 * indentation. It is sought where the force grows at the beginning and falls at the end. */
static void raise_force(struct peak *peak, struct motion *motion, double end, const double *reached)
{
    if (motion->model.pressed == 0.0)
        return;
    struct push left = push_of(motion, motion->before, motion->rate(motion));
    peak->force = larger(peak->force, larger(left.force, force_at(motion, reached)));
    if (!(left.growth > 0.0))
        return;
    struct push right = push_within(motion, reached);
    double low = motion->low, high = end;
    for (int i = 0; left.growth > 0.0 && 0.0 > right.growth && i < MOST_NARROWING; i++) {
        /* no more than what it grows from either end is to be had */
        const double most = smaller(left.force + left.growth * (high - low),
                                    right.force - right.growth * (high - low));
        if (most <= peak->force * (1.0 + NOISE))
            break;
        /* by the secant of the growth, or halves where that gets nowhere */
        const double part = i % 4 == 3 ? 0.5 : left.growth / (left.growth - right.growth);
        const double point = low + part * (high - low);
        const struct push here = push_within(motion, motion->at(motion, point));
        peak->force = larger(peak->force, here.force);
        if (here.growth > 0.0) {
            low = point;
            left = here;
        } else {
            high = point;
            right = here;
        }
    }
}

/* Record that the contact goes on in another way, and begin it there. */
static int change_mode(struct run *run, struct motion *motion, const struct change *change,
                       double *start, const double *atol, double *reached)
{
    /* with friction what rounding hid at the end of a step is found at the next's beginning */
    const int began = change->point <= motion->low
                      && (motion->low == 0.0 || motion->mode == &contact_mode);
    const double sense = motion->mode == &rub_mode ? motion->model.sigma : 0.0;
    const int kind = change_way(motion, change->guard, reached);
    if (run->event_room > 0) {
        if (run->events + EVENTS_A_CONTACT > run->event_room)
            return FULL_INSIDE;
        record_change(run, motion, kind, began, reached);
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

#ifdef RUN_UP
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
        settle_friction(motion, reached);
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
#endif
#else
void begin_pressed(struct motion *motion, const double *start) { (void)motion, (void)start; }

double lost_of(const struct motion *motion, const double *start, const double *values)
{
    (void)motion, (void)start, (void)values;
    return 0.0;
}

double heat_of(const struct motion *motion, const double *values)
{
    (void)motion, (void)values;
    return 0.0;
}
#endif

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
static double end_of_step(const struct run *run, struct motion *motion, double *reached, int *left)
{
    double end = motion->point;
    *left = 0;
    copy_values(motion, motion->values, reached);
    if (reached[CONTACT_Q] <= 0.0) {
        end = root_in_step(motion, contact_root_of, 0.0, inside(motion), end);
        if (isnan(end))
            return NAN;
        *left = 1;
        copy_values(motion, motion->at(motion, end), reached);
        reached[CONTACT_Q] = 0.0;
    }
    const double duration = phase_left(run);
    const double slack = duration < time_left(run) ? 0.0 : run->slack;
    if (reached[CONTACT_T] > duration + (*left ? slack : 0.0)) {
        end = root_in_step(motion, time_of, duration, motion->low, end);
        if (isnan(end))
            return NAN;
        *left = 0;
        copy_values(motion, motion->at(motion, end), reached);
        reached[CONTACT_T] = duration;
    } else if (*left) {
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
        && q + p * (end - low) > peak->values[CONTACT_Q] * (1.0 + NOISE)) {
        const double summit = root_in_step(motion, radial_velocity_of, 0.0, low, end);
        if (!isnan(summit) && motion->at(motion, summit)[CONTACT_Q] > peak->values[CONTACT_Q])
            memcpy(peak->values, motion->at(motion, summit),
                   sizeof(double) * (size_t)motion->mode->size);
    }
    if (reached[CONTACT_Q] > peak->values[CONTACT_Q])
        memcpy(peak->values, reached, sizeof(double) * (size_t)motion->mode->size);
}

/* Integrate one contact until q falls through 0 or the run is at its end. */
int integrate_contact(struct run *run, struct motion *motion, const double *begun,
                      const double *atol, double *reached, struct peak *peak, int *left)
{
    int idle = 0;
    int64_t steps = 0;
    double start[MOST_VALUES];
    copy_values(motion, begun, start);
    (void)atol, (void)steps; /* of another mode, which the paper's rotor has not */
    while (!asked_to_stop(run->stop)) {
        int status = motion->advance(motion);
        if (status != DONE)
            return status;
        double end = end_of_step(run, motion, reached, left);
#ifdef WHOLE_MODEL
        const struct change change = isnan(end) ? (struct change){NAN, HELD}
                                                : change_in_step(motion, end);
        const double turn = change.point;
        const int changes = turn < end || (turn == end && !*left);
        end = isnan(turn) ? NAN : smaller(turn, end);
        if (changes) {
            copy_values(motion, motion->at(motion, turn), reached);
            *left = 0;
        }
#endif
        if (isnan(end)) {
            copy_values(motion, motion->before, reached);
            return NO_ROOT;
        }
#ifdef WHOLE_MODEL
        steps++;
        if (motion->spend != NULL) {
            reached[CONTACT_SPENT] = motion->before[CONTACT_SPENT];
            if (motion->mode != &contact_mode)
                reached[RUB_HEAT] = motion->before[RUB_HEAT];
            motion->spend(motion, end, reached);
            motion->values[CONTACT_SPENT] = reached[CONTACT_SPENT];
            if (motion->mode != &contact_mode)
                motion->values[RUB_HEAT] = reached[RUB_HEAT];
#ifdef RUN_UP
            motion->values[CONTACT_WORK] = reached[CONTACT_WORK];
#endif
        }
#endif
#ifdef RUN_UP
        if (motion->model.inverse_inertia > 0.0 && reached[CONTACT_SPEED] < 0.0)
            return STALLED;
#endif
        raise_peak_of_contact(peak, motion, end, reached);
        const struct step step = {motion, end, reached[CONTACT_T], reached};
        status = observe_step(run, &step);
        if (status != DONE)
            return status;
#ifdef WHOLE_MODEL
        if (motion->model.contact_damping > 0.0)
            raise_force(peak, motion, end, reached);
        if (changes) {
            idle = turn <= motion->low ? idle + 1 : 0;
            status = change_mode(run, motion, &change, start, atol, reached);
            if (status == DONE && idle > PATIENCE)
                status = STUCK;
            if (status != DONE)
                return status;
            continue;
        }
#endif
        if (*left || reached[CONTACT_T] >= time_left(run)) {
            observe_phase(run, motion, start, reached);
#ifdef WHOLE_MODEL
            return is_balanced(motion, run->atol, begun, peak->values, reached, steps) ? DONE
                                                                                       : UNBALANCED;
#else
            return DONE;
#endif
        }
#ifdef RUN_UP
        if (reached[CONTACT_T] >= phase_left(run)) {
            status = change_piece(run, motion, start, atol, reached);
            if (status != DONE)
                return status;
            continue;
        }
#endif
        idle = reached[CONTACT_T] <= motion->before[CONTACT_T] ? idle + 1 : 0;
        if (idle > PATIENCE)
            return STUCK;
    }
    return STOPPED;
}

/* ---- Displacement and velocity: without clearance, and flight that is integrated ---- */

static double radius_of(const double *values) { return sqrt(squared_radius_of(values)); }

/* Points on the way back to the beginning of a step that are tried for one inside the ring. */
enum { MOST_NEARER = 30 };
/* Nearer to the ring, in clearances, rounding decides on which side the rotor is. */
static const double HIDDEN = 4.0 * ROUNDING;

/* Where a step that begins on the ring, falls inwards at first and ends outside touches it;
 * infinite where no point inside is seen. */
static double touch_after_fall(struct motion *motion, double delta0, double low, double high)
{
    double inside = 0.5 * (low + high);
    for (int i = 0; i < MOST_NEARER; i++) {
        const double *values = motion->at(motion, inside);
        if (delta0 - radius_of(values) > HIDDEN * delta0)
            return root_in_step(motion, radius_of, delta0, inside, high);
        inside = 0.5 * (low + inside);
    }
    return INFINITY;
}

/* Where in the last step the radius first rises through delta0; infinite where it does not.
 *
 * A rise and fall inside the step shows in the radial velocity: it changes from + to - there, and
 * the radius at its root tells. A fall and rise, which is how a step that starts on the ring may
 * look, shows likewise; where rounding hides the fall, the turn itself is the touch. */
static double touch_in_step(struct motion *motion, double delta0)
{
    double low = motion->low, high = motion->point, turn = low;
    const double rising = radial_rate_of(motion->before);
    if (rising * radial_rate_of(motion->values) < 0.0) {
        turn = root_in_step(motion, radial_rate_of, 0.0, low, high);
        if (rising > 0.0)
            high = turn;
        else if (radius_of(motion->at(motion, turn)) < delta0)
            low = turn;
    }
    const double above = radius_of(motion->at(motion, high)) - delta0;
    const int leaves = radial_rate_of(motion->at(motion, high)) > 0.0;
    const int on_ring = fabs(radius_of(motion->before) - delta0) <= HIDDEN * delta0;
    if (above <= (on_ring ? HIDDEN * delta0 : 0.0))
        return INFINITY;
    if (on_ring && leaves) {
        const double touch = touch_after_fall(motion, delta0, motion->low, high);
        if (touch < INFINITY)
            return touch;
    }
    if (radius_of(motion->at(motion, low)) >= delta0)
        return leaves ? larger(turn, 0.5 * (low + high)) : INFINITY;
    const double touch = root_in_step(motion, radius_of, delta0, low, high);
    if (isnan(touch))
        return touch;
    /* by rounding, or by the tolerances, what falls inwards from the ring is outside at first */
    return radial_rate_of(motion->at(motion, touch)) < 0.0 ? INFINITY : touch;
}

/* Keep the values of largest radius. On a whirl of constant radius the radial velocity is rounding
 * noise; there is nothing to look for. */
static void raise_peak(struct peak *peak, struct motion *motion, double end)
{
    const double *reached = motion->at(motion, end);
    const double rising = radial_rate_of(motion->before);
    const double could_reach = squared_radius_of(motion->before)
                               + 2.0 * rising * (end - motion->low);
    if (rising > 0.0 && 0.0 > radial_rate_of(reached)
        && could_reach > squared_radius_of(peak->values) * (1.0 + NOISE)) {
        const double summit = root_in_step(motion, radial_rate_of, 0.0, motion->low, end);
        end = summit > motion->low ? summit : end;
        reached = motion->at(motion, end);
    }
    if (radius_of(reached) <= radius_of(peak->values))
        return;
    memcpy(peak->values, reached, sizeof(double) * CARTESIAN_SIZE);
    peak->time = end;
}

/* Integrate until the rotor touches the ring from inside or the run is at its end. */
int follow_freely(struct run *run, struct motion *motion, struct peak *peak, int *touched)
{
    const double duration = phase_left(run);
    const double slack = duration < time_left(run) ? 0.0 : run->slack;
    double start[MOST_VALUES] = {run->state[0], run->state[1], run->state[2], run->state[3]};
    double atol[MOST_VALUES] = {run->atol, run->atol, run->atol, run->atol};
#ifdef WHOLE_MODEL
    const struct vector down = motion->down = where_it_is(run).down;
    start[CARTESIAN_DOWN_X] = down.x;
    start[CARTESIAN_DOWN_Y] = down.y;
    atol[CARTESIAN_DOWN_X] = atol[CARTESIAN_DOWN_Y] = run->atol;
#endif
#ifdef RUN_UP
    motion->model = parameters_of(&run->rotor, motion->model.felt);
    start[CARTESIAN_SPEED] = run->rotor.omega;
    start[CARTESIAN_ANGLE] = 0.0;
    atol[CARTESIAN_SPEED] = atol[CARTESIAN_ANGLE] = run->atol;
#endif
    double reached[MOST_VALUES];
    begin_differences(motion, start, atol);
    memcpy(peak->values, start, sizeof peak->values);
    memcpy(reached, start, sizeof reached);
    peak->time = 0.0;
    double end = 0.0;
    int over = 0, status = motion->restart(motion, start, atol);
    while (status == DONE && !over) {
        status = asked_to_stop(run->stop) ? STOPPED : motion->advance(motion);
        if (status != DONE)
            break;
        const double touch = run->rotor.delta0 > 0.0 ? touch_in_step(motion, run->rotor.delta0)
                                                     : INFINITY;
        if (isnan(touch)) {
            status = NO_ROOT;
            break;
        }
        *touched = touch <= duration + slack;
        end = *touched ? touch : smaller(motion->point, duration);
        raise_peak(peak, motion, end);
        copy_values(motion, motion->at(motion, end), reached);
#ifdef RUN_UP
        if (motion->model.inverse_inertia > 0.0 && reached[CARTESIAN_SPEED] < 0.0)
            status = STALLED;
        if (status == STALLED)
            break;
#endif
        const struct step step = {motion, end, end, reached};
        status = observe_step(run, &step);
        over = *touched || end >= duration;
    }
    if (status == DONE)
        observe_phase(run, motion, start, reached);
    run->evaluations += motion->evaluations(motion);
    advance_run(run, end, centre_of(motion, reached));
    return status;
}
