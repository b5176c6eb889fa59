/* What the core offers, but for the lanes: see core.h. */
#include "cvode.h"
#include "events.h"

/* The mode in which a contact begins; with friction it has another, of the same size. */
static const struct mode *mode_of_contact(const struct run *run)
{
#ifdef WHOLE_MODEL
    const int is_varied = run->differences > DIFFERENCES && run->rotor.disc_radius > 0.0;
    if (run->rotor.friction > 0.0 || (is_varied && run->rotor.delta0 > 0.0))
        return &rub_mode;
#endif
    (void)run;
    return &contact_mode;
}

/* Do what is asked with the motions of a run open. */
static int with_motions(struct run *run, int (*act)(struct run *, const struct motions *, void *),
                        void *more)
{
    const int tangents = run->differences > 0;
    const struct parameters model = parameters_of(&run->rotor, 0.0);
#ifdef RUN_UP
    /* there is no closed form of flight, which Taylor series lead whatever leads a contact */
    struct taylor flight, taylor;
    open_taylor(&flight, &cartesian_mode, model, run->rtol, 0);
    if (run->method == TAYLOR) {
        open_taylor(&taylor, mode_of_contact(run), model, run->rtol, 0);
        const struct motions motions = {&taylor.motion, &flight.motion};
        return act(run, &motions, more);
    }
#else
    if (run->method == TAYLOR) { /* flight is exact, so one of the two is enough */
        struct taylor taylor;
        const struct mode *mode = model.delta0 > 0.0 ? mode_of_contact(run) : &cartesian_mode;
        open_taylor(&taylor, mode, model, run->rtol, tangents);
        const struct motions motions = {&taylor.motion, &taylor.motion};
        return act(run, &motions, more);
    }
#endif
    struct cvode contact, free;
    const struct parameters felt = parameters_of(&run->rotor, model.delta0 == 0.0 ? 1.0 : 0.0);
    int status = open_cvode(&contact, run->sundials, run->method, mode_of_contact(run), model,
                            run->rtol, tangents);
    const int second = open_cvode(&free, run->sundials, run->method, &cartesian_mode, felt,
                                  run->rtol, tangents);
    status = status == DONE ? second : status;
    if (status == DONE) {
        const struct motions motions = {
            &contact.motion,
#ifdef RUN_UP
            model.delta0 > 0.0 ? &flight.motion : &free.motion,
#else
            &free.motion,
#endif
        };
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

/* Make rows orthonormal by Gram and Schmidt, twice; write the logarithms of their lengths. */
static void orthonormalise(double *rows, int count, double *stretch)
{
    for (int i = 0; i < count; i++) {
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

/* Put a new direction in the place of the last of four, which is lost: one along an axis, the
 * farthest from the others. */
static void replace_last(double *rows)
{
    double *last = &rows[4 * (DIFFERENCES - 1)], unused[DIFFERENCES], least = INFINITY;
    int axis = 0;
    for (int k = 0; k < 4; k++) {
        double along = 0.0;
        for (int i = 0; i < DIFFERENCES - 1; i++)
            along += rows[4 * i + k] * rows[4 * i + k];
        axis = along < least ? k : axis;
        least = smaller(least, along);
    }
    for (int k = 0; k < 4; k++)
        last[k] = k == axis ? 1.0 : 0.0;
    orthonormalise(rows, DIFFERENCES, unused);
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
            double *row = &asked->stretches[STRETCH_COLUMNS * *asked->done];
            orthonormalise(run->bundle, DIFFERENCES - run->flattened, row);
            row[DIFFERENCES] = run->volume_lost;
            if (run->flattened) {
                row[DIFFERENCES - 1] = -INFINITY;
                replace_last(run->bundle);
            }
            run->flattened = 0;
            run->volume_lost = 0.0;
            run->shift += run->duration;
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

#ifndef RUN_UP
int core_starts_in_contact(const struct rotor *rotor, const double state[4])
{
    return decide_mode(motion_at(state, 0.0, rotor), rotor) == IN_CONTACT;
}

void core_fly(const struct rotor *rotor, const double *states, const double *spans, double *reached,
              int64_t count)
{
    for (int64_t i = 0; i < count; i++) {
        const double *s = &states[4 * i];
        const struct motion_of_centre there = fly(motion_at(s, 0.0, rotor), spans[i], rotor);
        const double row[4] = {there.z.x, there.z.y, there.w.x, there.w.y};
        memcpy(&reached[4 * i], row, sizeof row);
    }
}

double core_first_touch(const struct rotor *rotor, const double state[4], double limit,
                        const uint8_t *stop)
{
    return first_touch(motion_at(state, 0.0, rotor), rotor, limit, stop);
}

#endif

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

/* The slip speed of a disc that rolls, in parts of its speeds: it is put there likewise. */
static const double OFF_ROLLING = 256.0 * ROUNDING;

static double radius_at(const double *state) { return length((struct vector){state[0], state[1]}); }

/* Whether what happens with friction, and what follows, fits the way in which the rotor moved. */
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
static int way_from(const struct run *run, int64_t event)
{
    return event < 0 ? run->way_began : run->event_ways[event];
}

static enum fault fault_of_events(const struct run *run, int64_t *row)
{
    const double delta0 = run->rotor.delta0;
    /* a contact that was entered begins pressed */
    int in_contact = run->began == IN_CONTACT, entered = 0, last = 0; /* of press and release */
    for (*row = 0; *row < run->events; ++*row) {
        const double *time = &run->event_times[*row], *state = &run->event_states[4 * *row];
        if (!is_finite(state))
            return EVENT_NOT_FINITE;
        if (*row > 0 && !(time[0] > time[-1]))
            return BACKWARDS;
        const int kind = run->event_kinds[*row];
        if (run->event_ways != NULL
            && !is_in_turn(kind, way_from(run, *row - 1), way_from(run, *row)))
            return NOT_IN_TURN;
        if (is_of_friction(kind)) {
            if (!in_contact || run->event_ways == NULL)
                return NOT_IN_TURN;
            if (!(radius_at(state) >= delta0 * (1.0 - ON_THE_RING)))
                return OFF_THE_RING;
            continue;
        }
        if (kind == PRESS || kind == RELEASE) {
            if (!in_contact || kind == last || (last == 0 && kind == PRESS && entered))
                return NOT_IN_TURN;
            last = kind;
            if (!(radius_at(state) >= delta0 * (1.0 - ON_THE_RING)))
                return OFF_THE_RING;
            continue;
        }
        if (kind != (in_contact ? EXIT : ENTRY))
            return NOT_IN_TURN;
        if (!(fabs(radius_at(state) - delta0) <= ON_THE_RING * delta0))
            return OFF_THE_RING;
        in_contact = !in_contact;
        entered = 1;
        last = 0;
    }
    return SOUND;
}

/* Whether the contact begins loose in which a run begins: only then is it pressed first. */
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
    const double held = 1.0 + damping * dot(z, v) / radius;
    const double least = damping * allowed * (1.0 + length(v) / run->rotor.delta0);
    return (loose ? -held : held) < -least;
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

/* What a sample says against the way in which surfaces slide, or the disc rolls. */
static enum fault fault_of_way(const struct run *run, const double *state, double time, int way,
                               double allowed)
{
    const struct rotor *rotor = &run->rotor;
    const struct vector z = {state[0], state[1]}, v = {state[2], state[3]};
    const double radius = length(z), rim = rotor->disc_radius * rotor->omega;
    const double slip = cross(z, v) / radius + rim, depth = larger(radius - rotor->delta0, 0.0);
    const double more = allowed * (1.0 + (length(v) + rim) / rotor->delta0);
    if (way != ROLLS)
        return way != IS_LOOSE && way != FLIES && way * slip < -more ? SLIDES_ASTRAY : SOUND;
    if (!(fabs(slip) <= OFF_ROLLING * (length(v) + rim)))
        return SLIPS_WHILE_ROLLING;
    const double spring = pow(depth, rotor->contact_exponent);
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
        if (run->event_ways != NULL) {
            const enum fault fault = fault_of_way(run, state, run->sample_times[*row],
                                                  way_from(run, passed - 1), allowed);
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
        const double *contact = &run->contacts[CONTACT_COLUMNS * i]; /* NaN where it has no end */
        if (run->rotor.delta0 > 0.0 && (contact[2] < contact[0] || contact[2] > contact[1])) {
            *row = i;
            fault = PEAKS_OUTSIDE;
        }
    }
    return (int)fault;
}
