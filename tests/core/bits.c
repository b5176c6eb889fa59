/* Results of every kind from one library of the core, each as the hash of its bits.
 *
 * `tests/platforms.py` compares what this says on several systems. Steps are by Taylor series. */
#include <inttypes.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "system.h"

enum { SAMPLES = 200, ROOM = 4096, STARTS = 256, SPANS = 20, SIZE = 4, CONTACTS = 2, SEED = 1 };
static stop_flag stop;

static void tell(const char *kind, int number, const char *what, const void *data, int64_t count,
                 size_t size)
{
    uint64_t hash = 14695981039346656037U; /* by Fowler, Noll and Vo */
    for (size_t i = 0; i < (size_t)count * size; i++)
        hash = (hash ^ ((const unsigned char *)data)[i]) * 1099511628211U;
    printf("%s %d %s %" PRId64 " %016" PRIx64 "\n", kind, number, what, count, hash);
}

static void *table(int64_t count, size_t size)
{
    void *room = calloc((size_t)count, size);
    if (room == NULL)
        exit(1);
    return room;
}

/* The paper's, then omega, zeta, delta0; shaft, exponent, contact damping, load; friction, radius.
 */
static const struct rotor ROTORS[] = {
    {.omega = 2.0, .zeta = 0.07, .delta0 = 2.0, .contact_exponent = 1.5},
    {.omega = 3.0, .zeta = 0.07, .delta0 = 0.5, .contact_exponent = 1.5},
    {.omega = 1.7, .zeta = 0.07, .delta0 = 0.0, .contact_exponent = 1.5},
    {.omega = 1.38, .zeta = 0.07, .delta0 = 1.0, .contact_exponent = 1.5},
#ifdef WHOLE_MODEL
    {2.0, 0.07, 2.0, 0.3, 1.5, 0.4, 0.5, 0.0, 0.0, .rate = 0.0},
    {3.0, 0.07, 0.5, 2.0, 1.0, 5.0, 1.0, 0.0, 0.0, .rate = 0.0},
    {2.0, 0.07, 2.0, 0.3, 1.0, 2.0, 1.5, 0.4, 0.5, .rate = 0.0},
    {1.2, 0.07, 0.5, 0.0, 1.5, 0.0, 0.0, 0.3, 0.6, .rate = 0.0},
#endif
};
static const double BEGUN[][4] = {{0.0, 0.0, 0.0, 0.0}, {3.0, 1.0, -0.3, 0.4}};

static struct run run_of(const struct rotor *rotor, const double start[4], double duration)
{
    static const struct piece COURSES[] = {{INFINITY, 0.02, .speed = 1.0},
                                           {INFINITY, 0.0, 3.0, 0.5, 0.05, 0.0}};
    static int turn;
    struct run run = {.rotor = *rotor,
                      .rtol = 1e-9,
                      .atol = 1e-11,
                      .duration = duration,
                      .exact_flight = HAS_CLOSED_FLIGHT,
                      .stop = &stop,
                      .where = UNDECIDED};
    memcpy(run.state, start, sizeof run.state);
    if (SPEED_CHANGES) {
        run.pieces = &COURSES[turn++ % 2];
        run.piece_count = 1;
    }
    return run;
}

static void runs(int number, const double start[4])
{
    struct run run = run_of(&ROTORS[number], start, 60.0);
    double *times = table(SAMPLES, sizeof *times);
    for (int i = 0; i < SAMPLES; i++)
        times[i] = run.duration * i / (SAMPLES - 1);
    run.sample_times = times;
    run.sample_count = SAMPLES;
    run.samples = table(SAMPLES, 4 * sizeof(double));
    run.sample_turns = table(SAMPLES, 2 * sizeof(double));
    run.event_room = run.contact_room = run.extremum_room = ROOM;
    run.event_times = table(ROOM, sizeof(double));
    run.event_states = table(ROOM, 4 * sizeof(double));
    run.event_kinds = table(ROOM, 1);
    run.event_modes = run.rotor.friction > 0.0 ? table(ROOM, 1) : NULL;
    run.event_turns = table(ROOM, 2 * sizeof(double));
    run.contacts = table(ROOM, sizeof(struct contact));
    run.extrema = table(ROOM, sizeof(struct extremum));
    run.differences = HAS_NEIGHBOURS ? 4 : 0;
    run.bundle = table(4, 4 * sizeof(double));
    for (int i = 0; i < 4; i++)
        run.bundle[5 * i] = 1.0;
    const int status = core_run(&run);
    tell("run", number, "status", &status, 1, sizeof status);
    tell("run", number, "samples", run.samples, run.sampled, 4 * sizeof(double));
    tell("run", number, "turns", run.sample_turns, SPEED_CHANGES ? run.sampled : 0,
         2 * sizeof(double));
    tell("run", number, "times", run.event_times, run.events, sizeof(double));
    tell("run", number, "states", run.event_states, run.events, 4 * sizeof(double));
    tell("run", number, "kinds", run.event_kinds, run.events, 1);
    tell("run", number, "contacts", run.contacts, run.contact_count, sizeof(struct contact));
    tell("run", number, "extrema", run.extrema, run.extremum_count, sizeof(struct extremum));
    tell("run", number, "bundle", run.bundle, run.differences, 4 * sizeof(double));
    void *tables[] = {times,           run.samples,      run.sample_turns,
                      run.event_times, run.event_states, run.event_kinds,
                      run.event_modes, run.event_turns,  run.contacts,
                      run.extrema,     run.bundle};
    for (size_t i = 0; i < sizeof tables / sizeof *tables; i++)
        free(tables[i]);
}

#ifndef RUN_UP
/* The same numbers on every system, from -1 to 1. */
static double uniform(void)
{
    static uint32_t state = SEED;
    state = 1664525U * state + 1013904223U;
    return (double)(state >> 8) / 8388608.0 - 1.0;
}

static void many_starts(int number)
{
    const struct rotor *rotor = &ROTORS[number];
    const double whirl[4] = {0.0, 0.0, -1.0, 0.0};
    static double states[4 * STARTS], spans[STARTS], reached[4 * STARTS];
    static int16_t labels[STARTS];
    static float times[STARTS];
    for (int i = 0; i < STARTS; i++) {
        spans[i] = 100.0 * (1.0 + uniform());
        labels[i] = -1;
        times[i] = 0.0F;
    }
    for (int i = 0; i < 4 * STARTS; i++)
        states[i] = (rotor->delta0 + 1.0) * uniform();
    core_fly(rotor, states, spans, reached, STARTS);
    tell("flight", number, "states", reached, STARTS, 4 * sizeof(double));
    core_rotate(reached, spans, rotor->omega, STARTS);
    tell("turned", number, "states", reached, STARTS, 4 * sizeof(double));
    for (int i = 0; i < STARTS; i++) {
        const double inside[4] = {0.4 * rotor->delta0 * uniform(), 0.4 * rotor->delta0 * uniform(),
                                  uniform(), uniform()};
        spans[i] = rotor->delta0 > 0.0 ? core_first_touch(rotor, inside, 50.0, &stop) : 0.0;
    }
    tell("touch", number, "times", spans, STARTS, sizeof(double));
    core_follow_lanes(rotor, states, labels, times, STARTS, NULL, 0, whirl, NULL, 0, 30.0, 1e-6,
                      &stop);
    tell("lanes", number, "states", states, STARTS, 4 * sizeof(double));
    tell("lanes", number, "labels", labels, STARTS, sizeof *labels);
}

static void stretches(int number)
{
    double rows[SPANS * STRETCH_COLUMNS] = {0.0}, bundle[16] = {0.0};
    int64_t done = 0;
    for (int i = 0; i < 4; i++)
        bundle[5 * i] = 1.0;
    struct run run = run_of(&ROTORS[number], BEGUN[1], 2.0);
    run.differences = 4;
    run.bundle = bundle;
    core_stretch(&run, SPANS, rows, &done);
    tell("stretch", number, "factors", rows, done, STRETCH_COLUMNS * sizeof(double));
}
#endif

#if defined(WHOLE_MODEL) && !defined(RUN_UP)
/* Two stations with gyroscopic coupling, an unbalance, and contacts with friction and damping. */
static void system_runs(int number)
{
    double stiffness[16] = {0.0}, damping[16] = {0.0}, gyroscopic[16] = {0.0}, state[8] = {0.0};
    double unbalance[8] = {1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0}, force[4] = {0.1, 0.0, 0.0, 0.0};
    double rows[16] = {[0] = 1.0, [5] = 1.0, [10] = 1.0, [15] = 1.0}, times[SAMPLES];
    for (int i = 0; i < SIZE; i++) {
        stiffness[5 * i] = 1.5;
        stiffness[4 * i + (i + 2) % 4] = -0.7;
        damping[5 * i] = 0.1;
        gyroscopic[4 * i + (i ^ 1)] = i % 2 ? 0.2 : -0.2;
    }
    struct system_law laws[CONTACTS] = {
        {.clearance = 0.5, .hertz = 20.0, .friction = 0.2, .radius = 2.0, .contact_damping = 0.3}};
    laws[1] = laws[0];
    if (number == 1)
        laws[0].clearance = 0.0;
    if (number == 2)
        laws[0].race_radius = laws[0].inverse_race_inertia = 2.0;
    struct system_touch touches[CONTACTS] = {0};
    struct race races[CONTACTS] = {0};
    struct episode open[CONTACTS] = {0};
    const struct piece piece = {INFINITY, number == 3 ? 0.02 : 0.0, .speed = 1.1};
    for (int i = 0; i < SAMPLES; i++)
        times[i] = 0.4 * i;
    struct system_run run = {.size = SIZE,
                             .stride = SIZE,
                             .contact_count = CONTACTS,
                             .stiffness = stiffness,
                             .damping = damping,
                             .gyroscopic = gyroscopic,
                             .unbalance = unbalance,
                             .force = force,
                             .rows = rows,
                             .laws = laws,
                             .touches = touches,
                             .pieces = &piece,
                             .piece_count = 1,
                             .rtol = 1e-10,
                             .displacement = 0.1,
                             .velocity = 0.1,
                             .fastest = 3.0,
                             .order = 18,
                             .duration = 0.4 * (SAMPLES - 1),
                             .stop = &stop,
                             .speed = 1.1,
                             .state = state,
                             .sample_times = times,
                             .sample_count = SAMPLES,
                             .event_room = ROOM,
                             .episode_room = ROOM,
                             .open = open,
                             .races = races};
    run.samples = table(SAMPLES, 2 * SIZE * sizeof(double));
    run.sample_forces = table(SAMPLES, 4 * CONTACTS * sizeof(double));
    run.sample_turns = table(SAMPLES, 2 * sizeof(double));
    run.event_times = table(ROOM, sizeof(double));
    run.event_turns = table(ROOM, 2 * sizeof(double));
    run.event_rates = table(ROOM, sizeof(double));
    run.event_states = table(ROOM, (2 * SIZE + CONTACTS) * sizeof(double));
    run.event_kinds = table(ROOM, sizeof(int32_t));
    run.event_contacts = table(ROOM, sizeof(int32_t));
    run.episodes = table(ROOM, sizeof(struct episode));
    run.room = table(core_system_room(SIZE, CONTACTS), sizeof(double));
    const int status = core_system_run(&run);
    tell("system", number, "status", &status, 1, sizeof status);
    tell("system", number, "samples", run.samples, run.sampled, 2 * SIZE * sizeof(double));
    tell("system", number, "forces", run.sample_forces, run.sampled, 4 * CONTACTS * sizeof(double));
    tell("system", number, "times", run.event_times, run.events, sizeof(double));
    tell("system", number, "episodes", run.episodes, run.episode_count, sizeof(struct episode));
    tell("system", number, "ledger", &run.ledger, 1, sizeof run.ledger);
    void *tables[] = {run.samples,        run.sample_forces, run.sample_turns, run.event_times,
                      run.event_turns,    run.event_rates,   run.event_states, run.event_kinds,
                      run.event_contacts, run.episodes,      run.room};
    for (size_t i = 0; i < sizeof tables / sizeof *tables; i++)
        free(tables[i]);
}
#endif

int main(void)
{
    printf("%s %s\n", core_model(), core_sources());
    for (int number = 0; number < (int)(sizeof ROTORS / sizeof *ROTORS); number++) {
        runs(number, BEGUN[0]);
        runs(number, BEGUN[1]);
#ifndef RUN_UP
        many_starts(number);
        stretches(number);
#endif
    }
#if defined(WHOLE_MODEL) && !defined(RUN_UP)
    for (int number = 0; number < 4; number++)
        system_runs(number);
#endif
    return 0;
}
