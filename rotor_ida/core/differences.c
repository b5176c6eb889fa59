/* Differences from a motion, carried along with it; and what the parameters add to it. */
#include "observers.h"

/* The direction of the first axis of the basis in which a motion's differences are read. */
static struct vector basis_of(const struct motion *motion, const double *values)
{
    return is_contact(motion) ? direction_of(values) : (struct vector){1.0, 0.0};
}

static void turn_row(double *row, struct vector by)
{
    for (int i = 0; i < 4; i += 2) {
        const struct vector turned = product((struct vector){row[i], row[i + 1]}, by);
        row[i] = turned.x;
        row[i + 1] = turned.y;
    }
}

static void turn_rows(struct run *run, struct vector by)
{
    for (double *row = run->bundle; row < run->bundle + 4 * run->differences; row += 4)
        turn_row(row, by);
}

/* Move the rows of a bundle over a stretch, of which `apart` is the matrix. */
static void carry(struct run *run, const double *apart)
{
    for (double *row = run->bundle; row < run->bundle + 4 * run->differences; row += 4) {
        double moved[4];
        for (int j = 0; j < 4; j++) {
            const double *line = &apart[DIFFERENCES * j];
            moved[j] = line[0] * row[0] + line[1] * row[1] + line[2] * row[2] + line[3] * row[3];
        }
        memcpy(row, moved, sizeof moved);
    }
}

/* ---- What the parameters add ----
 *
 * With P(t) the derivative of the state at a time t of a stretch by that at its beginning, and b
 * what a parameter adds to the rate of change, it adds P integral of P**-1 b dt. The integrand is
 * known wherever a step is read, and its series converge so far that few points are exact to
 * rounding. */

/* Places and weights of Gauss's quadrature of six points on [0, 1]. */
enum { POINTS = 6 };
static const double PLACES[POINTS] = {0.033765242898423975, 0.16939530676686776, 0.3806904069584015,
                                      0.6193095930415985,   0.8306046932331322,  0.966234757101576};
static const double WEIGHTS[POINTS] = {0.08566224618958525, 0.18038078652406947,
                                       0.23395696728634546, 0.23395696728634546,
                                       0.18038078652406947, 0.08566224618958525};

/* Longest panel of a quadrature over a flight, in parts of the time of its fastest motion. */
static const double PANEL = 0.5;

/* Solve P x = b by elimination; P is near the unit matrix. */
static void solve(const double p[4][4], const double b[4], double x[4])
{
    double rows[4][5];
    for (int i = 0; i < 4; i++) {
        memcpy(rows[i], p[i], sizeof p[i]);
        rows[i][4] = b[i];
    }
    for (int i = 0; i < 4; i++) {
        int best = i;
        for (int k = i + 1; k < 4; k++)
            best = fabs(rows[k][i]) > fabs(rows[best][i]) ? k : best;
        for (int j = i; j < 5; j++) {
            const double kept = rows[i][j];
            rows[i][j] = rows[best][j];
            rows[best][j] = kept;
        }
        for (int k = i + 1; k < 4; k++) {
            const double factor = rows[k][i] / rows[i][i];
            for (int j = i; j < 5; j++)
                rows[k][j] -= factor * rows[i][j];
        }
    }
    for (int i = 3; i >= 0; i--) {
        x[i] = rows[i][4];
        for (int j = i + 1; j < 4; j++)
            x[i] -= rows[i][j] * x[j];
        x[i] /= rows[i][i];
    }
}

/* P**-1 b but for a factor: the flow of the paper's rotor is conformally symplectic, P^T S P =
 * exp(-2 zeta t) S, so that P**-1 = exp(2 zeta t) S**-1 P^T S. */
static void solve_by_symmetry(const double p[4][4], const double b[4], double x[4])
{
    const double turned[4] = {b[2], b[3], -b[0], -b[1]}; /* S b */
    double along[4] = {0.0};
    for (int i = 0; i < 4; i++) {
        for (int j = 0; j < 4; j++)
            along[i] += p[j][i] * turned[j];
    }
    const double back[4] = {-along[2], -along[3], along[0], along[1]};
    memcpy(x, back, sizeof back);
}

/* Add to `drawn`, a row for each parameter, what a point of a quadrature does. */
static void draw_back(const double p[4][4], double added[PARAMETERS][4], double weight,
                      double drawn[PARAMETERS][4])
{
    for (int row = 0; row < PARAMETERS; row++) {
        double x[4];
        if (IS_WHOLE)
            solve(p, added[row], x);
        else
            solve_by_symmetry(p, added[row], x);
        for (int i = 0; i < 4; i++)
            drawn[row][i] += weight * x[i];
    }
}

/* Add to the last rows of a bundle what P makes of `drawn`. */
static void add_rows(struct run *run, const double p[4][4], double drawn[PARAMETERS][4])
{
    for (int row = 0; row < PARAMETERS; row++) {
        double *into = &run->bundle[4 * (DIFFERENCES + row)];
        for (int i = 0; i < 4; i++) {
            double sum = IS_WHOLE ? into[i] : 0.0;
            for (int j = 0; j < 4; j++)
                sum += p[i][j] * drawn[row][j];
            into[i] = IS_WHOLE ? sum : into[i] + sum;
        }
    }
}

/* Add to what omega adds to the rate of change that a load, which stands still, turns faster on
 * axes that do, the more the later: it hangs on the time since the start of the run. */
static void add_turn_of_load(const struct run *run, const struct mode *mode,
                             const struct parameters *model, const double *values, double since,
                             double added[PARAMETERS][4])
{
    const double turn = model->load * (run->time + since);
    if (!HAS_LOAD || turn == 0.0)
        return;
    double turned[MOST_STATE], by_turned[PARAMETERS][4];
    memcpy(turned, values, sizeof(double) * (size_t)mode->size);
    double *down = &turned[mode == &cartesian_mode ? (int)CARTESIAN_DOWN_X : (int)CONTACT_DOWN_R];
    const double along = down[0];
    down[0] = down[1];
    down[1] = -along;
    mode->by_parameters(model, turned, by_turned);
    for (int i = 2; i < 4; i++)
        added[BY_OMEGA][i] += turn * by_turned[BY_LOAD][i];
}

/* Add to the last rows of a bundle what each parameter adds over a step. */
static void add_by_parameters(struct run *run, const struct step *step)
{
    struct motion *motion = step->motion;
    const int size = motion->mode->size, contact = is_contact(motion);
    const double reach = step->end - motion->low;
    double drawn[PARAMETERS][4] = {{0.0}}, p[4][4];
    for (int place = 0; place < POINTS; place++) {
        const double *read = motion->glance_at(motion, motion->low + PLACES[place] * reach);
        const double passed = PLACES[place] * reach;
        const double since = contact ? read[CONTACT_T] : motion->low + passed;
        double weight = WEIGHTS[place] * reach * (contact ? read[CONTACT_Q] : 1.0);
        if (!IS_WHOLE)
            weight *= exp(2.0 * motion->model.zeta
                          * (contact ? since - motion->before[CONTACT_T] : passed));
        double added[PARAMETERS][4];
        motion->mode->by_parameters(&motion->model, read, added);
        add_turn_of_load(run, motion->mode, &motion->model, read, since, added);
        memcpy(p, &read[size], sizeof p);
        draw_back(p, added, weight, drawn);
    }
    memcpy(p, &step->reached[size], sizeof p);
    add_rows(run, p, drawn);
}

/* The same over a flight of the paper's rotor, in closed form; but what delta0 adds, which is
 * nothing. */
static void add_by_parameters_of_flight(struct run *run, const struct flight *flight)
{
    struct motion_of_centre added[2];
    fly_by_parameters(flight->start, flight->span, &run->rotor, added);
    for (int i = 0; i < 2; i++) {
        double *row = &run->bundle[4 * (DIFFERENCES + i)];
        row[0] += added[i].z.x;
        row[1] += added[i].z.y;
        row[2] += added[i].w.x;
        row[3] += added[i].w.y;
    }
}

/* The matrix by which differences grow in a flight. */
static void flown(const struct rotor *rotor, double span, double p[4][4])
{
    double rows[16] = {0.0};
    for (int i = 0; i < 4; i++)
        rows[5 * i] = 1.0;
    fly_differences(rows, 4, span, rotor);
    for (int i = 0; i < 4; i++) {
        for (int j = 0; j < 4; j++)
            p[i][j] = rows[4 * j + i];
    }
}

/* Move a bundle over a flight, with what the parameters add: panel by panel. */
static void carry_by_panels(struct run *run, const struct flight *flight)
{
    const struct rotor *rotor = &run->rotor;
    const double rate = rotor->omega + 2.0 * rotor->zeta + sqrt(rotor->shaft_stiffness);
    const double panels = ceil(larger(flight->span * rate / PANEL, 1.0));
    const double length = flight->span / panels;
    const struct parameters model = parameters_of(rotor, 0.0);
    struct motion_of_centre start = flight->start;
    for (double done = 0.0; done < panels && !asked_to_stop(run->stop); done++) {
        double drawn[PARAMETERS][4] = {{0.0}}, p[4][4];
        for (int place = 0; place < POINTS; place++) {
            const double passed = PLACES[place] * length;
            const struct motion_of_centre there = fly(start, passed, rotor);
            const double state[MOST_STATE] = {there.z.x, there.z.y,    there.w.x,
                                              there.w.y, there.down.x, there.down.y};
            double added[PARAMETERS][4];
            cartesian_mode.by_parameters(&model, state, added);
            add_turn_of_load(run, &cartesian_mode, &model, state, done * length + passed, added);
            flown(rotor, passed, p);
            draw_back(p, added, WEIGHTS[place] * length, drawn);
        }
        flown(rotor, length, p);
        fly_differences(run->bundle, run->differences, length, rotor);
        add_rows(run, p, drawn);
        start = fly(start, length, rotor);
    }
}
/* ---- All of them ---- */

void carry_over_flight(struct run *run, const struct flight *flight)
{
    const int varied = run->differences > DIFFERENCES;
    if (varied && IS_WHOLE) {
        carry_by_panels(run, flight);
        return;
    }
    fly_differences(run->bundle, run->differences, flight->span, &run->rotor);
    if (varied)
        add_by_parameters_of_flight(run, flight);
}

void carry_over_step(struct run *run, const struct step *step)
{
    struct motion *motion = step->motion;
    if (motion->low == 0.0)
        turn_rows(run, mirrored(basis_of(motion, motion->before)));
    carry(run, &step->reached[motion->mode->size]);
    if (run->differences > DIFFERENCES)
        add_by_parameters(run, step);
}

void observe_phase(struct run *run, struct motion *motion, const double *start,
                   const double *reached)
{
    if (run->differences == 0)
        return;
    if (!motion->begins_anew) {
        turn_rows(run, mirrored(basis_of(motion, start)));
        carry(run, &reached[motion->mode->size]);
    }
    turn_rows(run, basis_of(motion, reached));
}

/* The part of its slip speed by which a neighbour's jumps, as friction does: of a neighbour that is
 * a little earlier or later it acts so much longer or shorter. */
static double jump_of_slip(const struct motion *motion, double sense, const double *values)
{
    if (motion->mode == &rolling_mode)
        return -1.0;
    if (sense * motion->model.sigma >= 0.0)
        return 0.0;
    double watched[WATCHED], rates[WATCHED];
    rolling_mode.watched(&motion->model, values, watched, rates);
    return -2.0 * watched[0] / (fabs(watched[1]) + watched[0]);
}

/* The saltation matrix, I + (f+ - f-) grad(v_s)' / (grad(v_s) . f-): the fields before and after
 * differ by the tangential force alone. So all that jumps is the tangential velocity of a
 * neighbour; where the disc rolls, to where it slips no more. A parameter that moves v_s itself
 * adds its own. Leine and Nijmeijer 2004, chapter 7. */
void observe_jump(struct run *run, const struct motion *motion, double sense, const double *values)
{
    if (run->differences == 0)
        return;
    const double part = jump_of_slip(motion, sense, values);
    if (part == 0.0)
        return;
    const double r = radius_in_contact(&motion->model, values);
    turn_rows(run, mirrored(basis_of(motion, values)));
    for (int i = 0; i < run->differences; i++) {
        double *row = &run->bundle[4 * i];
        double slip = row[3] - values[CONTACT_P] * row[1] / r;
        if (i == DIFFERENCES + BY_OMEGA)
            slip += run->rotor.disc_radius;
        if (i == DIFFERENCES + BY_DISC_RADIUS)
            slip += run->rotor.omega;
        row[3] += part * slip;
    }
    turn_rows(run, basis_of(motion, values));
    if (motion->mode == &rolling_mode)
        run->flattened = 1;
    else
        run->volume_lost += log1p(part);
}
