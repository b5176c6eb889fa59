/* CVODE, and a motion led by it: Adams or BDF, Newton's method, a dense linear solver.
 *
 * The functions of SUNDIALS are handed over by Python, which has found and asked the libraries
 * (`rotor_ida.core.sundials`); nothing is linked. Their objects are known by address alone. */
#include "cvode.h"

/* The solver looks at the goal only to choose its first step. */
static const double FAR_GOAL = 1e9;
/* Steps in a row that may end where they began: one does after a reading, the others are too short
 * for the spacing of doubles. */
enum { MOST_IDLE_STEPS = 100, ONE_STEP = 2 };
/* To fetch the interpolant takes as long as so many single readings. */
enum { FEW_READINGS = 6 };

/* ---- A solver ---- */

/* Remember that a reading failed: it ends the run, though its values look like others. */
static int noted(struct solver *solver, int flag)
{
    if (solver->failure == 0)
        solver->failure = flag;
    return flag;
}

/* Make what SUNDIALS needs, in the order in which each needs the ones before. */
int open_solver(struct solver *solver, int method, int (*field)(double, void *, void *, void *),
                void *user)
{
    const struct sundials *sundials = solver->sundials;
    const int64_t size = solver->size;
    if (sundials == NULL)
        return NO_SOLVER;
    if (sundials->context_new(0, &solver->context) != 0 || solver->context == NULL)
        return NO_SOLVER;
    if (sundials->handlers_clear(solver->context) != 0)
        return NO_SOLVER;
    solver->state = sundials->vector_over(size, solver->values, solver->context);
    solver->derivative = sundials->vector_over(size, solver->derivatives, solver->context);
    solver->memory = sundials->create(method, solver->context);
    solver->matrix = sundials->matrix_new(size, size, solver->context);
    if (!solver->state || !solver->derivative || !solver->memory || !solver->matrix)
        return NO_SOLVER;
    solver->linear = sundials->linear_new(solver->state, solver->matrix, solver->context);
    if (!solver->linear || sundials->vector_fuse(solver->state, 1) != 0)
        return NO_SOLVER;
    int status = sundials->init(solver->memory, field, 0.0, solver->state);
    if (status == 0)
        status = sundials->user_data(solver->memory, user);
    if (status == 0)
        status = sundials->linear_use(solver->memory, solver->linear, solver->matrix);
    return status;
}

void close_solver(struct solver *solver)
{
    const struct sundials *sundials = solver->sundials;
    if (solver->memory)
        sundials->free(&solver->memory);
    if (solver->linear)
        sundials->linear_free(solver->linear);
    if (solver->matrix)
        sundials->matrix_free(solver->matrix);
    if (solver->state)
        sundials->vector_free(solver->state);
    if (solver->derivative)
        sundials->vector_free(solver->derivative);
    if (solver->context)
        sundials->context_free(&solver->context);
}

int step_solver(struct solver *solver, double goal, double *point)
{
    if (solver->failure)
        return solver->failure;
    for (int i = 0; i < MOST_IDLE_STEPS; i++) {
        double reached = *point, total = 0.0;
        const int status = solver->sundials->solve(solver->memory, goal, solver->state, &reached,
                                                   ONE_STEP);
        for (int64_t j = 0; j < solver->size; j++)
            total += solver->values[j];
        if (status < 0 || !isfinite(total))
            return status < 0 ? status : NOT_FINITE;
        if (reached > *point) {
            *point = reached;
            return DONE;
        }
    }
    return STUCK;
}

int interpolate(struct solver *solver, double point, double step, double *terms, int64_t apart)
{
    const struct sundials *sundials = solver->sundials;
    int degree = 0;
    double scale = 1.0;
    if (noted(solver, sundials->last_order(solver->memory, &degree)) || degree < 0
        || degree > HIGHEST_DEGREE)
        return -1;
    for (int power = 0; power <= degree; power++) {
        if (noted(solver, sundials->derivative(solver->memory, point, power, solver->derivative)))
            return -1;
        for (int64_t i = 0; i < solver->size; i++)
            terms[power * apart + i] = scale * solver->derivatives[i];
        scale *= step / (power + 1.0);
    }
    return degree;
}

/* ---- A motion ---- */

static struct cvode *cvode_of(struct motion *motion) { return (struct cvode *)motion; }

/* How fast the direction of the load is drawn to where it points, in parts of how fast it turns. */
static const double PULL = 0.1;

static void draw_load(const struct motion *motion, double point, const double *values,
                      double *rates)
{
    if (!HAS_LOAD || motion->model.load == 0.0)
        return;
    const struct vector down = load_of(motion, values, point);
    double turning = speed_of(motion, values);
    int place = CARTESIAN_DOWN_X;
    if (is_contact(motion)) {
        const double radius = radius_in_contact(&motion->model, values);
        turning = fabs(values[CONTACT_Q])
                  * (turning + fabs(momentum_of(motion, values)) / (radius * radius));
        place = CONTACT_DOWN_R;
    }
    rates[place] += PULL * turning * (down.x - values[place]);
    rates[place + 1] += PULL * turning * (down.y - values[place + 1]);
}

static int right_hand_side(double point, void *state, void *rate, void *user)
{
    const struct cvode *cvode = user;
    const struct motion *motion = &cvode->motion;
    const double *values = cvode->solver.sundials->vector_data(state);
    double *rates = cvode->solver.sundials->vector_data(rate);
    if (values == NULL || rates == NULL)
        return -1;
    motion->mode->field(&motion->model, values, rates);
    draw_load(motion, point, values, rates);
    if (!HAS_NEIGHBOURS || !motion->tangents)
        return 0;
    double growth[4][4];
    motion->mode->growth(&motion->model, values, growth);
    const double *apart = values + motion->mode->size;
    double *apart_rates = rates + motion->mode->size;
    for (int i = 0; i < 4; i++) {
        for (int d = 0; d < DIFFERENCES; d++) {
            double sum = 0.0;
            for (int j = 0; j < 4; j++)
                sum += growth[i][j] * apart[DIFFERENCES * j + d];
            apart_rates[DIFFERENCES * i + d] = sum;
        }
    }
    return 0;
}

static int derivative_of_it(double point, void *state, void *rate, void *matrix, void *user,
                            void *a, void *b, void *c)
{
    (void)point, (void)rate, (void)a, (void)b, (void)c;
    const struct cvode *cvode = user;
    const double *values = cvode->solver.sundials->vector_data(state);
    double *entries = cvode->solver.sundials->matrix_data(matrix);
    if (values == NULL || entries == NULL)
        return -1;
    cvode->motion.mode->jacobian(&cvode->motion.model, values, entries);
    return 0;
}

/* So many roundings of a value no tolerance may ask for less than. */
static const double LEAST_ERROR = 16.0 * ROUNDING;

/* With friction not every tolerance is in proportion to a value: see `size_of_slip`. */
static int weights_of(void *state, void *weights, void *user)
{
    const struct cvode *cvode = user;
    const struct motion *motion = &cvode->motion;
    const double *values = cvode->solver.sundials->vector_data(state);
    double *found = cvode->solver.sundials->vector_data(weights);
    if (values == NULL || found == NULL)
        return -1;
    for (int i = 0; i < values_of(motion); i++)
        found[i] = 1.0 / (motion->rtol * fabs(values[i]) + cvode->atol[i]);
    if (motion->mode == &rub_mode) {
        const double slip = motion->rtol * size_of_slip(motion, values, 1.0);
        const double least = LEAST_ERROR * fabs(values[RUB_SLIP]);
        found[RUB_SLIP] = 1.0 / larger(slip + cvode->atol[RUB_SLIP], least);
    }
    return 0;
}

/* Hand the tolerances of a motion over. */
static int set_tolerances(struct cvode *cvode)
{
    const struct sundials *sundials = cvode->solver.sundials;
    if (HAS_FRICTION && cvode->motion.model.friction > 0.0)
        return sundials->weigh_by(cvode->solver.memory, weights_of);
    return sundials->tolerances(cvode->solver.memory, cvode->motion.rtol, cvode->tolerances);
}

/* CVODE keeps the address of the values, so a motion must not move. */
static int restart(struct motion *motion, const double *start, const double *atol)
{
    struct cvode *cvode = cvode_of(motion);
    const size_t bytes = sizeof(double) * (size_t)values_of(motion);
    memcpy(motion->values, start, bytes);
    memcpy(motion->before, start, bytes);
    memcpy(cvode->atol, atol, bytes);
    motion->low = motion->point = 0.0;
    cvode->degree = -1;
    cvode->readings = 0;
    const int status = cvode->solver.sundials->reinit(cvode->solver.memory, 0.0,
                                                      cvode->solver.state);
    if (status != DONE)
        return status;
    return set_tolerances(cvode);
}

static int advance(struct motion *motion)
{
    struct cvode *cvode = cvode_of(motion);
    motion->low = motion->point;
    cvode->degree = -1;
    cvode->readings = 0;
    copy_values(motion, motion->values, motion->before);
    const int status = step_solver(&cvode->solver, FAR_GOAL, &motion->point);
    if (status != DONE)
        copy_values(motion, motion->before, motion->values);
    return status;
}

/* Read the motion; where CVODE cannot, it is as before the step, and the next step says so. */
static const double *at(struct motion *motion, double point)
{
    struct cvode *cvode = cvode_of(motion);
    if (point >= motion->point)
        return motion->values;
    if (point <= motion->low)
        return motion->before;
    struct solver *solver = &cvode->solver;
    if (noted(solver, solver->sundials->derivative(solver->memory, point, 0, solver->derivative)))
        return motion->before;
    return cvode->derivatives;
}

/* Fetch the interpolant of the last step; return whether it could be had. */
static int fetch(struct cvode *cvode)
{
    const struct motion *motion = &cvode->motion;
    cvode->degree = interpolate(&cvode->solver, motion->point, motion->point - motion->low,
                                cvode->series[0], MOST_VALUES);
    return cvode->degree >= 0;
}

static const double *glance_at(struct motion *motion, double point)
{
    struct cvode *cvode = cvode_of(motion);
    if (cvode->degree < 0) {
        const int outside = point >= motion->point || point <= motion->low;
        if (cvode->readings < FEW_READINGS || outside || !fetch(cvode)) {
            cvode->readings++;
            return at(motion, point);
        }
    }
    const double back = (point - motion->point) / (motion->point - motion->low);
    for (int i = 0; i < values_of(motion); i++) {
        double sum = cvode->series[cvode->degree][i];
        for (int power = cvode->degree - 1; power >= 0; power--)
            sum = sum * back + cvode->series[power][i];
        cvode->reading[i] = sum;
    }
    return cvode->reading;
}

static const double *rate(struct motion *motion)
{
    struct cvode *cvode = cvode_of(motion);
    motion->mode->field(&motion->model, motion->before, cvode->rates);
    return cvode->rates;
}

static int64_t evaluations(struct motion *motion)
{
    struct cvode *cvode = cvode_of(motion);
    long count = 0;
    struct solver *solver = &cvode->solver;
    return noted(solver, solver->sundials->evaluations(solver->memory, &count)) ? 0 : count;
}

int open_cvode(struct cvode *cvode, const struct sundials *sundials, int method,
               const struct mode *mode, struct parameters model, double rtol, int tangents)
{
    memset(cvode, 0, sizeof *cvode);
    cvode->motion = (struct motion){.mode = mode,
                                    .model = model,
                                    .rtol = rtol,
                                    .tangents = tangents,
                                    .restart = restart,
                                    .advance = advance,
                                    .at = at,
                                    .glance_at = glance_at,
                                    .rate = rate,
                                    .evaluations = evaluations};
    const int size = values_of(&cvode->motion);
    struct solver *solver = &cvode->solver;
    *solver = (struct solver){.sundials = sundials,
                              .values = cvode->motion.values,
                              .derivatives = cvode->derivatives,
                              .size = size};
    for (int i = 0; i < size; i++) /* nothing that SUNDIALS could refuse before the first start */
        cvode->atol[i] = cvode->motion.values[i] = 1.0;
    int status = open_solver(solver, method, right_hand_side, cvode);
    if (status == 0) {
        cvode->tolerances = sundials->vector_over(size, cvode->atol, solver->context);
        status = cvode->tolerances ? set_tolerances(cvode) : NO_SOLVER;
    }
    if (status == 0 && !tangents)
        status = sundials->jacobian(solver->memory, derivative_of_it);
    return status;
}

void close_cvode(struct cvode *cvode)
{
    if (cvode->tolerances)
        cvode->solver.sundials->vector_free(cvode->tolerances);
    close_solver(&cvode->solver);
}
