/* Every entry point of the core, called in every way that may go wrong: for the sanitizers.
 *
 * Tables are allocated to the last byte, so that a write beyond one is seen. Results are looked at
 * only so far as no row may be left as it was; their numbers are tested from Python. In the place
 * of SUNDIALS stands the classic Runge-Kutta method, each function of which can be made to fail. */
#define _XOPEN_SOURCE 700 /* of POSIX: timers */
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#ifdef _WIN32
#include <windows.h>
#else
#include <sys/time.h>
#endif

#include "observers.h"
#include "series.h"
#include "system.h"

static stop_flag stop;

#ifdef _WIN32
static void CALLBACK ask_to_stop(void *unused, BOOLEAN fired)
{
    (void)unused, (void)fired;
    stop = 1;
}

/* Ask to stop after a number of microseconds. */
static void stop_after(int microseconds)
{
    static HANDLE timer;
    if (timer != NULL)
        DeleteTimerQueueTimer(NULL, timer, INVALID_HANDLE_VALUE);
    stop = 0;
    CreateTimerQueueTimer(&timer, NULL, ask_to_stop, NULL, (DWORD)(microseconds / 1000), 0, 0);
}
#else
static void ask_to_stop(int signal)
{
    (void)signal;
    stop = 1;
}

static void stop_after(int microseconds)
{
    stop = 0;
    const struct itimerval timer = {{0, 0}, {0, microseconds}};
    const struct sigaction action = {.sa_handler = ask_to_stop};
    sigaction(SIGALRM, &action, NULL);
    setitimer(ITIMER_REAL, &timer, NULL);
}
#endif

static void require(int held, const char *what)
{
    if (!held) {
        fprintf(stderr, "%s\n", what);
        exit(1);
    }
}

static void *room_for(int64_t count, size_t size)
{
    void *room = malloc(count > 0 ? (size_t)count * size : 1);
    require(room != NULL, "no memory is left");
    return room;
}

/* ---- In the place of SUNDIALS ---- */

enum { MOST_MADE_UP = 128 }; /* values of a motion or of a system */

struct made_up_vector {
    int64_t size;
    double *data;
};

struct made_up_solver {
    int (*field)(double, void *, void *, void *);
    int (*jacobian)(double, void *, void *, void *, void *, void *, void *, void *);
    void *user;
    struct made_up_vector *state;
    double point, before[MOST_MADE_UP], low;
    long count;
    int (*weights)(void *state, void *found, void *user);
};

static int calls_until_failure; /* how many calls of SUNDIALS are left; negative: without end */
static int objects;             /* not freed so far */

static int fails(void) { return calls_until_failure >= 0 && calls_until_failure-- == 0; }

static void *object(size_t size)
{
    objects++;
    return calloc(1, size);
}

static void discard(void *object)
{
    objects--;
    free(object);
}

static int context_new(int communicator, void **context)
{
    (void)communicator;
    if (fails())
        return -1;
    *context = object(8);
    return 0;
}

static int forget(void **context)
{
    discard(*context);
    *context = NULL;
    return 0;
}

static int handlers_clear(void *context)
{
    (void)context;
    return fails() ? -1 : 0;
}

static void *vector_over(int64_t size, double *data, void *context)
{
    (void)context;
    if (fails())
        return NULL;
    struct made_up_vector *vector = object(sizeof *vector);
    *vector = (struct made_up_vector){size, data};
    return vector;
}

static int vector_fuse(void *vector, int on)
{
    (void)vector, (void)on;
    return fails() ? -1 : 0;
}

static double *vector_data(void *vector)
{
    return fails() ? NULL : ((struct made_up_vector *)vector)->data;
}

static void *matrix_new(int64_t rows, int64_t columns, void *context)
{
    (void)context;
    if (fails())
        return NULL;
    struct made_up_vector *matrix = object(sizeof *matrix);
    *matrix = (struct made_up_vector){rows, room_for(rows * columns, sizeof(double))};
    return matrix;
}

static void matrix_free(void *matrix)
{
    free(((struct made_up_vector *)matrix)->data);
    discard(matrix);
}

static void *linear_new(void *vector, void *matrix, void *context)
{
    (void)vector, (void)matrix, (void)context;
    return fails() ? NULL : object(8);
}

static int linear_free(void *linear)
{
    discard(linear);
    return 0;
}

static void *create(int method, void *context)
{
    (void)method, (void)context;
    return fails() ? NULL : object(sizeof(struct made_up_solver));
}

static void solver_free(void **memory) { forget(memory); }

static int init(void *memory, int (*field)(double, void *, void *, void *), double point,
                void *state)
{
    struct made_up_solver *solver = memory;
    solver->field = field;
    solver->state = state;
    solver->point = point;
    return fails() ? -1 : 0;
}

static int reinit(void *memory, double point, void *state)
{
    struct made_up_solver *solver = memory;
    solver->point = solver->low = point;
    solver->state = state;
    return fails() ? -1 : 0;
}

static int tolerances(void *memory, double rtol, void *atol)
{
    (void)memory, (void)rtol, (void)atol;
    return fails() ? -1 : 0;
}

static int weigh_by(void *memory, int (*weights)(void *state, void *found, void *user))
{
    ((struct made_up_solver *)memory)->weights = weights;
    return fails() ? -1 : 0;
}

static int user_data(void *memory, void *user)
{
    ((struct made_up_solver *)memory)->user = user;
    return fails() ? -1 : 0;
}

static int linear_use(void *memory, void *linear, void *matrix)
{
    (void)memory, (void)linear, (void)matrix;
    return fails() ? -1 : 0;
}

static int jacobian_use(void *memory, int (*jacobian)(double, void *, void *, void *, void *,
                                                      void *, void *, void *))
{
    ((struct made_up_solver *)memory)->jacobian = jacobian;
    return fails() ? -1 : 0;
}

/* One step of a fixed length; the Jacobian is asked for once, as a real solver would. */
static int solve(void *memory, double goal, void *state, double *reached, int task)
{
    static const double PARTS[] = {0.0, 0.5, 0.5, 1.0}, WEIGHTS[] = {1.0, 2.0, 2.0, 1.0};
    (void)goal, (void)task;
    struct made_up_solver *solver = memory;
    struct made_up_vector *values = state;
    const double step = 0.03;
    double now[MOST_MADE_UP], rate[MOST_MADE_UP] = {0.0}, sum[MOST_MADE_UP] = {0.0};
    const size_t count = (size_t)values->size;
    if (fails())
        return -4;
    memcpy(now, values->data, count * sizeof(double));
    memcpy(solver->before, now, count * sizeof(double));
    if (solver->weights) {
        double room[MOST_MADE_UP];
        struct made_up_vector found = {values->size, room};
        if (solver->weights(state, &found, solver->user) != 0)
            return -8;
    }
    if (solver->jacobian) {
        struct made_up_vector matrix = {values->size, room_for(values->size * values->size, 8)};
        const int status = solver->jacobian(0.0, state, state, &matrix, solver->user, NULL, NULL,
                                            NULL);
        free(matrix.data);
        if (status != 0)
            return -8;
    }
    for (int stage = 0; stage < 4; stage++) {
        double there[MOST_MADE_UP];
        for (size_t i = 0; i < count; i++)
            there[i] = now[i] + PARTS[stage] * step * rate[i];
        struct made_up_vector place = {values->size, there}, into = {values->size, rate};
        if (solver->field(0.0, &place, &into, solver->user) != 0)
            return -8;
        for (size_t i = 0; i < count; i++)
            sum[i] += WEIGHTS[stage] * rate[i] / 6.0;
    }
    for (size_t i = 0; i < count; i++)
        values->data[i] = now[i] + step * sum[i];
    solver->low = solver->point;
    solver->point += step;
    solver->count += 4;
    *reached = solver->point;
    return 0;
}

static int derivative(void *memory, double point, int order, void *vector)
{
    const struct made_up_solver *solver = memory;
    const struct made_up_vector *into = vector;
    if (fails())
        return -1;
    const double span = solver->point - solver->low, part = (point - solver->low) / span;
    for (int64_t i = 0; i < into->size; i++) {
        const double first = solver->before[i], last = solver->state->data[i];
        const double slope = order == 1 ? (last - first) / span : 0.0;
        into->data[i] = order == 0 ? first + part * (last - first) : slope;
    }
    return 0;
}

static int last_order(void *memory, int *order)
{
    (void)memory;
    *order = 1;
    return fails() ? -1 : 0;
}

static int evaluations(void *memory, long *count)
{
    *count = ((struct made_up_solver *)memory)->count;
    return fails() ? -1 : 0;
}

static const struct sundials made_up = {
    context_new, forget,      handlers_clear, vector_over, vector_fuse, discard,    vector_data,
    matrix_new,  matrix_free, vector_data,    linear_new,  linear_free, create,     solver_free,
    init,        reinit,      tolerances,     weigh_by,    user_data,   linear_use, jacobian_use,
    solve,       derivative,  last_order,     evaluations,
};

/* ---- Runs ---- */

/* How speeds change, by turns: as prescribed, piece by piece, and as a torque has it. */
static const struct piece COURSES[][3] = {
    {{0.3, 0.1, 0.0, 0.0, 0.0, 1.0},
     {0.9, -0.05, 0.0, 0.0, 0.0, 1.03},
     {INFINITY, 1e-3, .speed = 1.0}},
    {{0.4, 2.0, 0.0, 0.0, 0.0, 0.0}, {5e2, 0.0, 0.0, 0.0, 0.0, 0.8}, {INFINITY, .speed = 0.8}},
    {{INFINITY, 0.0, 3.0, 0.5, 0.2, 0.0}},
    {{INFINITY, 0.0, -1.0, 0.0, 10.0, 0.0}},
    {{INFINITY, 1e-4, 0.0, 0.0, 0.0, 2.0}},
};
static const int64_t PIECES[] = {3, 3, 1, 1, 1};
static int courses_taken;
enum { NEARLY_STEADY = -1 };

static struct run run_of(struct rotor rotor, const double start[4], double duration)
{
    struct run run = {.rotor = rotor,
                      .rtol = 1e-9,
                      .atol = 1e-11,
                      .duration = duration,
                      .exact_flight = 1,
                      .stop = &stop,
                      .where = UNDECIDED};
    memcpy(run.state, start, sizeof run.state);
    if (SPEED_CHANGES) {
        const int course = courses_taken == NEARLY_STEADY ? 4 : courses_taken % 4;
        courses_taken++;
        run.pieces = COURSES[course];
        run.piece_count = PIECES[course];
    }
    return run;
}

/* How much room the tables of a run have. */
struct room {
    int64_t samples, events, contacts, extrema;
    int32_t differences;
};

static void furnish(struct run *run, struct room room)
{
    double *times = room_for(room.samples, sizeof(double));
    for (int64_t i = 0; i < room.samples; i++)
        times[i] = run->duration * (double)i / (double)(room.samples > 1 ? room.samples - 1 : 1);
    run->sample_times = times;
    run->samples = room_for(room.samples, 4 * sizeof(double));
    run->sample_count = room.samples;
    run->event_times = room_for(room.events, sizeof(double));
    run->event_states = room_for(room.events, 4 * sizeof(double));
    run->event_kinds = room_for(room.events, 1);
    if (run->rotor.friction > 0.0)
        run->event_modes = room_for(room.events, 1);
    run->event_room = room.events;
    if (SPEED_CHANGES) {
        run->sample_turns = room_for(room.samples, 2 * sizeof(double));
        run->event_turns = room_for(room.events, 2 * sizeof(double));
    }
    run->contacts = room_for(room.contacts, sizeof(struct contact));
    run->contact_room = room.contacts;
    run->extrema = room_for(room.extrema, sizeof(struct extremum));
    run->extremum_room = room.extrema;
    run->differences = room.differences;
    run->bundle = room_for(room.differences, 4 * sizeof(double));
    for (int i = 0; i < 4 * room.differences; i++)
        run->bundle[i] = i % 5 == 0 && i < 16 ? 1.0 : 0.0;
}

static void clear(struct run *run)
{
    void *tables[] = {(void *)(uintptr_t)run->sample_times,
                      run->samples,
                      run->event_times,
                      run->event_states,
                      run->event_kinds,
                      run->event_modes,
                      run->contacts,
                      run->extrema,
                      run->bundle,
                      run->sample_turns,
                      run->event_turns};
    for (size_t i = 0; i < sizeof tables / sizeof *tables; i++)
        free(tables[i]);
}

/* Follow a run in tables of this room; return how it ended. */
static int followed(struct run run, struct room room)
{
    furnish(&run, room);
    const int status = core_run(&run);
    int64_t row = 0;
    require(run.sampled <= room.samples && run.events <= room.events
                && run.contact_count <= room.contacts && run.extremum_count <= room.extrema,
            "a table holds more than its room");
    if (status == DONE) {
        require(run.sampled == room.samples, "a sample is missing");
        core_fault(&run, 1e-6, &row);
    }
    clear(&run);
    return status;
}

/* Omega, zeta, delta0; shaft, exponent, contact damping and load; friction and radius of the disc.
 * The first few are also followed by name. */
static const struct rotor GENERAL_ROTORS[] = {{2.0, 0.07, 2.0, 0.3, 1.5, 0.4, 0.5, 0.0, 0.0},
                                              {3.0, 0.07, 0.5, 2.0, 1.0, 5.0, 1.0, 0.0, 0.0},
                                              {1.7, 0.07, 0.0, 0.5, 1.0, 0.0, 0.3, 0.0, 0.0},
                                              {0.0, 0.0, 1.0, 0.0, 1.5, 1.0, 0.0, 0.0, 0.0},
                                              {0.6, 0.0, 1e-9, 0.36, 1.5, 1e3, 1e-3, 0.0, 0.0},
                                              {1.3, 2.0, 50.0, 4.0, 1.0, 1e-300, 9.0, 0.0, 0.0},
                                              {1e3, 1e2, 1e3, 1e4, 1.0, 1e2, 1e3, 0.0, 0.0},
                                              {0.0, 0.0, 0.0, 0.0, 1.5, 0.0, 1.0, 0.0, 0.0},
                                              {0.0, 0.0, 1.0, 0.0, 1.0, 2.0, 1.0, 0.0, 0.0},
                                              {1.5, 1e-300, 2.0, 2.25, 1.5, 0.1, 0.0, 0.0, 0.0},
                                              {1.2, 0.0, 0.7, 9.0, 1.5, 20.0, 2.0, 0.0, 0.0},
                                              {0.0, 0.0, 0.3, 5.0, 1.0, 3.0, 0.0, 0.0, 0.0},
                                              {1e-200, 0.3, 1.0, 1e-20, 1.5, 0.0, 0.1, 0.0, 0.0},
                                              {1.7, 0.0, 0.0, 0.0, 1.5, 0.0, 1e300, 0.0, 0.0},
                                              {2.0, 0.07, 2.0, 0.3, 1.0, 2.0, 1.5, 0.4, 0.5},
                                              {1.2, 0.07, 0.5, 0.0, 1.5, 0.0, 0.0, 0.3, 0.6},
                                              {1e3, 1e2, 1e3, 1e4, 1.0, 1e2, 1e3, 1e3, 1e3},
                                              {0.6, 0.0, 1e-9, 0.36, 1.5, 1e3, 1e-3, 1e-300, 1e6}};
static const struct rotor PAPER_ROTORS[] = {
    {.omega = 2.0, .zeta = 0.07, .delta0 = 2.0}, {.omega = 3.0, .zeta = 0.07, .delta0 = 0.5},
    {.omega = 1.7, .zeta = 0.07, .delta0 = 0.0}, {.omega = 0.0, .zeta = 0.0, .delta0 = 1.0},
    {.omega = 0.6, .zeta = 0.0, .delta0 = 1e-9}, {.omega = 1.3, .zeta = 2.0, .delta0 = 50.0},
    {.omega = 1e3, .zeta = 1e2, .delta0 = 1e3},  {.omega = 0.0, .zeta = 0.0, .delta0 = 0.0}};
static const struct rotor *const ROTORS = IS_WHOLE ? GENERAL_ROTORS : PAPER_ROTORS;
enum { ROTOR_COUNT = (IS_WHOLE ? sizeof GENERAL_ROTORS : sizeof PAPER_ROTORS) / sizeof *ROTORS };
/* Rows of a bundle with those by parameters. */
enum { WITH_PARAMETERS = HAS_NEIGHBOURS ? 4 + PARAMETERS : 0, ALONE = HAS_NEIGHBOURS ? 4 : 0 };

/* Starts: at rest, in contact, on the ring in all ways, far off, and what is no number. */
static void start_of(int number, double delta0, double start[4])
{
    const double starts[][4] = {
        {0.0, 0.0, 0.0, 0.0},         {delta0 + 1.0, 0.3, -1.0, 0.4}, {delta0, 0.0, 0.0, 0.0},
        {0.0, delta0, 0.0, 0.0},      {delta0, 0.0, 1.0, 0.0},        {-delta0, 0.0, 1.0, 0.0},
        {delta0, 0.0, 0.0, 1.0},      {delta0, 0.0, -1e-12, 1.0},     {0.3, 0.0, 1e-300, 0.0},
        {1e6, -1e6, 1e6, 1e6},        {1e-300, 0.0, 0.0, 1e-300},     {1e200, 0.0, 0.0, 1e200},
        {1e308, 1e308, 1e308, 1e308}, {NAN, 0.0, 0.0, 0.0},           {0.3, 0.0, INFINITY, 0.0}};
    memcpy(start, starts[number], sizeof *starts);
}
enum { STARTS = 15, SOUND_STARTS = 9 };

static void runs_with_all_observers(void)
{
    const struct room everything = {31, 400, 200, 2000, WITH_PARAMETERS}, nothing = {0, 0, 0, 0, 0};
    for (int i = 0; i < ROTOR_COUNT; i++) {
        for (int number = 0; number < STARTS; number++) {
            double start[4];
            start_of(number, ROTORS[i].delta0, start);
            for (int kind = 0; kind < 6; kind++) {
                struct run run = run_of(ROTORS[i], start, kind % 3 == 0 ? 3.0 : 0.5);
                run.fixed_axes = kind % 2;
                run.slack = kind == 3 ? 1e-8 : 0.0;
                run.rtol = kind == 4 ? 1e-15 : 1e-9;
                run.exact_flight = kind < 5;
                stop_after(8000);
                const int status = followed(run, kind == 2 ? nothing : everything);
                const int fair = number < SOUND_STARTS && ROTORS[i].omega < 100.0
                                 && ROTORS[i].load < 100.0 && !stop;
                require(!fair || status == DONE || status == STALLED,
                        "a run of everyday did not end");
            }
        }
    }
}

/* Starts in a contact that is pulled loose and presses again; count how often the table of events
 * is full there. */
static int releases_in_rooms_that_are_too_small(void)
{
    int full_inside = 0;
    for (int number = 0; number < 8; number++) {
        const double start[4] = {2.0 + number, 0.1, number % 2 ? -9.0 : 3.0, 1.0};
        for (int64_t size = 0; size < 9; size++) {
            stop_after(25000);
            const struct run run = run_of(ROTORS[ROTOR_COUNT - 1 - number % 5], start, 9.0);
            full_inside += followed(run, (struct room){3, size, 40, 40, ALONE}) == FULL_INSIDE;
        }
    }
    return full_inside;
}

static void runs_in_rooms_that_are_too_small(void)
{
    const double start[4] = {0.0};
    int full_inside = 0;
    for (int i = 0; i < ROTOR_COUNT; i++) {
        for (int64_t size = 0; size < 6; size++) {
            stop_after(25000);
            const struct run run = run_of(ROTORS[i], start, 10.0);
            full_inside += followed(run, (struct room){size, size, 400, 0, 0}) == FULL_INSIDE;
            followed(run, (struct room){size, size, size, size, 0});
            followed(run, (struct room){size, 0, 0, size, ALONE});
            followed(run, (struct room){0, size, 400, 0, WITH_PARAMETERS});
            followed(run, (struct room){0, 400, size, 0, 0});
        }
    }
    if (IS_WHOLE)
        full_inside += releases_in_rooms_that_are_too_small();
    require((full_inside > 0) == IS_WHOLE, "a table was full in a contact, or never was");
    /* with more room a run goes on from where it stands */
    stop_after(900000);
    courses_taken = NEARLY_STEADY;
    struct run run = run_of(ROTORS[0], start, 60.0);
    furnish(&run, (struct room){9, 64, 64, 0, ALONE});
    run.event_room = run.contact_room = 2;
    int again = 0;
    int status;
    for (; (status = core_run(&run)) == FULL; again++)
        run.event_room = run.contact_room = run.event_room + 2;
    require(status == DONE && again > 2 && run.sampled == 9 && run.events > 4,
            "a run did not go on");
    clear(&run);
}

static void runs_of_odd_lengths(void)
{
    const double lengths[] = {0.0, -1.0, 5e-324, 1e-300, 1e-17, 1e9, INFINITY, NAN};
    const double tolerances_asked[] = {1e-9, 0.0, -1.0, 1e-300, 1.0, 1e300, NAN};
    for (size_t i = 0; i < sizeof lengths / sizeof *lengths; i++) {
        for (size_t j = 0; j < sizeof tolerances_asked / sizeof *tolerances_asked; j++) {
            for (int number = 0; number < 5; number++) {
                double start[4];
                start_of(number, 2.0, start);
                struct run run = run_of(ROTORS[number == 4 ? 2 : 0], start, lengths[i]);
                run.rtol = tolerances_asked[j];
                run.atol = tolerances_asked[j];
                furnish(&run, (struct room){0, 64, 64, 64, ALONE});
                stop_after(5000);
                core_run(&run);
                clear(&run);
            }
        }
    }
    stop = 1;
    double start[4] = {0.0};
    struct run run = run_of(ROTORS[0], start, 9.0);
    require(core_run(&run) == STOPPED, "a run that was asked to stop went on");
    stop_after(8000);
    run = run_of(ROTORS[0], start, 1e12);
    require(core_run(&run) == STOPPED, "a long run did not stop");
    run = run_of(ROTORS[0], start, 9.0);
    run.method = ADAMS;
    require(core_run(&run) == NO_SOLVER, "there was a solver");
}

/* Each call of SUNDIALS fails in turn; all objects are freed, whatever happened. */
static void runs_by_a_solver_that_fails(void)
{
    double start[4];
    for (int kind = 0; kind < 6; kind++) {
        int ended = -1;
        for (calls_until_failure = 0; ended != DONE;) {
            const int call = calls_until_failure;
            start_of(1, 2.0, start);
            struct run run = run_of(ROTORS[kind % 3], start, 0.4);
            run.method = kind % 2 ? ADAMS : BDF;
            run.exact_flight = kind < 3;
            run.sundials = &made_up;
            stop = 0;
            ended = followed(run, (struct room){3, 64, 64, 64, kind > 3 ? ALONE : 0});
            require(objects == 0, "an object of SUNDIALS was not freed");
            if (calls_until_failure >= 0)
                break; /* all calls were made, and none failed */
            require(ended != DONE, "a failure of SUNDIALS was passed over");
            calls_until_failure = call + 1;
            ended = -1;
            require(call < 100000, "the calls have no end");
        }
    }
    calls_until_failure = -1;
    for (int i = 0; i < ROTOR_COUNT; i++) {
        for (int number = 0; number < STARTS; number++) {
            start_of(number, ROTORS[i].delta0, start);
            struct run run = run_of(ROTORS[i], start, 3.0);
            run.method = ADAMS;
            run.exact_flight = number % 2;
            run.sundials = &made_up;
            stop_after(10000);
            followed(run, (struct room){40, 400, 200, 400, 0});
            require(objects == 0, "an object of SUNDIALS was not freed");
        }
    }
}

static void stretches(void)
{
    double start[4];
    for (int i = 0; i < ROTOR_COUNT; i++) {
        for (int number = 0; number < STARTS; number++) {
            start_of(number, ROTORS[i].delta0, start);
            struct run run = run_of(ROTORS[i], start, 0.5);
            furnish(&run, (struct room){0, 0, 0, 0, 4});
            double *rows = room_for(20, STRETCH_COLUMNS * sizeof(double));
            int64_t done = 0;
            stop_after(10000);
            core_stretch(&run, 20, rows, &done);
            require(0 <= done && done <= 20, "there are more spans than were asked for");
            core_stretch(&run, 0, rows, &done);
            require(done == 0, "a span was followed that was not asked for");
            free(rows);
            clear(&run);
        }
    }
}

static void single_states(void)
{
    const double spans[] = {0.0, 1e-300, 1.0, 1e6, 1e300, -1.0, INFINITY, NAN};
    enum { SPANS = sizeof spans / sizeof *spans };
    for (int i = 0; i < ROTOR_COUNT; i++) {
        for (int number = 0; number < STARTS; number++) {
            double start[4], *states = room_for(SPANS, 4 * sizeof(double));
            double *reached = room_for(SPANS, 4 * sizeof(double));
            start_of(number, ROTORS[i].delta0, start);
            core_starts_in_contact(&ROTORS[i], start);
            for (int j = 0; j < SPANS; j++)
                memcpy(&states[4 * j], start, sizeof start);
            core_fly(&ROTORS[i], states, spans, reached, SPANS);
            core_fly(&ROTORS[i], states, spans, reached, 0);
            core_rotate(states, spans, ROTORS[i].omega, SPANS);
            core_rotate(states, spans, ROTORS[i].omega, 0);
            for (int j = 0; j < SPANS; j++) {
                stop_after(5000);
                core_first_touch(&ROTORS[i], start, spans[j], &stop);
            }
            free(states);
            free(reached);
        }
    }
}

/* ---- Lanes, which know no speed that changes ---- */

#ifndef RUN_UP
enum { LANES_OF_KERNEL = 64, REGION = 14, SECTION = 21 };

static double uniform(void) { return 8.0 * (double)rand() / RAND_MAX - 4.0; }

/* Numbers that lie in a table of their own. */
static double *table_of(int64_t count, double first, double others)
{
    double *table = room_for(count, sizeof(double));
    for (int64_t i = 0; i < count; i++)
        table[i] = i % SECTION == 0 ? first : others;
    return table;
}

static void lanes(void)
{
    const int64_t counts[] = {0, 1, LANES_OF_KERNEL - 1, LANES_OF_KERNEL, LANES_OF_KERNEL + 1, 200};
    for (size_t c = 0; c < sizeof counts / sizeof *counts; c++) {
        for (int kind = 0; kind < 12; kind++) { /* the last ones rub */
            const int64_t count = counts[c], regions = kind % 3, sections = kind % 2;
            const struct rotor rotor = ROTORS[kind < 8 ? kind : ROTOR_COUNT + 7 - kind];
            double *states = room_for(4 * count, sizeof(double));
            int16_t *labels = room_for(count, sizeof(int16_t));
            float *times = room_for(count, sizeof(float));
            double *region = table_of(REGION * regions, 0.1, kind == 2 ? NAN : 0.5);
            double *section = table_of(SECTION * sections, 0.2, kind == 5 ? 0.0 : 0.7);
            const double whirl[4] = {-0.9, -0.1, kind % 2 ? 0.3 : -1.0, 2.0};
            for (int64_t i = 0; i < 4 * count; i++)
                states[i] = kind == 4 && i % 7 == 0 ? NAN : kind == 6 ? 1e200 : uniform();
            for (int64_t i = 0; i < count; i++) {
                labels[i] = i % 5 == 0 ? 3 : -2;
                times[i] = 0.0F;
            }
            stop_after(10000);
            core_follow_lanes(&rotor, states, labels, times, count, region, regions, whirl, section,
                              sections, kind == 7 ? INFINITY : 3.0, kind == 3 ? 0.0 : 1e-6, &stop);
            double *values = room_for(count, sizeof(double)), *one = table_of(SECTION, 0.2, 0.7);
            stop_after(10000);
            core_measure_returns(&rotor, states, count, one, 0.5, kind == 7 ? INFINITY : 3.0, 1e-6,
                                 values, &stop);
            stop = 1;
            core_measure_returns(&rotor, states, count, one, 0.5, 3.0, 1e-6, values, &stop);
            free(one);
            free(values);
            free(section);
            free(region);
            free(times);
            free(labels);
            free(states);
        }
    }
}

#else
static void lanes(void) {}
#endif

/* Systems of odd sizes, with and without each matrix, in tables that are filled again and again;
 * they are in the whole model alone. */
#if defined(WHOLE_MODEL) && !defined(RUN_UP)
enum { ROWS = 8, MOST = 16, KINDS = 72, PARAMETERS_OF_SYSTEM = 2, WATCHED_ROWS = 3 };

/* Numbers of any size in a table of their own. */
static double *random_table(int64_t count)
{
    double *table = room_for(count, sizeof(double));
    for (int64_t i = 0; i < count; i++)
        table[i] = 0.1 * uniform();
    return table;
}

/* What a run with columns has beside, each in a table to the last byte. */
struct beside {
    double *columns, *room, *watched, *at_samples, *at_events, *matrix, *rows;
    struct law_change laws[MOST];
    struct parameter parameters[PARAMETERS_OF_SYSTEM];
};

/* Give a run small changes of its start, of which the last are by parameters. */
static void add_columns(struct system_run *run, int kind, struct beside *beside)
{
    const int64_t count = 8 * (1 + kind % 7), long_one = 2 * run->size + run->contact_count;
    beside->columns = random_table(long_one * count);
    beside->room = room_for(core_system_column_room(run->size, run->contact_count, count),
                            sizeof(double));
    beside->watched = random_table(WATCHED_ROWS * run->stride);
    beside->at_samples = room_for(run->sample_count * WATCHED_ROWS * count, sizeof(double));
    beside->at_events = room_for(2 * ROWS * count, sizeof(double));
    beside->matrix = random_table(run->size * run->stride);
    beside->rows = random_table(2 * run->stride);
    for (int i = 0; i < MOST; i++)
        beside->laws[i] = (struct law_change){1.0, 0.5, 0.3, 0.2};
    beside->parameters[0] = (struct parameter){.stiffness = beside->matrix,
                                               .damping = beside->matrix,
                                               .unbalance = beside->rows,
                                               .laws = beside->laws,
                                               .mass = beside->matrix,
                                               .force = beside->rows};
    beside->parameters[1] = (struct parameter){.speed = 1.0, .laws = beside->laws};
    run->column_count = count;
    run->columns = beside->columns;
    run->column_room = beside->room;
    run->parameters = beside->parameters;
    run->parameter_count = kind % 3;
    run->first_of_parameters = count - run->parameter_count - kind % 2;
    run->watched = beside->watched;
    run->watched_count = WATCHED_ROWS;
    run->sample_columns = beside->at_samples;
    run->event_columns = beside->at_events;
}

static void remove_columns(struct beside *beside)
{
    double *tables[] = {beside->columns,   beside->room,   beside->watched, beside->at_samples,
                        beside->at_events, beside->matrix, beside->rows};
    for (size_t i = 0; i < sizeof tables / sizeof *tables; i++)
        free(tables[i]);
}

static void systems(void)
{
    srand(1); /* the same systems, whatever was exercised before */
    for (int kind = 0; kind < KINDS; kind++) {
        const int64_t size = kind == 0 ? 2 : 2 + 7 * (kind % 5),
                      stride = core_system_stride(size);
        const int64_t contacts = kind % 4, square = size * stride, width = 2 * stride + contacts;
        const int64_t samples = kind % 3 == 0 ? 0 : 20;
        double *matrices = room_for(4 * square, sizeof(double));
        for (int64_t i = 0; i < 4 * square; i++)
            matrices[i] = kind == 7 ? NAN : i % stride < size ? 0.3 * (uniform() - 0.5) : 0.0;
        const int has_modes = kind % 15 == 9; /* a stiffness with nothing but its diagonal */
        for (int64_t i = 0; i < square && has_modes; i++)
            matrices[i] = 0.0;
        for (int64_t i = 0; i < size; i++)
            matrices[i * stride + i] += 2.0;
        double *vectors = room_for((3 + 2 * contacts) * stride, sizeof(double));
        for (int64_t i = 0; i < (3 + 2 * contacts) * stride; i++)
            vectors[i] = i % stride < size ? uniform() : 0.0;
        struct system_law laws[MOST] = {0};
        struct system_touch touches[MOST] = {0};
        struct race races[MOST] = {0};
        struct episode open[MOST] = {0}, *episodes = room_for(ROWS, sizeof(struct episode));
        for (int64_t i = 0; i < contacts; i++)
            laws[i] = (struct system_law){.clearance = 0.1 + 0.2 * uniform(),
                                          .hertz = 30.0 * (kind % 2),
                                          .linear = 30.0 * (kind % 2 == 0),
                                          .contact_damping = kind % 3,
                                          .friction = 0.3 * (kind % 5 > 1),
                                          .radius = 1.0,
                                          .race_radius = kind % 7 == 1,
                                          .inverse_race_inertia = kind % 7 == 1,
                                          .race_drag = 0.1};
        const int has_columns = kind >= 24 && kind % 3 != 2, is_centred = kind % 5 == 3;
        if (is_centred && contacts > 0)
            laws[0].clearance = 0.0;
        const int64_t places = kind % 4 ? kind % 3 : 0, extrema = (ORDERS + 1) * places;
        struct place observed[2] = {{.centre = {0.1, -0.1}}, {.centre = {0.0, 0.0}}};
        double *by_place = random_table(2 * places * stride);
        struct extremum_of_place *farthest = room_for(extrema, sizeof *farthest);
        struct beside beside = {0};
        struct piece pieces[] = {{1.0, kind % 3 == 1 ? 0.5 : 0.0, 1.0, 0.3, kind % 3 == 2, 1.2},
                                 {9.0, 0.0, 1.0, 0.3, kind % 3 == 2, 1.7}};
        double *state = room_for(2 * stride, sizeof(double)), times[20];
        memset(state, 0, sizeof(double) * (size_t)(2 * stride));
        for (int i = 0; i < 20; i++)
            times[i] = 0.3 * i;
        double *sampled = room_for(samples * (2 * stride + 4 * contacts + 2), sizeof(double));
        double *events = room_for(ROWS * (width + 4), sizeof(double));
        int32_t *kinds = room_for(2 * ROWS, sizeof(int32_t));
        double *room = room_for(core_system_room(size, contacts), sizeof(double));
        double *cvode_room = room_for(core_system_cvode_room(size, contacts), sizeof(double));
        /* two bearings whose table a speed may leave */
        const double knots[] = {0.9, 1.2, 1.3, 1.6, 1.9};
        double *bearing_room = room_for(core_system_bearing_room(2, 56), sizeof(double));
        double cubics[4 * BEARING_POWERS * BEARING_ENTRIES];
        for (size_t i = 0; i < sizeof cubics / sizeof *cubics; i++)
            cubics[i] = 0.1 * uniform();
        struct system_bearing bearings[] = {{vectors, knots, cubics, 5, 0},
                                            {vectors, knots, cubics, 5, 1}};
        calls_until_failure = kind % 8 == 5 ? 200 : -1;
        struct system_run run = {.size = size,
                                 .stride = stride,
                                 .contact_count = contacts,
                                 .stiffness = matrices,
                                 .damping = kind % 2 ? matrices + square : NULL,
                                 .gyroscopic = kind % 3 ? matrices + 2 * square : NULL,
                                 .stiffness_rate = kind % 4 ? matrices + 3 * square : NULL,
                                 .unbalance = vectors,
                                 .force = vectors + 2 * stride,
                                 .rows = vectors + 3 * stride,
                                 .laws = laws,
                                 .touches = touches,
                                 .pieces = pieces,
                                 .piece_count = 2,
                                 .inertia = 9.0 * size,
                                 .rtol = kind == 9 ? 0.0 : 1e-10,
                                 .displacement = 0.1,
                                 .velocity = 0.1,
                                 .fastest = 3.0,
                                 .bearings = bearings,
                                 .bearing_count = kind % 4 == 1 ? 2 : 0,
                                 .bearing_room = bearing_room,
                                 .order = kind % 2 ? HIGHEST_ORDER : 12,
                                 .duration = kind == 11 ? 0.0 : 6.0,
                                 .stop = &stop,
                                 .speed = 1.2,
                                 .state = state,
                                 .sample_times = times,
                                 .samples = sampled,
                                 .sample_forces = sampled + samples * 2 * stride,
                                 .sample_turns = sampled + samples * (2 * stride + 4 * contacts),
                                 .sample_count = samples,
                                 .event_times = events,
                                 .event_turns = events + ROWS,
                                 .event_rates = events + 3 * ROWS,
                                 .event_states = events + 4 * ROWS,
                                 .event_kinds = kinds,
                                 .event_contacts = kinds + ROWS,
                                 .event_room = ROWS,
                                 .episodes = episodes,
                                 .open = open,
                                 .races = races,
                                 .episode_room = ROWS,
                                 .room = room,
                                 .method = kind / 4 % 2 && !has_columns && !is_centred ? ADAMS
                                                                                       : TAYLOR,
                                 .sundials = &made_up,
                                 .cvode_room = cvode_room,
                                 .place_rows = by_place,
                                 .places = observed,
                                 .place_count = places,
                                 .extrema = farthest,
                                 .extremum_room = extrema};
        if (has_columns)
            add_columns(&run, kind, &beside);
        stop_after(50000);
        while (core_system_run(&run) == FULL)
            run.events = run.episode_count = run.extremum_count = 0; /* which are written over */
        require(objects == 0, "an object of SUNDIALS was not freed");
        require(run.extremum_count <= extrema, "there are more extrema than their room");
        calls_until_failure = -1;
        remove_columns(&beside);
        free(farthest);
        free(by_place);
        free(cvode_room);
        free(room);
        free(kinds);
        free(events);
        free(bearing_room);
        free(sampled);
        free(state);
        free(episodes);
        free(vectors);
        free(matrices);
    }
}
#else
static void systems(void) {}
#endif

int main(void)
{
    calls_until_failure = -1;
    require(core_version()[0] && core_compiler() && core_flags() && core_level() && core_model()
                && core_sources(),
            "the core does not say what it is");
    require(core_widest_level() >= 0, "the processor has no level");
    runs_with_all_observers();
    runs_in_rooms_that_are_too_small();
    runs_of_odd_lengths();
    runs_by_a_solver_that_fails();
    if (!SPEED_CHANGES) {
        stretches();
        single_states();
        lanes();
        systems();
    }
    puts("done");
    return 0;
}
