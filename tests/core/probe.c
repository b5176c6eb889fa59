/* What the tests ask of a motion by Taylor series that the core offers to nobody.
 *
 * It is compiled into a library of its own for each model, with what is derived. A model is given
 * by all parameters of a mode, in their order there. */
#include "taylor.c"

static struct taylor taylor;

/* By number: 0 anywhere, 1 in contact, with friction 2 where it slides and 3 where it rolls. */
static const struct mode *mode_of(int number)
{
    if (number > 1)
        return number > 2 ? &rolling_mode : &rub_mode;
    return number ? &contact_mode : &cartesian_mode;
}

static struct parameters model_of(const double *model)
{
    struct parameters parameters;
    memcpy(&parameters, model, sizeof parameters);
    return parameters;
}

int probe_width(void) { return WIDTH; }
int probe_parameters(void) { return (int)(sizeof(struct parameters) / sizeof(double)); }

int probe_order(double rtol) { return order_for(rtol); }

/* Field, Jacobian by columns, growth, and what parameters add, at a state. */
void probe_values(int mode_number, const double *model, const double *state, double *rate,
                  double *matrix, double growth[4][4], double added[PARAMETERS][4])
{
    const struct mode *mode = mode_of(mode_number);
    const struct parameters parameters = model_of(model);
    mode->field(&parameters, state, rate);
    mode->jacobian(&parameters, state, matrix);
    mode->growth(&parameters, state, growth);
    mode->by_parameters(&parameters, state, added);
}

/* The Taylor series of a state, rows of WIDTH, twice, and of differences, rows of APART. */
void probe_series(int mode_number, const double *model, const double *state, int order,
                  double *terms, double *with_factors, double *apart)
{
    const struct mode *mode = mode_of(mode_number);
    const struct parameters parameters = model_of(model);
    struct series *series = &taylor.series;
    const size_t bytes = sizeof(double) * WIDTH * (size_t)(order + 1);
    memset(series, 0, sizeof *series);
    memcpy(series->terms[0], state, sizeof(double) * (size_t)mode->size);
    mode->expand(&parameters, series, order);
    memcpy(terms, series->terms, bytes);
    mode->expand_with_factors(&parameters, series, order);
    memcpy(with_factors, series->terms, bytes);
    for (int j = 0; j < APART; j++)
        series->apart[0][j] = j % (DIFFERENCES + 1) == 0 ? 1.0 : 0.0;
    mode->expand_differences(&parameters, series, order);
    memcpy(apart, series->apart, sizeof(double) * APART * (size_t)(order + 1));
}

/* Begin a motion; one tolerance serves all. */
int probe_begin(int mode_number, const double *model, double rtol, double atol, int tangents,
                const double *start)
{
    double tolerances[MOST_STATE];
    for (int i = 0; i < MOST_STATE; i++)
        tolerances[i] = atol;
    open_taylor(&taylor, mode_of(mode_number), model_of(model), rtol, tangents);
    return taylor.motion.restart(&taylor.motion, start, tolerances);
}

/* Take a step and write its ends. */
int probe_advance(double ends[2])
{
    const int status = taylor.motion.advance(&taylor.motion);
    ends[0] = taylor.motion.low;
    ends[1] = taylor.motion.point;
    return status;
}

void probe_at(double point, double *values)
{
    memcpy(values, taylor.motion.at(&taylor.motion, point),
           sizeof(double) * (size_t)values_of(&taylor.motion));
}

/* A step of 1, cut so that a polynomial vanishes inside it at most once. */
double probe_cut(const double *terms, double rtol)
{
    open_taylor(&taylor, &contact_mode, (struct parameters){0}, rtol, 0);
    for (int n = 0; n <= taylor.order; n++)
        taylor.series.terms[n][0] = terms[n];
    return with_one_root(&taylor, 0, INFINITY, 1.0);
}
