/* A motion led by CVODE, through the SUNDIALS libraries that scikit-sundae brings. */
#ifndef ROTOR_IDA_CVODE_H
#define ROTOR_IDA_CVODE_H

#include "motion.h"

enum { HIGHEST_DEGREE = 12 };

struct cvode {
    struct motion motion;
    const struct sundials *sundials;
    void *context, *memory, *matrix, *linear, *state, *tolerances, *derivative;
    double atol[MOST_VALUES], derivatives[MOST_VALUES], reading[MOST_VALUES], rates[MOST_VALUES];
    double series[HIGHEST_DEGREE + 1][MOST_VALUES]; /* of the last step about its end, scaled */
    int degree, readings;
    int failure; /* the first flag of a reading that failed, or 0 */
};

/* Make an integration; whoever opens one must close it, also where it could not be opened. */
int open_cvode(struct cvode *cvode, const struct sundials *sundials, int method,
               const struct mode *mode, struct parameters model, double rtol, int tangents);
void close_cvode(struct cvode *cvode);

#endif
