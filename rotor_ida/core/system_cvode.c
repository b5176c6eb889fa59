/* A rotor system led by CVODE: its interpolant takes the place of the Taylor series of a step.
 *
 * The values are those whose series a step has: displacements, velocities, the time and, under a
 * torque, the angle since the start, the speed, and of the contacts the roots of their indentations
 * and the speeds of their races. Their rates are coefficients 1 of the expansion of system.c, at a
 * pace that is the product of the roots of all that touch, so that they are smooth through entry
 * and exit. Each mode begins with a short step by series: it leaves the zeros of the guards that
 * are known to lie at its beginning. Guards, samples and ledger ask the interpolant as they ask
 * series. */
#include "cvode.h"
#include "system_work.h"

struct system_cvode {
    struct solver solver;
    struct work *work;
    int64_t turn, roots, races; /* where these values begin; -1 where there are none */
    double *atol, *terms, *given;
    double begun, angle, point; /* time and angle of the start; and where the solver stands */
    double goal, reached;       /* towards which it steps; and the time to which it has come */
    int64_t events, piece;      /* of the run, then */
    int degree, is_started, is_singular;
};

/* Orders beyond its degree to which the interpolant is expanded where forces are asked for. */
enum { MORE_ORDERS = 4 };
/* The interpolant of a step has the rates at as many ends of steps as it has degrees: it is read
 * over the last steps, of which each may have so many. */
enum { DEGREES_A_STEP = 2 };
/* The short step by series at the start of a mode, in parts of the one that they would take. */
static const double FIRST = 0.02;
/* The solver looks at its goal only to choose its first step; in units of the scale of time. */
static const double FAR = 1e6;
/* How fast the root of an indentation is drawn to that of the displacement, in parts of the scale
 * of rates: else they drift apart, a tolerance a step. */
static const double DRAWN = 0.1;
/* However slight a touch, it is not asked for fewer parts of the scale of its contact. */
static const double SLIGHTEST = 1e-8;
enum { VALUES_BESIDE = 3, ROWS_BESIDE = 4 };

int64_t core_system_cvode_room(int64_t size, int64_t contacts)
{
    const int64_t values = 2 * (size + contacts) + VALUES_BESIDE;
    return (int64_t)(sizeof(struct system_cvode) / sizeof(double)) + 1
           + (HIGHEST_DEGREE + 1 + ROWS_BESIDE) * values;
}

static int has_race(const struct system_run *run)
{
    int found = 0;
    for (int64_t i = 0; i < run->contact_count; i++)
        found |= run->laws[i].inverse_race_inertia > 0.0;
    return found;
}

/* Take the state of the run from values. */
static void take_values(struct system_cvode *cvode, const double *values)
{
    struct system_run *run = cvode->work->run;
    const struct piece *piece = &run->pieces[run->piece];
    const int64_t n = run->size;
    memcpy(run->state, values, sizeof(double) * (size_t)n);
    memcpy(run->state + run->stride, values + n, sizeof(double) * (size_t)n);
    if (cvode->turn >= 0) {
        run->angle = cvode->angle + values[cvode->turn];
        run->speed = values[cvode->turn + 1];
    } else {
        const double since = cvode->begun + values[2 * n] - run->piece_time;
        run->speed = piece->speed + piece->rate * since;
        run->angle = run->piece_angle + (piece->speed + 0.5 * piece->rate * since) * since;
    }
    for (int64_t i = 0; i < run->contact_count; i++) {
        run->touches[i].root = values[cvode->roots + i];
        if (cvode->races >= 0)
            run->touches[i].race = values[cvode->races + i];
    }
}

/* Begin the terms of the state of the run at the pace of all that touch. */
static void begin_at_pace(struct work *work)
{
    begin_terms(work);
    work->edge_count = 0;
    for (int i = 0; i < (int)work->run->contact_count; i++) {
        work->touching[i].is_edge = is_touching(&work->touching[i])
                                    && !is_spring(&work->touching[i]);
        if (work->touching[i].is_edge)
            work->edges[work->edge_count++] = i;
    }
    work->moves = work->edge_count > 0;
}

/* How fast a root is drawn to that of the displacement. */
static double drawn(const struct work *work, const struct touching *each)
{
    const double *terms = each->series.terms[0];
    const double root = terms[ELEMENT_ROOT], x = terms[ELEMENT_X], y = terms[ELEMENT_Y];
    const double apart = depth_of(each, root) - (sqrt(x * x + y * y) - each->law->clearance);
    const double others = work->edge_count == 1 ? 1.0 : each->others[0];
    const double share = is_spring(each) ? work->pace[0] : 0.5 * others;
    return -DRAWN * work->run->velocity / work->run->displacement * share * apart;
}

static int right_hand_side(double point, void *state, void *rate, void *user)
{
    (void)point;
    struct system_cvode *cvode = user;
    struct work *work = cvode->work;
    const struct system_run *run = work->run;
    const struct sundials *sundials = cvode->solver.sundials;
    const double *values = sundials->vector_data(state);
    double *rates = sundials->vector_data(rate);
    if (values == NULL || rates == NULL)
        return -1;
    take_values(cvode, values);
    begin_at_pace(work);
    expand_system(work, 1);
    cvode->is_singular |= work->is_singular;
    if (work->is_singular)
        return -1;
    memcpy(rates, row_of(work, work->y, 1), sizeof(double) * (size_t)run->size);
    memcpy(rates + run->size, row_of(work, work->v, 1), sizeof(double) * (size_t)run->size);
    rates[2 * run->size] = work->time[1];
    if (cvode->turn >= 0) {
        rates[cvode->turn] = work->turning[0];
        rates[cvode->turn + 1] = work->spin[1];
    }
    for (int64_t i = 0; i < run->contact_count; i++) {
        const struct touching *each = &work->touching[i];
        const double *terms = each->series.terms[1];
        rates[cvode->roots + i] = is_touching(each) ? terms[ELEMENT_ROOT] + drawn(work, each) : 0.0;
        if (cvode->races >= 0)
            rates[cvode->races + i] = each->law->inverse_race_inertia > 0.0 ? terms[ELEMENT_RACE]
                                                                            : 0.0;
    }
    return 0;
}

/* Time and angle since the start have absolute tolerances alone. */
static int weights_of(void *state, void *weights, void *user)
{
    const struct system_cvode *cvode = user;
    const struct sundials *sundials = cvode->solver.sundials;
    const double *values = sundials->vector_data(state);
    double *found = sundials->vector_data(weights);
    if (values == NULL || found == NULL)
        return -1;
    for (int64_t i = 0; i < cvode->solver.size; i++) {
        const int is_absolute = i == 2 * cvode->work->run->size || i == cvode->turn;
        const double of_value = is_absolute ? 0.0 : cvode->work->run->rtol * fabs(values[i]);
        found[i] = 1.0 / (of_value + cvode->atol[i]);
    }
    return 0;
}

/* Write the absolute tolerances of a start: of the sizes to which the values come, so that a slight
 * touch is resolved too. */
static void set_tolerances(struct system_cvode *cvode)
{
    const struct work *work = cvode->work;
    const struct system_run *run = work->run;
    const double rate = run->velocity / run->displacement;
    double *atol = cvode->atol, slightest = 1.0;
    const int64_t n = run->size;
    for (int64_t k = 0; k < n; k++) {
        atol[k] = run->rtol * run->displacement;
        atol[n + k] = run->rtol * run->velocity;
        for (int64_t i = 0; i < run->contact_count && k >= n - run->massless; i++) {
            const double *rows = work->touching[i].rows;
            const double row = fabs(rows[k] + rows[work->stride + k]);
            if (row > 0.0) /* in units of a stator without mass */
                atol[k] = run->rtol * run->laws[i].clearance / row;
        }
    }
    for (int64_t i = 0; i < run->contact_count; i++) {
        const struct touching *each = &work->touching[i];
        const double clearance = each->law->clearance, scale = root_of(each, clearance);
        const double approach = fabs(each->answers[0][ELEMENT_APPROACH]);
        double size = 1.0;
        if (is_touching(each))
            size = fmin(fmax(each->touch->root / scale, approach / (clearance * rate)), 1.0);
        size = fmax(size, SLIGHTEST);
        slightest = fmin(slightest, size);
        atol[cvode->roots + i] = run->rtol * scale * size;
        if (cvode->races >= 0)
            atol[cvode->races + i] = run->rtol * rate;
    }
    atol[2 * n] = run->rtol * slightest / rate;
    if (cvode->turn >= 0) {
        atol[cvode->turn] = run->rtol;
        atol[cvode->turn + 1] = run->rtol * rate;
    }
}

/* Start the solver from the state of the run. */
static int start(struct system_cvode *cvode)
{
    const struct system_run *run = cvode->work->run;
    double *values = cvode->solver.values;
    const int64_t n = run->size;
    memcpy(values, run->state, sizeof(double) * (size_t)n);
    memcpy(values + n, run->state + run->stride, sizeof(double) * (size_t)n);
    cvode->begun = run->time;
    cvode->angle = run->angle;
    cvode->point = values[2 * n] = 0.0;
    if (cvode->turn >= 0) {
        values[cvode->turn] = 0.0;
        values[cvode->turn + 1] = run->speed;
    }
    for (int64_t i = 0; i < run->contact_count; i++) {
        values[cvode->roots + i] = run->touches[i].root;
        if (cvode->races >= 0)
            values[cvode->races + i] = run->touches[i].race;
    }
    set_tolerances(cvode);
    cvode->degree = 0;
    cvode->goal = FAR * run->displacement / run->velocity;
    for (int64_t i = 0; i < run->contact_count; i++) {
        const struct touching *each = &cvode->work->touching[i];
        if (is_touching(each) && !is_spring(each))
            cvode->goal /= sqrt(run->laws[i].clearance);
    }
    return cvode->solver.sundials->reinit(cvode->solver.memory, 0.0, cvode->solver.state);
}

/* Write the terms of the interpolant about the beginning of the step. */
static void shift_terms(struct system_cvode *cvode, double step)
{
    const int64_t size = cvode->solver.size;
    for (int i = 0; i < cvode->degree; i++)
        for (int n = cvode->degree - 1; n >= i; n--)
            for (int64_t k = 0; k < size; k++)
                cvode->terms[n * size + k] -= cvode->terms[(n + 1) * size + k];
    double scale = 1.0;
    for (int n = 1; n <= cvode->degree; n++) {
        scale /= step;
        for (int64_t k = 0; k < size; k++)
            cvode->terms[n * size + k] *= scale;
    }
}

void take_terms(struct work *work, int n)
{
    const struct system_cvode *cvode = work->cvode;
    const struct system_run *run = work->run;
    const double *terms = n > cvode->degree ? cvode->given : &cvode->terms[n * cvode->solver.size];
    const size_t bytes = sizeof(double) * (size_t)run->size;
    memcpy(row_of(work, work->y, n), terms, bytes);
    memcpy(row_of(work, work->v, n), terms + run->size, bytes);
    work->time[n] = terms[2 * run->size] + (n == 0 ? cvode->begun : 0.0);
    if (cvode->turn >= 0)
        work->spin[n] = terms[cvode->turn + 1];
    for (int64_t i = 0; i < run->contact_count; i++) {
        struct touching *each = &work->touching[i];
        if (is_touching(each))
            each->series.terms[n][ELEMENT_ROOT] = terms[cvode->roots + i];
        if (each->law->inverse_race_inertia > 0.0)
            each->series.terms[n][ELEMENT_RACE] = terms[cvode->races + i];
    }
}

/* Take a short step by series, and start the solver behind it. */
static int begin_mode(struct system_cvode *cvode)
{
    struct work *work = cvode->work;
    begin_at_pace(work);
    expand_system(work, work->order);
    choose_step(work);
    work->step *= FIRST;
    cvode->is_started = 0;
    return work->is_singular ? SINGULAR : isnan(work->step) ? NOT_FINITE : DONE;
}

/* Whether a contact has come to its end. */
static int is_behind_exit(const struct system_cvode *cvode)
{
    int found = 0;
    for (int64_t i = 0; i < cvode->work->run->contact_count; i++)
        found |= cvode->solver.values[cvode->roots + i] < 0.0;
    return found;
}

/* Take some steps, and the last interpolant for all of them. */
static int advance(struct system_cvode *cvode)
{
    struct work *work = cvode->work;
    const double low = cvode->point;
    const int together = (int)larger(cvode->degree / DEGREES_A_STEP, 1);
    int status = DONE, count = 0;
    while (status == DONE && count < together && (count == 0 || !is_behind_exit(cvode))) {
        status = step_solver(&cvode->solver, cvode->goal, &cvode->point);
        count++;
    }
    if (status == DONE) {
        work->run->steps += count - 1;
        work->step = cvode->point - low;
        cvode->degree = interpolate(&cvode->solver, cvode->point, work->step, cvode->terms,
                                    cvode->solver.size);
        status = cvode->solver.failure;
    }
    if (status != DONE)
        return cvode->is_singular ? SINGULAR : status;
    shift_terms(cvode, work->step);
    take_values(cvode, cvode->terms);
    begin_at_pace(work);
    work->time[0] = cvode->begun + cvode->terms[2 * work->run->size];
    work->order = (int)smaller(cvode->degree + MORE_ORDERS, (double)work->run->order);
    work->is_led = 1;
    expand_system(work, work->order);
    work->is_led = 0;
    return work->is_singular ? SINGULAR : DONE;
}

int leads(const struct work *work)
{
    int touches = 0;
    for (int64_t i = 0; i < work->run->contact_count; i++)
        touches |= is_touching(&work->touching[i]);
    return work->cvode != NULL && touches;
}

int step_by_cvode(struct work *work)
{
    struct system_cvode *cvode = work->cvode;
    const struct system_run *run = work->run;
    const int goes_on = run->time == cvode->reached && run->events == cvode->events
                        && run->piece == cvode->piece;
    int status = DONE;
    work->order = (int)run->order;
    if (!goes_on)
        status = begin_mode(cvode);
    else {
        if (!cvode->is_started)
            status = start(cvode);
        cvode->is_started = 1;
        if (status == DONE)
            status = advance(cvode);
    }
    cvode->reached = polynomial(work->time, 1, work->order, work->step);
    cvode->events = run->events;
    cvode->piece = run->piece;
    return status;
}

int open_system_cvode(struct work *work)
{
    const struct system_run *run = work->run;
    work->cvode = NULL;
    work->is_led = 0;
    if (run->method == TAYLOR)
        return DONE;
    struct system_cvode *cvode = work->cvode = (struct system_cvode *)(void *)run->cvode_room;
    const int64_t n = run->size, has_torque = run->inertia > 0.0;
    int64_t size = 2 * n + 1;
    *cvode = (struct system_cvode){.work = work, .reached = NAN};
    cvode->turn = has_torque ? size : -1;
    cvode->roots = size + 2 * has_torque;
    size = cvode->roots + run->contact_count;
    cvode->races = has_race(run) ? size : -1;
    size += cvode->races >= 0 ? run->contact_count : 0;
    double *room = (double *)(void *)(cvode + 1);
    cvode->atol = room;
    cvode->given = room + size; /* zeros */
    cvode->terms = room + 4 * size;
    cvode->solver = (struct solver){.sundials = run->sundials,
                                    .size = size,
                                    .values = room + 2 * size,
                                    .derivatives = room + 3 * size};
    for (int64_t i = 0; i < size; i++)
        cvode->atol[i] = 1.0;
    const int status = open_solver(&cvode->solver, (int)run->method, right_hand_side, cvode);
    if (status != DONE)
        return status;
    return run->sundials->weigh_by(cvode->solver.memory, weights_of);
}

void close_system_cvode(struct work *work)
{
    if (work->cvode != NULL)
        close_solver(&work->cvode->solver);
}
