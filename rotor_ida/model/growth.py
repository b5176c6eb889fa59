"""Whether the motion of a rotor system without contact grows, and whether anything holds it."""

from __future__ import annotations

from itertools import pairwise
from typing import NamedTuple

import numpy as np
from scipy.optimize import brentq

from rotor_ida.arrays import ComplexValues
from rotor_ida.model.assembly import Canonical

# Relative size below which an eigenvalue is that of a free motion.
FREE = 1e-9
# Growth rates below this part of the largest eigenvalue are rounding; so are those of eigenvalues
# that are themselves below this part of it, as of a rotor that nothing holds: a double 0.
GROWING, HELD = 1e-9, 1e-6
# Steps in which the speed falls where growth is followed to its beginning, and how near to that
# where no sign of the growth rate tells it.
STEPS, PLACED = 16, 1e-6
# Speeds at which ranges of growth are sought.
POINTS = 65


class Growth(NamedTuple):
    """How a motion without contact grows: at which rate, and at which whirl speed."""

    rate: float
    whirl_speed: float


def rates_of(found: Canonical, speed: float) -> ComplexValues:
    """Return the eigenvalues of the motion without contact at a speed."""
    inert = len(found.stiffness) - found.massless
    first_order = np.eye(2 * inert, k=inert)
    stiffness = found.stiffness_at(speed)
    first_order[inert:, :inert] = -stiffness[:inert, :inert]
    first_order[inert:, inert:] -= found.damping_at(speed)[:inert, :inert]
    if found.gyroscopic is not None:
        first_order[inert:, inert:] -= speed * found.gyroscopic[:inert, :inert]
    relaxing = -np.diag(stiffness)[inert:]  # stators without mass
    return np.concatenate([np.linalg.eigvals(first_order), relaxing])


def growth_of(found: Canonical, speed: float) -> Growth | None:
    """Return how the motion without contact grows fastest at a speed; None where it does not."""
    rates = rates_of(found, speed)
    fastest, largest = _fastest(rates)
    if not fastest.real > GROWING * largest:
        return None
    return Growth(fastest.real, abs(fastest.imag))


def _fastest(rates: ComplexValues) -> tuple[complex, float]:
    """Return the eigenvalue that grows fastest, free motions aside, and the largest size of all."""
    sizes = np.abs(rates)
    moving = rates[sizes > HELD * sizes.max()]
    fastest = complex(moving[np.argmax(moving.real)]) if moving.size else 0j
    return fastest, float(sizes.max())


def growth_begins(found: Canonical, speed: float) -> float | None:
    """Return from which speed on the motion without contact grows up to a speed at which it does.

    It is sought on films alone, down to the lowest speed of their tables; None if it grows there.
    """
    first = found.films.reach[0]
    high = speed
    for low in np.linspace(speed, first, STEPS + 1)[1:].tolist():
        if growth_of(found, low) is None:
            break
        high = low
    else:
        return None
    return _end_between(found, low, high, True)


def growth_between(
    found: Canonical, low: float, high: float, points: int = POINTS
) -> list[tuple[float, float]]:
    """Return the ranges of speeds between two in which the motion without contact grows.

    Ranges, and gaps between them, that lie between neighbours of some `points` are not seen.
    """
    knots = found.films.knots
    inside = knots[(knots > low) & (knots < high)]
    speeds = np.unique(np.concatenate([np.linspace(low, high, points), inside])).tolist()
    grow = [growth_of(found, each) is not None for each in speeds]
    ends = [low] if grow[0] else []
    for (below, above), grows in zip(pairwise(speeds), grow[1:], strict=True):
        if grows != (len(ends) % 2 == 1):
            ends.append(_end_between(found, below, above, grows))
    ends += [high] if len(ends) % 2 else []
    return list(zip(ends[::2], ends[1::2], strict=True))


def _end_between(found: Canonical, low: float, high: float, grows: bool) -> float:
    """Return where growth begins between two speeds, or ends.

    It is where the growth rate is 0; where it does not change its sign, as without damping, a speed
    at which there is growth.
    """

    def rate(speed: float) -> float:
        fastest, largest = _fastest(rates_of(found, speed))
        return fastest.real / largest if largest else 0.0

    lower, higher = sorted((rate(low), rate(high)))
    if lower < -GROWING and higher > GROWING:
        return float(brentq(rate, low, high, xtol=1e-14 * max(abs(low), abs(high))))
    near = PLACED * max(abs(low), abs(high))
    while high - low > near:
        middle = 0.5 * (low + high)
        same = (growth_of(found, middle) is not None) == grows
        low, high = (low, middle) if same else (middle, high)
    return high if grows else low


def nothing_holds(found: Canonical) -> bool:
    """Return whether constant forces move the system where neither supports nor contacts hold it.

    Nothing balances a force f along a motion u that neither bends supports, ``u' K = 0``, nor moves
    a contact, ``B u = 0``.
    """
    if not found.force.any():
        return False
    left, sizes, _ = np.linalg.svd(found.stiffness)
    free = left[:, sizes <= FREE * sizes.max(initial=0.0)]
    _, strengths, shapes = np.linalg.svd(found.rows.reshape(-1, len(free)) @ free)
    rank = int((strengths > FREE * strengths.max(initial=0.0)).sum())
    pushed = (free @ shapes[rank:].T).T @ found.force
    return bool(np.abs(pushed).max(initial=0.0) > FREE * np.linalg.norm(found.force))
