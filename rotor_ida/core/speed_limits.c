/* Where a speed that a torque drives leaves what can be followed: it falls below 0, or runs away.
 */
#include "events.h"

/* Looks at a step by CVODE; one by Taylor series is cut so that the speed turns at most once. */
enum { LOOKS_FOR_STALL = 4, MOST_BISECTIONS = 80 };
/* At the very entry of a contact dt/du is 0: the sign of the acceleration is read behind it. */
static const double BEHIND_ENTRY = 1e-9;
/* The largest speed of a rotor, as of a prescribed one. */
static const double LARGEST_SPEED = 1e6;

static double speed_in_contact(const double *values) { return values[CONTACT_SPEED]; }
static double speed_outside(const double *values) { return values[CARTESIAN_SPEED]; }

/* The speed at a point of the step, and its derivative by that of the step. */
static double speed_at(struct motion *motion, double point, double *slope)
{
    double values[MOST_VALUES], rate[MOST_VALUES];
    copy_values(motion, motion->at(motion, point), values);
    if (is_contact(motion))
        values[CONTACT_Q] = larger(values[CONTACT_Q], BEHIND_ENTRY);
    motion->mode->field(&motion->model, values, rate);
    *slope = speed_of(motion, rate);
    return speed_of(motion, values);
}

static int accelerates_at(struct motion *motion, double point)
{
    double slope;
    speed_at(motion, point, &slope);
    return slope > 0.0;
}

/* Whether the speed would stay above 0 if it fell all along a step as steeply as it ever does at
 * the ends and in the middle. */
static int is_far_from_stall(struct motion *motion, double end)
{
    const double points[] = {motion->low, 0.5 * (motion->low + end), end};
    double least = INFINITY, steepest = 0.0;
    for (int i = 0; i < 3; i++) {
        double slope;
        least = smaller(least, speed_at(motion, points[i], &slope));
        steepest = larger(steepest, fabs(slope));
    }
    return least > steepest * (end - motion->low);
}

/* Where between two points the speed turns; the second where it does not. */
static double turn_of_speed(struct motion *motion, double low, double high)
{
    const int rises = accelerates_at(motion, low);
    if (accelerates_at(motion, high) == rises)
        return high;
    for (int i = 0; i < MOST_BISECTIONS && high - low > ROUNDING * high; i++) {
        const double middle = 0.5 * (low + high);
        if (accelerates_at(motion, middle) == rises)
            low = middle;
        else
            high = middle;
    }
    return high;
}

/* Where in the last step, up to `end`, the speed falls below 0; infinite where it does not. */
static double stall_in_step(struct motion *motion, double end)
{
    if (!is_driven(motion) || (!motion->begins_anew && is_far_from_stall(motion, end)))
        return INFINITY;
    const int looks = motion->begins_anew ? 1 : LOOKS_FOR_STALL;
    double (*const speed)(const double *) = is_contact(motion) ? speed_in_contact : speed_outside;
    double low = motion->low;
    for (int look = 1; look <= looks; look++) {
        const double to = look < looks ? motion->low + (end - motion->low) * look / looks : end;
        const double points[] = {turn_of_speed(motion, low, to), to};
        for (int i = 0; i < 2; i++) {
            if (speed(motion->at(motion, points[i])) < 0.0)
                return speed(motion->at(motion, low)) > 0.0
                           ? root_in_step(motion, speed, 0.0, low, points[i])
                           : low;
            low = points[i];
        }
    }
    return INFINITY;
}

int check_speed(struct motion *motion, double *end, double *reached)
{
    const double stall = stall_in_step(motion, *end);
    if (isnan(stall))
        return NO_ROOT;
    if (stall <= *end) {
        *end = stall;
        copy_values(motion, motion->at(motion, stall), reached);
        return STALLED;
    }
    return is_driven(motion) && speed_of(motion, reached) > LARGEST_SPEED ? RUNAWAY : DONE;
}
