/* What the model of this library has: constants, by which the compiler removes what it lacks.
 *
 * A library knows one model: the paper's rotor; the whole one, with a shaft, a load, another law
 * of contact and friction; or that with a speed that changes. `hatch_build.py` chooses it. It asks
 * the preprocessor here, and elsewhere stands `if (HAS_FRICTION)`; only the derived files ask it
 * too, whether they are compiled at all. A name that only another model has is declared all the
 * same, and 0 (see the derived headers). A new force of the whole model needs a constant of its own
 * here only where C that is written by hand must leave it out of the paper's rotor; and flight has
 * a closed form no more, unless flight.c gets that of the new force (HAS_CLOSED_FLIGHT). */
#ifndef ROTOR_IDA_MODEL_H
#define ROTOR_IDA_MODEL_H

#ifdef WHOLE_MODEL
enum { IS_WHOLE = 1 };
#else
enum { IS_WHOLE = 0 };
#endif

#ifdef RUN_UP
enum { SPEED_CHANGES = 1 };
#define DERIVED_HEADER "derived_run_up.h"
#else
enum { SPEED_CHANGES = 0 };
#ifdef WHOLE_MODEL
#define DERIVED_HEADER "derived_whole.h"
#else
#define DERIVED_HEADER "derived.h"
#endif
#endif

enum {
    HAS_SHAFT = IS_WHOLE,
    HAS_LOAD = IS_WHOLE,
    HAS_CONTACT_DAMPING = IS_WHOLE,
    HAS_LINEAR_CONTACT = IS_WHOLE, /* beside Hertz's */
    HAS_FRICTION = IS_WHOLE,
    /* a speed that changes has no closed form of flight, and no neighbours are followed beside it
     */
    HAS_CLOSED_FLIGHT = !SPEED_CHANGES,
    HAS_NEIGHBOURS = !SPEED_CHANGES
};

#endif
