/* What the coefficients of one contact step cost, and what a dot product's multiply-adds cost.
 *
 *     series order repetitions
 *
 * prints seconds (clock, processor) of one expansion up to that order, then of one multiply-add of
 * a dot product whose vectors lie in the nearest cache. Compiled with the core's `derived.c`. */
#define _POSIX_C_SOURCE 199309L /* clock_gettime */
#include <stdio.h>
#include <stdlib.h>
#include <time.h>

#include "motion.h"

enum { NUMBERS = 1024, SUMS = 8 };
static const double STATE[] = {0.8, 0.1, 1.5, 0.6, 0.8, 0.0, 0.0};

struct moment {
    double clock, processor;
};

static double seconds(clockid_t clock)
{
    struct timespec moment;
    clock_gettime(clock, &moment);
    return (double)moment.tv_sec + 1e-9 * (double)moment.tv_nsec;
}

static struct moment now(void)
{
    return (struct moment){seconds(CLOCK_MONOTONIC), seconds(CLOCK_PROCESS_CPUTIME_ID)};
}

static void print_since(struct moment began, double count)
{
    const struct moment ended = now();
    printf("%.9e %.9e\n", (ended.clock - began.clock) / count,
           (ended.processor - began.processor) / count);
}

/* The first coefficient is changed by the last result, so that no repetition can be left out. */
static double expand(int order, long repetitions)
{
    static struct series series;
    const struct parameters model = {.omega = 1.2, .zeta = 0.07, .delta0 = 0.5, .felt = 1.0};
    double left = 0.0;
    for (long i = 0; i < repetitions; i++) {
        memcpy(series.terms[0], STATE, sizeof STATE);
        series.terms[0][CONTACT_Q] += 1e-30 * left;
        contact_mode.expand(&model, &series, order);
        left = series.terms[order][0];
    }
    return left;
}

static double dot_product(long repetitions)
{
    static _Alignas(32) double left[NUMBERS], right[NUMBERS];
    for (int i = 0; i < NUMBERS; i++)
        left[i] = right[i] = 1.0;
    double total = 0.0;
    for (long i = 0; i < repetitions; i++) {
        left[0] = 1.0 + 1e-30 * total;
        vec4 sums[SUMS] = {{0.0}};
        for (int j = 0; j < NUMBERS; j += 4 * SUMS) {
            for (int k = 0; k < SUMS; k++)
                sums[k] = fma4(load(&left[j + 4 * k]), load(&right[j + 4 * k]), sums[k]);
        }
        vec4 sum = spread(0.0);
        for (int k = 0; k < SUMS; k++)
            sum += sums[k];
        total += sum[0] + sum[1] + sum[2] + sum[3];
    }
    return total;
}

int main(int count, char **given)
{
    if (count != 3)
        return 1;
    const int order = atoi(given[1]);
    const long repetitions = atol(given[2]);
    struct moment began = now();
    volatile double kept = expand(order, repetitions);
    print_since(began, (double)repetitions);
    began = now();
    kept = dot_product(repetitions);
    (void)kept;
    print_since(began, (double)repetitions * NUMBERS);
    return 0;
}
