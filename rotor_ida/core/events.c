/* The event loop: from the start through flight and contact, event by event, to the end.
 *
 * Decide the mode at the start; integrate inside the mode until something may have happened; look
 * for a crossing that the step hid; polish the event; record it; restart in the other mode. */
#include "events.h"

struct motion_of_centre motion_at(const double *state, double time, const struct rotor *rotor)
{
    struct motion_of_centre centre = {.z = {state[0], state[1]}, .w = {state[2], state[3]}};
    if (WHOLE) { /* -i exp(-i omega t) */
        const double angle = rotor->omega * time;
        centre.down = (struct vector){-sin(angle), -cos(angle)};
    }
    return centre;
}

struct motion_of_centre where_it_is(const struct run *run)
{
    return motion_at(run->state, run->shift + run->time, &run->rotor);
}

int is_finite(const double *state) { return isfinite(state[0] + state[1] + state[2] + state[3]); }

/* Advance the time by `span`, to a new displacement and velocity. */
void advance_run(struct run *run, double span, struct motion_of_centre centre)
{
    run->time = span == time_left(run) ? run->duration : run->time + span;
    run->state[0] = centre.z.x;
    run->state[1] = centre.z.y;
    run->state[2] = centre.w.x;
    run->state[3] = centre.w.y;
}

/* ---- Contacts ---- */

static void add_contact(struct run *run, double entry, double leaving, double peak_time,
                        double root, double impulse, double momentum, double lost, double force,
                        double heat)
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
    row[6] = lost;
    row[7] = force;
    row[8] = heat;
    run->contact_count++;
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
    if (left <= 0.0) {
        add_contact(run, entry, NAN, began, 0.0, NAN, cross(here.z, here.w), 0.0, 0.0, 0.0);
        if (!WHOLE)
            return DONE;
    }
    double start[MOST_VALUES] = {0.0}, atol[MOST_VALUES] = {0.0}, reached[MOST_VALUES];
    begin_contact(here, left, &run->rotor, start);
    contact_tolerances(start, run->rtol, run->atol, atol);
#ifdef WHOLE_MODEL
    begin_with_friction(motion, start, atol);
#endif
    begin_differences(motion, start, atol);
    if (run->differences > 0 && start[CONTACT_T] > 0.0)
        fly_differences(run->bundle, run->differences, start[CONTACT_T], &run->rotor);
    copy_values(motion, start, reached);
    struct peak peak = {.force = 0.0};
    memcpy(peak.values, start, sizeof peak.values);
    begin_pressed(motion, start);
#ifdef WHOLE_MODEL
    motion->down = here.down;
    settle_friction(motion, start);
    observe_jump(run, motion, 0.0, start);
    if (run->event_room > 0)
        record_way(run, motion);
    if (left <= 0.0)
        return DONE;
#endif
    int leaves = 0, status = motion->restart(motion, start, atol);
    if (status == DONE)
        status = integrate_contact(run, motion, start, atol, reached, &peak, &leaves);
    run->evaluations += motion->evaluations(motion);
    advance_run(run, reached[CONTACT_T], centre_of(motion, reached));
    if (status != DONE)
        return status;
    if (leaves) {
        run->where = IN_FLIGHT;
        if (WHOLE)
            take_back(run);
        if (run->event_room > 0)
            record_event(run, EXIT);
        if (run->event_room > 0 && run->event_ways != NULL)
            run->event_ways[run->events - 1] = FLIES;
    }
    add_contact(run, entry, leaves ? run->time : NAN,
                smaller(began + peak.values[CONTACT_T], run->time), peak.values[CONTACT_Q],
                reached[CONTACT_J], momentum_of(motion, peak.values),
                lost_of(motion, start, reached), peak.force, heat_of(motion, reached));
    return DONE;
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
                cross(at_peak.z, at_peak.w), 0.0, NAN, 0.0);
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
    if (status == DONE)
        observe_end(run);
    return status;
}
