/* A motion led by CVODE: Adams or BDF, Newton's method, a dense linear solver.
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
    const double *values = cvode->sundials->vector_data(state);
    double *rates = cvode->sundials->vector_data(rate);
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
    const double *values = cvode->sundials->vector_data(state);
    double *entries = cvode->sundials->matrix_data(matrix);
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
    const double *values = cvode->sundials->vector_data(state);
    double *found = cvode->sundials->vector_data(weights);
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
    const struct sundials *sundials = cvode->sundials;
    if (HAS_FRICTION && cvode->motion.model.friction > 0.0)
        return sundials->weigh_by(cvode->memory, weights_of);
    return sundials->tolerances(cvode->memory, cvode->motion.rtol, cvode->tolerances);
}

/* Remember that a reading failed: it ends the run, though its values look like others. */
static int noted(struct cvode *cvode, int flag)
{
    if (cvode->failure == 0)
        cvode->failure = flag;
    return flag;
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
    const int status = cvode->sundials->reinit(cvode->memory, 0.0, cvode->state);
    if (status != DONE)
        return status;
    return set_tolerances(cvode);
}

static int advance(struct motion *motion)
{
    struct cvode *cvode = cvode_of(motion);
    const int count = values_of(motion);
    motion->low = motion->point;
    cvode->degree = -1;
    cvode->readings = 0;
    copy_values(motion, motion->values, motion->before);
    if (cvode->failure)
        return cvode->failure;
    for (int i = 0; i < MOST_IDLE_STEPS; i++) {
        double reached = motion->point;
        const int status = cvode->sundials->solve(cvode->memory, FAR_GOAL, cvode->state, &reached,
                                                  ONE_STEP);
        double total = 0.0;
        for (int j = 0; j < count; j++)
            total += motion->values[j];
        if (status < 0 || !isfinite(total)) {
            copy_values(motion, motion->before, motion->values);
            return status < 0 ? status : NOT_FINITE;
        }
        motion->point = reached;
        if (motion->point > motion->low)
            return DONE;
    }
    return STUCK;
}

/* Read the motion; where CVODE cannot, it is as before the step, and the next step says so. */
static const double *at(struct motion *motion, double point)
{
    struct cvode *cvode = cvode_of(motion);
    if (point >= motion->point)
        return motion->values;
    if (point <= motion->low)
        return motion->before;
    if (noted(cvode, cvode->sundials->derivative(cvode->memory, point, 0, cvode->derivative)))
        return motion->before;
    return cvode->derivatives;
}

/* Fetch the interpolant of the last step; return whether it could be had. */
static int fetch(struct cvode *cvode)
{
    int degree = 0;
    if (noted(cvode, cvode->sundials->last_order(cvode->memory, &degree)) || degree < 0
        || degree > HIGHEST_DEGREE)
        return 0;
    const struct motion *motion = &cvode->motion;
    const double step = motion->point - motion->low;
    double scale = 1.0;
    for (int power = 0; power <= degree; power++) {
        if (noted(cvode, cvode->sundials->derivative(cvode->memory, motion->point, power,
                                                     cvode->derivative)))
            return 0;
        for (int i = 0; i < values_of(motion); i++)
            cvode->series[power][i] = scale * cvode->derivatives[i];
        scale *= step / (power + 1.0);
    }
    cvode->degree = degree;
    return 1;
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
    return noted(cvode, cvode->sundials->evaluations(cvode->memory, &count)) ? 0 : count;
}

/* Make what SUNDIALS needs, in the order in which each needs the ones before. */
static int make(struct cvode *cvode, int method, int64_t size)
{
    const struct sundials *sundials = cvode->sundials;
    struct motion *motion = &cvode->motion;
    if (sundials->context_new(0, &cvode->context) != 0 || cvode->context == NULL)
        return NO_SOLVER;
    if (sundials->handlers_clear(cvode->context) != 0)
        return NO_SOLVER;
    cvode->state = sundials->vector_over(size, motion->values, cvode->context);
    cvode->tolerances = sundials->vector_over(size, cvode->atol, cvode->context);
    cvode->derivative = sundials->vector_over(size, cvode->derivatives, cvode->context);
    cvode->memory = sundials->create(method, cvode->context);
    cvode->matrix = sundials->matrix_new(size, size, cvode->context);
    if (!cvode->state || !cvode->tolerances || !cvode->derivative || !cvode->memory
        || !cvode->matrix)
        return NO_SOLVER;
    cvode->linear = sundials->linear_new(cvode->state, cvode->matrix, cvode->context);
    if (!cvode->linear || sundials->vector_fuse(cvode->state, 1) != 0)
        return NO_SOLVER;
    int status = sundials->init(cvode->memory, right_hand_side, 0.0, cvode->state);
    if (status == 0)
        status = sundials->user_data(cvode->memory, cvode);
    if (status == 0)
        status = set_tolerances(cvode);
    if (status == 0)
        status = sundials->linear_use(cvode->memory, cvode->linear, cvode->matrix);
    if (status == 0 && !motion->tangents)
        status = sundials->jacobian(cvode->memory, derivative_of_it);
    return status;
}

int open_cvode(struct cvode *cvode, const struct sundials *sundials, int method,
               const struct mode *mode, struct parameters model, double rtol, int tangents)
{
    memset(cvode, 0, sizeof *cvode);
    cvode->sundials = sundials;
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
    if (sundials == NULL)
        return NO_SOLVER;
    const int size = values_of(&cvode->motion);
    for (int i = 0; i < size; i++) /* nothing that SUNDIALS could refuse before the first start */
        cvode->atol[i] = cvode->motion.values[i] = 1.0;
    return make(cvode, method, size);
}

void close_cvode(struct cvode *cvode)
{
    const struct sundials *sundials = cvode->sundials;
    if (cvode->memory)
        sundials->free(&cvode->memory);
    if (cvode->linear)
        sundials->linear_free(cvode->linear);
    if (cvode->matrix)
        sundials->matrix_free(cvode->matrix);
    void *vectors[] = {cvode->state, cvode->tolerances, cvode->derivative};
    for (int i = 0; i < 3; i++) {
        if (vectors[i])
            sundials->vector_free(vectors[i]);
    }
    if (cvode->context)
        sundials->context_free(&cvode->context);
}
