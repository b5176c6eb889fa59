"""Of what order a series is best, and how far it may be followed: by the tolerance alone.

With a tolerance eps the order that costs least is ``1 - ln(eps)/2``, and a step is so long that
neither of the last two terms of any component comes to its tolerance [1]_.

References
----------
.. [1] À. Jorba and M. Zou, "A software package for the numerical integration of ODEs by means of
   high-order Taylor methods", Experimental Mathematics 14, 2005, sections 3.2 and 3.3.
"""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt

from rotor_ida.equations.compiling import shared
from rotor_ida.simulation.taylor.rows import evaluate_sizes

Values = npt.NDArray[np.float64]

LOWEST_ORDER, HIGHEST_ORDER = 6, 24
# A step turns the fastest of the motions that the terms cannot show by no more than this part of
# the order: beyond, a series that has died away to rounding would grow again.
FARTHEST = 0.25
# The logarithm of a step that nothing limits.
UNLIMITED = 100.0
# Terms fall by a factor exp(2) where the order is best; so many are looked at, as some may vanish:
# the series of a radial entry has but every fifth.
FALL, LOOKED_AT = 2.0, 6
RATIO = math.exp(FALL)


@shared
def order_for(rtol: float) -> int:
    """Return the order at which a given accuracy takes the least work."""
    order = math.ceil(1.0 - 0.5 * math.log(rtol))
    return min(max(order, LOWEST_ORDER), HIGHEST_ORDER)


@shared
def longest_step(
    terms: Values, inverse: Values, sizes: Values, order: int, components: int, rate: float
) -> float:
    """Return the step at which the last terms of the first components reach their tolerances.

    It is NaN where a term is not finite.
    """
    last = _worst(terms, inverse, order, components)
    before = _worst(terms, inverse, order - 1, components)
    if not math.isfinite(last + before):
        return math.nan
    longest = UNLIMITED
    if last > 0.0:
        longest = -math.log(last) / order
    if before > 0.0:
        longest = min(longest, (FALL - math.log(before)) / (order - 1))
    step = math.exp(longest)
    if rate > 0.0:
        step = min(step, FARTHEST * order / rate)
    # others in case these vanish: the series of a radial entry has but every fifth term
    first, growth = order - LOOKED_AT + 1, RATIO * step
    evaluate_sizes(terms[first:], LOOKED_AT - 3, growth, sizes)
    scale, excess = growth**first / RATIO ** (order + 1), 0.0
    for i in range(components):
        excess = max(excess, scale * sizes[i] * inverse[i])
    if excess > 1.0:
        for n in range(first, order - 1):
            worst = _worst(terms, inverse, n, components)
            if worst > 0.0:
                step = min(step, math.exp((FALL * (order + 1 - n) - math.log(worst)) / n))
    return step


@shared
def _worst(terms: Values, inverse: Values, n: int, components: int) -> float:
    """Return the largest of the coefficients n, each in parts of its tolerance."""
    worst = 0.0
    for i in range(components):
        worst = max(worst, abs(terms[n, i]) * inverse[i])
    return worst
