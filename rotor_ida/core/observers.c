/* What watches a run: samples, events, extrema of the radius, and differences carried along.
 *
 * Each looks at flights and at steps as the event loop (events.c) comes past them, and does nothing
 * where it was not asked for. */
#include "observers.h"

/* Columns of the table of extrema. */
enum { TIME, RADIUS, KIND, STATE };
/* How closely steps without clearance, and of flights that are integrated, are looked at for
 * extrema. */
enum { LOOKS_A_STEP = 4, MOST_HALVINGS = 80 };

double time_left(const struct run *run) { return run->duration - run->time; }

double phase_left(const struct run *run)
{
#ifdef RUN_UP
    if (run->piece + 1 < run->piece_count)
        return smaller(run->pieces[run->piece].end - run->time, time_left(run));
#endif
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

struct motion_of_centre centre_of(const struct motion *motion, const double *values)
{
    if (!is_contact(motion))
        return (struct motion_of_centre){
            .z = {values[0], values[1]},
            .w = {values[2], values[3]},
#ifdef RUN_UP
            .speed = values[CARTESIAN_SPEED],
            .angle = values[CARTESIAN_ANGLE],
#endif
        };
    const struct vector direction = {values[CONTACT_C], values[CONTACT_S]};
    const struct vector outwards = scaled(1.0 / length(direction), direction);
    const double radius = motion->model.delta0 + values[CONTACT_Q] * values[CONTACT_Q];
    const struct vector velocity = {values[CONTACT_P], momentum_of(motion, values) / radius};
    return (struct motion_of_centre){
        .z = scaled(radius, outwards),
        .w = product(velocity, outwards),
#ifdef RUN_UP
        .speed = values[CONTACT_SPEED],
        .angle = values[CONTACT_ANGLE],
#endif
    };
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
#ifdef RUN_UP
    write_turn(run->event_turns, run->events, run->angle + centre.angle, centre.speed);
#endif
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
#ifdef RUN_UP
    write_turn(run->sample_turns, run->sampled, run->angle + centre.angle, centre.speed);
#endif
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

#ifndef RUN_UP
static void sample_flight(struct run *run, const struct flight *flight)
{
    for (double due; is_due(run, flight->span, flight->span, &due) && !asked_to_stop(run->stop);)
        record_sample(run, fly(flight->start, due, &run->rotor));
}
#endif

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
            record_sample(run, centre_of(motion, motion->glance_at(motion, due)));
        return;
    }
    while (run->sampled < run->sample_count && !asked_to_stop(run->stop)) {
        const double next = run->sample_times[run->sampled];
        const double due = smaller(larger(next - run->time, 0.0), left);
        if (next > run->duration || due > step->until)
            break;
        record_sample(run, centre_of(motion, values_at(step, due)));
    }
}

/* ---- Extrema of the radius ---- */

static void record_extremum(struct run *run, double time, int kind, struct motion_of_centre centre)
{
    double *row = &run->extrema[EXTREMUM_COLUMNS * run->extremum_count];
    row[TIME] = time;
    row[RADIUS] = length(centre.z);
    row[KIND] = kind;
    write_state(&row[STATE], centre);
    run->extremum_count++;
}

static int has_room_for_extrema(const struct run *run)
{
    return run->extremum_count < run->extremum_room;
}

/* r r' and its rate of change. */
struct turning {
    double rate, bend;
};

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

#ifndef RUN_UP
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

#endif

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
            for (int i = 0; i < MOST_HALVINGS && last - first > ROUNDING * last; i++) {
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

/* ---- Differences carried along ---- */

/* The direction of the first axis of the basis in which a motion's differences are read. */
static struct vector basis_of(const struct motion *motion, const double *values)
{
    if (!is_contact(motion))
        return (struct vector){1.0, 0.0};
    const struct vector direction = {values[CONTACT_C], values[CONTACT_S]};
    return scaled(1.0 / length(direction), direction);
}

static void turn_row(double *row, struct vector by)
{
    for (int i = 0; i < 4; i += 2) {
        const struct vector turned = product((struct vector){row[i], row[i + 1]}, by);
        row[i] = turned.x;
        row[i + 1] = turned.y;
    }
}

static void turn_rows(struct run *run, struct vector by)
{
    for (double *row = run->bundle; row < run->bundle + 4 * run->differences; row += 4)
        turn_row(row, by);
}

/* Move the rows of a bundle over a stretch, of which `apart` is the matrix. */
static void carry(struct run *run, const double *apart)
{
    for (double *row = run->bundle; row < run->bundle + 4 * run->differences; row += 4) {
        double moved[4];
        for (int j = 0; j < 4; j++) {
            const double *line = &apart[DIFFERENCES * j];
            moved[j] = line[0] * row[0] + line[1] * row[1] + line[2] * row[2] + line[3] * row[3];
        }
        memcpy(row, moved, sizeof moved);
    }
}

#ifndef RUN_UP
/* Places and weights of Gauss's quadrature of six points on [0, 1]. */
static const double PLACES[] = {0.033765242898423975, 0.16939530676686776, 0.3806904069584015,
                                0.6193095930415985,   0.8306046932331322,  0.966234757101576};
static const double WEIGHTS[] = {0.08566224618958525, 0.18038078652406947, 0.23395696728634546,
                                 0.23395696728634546, 0.18038078652406947, 0.08566224618958525};

#ifndef WHOLE_MODEL
/* Add to the last three rows of a bundle what omega, zeta and delta0 add over a step.
 *
 * With P(t) the derivative of the state at a time t of the step by that at its beginning, and b
 * what a parameter adds to the rate of change, it adds P integral of P**-1 b dt. The flow is
 * conformally symplectic, P^T S P = exp(-2 zeta t) S, so that P**-1 = exp(2 zeta t) S**-1 P^T S.
 * The integrand is known wherever the step is read, and its series converge so far that few points
 * are exact to rounding. */
static void add_by_parameters(struct run *run, const struct step *step)
{
    struct motion *motion = step->motion;
    const int size = motion->mode->size;
    const double reach = step->end - motion->low;
    double drawn[3][4] = {{0.0}};
    for (int place = 0; place < 6; place++) {
        const double *read = motion->glance_at(motion, motion->low + PLACES[place] * reach);
        double passed = PLACES[place] * reach, pace = 1.0, added[3][4];
        if (is_contact(motion)) {
            passed = read[CONTACT_T] - motion->before[CONTACT_T];
            pace = read[CONTACT_Q];
        }
        const double weight = WEIGHTS[place] * reach * pace
                              * exp(2.0 * motion->model.zeta * passed);
        motion->mode->by_parameters(&motion->model, read, added);
        for (int row = 0; row < 3; row++) {
            const double *b = added[row];
            const double turned[4] = {b[2], b[3], -b[0], -b[1]}; /* S b */
            for (int i = 0; i < 4; i++) {
                double along = 0.0;
                for (int j = 0; j < 4; j++)
                    along += read[size + DIFFERENCES * j + i] * turned[j];
                drawn[row][i] += weight * along;
            }
        }
    }
    for (int row = 0; row < 3; row++) {
        const double *d = drawn[row];
        const double back[4] = {-d[2], -d[3], d[0], d[1]}; /* S**-1 d */
        double moved[4];
        for (int j = 0; j < 4; j++) {
            const double *line = &step->reached[size + DIFFERENCES * j];
            moved[j] = line[0] * back[0] + line[1] * back[1] + line[2] * back[2]
                       + line[3] * back[3];
        }
        for (int j = 0; j < 4; j++)
            run->bundle[4 * (DIFFERENCES + row) + j] += moved[j];
    }
}

static void add_by_parameters_of_flight(struct run *run, const struct flight *flight)
{
    struct motion_of_centre added[2];
    fly_by_parameters(flight->start, flight->span, &run->rotor, added);
    for (int i = 0; i < 2; i++) {
        double *row = &run->bundle[4 * (DIFFERENCES + i)];
        row[0] += added[i].z.x;
        row[1] += added[i].z.y;
        row[2] += added[i].w.x;
        row[3] += added[i].w.y;
    }
}
#else
/* Longest panel of a quadrature over a flight, in parts of the time of its fastest motion. */
static const double PANEL = 0.5;

/* Solve P x = b by elimination; P is near the unit matrix. */
static void solve(const double p[4][4], const double b[4], double x[4])
{
    double rows[4][5];
    for (int i = 0; i < 4; i++) {
        memcpy(rows[i], p[i], sizeof p[i]);
        rows[i][4] = b[i];
    }
    for (int i = 0; i < 4; i++) {
        int best = i;
        for (int k = i + 1; k < 4; k++)
            best = fabs(rows[k][i]) > fabs(rows[best][i]) ? k : best;
        for (int j = i; j < 5; j++) {
            const double kept = rows[i][j];
            rows[i][j] = rows[best][j];
            rows[best][j] = kept;
        }
        for (int k = i + 1; k < 4; k++) {
            const double factor = rows[k][i] / rows[i][i];
            for (int j = i; j < 5; j++)
                rows[k][j] -= factor * rows[i][j];
        }
    }
    for (int i = 3; i >= 0; i--) {
        x[i] = rows[i][4];
        for (int j = i + 1; j < 4; j++)
            x[i] -= rows[i][j] * x[j];
        x[i] /= rows[i][i];
    }
}

/* Add to the last rows of a bundle what P makes of `drawn`, a row for each parameter. */
static void add_rows(struct run *run, const double p[4][4], double drawn[PARAMETERS][4])
{
    for (int row = 0; row < PARAMETERS; row++) {
        double *into = &run->bundle[4 * (DIFFERENCES + row)];
        for (int i = 0; i < 4; i++) {
            for (int j = 0; j < 4; j++)
                into[i] += p[i][j] * drawn[row][j];
        }
    }
}

/* Add to what omega adds to the rate of change that a load, which stands still, turns faster on
 * axes that do, the more the later: it hangs on the time since the start of the run. */
static void add_turn_of_load(const struct run *run, const struct mode *mode,
                             const struct parameters *model, const double *values, double since,
                             double added[PARAMETERS][4])
{
    const double turn = model->load * (run->time + since);
    if (turn == 0.0)
        return;
    double turned[MOST_STATE], by_turned[PARAMETERS][4];
    memcpy(turned, values, sizeof(double) * (size_t)mode->size);
    double *down = &turned[mode == &cartesian_mode ? (int)CARTESIAN_DOWN_X : (int)CONTACT_DOWN_R];
    const double along = down[0];
    down[0] = down[1];
    down[1] = -along;
    mode->by_parameters(model, turned, by_turned);
    for (int i = 2; i < 4; i++)
        added[BY_OMEGA][i] += turn * by_turned[BY_LOAD][i];
}

/* Add to the last rows of a bundle what each parameter adds over a step.
 *
 * With P(t) the derivative of the state at a time t of the step by that at its beginning, and b
 * what a parameter adds to the rate of change, it adds P integral of P**-1 b dt. The integrand is
 * known wherever the step is read, and its series converge so far that few points are exact to
 * rounding. */
static void add_by_parameters(struct run *run, const struct step *step)
{
    struct motion *motion = step->motion;
    const int size = motion->mode->size;
    const double reach = step->end - motion->low;
    double drawn[PARAMETERS][4] = {{0.0}}, p[4][4];
    for (int place = 0; place < 6; place++) {
        const double *read = motion->glance_at(motion, motion->low + PLACES[place] * reach);
        const double pace = is_contact(motion) ? read[CONTACT_Q] : 1.0;
        const double since = is_contact(motion) ? read[CONTACT_T]
                                                : motion->low + PLACES[place] * reach;
        double added[PARAMETERS][4], x[4];
        motion->mode->by_parameters(&motion->model, read, added);
        add_turn_of_load(run, motion->mode, &motion->model, read, since, added);
        memcpy(p, &read[size], sizeof p);
        for (int row = 0; row < PARAMETERS; row++) {
            solve(p, added[row], x);
            for (int i = 0; i < 4; i++)
                drawn[row][i] += WEIGHTS[place] * reach * pace * x[i];
        }
    }
    memcpy(p, &step->reached[size], sizeof p);
    add_rows(run, p, drawn);
}

/* The matrix by which differences grow in a flight. */
static void flown(const struct rotor *rotor, double span, double p[4][4])
{
    double rows[16] = {0.0};
    for (int i = 0; i < 4; i++)
        rows[5 * i] = 1.0;
    fly_differences(rows, 4, span, rotor);
    for (int i = 0; i < 4; i++) {
        for (int j = 0; j < 4; j++)
            p[i][j] = rows[4 * j + i];
    }
}

/* Move a bundle over a flight, with what the parameters add: panel by panel. */
static void carry_over_flight(struct run *run, const struct flight *flight)
{
    const struct rotor *rotor = &run->rotor;
    const double rate = rotor->omega + 2.0 * rotor->zeta + sqrt(rotor->shaft_stiffness);
    const double panels = ceil(larger(flight->span * rate / PANEL, 1.0));
    const double length = flight->span / panels;
    const struct parameters model = parameters_of(rotor, 0.0);
    struct motion_of_centre start = flight->start;
    for (double done = 0.0; done < panels && !asked_to_stop(run->stop); done++) {
        double drawn[PARAMETERS][4] = {{0.0}}, p[4][4];
        for (int place = 0; place < 6; place++) {
            const double passed = PLACES[place] * length;
            const struct motion_of_centre there = fly(start, passed, rotor);
            const double state[CARTESIAN_SIZE] = {there.z.x, there.z.y,    there.w.x,
                                                  there.w.y, there.down.x, there.down.y};
            double added[PARAMETERS][4], x[4];
            cartesian_mode.by_parameters(&model, state, added);
            add_turn_of_load(run, &cartesian_mode, &model, state, done * length + passed, added);
            flown(rotor, passed, p);
            for (int row = 0; row < PARAMETERS; row++) {
                solve(p, added[row], x);
                for (int i = 0; i < 4; i++)
                    drawn[row][i] += WEIGHTS[place] * length * x[i];
            }
        }
        flown(rotor, length, p);
        fly_differences(run->bundle, run->differences, length, rotor);
        add_rows(run, p, drawn);
        start = fly(start, length, rotor);
    }
}
#endif

#endif

void observe_phase(struct run *run, struct motion *motion, const double *start,
                   const double *reached)
{
    if (run->differences == 0)
        return;
    if (!motion->begins_anew) {
        turn_rows(run, mirrored(basis_of(motion, start)));
        carry(run, &reached[motion->mode->size]);
    }
    turn_rows(run, basis_of(motion, reached));
}

#ifdef WHOLE_MODEL
/* The part of its slip speed by which a neighbour's jumps, as friction does: of a neighbour that is
 * a little earlier or later it acts so much longer or shorter. */
static double jump_of_slip(const struct motion *motion, double sense, const double *values)
{
    if (motion->mode == &rolling_mode)
        return -1.0;
    if (sense * motion->model.sigma >= 0.0)
        return 0.0;
    double watched[WATCHED], rates[WATCHED];
    rolling_mode.watched(&motion->model, values, watched, rates);
    return -2.0 * watched[0] / (fabs(watched[1]) + watched[0]);
}

/* The saltation matrix, I + (f+ - f-) grad(v_s)' / (grad(v_s) . f-): the fields before and after
 * differ by the tangential force alone. So all that jumps is the tangential velocity of a
 * neighbour; where the disc rolls, to where it slips no more. A parameter that moves v_s itself
 * adds its own. Leine and Nijmeijer 2004, chapter 7. */
void observe_jump(struct run *run, const struct motion *motion, double sense, const double *values)
{
    if (run->differences == 0)
        return;
    const double part = jump_of_slip(motion, sense, values);
    if (part == 0.0)
        return;
    const double r = motion->model.delta0 + values[CONTACT_Q] * values[CONTACT_Q];
    turn_rows(run, mirrored(basis_of(motion, values)));
    for (int i = 0; i < run->differences; i++) {
        double *row = &run->bundle[4 * i];
        double slip = row[3] - values[CONTACT_P] * row[1] / r;
#ifndef RUN_UP
        if (i == DIFFERENCES + BY_OMEGA)
            slip += run->rotor.disc_radius;
        if (i == DIFFERENCES + BY_DISC_RADIUS)
            slip += run->rotor.omega;
#endif
        row[3] += part * slip;
    }
    turn_rows(run, basis_of(motion, values));
    if (motion->mode == &rolling_mode)
        run->flattened = 1;
    else
        run->volume_lost += log1p(part);
}
#endif

/* ---- All of them ---- */

#ifndef RUN_UP
void observe_flight(struct run *run, const struct flight *flight)
{
    sample_flight(run, flight);
    if (has_room_for_extrema(run))
        find_extrema_of_flight(run, flight);
    if (run->differences == 0)
        return;
#ifdef WHOLE_MODEL
    if (run->differences > DIFFERENCES) {
        carry_over_flight(run, flight);
        return;
    }
    fly_differences(run->bundle, run->differences, flight->span, &run->rotor);
#else
    fly_differences(run->bundle, run->differences, flight->span, &run->rotor);
    if (run->differences > DIFFERENCES)
        add_by_parameters_of_flight(run, flight);
#endif
}
#endif

int observe_step(struct run *run, const struct step *step)
{
    sample_step(run, step);
    if (has_room_for_extrema(run)) {
        if (is_contact(step->motion))
            find_extremum_of_contact(run, step);
        else
            find_extrema_of_step(run, step);
    }
    if (run->differences > 0 && step->motion->begins_anew) {
        struct motion *motion = step->motion;
        if (motion->low == 0.0)
            turn_rows(run, mirrored(basis_of(motion, motion->before)));
        carry(run, &step->reached[motion->mode->size]);
#ifndef RUN_UP
        if (run->differences > DIFFERENCES)
            add_by_parameters(run, step);
#endif
    }
    if (asked_to_stop(run->stop))
        return STOPPED;
    return run->extremum_room > 0 && !has_room_for_extrema(run) ? FULL : DONE;
}
