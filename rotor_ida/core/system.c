/* The linear part of a rotor system: the Taylor series of one step.
 *
 * Coefficient n of the accelerations is one product of the matrices with coefficients n of
 * displacement and velocity, what the contacts answer (derived_element.h), and what is implicit:
 * the tangential forces of contacts that roll and, under a torque, the rate of the spin. These
 * appear linearly, with the same matrix at each order. */
#include "system_work.h"

/* The step is taken where the last terms reach the tolerance; lower ones may be larger by this
 * exponent an order, as they fall so where the order is best. */
static const double FALL = 2.0;
enum { TERMS_LOOKED_AT = 4 };
/* A step turns the fastest motion by no more than this part of the order. */
static const double FARTHEST = 0.25;
/* Small changes that are as fast may err by this many tolerances of the motion in a step. */
static const double OF_CHANGES = 1e3;
/* The logarithm of a step that nothing limits. */
static const double UNLIMITED = 200.0;
/* Contacts of a root below this part of that of the clearance have a fictitious time. */
static const double EDGE = 0.3;
/* Bytes to which what a run works with is aligned. */
enum { ALIGNED = 64 };
/* How many times eight columns are summed in registers. */
enum { MOST_EIGHTS = 3 };
/* A pivot below this part of its row is rounding. */
static const double DEPENDENT = 1e-13;

int64_t core_system_stride(int64_t size) { return padded(size); }

int64_t core_system_room(int64_t size, int64_t contacts)
{
    (void)contacts;
    const int64_t stride = padded(size);
    return (int64_t)(sizeof(struct work) / sizeof(double)) + 6 * ORDERS * stride + stride * stride
           + stride + (int64_t)(ALIGNED / sizeof(double));
}

/* Write the diagonal of the stiffness, where it has nothing else, as that of modes; else NULL. */
static const double *diagonal_of(const struct system_run *run, double *diagonal)
{
    memset(diagonal, 0, sizeof(double) * (size_t)run->stride);
    for (int64_t k = 0; k < run->size; k++) {
        const double *column = &run->stiffness[k * run->stride];
        for (int64_t i = 0; i < run->size; i++) {
            if (i != k && column[i] != 0.0)
                return NULL;
        }
        diagonal[k] = column[k];
    }
    return diagonal;
}

struct work *open_work(struct system_run *run)
{
    const int64_t stride = run->stride, block = ORDERS * stride;
    const size_t past = (uintptr_t)run->room % ALIGNED;
    struct work *work = (struct work *)(void *)((char *)run->room + (ALIGNED - past));
    double *rows = (double *)(void *)(work + 1);
    work->run = run;
    work->stride = stride;
    work->order = (int)run->order;
    work->y = rows;
    work->v = rows + block;
    work->acceleration = rows + 2 * block;
    work->resisted = rows + 3 * block;
    work->turned = rows + 4 * block;
    work->stiffened = rows + 5 * block;
    work->both = rows + 6 * block;
    work->diagonal = diagonal_of(run, work->both + stride * stride);
    work->is_summed = work->diagonal != NULL && run->stiffness_rate == NULL && run->massless == 0
                      && run->bearing_count == 0;
    work->bearings = open_bearings(run);
    for (int64_t i = 0; i < run->contact_count; i++) {
        struct touching *each = &work->touching[i];
        each->law = &run->laws[i];
        each->touch = &run->touches[i];
        each->rows = &run->rows[2 * i * stride];
        each->mobility = each->stator_mobility = 0.0;
        for (int64_t k = 0; k < run->size; k++) {
            const double x = each->rows[k], y = each->rows[stride + k];
            if (k < run->size - run->massless)
                each->mobility += x * x + y * y;
            else /* the same in both directions */
                each->stator_mobility += x * x;
        }
        memset(each->series.terms, 0, sizeof each->series.terms);
    }
    return work;
}

void begin_system_piece(struct work *work)
{
    struct system_run *run = work->run;
    const struct piece *piece = &run->pieces[run->piece];
    work->has_torque = piece->inverse_inertia > 0.0;
    work->has_rate = work->has_torque || piece->rate != 0.0;
    if (!work->has_torque) /* a run that goes on with more room is within a piece */
        turn_as_prescribed(run);
    for (int64_t i = 0; i < run->size * run->stride && run->gyroscopic && !work->has_rate; i++)
        work->both[i] = (run->damping ? run->damping[i] : 0.0) + run->speed * run->gyroscopic[i];
    begin_column_piece(work);
}

/* What the compiler knows of a system: the expansion of a small one is compiled for its size. */
struct shape {
    int64_t size, stride, contacts;
    /* whether the speed is constant, nothing is implicit, and there are neither races that spin nor
     * stators without mass nor contacts without clearance nor bearings by a table */
    int is_plain;
};

/* Add coefficient n of a product of a series with rows. What was written last is read last. */
COMPILED void add_convolved(double scale, const double *series, const double *rows, int n,
                            int64_t stride, double *to)
{
    add_sums(scale, &series[n], -1, rows, n + 1, stride, to);
}

/* The displacement or velocity of a contact by the coordinates. */
COMPILED void see(const double *rows, const double *coordinates, struct shape shape, double seen[2])
{
    if (shape.size > 2) {
        sums_of_products(rows, coordinates, shape.stride, seen);
        return;
    }
    for (int j = 0; j < 2; j++) {
        const double *row = rows + j * shape.stride;
        seen[j] = fma(row[0], coordinates[0], row[1] * coordinates[1]);
    }
}

/* ---- Beginning ---- */

void begin_terms(struct work *work)
{
    struct system_run *run = work->run;
    const size_t bytes = sizeof(double) * (size_t)work->stride;
    memcpy(work->y, run->state, bytes);
    memcpy(work->v, run->state + work->stride, bytes);
    work->time[0] = run->time;
    work->spin[0] = run->speed;
    work->cosine[0] = cos(run->angle);
    work->sine[0] = sin(run->angle);
    work->rolls = 0;
    work->edge_count = 0;
    for (int64_t i = 0; i < run->contact_count; i++) {
        struct touching *each = &work->touching[i];
        set_element(each);
        begin_lanes(&each->series);
        const double root = each->touch->root;
        each->series.terms[0][ELEMENT_ROOT] = root;
        each->series.terms[0][ELEMENT_RACE] = each->touch->race;
        each->is_edge = is_touching(each) && !is_spring(each)
                        && root < EDGE * sqrt(each->law->clearance);
        each->inverse_root = inverse(root);
        if (is_centred(each))
            begin_centred(work, each);
        if (each->is_edge)
            work->edges[work->edge_count++] = (int)i;
        if (each->touch->mode == ROLLS && each->stator_mobility == 0.0)
            work->rolling[work->rolls++] = (int)i;
    }
    work->moves = work->edge_count > 0;
    begin_bearings(work);
}

/* ---- One order ---- */

/* Take the answers of a contact with a stator without mass, which moves by them at once. */
static void push_massless(struct work *work, struct touching *each, int n)
{
    const struct system_run *run = work->run;
    double *answers = each->answers[n], *v = row_of(work, work->v, n);
    massless_order(&each->element, &each->series, n, answers);
    each->drag[n] = answers[ELEMENT_DRAG];
    for (int64_t i = run->size - run->massless; i < run->size; i++)
        v[i] += each->rows[i] * answers[ELEMENT_FORCE_X]
                + each->rows[work->stride + i] * answers[ELEMENT_FORCE_Y];
}

/* Give contacts coefficient n of their displacement and velocity, and take their answers. */
COMPILED void ask_contacts(struct work *work, int n, struct shape shape)
{
    struct system_run *run = work->run;
    const double *y = &work->y[n * shape.stride];
    double *v = &work->v[n * shape.stride];
    for (int64_t i = run->size - run->massless; i < run->size && !shape.is_plain; i++)
        v[i] = drift_of(run, y, n == 0 ? run->force[i] : 0.0, i);
    for (int64_t i = 0; i < shape.contacts; i++) {
        struct touching *each = &work->touching[i];
        double *given = each->series.terms[n];
        see(each->rows, y, shape, &given[ELEMENT_X]);
        for (int j = 0; j < 2 && n == 0; j++)
            given[ELEMENT_X + j] -= each->law->offset[j];
        if (is_touching(each))
            see(each->rows, v, shape, &given[ELEMENT_VX]);
        given[ELEMENT_SPIN] = work->spin[n];
        if (!is_touching(each))
            continue;
        if (!shape.is_plain && is_centred(each)) {
            push_centred(each, n);
        } else if (shape.is_plain) {
            element_order(&each->element, &each->series, n, each->answers[n]);
            each->drag[n] = element_drag(&each->element, each->answers[n][ELEMENT_PUSH]);
        } else if (each->stator_mobility > 0.0) {
            push_massless(work, each, n);
        } else if (each->touch->mode == ROLLS) {
            rolling_order(&each->element, &each->series, n, each->answers[n]);
            each->drag[n] = 0.0; /* until what is implicit is known */
        } else {
            element_order(&each->element, &each->series, n, each->answers[n]);
            each->drag[n] = element_drag(&each->element, each->answers[n][ELEMENT_PUSH]);
        }
    }
}

/* Coefficient n of the product of the roots of several contacts near their edges, and of those of
 * all but one of them. */
static void set_pace_of_many(struct work *work, int n)
{
    for (int e = 0; e < work->edge_count; e++) {
        double product[ORDERS];
        const int first = e == 0;
        for (int k = 0; k <= n; k++)
            product[k] = work->touching[work->edges[first]].series.terms[k][ELEMENT_ROOT];
        for (int other = first + 1; other < work->edge_count; other++) {
            const double *root = &work->touching[work->edges[other]].series.terms[0][ELEMENT_ROOT];
            for (int k = n; k >= 0 && other != e; k--)
                product[k] = convolved(product, 1, root, WIDTH, k);
        }
        work->touching[work->edges[e]].others[n] = product[n];
    }
    const struct touching *first = &work->touching[work->edges[0]];
    const double *root = &first->series.terms[0][ELEMENT_ROOT];
    work->pace[n] = convolved(first->others, 1, root, WIDTH, n);
}

/* Coefficient n of the pace: the product of the roots of all contacts near their edges. */
COMPILED void set_pace(struct work *work, int n, struct shape shape)
{
    const int only = shape.contacts == 1 ? 0 : work->edges[0];
    if (!work->moves) {
        work->pace[n] = n == 0 ? 1.0 : 0.0;
        return;
    }
    if (shape.contacts == 1 || work->edge_count == 1)
        work->pace[n] = work->touching[only].series.terms[n][ELEMENT_ROOT];
    else
        set_pace_of_many(work, n);
}

/* Coefficient n of what the speed does: its square, and the two factors of the unbalance, without
 * what is implicit of them. */
COMPILED void set_drive(struct work *work, int n, struct shape shape)
{
    const double rate = work->run->pieces[work->run->piece].rate;
    if (!work->has_torque)
        work->spin_rate[n] = n == 0 ? rate : 0.0;
    if (shape.is_plain || !work->has_rate) {
        const double square = work->spin[0] * work->spin[0];
        work->turning[n] = work->pace[n] * work->spin[0];
        work->by_cosine[n] = square * work->cosine[n];
        work->by_sine[n] = square * work->sine[n];
        return;
    }
    work->spin_square[n] = convolved(work->spin, 1, work->spin, 1, n);
    work->turning[n] = work->moves ? convolved(work->pace, 1, work->spin, 1, n) : work->spin[n];
    const double *c = work->cosine, *s = work->sine, *d = work->spin_rate;
    work->by_cosine[n] = convolved(work->spin_square, 1, c, 1, n);
    work->by_sine[n] = convolved(work->spin_square, 1, s, 1, n);
    work->by_cosine[n] += work->has_torque ? convolved_later(s, 1, d, 1, n) : d[0] * s[n];
    work->by_sine[n] -= work->has_torque ? convolved_later(c, 1, d, 1, n) : d[0] * c[n];
}

/* Add what some times eight columns of a matrix make of a row, in two sums that wait by turns. */
COMPILED void add_columns(const int eights, const double *matrix, const double *row, int64_t size,
                          int64_t stride, vec8 *sum)
{
    vec8 odd[MOST_EIGHTS];
    for (int e = 0; e < eights; e++)
        odd[e] = spread8(0.0);
    int64_t k = 0;
    for (; k + 1 < size; k += 2, matrix += 2 * stride)
        for (int e = 0; e < eights; e++) {
            sum[e] = fma8(row[k], load8(&matrix[8 * e]), sum[e]);
            odd[e] = fma8(row[k + 1], load8(&matrix[stride + 8 * e]), odd[e]);
        }
    for (int e = 0; e < eights; e++) {
        if (k < size)
            sum[e] = fma8(row[k], load8(&matrix[8 * e]), sum[e]);
        sum[e] += odd[e];
    }
}

/* The same, of some times eight columns, where the stiffness is diagonal and the same at all
 * speeds: what is summed stays in registers. */
COMPILED void accelerate_eights(const struct work *work, const int eights, int n,
                                struct shape shape, const int turns, int64_t at)
{
    const struct system_run *run = work->run;
    const int64_t stride = shape.stride;
    const double *y = &work->y[n * stride + at], *v = &work->v[n * stride];
    const double *resistance = run->gyroscopic != NULL && !turns ? work->both : run->damping;
    vec8 sum[MOST_EIGHTS], resisted[MOST_EIGHTS], turned[MOST_EIGHTS];
    for (int e = 0; e < eights; e++) {
        sum[e] = n == 0 ? load8(&run->force[at + 8 * e]) : spread8(0.0);
        sum[e] = fma_each(-load8(&work->diagonal[at + 8 * e]), load8(&y[8 * e]), sum[e]);
        resisted[e] = turned[e] = spread8(0.0);
    }
    if (resistance != NULL)
        add_columns(eights, resistance + at, v, shape.size, stride, resisted);
    if (turns) {
        add_columns(eights, run->gyroscopic + at, v, shape.size, stride, turned);
        double *rows = &work->turned[at];
        for (int e = 0; e < eights; e++) {
            store8(&rows[n * stride + 8 * e], turned[e]);
            resisted[e] = fma8(work->spin[0], turned[e], resisted[e]);
            turned[e] = spread8(0.0);
        }
        for (int k = 0; k < n; k++)
            for (int e = 0; e < eights; e++)
                turned[e] = fma8(work->spin[n - k], load8(&rows[k * stride + 8 * e]), turned[e]);
    }
    for (int e = 0; e < eights; e++) {
        resisted[e] += turned[e];
        store8(&work->resisted[n * stride + at + 8 * e], resisted[e]);
        sum[e] -= resisted[e];
        sum[e] = fma8(work->by_cosine[n], load8(&run->unbalance[at + 8 * e]), sum[e]);
        sum[e] = fma8(work->by_sine[n], load8(&run->unbalance[stride + at + 8 * e]), sum[e]);
        for (int64_t i = 0; i < shape.contacts; i++) {
            const struct touching *each = &work->touching[i];
            const double *row = each->rows + at + 8 * e;
            if (!is_touching(each))
                continue;
            sum[e] = fma8(each->answers[n][ELEMENT_FORCE_X], load8(row), sum[e]);
            sum[e] = fma8(each->answers[n][ELEMENT_FORCE_Y], load8(row + stride), sum[e]);
        }
        store8(&work->acceleration[n * stride + at + 8 * e], sum[e]);
    }
}

/* The same of all columns. */
COMPILED void accelerate_in_registers(const struct work *work, int n, struct shape shape,
                                      const int turns)
{
    int64_t i = 0;
    for (; i + 24 <= shape.stride; i += 24)
        accelerate_eights(work, 3, n, shape, turns, i);
    if (i + 16 <= shape.stride)
        accelerate_eights(work, 2, n, shape, turns, i);
    else if (i < shape.stride)
        accelerate_eights(work, 1, n, shape, turns, i);
}

/* Coefficient n of the accelerations, but for what is implicit. */
COMPILED void accelerate(struct work *work, int n, struct shape shape)
{
    struct system_run *run = work->run;
    const int64_t size = shape.size, stride = shape.stride;
    const double *y = &work->y[n * stride], *v = &work->v[n * stride];
    /* a row of four, of which the compiler knows all uses, stays in a register */
    double here[2][4];
    double *to = stride == 4 ? here[0] : &work->acceleration[n * stride];
    double *resisted = stride == 4 ? here[1] : &work->resisted[n * stride];
    const int has_rate = !shape.is_plain && work->has_rate;
    const int joined = run->gyroscopic != NULL && !has_rate;
    const double *resistance = joined ? work->both : run->damping;
    const size_t bytes = sizeof(double) * (size_t)stride;
    if (stride > 4 && work->is_summed) {
        if (run->gyroscopic != NULL && has_rate)
            accelerate_in_registers(work, n, shape, 1);
        else
            accelerate_in_registers(work, n, shape, 0);
        return;
    }
    if (n == 0)
        memcpy(to, run->force, bytes);
    else
        memset(to, 0, bytes);
    if (work->diagonal == NULL)
        multiply(run->stiffness, y, -1.0, size, stride, to);
    else
        for (int64_t i = 0; i < stride; i += 4)
            store(&to[i], fma4(-load(&work->diagonal[i]), load(&y[i]), load(&to[i])));
    memset(resisted, 0, bytes);
    if (resistance != NULL) {
        multiply(resistance, v, 1.0, size, stride, resisted);
    }
    if (run->gyroscopic != NULL && has_rate) {
        double *turned = row_of(work, work->turned, n);
        memset(turned, 0, bytes);
        multiply(run->gyroscopic, v, 1.0, size, stride, turned);
        add_convolved(1.0, work->spin, work->turned, n, stride, resisted);
    }
    add_scaled(-1.0, resisted, to, stride);
    if (run->stiffness_rate != NULL && has_rate) {
        double *stiffened = row_of(work, work->stiffened, n);
        memset(stiffened, 0, bytes);
        multiply(run->stiffness_rate, y, 1.0, size, stride, stiffened);
        if (!work->has_torque)
            add_scaled(-work->spin_rate[0], stiffened, to, stride);
        else /* all but the coefficient of the rate that is implicit */
            for (int k = 1; k <= n; k++)
                add_scaled(-work->spin_rate[n - k], row_of(work, work->stiffened, k), to, stride);
    }
    add_both(work->by_cosine[n], work->by_sine[n], run->unbalance, stride, to);
    for (int64_t i = 0; i < shape.contacts; i++) {
        const struct touching *each = &work->touching[i];
        if (!is_touching(each))
            continue;
        const double *answers = each->answers[n];
        add_both(answers[ELEMENT_FORCE_X], answers[ELEMENT_FORCE_Y], each->rows, stride, to);
    }
    if (!shape.is_plain && run->bearing_count > 0)
        push_by_bearings(work, n, to);
    for (int64_t i = size - run->massless; i < size && !shape.is_plain; i++)
        to[i] = 0.0; /* whose velocities follow from the forces */
    if (stride == 4) {
        store(&work->acceleration[4 * n], load(to));
        store(&work->resisted[4 * n], load(resisted));
    }
}

/* ---- What is implicit ---- */

/* The two components across a contact's displacement, to the left. */
static inline void across_of(const struct touching *each, int n, double tangent[2])
{
    tangent[0] = -each->answers[n][ELEMENT_NORMAL_Y];
    tangent[1] = each->answers[n][ELEMENT_NORMAL_X];
}

/* Write what a unit tangential force of a contact accelerates at order 0. */
static void column_of_hold(const struct work *work, const struct touching *each, double *column)
{
    double tangent[2];
    across_of(each, 0, tangent);
    memset(column, 0, sizeof(double) * (size_t)work->stride);
    add_both(-tangent[0], -tangent[1], each->rows, work->stride, column);
}

/* The same of a unit rate of the spin. */
static void column_of_spin(const struct work *work, double *column)
{
    const struct system_run *run = work->run;
    memset(column, 0, sizeof(double) * (size_t)work->stride);
    add_both(work->sine[0], -work->cosine[0], run->unbalance, work->stride, column);
    if (run->stiffness_rate != NULL)
        add_scaled(-1.0, work->stiffened, column, work->stride);
}

/* The rate of slip of a contact by accelerations, along its tangent at order 0. */
static double slip_by(const struct work *work, const struct touching *each, const double *row)
{
    double tangent[2], moved[2];
    across_of(each, 0, tangent);
    sums_of_products(each->rows, row, work->stride, moved);
    return tangent[0] * moved[0] + tangent[1] * moved[1];
}

/* What accelerations take from the torque, through the unbalance, by its direction at order 0. */
static double torque_by(const struct work *work, const double *row)
{
    double swung[2];
    sums_of_products(work->run->unbalance, row, work->stride, swung);
    return work->cosine[0] * swung[1] - work->sine[0] * swung[0];
}

/* Factorise a small matrix in place, by rows with pivots; say whether it is regular. */
static int factorise(struct work *work, int size)
{
    double largest[MOST_CONTACTS + 1];
    int regular = 1;
    for (int i = 0; i < size; i++) {
        largest[i] = 0.0;
        for (int j = 0; j < size; j++)
            largest[i] = fmax(largest[i], fabs(work->matrix[i][j]));
    }
    for (int k = 0; k < size; k++) {
        int best = k;
        for (int i = k + 1; i < size; i++)
            best = fabs(work->matrix[i][k]) > fabs(work->matrix[best][k]) ? i : best;
        work->pivot[k] = best;
        regular &= fabs(work->matrix[best][k]) > DEPENDENT * largest[best];
        largest[best] = largest[k];
        for (int j = 0; j < size && best != k; j++) {
            const double kept = work->matrix[k][j];
            work->matrix[k][j] = work->matrix[best][j];
            work->matrix[best][j] = kept;
        }
        const double inverse_pivot = inverse(work->matrix[k][k]);
        for (int i = k + 1; i < size; i++) {
            const double factor = work->matrix[i][k] * inverse_pivot;
            work->matrix[i][k] = factor;
            for (int j = k + 1; j < size; j++)
                work->matrix[i][j] -= factor * work->matrix[k][j];
        }
    }
    return regular;
}

void solve_implicit(const struct work *work, int size, double *right)
{
    for (int k = 0; k < size; k++) { /* whole rows have changed places, factors too */
        const double kept = right[work->pivot[k]];
        right[work->pivot[k]] = right[k];
        right[k] = kept;
    }
    for (int k = 0; k < size; k++) {
        for (int i = k + 1; i < size; i++)
            right[i] -= work->matrix[i][k] * right[k];
    }
    for (int k = size - 1; k >= 0; k--) {
        for (int j = k + 1; j < size; j++)
            right[k] -= work->matrix[k][j] * right[j];
        right[k] = ratio(right[k], work->matrix[k][k]);
    }
}

/* Write the matrix of what is implicit: of unit forces and of a unit rate of the spin (the last
 * unknown), the rates of slip of the contacts that roll, and the torque. */
static void write_matrix(struct work *work)
{
    const struct system_run *run = work->run;
    /* nothing reads this row before it is written again */
    double *column = row_of(work, work->acceleration, 1);
    for (int j = 0; j < work->rolls; j++) {
        const struct touching *pushed = &work->touching[work->rolling[j]];
        const struct system_law *law = pushed->law;
        column_of_hold(work, pushed, column);
        for (int i = 0; i < work->rolls; i++)
            work->matrix[i][j] = -slip_by(work, &work->touching[work->rolling[i]], column);
        for (int i = 0; i < work->rolls; i++) {
            if (work->touching[work->rolling[i]].law->race == law->race)
                work->matrix[i][j] += yield_of_race(law);
        }
        if (work->has_torque)
            work->matrix[work->rolls][j] = law->radius + torque_by(work, column);
    }
    if (work->has_torque) {
        column_of_spin(work, column);
        for (int i = 0; i < work->rolls; i++) {
            const struct touching *each = &work->touching[work->rolling[i]];
            work->matrix[i][work->rolls] = -slip_by(work, each, column) - each->law->radius;
        }
        work->matrix[work->rolls][work->rolls] = run->inertia + torque_by(work, column);
    }
}

/* Coefficient n of what is implicit: set its right-hand side, solve, and add what it does. */
static void add_implicit(struct work *work, int n)
{
    struct system_run *run = work->run;
    const int64_t stride = work->stride;
    const int size = work->rolls + work->has_torque;
    if (size == 0)
        return;
    double *to = row_of(work, work->acceleration, n), *right = work->right;
    for (int j = 0; j < work->rolls; j++) { /* known parts of the holding forces */
        const struct touching *each = &work->touching[work->rolling[j]];
        const double *along = &each->answers[0][ELEMENT_NORMAL_X];
        const double *aside = &each->answers[0][ELEMENT_NORMAL_Y];
        const double known_x = convolved_later(along, ELEMENT_ANSWERS, each->drag, 1, n);
        const double known_y = convolved_later(aside, ELEMENT_ANSWERS, each->drag, 1, n);
        add_both(known_y, -known_x, each->rows, stride, to);
    }
    for (int i = 0; i < work->rolls; i++) {
        const struct touching *each = &work->touching[work->rolling[i]];
        const struct system_law *law = each->law;
        const double *along = &each->answers[0][ELEMENT_NORMAL_X];
        const double *aside = &each->answers[0][ELEMENT_NORMAL_Y];
        right[i] = slip_by(work, each, to) - each->answers[n][ELEMENT_TURNING]
                   + convolved_later(along, ELEMENT_ANSWERS, &each->pull[0][1], 2, n)
                   - convolved_later(aside, ELEMENT_ANSWERS, &each->pull[0][0], 2, n)
                   + law->race_radius * law->inverse_race_inertia * law->race_drag
                         * each->series.terms[n][ELEMENT_RACE];
        for (int64_t k = 0; k < run->contact_count; k++) {
            const struct touching *other = &work->touching[k];
            if (other != each && turns_race(other, each)) /* 0 yet of those that roll */
                right[i] -= yield_of_race(law) * other->drag[n];
        }
        if (!work->has_torque)
            right[i] += law->radius * work->spin_rate[n];
    }
    if (work->has_torque) {
        const struct piece *piece = &run->pieces[run->piece];
        double torque = (n == 0 ? piece->torque : 0.0) - piece->slope * work->spin[n];
        torque += work->cosine[n] * run->weight[0] - work->sine[n] * run->weight[1];
        torque -= torque_by(work, to) + convolved_later(work->cosine, 1, &work->swung[0][1], 2, n)
                  - convolved_later(work->sine, 1, &work->swung[0][0], 2, n);
        for (int64_t i = 0; i < run->contact_count; i++) {
            const struct touching *each = &work->touching[i];
            if (pushes(each) && (each->touch->mode != ROLLS || each->stator_mobility > 0.0))
                torque -= each->law->radius * each->drag[n];
        }
        right[work->rolls] = torque;
    }
    if (n == 0) {
        write_matrix(work);
        if (work->is_asked) /* the caller wants matrix and right-hand side as they are */
            return;
        work->is_singular = !factorise(work, size);
    }
    solve_implicit(work, size, right);
    for (int j = 0; j < work->rolls; j++) {
        struct touching *each = &work->touching[work->rolling[j]];
        double tangent[2];
        across_of(each, 0, tangent);
        each->drag[n] = right[j];
        add_both(-tangent[0] * right[j], -tangent[1] * right[j], each->rows, stride, to);
    }
    if (work->has_torque) {
        const double rate = right[work->rolls];
        const double along = work->sine[0] * rate, aside = -work->cosine[0] * rate;
        work->spin_rate[n] = rate;
        work->by_cosine[n] += along;
        work->by_sine[n] += aside;
        add_both(along, aside, run->unbalance, stride, to);
        if (run->stiffness_rate != NULL)
            add_scaled(-rate, work->stiffened, to, stride);
        sums_of_products(run->unbalance, to, stride, work->swung[n]);
    }
}

/* ---- Coefficients n + 1 ---- */

/* The root of a contact: 2 s s' = pace d', where its own root is no factor of the pace; or the
 * indentation itself, d' = pace d'. */
COMPILED double next_root(const struct work *work, const struct touching *each, int n, double share)
{
    const double *root = &each->series.terms[0][ELEMENT_ROOT];
    const double *approach = &each->answers[0][ELEMENT_APPROACH];
    if (each->is_edge && work->edge_count == 1)
        return 0.5 * share * approach[n * ELEMENT_ANSWERS];
    if (each->is_edge)
        return 0.5 * share * convolved(each->others, 1, approach, ELEMENT_ANSWERS, n);
    const double rate = work->moves ? convolved(work->pace, 1, approach, ELEMENT_ANSWERS, n)
                                    : approach[n * ELEMENT_ANSWERS];
    if (is_spring(each))
        return share * rate;
    const double square = n == 0 ? 0.0 : convolved(&root[WIDTH], WIDTH, &root[WIDTH], WIDTH, n - 1);
    return 0.5 * fma(share, rate, -square) * each->inverse_root;
}

COMPILED void go_on(struct work *work, int n, struct shape shape)
{
    const int64_t stride = shape.stride;
    const double share = 1.0 / (n + 1);
    const int has_rate = !shape.is_plain && work->has_rate;
    double *y = &work->y[(n + 1) * stride], *v = &work->v[(n + 1) * stride];
    const size_t bytes = sizeof(double) * (size_t)stride;
    if (work->moves) {
        memset(y, 0, bytes);
        memset(v, 0, bytes);
        add_convolved(share, work->pace, work->v, n, stride, y);
        add_convolved(share, work->pace, work->acceleration, n, stride, v);
    } else {
        const double *velocity = &work->v[n * stride];
        const double *acceleration = &work->acceleration[n * stride];
        int64_t i = 0;
        for (; i + 8 <= stride; i += 8) {
            store8(&y[i], spread8(share) * load8(&velocity[i]));
            store8(&v[i], spread8(share) * load8(&acceleration[i]));
        }
        for (; i < stride; i += 4) {
            store(&y[i], spread(share) * load(&velocity[i]));
            store(&v[i], spread(share) * load(&acceleration[i]));
        }
    }
    work->time[n + 1] = work->pace[n] * share;
    if (work->moves || has_rate) {
        work->cosine[n + 1] = -convolved(work->turning, 1, work->sine, 1, n) * share;
        work->sine[n + 1] = convolved(work->turning, 1, work->cosine, 1, n) * share;
    } else {
        work->cosine[n + 1] = -work->turning[0] * work->sine[n] * share;
        work->sine[n + 1] = work->turning[0] * work->cosine[n] * share;
    }
    work->spin[n + 1] = 0.0;
    if (has_rate)
        work->spin[n + 1] = share
                            * (work->moves ? convolved(work->pace, 1, work->spin_rate, 1, n)
                                           : work->spin_rate[n]);
    for (int64_t i = 0; i < shape.contacts; i++) {
        struct touching *each = &work->touching[i];
        const struct system_law *law = each->law;
        double *terms = each->series.terms[n + 1];
        if (shape.is_plain ? is_touching(each) : may_leave(each))
            terms[ELEMENT_ROOT] = next_root(work, each, n, share);
        if (shape.is_plain)
            continue;
        if (law->inverse_race_inertia > 0.0) {
            double rate = -law->race_drag
                          * convolved(work->pace, 1, &each->series.terms[0][ELEMENT_RACE], WIDTH,
                                      n);
            for (int64_t k = 0; k < shape.contacts; k++) {
                const struct touching *other = &work->touching[k];
                if (turns_race(other, each))
                    rate += law->race_radius * convolved(work->pace, 1, other->drag, 1, n);
            }
            terms[ELEMENT_RACE] = rate * law->inverse_race_inertia * share;
        }
        if (each->touch->mode == ROLLS) {
            const double *row = row_of(work, work->acceleration, n);
            sums_of_products(each->rows, row, stride, each->pull[n]);
        }
    }
}

static struct shape shape_of(const struct work *work)
{
    const struct system_run *run = work->run;
    int is_plain = !work->has_rate && work->rolls == 0 && run->massless == 0;
    is_plain &= run->bearing_count == 0;
    for (int64_t i = 0; i < run->contact_count; i++)
        is_plain &= run->laws[i].inverse_race_inertia == 0.0 && run->laws[i].clearance > 0.0;
    return (struct shape){run->size, work->stride, run->contact_count, is_plain};
}

void ask_implicit(struct work *work)
{
    const struct shape shape = shape_of(work);
    ask_contacts(work, 0, shape);
    set_pace(work, 0, shape);
    set_drive(work, 0, shape);
    accelerate(work, 0, shape);
    work->is_asked = 1;
    add_implicit(work, 0);
}

COMPILED void expand_as(struct work *work, int order, struct shape shape)
{
    for (int n = 0; n < order; n++) {
        ask_contacts(work, n, shape);
        set_pace(work, n, shape);
        set_drive(work, n, shape);
        accelerate(work, n, shape);
        if (!shape.is_plain)
            add_implicit(work, n);
        go_on(work, n, shape);
        if (work->is_led)
            take_terms(work, n + 1);
    }
    if (order > 1)
        ask_contacts(work, order, shape);
}

void expand_system(struct work *work, int order)
{
    const struct shape shape = shape_of(work);
    work->is_asked = work->is_singular = 0;
    if (shape.is_plain && shape.size == 2 && shape.contacts == 1)
        expand_as(work, order, (struct shape){2, 4, 1, 1});
    else if (shape.is_plain && shape.size == 4 && shape.contacts == 1)
        expand_as(work, order, (struct shape){4, 4, 1, 1});
    else if (shape.is_plain)
        expand_as(work, order, (struct shape){shape.size, shape.stride, shape.contacts, 1});
    else
        expand_as(work, order, shape);
}

/* ---- The step ---- */

/* The larger of the terms n of the velocities that decide how a contact goes on. */
static double worst_answer(const struct touching *each, int n)
{
    const double approach = fabs(each->answers[n][ELEMENT_APPROACH]);
    const double slip = fabs(each->answers[n][ELEMENT_SLIP]);
    return each->law->friction > 0.0 ? fmax(approach, slip) : approach;
}

/* The largest size of the numbers of a row; more than any number where one is not finite. */
static double largest_of(const double *row, int64_t size)
{
    vec4 largest = spread(0.0), total = spread(0.0);
    for (int64_t i = 0; i < size; i += 4) {
        const vec4 here = load_row(&row[i], 1);
        for (int j = 0; j < 4; j++)
            largest[j] = larger(here[j], largest[j]);
        total += here;
    }
    const double sum = (total[0] + total[1]) + (total[2] + total[3]);
    const double most = larger(larger(largest[0], largest[1]), larger(largest[2], largest[3]));
    return isfinite(sum) ? most : INFINITY;
}

/* The same of the numbers that belong to coordinates with mass. */
static double largest_inert(const struct system_run *run, const double *row)
{
    const int64_t inert = run->size - run->massless, whole = inert / 4 * 4;
    if (run->massless == 0)
        return largest_of(row, run->stride);
    double found = largest_of(row, whole);
    for (int64_t i = whole; i < inert; i++)
        found = larger(isfinite(row[i]) ? fabs(row[i]) : INFINITY, found);
    return found;
}

/* The largest of the terms n, in parts of their tolerances; NaN where one is not finite. */
static double worst_of(const struct work *work, int n)
{
    const struct system_run *run = work->run;
    const double *y = &work->y[n * work->stride], *v = &work->v[n * work->stride];
    const double scale = run->velocity / run->displacement; /* a rate */
    double worst = larger(largest_inert(run, y) / run->displacement,
                          largest_inert(run, v) / run->velocity);
    worst = larger(fabs(work->time[n]) * scale, worst);
    if (work->has_torque)
        worst = larger(fabs(work->spin[n]) / scale, worst);
    for (int64_t i = 0; i < run->contact_count; i++) {
        const struct touching *each = &work->touching[i];
        const double *terms = each->series.terms[n];
        if (is_centred(each)) /* whose displacement is all there is */
            continue;
        if (is_touching(each)) {
            worst = larger(fabs(terms[ELEMENT_ROOT]) / root_of(each, each->law->clearance), worst);
            worst = larger(worst_answer(each, n) / (each->law->clearance * scale), worst);
        }
        if (each->law->inverse_race_inertia > 0.0)
            worst = larger(fabs(terms[ELEMENT_RACE]) / scale, worst);
        for (int64_t k = run->size - run->massless; k < run->size; k++) {
            const double row = fabs(each->rows[k] + each->rows[work->stride + k]);
            const double moved = row * larger(fabs(y[k]), fabs(v[k]) / scale);
            worst = larger(moved / each->law->clearance, worst);
            if (!isfinite(moved))
                worst = INFINITY;
        }
    }
    return isfinite(worst) ? worst / run->rtol : NAN;
}

/* The angle by which a step turns the fastest motion at most. Where small changes are followed,
 * some turn at that rate whatever the motion does: by it their last term is as small as they may
 * err. */
static double farthest_turn(const struct work *work)
{
    const int order = work->order;
    if (work->run->column_count == 0)
        return FARTHEST * order;
    double product = OF_CHANGES * work->run->rtol;
    for (int n = 2; n <= order; n++)
        product *= n;
    return smaller(to_power(product, 1.0 / order), FARTHEST * order);
}

void choose_step(struct work *work)
{
    const int order = work->order;
    double longest = UNLIMITED;
    for (int n = order; n > order - TERMS_LOOKED_AT; n--) {
        const double worst = worst_of(work, n);
        if (isnan(worst)) {
            work->step = NAN;
            return;
        }
        if (worst > 0.0)
            longest = smaller(longest, (FALL * (order - n) - log(worst)) / n);
    }
    work->step = exp(longest);
    double square = work->run->fastest * work->run->fastest, following = 0.0;
    for (int64_t i = 0; i < work->run->contact_count; i++) {
        const struct touching *each = &work->touching[i];
        if (!is_touching(each))
            continue;
        const double stiffness = element_stiffness(&each->element, 0, each->touch->root);
        square += each->mobility * stiffness;
        following = fmax(following, each->stator_mobility * stiffness);
    }
    const double rate = (sqrt(square) + following + fabs(work->spin[0])) * work->pace[0];
    if (rate > 0.0)
        work->step = smaller(work->step, farthest_turn(work) / rate);
    for (int64_t i = 0; i < work->run->contact_count; i++) {
        if (is_centred(&work->touching[i]))
            work->step = before_centre(work, &work->touching[i], work->step);
    }
}

void read_rows(const struct work *work, const double *rows, double point, double *values)
{
    const int64_t stride = work->stride;
    const vec4 at = spread(point);
    for (int64_t i = 0; i < stride; i += 4) {
        vec4 sum = load(&rows[work->order * stride + i]);
        for (int n = work->order - 1; n >= 0; n--)
            sum = fma4(sum, at, load(&rows[n * stride + i]));
        store(&values[i], sum);
    }
}

/* Where a prescribed speed has turned the rotor, which no step makes less exact. */
void turn_as_prescribed(struct system_run *run)
{
    const struct piece *piece = &run->pieces[run->piece];
    const double since = run->time - run->piece_time;
    run->speed = piece->speed + piece->rate * since;
    run->angle = run->piece_angle + (piece->speed + 0.5 * piece->rate * since) * since;
}

void move_system(struct work *work, double point)
{
    struct system_run *run = work->run;
    const double reached = polynomial(work->time, 1, work->order, point);
    const double span = reached - run->time;
    if (!run->only_events)
        keep_ledger(work, point, span);
    for (int64_t i = 0; i < run->contact_count; i++) {
        struct touching *each = &work->touching[i];
        const double *terms = each->series.terms[0];
        if (may_leave(each))
            each->touch->root = polynomial(&terms[ELEMENT_ROOT], WIDTH, work->order, point);
        if (each->law->inverse_race_inertia > 0.0)
            each->touch->race = polynomial(&terms[ELEMENT_RACE], WIDTH, work->order, point);
        const int of_slip = each->touch->zeros[OF_SLIP];
        memset(each->touch->zeros, 0, sizeof each->touch->zeros);
        if (span <= 0.0) /* holds that give way together: each slip still has its zero here */
            each->touch->zeros[OF_SLIP] = of_slip;
    }
    read_rows(work, work->y, point, run->state);
    read_rows(work, work->v, point, run->state + work->stride);
    if (work->has_torque) {
        run->angle += turned_by(work, point);
        run->speed = polynomial(work->spin, 1, work->order, point);
    }
    run->time = reached;
    if (!work->has_torque)
        turn_as_prescribed(run);
    pass_knots(work, point);
    run->steps++;
}
