/* Small changes of a motion of a rotor system: columns, as the start or a parameter would change.
 *
 * Between events they solve the linearised equations, by series in the same variable as the motion
 * itself. Columns stand side by side, so that one sum serves eight. Displacement, velocity and the
 * speeds of races are continuous at events; where their rates jump, as slip ends or turns, the
 * columns jump with the instant of the event (saltation: Leine and Nijmeijer, "Dynamics and
 * Bifurcations of Non-Smooth Mechanical Systems", 2004, section 7.2). */
#include "system_work.h"

/* A row of columns that is summed, and what it is multiplied by; counted from the first of all. */
struct term {
    double by;
    int64_t place;
};

/* A sum of rows of columns. */
struct sum {
    struct term *terms;
    int64_t count;
};

/* Series of what a contact does with the columns; two rows where there are two components. */
struct column_touch {
    double *moved, *rates, *pull;       /* of its displacement: that, velocity, acceleration */
    double *along, *aside;              /* the displacement, along e and t */
    double *rate_along, *rate_aside;    /* the velocity */
    double *push, *radial, *tangential; /* of N; and of the force, along -e and -t */
    double *drag, *race;                /* of T, but for the turn of t; the speed of the race */
    struct sum seen[2];                 /* its displacement by the coordinates */
    double slopes[ORDERS][SLOPES];
    struct series series;
};

struct columns {
    int64_t count;
    double *y, *v, *acceleration; /* of which v stands behind y */
    struct sum *linear;           /* what the matrices make of y and v, by coordinates */
    double *right;                /* MOST_CONTACTS rows */
    double *before;               /* accelerations of the motion before they jump */
    double *forced;               /* accelerations by a parameter */
    double *row;                  /* of all coordinates */
    struct column_touch touching[MOST_CONTACTS];
};

/* Vectors of eight columns that are summed at once; rows that are gathered for it. */
enum { BLOCK = 5, GATHERED = 64, SERIES_OF_TOUCH = 15, ALIGNMENT = 64 };

int64_t core_system_column_room(int64_t size, int64_t contacts, int64_t columns)
{
    const int64_t rows = (3 * ORDERS + 1) * size + contacts * SERIES_OF_TOUCH * ORDERS
                         + MOST_CONTACTS;
    const int64_t stride = padded(size), terms = 2 * size * (size + contacts);
    const size_t bytes = sizeof(struct columns) + 2 * ALIGNMENT + (size_t)size * sizeof(struct sum)
                         + (size_t)terms * sizeof(struct term);
    return (int64_t)(bytes / sizeof(double)) + rows * columns + 2 * stride;
}

static double *taken(double **room, int64_t count)
{
    double *here = *room;
    *room += count;
    return here;
}

static void *aligned(void *room)
{
    return (char *)room + (ALIGNMENT - (uintptr_t)room % ALIGNMENT) % ALIGNMENT;
}

static struct columns *columns_of(const struct work *work)
{
    return aligned(work->run->column_room);
}

/* ---- Sums of rows of columns ---- */

/* Add terms, of which each number stands `apart` from the next, and each row `apart_rows`, to a
 * sum that has room for them. */
static void gather(double sign, const double *numbers, int64_t apart, int64_t many, int64_t first,
                   int64_t apart_rows, struct sum *sum)
{
    for (int64_t k = 0; k < many; k++) {
        if (numbers[k * apart] != 0.0)
            sum->terms[sum->count++] = (struct term){sign * numbers[k * apart],
                                                     first + k * apart_rows};
    }
}

/* Add a sum of rows to some vectors of eight columns. */
COMPILED void add_vectors(const struct sum *sum, const double *rows, double *to, const int vectors)
{
    vec8 sums[BLOCK];
    for (int v = 0; v < vectors; v++)
        sums[v] = load8(&to[8 * v]);
    for (int64_t k = 0; k < sum->count; k++) {
        const double *row = &rows[sum->terms[k].place];
        for (int v = 0; v < vectors; v++)
            sums[v] = fma8(sum->terms[k].by, load8(&row[8 * v]), sums[v]);
    }
    for (int v = 0; v < vectors; v++)
        store8(&to[8 * v], sums[v]);
}

/* The same of all columns: blocks whose size the compiler knows, the last two about as large. */
static void add_sum(const struct sum *sum, const double *rows, double *to, int64_t count)
{
    for (int64_t many, left = count / 8; left > 0; left -= many) {
        many = left <= BLOCK ? left : left < 2 * BLOCK ? left / 2 : BLOCK;
        switch (many) {
        case 1:
            add_vectors(sum, rows, to, 1);
            break;
        case 2:
            add_vectors(sum, rows, to, 2);
            break;
        case 3:
            add_vectors(sum, rows, to, 3);
            break;
        case 4:
            add_vectors(sum, rows, to, 4);
            break;
        default:
            add_vectors(sum, rows, to, BLOCK);
        }
        rows += 8 * many;
        to += 8 * many;
    }
}

/* Add rows of columns, scaled: rows and factors stand so far apart. */
static void add_all(double sign, const double *factors, int64_t factor_apart, const double *rows,
                    int64_t apart, int64_t many, double *to, int64_t count)
{
    struct term terms[GATHERED];
    for (int64_t k = 0; k < many; k += GATHERED) {
        const int64_t here = many - k < GATHERED ? many - k : GATHERED;
        struct sum sum = {terms, 0};
        gather(sign, factors + k * factor_apart, factor_apart, here, k * apart, apart, &sum);
        add_sum(&sum, rows, to, count);
    }
}

/* Add coefficient n of a series times one of columns, of which a row stands every `apart`. */
static void add_product(double factor, const double *series, int series_apart, const double *rows,
                        int64_t apart, int n, double *to, int64_t count)
{
    add_all(factor, series, series_apart, rows + n * apart, -apart, n + 1, to, count);
}

static void clear(double *row, int64_t count) { memset(row, 0, sizeof(double) * (size_t)count); }

/* Add a matrix, stored by columns, times coefficients of all coordinates. */
static void add_matrix(const struct system_run *run, const double *matrix, double factor,
                       const double *rows, double *to)
{
    const int64_t count = run->column_count;
    for (int64_t i = 0; i < run->size; i++)
        add_all(factor, matrix + i, run->stride, rows, count, run->size, &to[i * count], count);
}

/* Write the displacement of a contact by coordinates. */
static void project(const struct system_run *run, const double *row, const double *rows, double *to)
{
    clear(to, run->column_count);
    add_all(1.0, row, 1, rows, run->column_count, run->size, to, run->column_count);
}

/* The same by what has been gathered of the contact; both components. */
static void project_both(const struct column_touch *touch, const double *rows, int64_t count,
                         double *to)
{
    clear(to, 2 * count);
    for (int j = 0; j < 2; j++)
        add_sum(&touch->seen[j], rows, to + j * count, count);
}

/* Let a force on a contact accelerate the coordinates. */
static void push_by(const struct system_run *run, const double *row, const double *force,
                    double *to)
{
    for (int64_t i = 0; i < run->size; i++) {
        if (row[i] != 0.0)
            add_scaled(row[i], force, &to[i * run->column_count], run->column_count);
    }
}

/* ---- Room ---- */

/* Give sums their room; gather those of the contacts. */
static void open_sums(const struct work *work, struct columns *columns, double *room)
{
    const struct system_run *run = work->run;
    columns->linear = (struct sum *)(void *)room;
    struct term *terms = (struct term *)(void *)(columns->linear + run->size);
    for (int64_t i = 0; i < run->size; i++) {
        columns->linear[i].terms = terms;
        terms += 2 * run->size;
    }
    for (int64_t i = 0; i < run->contact_count; i++) {
        for (int j = 0; j < 2; j++) {
            columns->touching[i].seen[j] = (struct sum){terms, 0};
            gather(1.0, work->touching[i].rows + j * run->stride, 1, run->size, 0, columns->count,
                   &columns->touching[i].seen[j]);
            terms += run->size;
        }
    }
}

void open_columns(struct work *work)
{
    const struct system_run *run = work->run;
    if (run->column_count == 0)
        return;
    struct columns *columns = columns_of(work);
    const int64_t count = run->column_count, series = ORDERS * count;
    double *room = aligned(columns + 1);
    columns->count = count;
    columns->y = taken(&room, series * run->size);
    columns->v = taken(&room, series * run->size);
    columns->acceleration = taken(&room, series * run->size);
    columns->right = taken(&room, MOST_CONTACTS * count);
    columns->row = taken(&room, run->size * count);
    for (int64_t i = 0; i < run->contact_count; i++) {
        struct column_touch *each = &columns->touching[i];
        each->moved = taken(&room, 2 * series);
        each->rates = taken(&room, 2 * series);
        each->pull = taken(&room, 2 * series);
        double **singles[] = {&each->along,      &each->aside, &each->rate_along,
                              &each->rate_aside, &each->push,  &each->radial,
                              &each->tangential, &each->drag,  &each->race};
        for (size_t k = 0; k < sizeof singles / sizeof singles[0]; k++)
            *singles[k] = taken(&room, series);
    }
    columns->before = taken(&room, run->stride);
    columns->forced = taken(&room, run->stride);
    open_sums(work, columns, room);
}

void begin_column_piece(struct work *work)
{
    const struct system_run *run = work->run;
    if (run->column_count == 0)
        return;
    struct columns *columns = columns_of(work);
    const int64_t count = columns->count, stride = run->stride, to_v = columns->v - columns->y;
    const double *resistance = run->gyroscopic != NULL && !work->has_rate ? work->both
                                                                          : run->damping;
    for (int64_t i = 0; i < run->size; i++) {
        struct sum *sum = &columns->linear[i];
        sum->count = 0;
        gather(-1.0, run->stiffness + i, stride, run->size, 0, count, sum);
        if (resistance != NULL)
            gather(-1.0, resistance + i, stride, run->size, to_v, count, sum);
    }
}

/* ---- One contact ---- */

/* Write coefficient n of the slopes of a contact. */
static void set_slopes(const struct touching *each, struct column_touch *touch, int n)
{
    const struct system_law *law = each->law;
    const double *answers = each->answers[n], *given = each->series.terms[n];
    double *here = touch->series.terms[n];
    here[SLOPE_ROOT] = given[ELEMENT_ROOT];
    here[SLOPE_APPROACH] = answers[ELEMENT_APPROACH];
    here[SLOPE_ACROSS] = answers[ELEMENT_SLIP] - law->radius * given[ELEMENT_SPIN]
                         + law->race_radius * given[ELEMENT_RACE];
    here[SLOPE_PUSH] = answers[ELEMENT_PUSH];
    here[SLOPE_DRAG] = each->drag[n];
    here[SLOPE_PULL] = 0.0;
    if (each->touch->mode == ROLLS)
        here[SLOPE_PULL] = convolved(&each->answers[0][ELEMENT_NORMAL_X], ELEMENT_ANSWERS,
                                     &each->pull[0][0], 2, n)
                           + convolved(&each->answers[0][ELEMENT_NORMAL_Y], ELEMENT_ANSWERS,
                                       &each->pull[0][1], 2, n);
    slope_order(&each->element, &touch->series, n, touch->slopes[n]);
}

/* Write coefficients n of two components along e and t. */
static void turn_along(const struct touching *each, const double *pair, int64_t count, int n,
                       double *along, double *aside)
{
    const double *x = &each->answers[0][ELEMENT_NORMAL_X], *y = &each->answers[0][ELEMENT_NORMAL_Y];
    clear(along, count);
    clear(aside, count);
    add_product(1.0, x, ELEMENT_ANSWERS, pair, 2 * count, n, along, count);
    add_product(1.0, y, ELEMENT_ANSWERS, pair + count, 2 * count, n, along, count);
    add_product(1.0, x, ELEMENT_ANSWERS, pair + count, 2 * count, n, aside, count);
    add_product(-1.0, y, ELEMENT_ANSWERS, pair, 2 * count, n, aside, count);
}

/* What a parameter changes of a contact. */
static inline const struct law_change *change_of(const struct work *work,
                                                 const struct touching *each, int64_t parameter)
{
    return &work->run->parameters[parameter].laws[each - work->touching];
}

/* Add what parameters change of the normal force of a contact. */
static void push_by_parameters(const struct work *work, const struct touching *each,
                               const struct column_touch *touch, int n, double *push)
{
    const struct system_run *run = work->run;
    for (int64_t k = 0; k < run->parameter_count; k++) {
        const struct law_change *change = change_of(work, each, k);
        push[run->first_of_parameters + k] +=
            change->stiffness * each->answers[n][ELEMENT_PUSH]
            + change->contact_damping * touch->slopes[n][SLOPE_BY_CONTACT_DAMPING]
            - change->clearance * touch->slopes[n][SLOPE_BY_ALONG];
    }
}

/* Let the force of a contact, whose coefficients up to n are known, act. */
static void answer_columns(const struct work *work, const struct touching *each,
                           struct column_touch *touch, int n)
{
    const struct system_run *run = work->run;
    struct columns *columns = columns_of(work);
    const int64_t count = columns->count, here = n * count;
    const double *slopes = touch->slopes[0];
    project_both(touch, &columns->y[here * run->size], count, &touch->moved[2 * here]);
    turn_along(each, touch->moved, count, n, &touch->along[here], &touch->aside[here]);
    if (each->law->contact_damping > 0.0 || each->touch->mode == ROLLS) {
        project_both(touch, &columns->v[here * run->size], count, &touch->rates[2 * here]);
        turn_along(each, touch->rates, count, n, &touch->rate_along[here],
                   &touch->rate_aside[here]);
    }

    double *push = &touch->push[here], *radial = &touch->radial[here];
    double *tangential = &touch->tangential[here], *drag = &touch->drag[here];
    clear(push, count);
    add_product(1.0, &slopes[SLOPE_BY_ALONG], SLOPES, touch->along, count, n, push, count);
    if (each->law->contact_damping > 0.0) {
        add_product(1.0, &slopes[SLOPE_BY_ASIDE], SLOPES, touch->aside, count, n, push, count);
        add_product(1.0, &slopes[SLOPE_BY_RATE], SLOPES, touch->rate_along, count, n, push, count);
    }
    push_by_parameters(work, each, touch, n, push);
    memcpy(radial, push, sizeof(double) * (size_t)count);
    add_product(-1.0, &slopes[SLOPE_BY_DRAG_SHARE], SLOPES, touch->aside, count, n, radial, count);
    clear(drag, count); /* of one that rolls not known yet */
    add_scaled(element_drag(&each->element, 1.0), push, drag, count);
    for (int64_t k = 0; k < run->parameter_count; k++)
        drag[run->first_of_parameters + k] += each->element.sigma
                                              * change_of(work, each, k)->friction
                                              * each->answers[n][ELEMENT_PUSH];
    memcpy(tangential, drag, sizeof(double) * (size_t)count);
    add_product(1.0, &slopes[SLOPE_BY_PUSH_SHARE], SLOPES, touch->aside, count, n, tangential,
                count);

    double *to = &columns->acceleration[here * run->size];
    double *force = columns->right; /* which is written later */
    const double *x = &each->answers[0][ELEMENT_NORMAL_X], *y = &each->answers[0][ELEMENT_NORMAL_Y];
    for (int j = 0; j < 2; j++) {
        clear(force, count);
        add_product(-1.0, j ? y : x, ELEMENT_ANSWERS, touch->radial, count, n, force, count);
        add_product(j ? -1.0 : 1.0, j ? x : y, ELEMENT_ANSWERS, touch->tangential, count, n, force,
                    count);
        push_by(run, each->rows + j * work->stride, force, to);
    }
}

/* The same without clearance. */
static void answer_centred(const struct work *work, const struct touching *each,
                           struct column_touch *touch, int n)
{
    const struct system_run *run = work->run;
    struct columns *columns = columns_of(work);
    const int64_t count = columns->count, here = n * count;
    double stiffness, *slopes = touch->slopes[n];
    memcpy(touch->series.terms[n], each->series.terms[n], sizeof each->series.terms[n]);
    if (is_linear_here(each, &stiffness)) {
        slopes[CENTRED_X_BY_X] = slopes[CENTRED_Y_BY_Y] = n == 0 ? -stiffness : 0.0;
        slopes[CENTRED_X_BY_Y] = 0.0;
    } else {
        centred_slope_order(&each->element, &touch->series, n, slopes);
    }
    clear(&touch->drag[here], count);
    project_both(touch, &columns->y[here * run->size], count, &touch->moved[2 * here]);
    double *to = &columns->acceleration[here * run->size];
    double *force = columns->right; /* which is written later */
    for (int j = 0; j < 2; j++) {
        clear(force, count);
        for (int k = 0; k < 2; k++)
            add_product(1.0, &touch->slopes[0][CENTRED_X_BY_X + j + k], SLOPES,
                        touch->moved + k * count, 2 * count, n, force, count);
        for (int64_t k = 0; k < run->parameter_count; k++)
            force[run->first_of_parameters + k] += change_of(work, each, k)->stiffness
                                                   * each->answers[n][ELEMENT_FORCE_X + j];
        push_by(run, each->rows + j * work->stride, force, to);
    }
}

/* The right-hand side of what holds a contact that rolls, at order n. */
static void ask_hold(const struct work *work, const struct touching *each,
                     struct column_touch *touch, int n, double *right)
{
    const struct system_run *run = work->run;
    const struct columns *columns = columns_of(work);
    const struct system_law *law = each->law;
    const int64_t count = columns->count;
    const double *slopes = touch->slopes[0];
    const double *x = &each->answers[0][ELEMENT_NORMAL_X], *y = &each->answers[0][ELEMENT_NORMAL_Y];
    double *pull = &touch->pull[2 * n * count];
    project_both(touch, &columns->acceleration[n * count * run->size], count, pull);
    clear(right, count);
    add_product(1.0, x, ELEMENT_ANSWERS, touch->pull + count, 2 * count, n, right, count);
    add_product(-1.0, y, ELEMENT_ANSWERS, touch->pull, 2 * count, n, right, count);
    const struct {
        int slope;
        double sign;
        const double *rows;
    } parts[] = {
        {SLOPE_BY_PULL_SHARE, -1.0, touch->aside},
        {SLOPE_BY_ACROSS_SHARE, -1.0, touch->rate_along},
        {SLOPE_BY_APPROACH_SHARE, -1.0, touch->rate_aside},
        {SLOPE_BY_DIFFERENCE, -1.0, touch->aside},
        {SLOPE_BY_PRODUCT, 1.0, touch->along},
    };
    for (size_t k = 0; k < sizeof parts / sizeof parts[0]; k++)
        add_product(parts[k].sign, &slopes[parts[k].slope], SLOPES, parts[k].rows, count, n, right,
                    count);
    add_scaled(law->race_radius * law->inverse_race_inertia * law->race_drag,
               &touch->race[n * count], right, count);
    for (int64_t k = 0; k < run->contact_count; k++) {
        const struct touching *other = &work->touching[k];
        if (other != each && turns_race(other, each)) /* 0 yet of those that roll */
            add_scaled(-yield_of_race(law), &columns->touching[k].drag[n * count], right, count);
    }
}

/* Find the tangential forces of the contacts that roll, and let them act. */
static void hold_columns(struct work *work, int n)
{
    const struct system_run *run = work->run;
    struct columns *columns = columns_of(work);
    const int64_t count = columns->count, here = n * count;
    for (int j = 0; j < work->rolls; j++)
        ask_hold(work, &work->touching[work->rolling[j]], &columns->touching[work->rolling[j]], n,
                 &columns->right[j * count]);
    for (int64_t c = 0; c < count && work->rolls > 0; c++) {
        double right[MOST_CONTACTS + 1];
        for (int j = 0; j < work->rolls; j++)
            right[j] = columns->right[j * count + c];
        solve_implicit(work, work->rolls, right);
        for (int j = 0; j < work->rolls; j++)
            columns->right[j * count + c] = right[j];
    }
    double *to = &columns->acceleration[here * run->size];
    for (int j = 0; j < work->rolls; j++) {
        const struct touching *each = &work->touching[work->rolling[j]];
        struct column_touch *touch = &columns->touching[work->rolling[j]];
        const double *held = &columns->right[j * count];
        add_scaled(1.0, held, &touch->drag[here], count);
        add_scaled(1.0, held, &touch->tangential[here], count);
        for (int64_t i = 0; i < run->size; i++) {
            const double by = each->rows[i] * each->answers[0][ELEMENT_NORMAL_Y]
                              - each->rows[work->stride + i] * each->answers[0][ELEMENT_NORMAL_X];
            add_scaled(by, held, &to[i * count], count);
        }
    }
    for (int j = 0; j < work->rolls; j++) {
        struct column_touch *touch = &columns->touching[work->rolling[j]];
        project_both(touch, to, count, &touch->pull[2 * here]);
    }
}

/* Let what a parameter changes but for the contacts accelerate the coordinates of its column. */
static void force_by_parameter(const struct work *work, const struct parameter *parameter, int n,
                               double *to)
{
    const struct system_run *run = work->run;
    const int64_t size = run->size, stride = work->stride;
    const double *y = row_of(work, work->y, n), *v = row_of(work, work->v, n);
    double *forced = columns_of(work)->forced;
    clear(forced, stride);
    if (parameter->mass != NULL)
        multiply(parameter->mass, row_of(work, work->acceleration, n), -1.0, size, stride, forced);
    if (parameter->force != NULL && n == 0)
        add_scaled(1.0, parameter->force, forced, stride);
    if (parameter->stiffness != NULL)
        multiply(parameter->stiffness, y, -1.0, size, stride, forced);
    if (parameter->damping != NULL)
        multiply(parameter->damping, v, -1.0, size, stride, forced);
    if (parameter->unbalance != NULL) {
        add_scaled(work->by_cosine[n], parameter->unbalance, forced, stride);
        add_scaled(work->by_sine[n], parameter->unbalance + stride, forced, stride);
    }
    if (parameter->speed != 0.0) { /* at all times the same, so that the angle grows with time */
        const double later = convolved(work->time, 1, work->by_cosine, 1, n);
        const double earlier = -convolved(work->time, 1, work->by_sine, 1, n);
        const double by_cosine = 2.0 * convolved(work->spin, 1, work->cosine, 1, n) + earlier;
        const double by_sine = 2.0 * convolved(work->spin, 1, work->sine, 1, n) + later;
        add_scaled(parameter->speed * by_cosine, run->unbalance, forced, stride);
        add_scaled(parameter->speed * by_sine, run->unbalance + stride, forced, stride);
        if (run->gyroscopic != NULL)
            multiply(run->gyroscopic, v, -parameter->speed, size, stride, forced);
    }
    for (int64_t i = 0; i < size; i++)
        to[i * run->column_count] += forced[i];
}

/* ---- A step ---- */

/* Write coefficient n + 1: the pace times a rate, integrated. */
static void integrate(const struct work *work, const double *rates, double *to, int64_t apart,
                      int n)
{
    clear(to, apart);
    if (work->moves)
        add_product(1.0 / (n + 1), work->pace, 1, rates, apart, n, to, apart);
    else
        add_scaled(1.0 / (n + 1), &rates[n * apart], to, apart);
}

/* What a bearing does whose coefficients change with the speed. */
static void push_columns_by_bearing(const struct work *work, int64_t number, int n, double *to)
{
    const struct system_run *run = work->run;
    const struct columns *columns = columns_of(work);
    const struct bearing_terms *bearing = &work->bearings->each[number];
    const int64_t count = columns->count, apart = run->size * count;
    const int64_t wide = ROWS_OF_BEARING * count;
    const int last = n < work->bearings->degree ? n : work->bearings->degree;
    const double *rows = run->bearings[number].rows;
    double *motion = &bearing->columns[n * wide], *force = columns->right; /* written later */
    for (int j = 0; j < 2; j++) {
        project(run, rows + j * run->stride, &columns->y[n * apart], motion + j * count);
        project(run, rows + j * run->stride, &columns->v[n * apart], motion + (2 + j) * count);
    }
    for (int j = 0; j < 2; j++) {
        memset(force, 0, sizeof(double) * (size_t)count);
        for (int k = 0; k < ROWS_OF_BEARING; k++)
            add_all(-1.0, &bearing->entries[0][ROWS_OF_BEARING * j + k], BEARING_ENTRIES,
                    motion + k * count, -wide, last + 1, force, count);
        push_by(run, rows + j * run->stride, force, to);
    }
}

/* What matrices do with coefficients n. */
static void accelerate_columns(const struct work *work, int n, double *to)
{
    const struct system_run *run = work->run;
    const struct columns *columns = columns_of(work);
    const int64_t count = columns->count, apart = run->size * count;
    const int is_turning = run->gyroscopic != NULL && work->has_rate;
    clear(to, apart);
    for (int64_t i = 0; i < run->size; i++)
        add_sum(&columns->linear[i], &columns->y[n * apart], &to[i * count], count);
    if (is_turning) {
        clear(columns->row, apart);
        add_product(1.0, work->spin, 1, columns->v, apart, n, columns->row, apart);
        add_matrix(run, run->gyroscopic, -1.0, columns->row, to);
    }
    if (run->stiffness_rate != NULL && work->has_rate)
        add_matrix(run, run->stiffness_rate, -work->spin_rate[0], &columns->y[n * apart], to);
}

static void expand_all(struct work *work)
{
    const struct system_run *run = work->run;
    struct columns *columns = columns_of(work);
    const int64_t count = columns->count, apart = run->size * count;
    for (int n = 0; n < work->order; n++) {
        double *to = &columns->acceleration[n * apart];
        accelerate_columns(work, n, to);
        for (int64_t i = 0; i < run->bearing_count; i++)
            push_columns_by_bearing(work, i, n, to);
        for (int64_t k = 0; k < run->parameter_count; k++)
            force_by_parameter(work, &run->parameters[k], n, to + run->first_of_parameters + k);
        for (int64_t i = 0; i < run->contact_count; i++) {
            if (is_centred(&work->touching[i])) {
                answer_centred(work, &work->touching[i], &columns->touching[i], n);
            } else if (pushes(&work->touching[i])) {
                set_slopes(&work->touching[i], &columns->touching[i], n);
                answer_columns(work, &work->touching[i], &columns->touching[i], n);
            }
        }
        hold_columns(work, n);
        integrate(work, columns->v, &columns->y[(n + 1) * apart], apart, n);
        integrate(work, columns->acceleration, &columns->v[(n + 1) * apart], apart, n);
        for (int64_t i = 0; i < run->contact_count; i++) {
            const struct system_law *law = work->touching[i].law;
            struct column_touch *touch = &columns->touching[i];
            double *race = &touch->race[(n + 1) * count];
            clear(race, count);
            if (law->inverse_race_inertia == 0.0)
                continue;
            const double share = law->inverse_race_inertia / (n + 1);
            add_product(-law->race_drag * share, work->pace, 1, touch->race, count, n, race, count);
            for (int64_t k = 0; k < run->contact_count; k++) {
                if (turns_race(&work->touching[k], &work->touching[i]))
                    add_product(law->race_radius * share, work->pace, 1, columns->touching[k].drag,
                                count, n, race, count);
            }
        }
    }
}

static void read_columns(const struct work *work, const double *series, int64_t apart, double point,
                         double *to)
{
    double powers[ORDERS] = {1.0};
    for (int n = 1; n <= work->order; n++)
        powers[n] = powers[n - 1] * point;
    clear(to, apart);
    add_all(1.0, powers, 1, series, apart, work->order + 1, to, apart);
}

void expand_columns(struct work *work)
{
    const struct system_run *run = work->run;
    if (run->column_count == 0)
        return;
    struct columns *columns = columns_of(work);
    const int64_t count = columns->count, apart = run->size * count;
    const double *y = run->columns, *v = y + apart, *races = v + apart;
    memcpy(columns->y, y, sizeof(double) * (size_t)apart);
    memcpy(columns->v, v, sizeof(double) * (size_t)apart);
    for (int64_t i = 0; i < run->contact_count; i++) {
        struct column_touch *touch = &columns->touching[i];
        memcpy(touch->race, races + i * count, sizeof(double) * (size_t)count);
        begin_lanes(&touch->series);
    }
    expand_all(work);
}

void move_columns(struct work *work, double point)
{
    struct system_run *run = work->run;
    if (run->column_count == 0)
        return;
    const struct columns *columns = columns_of(work);
    const int64_t count = columns->count, apart = run->size * count;
    double *y = run->columns, *v = y + apart, *races = v + apart;
    read_columns(work, columns->y, apart, point, y);
    read_columns(work, columns->v, apart, point, v);
    for (int64_t i = 0; i < run->contact_count; i++)
        read_columns(work, columns->touching[i].race, count, point, races + i * count);
}

void sample_columns(const struct work *work, double point)
{
    const struct system_run *run = work->run;
    if (run->column_count == 0 || run->watched_count == 0)
        return;
    const struct columns *columns = columns_of(work);
    const int64_t count = columns->count, apart = run->size * count;
    double *to = &run->sample_columns[run->sampled * run->watched_count * count];
    read_columns(work, columns->y, apart, point, columns->row);
    for (int64_t k = 0; k < run->watched_count; k++)
        project(run, &run->watched[k * run->stride], columns->row, &to[k * count]);
}

void record_columns(const struct system_run *run, int contact)
{
    const int64_t count = run->column_count;
    if (count == 0)
        return;
    double *to = &run->event_columns[2 * run->events * count];
    for (int j = 0; j < 2; j++)
        project(run, &run->rows[(2 * contact + j) * run->stride], run->columns, &to[j * count]);
}

/* ---- Where rates jump ---- */

/* Find the accelerations at the state of a run, and write the rates of its races. */
static void find_rates(struct work *work, double *races)
{
    begin_terms(work);
    expand_system(work, 1);
    for (int64_t i = 0; i < work->run->contact_count; i++) {
        const struct touching *each = &work->touching[i];
        const struct system_law *law = each->law;
        double drag = 0.0;
        for (int64_t k = 0; k < work->run->contact_count; k++)
            drag += turns_race(&work->touching[k], each) ? work->touching[k].drag[0] : 0.0;
        races[i] = law->inverse_race_inertia
                   * (law->race_radius * drag - law->race_drag * each->touch->race);
    }
}

/* The change of the slip of a contact with a change of the state, whose numbers are `apart`, and of
 * the speed. */
static double change_of_slip(const struct work *work, int contact, const double *y, const double *v,
                             double race, double speed, int64_t apart)
{
    const struct touching *each = &work->touching[contact];
    const double *answers = each->answers[0];
    const double across[2] = {-answers[ELEMENT_NORMAL_Y], answers[ELEMENT_NORMAL_X]};
    const double radius = each->law->clearance + depth_of(each, each->touch->root);
    double moved = 0.0, faster = 0.0;
    for (int j = 0; j < 2; j++) {
        const double *row = each->rows + j * work->stride;
        for (int64_t i = 0; i < work->run->size; i++) {
            moved += across[j] * row[i] * y[i * apart];
            faster += across[j] * row[i] * v[i * apart];
        }
    }
    return faster - answers[ELEMENT_APPROACH] * moved / radius + each->law->radius * speed
           - each->law->race_radius * race;
}

/* The change of the slip of a contact in a column. */
static double slip_in_column(const struct work *work, int contact, int64_t column)
{
    const struct system_run *run = work->run;
    const int64_t count = run->column_count, first = run->first_of_parameters;
    const double *y = run->columns, *v = y + run->size * count, *races = v + run->size * count;
    const int is_by_parameter = column >= first && column < first + run->parameter_count;
    return change_of_slip(work, contact, y + column, v + column, races[contact * count + column],
                          is_by_parameter ? run->parameters[column - first].speed : 0.0, count);
}

int change_with_columns(struct work *work, struct happening what)
{
    struct system_run *run = work->run;
    const int contact = what.contact;
    if (run->column_count == 0 || what.guard != OF_SLIP || run->touches[contact].mode == ROLLS)
        return change_contact(work, what);
    struct columns *columns = columns_of(work);
    const int64_t count = columns->count, size = run->size;
    double *v = run->columns + size * count, *races = v + size * count;
    double before[MOST_CONTACTS], after[MOST_CONTACTS], *later = columns->right;
    find_rates(work, before);
    memcpy(columns->before, work->acceleration, sizeof(double) * (size_t)work->stride);
    const double rate = change_of_slip(work, contact, run->state + work->stride, columns->before,
                                       before[contact], work->spin_rate[0], 1);
    for (int64_t c = 0; c < count; c++)
        later[c] = -ratio(slip_in_column(work, contact, c), rate);
    const int status = change_contact(work, what);
    if (status != DONE)
        return status;
    find_rates(work, after);
    for (int64_t i = 0; i < size; i++)
        add_scaled(columns->before[i] - work->acceleration[i], later, &v[i * count], count);
    for (int64_t i = 0; i < run->contact_count; i++)
        add_scaled(before[i] - after[i], later, &races[i * count], count);
    return DONE;
}

void begin_columns(struct work *work)
{
    struct system_run *run = work->run;
    if (run->column_count == 0)
        return;
    begin_terms(work);
    expand_system(work, 1);
    const int64_t count = run->column_count, size = run->size;
    double *v = run->columns + size * count, *races = v + size * count;
    for (int64_t c = 0; c < count && work->rolls > 0; c++) {
        double held[MOST_CONTACTS + 1];
        for (int j = 0; j < work->rolls; j++)
            held[j] = slip_in_column(work, work->rolling[j], c);
        solve_implicit(work, work->rolls, held);
        for (int j = 0; j < work->rolls; j++) {
            const struct touching *each = &work->touching[work->rolling[j]];
            const struct system_law *law = each->law;
            const double *answers = each->answers[0];
            for (int64_t i = 0; i < size; i++)
                v[i * count + c] += held[j]
                                    * (each->rows[i] * answers[ELEMENT_NORMAL_Y]
                                       - each->rows[work->stride + i] * answers[ELEMENT_NORMAL_X]);
            for (int64_t k = 0; k < run->contact_count; k++) {
                if (work->touching[k].law->race == law->race)
                    races[k * count + c] += held[j] * law->race_radius * law->inverse_race_inertia;
            }
        }
    }
}
