/* What watches a run: samples, events, and extrema of the radius. Differences: see differences.c.
 *
 * Each looks at flights and at steps as the event loop (events.c) comes past them, and does nothing
 * where it was not asked for. */
#include "observers.h"

/* How closely steps without clearance, and of flights that are integrated, are looked at for
 * extrema. */
enum { LOOKS_A_STEP = 4, MOST_BISECTIONS = 80 };

double time_left(const struct run *run) { return run->duration - run->time; }

double phase_left(const struct run *run)
{
    if (SPEED_CHANGES && run->piece + 1 < run->piece_count)
        return smaller(run->pieces[run->piece].end - run->time, time_left(run));
    return time_left(run);
}

double contact_root_of(const double *values) { return values[CONTACT_Q]; }
double radial_velocity_of(const double *values) { return values[CONTACT_P]; }
double time_of(const double *values) { return values[CONTACT_T]; }

double radial_rate_of(const double *values)
{
    return values[CARTESIAN_X] * values[CARTESIAN_VX] + values[CARTESIAN_Y] * values[CARTESIAN_VY];
}

double squared_radius_of(const double *values)
{
    return values[CARTESIAN_X] * values[CARTESIAN_X] + values[CARTESIAN_Y] * values[CARTESIAN_Y];
}

/* Inlined, as all samples are read so. */
static inline __attribute__((always_inline)) struct motion_of_centre
centre_at(const struct motion *motion, const double *values)
{
    struct motion_of_centre centre;
    if (is_contact(motion)) {
        const struct vector outwards = direction_of(values);
        const double radius = radius_in_contact(&motion->model, values);
        const struct vector velocity = {values[CONTACT_P], momentum_of(motion, values) / radius};
        centre.z = scaled(radius, outwards);
        centre.w = product(velocity, outwards);
    } else {
        centre.z = (struct vector){values[CARTESIAN_X], values[CARTESIAN_Y]};
        centre.w = (struct vector){values[CARTESIAN_VX], values[CARTESIAN_VY]};
    }
    centre.down = (struct vector){0.0, 0.0};
    centre.speed = SPEED_CHANGES ? speed_of(motion, values) : 0.0;
    centre.angle = SPEED_CHANGES ? angle_of(motion, values) : 0.0;
    return centre;
}

struct motion_of_centre centre_of(const struct motion *motion, const double *values)
{
    return centre_at(motion, values);
}

static void write_state(double *row, struct motion_of_centre centre)
{
    row[0] = centre.z.x;
    row[1] = centre.z.y;
    row[2] = centre.w.x;
    row[3] = centre.w.y;
}

/* Write angle and speed into a table of them. */
static void write_turn(double *table, int64_t row, double angle, double speed)
{
    if (table == NULL)
        return;
    table[2 * row] = angle;
    table[2 * row + 1] = speed;
}

void record_event(struct run *run, enum event kind)
{
    write_turn(run->event_turns, run->events, run->angle, run->rotor.omega);
    run->event_times[run->events] = run->time;
    run->event_kinds[run->events] = (int8_t)kind;
    memcpy(&run->event_states[4 * run->events], run->state, sizeof run->state);
    run->events++;
}

void record_event_inside(struct run *run, enum event kind, double since,
                         struct motion_of_centre centre)
{
    run->event_times[run->events] = run->time + since;
    run->event_kinds[run->events] = (int8_t)kind;
    write_state(&run->event_states[4 * run->events], centre);
    write_turn(run->event_turns, run->events, run->angle + centre.angle, centre.speed);
    run->events++;
}

/* ---- Samples ---- */

/* The next sample time, counted from now and clipped to the next `span`; infinite where none is
 * left, or none lies within it. */
static double next_sample(const struct run *run, double span)
{
    if (run->sampled >= run->sample_count)
        return INFINITY;
    /* time + left may fall short of the duration by rounding; its sample must not be lost */
    const double until = span >= time_left(run) ? run->duration : run->time + span;
    const double next = run->sample_times[run->sampled];
    return next > until ? INFINITY : smaller(larger(next - run->time, 0.0), span);
}

static void record_sample(struct run *run, struct motion_of_centre centre)
{
    write_state(&run->samples[4 * run->sampled], centre);
    write_turn(run->sample_turns, run->sampled, run->angle + centre.angle, centre.speed);
    run->sampled++;
}

/* Record where the run stands. */
static void record_sample_here(struct run *run)
{
    memcpy(&run->samples[4 * run->sampled], run->state, sizeof run->state);
    write_turn(run->sample_turns, run->sampled, run->angle, run->rotor.omega);
    run->sampled++;
}

void observe_start(struct run *run)
{
    if (next_sample(run, 0.0) == 0.0)
        record_sample_here(run);
}

/* Whether a sample is left that lies within the next `span`, and is due until some time of it. */
static int is_due(const struct run *run, double span, double until, double *due)
{
    *due = next_sample(run, span);
    return isfinite(*due) && *due <= until;
}

/* Samples at the end of a run, which the last phase may have left out: its own time, added to that
 * at which it began, may round to the end. */
void observe_end(struct run *run)
{
    while (run->sampled < run->sample_count && run->sample_times[run->sampled] <= run->duration)
        record_sample_here(run);
}

static void sample_flight(struct run *run, const struct flight *flight)
{
    for (double due; is_due(run, flight->span, flight->span, &due) && !asked_to_stop(run->stop);)
        record_sample(run, fly(flight->start, due, &run->rotor));
}

/* About in which part of the last step a time lies: u as a cubic of t, du = dt/q. */
static double guess_of_part(const struct motion *motion, double time)
{
    const double *before = motion->before, *after = motion->values;
    const double span = after[CONTACT_T] - before[CONTACT_T], reach = motion->point - motion->low;
    if (span <= 0.0)
        return 0.5;
    double part = (time - before[CONTACT_T]) / span;
    if (before[CONTACT_Q] > 0.0 && after[CONTACT_Q] > 0.0) {
        const double start = span / (before[CONTACT_Q] * reach) - 1.0;
        const double end = 1.0 - span / (after[CONTACT_Q] * reach);
        part += part * (1.0 - part) * (start * (1.0 - part) + end * part);
    }
    return smaller(larger(part, 0.0), 1.0);
}

/* The values at a time inside the last step: Halley's method, kept in a bracket. */
static const double *values_at(const struct step *step, double time)
{
    struct motion *motion = step->motion;
    double low = motion->low, high = step->end;
    double point = smaller(low + (motion->point - low) * guess_of_part(motion, time), high);
    const double *values = motion->glance_at(motion, point), finest = 4e-16 * larger(1.0, time);
    for (int i = 0; i < 60; i++) {
        const double late = values[CONTACT_T] - time;
        if (fabs(late) <= finest || high - low <= 4e-16 * high)
            break;
        if (late > 0.0)
            high = point;
        else
            low = point;
        double new = low;
        if (values[CONTACT_Q] > 0.0) { /* t' = q, t'' = p/2 */
            const double by = late / values[CONTACT_Q];
            new = point - by / (1.0 - 0.25 * by * values[CONTACT_P] / values[CONTACT_Q]);
        }
        point = low < new && new < high ? new : 0.5 * (low + high);
        values = motion->glance_at(motion, point);
    }
    return values;
}

static void sample_step(struct run *run, const struct step *step)
{
    struct motion *motion = step->motion;
    const double left = time_left(run);
    if (!is_contact(motion)) {
        for (double due; is_due(run, left, step->end, &due) && !asked_to_stop(run->stop);)
            record_sample(run, centre_at(motion, motion->glance_at(motion, due)));
        return;
    }
    while (run->sampled < run->sample_count && !asked_to_stop(run->stop)) {
        const double next = run->sample_times[run->sampled];
        const double due = smaller(larger(next - run->time, 0.0), left);
        if (next > run->duration || due > step->until)
            break;
        record_sample(run, centre_at(motion, values_at(step, due)));
    }
}

/* ---- Extrema of the radius ---- */

static void record_extremum(struct run *run, double time, int kind, struct motion_of_centre centre)
{
    struct extremum *extremum = &run->extrema[run->extremum_count];
    extremum->time = time;
    extremum->radius = length(centre.z);
    extremum->kind = kind;
    write_state(extremum->state, centre);
    run->extremum_count++;
}

static int has_room_for_extrema(const struct run *run)
{
    return run->extremum_count < run->extremum_room;
}

/* Of a state on the rotating axes, where the force without clearance is felt or not. */
static struct turning turning_of(const struct rotor *rotor, double felt, const double *state)
{
    const struct parameters model = parameters_of(rotor, felt);
    double rates[CARTESIAN_SIZE];
    cartesian_mode.field(&model, state, rates);
    const struct vector z = {state[0], state[1]}, w = {state[2], state[3]};
    const struct vector z_rate = {rates[0], rates[1]}, w_rate = {rates[2], rates[3]};
    return (struct turning){dot(z, w), dot(z_rate, w) + dot(z, w_rate)};
}

static void find_extrema_of_flight(struct run *run, const struct flight *flight)
{
    double time = 0.0, rising = 0.0;
    while (has_room_for_extrema(run)) {
        time = next_turn(flight->start, &run->rotor, time, flight->span, &rising, run->stop);
        if (!(time < flight->span))
            return;
        record_extremum(run, run->time + time, (int)rising, fly(flight->start, time, &run->rotor));
        rising = -rising;
    }
}

/* Whether a rate that has the same sign at both ends comes towards 0 between them and goes again:
 * there two extrema may hide. */
static int comes_near(struct turning first, struct turning last)
{
    return first.rate * last.rate > 0.0 && first.rate * first.bend < 0.0
           && last.rate * last.bend > 0.0;
}

/* Of a contact. A step by Taylor series has one at most; one by CVODE is not looked at closer. */
static void find_extremum_of_contact(struct run *run, const struct step *step)
{
    struct motion *motion = step->motion;
    const double rising = motion->before[CONTACT_P];
    if (rising * step->reached[CONTACT_P] >= 0.0)
        return;
    const double point = root_in_step(motion, radial_velocity_of, 0.0, motion->low, step->end);
    if (isnan(point))
        return;
    const double *values = motion->at(motion, point);
    record_extremum(run, run->time + values[CONTACT_T], rising > 0.0 ? 1 : -1,
                    centre_of(motion, values));
}

static void find_extremum_of_step(struct run *run, const struct step *step, double low, double high,
                                  double rising)
{
    struct motion *motion = step->motion;
    if (!has_room_for_extrema(run))
        return;
    const double point = root_in_step(motion, radial_rate_of, 0.0, low, high);
    if (isnan(point))
        return;
    record_extremum(run, run->time + point, rising > 0.0 ? 1 : -1,
                    centre_of(motion, motion->at(motion, point)));
}

static struct turning turning_in_step(const struct run *run, struct motion *motion, double point)
{
    return turning_of(&run->rotor, motion->model.felt, motion->at(motion, point));
}

static void find_extrema_of_step(struct run *run, const struct step *step)
{
    struct motion *motion = step->motion;
    double low = motion->low;
    struct turning before = turning_in_step(run, motion, low);
    for (int look = 1; look <= LOOKS_A_STEP && has_room_for_extrema(run); look++) {
        const double high = motion->low + (step->end - motion->low) * look / LOOKS_A_STEP;
        const struct turning after = turning_in_step(run, motion, high);
        if (before.rate * after.rate < 0.0)
            find_extremum_of_step(run, step, low, high, before.rate);
        if (comes_near(before, after)) {
            double first = low, last = high;
            for (int i = 0; i < MOST_BISECTIONS && last - first > ROUNDING * last; i++) {
                const double middle = 0.5 * (first + last);
                if (turning_in_step(run, motion, middle).bend * before.bend > 0.0)
                    first = middle;
                else
                    last = middle;
            }
            if (radial_rate_of(motion->at(motion, first)) * before.rate < 0.0) {
                find_extremum_of_step(run, step, low, first, before.rate);
                find_extremum_of_step(run, step, first, high, -before.rate);
            }
        }
        low = high;
        before = after;
    }
}

/* ---- All of them ---- */

void observe_flight(struct run *run, const struct flight *flight)
{
    sample_flight(run, flight);
    if (has_room_for_extrema(run))
        find_extrema_of_flight(run, flight);
    if (run->differences > 0)
        carry_over_flight(run, flight);
}

int observe_step(struct run *run, const struct step *step)
{
    sample_step(run, step);
    if (has_room_for_extrema(run)) {
        if (is_contact(step->motion))
            find_extremum_of_contact(run, step);
        else
            find_extrema_of_step(run, step);
    }
    if (run->differences > 0 && step->motion->begins_anew)
        carry_over_step(run, step);
    if (asked_to_stop(run->stop))
        return STOPPED;
    return run->extremum_room > 0 && !has_room_for_extrema(run) ? FULL : DONE;
}
