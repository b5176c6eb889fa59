/* CVODE, through the SUNDIALS libraries that scikit-sundae brings; and a motion led by it. */
#ifndef ROTOR_IDA_CVODE_H
#define ROTOR_IDA_CVODE_H

#include "motion.h"

enum { HIGHEST_DEGREE = 12 };

/* A solver of values that its owner keeps, and must not move; and room for a reading. */
struct solver {
    const struct sundials *sundials;
    void *context, *memory, *matrix, *linear, *state, *derivative;
    double *values, *derivatives;
    int64_t size;
    int failure; /* the first flag of a reading that failed, or 0 */
};

/* Make a solver, which must be closed, also where it could not be opened. */
int open_solver(struct solver *solver, int method,
                int (*field)(double point, void *state, void *rate, void *user), void *user);
void close_solver(struct solver *solver);
/* Take one step from a point towards a goal, which is far. */
int step_solver(struct solver *solver, double goal, double *point);
/* Write the interpolant of the last step about its end: its terms by the distance in steps of the
 * length `step`, each `apart` from the next. Return its degree, or -1 where SUNDIALS has none. */
int interpolate(struct solver *solver, double point, double step, double *terms, int64_t apart);

struct cvode {
    struct motion motion;
    struct solver solver;
    void *tolerances;
    double atol[MOST_VALUES], derivatives[MOST_VALUES], reading[MOST_VALUES], rates[MOST_VALUES];
    double series[HIGHEST_DEGREE + 1][MOST_VALUES]; /* of the last step about its end, scaled */
    int degree, readings;
};

/* Make an integration; whoever opens one must close it, also where it could not be opened. */
int open_cvode(struct cvode *cvode, const struct sundials *sundials, int method,
               const struct mode *mode, struct parameters model, double rtol, int tangents);
void close_cvode(struct cvode *cvode);

#endif
