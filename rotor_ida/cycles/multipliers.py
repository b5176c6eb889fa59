"""The multipliers of a limit cycle, from the trace of its monodromy matrix.

Damping is uniform: the flow contracts areas at the rate ``exp(-2 zeta t)``, it is conformally
symplectic [1]_. Over a period T the monodromy matrix M obeys ``M^T S M = q S``, ``q = exp(-2 zeta
T)``, with S the symplectic form of displacement and momentum on the rotating axes. So its
multipliers come in pairs of product q. A shift along the cycle is one, 1, and has the partner q;
the other two are ``mu`` and ``q/mu``, with

    mu + q/mu = tr M - 1 - q,

a complex pair on the circle of radius sqrt(q), or two real numbers. One number tells all:
a fold is where ``tr M = 2 (1 + q)``, a period doubling where ``tr M = 0``, and the cycle is stable
exactly between. A pair cannot cross the unit circle, as its modulus is ``sqrt(q) < 1``: no torus is
born from a cycle.

So it is with a shaft, too. Contact damping is not uniform, and there are no pairs: there the three
multipliers beside the trivial one are the eigenvalues of what M leaves of the space across the
field, a fold is where ``(1 - mu_1) (1 - mu_2) (1 - mu_3)`` vanishes, a doubling where
``(1 + mu_1) (1 + mu_2) (1 + mu_3)`` does, and a torus may be born.

References
----------
.. [1] R. C. Calleja, A. Celletti, R. de la Llave, "A KAM theory for conformally symplectic
   systems", Journal of Differential Equations 255, 2013.
"""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt

from rotor_ida.stability.orbit import Shot

Complex = npt.NDArray[np.complex128]

# The symplectic form ``dx ^ dvx + dy ^ dvy``: the velocity of the rotor, read on the rotating axes,
# is the momentum of the displacement there.
FORM = np.kron([[0.0, 1.0], [-1.0, 0.0]], np.eye(2))


def contraction(zeta: float, period: float) -> float:
    """Return ``q = exp(-2 zeta T)``, by which areas shrink in a period.

    Examples
    --------
    >>> contraction(0.0, 3.0)
    1.0
    """
    return math.exp(-2.0 * zeta * period)


def fold_test(shot: Shot) -> float:
    """Return ``2 (1 + q) - tr M``: 0 at a fold, and below 0 where a real multiplier is above 1.

    With contact damping ``(1 - mu_1) (1 - mu_2) (1 - mu_3)``.
    """
    if not has_pairs(shot):
        return float(np.prod(1.0 - _others_of(shot)).real)
    return 2.0 * (1.0 + _contraction_of(shot)) - float(shot.monodromy.trace())


def doubling_test(shot: Shot) -> float:
    """Return ``tr M``: 0 at a period doubling, and below 0 where a real multiplier is below -1.

    With contact damping ``(1 + mu_1) (1 + mu_2) (1 + mu_3)``.
    """
    if not has_pairs(shot):
        return float(np.prod(1.0 + _others_of(shot)).real)
    return float(shot.monodromy.trace())


def is_stable(shot: Shot) -> bool:
    """Return whether all multipliers but the trivial one lie inside the unit circle."""
    if not has_pairs(shot):
        return bool((np.abs(_others_of(shot)) < 1.0).all())
    return fold_test(shot) > 0.0 and doubling_test(shot) > 0.0


def has_pairs(shot: Shot) -> bool:
    """Return whether the multipliers come in pairs: all damping is uniform."""
    return shot.rotor.contact_damping == 0.0


def _others_of(shot: Shot) -> Complex:
    """Return the multipliers beside the trivial one: of M across the field at the start."""
    along = shot.start_rate / np.linalg.norm(shot.start_rate)
    across = np.linalg.svd(along[None])[2][1:]
    return np.asarray(np.linalg.eigvals(across @ shot.monodromy @ across.T), dtype=np.complex128)


def multipliers_of(shot: Shot) -> Complex:
    """Return the four multipliers of a closed orbit, by falling modulus."""
    if not has_pairs(shot):
        found = np.append(1.0, _others_of(shot))
        return np.asarray(found[np.argsort(-np.abs(found), kind="stable")])
    q = _contraction_of(shot)
    half = 0.5 * (float(shot.monodromy.trace()) - 1.0 - q)
    rest = half * half - q
    if rest < 0.0:
        root = math.sqrt(-rest)
        pair = [complex(half, root), complex(half, -root)]
    else:
        # the smaller one from the product: a difference would cancel
        larger = half + math.copysign(math.sqrt(rest), half)
        pair = [complex(larger), complex(q / larger)]
    found = np.array([1.0, q, *pair], dtype=np.complex128)
    return found[np.argsort(-np.abs(found), kind="stable")]


def defects_of(shot: Shot) -> tuple[float, float]:
    """Return how far the integrated matrix is from the structure that the multipliers rest on.

    Returns
    -------
    trivial : float
        ``|M f - f|/|f|``, with f the rate of change at the start: 0 if 1 is a multiplier [1].
    symplectic : float
        The largest element of ``M^T S M - q S``, as a part of that of ``M^T S M`` with all signs
        positive: what rounding can do at most is of the order 1e-15 [1]. NaN with contact damping,
        where there is no such structure.
    """
    rate, matrix = shot.start_rate, shot.monodromy
    trivial = np.linalg.norm(matrix @ rate - shot.end_rate) / np.linalg.norm(rate)
    if not has_pairs(shot):
        return float(trivial), math.nan
    defect = np.abs(matrix.T @ FORM @ matrix - _contraction_of(shot) * FORM).max()
    size = (np.abs(matrix).T @ np.abs(FORM) @ np.abs(matrix)).max()
    # both are zero where a period damps all velocities to nothing
    return float(trivial), float(defect / size) if size else 0.0


def _contraction_of(shot: Shot) -> float:
    return contraction(shot.rotor.zeta, shot.duration)
