/* The event loop: from the start through flight and contact, event by event, to the end.
 *
 * `follow_events` decides whether the run begins in flight or in contact, and lets the two take
 * turns. A flight ends at an entry (`enter`). `follow_contact` begins a contact, has it integrated
 * by `integrate_contact` (contact_phase.c), which finds its exit and changes its mode at release,
 * press and events of friction on the way, and records the exit and the row of the contact. */
#include "events.h"

struct motion_of_centre motion_at(const double *state, double time, const struct rotor *rotor)
{
    struct motion_of_centre centre = {.z = {state[0], state[1]}, .w = {state[2], state[3]}};
    if (IS_WHOLE) { /* -i exp(-i omega t) */
        const double angle = rotor->omega * time;
        centre.down = (struct vector){-sin(angle), -cos(angle)};
    }
    return centre;
}

struct motion_of_centre where_it_is(const struct run *run)
{
    if (!SPEED_CHANGES)
        return motion_at(run->state, run->shift + run->time, &run->rotor);
    struct motion_of_centre here = motion_at(run->state, 0.0, &run->rotor);
    here.down = (struct vector){-sin(run->angle), -cos(run->angle)};
    here.speed = run->rotor.omega;
    return here;
}

int is_finite(const double *state) { return isfinite(state[0] + state[1] + state[2] + state[3]); }

static int is_prescribed(const struct rotor *rotor) { return rotor->inverse_inertia == 0.0; }

void begin_piece(struct run *run)
{
    const struct piece *piece = &run->pieces[run->piece];
    struct rotor *rotor = &run->rotor;
    rotor->rate = piece->rate;
    rotor->torque = piece->torque;
    rotor->slope = piece->slope;
    rotor->inverse_inertia = piece->inverse_inertia;
    if (is_prescribed(rotor))
        rotor->omega = piece->speed;
}

/* Go on to the piece of a speed that changes in which the run is. */
static void pass_pieces(struct run *run)
{
    while (SPEED_CHANGES && run->piece + 1 < run->piece_count
           && run->time >= run->pieces[run->piece].end) {
        run->piece++;
        begin_piece(run);
    }
}

/* Turn the rotor as far as it has turned in a phase that ends now. */
static void turn_rotor(struct run *run, struct motion_of_centre centre)
{
    const struct piece *piece = &run->pieces[run->piece];
    const double begun = run->piece > 0 ? piece[-1].end : 0.0;
    run->angle += centre.angle;
    run->rotor.omega = is_prescribed(&run->rotor) ? piece->speed + piece->rate * (run->time - begun)
                                                  : centre.speed;
}

/* Advance the time by `span`, to a new displacement and velocity. */
void advance_run(struct run *run, double span, struct motion_of_centre centre)
{
    if (span == time_left(run))
        run->time = run->duration;
    else if (SPEED_CHANGES && span == phase_left(run))
        run->time = run->pieces[run->piece].end;
    else
        run->time += span;
    if (SPEED_CHANGES)
        turn_rotor(run, centre);
    run->state[0] = centre.z.x;
    run->state[1] = centre.z.y;
    run->state[2] = centre.w.x;
    run->state[3] = centre.w.y;
}

/* ---- Contacts ---- */

static void add_contact(struct run *run, struct contact contact)
{
    if (run->contact_room > 0)
        run->contacts[run->contact_count++] = contact;
}

/* Take back what happened in a contact at the very time of its exit. */
static void take_back(struct run *run)
{
    while (run->event_room > 0 && run->events > 0 && run->event_times[run->events - 1] >= run->time
           && run->event_kinds[run->events - 1] != ENTRY)
        run->events--;
}

/* Follow one contact, record its exit if it has one, and add its row. */
static int follow_contact(struct run *run, struct motion *motion, double entry)
{
    const double began = run->time, left = time_left(run);
    const struct motion_of_centre here = where_it_is(run);
    run->where = IN_CONTACT;
    if (SPEED_CHANGES)
        motion->model = parameters_of(&run->rotor, 0.0);
    if (left <= 0.0) {
        add_contact(run, (struct contact){.entry = entry,
                                          .exit = NAN,
                                          .peak_time = began,
                                          .impulse = NAN,
                                          .momentum = cross(here.z, here.w)});
        if (!IS_WHOLE)
            return DONE;
    }
    double start[MOST_VALUES] = {0.0}, atol[MOST_VALUES] = {0.0}, reached[MOST_VALUES];
    begin_contact(here, phase_left(run), &run->rotor, start);
    contact_tolerances(start, run->rtol, run->atol, atol);
    begin_with_friction(motion, start, atol);
    if (SPEED_CHANGES && motion->model.contact_damping == 0.0)
        /* then the work on the ring is what it holds */
        start[CONTACT_WORK] = energy_of_root(&motion->model, start[CONTACT_Q]);
    begin_differences(motion, start, atol);
    if (run->differences > 0 && start[CONTACT_T] > 0.0)
        fly_differences(run->bundle, run->differences, start[CONTACT_T], &run->rotor);
    copy_values(motion, start, reached);
    struct peak peak = {.force = 0.0, .slid = 0.0};
    memcpy(peak.values, start, sizeof peak.values);
    decide_looseness(motion, start);
    if (IS_WHOLE) {
        motion->down = here.down;
        decide_friction(motion, start);
        observe_jump(run, motion, 0.0, start);
        if (run->event_room > 0)
            record_mode(run, motion);
        if (left <= 0.0)
            return DONE;
    }
    int leaves = 0, status = motion->restart(motion, start, atol);
    if (status == DONE)
        status = integrate_contact(run, motion, start, atol, reached, &peak, &leaves);
    run->evaluations += motion->evaluations(motion);
    advance_run(run, reached[CONTACT_T], centre_of(motion, reached));
    if (status != DONE)
        return status;
    if (leaves) {
        run->where = IN_FLIGHT;
        if (IS_WHOLE)
            take_back(run);
        if (run->event_room > 0)
            record_event(run, EXIT);
        if (run->event_room > 0 && run->event_modes != NULL)
            run->event_modes[run->events - 1] = FLIES;
    }
    add_contact(run, (struct contact){
                         .entry = entry,
                         .exit = leaves ? run->time : NAN,
                         .peak_time = smaller(began + peak.values[CONTACT_T], run->time),
                         .peak_root = peak.values[CONTACT_Q],
                         .impulse = reached[CONTACT_J],
                         .momentum = momentum_of(motion, peak.values),
                         .lost = lost_of(motion, start, reached),
                         .largest_force = peak.force,
                         .heat = heat_of(motion, reached),
                         .slip_distance = peak.slid,
                     });
    return DONE;
}

/* Follow a rotor without clearance, which has no events, to the end. */
static int stay_in_contact(struct run *run, struct motion *motion)
{
    struct motion_of_centre farthest = {.z = {0.0, 0.0}};
    double at = run->time;
    int touched = 0, status = DONE;
    while (status == DONE && time_left(run) > 0.0) { /* once, but where a speed changes */
        struct peak peak;
        const double began = run->time;
        pass_pieces(run);
        status = follow_freely(run, motion, &peak, &touched);
        const struct motion_of_centre at_peak = centre_of(motion, peak.values);
        if (length(at_peak.z) >= length(farthest.z)) {
            farthest = at_peak;
            at = began + peak.time;
        }
    }
    add_contact(run, (struct contact){.entry = NAN,
                                      .exit = NAN,
                                      .peak_time = at,
                                      .peak_root = sqrt(length(farthest.z)),
                                      .impulse = NAN,
                                      .momentum = cross(farthest.z, farthest.w),
                                      .largest_force = NAN});
    return status;
}

/* ---- Flight ---- */

/* Fly to the next touch, or to the end, in closed form; say whether it is a touch. */
static int fly_exactly(struct run *run, int *touched)
{
    const double left = time_left(run), limit = left + run->slack;
    struct flight flight = {where_it_is(run), left};
    const int status = allow_step(run);
    if (status != DONE)
        return status;
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

static int has_room(const struct run *run)
{
    const int events = run->event_room == 0 || run->events + EVENTS_A_CONTACT <= run->event_room;
    const int contacts = run->contact_room == 0 || run->contact_count < run->contact_room;
    const int extrema = run->extremum_room == 0 || run->extremum_count < run->extremum_room;
    return events && contacts && extrema;
}

int follow_events(struct run *run, const struct motions *motions)
{
    if (!is_finite(run->state))
        return NOT_FINITE;
    if (run->where == UNDECIDED) {
        if (SPEED_CHANGES)
            begin_piece(run);
        run->where = run->began = decide_mode(where_it_is(run), &run->rotor);
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
            const int exact = HAS_CLOSED_FLIGHT && (run->exact_flight || run->method == TAYLOR);
            status = exact ? fly_exactly(run, &touched)
                           : follow_freely(run, motions->free, &farthest, &touched);
            pass_pieces(run);
            if (status != DONE || !touched)
                continue;
            enter(run);
            entry = run->time;
        }
        status = follow_contact(run, motions->contact, entry);
        pass_pieces(run);
    }
    if (status == DONE)
        observe_end(run);
    return status;
}
