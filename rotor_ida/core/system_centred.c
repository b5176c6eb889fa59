/* Contacts without clearance: they never open, and the direction of the force has no limit at the
 * centre. The force is a function of the displacement alone, analytic but by Hertz at the centre.
 *
 * So near to it that the force changes the motion by less than the tolerance of a step, no force is
 * felt. Elsewhere no step passes the centre: where the rotor comes to rest there, its series goes
 * on through it, but as if the force repelled. */
#include "system_work.h"

/* What the velocity of a displacement may be off by where no force is felt, in tolerances. */
static const double UNFELT = 1e-2;
/* A displacement whose velocity is across it, but for this part of its square, whirls. */
static const double OF_WHIRL = 0.2;

/* The radius up to which the force is not felt: the time inside is at most that of a crossing, or
 * the force is small at the rates of the system. */
static double unfelt(const struct work *work, const struct touching *each, double speed)
{
    const struct system_run *run = work->run;
    const double push = each->law->hertz * each->mobility;
    const double allowed = UNFELT * run->rtol * run->velocity * sqrt(each->mobility);
    const double rate = run->velocity / run->displacement;
    return larger(to_power(allowed * speed / push, 0.4),
                  to_power(allowed * rate / push, 2.0 / 3.0));
}

void begin_centred(const struct work *work, struct touching *each)
{
    const double *v = work->run->state + work->stride;
    const double vx = sum_of_products(each->rows, v, work->stride);
    const double vy = sum_of_products(each->rows + work->stride, v, work->stride);
    each->radius = radius_of_touch(work, each);
    each->touch->root = sqrt(each->radius);
    each->inner = each->law->hertz > 0.0 ? unfelt(work, each, sqrt(vx * vx + vy * vy)) : 0.0;
}

int is_linear_here(const struct touching *each, double *stiffness)
{
    *stiffness = element_stiffness(&each->element, 0, 0.0);
    return each->law->hertz == 0.0 || each->radius <= each->inner;
}

void push_centred(struct touching *each, int n)
{
    double stiffness, *answers = each->answers[n];
    const double *given = each->series.terms[n];
    each->drag[n] = 0.0;
    if (is_linear_here(each, &stiffness)) {
        answers[ELEMENT_FORCE_X] = -stiffness * given[ELEMENT_X];
        answers[ELEMENT_FORCE_Y] = -stiffness * given[ELEMENT_Y];
    } else {
        centred_order(&each->element, &each->series, n, answers);
    }
}

double before_centre(const struct work *work, const struct touching *each, double step)
{
    const double *here = each->series.terms[0];
    const double vx = here[ELEMENT_VX], vy = here[ELEMENT_VY];
    const double towards = here[ELEMENT_X] * vx + here[ELEMENT_Y] * vy;
    const double square = each->radius * each->radius * (vx * vx + vy * vy);
    const int is_near = each->radius <= each->inner;
    if (each->law->hertz == 0.0 || (!is_near && towards * towards < OF_WHIRL * square))
        return step;
    const double within = is_near ? each->inner : each->radius;
    for (;; step *= 0.5) {
        double moved = 0.0, power = 1.0;
        for (int n = 1; n <= work->order; n++) {
            const double *terms = each->series.terms[n];
            power *= step;
            moved += (fabs(terms[ELEMENT_X]) + fabs(terms[ELEMENT_Y])) * power;
        }
        if (!(moved > within))
            return step;
    }
}

/* Write what is given to a contact at a point of the step, but for its root. */
static void read_given(const struct work *work, const struct touching *each, double point,
                       double *given)
{
    for (int i = ELEMENT_X; i <= ELEMENT_VY; i++)
        given[i] = polynomial(&each->series.terms[0][i], WIDTH, work->order, point);
}

void sample_centred(const struct work *work, const struct touching *each, double point,
                    double *forces)
{
    double given[ELEMENT_GIVEN] = {0.0}, answers[ELEMENT_ANSWERS];
    read_given(work, each, point, given);
    centred_values(&each->element, given, answers);
    const double x = given[ELEMENT_X], y = given[ELEMENT_Y];
    const double across = x * given[ELEMENT_VY] - y * given[ELEMENT_VX];
    forces[0] = length((struct vector){answers[ELEMENT_FORCE_X], answers[ELEMENT_FORCE_Y]});
    forces[2] = ratio(across, length((struct vector){x, y}));
}

/* Its impulse is not known, as of one disc; its work is that on its spring. */
void keep_centred(struct work *work, const struct touching *each, double point)
{
    double given[ELEMENT_GIVEN] = {0.0};
    struct episode *episode = &work->run->open[each - work->touching];
    read_given(work, each, point, given);
    const double root = sqrt(length((struct vector){given[ELEMENT_X], given[ELEMENT_Y]}));
    const double kept = element_energy(&each->element, 0, root)
                        - element_energy(&each->element, 0, each->touch->root);
    episode->impulse = NAN;
    episode->work += kept;
    work->run->ledger.normal += kept;
}

void write_square(const struct work *work, const struct touching *each, double *square)
{
    const double *x = &each->series.terms[0][ELEMENT_X], *y = &each->series.terms[0][ELEMENT_Y];
    for (int n = 0; n <= work->order; n++)
        square[n] = convolved(x, WIDTH, x, WIDTH, n) + convolved(y, WIDTH, y, WIDTH, n);
}
