"""How often a polynomial vanishes inside a step.

By Descartes' rule, in the basis of Bernstein, it does so at most as often as its coefficients
change sign, or fewer times by an even number. None means no root, one means one: what is told
apart in this way hides in no step, however long.

References
----------
.. [1] G. E. Collins, A. G. Akritas, "Polynomial real root isolation using Descarte's rule of
   signs", SYMSAC 1976.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from rotor_ida.equations.compiling import shared
from rotor_ida.simulation.taylor.rows import LANES, Count, sum_products

Values = npt.NDArray[np.float64]

_ONE: Count = (0,)
MOST_CUTS = 60


@shared
def is_monotonic(terms: Values, component: int, step: float) -> bool:
    """Return whether a polynomial's own size of terms shows that it is, on ``(0, step]``.

    It is where the first term of its slope outweighs all others.

    Parameters
    ----------
    terms, component, step
        As of `sign_changes`.
    """
    others, scale = 0.0, step
    for n in range(2, terms.shape[0]):
        scale *= step
        others += n * scale * abs(terms[n, component])
    return bool(others < step * abs(terms[1, component]))


@shared
def bernstein_basis(degree: int) -> Values:
    """Return what each power of a polynomial on (0, 1] adds to its Bernstein coefficients.

    Power k adds ``binomial(j, k)/binomial(degree, k)`` to coefficient j.

    Returns
    -------
    ndarray, shape (parts, degree + 1, 16)
        The highest power first; coefficient j is in lane ``j % 16`` of part ``j // 16``.
    """
    basis = np.zeros((degree // LANES + 1, degree + 1, LANES))
    for j in range(degree + 1):
        share = 1.0
        for k in range(j + 1):
            basis[j // LANES, degree - k, j % LANES] = share
            share *= (j - k) / max(degree - k, 1)
    return basis


@shared
def sign_changes(
    terms: Values, component: int, step: float, basis: Values, powers: Values, total: Values
) -> int:
    """Return how often the Bernstein coefficients of a polynomial on ``(0, step]`` change sign.

    Parameters
    ----------
    terms : ndarray, shape (degree + 1, components)
        Coefficients by powers.
    component : int
        Which of the polynomials.
    step : float
        Length of the interval.
    basis : ndarray, shape (parts, degree + 1, 16)
        From `bernstein_basis`.
    powers, total : ndarray, shapes (1, degree + 1) and (16,)
        Overwritten.
    """
    orders = basis.shape[1]
    scale = 1.0
    for n in range(orders):
        powers[0, n] = terms[n, component] * scale
        scale *= step
    changes, last = 0, 0.0
    for part in range(basis.shape[0]):
        sum_products(powers, 0, basis[part : part + 1], _ONE, orders - 1, total)
        for j in range(min(LANES, orders - part * LANES)):
            if total[j] != 0.0:
                changes += total[j] * last < 0.0
                last = total[j]
    return changes


@shared
def with_one_root(
    terms: Values, component: int, size: float, step: float, basis: Values, powers: Values,
    total: Values,
) -> float:  # fmt: skip
    """Return a step, cut so that a component vanishes inside it at most once.

    `size` is the sum of its terms at the end of the step, each without its sign.
    """
    if size < 2.0 * abs(terms[0, component]) or is_monotonic(terms, component, step):
        return step
    for _ in range(MOST_CUTS):
        if sign_changes(terms, component, step, basis, powers, total) <= 1:
            break
        step *= 0.5
    return step
