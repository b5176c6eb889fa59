"""The multipliers of a limit cycle, from its monodromy matrix or from the trace alone.

Damping is uniform: the flow contracts areas by ``exp(-2 zeta t)`` and is conformally symplectic
[1]_. Over a period T the monodromy matrix M obeys ``M^T S M = q S``, ``q = exp(-2 zeta T)``, with S
the symplectic form of displacement and momentum on the rotating axes. So its multipliers form pairs
of product q. A shift along the cycle has the multiplier 1, with the partner q; the other two are
``mu`` and ``q/mu``, with

    mu + q/mu = tr M - 1 - q,

a complex pair on the circle of radius sqrt(q), or two real numbers. The trace determines all: a
fold is where ``tr M = 2 (1 + q)``, a period doubling where ``tr M = 0``, and the cycle is stable
exactly between. A complex pair has modulus ``sqrt(q) < 1`` and cannot cross the unit circle: no
torus is born from a cycle.

This also holds with a shaft. Contact damping is not uniform, and there are no pairs: the three
nontrivial multipliers are the eigenvalues of M restricted to the space across the field. A fold is
where ``(1 - mu_1) (1 - mu_2) (1 - mu_3)`` vanishes, a doubling where
``(1 + mu_1) (1 + mu_2) (1 + mu_3)`` does. A torus may be born: a pair passes the unit circle where
``(1 - mu_1 mu_2) (1 - mu_1 mu_3) (1 - mu_2 mu_3)`` vanishes. This product also vanishes if two real
multipliers have the product 1, which is no bifurcation.

Friction does not depend on velocity while surfaces slide, so volumes shrink as without it, but
there are no pairs. If the disc rolls, neighbouring orbits begin to roll too, and one multiplier is
0.

Under a load the motion has the period of the load, and no multiplier is trivial: the same products
run over all four. Without contact damping these are still two pairs of product q, but two complex
pairs may leave the circle of radius sqrt(q) and cross the unit circle together.

References
----------
.. [1] R. C. Calleja, A. Celletti, R. de la Llave, "A KAM theory for conformally symplectic
   systems", Journal of Differential Equations 255, 2013.
"""

from __future__ import annotations

import math
from itertools import combinations

import numpy as np

from rotor_ida.arrays import ComplexValues
from rotor_ida.cycles.orbit import Orbit
from rotor_ida.simulation.flow import nontrivial as nontrivial_of

# Factors of a test function smaller than this show in it; many larger ones leave its size alone.
NEAR_ZERO = 0.03
# A pair that has been located on the unit circle is within this distance of it.
ON_CIRCLE = 1e-6
# The symplectic form ``dx ^ dvx + dy ^ dvy``: the velocity of the rotor, resolved on the rotating
# axes, is the momentum of the displacement there.
FORM = np.kron([[0.0, 1.0], [-1.0, 0.0]], np.eye(2))


def fold_test(orbit: Orbit) -> float:
    """Return ``2 (1 + q) - tr M``: 0 at a fold, and below 0 where a real multiplier is above 1.

    If the trace is not sufficient, the product of ``1 - mu`` over the nontrivial multipliers.
    """
    if orbit.pair_product is None:
        return _product(1.0 - nontrivial(orbit))
    return 2.0 * (1.0 + orbit.pair_product) - float(orbit.monodromy.trace())


def doubling_test(orbit: Orbit) -> float:
    """Return ``tr M``: 0 at a period doubling, and below 0 where a real multiplier is below -1.

    If the trace is not sufficient, the product of ``1 + mu`` over the nontrivial multipliers.
    """
    if orbit.pair_product is None:
        return _product(1.0 + nontrivial(orbit))
    return float(orbit.monodromy.trace())


def torus_test(orbit: Orbit) -> float:
    """Return the product of ``1 - mu_i mu_j`` over the pairs of nontrivial multipliers.

    It is 0 where a complex pair is on the unit circle, and where two real ones have the product 1.
    """
    pairs = combinations(nontrivial(orbit), 2)
    return _product(np.array([1.0 - one * other for one, other in pairs], dtype=np.complex128))


def _product(factors: ComplexValues) -> float:
    """Return the product of factors, each over its size where that is not small.

    A system of slight damping has many multipliers near the unit circle, and the product of the
    factors themselves would be small everywhere.
    """
    return float(np.prod(factors / np.sqrt(np.abs(factors) ** 2 + NEAR_ZERO**2)).real)


def on_unit_circle(orbit: Orbit) -> bool:
    """Return whether a complex pair of multipliers lies on the unit circle, to `ON_CIRCLE`."""
    multipliers = nontrivial(orbit)
    return bool(
        ((np.abs(np.abs(multipliers) - 1.0) <= ON_CIRCLE) & (multipliers.imag != 0.0)).any()
    )


def is_stable(orbit: Orbit) -> bool:
    """Return whether all multipliers but the trivial one lie inside the unit circle."""
    if orbit.pair_product is None:
        return bool((np.abs(nontrivial(orbit)) < 1.0).all())
    return fold_test(orbit) > 0.0 and doubling_test(orbit) > 0.0


def nontrivial(orbit: Orbit) -> ComplexValues:
    """Return the multipliers of a closed orbit but the trivial one; all where none is trivial."""
    return nontrivial_of(orbit.flow, orbit.piece)


def multipliers_of(orbit: Orbit) -> ComplexValues:
    """Return the multipliers of a closed orbit, by decreasing modulus."""
    trivial = [1.0] if orbit.is_autonomous else []
    multipliers = np.append(trivial, nontrivial(orbit))
    if orbit.rolls:  # up to rounding
        multipliers[np.argmin(np.abs(multipliers))] = 0.0
    return np.asarray(multipliers[np.argsort(-np.abs(multipliers), kind="stable")])


def multipliers_near(multipliers: ComplexValues, orbit: Orbit) -> ComplexValues:
    """Return the multipliers of a closed orbit in the order of the nearest given ones.

    Rounding alone decides the order by modulus of several on one circle.
    """
    from scipy.optimize import linear_sum_assignment  # noqa: PLC0415 - takes long to import

    others = multipliers_of(orbit)
    if orbit.pair_product is not None:
        return others
    nearest = linear_sum_assignment(np.abs(others - multipliers[:, np.newaxis]))[1]
    return np.asarray(others[nearest])


def trivial_defect(orbit: Orbit) -> float:
    """Return ``|M f - f|/|f|``, with f the rate of change at the start; NaN where no mu is 1."""
    rate = orbit.start_rate
    missed = np.linalg.norm(orbit.monodromy @ rate - orbit.end_rate) / np.linalg.norm(rate)
    return float(missed) if orbit.is_autonomous else math.nan


def symplectic_defect(orbit: Orbit) -> float:
    """Return the deviation of the matrix of one disc from the structure assumed for multipliers.

    The largest element of ``M^T S M - q S``, relative to that of ``M^T S M`` with all signs
    positive [dimensionless]; about 1e-15 by rounding alone. NaN with contact damping or friction,
    where there is no such structure.
    """
    rotor, matrix = orbit.rotor, orbit.monodromy
    if not rotor.damps_uniformly:
        return math.nan
    contraction = math.exp(-2.0 * rotor.zeta * orbit.duration)
    defect = np.abs(matrix.T @ FORM @ matrix - contraction * FORM).max()
    size = (np.abs(matrix).T @ np.abs(FORM) @ np.abs(matrix)).max()
    # both are zero where a period damps all velocities to nothing
    return float(defect / size) if size else 0.0
