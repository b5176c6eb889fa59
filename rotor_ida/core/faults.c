/* What of a run contradicts the mechanics: its invariants, by formulas of their own. */
#include "events.h"

/* Radius at an event against delta0: the state is put there, so only rounding may remain. */
static const double RADIUS_ROUNDING = 8.0 * ROUNDING;

/* The slip speed of a disc that rolls, in parts of its speeds: it is put there likewise. */
static const double SLIP_ROUNDING = 256.0 * ROUNDING;

static double radius_at(const double *state) { return length((struct vector){state[0], state[1]}); }

/* Whether what happens with friction, and what follows, fits the mode in which the rotor moved. */
static int is_in_turn(int kind, int before, int now)
{
    const int slides = now == SLIDES_FORWARDS || now == SLIDES_BACKWARDS;
    const int slid = before == SLIDES_FORWARDS || before == SLIDES_BACKWARDS;
    switch (kind) {
    case ENTRY:
        return before == FLIES && (slides || now == ROLLS);
    case EXIT:
        return before != FLIES && now == FLIES;
    case ROLL:
        return slid && now == ROLLS;
    case SLIP:
        return before == ROLLS && slides;
    case REVERSE:
        return slid && now == -before;
    case RELEASE:
        return (slid || before == ROLLS) && now == IS_LOOSE;
    case PRESS:
        return before == IS_LOOSE && (slides || now == ROLLS);
    default:
        return 0;
    }
}

static int is_of_friction(int kind) { return kind == ROLL || kind == SLIP || kind == REVERSE; }

/* How the rotor moves from an event on; before all with friction as at the start. */
static int mode_from(const struct run *run, int64_t event)
{
    return event < 0 ? run->mode_began : run->event_modes[event];
}

/* What of the order of events is known so far. */
struct order {
    int in_contact, entered; /* a contact that was entered is not loose */
    int last;                /* press or release of this contact */
};

/* Whether an event follows from those before, and takes its place among them. */
static int follows(struct order *order, int kind, const struct run *run)
{
    if (is_of_friction(kind))
        return order->in_contact && run->event_modes != NULL;
    if (kind == PRESS || kind == RELEASE) {
        const int repeats = kind == order->last
                            || (order->last == 0 && kind == PRESS && order->entered);
        order->last = kind;
        return order->in_contact && !repeats;
    }
    if (kind != (order->in_contact ? EXIT : ENTRY))
        return 0;
    *order = (struct order){.in_contact = !order->in_contact, .entered = 1};
    return 1;
}

static enum fault fault_of_events(const struct run *run, int64_t *row)
{
    const double delta0 = run->rotor.delta0;
    struct order order = {.in_contact = run->began == IN_CONTACT};
    for (*row = 0; *row < run->events; ++*row) {
        const double *time = &run->event_times[*row], *state = &run->event_states[4 * *row];
        if (!is_finite(state))
            return EVENT_NOT_FINITE;
        if (*row > 0 && !(time[0] > time[-1]))
            return BACKWARDS;
        const int kind = run->event_kinds[*row];
        if (run->event_modes != NULL
            && !is_in_turn(kind, mode_from(run, *row - 1), mode_from(run, *row)))
            return NOT_IN_TURN;
        if (!follows(&order, kind, run))
            return NOT_IN_TURN;
        const double off = radius_at(state) - delta0;
        const int on_ring = kind == ENTRY || kind == EXIT
                                ? fabs(off) <= RADIUS_ROUNDING * delta0
                                : radius_at(state) >= delta0 * (1.0 - RADIUS_ROUNDING);
        if (!on_ring)
            return OFF_THE_RING;
    }
    return SOUND;
}

/* Whether the contact begins loose in which a run begins: only then a press comes first. */
static int begins_loose(const struct run *run)
{
    return run->began == IN_CONTACT && run->events > 0 && run->event_kinds[0] == PRESS;
}

/* How far 1 + c d' may lie on the wrong side of 0: as far as a sample off the ring, by its speed.
 */
static int is_tensile(const struct run *run, const double *state, int loose, double allowed)
{
    const struct vector z = {state[0], state[1]}, v = {state[2], state[3]};
    const double radius = length(z), damping = run->rotor.contact_damping;
    const double factor = 1.0 + damping * dot(z, v) / radius;
    const double least = damping * allowed * (1.0 + length(v) / run->rotor.delta0);
    return (loose ? -factor : factor) < -least;
}

/* The tangential force that rolling needs at a time on axes that stand still. */
static double hold_at(const struct rotor *rotor, const double *state, double time)
{
    const struct vector z = {state[0], state[1]}, v = {state[2], state[3]};
    const double radius = length(z), rim = rotor->disc_radius * rotor->omega;
    const struct vector drive = {cos(rotor->omega * time), sin(rotor->omega * time)};
    return (rotor->omega * rotor->omega * cross(z, drive) - rotor->load * z.x) / radius
           + rim * (2.0 * rotor->zeta + dot(z, v) / (radius * radius));
}

/* What a sample says against the mode, in which surfaces slide or the disc rolls. */
static enum fault fault_of_mode(const struct run *run, const double *state, double time, int mode,
                                double allowed)
{
    const struct rotor *rotor = &run->rotor;
    const struct vector z = {state[0], state[1]}, v = {state[2], state[3]};
    const double radius = length(z), rim = rotor->disc_radius * rotor->omega;
    const double slip = cross(z, v) / radius + rim, depth = larger(radius - rotor->delta0, 0.0);
    const double more = allowed * (1.0 + (length(v) + rim) / rotor->delta0);
    if (mode != ROLLS)
        return mode != IS_LOOSE && mode != FLIES && mode * slip < -more ? SLIDES_ASTRAY : SOUND;
    if (!(fabs(slip) <= SLIP_ROUNDING * (length(v) + rim)))
        return SLIPS_WHILE_ROLLING;
    const double spring = to_power(depth, rotor->contact_exponent);
    const double factor = 1.0 + rotor->contact_damping * dot(z, v) / radius;
    const double grip = rotor->friction * larger(spring * factor, 0.0);
    const double steep = 1.5 * (1.0 + sqrt(depth)) * (1.0 + fabs(factor))
                         + rotor->contact_damping * spring + rotor->omega * rotor->omega
                         + rotor->load;
    return fabs(hold_at(rotor, state, time)) > grip + more * (1.0 + steep) ? SLIPS_WHILE_ROLLING
                                                                           : SOUND;
}

static enum fault fault_of_samples(const struct run *run, double allowed, int64_t *row)
{
    int64_t passed = 0;
    double outwards = run->began == IN_CONTACT ? 1.0 : -1.0;
    int loose = begins_loose(run);
    /* without an event before its end it is not known how the first contact began */
    int known = run->began != IN_CONTACT || (run->events > 0 && run->event_kinds[0] != EXIT);
    for (*row = 0; *row < run->sampled; ++*row) {
        const double *state = &run->samples[4 * *row];
        if (!is_finite(state))
            return SAMPLE_NOT_FINITE;
        for (; passed < run->events && run->event_times[passed] <= run->sample_times[*row];
             passed++) {
            const int kind = run->event_kinds[passed];
            outwards = kind == ENTRY || kind == EXIT ? -outwards : outwards;
            loose = kind == RELEASE;
            known = 1;
        }
        if (outwards * (radius_at(state) - run->rotor.delta0) < -allowed && run->rotor.delta0 > 0.0)
            return WRONG_SIDE_OF_THE_RING;
        if (outwards > 0.0 && known && run->rotor.contact_damping > 0.0
            && is_tensile(run, state, loose, allowed))
            return TENSILE;
        if (run->event_modes != NULL) {
            const enum fault fault = fault_of_mode(run, state, run->sample_times[*row],
                                                   mode_from(run, passed - 1), allowed);
            if (fault != SOUND)
                return fault;
        }
    }
    return SOUND;
}

int core_fault(const struct run *run, double allowed, int64_t *row)
{
    enum fault fault = fault_of_events(run, row);
    if (fault == SOUND)
        fault = fault_of_samples(run, allowed, row);
    for (int64_t i = 0; fault == SOUND && i < run->contact_count; i++) {
        const struct contact *contact = &run->contacts[i]; /* NaN where it has no end */
        if (run->rotor.delta0 > 0.0
            && (contact->peak_time < contact->entry || contact->peak_time > contact->exit)) {
            *row = i;
            fault = PEAKS_OUTSIDE;
        }
    }
    return (int)fault;
}
