/* Many starts followed side by side, each until a region holds it or its time is up.
 *
 * One orbit in each lane, on the rotating axes, with a time and a step of its own. Every quantity
 * is a row of LANES numbers; loops over the lanes have no branches, so that they become vector
 * instructions. A lane whose orbit is decided takes the next start.
 *
 * The method is that of Dormand and Prince of order 8 with the error estimate of DOP853: Hairer,
 * Nørsett and Wanner, Solving Ordinary Differential Equations I, 2nd ed., 1993, section II.5.
 *
 * With friction the disc slides forwards in every lane. An orbit whose slip speed comes near to 0
 * in contact, where it might roll or slide the other way, leaves its lane with a label of its own.
 *
 * A load turns backwards on the rotating axes, on which the motion then depends on time. Its
 * direction is carried beside the state, and a region holds an orbit at whole revolutions alone.
 *
 * What the motion obeys is derived from model/lanes.py: only roots and directions are found here.
 */
#include <math.h>
#include <stdbool.h>
#include <string.h>

#include "core.h"
#include DERIVED_HEADER

/* So many keep the vector units busy while the rows stay in the innermost cache. */
enum { LANES = 64 };
enum { NO_ATTRACTOR = -1, NO_START = -1, MOST_STEPS = 200000 };
/* The label of an orbit that does not slide forwards throughout, as in basins/kernel.py. */
enum { NOT_FORWARDS = -6 };
/* So many steps are allowed, and as many again for each such time that is asked for; but not where
 * that is longer than any motion is followed, as with hardly any damping it may be for ever. */
static const double TIME_OF_STEPS = 5000.0, MOST_TIME = 40000.0;
static const double FIRST_STEP = 0.02, SHRINK = 0.2, GROW = 5.0;
static const float CAUTION = 0.9F;
/* An error below this is not seen of a step over the ring. In the time h after the ring is crossed
 * at a speed v the force puts the velocity off by about v**1.5 h**2.5: the shortest step. A linear
 * contact does so by v h**2, and so does a force that comes to an end inside the contact. */
static const double SEEN = 1e-8, KINK = 2.5, SHARPER_KINK = 2.0, SHORTEST = 0.25;
/* Below this a radius or a depth counts as this; its force is nothing. */
static const double TINY = 1e-30;
static const double HOPELESS = 1e30;
/* The slip speed is seen at the stages of a step, which leave gaps of up to 0.27 of it: a parabola
 * may dip in one by 0.073 of its range below what is seen. It must keep clear of 0 by this part. */
static const double CLEAR = 0.1;
/* A whirl's touches fade if its drift is at most this part of how much too far out it ends. */
static const double MOST_DRIFT = 0.3;
static const double WHOLE_TURN = 6.283185307179586;
/* Under a load no step is longer than this part of a revolution, over which these terms of the
 * series of cosine and sine are exact to rounding. */
static const double LONGEST_TURN = 0.125;
enum { TERMS = 8 };
/* Steps of the classic Runge-Kutta method to a section, halvings of a cubic that find the place of
 * a crossing on a step, and how far outside the set, by the cubic alone, is looked at closely. */
enum { PARTS = 4, HALVINGS = 12 };
static const double ROUGHLY = 3.0;

/* A trapping region: its centre, and from FORM on the upper triangular factor of its form. */
enum { FORM = 4, REGION = 14 };
/* A section: its state c, from NORMAL on its unit normal, from ROWS on the three rows of L, and at
 * REACH the squared distance from c within which the set |L (s - c)| <= 1 lies. */
enum { NORMAL = 4, ROWS = 8, REACH = 20, SECTION = 21 };

/* Weights of the stages, of the step and of its error of order 5, and what the weights of its error
 * of order 3 are less than those of the step. Those that are 0 are left out. */
static const double STAGE_2[] = {0.05260015195876773};
static const double STAGE_3[] = {0.0197250569845379, 0.059175170953613701};
static const double STAGE_4[] = {0.029587585476806851, 0.088762756430420545};
static const double STAGE_5[] = {0.24136513415926669, -0.88454947932828609, 0.92483400326179199};
static const double STAGE_6[] = {0.037037037037037035, 0.17082860872947386, 0.12546768756682242};
static const double STAGE_7[] = {0.037109375, 0.17025221101954405, 0.060216538980455959,
                                 -0.017578125};
static const double STAGE_8[] = {0.037092000118504789, 0.17038392571223998, 0.10726203044637328,
                                 -0.015319437748624402, 0.0082737891638140233};
static const double STAGE_9[] = {0.62411095871607569, -3.3608926294469414, -0.86821934684172597,
                                 27.59209969944671,   20.154067550477894,  -43.489884181069961};
static const double STAGE_10[] = {0.47766253643826434,  -2.4881146199716677, -0.59029082683684297,
                                  21.230051448181193,   15.279233632882423,  -33.288210968984863,
                                  -0.020331201708508627};
static const double STAGE_11[] = {-0.9371424300859873, 5.1863724288440638,  1.0914373489967295,
                                  -8.1497870107469268, -18.520065659996959, 22.739487099350505,
                                  2.4936055526796523,  -3.0467644718982196};
static const double STAGE_12[] = {2.273310147516538,   -10.534495466737249, -2.0008720582248625,
                                  -17.958931863118799, 27.94888452941996,   -2.8589982771350235,
                                  -8.8728569335306293, 12.360567175794303,  0.64339274601576357};
static const double ADVANCE[] = {0.054293734116568765, 4.4503128927524092,  1.8915178993145003,
                                 -5.8012039600105849,  0.3111643669578199,  -0.15216094966251609,
                                 0.20136540080403034,  0.044710615727772587};
static const double FIFTH[] = {0.01312004499419488, -1.2251564463762044,  -0.4957589496572502,
                               1.6643771824549864,  -0.35032884874997366, 0.33417911871301748,
                               0.08192320648511571, -0.022355307863886294};
static const double THIRD[] = {0.24409448818897639, 0.73384668828161181, 0.022058823529411766};

struct state {
    double x, y, u, v;
};

/* Of a load, on the rotating axes. */
struct direction {
    double x, y;
};

struct rows {
    double x[LANES], y[LANES], u[LANES], v[LANES], time[LANES];
    double down_x[LANES], down_y[LANES];
};

struct lanes {
    _Alignas(64) struct rows now;
    struct rows was; /* before the last step */
    double step[LANES];
    double inside[LANES]; /* 1 + the number of the attractor that holds the lane, or 0 */
    double turns[LANES];  /* with friction 1 where the last step does not slide forwards, or 0 */
    int64_t steps[LANES];
    /* under a load: 1 at a whole revolution, else -1; when the next one ends, and its number; and
     * how long a step would be but for that */
    double whole[LANES], due[LANES], revolutions[LANES], wanted[LANES];
};

/* Many starts, with what becomes of them. */
struct starts {
    double *states;
    int16_t *labels;
    float *times;
    int64_t count;
};

/* A call in the loop over the lanes would keep it from becoming vector instructions. */
#define inlined static inline __attribute__((always_inline))

inlined double larger(double a, double b) { return a > b ? a : b; }

inlined double smaller(double a, double b) { return a < b ? a : b; }

inlined struct state state_in(const struct rows *rows, int i)
{
    return (struct state){rows->x[i], rows->y[i], rows->u[i], rows->v[i]};
}

inlined struct state state_of(const double z[4]) { return (struct state){z[0], z[1], z[2], z[3]}; }

inlined struct state minus(struct state a, struct state b)
{
    return (struct state){a.x - b.x, a.y - b.y, a.u - b.u, a.v - b.v};
}

/* a**2 + b**2 */
inlined double squares(double a, double b) { return fma(a, a, b * b); }

/* The scalar product. */
inlined double dot(struct state a, struct state b)
{
    return fma(a.x, b.x, a.y * b.y) + fma(a.u, b.u, a.v * b.v);
}

/* z + h k */
inlined struct state moved(struct state z, double h, struct state k)
{
    return (struct state){fma(h, k.x, z.x), fma(h, k.y, z.y), fma(h, k.u, z.u), fma(h, k.v, z.v)};
}

/* The sum of n states by their weights, unrolled where n is a constant. */
inlined struct state sum(int n, const double *w, const struct state *k)
{
    struct state total = {w[0] * k[0].x, w[0] * k[0].y, w[0] * k[0].u, w[0] * k[0].v};
    for (int j = 1; j < n; j++)
        total = moved(total, w[j], k[j]);
    return total;
}

/* 1/sqrt(value): a root in single precision, polished by one step of Newton's method to a relative
 * error of about 1e-13, in a third of the time of the processor's own double roots. */
inlined double inverse_root(double value)
{
    const double y = (double)(1.0F / sqrtf((float)value));
    return y * (1.5 - 0.5 * (value * y * y));
}

/* What is the same in all lanes, and known before a loop over them begins. */
struct law {
    bool always; /* in contact: without a clearance it takes less arithmetic */
    bool rubs;   /* with friction, sliding forwards */
    bool loaded;
    double release; /* the radial velocity below which contact damping leaves no force */
    struct parameters m;
};

/* With friction the slip speeds that are seen in a step, and the largest squared radius. */
struct slide {
    double lowest, highest, farthest;
};

static struct law law_of(const struct rotor *rotor)
{
    const struct parameters m = parameters_of(rotor, 1.0);
    const bool rubs = HAS_FRICTION && rotor->friction > 0.0;
    const bool loaded = HAS_LOAD && rotor->load > 0.0 && rotor->omega > 0.0;
    const bool always = rotor->delta0 == 0.0 && !rubs && !loaded;
    return (struct law){always, rubs, loaded, release_velocity(&m), m};
}

/* What the motion is given of a state. */
inlined void give(struct state z, struct direction down, struct law law, double given[LANE_GIVEN])
{
    const double square = larger(squares(z.x, z.y), TINY);
    given[LANE_X] = z.x, given[LANE_Y] = z.y, given[LANE_U] = z.u, given[LANE_V] = z.v;
    given[LANE_DOWN_X] = down.x, given[LANE_DOWN_Y] = down.y;
    if (law.always) { /* from the inverse fourth root of r**2 */
        const double rough = (double)(1.0F / sqrtf(sqrtf((float)square)));
        const double y = rough * (1.25 - 0.25 * (square * (rough * rough) * (rough * rough)));
        given[LANE_INVERSE] = y * y, given[LANE_ROOT] = square * y * (y * y);
    } else {
        const double y = inverse_root(square), depth = larger(square * y - law.m.delta0, TINY);
        given[LANE_INVERSE] = y, given[LANE_ROOT] = depth * inverse_root(depth);
    }
}

/* 1 + c d': the part of the contact force that contact damping leaves; where it is negative there
 * is none. */
inlined double damped_part(struct state z, struct law law)
{
    double given[LANE_GIVEN], motion[2];
    give(z, (struct direction){0.0, 0.0}, law, given);
    motion_in_lane(&law.m, given, motion);
    return damping_factor(&law.m, motion[0]);
}

/* See how fast the surfaces slide. */
inlined void see_slide(struct slide *seen, double slip, struct state z)
{
    seen->lowest = smaller(seen->lowest, slip);
    seen->highest = larger(seen->highest, slip);
    seen->farthest = larger(seen->farthest, squares(z.x, z.y));
}

/* The rates of a state under a load with a direction. */
inlined struct state seen_rate(struct state z, struct direction down, struct law law,
                               struct slide *seen)
{
    double given[LANE_GIVEN], motion[2], rates[4];
    give(z, down, law, given);
    motion_in_lane(&law.m, given, motion);
    given[LANE_APPROACH] = larger(motion[0], law.release);
    rates_in_lane(&law.m, given, rates);
    if (HAS_FRICTION && law.rubs)
        see_slide(seen, motion[1], z);
    return state_of(rates);
}

/* Of an orbit that is under no load. */
inlined struct state rate(struct state z, struct law law)
{
    struct slide seen = {0.0, 0.0, 0.0};
    return seen_rate(z, (struct direction){0.0, 0.0}, law, &seen);
}

/* A direction that stands still, once the axes have turned by an angle; by series. */
inlined struct direction turned(struct direction before, double angle)
{
    const double square = angle * angle;
    double sine = 1.0, cosine = 1.0;
    for (int k = TERMS; k > 0; k--) {
        sine = fma(-square * (1.0 / (2.0 * k * (2.0 * k + 1.0))), sine, 1.0);
        cosine = fma(-square * (1.0 / (2.0 * k * (2.0 * k - 1.0))), cosine, 1.0);
    }
    sine *= angle;
    return (struct direction){fma(before.x, cosine, before.y * sine),
                              fma(before.y, cosine, -before.x * sine)};
}

/* The rates at a stage of a step of length h from z on, by weights of the rates of earlier ones.
 * How far on it lies is the sum of the weights. */
inlined struct state stage(int n, const double *w, const struct state *k, struct state z, double h,
                           struct direction down, struct law law, struct slide *seen)
{
    if (HAS_LOAD && law.loaded) {
        double part = w[0];
        for (int j = 1; j < n; j++)
            part += w[j];
        down = turned(down, law.m.omega * h * part);
    }
    return seen_rate(moved(z, h, sum(n, w, k)), down, law, seen);
}

/* How long a step may be to just short of a kink of the force, where it passes one that the
 * shortest step is to cross; HOPELESS elsewhere. */
inlined double up_to_kink(double before, double after, double h, double over)
{
    const double part = larger(h * before / (before - after) - 0.5 * over, 0.9 * over);
    return before * after < 0.0 ? part : HOPELESS;
}

/* The same for the ring and, in contact, for the end of the force: for whichever comes first. */
inlined double up_to_kinks(struct state z, struct state next, struct law law, double h, double over)
{
    const double ring = law.m.delta0 * law.m.delta0;
    const double before = squares(z.x, z.y) - ring, after = squares(next.x, next.y) - ring;
    const double at_ring = up_to_kink(before, after, h, over);
    if (!HAS_CONTACT_DAMPING)
        return at_ring;
    const double loose = up_to_kink(damped_part(z, law), damped_part(next, law), h, over);
    return smaller(at_ring, larger(before, after) > 0.0 ? loose : HOPELESS);
}

/* Try one step in every lane; a step whose error is too large is taken back and made smaller.
 *
 * The error is measured against tolerance sqrt(1 + x**2 + y**2 + u**2 + v**2). It is not seen of a
 * step over the ring, where the force begins as depth**1.5: such a step is taken back until it is
 * so short that the force in it is below the tolerance: `over`. */
inlined void step_all(struct lanes *lanes, struct law law, double tolerance, double over)
{
    struct rows *now = &lanes->now;
    for (int i = 0; i < LANES; i++) {
        const struct state z = state_in(now, i);
        const struct direction down = {now->down_x[i], now->down_y[i]};
        const double h = lanes->step[i];
        struct slide seen = {HOPELESS, -HOPELESS, 0.0};
        const struct state k1 = seen_rate(z, down, law, &seen);
        const struct state k2 = stage(1, STAGE_2, &k1, z, h, down, law, &seen);
        struct state early[3] = {k1, k2};
        const struct state k3 = stage(2, STAGE_3, early, z, h, down, law, &seen);
        early[1] = k3; /* the stages after it know nothing of the second */
        const struct state k4 = stage(2, STAGE_4, early, z, h, down, law, &seen);
        early[2] = k4;
        const struct state k5 = stage(3, STAGE_5, early, z, h, down, law, &seen);
        struct state k[10] = {k1, k4, k5}; /* nor those after it of the third */
        k[3] = stage(3, STAGE_6, k, z, h, down, law, &seen);
        k[4] = stage(4, STAGE_7, k, z, h, down, law, &seen);
        k[5] = stage(5, STAGE_8, k, z, h, down, law, &seen);
        k[6] = stage(6, STAGE_9, k, z, h, down, law, &seen);
        k[7] = stage(7, STAGE_10, k, z, h, down, law, &seen);
        k[8] = stage(8, STAGE_11, k, z, h, down, law, &seen);
        k[9] = stage(9, STAGE_12, k, z, h, down, law, &seen);
        const struct state late[8] = {k1, k[3], k[4], k[5], k[6], k[7], k[8], k[9]};
        const struct state some[3] = {k1, k[6], k[9]};
        const struct state mean = sum(8, ADVANCE, late), next = moved(z, h, mean);
        const struct state fifth = sum(8, FIFTH, late), third = minus(mean, sum(3, THIRD, some));
        const double five = dot(fifth, fifth), three = dot(third, third);
        const double scale = (1.0 + dot(z, z)) * (tolerance * tolerance);
        const double found = h * h * five * five / ((five + 0.01 * three + 1e-300) * scale);
        const double error = found < HOPELESS ? found : HOPELESS; /* also where it overflowed */
        /* the eighth root of the error itself, in single precision: it only chooses the step */
        const float root = sqrtf(sqrtf(sqrtf(sqrtf((float)(error + 1e-30)))));
        const double factor = larger(smaller((double)(CAUTION / root), GROW), SHRINK);
        /* how long a step over a kink is that is good otherwise */
        const double part = up_to_kinks(z, next, law, h, over);
        const double passing = part < HOPELESS && !law.always ? h : 0.0;
        const double crossing = error <= 1.0 ? passing : 0.0;
        const double grade = crossing > over ? HOPELESS : error;
        lanes->step[i] = crossing > over ? part : h * factor;
        now->time[i] += grade <= 1.0 ? h : 0.0;
        now->x[i] = grade <= 1.0 ? next.x : z.x;
        now->y[i] = grade <= 1.0 ? next.y : z.y;
        now->u[i] = grade <= 1.0 ? next.u : z.u;
        now->v[i] = grade <= 1.0 ? next.v : z.v;
        if (HAS_LOAD && law.loaded) {
            const struct direction after = turned(down, law.m.omega * h);
            now->down_x[i] = grade <= 1.0 ? after.x : down.x;
            now->down_y[i] = grade <= 1.0 ? after.y : down.y;
        }
        if (HAS_FRICTION && law.rubs) {
            const double least = CLEAR * (seen.highest - seen.lowest);
            const double turns = seen.lowest <= least ? 1.0 : 0.0;
            const double touching = seen.farthest > law.m.delta0 * law.m.delta0 ? turns : 0.0;
            lanes->turns[i] = grade <= 1.0 ? touching : 0.0;
        }
    }
}

static void step_lanes(struct lanes *lanes, struct law law, double tolerance)
{
    const bool is_sharper = HAS_LINEAR_CONTACT && law.m.linear > 0.0;
    const bool is_damped = HAS_CONTACT_DAMPING && law.m.contact_damping > 0.0;
    const double kink = is_sharper || is_damped ? SHARPER_KINK : KINK;
    const double over = tolerance < SEEN ? SHORTEST * exp(log(tolerance) / kink) : INFINITY;
    /* each a loop of its own */
    if (HAS_LOAD && law.loaded && law.rubs)
        step_all(lanes, (struct law){false, true, true, law.release, law.m}, tolerance, over);
    else if (HAS_LOAD && law.loaded)
        step_all(lanes, (struct law){false, false, true, law.release, law.m}, tolerance, over);
    else if (HAS_FRICTION && law.rubs)
        step_all(lanes, (struct law){false, true, false, law.release, law.m}, tolerance, over);
    else if (law.always)
        step_all(lanes, (struct law){true, false, false, law.release, law.m}, tolerance, over);
    else
        step_all(lanes, (struct law){false, false, false, law.release, law.m}, tolerance, over);
}

/* Under a load find the lanes at whole revolutions, where the axes stand as they did at first. */
static void find_whole_revolutions(struct lanes *lanes, double omega)
{
    for (int i = 0; i < LANES; i++) {
        const bool is_whole = lanes->now.time[i] >= lanes->due[i];
        lanes->whole[i] = is_whole ? 1.0 : -1.0;
        lanes->revolutions[i] += is_whole ? 1.0 : 0.0;
        lanes->due[i] = WHOLE_TURN / omega * lanes->revolutions[i];
        lanes->now.down_x[i] = is_whole ? 0.0 : lanes->now.down_x[i];
        lanes->now.down_y[i] = is_whole ? -1.0 : lanes->now.down_y[i];
        lanes->step[i] = is_whole ? larger(lanes->step[i], lanes->wanted[i]) : lanes->step[i];
    }
}

/* Write the code of a trapping region into `inside` where it holds the lane, under a load at whole
 * revolutions. */
static void find_trapped(struct lanes *lanes, const double region[REGION], bool loaded, double code)
{
    const struct state centre = state_of(region);
    const double *f = region + FORM;
    for (int i = 0; i < LANES; i++) {
        const struct state z = minus(state_in(&lanes->now, i), centre);
        const struct state form = {
            dot(state_of(f), z),
            fma(f[4], z.y, fma(f[5], z.u, f[6] * z.v)),
            fma(f[7], z.u, f[8] * z.v),
            f[9] * z.v,
        };
        const double limit = loaded ? lanes->whole[i] : 1.0;
        lanes->inside[i] = dot(form, form) <= limit ? code : lanes->inside[i];
    }
}

/* Write the code into `inside` where an orbit will never touch the ring again.
 *
 * Out of contact the centre of the whirl moves straight from c to c + drift; the orbit stays
 * inside the clearance exactly when both ends do with the whirl's own radius to spare. Where it
 * comes to rest but a little too far out, its touches fade: code + 1. */
static void find_contact_free(struct lanes *lanes, struct rotor rotor, const double whirl[4],
                              double code)
{
    const double wx = whirl[0], wy = whirl[1], room = whirl[2], edge = whirl[3];
    const double omega = rotor.omega, per = 0.5 / rotor.zeta, ring = rotor.delta0 * rotor.delta0;
    const double most_drift = 0.5 * MOST_DRIFT / sqrt(room);
    for (int i = 0; i < LANES; i++) {
        /* on the rotating axes the whirl stands still at w and its velocity is i omega w */
        const struct state z = state_in(&lanes->now, i);
        const double x = z.x - wx, y = z.y - wy;
        const double u = x + per * (z.u + omega * wy), v = y + per * (z.v - omega * wx);
        const double end = squares(u, v), farthest = larger(squares(x, y), end);
        const double outside = most_drift * larger(end - room, 0.0);
        const bool slow = squares(u - x, v - y) < outside * outside;
        const bool fades = (end <= edge) & slow & (squares(z.x, z.y) < ring);
        const double inside = fades ? code + 1.0 : lanes->inside[i];
        lanes->inside[i] = farthest <= room ? code : inside;
    }
}

/* Write the code into `inside` where an orbit that a shaft draws back will never touch the ring
 * again.
 *
 * Out of contact the distance xi to the whirl dies out. The energy |xi'|**2 + kappa |xi|**2 only
 * falls: that bounds it. With much damping xi is a sum of two motions that die out without turning,
 * and lies between 0, where it is, and what the slow one is: that bounds it as well. A load moves
 * the centre of the whirl down. */
static void find_held_by_shaft(struct lanes *lanes, struct rotor rotor, bool loaded,
                               const double whirl[4], double code)
{
    const double wx = whirl[0], wy = whirl[1], room = whirl[2];
    const double omega = rotor.omega, kappa = rotor.shaft_stiffness;
    const double square = fma(rotor.zeta, rotor.zeta, -kappa), root = sqrt(larger(square, 0.0));
    const double fast = rotor.zeta + root, per = square > 0.0 ? 0.5 / root : INFINITY;
    const double sag = loaded ? rotor.load / kappa : 0.0;
    for (int i = 0; i < LANES; i++) {
        const struct state z = state_in(&lanes->now, i);
        const double x = z.x - fma(sag, lanes->now.down_x[i], wx);
        const double y = z.y - fma(sag, lanes->now.down_y[i], wy);
        const double u = fma(omega, wy, z.u), v = fma(-omega, wx, z.v);
        const double now = squares(x, y), energy = fma(kappa, now, squares(u, v));
        const double slow = squares(per * fma(fast, x, u), per * fma(fast, y, v));
        const bool bounded = (larger(now, slow) <= room) | (energy <= kappa * room);
        lanes->inside[i] = bounded ? code : lanes->inside[i];
    }
}

/* Find the lanes that passed a section in the last step, the way its cycle does, close by; return
 * whether there is one. */
static bool find_crossings(const struct lanes *lanes, const double section[SECTION],
                           int64_t passed[LANES])
{
    const struct state centre = state_of(section), normal = state_of(section + NORMAL);
    int64_t any = 0;
    for (int i = 0; i < LANES; i++) {
        const struct state z = state_in(&lanes->now, i), from = minus(z, centre);
        const struct state step = minus(z, state_in(&lanes->was, i));
        const double after = dot(normal, from), before = after - dot(normal, step);
        const double room = 2.0 * (section[REACH] + dot(step, step)) - dot(from, from);
        const int64_t through = before < 0.0 ? after >= 0.0 : 0;
        passed[i] = room >= 0.0 ? through : 0;
        any |= passed[i];
    }
    return any != 0;
}

/* The state at a part of a step, by the cubic through both ends with their rates. */
static struct state between(struct state was, struct state now, struct state first,
                            struct state last, double h, double part)
{
    const double rest = 1.0 - part, slope = h * part * rest;
    const double w[] = {rest * rest * (1.0 + 2.0 * part), part * part * (1.0 + 2.0 * rest),
                        slope * rest, -slope * part};
    return sum(4, w, (struct state[]){was, now, first, last});
}

/* How far a state is beyond a section. */
static double height(struct state z, const double section[SECTION])
{
    return dot(state_of(section + NORMAL), minus(z, state_of(section)));
}

/* |L (s - c)|**2 of the state on the section that a state close to it flows to. */
static double size_on_section(struct state z, const double section[SECTION], struct law law)
{
    const struct state k = rate(z, law);
    const double shift = height(z, section) / dot(state_of(section + NORMAL), k);
    const struct state from = minus(moved(z, -shift, k), state_of(section));
    const double a = dot(state_of(section + ROWS), from);
    const double b = dot(state_of(section + ROWS + 4), from);
    const double c = dot(state_of(section + ROWS + 8), from);
    return squares(a, b) + c * c;
}

/* The state a time h later, by the classic Runge-Kutta method. */
static struct state classic_step(struct state z, double h, struct law law)
{
    const struct state k1 = rate(z, law);
    const struct state k2 = rate(moved(z, 0.5 * h, k1), law);
    const struct state k3 = rate(moved(z, 0.5 * h, k2), law);
    const struct state k4 = rate(moved(z, h, k3), law);
    static const double weights[] = {1.0, 2.0, 2.0, 1.0};
    return moved(z, h / 6.0, sum(4, weights, (struct state[]){k1, k2, k3, k4}));
}

/* |L (s - c)|**2 where the last step in a lane passed the section. */
static double section_value(const struct lanes *lanes, int i, const double section[SECTION],
                            struct law law)
{
    const struct state was = state_in(&lanes->was, i), now = state_in(&lanes->now, i);
    const struct state first = rate(was, law), last = rate(now, law);
    const double h = lanes->now.time[i] - lanes->was.time[i];
    double low = 0.0, high = 1.0;
    for (int halving = 0; halving < HALVINGS; halving++) {
        const double middle = 0.5 * (low + high);
        if (height(between(was, now, first, last, h, middle), section) < 0.0)
            low = middle;
        else
            high = middle;
    }
    struct state z = between(was, now, first, last, h, high);
    const double roughly = size_on_section(z, section, law);
    if (roughly > ROUGHLY)
        return roughly;
    z = was;
    for (int part = 0; part < PARTS; part++)
        z = classic_step(z, h * high / (double)PARTS, law);
    return size_on_section(z, section, law);
}

/* Write the code of a limit cycle into `inside` where it holds the lane. */
static void find_on_cycle(struct lanes *lanes, struct law law, const double section[SECTION],
                          double code)
{
    int64_t passed[LANES];
    if (!find_crossings(lanes, section, passed))
        return;
    for (int i = 0; i < LANES; i++)
        if (passed[i] && section_value(lanes, i, section, law) <= 1.0)
            lanes->inside[i] = code;
}

/* Count a step of each lane and find those that are decided, or whose time or number of steps is
 * up; return whether there is one. Under a load the latter cannot be followed further, as they do
 * not stop at a whole revolution. */
static bool find_ended(struct lanes *lanes, bool loaded, double duration, int64_t ended[LANES])
{
    const double most_time = duration <= MOST_TIME ? duration : 0.0;
    const double most_steps = MOST_STEPS * (1.0 + most_time / TIME_OF_STEPS);
    int64_t any = 0;
    for (int i = 0; i < LANES; i++) {
        lanes->steps[i]++;
        const int64_t late = (double)lanes->steps[i] >= most_steps;
        lanes->turns[i] = loaded && late ? 1.0 : lanes->turns[i];
        const bool decided = (lanes->inside[i] > 0.0) | (lanes->turns[i] > 0.0);
        const int64_t held = decided ? 1 : late;
        ended[i] = lanes->now.time[i] < duration ? held : 1;
        any |= ended[i];
    }
    return any != 0;
}

/* The first start from `number` on that has no label yet, or their count. */
static int64_t next_waiting(const struct starts *starts, int64_t number)
{
    while (number < starts->count && starts->labels[number] >= 0)
        number++;
    return number;
}

static void load_state(struct lanes *lanes, int i, struct state z, double step)
{
    lanes->now.x[i] = z.x, lanes->now.y[i] = z.y, lanes->now.u[i] = z.u, lanes->now.v[i] = z.v;
    lanes->now.time[i] = 0.0, lanes->step[i] = step, lanes->steps[i] = 0;
    lanes->turns[i] = 0.0;
    lanes->due[i] = 0.0, lanes->revolutions[i] = 0.0, lanes->wanted[i] = step;
    lanes->now.down_x[i] = 0.0, lanes->now.down_y[i] = -1.0;
}

/* One of `count` states that are kept as four rows. */
static struct state state_at(const double *states, int64_t count, int64_t number)
{
    const double *x = states + number;
    return (struct state){x[0], x[count], x[2 * count], x[3 * count]};
}

/* Let no step pass the end of the time: orbits are left at the same moment. Nor, under a load, that
 * of a revolution. */
static void end_in_time(struct lanes *lanes, struct law law, double duration)
{
    const double longest = law.loaded ? LONGEST_TURN * WHOLE_TURN / law.m.omega : INFINITY;
    for (int i = 0; i < LANES; i++) {
        const double end = law.loaded ? smaller(lanes->due[i], duration) : duration;
        lanes->wanted[i] = lanes->step[i];
        lanes->step[i] = smaller(smaller(lanes->step[i], longest), end - lanes->now.time[i]);
    }
}

/* Put a start into a lane and return its number; without one, leave the lane at rest. */
static int64_t load_start(struct lanes *lanes, int i, const struct starts *starts, int64_t number)
{
    if (number >= starts->count) {
        load_state(lanes, i, (struct state){0.0, 0.0, 0.0, 0.0}, 0.0);
        return NO_START;
    }
    load_state(lanes, i, state_at(starts->states, starts->count, number), FIRST_STEP);
    return number;
}

/* Copy the result of a start from its lane. */
static void record_result(const struct lanes *lanes, int i, const struct starts *starts,
                          int64_t number)
{
    const int code = (int)lanes->inside[i];
    const int label = code > 0 ? code - 1 : NO_ATTRACTOR;
    starts->labels[number] = (int16_t)(lanes->turns[i] > 0.0 ? NOT_FORWARDS : label);
    starts->times[number] += (float)lanes->now.time[i];
    double *x = starts->states + number;
    x[0] = lanes->now.x[i];
    x[starts->count] = lanes->now.y[i];
    x[2 * starts->count] = lanes->now.u[i];
    x[3 * starts->count] = lanes->now.v[i];
}

/* Read from memory each time: another thread writes it. */
int core_follow_lanes(const struct rotor *rotor, double *states, int16_t *labels, float *times,
                      int64_t count, const double *regions, int64_t region_count,
                      const double free_whirl[4], const double *sections, int64_t section_count,
                      double duration, double tolerance, const stop_flag *stop)
{
    const struct starts starts = {states, labels, times, count};
    const struct law law = law_of(rotor);
    const double first_code = (double)(region_count + 1); /* of those that follow the regions */
    struct lanes lanes = {0};
    int64_t owner[LANES], ended[LANES], waiting = 0, active = 0;
    for (int i = 0; i < LANES; i++) {
        waiting = next_waiting(&starts, waiting);
        owner[i] = load_start(&lanes, i, &starts, waiting++);
        active += owner[i] != NO_START;
    }
    lanes.was = lanes.now;
    while (active > 0) {
        if (asked_to_stop(stop))
            return STOPPED;
        memset(lanes.inside, 0, sizeof lanes.inside);
        if (HAS_LOAD && law.loaded)
            find_whole_revolutions(&lanes, rotor->omega);
        for (int64_t j = 0; j < region_count; j++)
            find_trapped(&lanes, regions + REGION * j, law.loaded, (double)(j + 1));
        if (free_whirl[2] >= 0.0 && IS_WHOLE && rotor->shaft_stiffness > 0.0)
            find_held_by_shaft(&lanes, *rotor, law.loaded, free_whirl, first_code);
        else if (free_whirl[2] >= 0.0)
            find_contact_free(&lanes, *rotor, free_whirl, first_code);
        for (int64_t j = 0; j < section_count; j++)
            find_on_cycle(&lanes, law, sections + SECTION * j, first_code + 2.0 + (double)j);
        const bool any = find_ended(&lanes, law.loaded, duration, ended);
        for (int i = 0; any && i < LANES; i++) {
            if (owner[i] == NO_START || !ended[i])
                continue;
            record_result(&lanes, i, &starts, owner[i]);
            waiting = next_waiting(&starts, waiting);
            owner[i] = load_start(&lanes, i, &starts, waiting++);
            active -= owner[i] == NO_START;
        }
        if (section_count > 0)
            lanes.was = lanes.now;
        end_in_time(&lanes, law, duration);
        step_lanes(&lanes, law, tolerance);
    }
    return DONE;
}

int core_measure_returns(const struct rotor *rotor, const double *states, int64_t count,
                         const double section[SECTION], double earliest, double latest,
                         double tolerance, double *values, const stop_flag *stop)
{
    const struct law law = law_of(rotor);
    struct lanes lanes = {0};
    int64_t passed[LANES];
    bool left[LANES]; /* with friction, whether it has not slid forwards since its start */
    for (int64_t number = 0; number < count; number++)
        values[number] = INFINITY;
    for (int64_t first = 0; first < count; first += LANES) {
        const int used = count - first < LANES ? (int)(count - first) : LANES;
        for (int i = 0; i < LANES; i++)
            load_state(&lanes, i, state_at(states, count, first + (i < used ? i : used - 1)),
                       FIRST_STEP);
        memset(left, 0, sizeof left);
        double slowest = 0.0;
        for (int steps = 0; slowest < latest && steps < MOST_STEPS; steps++) {
            if (asked_to_stop(stop))
                return STOPPED;
            lanes.was = lanes.now;
            step_lanes(&lanes, law, tolerance);
            slowest = latest;
            for (int i = 0; i < used; i++) {
                slowest = smaller(lanes.now.time[i], slowest);
                left[i] = left[i] || lanes.turns[i] > 0.0;
            }
            const bool any = find_crossings(&lanes, section, passed);
            for (int i = 0; any && i < used; i++) {
                const double time = lanes.now.time[i];
                if (passed[i] && !left[i] && earliest <= time && time <= latest)
                    values[first + i] = smaller(section_value(&lanes, i, section, law),
                                                values[first + i]);
            }
        }
    }
    return DONE;
}
