/* A phase whose displacement and velocity are integrated as they are: without clearance, and a
 * flight that has no closed form. */
#include "events.h"

/* Add the unit matrix as differences behind the state of a motion, with their tolerances. */
void begin_differences(const struct motion *motion, double *start, double *atol)
{
    for (int j = 0; motion->tangents && j < APART; j++) {
        start[motion->mode->size + j] = j % (DIFFERENCES + 1) == 0 ? 1.0 : 0.0;
        atol[motion->mode->size + j] = motion->rtol;
    }
}

static double radius_of(const double *values) { return sqrt(squared_radius_of(values)); }

/* Points on the way back to the beginning of a step that are tried for one inside the ring. */
enum { MOST_NEARER = 30 };
/* Nearer to the ring, in clearances, rounding decides on which side the rotor is. */
static const double SIDE_ROUNDING = 4.0 * ROUNDING;

/* Where a step that begins on the ring, falls inwards at first and ends outside touches it;
 * infinite where no point inside is seen. */
static double touch_after_fall(struct motion *motion, double delta0, double low, double high)
{
    double inside = 0.5 * (low + high);
    for (int i = 0; i < MOST_NEARER; i++) {
        const double *values = motion->at(motion, inside);
        if (delta0 - radius_of(values) > SIDE_ROUNDING * delta0)
            return root_in_step(motion, radius_of, delta0, inside, high);
        inside = 0.5 * (low + inside);
    }
    return INFINITY;
}

/* Where in the last step the radius first rises through delta0; infinite where it does not.
 *
 * A rise and fall inside the step shows in the radial velocity: it changes from + to - there, and
 * the radius at its root tells. A fall and rise, which is how a step that starts on the ring may
 * look, shows likewise; where rounding hides the fall, the turn itself is the touch. */
static double touch_in_step(struct motion *motion, double delta0)
{
    double low = motion->low, high = motion->point, turn = low;
    const double rising = radial_rate_of(motion->before);
    if (rising * radial_rate_of(motion->values) < 0.0) {
        turn = root_in_step(motion, radial_rate_of, 0.0, low, high);
        if (rising > 0.0)
            high = turn;
        else if (radius_of(motion->at(motion, turn)) < delta0)
            low = turn;
    }
    const double above = radius_of(motion->at(motion, high)) - delta0;
    const int leaves = radial_rate_of(motion->at(motion, high)) > 0.0;
    const int on_ring = fabs(radius_of(motion->before) - delta0) <= SIDE_ROUNDING * delta0;
    if (above <= (on_ring ? SIDE_ROUNDING * delta0 : 0.0))
        return INFINITY;
    if (on_ring && leaves) {
        const double touch = touch_after_fall(motion, delta0, motion->low, high);
        if (touch < INFINITY)
            return touch;
    }
    if (radius_of(motion->at(motion, low)) >= delta0)
        return leaves ? larger(turn, 0.5 * (low + high)) : INFINITY;
    const double touch = root_in_step(motion, radius_of, delta0, low, high);
    if (isnan(touch))
        return touch;
    /* by rounding, or by the tolerances, what falls inwards from the ring is outside at first */
    return radial_rate_of(motion->at(motion, touch)) < 0.0 ? INFINITY : touch;
}

/* Keep the values of largest radius. On a whirl of constant radius the radial velocity is rounding
 * noise; there is nothing to look for. */
static void raise_peak(struct peak *peak, struct motion *motion, double end)
{
    const double *reached = motion->at(motion, end);
    const double rising = radial_rate_of(motion->before);
    const double could_reach = squared_radius_of(motion->before)
                               + 2.0 * rising * (end - motion->low);
    if (rising > 0.0 && 0.0 > radial_rate_of(reached)
        && could_reach > squared_radius_of(peak->values) * (1.0 + LEAST_RISE)) {
        const double summit = root_in_step(motion, radial_rate_of, 0.0, motion->low, end);
        end = summit > motion->low ? summit : end;
        reached = motion->at(motion, end);
    }
    if (radius_of(reached) <= radius_of(peak->values))
        return;
    memcpy(peak->values, reached, sizeof(double) * CARTESIAN_SIZE);
    peak->time = end;
}

/* Integrate until the rotor touches the ring from inside or the run is at its end. */
int follow_freely(struct run *run, struct motion *motion, struct peak *peak, int *touched)
{
    const double duration = phase_left(run);
    const double slack = duration < time_left(run) ? 0.0 : run->slack;
    double start[MOST_VALUES] = {run->state[0], run->state[1], run->state[2], run->state[3]};
    double atol[MOST_VALUES] = {0.0};
    for (int i = 0; i < CARTESIAN_SIZE; i++)
        atol[i] = run->atol;
    if (IS_WHOLE) {
        const struct vector down = motion->down = where_it_is(run).down;
        start[CARTESIAN_DOWN_X] = down.x;
        start[CARTESIAN_DOWN_Y] = down.y;
    }
    if (SPEED_CHANGES) {
        motion->model = parameters_of(&run->rotor, motion->model.felt);
        start[CARTESIAN_SPEED] = run->rotor.omega;
    }
    double reached[MOST_VALUES];
    begin_differences(motion, start, atol);
    memcpy(peak->values, start, sizeof peak->values);
    memcpy(reached, start, sizeof reached);
    peak->time = 0.0;
    double end = 0.0;
    int over = 0, status = motion->restart(motion, start, atol);
    while (status == DONE && !over) {
        status = allow_step(run);
        if (status == DONE)
            status = motion->advance(motion);
        if (status != DONE)
            break;
        const double touch = run->rotor.delta0 > 0.0 ? touch_in_step(motion, run->rotor.delta0)
                                                     : INFINITY;
        if (isnan(touch)) {
            status = NO_ROOT;
            break;
        }
        *touched = touch <= duration + slack;
        end = *touched ? touch : smaller(motion->point, duration);
        raise_peak(peak, motion, end);
        copy_values(motion, motion->at(motion, end), reached);
        status = check_speed(motion, &end, reached);
        if (status != DONE)
            break;
        const struct step step = {motion, end, end, reached};
        status = observe_step(run, &step);
        over = *touched || end >= duration;
    }
    if (status == DONE)
        observe_phase(run, motion, start, reached);
    run->evaluations += motion->evaluations(motion);
    advance_run(run, end, centre_of(motion, reached));
    return status;
}
