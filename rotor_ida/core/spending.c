/* What damping, load and drive take of a contact's energy on the rotating axes, and the heat of
 * sliding: by quadratures over the steps of Taylor series, which have no lanes for them. CVODE
 * integrates both with the motion. The balance of energy over a contact is what they serve.
 *
 * The slip distance is a quadrature whatever leads the motion: its steps do not depend on it. */
#include "motion.h"

/* Places and weights of Gauss's quadrature of eight points on [0, 1], four to a vector. */
static const vec4 PLACES[AT_ONCE] = {
    {0.01985507175123188, 0.10166676129318664, 0.2372337950418355, 0.4082826787521751},
    {0.5917173212478249, 0.7627662049581645, 0.8983332387068134, 0.9801449282487681}};
static const vec4 WEIGHTS[AT_ONCE] = {
    {0.05061426814518813, 0.11119051722668724, 0.15685332293894363, 0.18134189168918100},
    {0.18134189168918100, 0.15685332293894363, 0.11119051722668724, 0.05061426814518813}};

static inline double total_of(vec4 row) { return row[0] + row[1] + row[2] + row[3]; }

/* What a contact spends, by a quadrature over the last step: a lane of its own would cost more. */
void spend(struct motion *motion, double end, double *reached)
{
    if (!IS_WHOLE)
        return;
    const struct parameters *m = &motion->model;
    const struct mode *mode = motion->mode;
    const struct taylor *taylor = taylor_of(motion);
    const double reach = end - motion->low;
    const vec4 parts[AT_ONCE] = {spread(reach) * PLACES[0], spread(reach) * PLACES[1]};
    vec4 rate[AT_ONCE][2], total[2] = {spread(0.0), spread(0.0)};
    if (!SPEED_CHANGES || m->inverse_inertia > 0.0)
        mode->spent(m, &taylor->series, taylor->order, parts, rate);
    else if (is_plain(m)) {
        mode->spent_plain(m, &taylor->series, taylor->order, parts, rate);
        /* there the series has no work, which is what the ring holds */
        reached[CONTACT_WORK] = energy_of_root(m, reached[CONTACT_Q]);
    } else
        mode->spent_prescribed(m, &taylor->series, taylor->order, parts, rate);
    for (int v = 0; v < AT_ONCE; v++) {
        total[0] += WEIGHTS[v] * rate[v][0];
        total[1] += WEIGHTS[v] * rate[v][1];
    }
    reached[CONTACT_SPENT] += reach * total_of(total[0]);
    if (mode == &rub_mode)
        reached[RUB_HEAT] += reach * total_of(total[1]);
}

double slid_in_step(struct motion *motion, double end)
{
    const double sense = motion->model.sigma, reach = end - motion->low;
    if (!is_rubbing(motion) || sense == 0.0)
        return 0.0;
    double distance = 0.0;
    for (int v = 0; v < AT_ONCE; v++)
        for (int i = 0; i < 4; i++) {
            const double *values = motion->glance_at(motion, motion->low + PLACES[v][i] * reach);
            const double speed = values[RUB_SLIP] / radius_in_contact(&motion->model, values);
            distance += WEIGHTS[v][i] * speed * values[CONTACT_Q]; /* dt = q du */
        }
    return larger(sense * reach * distance, 0.0);
}
