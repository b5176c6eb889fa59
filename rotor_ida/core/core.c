/* What the core offers, but for lanes (lanes.c) and invariants (faults.c): see core.h. */
#include "cvode.h"
#include "events.h"

/* The mode in which a contact begins; with friction it has another, of the same size. */
static const struct mode *mode_of_contact(const struct run *run)
{
    const int is_varied = run->differences > DIFFERENCES && run->rotor.disc_radius > 0.0;
    const int rubs = run->rotor.friction > 0.0 || (is_varied && run->rotor.delta0 > 0.0);
    return HAS_FRICTION && rubs ? &rub_mode : &contact_mode;
}

/* Do what is asked with the motions of a run open: those that it needs. */
static int with_motions(struct run *run, int (*act)(struct run *, const struct motions *, void *),
                        void *more)
{
    const int tangents = run->differences > 0, touches = run->rotor.delta0 > 0.0;
    const struct parameters model = parameters_of(&run->rotor, 0.0);
    struct motions motions = {NULL, NULL};
    /* where flight has no closed form, Taylor series lead it whatever leads a contact */
    struct taylor taylor, flight;
    if (!HAS_CLOSED_FLIGHT) {
        open_taylor(&flight, &cartesian_mode, model, run->rtol, tangents);
        motions.free = &flight.motion;
    }
    if (run->method == TAYLOR) {
        const int contact = touches || !HAS_CLOSED_FLIGHT;
        open_taylor(&taylor, contact ? mode_of_contact(run) : &cartesian_mode, model, run->rtol,
                    tangents);
        motions.contact = &taylor.motion;
        if (HAS_CLOSED_FLIGHT)
            motions.free = &taylor.motion;
        return act(run, &motions, more);
    }
    struct cvode contact = {.degree = 0}, free = {.degree = 0};
    int status = DONE;
    if (touches) {
        status = open_cvode(&contact, run->sundials, run->method, mode_of_contact(run), model,
                            run->rtol, tangents);
        motions.contact = &contact.motion;
    }
    if (status == DONE && !(touches && (run->exact_flight || !HAS_CLOSED_FLIGHT))) {
        status = open_cvode(&free, run->sundials, run->method, &cartesian_mode,
                            parameters_of(&run->rotor, touches ? 0.0 : 1.0), run->rtol, tangents);
        motions.free = &free.motion;
    }
    if (status == DONE) {
        status = act(run, &motions, more);
        const int failure = contact.solver.failure ? contact.solver.failure : free.solver.failure;
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
                        const stop_flag *stop)
{
    return first_touch(motion_at(state, 0.0, rotor), rotor, limit, stop);
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
