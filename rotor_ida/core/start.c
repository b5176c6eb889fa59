/* How a run begins: in contact or in flight, also where the rotor lies exactly on the ring.
 *
 * Displacement and velocity are read on the rotating axes of the moment. */
#include "events.h"

/* A start that is drawn off the ring is followed in closed form to this depth, in clearances. */
static const double FIRST_DEPTH = 1e-16;
/* On a steady whirl rounding alone moves q and p by so much: no step can be asked for less. */
static const double BELOW_ROUNDING = 1e-16;
static const double TIGHTEST_ATOL = 1e-30;
/* What serves a check alone shall ask for no step of its own. */
static const double SPENT_LOOSER = 100.0;

/* The radial velocity; 0 where rounding hides its sign. */
static double radial_velocity(struct motion_of_centre start)
{
    const double along = dot(start.z, start.w) / length(start.z);
    return fabs(along) > 4.0 * ROUNDING * length(start.w) ? along : 0.0;
}

/* The angular acceleration without contact: 0 but where the speed changes. */
static double quickening_of(struct motion_of_centre start, const struct rotor *rotor)
{
    const double left = rotor->torque - rotor->slope * rotor->omega + 2.0 * rotor->zeta * start.w.y
                        + rotor->shaft_stiffness * start.z.y;
    return SPEED_CHANGES ? rotor->rate + rotor->inverse_inertia * left : 0.0;
}

/* The radial acceleration at radial rest, without contact; 0 where rounding hides it. */
static double radial_acceleration(struct motion_of_centre start, const struct rotor *rotor)
{
    const double radius = length(start.z), around = cross(start.z, start.w) / radius;
    const double centrifugal = around * around / radius, unbalance = rotor->omega * rotor->omega;
    double total = centrifugal + unbalance * (start.z.x / radius), size = centrifugal + unbalance;
    if (IS_WHOLE) {
        const double spring = rotor->shaft_stiffness * radius;
        total += rotor->load * dot(start.z, start.down) / radius - spring;
        size += rotor->load + spring;
    }
    const double faster = quickening_of(start, rotor); /* which pulls along -i */
    total -= faster * (start.z.y / radius);
    size += fabs(faster);
    return fabs(total) > 16.0 * ROUNDING * size ? total : 0.0;
}

/* The radial jerk where velocity and acceleration vanish; 0 where rounding hides it. */
static double radial_jerk(struct motion_of_centre start, const struct rotor *rotor)
{
    const double omega = rotor->omega, damping = 2.0 * rotor->zeta, radius = length(start.z);
    struct vector acceleration = {omega * omega - damping * start.w.x, -damping * start.w.y};
    if (IS_WHOLE)
        acceleration = plus(acceleration, plus(scaled(-rotor->shaft_stiffness, start.z),
                                               scaled(rotor->load, start.down)));
    const double faster = quickening_of(start, rotor);
    acceleration.y -= faster;
    struct vector jerk = {-damping * acceleration.x,
                          omega * omega * omega - damping * acceleration.y};
    if (IS_WHOLE)
        jerk = plus(jerk, scaled(-rotor->shaft_stiffness, start.w));
    if (SPEED_CHANGES) {
        /* of (omega**2 - i theta'') exp(i theta); theta'' changes as the reaction does */
        const struct vector turned = plus(acceleration, scaled(-omega, quarter_turned(start.w)));
        const struct vector moved = plus(start.w, scaled(-omega, quarter_turned(start.z)));
        const double jolt = rotor->inverse_inertia
                            * (damping * turned.y + rotor->shaft_stiffness * moved.y
                               - rotor->slope * faster);
        jerk.x += 3.0 * omega * faster;
        jerk.y -= jolt;
    }
    const double by_velocity = 3.0 * dot(start.w, acceleration), by_position = dot(start.z, jerk);
    const double size = 3.0 * length(start.w) * length(acceleration)
                        + length(start.z) * length(jerk);
    const double total = by_velocity + by_position;
    return fabs(total) > 64.0 * ROUNDING * size ? total / radius : 0.0;
}

/* Decide the mode at a start.
 *
 * On the ring the first of radial velocity, acceleration and jerk that is not zero decides:
 * outwards means contact, inwards flight. Where all vanish the rotor whirls along the ring, which
 * is flight. */
enum where decide_mode(struct motion_of_centre start, const struct rotor *rotor)
{
    if (rotor->delta0 == 0.0)
        return IN_CONTACT;
    const double radius = length(start.z);
    if (fabs(radius - rotor->delta0) > 4.0 * ROUNDING * radius)
        return radius > rotor->delta0 ? IN_CONTACT : IN_FLIGHT;
    double rate = radial_velocity(start);
    if (rate == 0.0)
        rate = radial_acceleration(start, rotor);
    if (rate == 0.0)
        rate = radial_jerk(start, rotor);
    return rate > 0.0 ? IN_CONTACT : IN_FLIGHT;
}

static void regularise(struct motion_of_centre start, double root, double *values)
{
    const struct vector direction = scaled(1.0 / length(start.z), start.z);
    values[CONTACT_Q] = root;
    values[CONTACT_P] = dot(start.w, direction);
    values[CONTACT_H] = cross(start.z, start.w);
    values[CONTACT_C] = direction.x;
    values[CONTACT_S] = direction.y;
    values[CONTACT_T] = values[CONTACT_J] = 0.0;
    if (IS_WHOLE) {
        values[CONTACT_DOWN_R] = dot(direction, start.down);
        values[CONTACT_DOWN_T] = cross(direction, start.down);
        values[CONTACT_WORK] = 0.0;
        values[CONTACT_SPENT] = 0.0;
    }
    if (SPEED_CHANGES) {
        values[CONTACT_SPEED] = start.speed;
        values[CONTACT_ANGLE] = start.angle;
    }
}

/* The motion a moment later, in flight: where there is no closed form, by a few terms of its
 * series. */
static struct motion_of_centre fly_shortly(struct motion_of_centre start, double moment,
                                           const struct rotor *rotor)
{
    if (HAS_CLOSED_FLIGHT)
        return fly(start, moment, rotor);
    const struct parameters model = parameters_of(rotor, 0.0);
    struct series series;
    double values[WIDTH];
    memset(&series, 0, sizeof series);
    const double first[] = {start.z.x,    start.z.y,    start.w.x,   start.w.y,
                            start.down.x, start.down.y, start.speed, start.angle};
    memcpy(series.terms[0], first, sizeof first);
    cartesian_mode.expand(&model, &series, LOWEST_ORDER);
    evaluate(series.terms[0], WIDTH, WIDTH, LOWEST_ORDER, moment, 0, values);
    return (struct motion_of_centre){.z = {values[CARTESIAN_X], values[CARTESIAN_Y]},
                                     .w = {values[CARTESIAN_VX], values[CARTESIAN_VY]},
                                     .down = {values[CARTESIAN_DOWN_X], values[CARTESIAN_DOWN_Y]},
                                     .speed = values[CARTESIAN_SPEED],
                                     .angle = values[CARTESIAN_ANGLE]};
}

/* The values a moment after a start at radial rest that is drawn outwards.
 *
 * q = p = 0 is an equilibrium of the regularised equations. The motion leaves it with an
 * indentation that grows like t**2, or t**3 where the radial acceleration vanishes too, unhindered
 * so far by a force of higher order. */
static void push_off(struct motion_of_centre start, double left, const struct rotor *rotor,
                     double *values)
{
    const double acceleration = larger(radial_acceleration(start, rotor), 0.0);
    const double jerk = acceleration == 0.0 ? larger(radial_jerk(start, rotor), 0.0) : 0.0;
    const double depth = FIRST_DEPTH * rotor->delta0;
    double moment = 0.0;
    if (acceleration > 0.0)
        moment = smaller(sqrt(2.0 * depth / acceleration), 1e-3 * left);
    else if (jerk > 0.0)
        moment = smaller(to_power(6.0 * depth / jerk, 1.0 / 3.0), 1e-3 * left);
    const double indentation = (acceleration / 2.0 + jerk * moment / 6.0) * moment * moment;
    regularise(fly_shortly(start, moment, rotor), sqrt(indentation), values);
    values[CONTACT_P] = (acceleration + jerk * moment / 2.0) * moment;
    values[CONTACT_T] = moment;
}

void begin_contact(struct motion_of_centre start, double left, const struct rotor *rotor,
                   double *values)
{
    const double depth = length(start.z) - rotor->delta0;
    const double root = depth > 4.0 * ROUNDING * rotor->delta0 ? sqrt(depth) : 0.0;
    if (root == 0.0 && radial_velocity(start) <= 0.0)
        push_off(start, left, rotor, values);
    else
        regularise(start, root, values);
}

/* Absolute tolerances: the relative one, of the size that each variable comes to.
 *
 * So a very slight touch is still resolved, and a hard one is not asked for digits at entry and
 * exit, where q is 0, that are lost in its course. */
void contact_tolerances(const double *start, double rtol, double absolute, double *atol)
{
    const double q = start[CONTACT_Q], p = start[CONTACT_P], fastest = larger(q, fabs(p));
    /* a contact cannot end sooner than by a straight way out */
    const double least = p < 0.0 && 0.0 < q ? q * q / -p : fastest;
    for (int i = 0; i < CONTACT_SIZE; i++)
        atol[i] = absolute;
    atol[CONTACT_Q] = atol[CONTACT_P] = larger(rtol * fastest, BELOW_ROUNDING);
    atol[CONTACT_T] = atol[CONTACT_J] = larger(rtol * least, TIGHTEST_ATOL);
    if (IS_WHOLE) {
        atol[CONTACT_WORK] = larger(rtol * fastest * fastest, TIGHTEST_ATOL);
        atol[CONTACT_SPENT] = SPENT_LOOSER * atol[CONTACT_WORK];
    }
}
