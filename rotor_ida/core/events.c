/* The event loop: from the start through flight and contact, event by event, to the end.
 *
 * Decide the mode at the start; integrate inside the mode until something may have happened; look
 * for a crossing that the step hid; polish the event; record it; restart in the other mode. */
#include "cvode.h"
#include "observers.h"

/* A start that is drawn off the ring is followed in closed form to this depth, in clearances. */
static const double FIRST_DEPTH = 1e-16;
/* On a steady whirl rounding alone moves q and p by so much: no step can be asked for less. */
static const double BELOW_ROUNDING = 1e-16;
static const double TIGHTEST_ATOL = 1e-30;
/* A rise by less than this part is rounding. */
static const double NOISE = 1e-13;
/* Internal steps without progress in time after which a contact counts as stuck. */
enum { PATIENCE = 10000 };

static struct motion_of_centre where_it_is(const struct run *run)
{
    return (struct motion_of_centre){{run->state[0], run->state[1]},
                                     {run->state[2], run->state[3]}};
}

static int is_finite(const double *state)
{
    return isfinite(state[0] + state[1] + state[2] + state[3]);
}

/* Advance the time by `span`, to a new displacement and velocity. */
static void advance_run(struct run *run, double span, struct motion_of_centre centre)
{
    run->time = span == time_left(run) ? run->duration : run->time + span;
    run->state[0] = centre.z.x;
    run->state[1] = centre.z.y;
    run->state[2] = centre.w.x;
    run->state[3] = centre.w.y;
}

/* ---- How a contact begins ---- */

/* The radial velocity; 0 where rounding hides its sign. */
static double radial_velocity(struct motion_of_centre start)
{
    const double along = dot(start.z, start.w) / length(start.z);
    return fabs(along) > 4.0 * ROUNDING * length(start.w) ? along : 0.0;
}

/* The radial acceleration at radial rest, without contact; 0 where rounding hides it. */
static double radial_acceleration(struct motion_of_centre start, const struct rotor *rotor)
{
    const double radius = length(start.z), around = cross(start.z, start.w) / radius;
    const double centrifugal = around * around / radius, unbalance = rotor->omega * rotor->omega;
    const double total = centrifugal + unbalance * (start.z.x / radius);
    return fabs(total) > 16.0 * ROUNDING * (centrifugal + unbalance) ? total : 0.0;
}

/* The radial jerk where velocity and acceleration vanish; 0 where rounding hides it. */
static double radial_jerk(struct motion_of_centre start, const struct rotor *rotor)
{
    const double omega = rotor->omega, damping = 2.0 * rotor->zeta, radius = length(start.z);
    const struct vector acceleration = {omega * omega - damping * start.w.x, -damping * start.w.y};
    const struct vector jerk = {-damping * acceleration.x,
                                omega * omega * omega - damping * acceleration.y};
    const double by_velocity = 3.0 * dot(start.w, acceleration), by_position = dot(start.z, jerk);
    const double size = 3.0 * length(start.w) * length(acceleration)
                        + length(start.z) * length(jerk);
    const double total = by_velocity + by_position;
    return fabs(total) > 64.0 * ROUNDING * size ? total / radius : 0.0;
}

/* Decide the mode at a start.
 *
 * On the ring the first of radial velocity, acceleration and jerk that is not zero decides:
 * outwards means contact, inwards flight. Where all vanish the rotor whirls along the ring, which
 * is flight. */
static enum where begins(struct motion_of_centre start, const struct rotor *rotor)
{
    if (rotor->delta0 == 0.0)
        return IN_CONTACT;
    const double radius = length(start.z);
    if (fabs(radius - rotor->delta0) > 4.0 * ROUNDING * radius)
        return radius > rotor->delta0 ? IN_CONTACT : IN_FLIGHT;
    double rate = radial_velocity(start);
    if (rate == 0.0)
        rate = radial_acceleration(start, rotor);
    if (rate == 0.0)
        rate = radial_jerk(start, rotor);
    return rate > 0.0 ? IN_CONTACT : IN_FLIGHT;
}

static void regularise(struct motion_of_centre start, double root, double *values)
{
    const struct vector direction = scaled(1.0 / length(start.z), start.z);
    values[CONTACT_Q] = root;
    values[CONTACT_P] = dot(start.w, direction);
    values[CONTACT_H] = cross(start.z, start.w);
    values[CONTACT_C] = direction.x;
    values[CONTACT_S] = direction.y;
    values[CONTACT_T] = values[CONTACT_J] = 0.0;
}

/* The values a moment after a start at radial rest that is drawn outwards.
 *
 * q = p = 0 is an equilibrium of the regularised equations. The motion leaves it with an
 * indentation that grows like t**2, or t**3 where the radial acceleration vanishes too, unhindered
 * so far by a force of higher order. */
static void push_off(struct motion_of_centre start, double left, const struct rotor *rotor,
                     double *values)
{
    const double acceleration = larger(radial_acceleration(start, rotor), 0.0);
    const double jerk = acceleration == 0.0 ? larger(radial_jerk(start, rotor), 0.0) : 0.0;
    const double depth = FIRST_DEPTH * rotor->delta0;
    double moment = 0.0;
    if (acceleration > 0.0)
        moment = smaller(sqrt(2.0 * depth / acceleration), 1e-3 * left);
    else if (jerk > 0.0)
        moment = smaller(cbrt(6.0 * depth / jerk), 1e-3 * left);
    const double indentation = (acceleration / 2.0 + jerk * moment / 6.0) * moment * moment;
    regularise(fly(start, moment, rotor), sqrt(indentation), values);
    values[CONTACT_P] = (acceleration + jerk * moment / 2.0) * moment;
    values[CONTACT_T] = moment;
}

static void contact_start(struct motion_of_centre start, double left, const struct rotor *rotor,
                          double *values)
{
    const double depth = length(start.z) - rotor->delta0;
    const double root = depth > 4.0 * ROUNDING * rotor->delta0 ? sqrt(depth) : 0.0;
    if (root == 0.0 && radial_velocity(start) <= 0.0)
        push_off(start, left, rotor, values);
    else
        regularise(start, root, values);
}

/* Absolute tolerances: the relative one, of the size that each variable comes to.
 *
 * So a very slight touch is still resolved, and a hard one is not asked for digits at entry and
 * exit, where q is 0, that are lost in its course. */
static void contact_tolerances(const double *start, double rtol, double absolute, double *atol)
{
    const double q = start[CONTACT_Q], p = start[CONTACT_P], fastest = larger(q, fabs(p));
    /* a contact cannot end sooner than by a straight way out */
    const double least = p < 0.0 && 0.0 < q ? q * q / -p : fastest;
    for (int i = 0; i < CONTACT_SIZE; i++)
        atol[i] = absolute;
    atol[CONTACT_Q] = atol[CONTACT_P] = larger(rtol * fastest, BELOW_ROUNDING);
    atol[CONTACT_T] = atol[CONTACT_J] = larger(rtol * least, TIGHTEST_ATOL);
}

/* Add the unit matrix as differences behind the state of a motion, with their tolerances. */
static void begin_differences(const struct motion *motion, double *start, double *atol)
{
    for (int j = 0; motion->tangents && j < APART; j++) {
        start[motion->mode->size + j] = j % (DIFFERENCES + 1) == 0 ? 1.0 : 0.0;
        atol[motion->mode->size + j] = motion->rtol;
    }
}

/* ---- A contact ---- */

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
    const double duration = time_left(run);
    if (reached[CONTACT_T] > duration + (*left ? run->slack : 0.0)) {
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
            memcpy(peak->values, motion->at(motion, summit), sizeof(double) * CONTACT_SIZE);
    }
    if (reached[CONTACT_Q] > peak->values[CONTACT_Q])
        memcpy(peak->values, reached, sizeof(double) * CONTACT_SIZE);
}

/* Integrate one contact until q falls through 0 or the run is at its end. */
static int integrate_contact(struct run *run, struct motion *motion, const double *start,
                             double *reached, struct peak *peak, int *left)
{
    int idle = 0;
    while (!asked_to_stop(run->stop)) {
        int status = motion->advance(motion);
        if (status != DONE)
            return status;
        const double end = end_of_step(run, motion, reached, left);
        if (isnan(end)) {
            copy_values(motion, motion->before, reached);
            return NO_ROOT;
        }
        raise_peak_of_contact(peak, motion, end, reached);
        const struct step step = {motion, end, reached[CONTACT_T], reached};
        status = observe_step(run, &step);
        if (status != DONE)
            return status;
        if (*left || reached[CONTACT_T] >= time_left(run)) {
            observe_phase(run, motion, start, reached);
            return DONE;
        }
        idle = reached[CONTACT_T] <= motion->before[CONTACT_T] ? idle + 1 : 0;
        if (idle > PATIENCE)
            return STUCK;
    }
    return STOPPED;
}

static void add_contact(struct run *run, double entry, double leaving, double peak_time,
                        double root, double impulse, double momentum)
{
    if (run->contact_room == 0)
        return;
    double *row = &run->contacts[CONTACT_COLUMNS * run->contact_count];
    row[0] = entry;
    row[1] = leaving;
    row[2] = peak_time;
    row[3] = root;
    row[4] = impulse;
    row[5] = momentum;
    run->contact_count++;
}

/* Follow one contact, record its exit if it has one, and add its row. */
static int follow_contact(struct run *run, struct motion *motion, double entry)
{
    const double began = run->time, left = time_left(run);
    const struct motion_of_centre here = where_it_is(run);
    run->where = IN_CONTACT;
    if (left <= 0.0) {
        add_contact(run, entry, NAN, began, 0.0, NAN, cross(here.z, here.w));
        return DONE;
    }
    double start[MOST_VALUES] = {0.0}, atol[MOST_VALUES] = {0.0}, reached[MOST_VALUES];
    contact_start(here, left, &run->rotor, start);
    contact_tolerances(start, run->rtol, run->atol, atol);
    begin_differences(motion, start, atol);
    if (run->differences > 0 && start[CONTACT_T] > 0.0)
        fly_differences(run->bundle, run->differences, start[CONTACT_T], &run->rotor);
    copy_values(motion, start, reached);
    struct peak peak;
    memcpy(peak.values, start, sizeof peak.values);
    int leaves = 0, status = motion->restart(motion, start, atol);
    if (status == DONE)
        status = integrate_contact(run, motion, start, reached, &peak, &leaves);
    run->evaluations += motion->evaluations(motion);
    advance_run(run, reached[CONTACT_T], centre_of(motion, reached));
    if (status != DONE)
        return status;
    if (leaves) {
        run->where = IN_FLIGHT;
        if (run->event_room > 0)
            record_event(run, EXIT);
    }
    add_contact(run, entry, leaves ? run->time : NAN,
                smaller(began + peak.values[CONTACT_T], run->time), peak.values[CONTACT_Q],
                reached[CONTACT_J], peak.values[CONTACT_H]);
    return DONE;
}

/* ---- Displacement and velocity: without clearance, and flight that is integrated ---- */

static double radius_of(const double *values) { return sqrt(squared_radius_of(values)); }

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
    if (radius_of(motion->at(motion, high)) <= delta0)
        return INFINITY;
    if (radius_of(motion->at(motion, low)) >= delta0) {
        const int leaves = radial_rate_of(motion->at(motion, high)) > 0.0;
        return leaves ? larger(turn, 0.5 * (low + high)) : INFINITY;
    }
    return root_in_step(motion, radius_of, delta0, low, high);
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
static int follow_freely(struct run *run, struct motion *motion, struct peak *peak, int *touched)
{
    const double duration = time_left(run);
    double start[MOST_VALUES] = {run->state[0], run->state[1], run->state[2], run->state[3]};
    double atol[MOST_VALUES] = {run->atol, run->atol, run->atol, run->atol};
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
        *touched = touch <= duration + run->slack;
        end = *touched ? touch : smaller(motion->point, duration);
        raise_peak(peak, motion, end);
        copy_values(motion, motion->at(motion, end), reached);
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

/* Follow a rotor without clearance, which has no events, to the end. */
static int stay_in_contact(struct run *run, struct motion *motion)
{
    struct peak peak;
    int touched = 0;
    const double began = run->time;
    const int status = follow_freely(run, motion, &peak, &touched);
    const struct motion_of_centre at_peak = centre_of(motion, peak.values);
    add_contact(run, NAN, NAN, began + peak.time, sqrt(length(at_peak.z)), NAN,
                cross(at_peak.z, at_peak.w));
    return status;
}

/* ---- Flight ---- */

/* Fly to the next touch, or to the end, in closed form; say whether it is a touch. */
static int fly_exactly(struct run *run, int *touched)
{
    const double left = time_left(run), limit = left + run->slack;
    struct flight flight = {where_it_is(run), left};
    const double touch = first_touch(flight.start, &run->rotor, limit, run->stop);
    if (asked_to_stop(run->stop))
        return STOPPED;
    if (isnan(touch))
        return is_finite(run->state) ? STUCK : NOT_FINITE;
    *touched = touch <= limit;
    if (*touched)
        flight.span = touch;
    observe_flight(run, &flight);
    if (asked_to_stop(run->stop))
        return STOPPED; /* in the midst of it, perhaps */
    if (run->extremum_room > 0 && run->extremum_count >= run->extremum_room)
        return FULL;
    advance_run(run, flight.span, fly(flight.start, flight.span, &run->rotor));
    return is_finite(run->state) ? DONE : NOT_FINITE;
}

/* Put the rotor on the ring, off which rounding has moved it, and record its entry. */
static void enter(struct run *run)
{
    const double scale = run->rotor.delta0 / length(where_it_is(run).z);
    run->state[0] *= scale;
    run->state[1] *= scale;
    if (run->event_room > 0)
        record_event(run, ENTRY);
}

/* ---- The loop ---- */

/* The two integrations of a run; CVODE's must not move. */
struct motions {
    struct motion *contact, *free;
};

static int has_room(const struct run *run)
{
    const int events = run->event_room == 0 || run->events + EVENTS_A_CONTACT <= run->event_room;
    const int contacts = run->contact_room == 0 || run->contact_count < run->contact_room;
    const int extrema = run->extremum_room == 0 || run->extremum_count < run->extremum_room;
    return events && contacts && extrema;
}

static int follow_events(struct run *run, const struct motions *motions)
{
    if (run->where == UNDECIDED) {
        run->where = run->began = begins(where_it_is(run), &run->rotor);
        observe_start(run);
    }
    int status = DONE;
    while (status == DONE && time_left(run) > 0.0) {
        if (!has_room(run))
            return FULL;
        double entry = NAN;
        if (run->rotor.delta0 == 0.0) {
            status = stay_in_contact(run, motions->free);
            continue;
        }
        if (run->where == IN_FLIGHT) {
            int touched = 0;
            struct peak farthest;
            const int exact = run->exact_flight || run->method == TAYLOR;
            status = exact ? fly_exactly(run, &touched)
                           : follow_freely(run, motions->free, &farthest, &touched);
            if (status != DONE || !touched)
                continue;
            enter(run);
            entry = run->time;
        }
        status = follow_contact(run, motions->contact, entry);
    }
    return status;
}

/* Do what is asked with the motions of a run open. */
static int with_motions(struct run *run, int (*act)(struct run *, const struct motions *, void *),
                        void *more)
{
    const int tangents = run->differences > 0;
    const struct parameters model = parameters_of(&run->rotor, 0.0);
    if (run->method == TAYLOR) { /* flight is exact, so one of the two is enough */
        struct taylor taylor;
        const struct mode *mode = model.delta0 > 0.0 ? &contact_mode : &cartesian_mode;
        open_taylor(&taylor, mode, model, run->rtol, tangents);
        const struct motions motions = {&taylor.motion, &taylor.motion};
        return act(run, &motions, more);
    }
    struct cvode contact, free;
    const struct parameters felt = parameters_of(&run->rotor, model.delta0 == 0.0 ? 1.0 : 0.0);
    int status = open_cvode(&contact, run->sundials, run->method, &contact_mode, model, run->rtol,
                            tangents);
    const int second = open_cvode(&free, run->sundials, run->method, &cartesian_mode, felt,
                                  run->rtol, tangents);
    status = status == DONE ? second : status;
    if (status == DONE) {
        const struct motions motions = {&contact.motion, &free.motion};
        status = act(run, &motions, more);
        const int failure = contact.failure ? contact.failure : free.failure;
        status = failure ? failure : status;
    }
    close_cvode(&contact);
    close_cvode(&free);
    return status;
}

static int once(struct run *run, const struct motions *motions, void *more)
{
    (void)more;
    return follow_events(run, motions);
}

int core_run(struct run *run)
{
    const int status = with_motions(run, once, NULL);
    if (run->fixed_axes && status != FULL) {
        core_rotate(run->samples, run->sample_times, run->rotor.omega, run->sampled);
        core_rotate(run->event_states, run->event_times, run->rotor.omega, run->events);
        core_rotate(run->state, &run->time, run->rotor.omega, 1);
    }
    return status;
}

/* ---- Stretching ---- */

/* Make four rows orthonormal by Gram and Schmidt, twice; write the logarithms of their lengths. */
static void orthonormalise(double *rows, double *stretch)
{
    for (int i = 0; i < DIFFERENCES; i++) {
        double *row = &rows[4 * i];
        for (int again = 0; again < 2; again++) {
            for (int j = 0; j < i; j++) {
                const double *other = &rows[4 * j];
                double along = 0.0;
                for (int k = 0; k < 4; k++)
                    along += row[k] * other[k];
                for (int k = 0; k < 4; k++)
                    row[k] -= along * other[k];
            }
        }
        double square = 0.0;
        for (int k = 0; k < 4; k++)
            square += row[k] * row[k];
        const double size = sqrt(square);
        stretch[i] = log(size);
        for (int k = 0; k < 4; k++)
            row[k] /= size;
    }
}

struct stretching {
    int64_t spans;
    double *stretches;
    int64_t *done;
};

static int stretch(struct run *run, const struct motions *motions, void *more)
{
    const struct stretching *asked = more;
    int status = DONE;
    for (*asked->done = 0; *asked->done < asked->spans && status == DONE;) {
        run->time = 0.0;
        status = follow_events(run, motions);
        if (status == DONE) {
            orthonormalise(run->bundle, &asked->stretches[4 * *asked->done]);
            ++*asked->done;
        }
    }
    return status;
}

int core_stretch(struct run *run, int64_t spans, double *stretches, int64_t *done)
{
    struct stretching asked = {spans, stretches, done};
    return with_motions(run, stretch, &asked);
}

/* ---- What others ask of single states ---- */

int core_starts_in_contact(const struct rotor *rotor, const double state[4])
{
    return begins((struct motion_of_centre){{state[0], state[1]}, {state[2], state[3]}}, rotor)
           == IN_CONTACT;
}

void core_fly(const struct rotor *rotor, const double *states, const double *spans, double *reached,
              int64_t count)
{
    for (int64_t i = 0; i < count; i++) {
        const double *s = &states[4 * i];
        const struct motion_of_centre start = {{s[0], s[1]}, {s[2], s[3]}};
        const struct motion_of_centre there = fly(start, spans[i], rotor);
        const double row[4] = {there.z.x, there.z.y, there.w.x, there.w.y};
        memcpy(&reached[4 * i], row, sizeof row);
    }
}

double core_first_touch(const struct rotor *rotor, const double state[4], double limit,
                        const uint8_t *stop)
{
    const struct motion_of_centre start = {{state[0], state[1]}, {state[2], state[3]}};
    return first_touch(start, rotor, limit, stop);
}

void core_rotate(double *states, const double *times, double omega, int64_t count)
{
    for (int64_t i = 0; i < count; i++) {
        const struct vector turn = {cos(omega * times[i]), sin(omega * times[i])};
        for (double *pair = &states[4 * i]; pair < &states[4 * i + 4]; pair += 2) {
            const struct vector turned = product((struct vector){pair[0], pair[1]}, turn);
            pair[0] = turned.x;
            pair[1] = turned.y;
        }
    }
}

/* ---- Invariants ---- */

/* Radius at an event against delta0: the state is put there, so only rounding may remain. */
static const double ON_THE_RING = 8.0 * ROUNDING;

static double radius_at(const double *state) { return length((struct vector){state[0], state[1]}); }

static enum fault fault_of_events(const struct run *run, int64_t *row)
{
    const double delta0 = run->rotor.delta0;
    int expected = run->began == IN_CONTACT ? EXIT : ENTRY;
    for (*row = 0; *row < run->events; ++*row, expected = -expected) {
        const double *time = &run->event_times[*row], *state = &run->event_states[4 * *row];
        if (!is_finite(state))
            return EVENT_NOT_FINITE;
        if (*row > 0 && !(time[0] > time[-1]))
            return BACKWARDS;
        if (run->event_kinds[*row] != expected)
            return NOT_IN_TURN;
        if (!(fabs(radius_at(state) - delta0) <= ON_THE_RING * delta0))
            return OFF_THE_RING;
    }
    return SOUND;
}

static enum fault fault_of_samples(const struct run *run, double allowed, int64_t *row)
{
    int64_t passed = 0;
    double outwards = run->began == IN_CONTACT ? 1.0 : -1.0;
    for (*row = 0; *row < run->sampled; ++*row) {
        const double *state = &run->samples[4 * *row];
        if (!is_finite(state))
            return SAMPLE_NOT_FINITE;
        for (; passed < run->events && run->event_times[passed] <= run->sample_times[*row];
             passed++)
            outwards = -outwards;
        if (outwards * (radius_at(state) - run->rotor.delta0) < -allowed && run->rotor.delta0 > 0.0)
            return WRONG_SIDE_OF_THE_RING;
    }
    return SOUND;
}

int core_fault(const struct run *run, double allowed, int64_t *row)
{
    enum fault fault = fault_of_events(run, row);
    if (fault == SOUND)
        fault = fault_of_samples(run, allowed, row);
    for (int64_t i = 0; fault == SOUND && i < run->contact_count; i++) {
        const double *contact = &run->contacts[CONTACT_COLUMNS * i]; /* NaN where it has no end */
        if (run->rotor.delta0 > 0.0 && (contact[2] < contact[0] || contact[2] > contact[1])) {
            *row = i;
            fault = PEAKS_OUTSIDE;
        }
    }
    return (int)fault;
}
