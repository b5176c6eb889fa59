/* The event loop of a rotor system: step, look for what happens first, record it, go on. */
#include "system_work.h"

/* Steps without progress in time after which a run counts as stuck. */
enum { MOST_IDLE = 1000, FORCES_A_CONTACT = 4 };
/* Crossings of a speed that are looked for in one step. */
enum { MOST_CROSSINGS = 100 };

/* The largest displacement, in clearances or, without contacts, in sizes of the motion. */
static const double MOST_CLEARANCES = 1e30;

void record_system_event(struct system_run *run, int kind, int contact)
{
    record_columns(run, contact);
    const int64_t row = run->events++, width = 2 * run->stride + run->contact_count;
    double *state = &run->event_states[row * width];
    run->event_times[row] = run->time;
    run->event_kinds[row] = kind;
    run->event_contacts[row] = contact;
    run->event_rates[row] = INFINITY;
    run->event_turns[2 * row] = run->angle;
    run->event_turns[2 * row + 1] = run->speed;
    memcpy(state, run->state, sizeof(double) * (size_t)(2 * run->stride));
    for (int64_t i = 0; i < run->contact_count; i++)
        state[2 * run->stride + i] = run->touches[i].race;
}

static int has_room_for_step(const struct system_run *run)
{
    return run->events + 2 * run->contact_count + 2 <= run->event_room
           && run->episode_count + run->contact_count <= run->episode_room
           && run->extremum_count + (ORDERS + 1) * run->place_count <= run->extremum_room;
}

/* The point of the step at which a time is reached. */
static double point_of(const struct work *work, double time, double low, double high)
{
    if (!work->moves)
        return fmin(fmax(time - work->time[0], low), high);
    for (int i = 0; i < 100 && high - low > 4e-16 * high; i++) {
        double middle = 0.5 * (low + high);
        if (i % 2 == 0) {
            double value = work->time[work->order], slope = 0.0;
            for (int n = work->order - 1; n >= 0; n--) {
                slope = fma(slope, middle, value);
                value = fma(value, middle, work->time[n]);
            }
            const double newton = middle - (value - time) / slope;
            middle = newton > low && newton < high ? newton : middle;
        }
        if (polynomial(work->time, 1, work->order, middle) < time)
            low = middle;
        else
            high = middle;
    }
    return high;
}

static void sample(struct work *work, double point)
{
    struct system_run *run = work->run;
    double *row = &run->samples[run->sampled * 2 * work->stride];
    read_rows(work, work->y, point, row);
    read_rows(work, work->v, point, row + work->stride);
    double *turn = &run->sample_turns[2 * run->sampled];
    const double time = run->sample_times[run->sampled], since = time - run->piece_time;
    const struct piece *piece = &run->pieces[run->piece];
    turn[1] = work->has_torque ? polynomial(work->spin, 1, work->order, point)
                               : piece->speed + piece->rate * since;
    turn[0] = run->piece_angle + (piece->speed + 0.5 * piece->rate * since) * since;
    if (work->has_torque) {
        double angle = 0.0;
        for (int n = work->order - 1; n >= 0; n--)
            angle = (angle + work->turning[n] / (n + 1)) * point;
        turn[0] = run->angle + angle;
    }
    for (int64_t i = 0; i < run->contact_count; i++) {
        const struct touching *each = &work->touching[i];
        double *forces =
            &run->sample_forces[(run->sampled * run->contact_count + i) * FORCES_A_CONTACT];
        const double *answers = each->answers[0];
        forces[0] = forces[1] = 0.0;
        forces[2] = NAN;
        forces[3] = each->touch->mode;
        if (!is_touching(each))
            continue;
        if (is_centred(each)) {
            sample_centred(work, each, point, forces);
            continue;
        }
        forces[2] = polynomial(&answers[ELEMENT_SLIP], ELEMENT_ANSWERS, work->order, point);
        if (!pushes(each))
            continue;
        forces[0] = polynomial(&answers[ELEMENT_PUSH], ELEMENT_ANSWERS, work->order, point);
        forces[1] = polynomial(each->drag, 1, work->order - 1, point);
    }
    sample_columns(work, point);
    run->sampled++;
}

/* Report the samples of a step up to a point, and up to its time. */
static void observe(struct work *work, double point, double until)
{
    struct system_run *run = work->run;
    double low = 0.0;
    while (run->sampled < run->sample_count && run->sample_times[run->sampled] <= until) {
        low = point_of(work, run->sample_times[run->sampled], low, point);
        sample(work, low);
    }
    if (!run->only_events)
        keep_peaks(work, point, until);
    keep_extrema(work, point, until);
}

/* Write a polynomial in the distance from a point. */
static void begin_at(double point, int order, double *terms)
{
    for (int i = 0; i < order; i++)
        for (int n = order - 1; n >= i; n--)
            terms[n] = fma(point, terms[n + 1], terms[n]);
}

/* Where a speed first leaves its side of a limit; the first term by which it differs from one that
 * it has just crossed is known to be a zero. */
static double first_crossing(const double *spin, int order, double limit, int is_below, int crossed,
                             double step)
{
    double first = INFINITY;
    for (int side = 0; side < 2; side++) {
        const double sign = side ? -1.0 : 1.0;
        const int is_near = sign * spin[0] >= 0.0;
        if (!is_below && !is_near)
            continue;
        double left[ORDERS];
        for (int n = 0; n <= order; n++)
            left[n] = (is_below ? -sign : sign) * spin[n];
        left[0] += is_below ? limit : -limit;
        first = smaller(first, first_fall(left, 1, order, step, is_near && crossed));
    }
    return first;
}

/* Keep since when the speed has stayed below its limit, up to a point and its time. */
static void look_for_standstill(struct work *work, double end, double until)
{
    struct standstill *stands = &work->run->standstill;
    if (!work->has_torque || stands->limit == 0.0)
        return;
    const int order = work->order;
    double spin[ORDERS], at = 0.0;
    memcpy(spin, work->spin, sizeof(double) * (size_t)(order + 1));
    for (int i = 0; i < MOST_CROSSINGS; i++) {
        const int is_below = !isnan(stands->since);
        const double point = first_crossing(spin, order, stands->limit, is_below, i > 0, end - at);
        if (!(at + point < end))
            return;
        at += point;
        begin_at(point, order, spin);
        const double time = smaller(polynomial(work->time, 1, order, at), until);
        if (is_below)
            stands->longest = fmax(stands->longest, time - stands->since);
        stands->since = is_below ? NAN : time;
        stands->rate = polynomial(work->spin_rate, 1, order - 1, at);
    }
}

/* Go on with the next piece of a speed: the rate of the spin jumps, and with it what holds. */
static int pass_system_piece(struct work *work)
{
    struct system_run *run = work->run;
    if (run->piece + 1 >= run->piece_count)
        return DONE;
    run->piece++;
    run->piece_time = run->time;
    run->piece_angle = run->angle;
    begin_system_piece(work);
    return decide_rolling_of_others(work, -1);
}

/* Whether the motion has grown so far that no contact bounds it: its steps, whose errors are
 * measured by the clearance, would become ever shorter. */
static int is_unbounded(const struct system_run *run)
{
    double largest = 0.0;
    for (int64_t i = 0; i < run->size - run->massless; i++)
        largest = fmax(largest, fabs(run->state[i]));
    return largest > MOST_CLEARANCES * run->displacement;
}

/* Write the series of a step, and how long it is. */
static int expand_step(struct work *work)
{
    if (leads(work)) {
        const int status = step_by_cvode(work);
        return status == DONE ? limit_to_knots(work) : status;
    }
    work->order = (int)work->run->order;
    begin_terms(work);
    expand_system(work, work->order);
    if (work->is_singular)
        return SINGULAR;
    choose_step(work);
    return isnan(work->step) ? NOT_FINITE : limit_to_knots(work);
}

static int take_step(struct work *work, int *is_idle)
{
    struct system_run *run = work->run;
    const struct piece *piece = &run->pieces[run->piece];
    const double limit = run->piece + 1 < run->piece_count ? smaller(piece->end, run->duration)
                                                           : run->duration;
    const int status = expand_step(work);
    if (status != DONE)
        return status;
    if (is_unbounded(run))
        return UNBOUNDED;
    double end = work->step;
    int ends = polynomial(work->time, 1, work->order, end) >= limit;
    if (ends)
        end = point_of(work, limit, 0.0, end);
    const struct happening what = first_happening(work, end);
    int happens = what.point <= end;
    end = happens ? what.point : end;
    double until = polynomial(work->time, 1, work->order, end);
    if (happens && until > limit) { /* behind an exit time falls: the limit lies before it */
        ends = 1;
        happens = 0;
        end = point_of(work, limit, 0.0, end);
    }
    until = ends && !happens ? limit : fmax(until, run->time);
    expand_columns(work);
    observe(work, end, until);
    look_for_standstill(work, end, until);
    const double before = run->time;
    move_columns(work, end);
    move_system(work, end);
    run->time = until;
    if (!work->has_torque)
        turn_as_prescribed(run);
    *is_idle = run->time <= before;
    if (happens)
        return change_with_columns(work, what);
    if (work->moves) {
        const int left = leave_together(work);
        if (left != DONE)
            return left;
    }
    return ends && run->time < run->duration ? pass_system_piece(work) : DONE;
}

static void begin_races(struct system_run *run)
{
    for (int64_t i = 0; i < run->contact_count; i++) {
        const struct extreme now = {run->touches[i].race, run->time};
        run->races[i] = (struct race){now, now};
    }
}

static int follow(struct work *work)
{
    struct system_run *run = work->run;
    open_columns(work);
    begin_system_piece(work);
    int status = DONE, idle = 0;
    if (!run->began) {
        if (!has_room_for_step(run))
            return FULL;
        begin_races(run);
        status = begin_contacts(work);
        run->began = 1;
        if (status == DONE)
            begin_columns(work);
    }
    while (status == DONE && run->time < run->duration) {
        int is_idle = 0;
        if (asked_to_stop(run->stop))
            return STOPPED;
        if (!has_room_for_step(run))
            return FULL;
        status = take_step(work, &is_idle);
        idle = is_idle ? idle + 1 : 0;
        if (idle > MOST_IDLE)
            return STUCK;
    }
    return status;
}

int core_system_run(struct system_run *run)
{
    struct work *work = open_work(run);
    int status = open_system_cvode(work);
    if (status == DONE)
        status = follow(work);
    close_system_cvode(work);
    return status;
}
