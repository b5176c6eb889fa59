"""Trapping sets on a section of a stable limit cycle: sets that return into themselves.

The section is the plane across the field at the state c of the cycle where its radius is largest.
Near c an orbit returns by ``s - c -> Pi (s - c)``, where Pi is the monodromy matrix restricted to
the section. Its eigenvalues are the nontrivial multipliers of the cycle. A weighted sum of the
squared amplitudes of its modes falls from return to return,

    V(s) = sum w_i |l_i . (s - c)|**2 = |L (s - c)|**2,    l_i the left eigenvectors,

at least by the largest ``|mu_i|**2``. The size of the set ``V <= 1`` is found by following states:
it is the largest set from which all of many states, spread over it, return with a smaller V. It is
therefore an estimate, not a proof as for the whirls (`trapping_regions`).

Under a load the motion depends on time as well. The section is then that of whole revolutions: all
states at the end of one, among which Pi is the monodromy matrix itself.

Where the largest multiplier is near -1, one return increases V and the next decreases it again:
``x -> -x + b x**2``. There states are followed for two returns.
"""

from __future__ import annotations

import math
from bisect import bisect_left
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from rotor_ida.arrays import Stop, Values
from rotor_ida.basins.kernel import (
    NO_CONTACT_FREE,
    NOT_COMPUTED,
    NOT_FORWARDS,
    REGION,
    SECTION,
    Rows,
    follow,
    measure_returns,
)
from rotor_ida.basins.trapping_regions import MOST_SKEW
from rotor_ida.cycles.multipliers import multipliers_of
from rotor_ida.cycles.orbit import Orbit
from rotor_ida.errors import SimulationError
from rotor_ida.simulation.flow import MAXIMUM, DiscFlow

# Tolerance of a step of the kernel: close to a graze the set is small.
TOLERANCE = 1e-10
# Relative sizes of the shells over which states are spread,
SHELLS = (1.0, 0.8, 0.6, 0.4, 0.2)
# and the number of states on each, in three dimensions and under a load in four.
STATES, STATES_UNDER_LOAD = 64, 512
# V must fall by this fraction of its decrease in the linear motion.
FALLS = 0.3
# Safety factor on the width, for states that were not tried.
CAUTION = 0.8
# A state returns between these fractions of the period: neither at once nor after two rounds.
FIRST_RETURN, LAST_RETURN = 0.5, 1.6
# The widest set tried, relative to the size of the cycle,
WIDEST = 1.0
# and the narrowest.
NARROWEST = 1e-5
# Number of widths tried, each 0.68 of the one before.
WIDTHS = 31
# Weights of the mode with the multiplier exp(-2 zeta T), or of the faster pair, against the others.
MODE_RATIOS = (0.1, 1.0, 10.0)
# Multipliers within this fraction of the largest count as a pair: the difference is rounding.
SAME_MODULUS = 1e-6


@dataclass(frozen=True)
class CycleSection:
    """A section of a limit cycle with a trapping set on it, which returns into itself.

    Parameters
    ----------
    cycle : Orbit
        The cycle.
    centre, normal : ndarray, shape (4,)
        Its state on the section, and the direction of the field there [dimensionless]; 0 under a
        load.
    form : ndarray, shape (3, 4) or (4, 4)
        L: the set is ``|L (s - centre)| <= 1``. All infinite if no such set was found. Under a load
        it is an upper triangle, and the set is one of states at whole revolutions.
    """

    cycle: Orbit
    centre: Values
    normal: Values
    form: Values

    @property
    def exists(self) -> bool:
        """Whether a set was found."""
        return bool(np.isfinite(self.form).all())

    @cached_property
    def row(self) -> Rows:
        """The section in the kernel's format; no orbit passes one whose centre is infinite.

        Under a load it is a region.
        """
        if len(self.form) == len(self.centre):
            factor = self.form if self.exists else np.eye(4)
            centre = self.centre if self.exists else np.full(4, np.inf)
            return np.array((centre, factor[np.triu_indices(4)]), dtype=REGION)
        if not self.exists:
            return np.array((np.full(4, np.inf), np.ones(4), np.ones((3, 4)), 0.0), dtype=SECTION)
        widest = 1.0 / np.linalg.svd(self.form, compute_uv=False)[-1]
        return np.array((self.centre, self.normal, self.form, widest**2), dtype=SECTION)


def cycle_section(cycle: Orbit, stop: Stop) -> CycleSection:
    """Return a section of a stable limit cycle with a trapping set, if there is one.

    None is sought where the disc rolls, which the kernel cannot follow. With friction the disc
    slides forwards throughout from every state of the set.
    """
    rows = 3 if cycle.is_autonomous else 4
    none = CycleSection(cycle, cycle.start, np.zeros(4), np.full((rows, 4), np.inf))
    if cycle.rolls:
        return none
    try:
        if cycle.is_autonomous:
            return _widest_section(cycle, stop)
        return _widest(none, cycle.monodromy, np.eye(4), stop)
    except (SimulationError, np.linalg.LinAlgError):
        return none


def _widest_section(cycle: Orbit, stop: Stop) -> CycleSection:
    """Return the section with the largest set among those that the modes suggest."""
    extrema, flow = cycle.piece.extrema, DiscFlow(cycle.rotor, stop)
    maxima = extrema[extrema["kind"] == MAXIMUM]
    time = float(maxima["time"][np.argmax(maxima["radius"])])
    centre = flow.run(cycle.start, time).end if time > 0.0 else cycle.start
    round_ = flow.run(centre, cycle.duration)
    normal = round_.start_rate / np.linalg.norm(round_.start_rate)
    section = CycleSection(cycle, centre, normal, np.full((3, 4), np.inf))
    plane = np.linalg.svd(normal[None])[2][1:]  # three directions across the field
    return _widest(section, round_.tangents, plane, stop)


def _widest(section: CycleSection, monodromy: Values, plane: Values, stop: Stop) -> CycleSection:
    """Return a section with the largest set, whose directions are the rows of `plane`."""
    cycle = section.cycle
    slowest = complex(multipliers_of(cycle)[1 if cycle.is_autonomous else 0])
    rounds = 2 if slowest.real < 0.0 and slowest.imag == 0.0 else 1
    allowed = 1.0 - FALLS * (1.0 - abs(slowest) ** (2 * rounds))
    best, volume = section, 0.0
    for form in _forms(monodromy, plane):
        width, size = _width(section, form, rounds, allowed, stop), len(form)
        if width > 0.0 and width**size / _density(form) > volume:
            volume = width**size / _density(form)
            best = replace(section, form=form / (CAUTION * width))
    return best


def _forms(monodromy: Values, plane: Values) -> list[Values]:
    """Return forms L of size about 1, with different weights of the modes of the return."""
    values, vectors = np.linalg.eig(plane @ monodromy @ plane.T)
    if np.linalg.cond(vectors) > MOST_SKEW:
        return []
    inverse = np.linalg.inv(vectors)
    fast = np.abs(values) < np.abs(values).max() * (1.0 - SAME_MODULUS)
    forms = []
    for ratio in MODE_RATIOS:
        weights = np.where(fast, ratio, 1.0)
        square = ((inverse.conj().T * weights) @ inverse).real
        factor = np.linalg.cholesky(0.5 * (square + square.T)).T
        forms.append(factor @ plane / np.linalg.norm(factor, 2))
    return forms


def _density(form: Values) -> float:
    """Return the product of the inverse half-widths of the set ``|L x| <= 1``."""
    return float(np.prod(np.linalg.svd(form, compute_uv=False)))


def _width(section: CycleSection, form: Values, rounds: int, allowed: float, stop: Stop) -> float:
    """Return about the largest width at which all states return with a smaller V; 0 if none.

    They are followed for `rounds` returns, after which V may be at most `allowed`.
    """
    count = STATES if section.cycle.is_autonomous else STATES_UNDER_LOAD
    directions = np.linalg.pinv(form) @ _sphere(count, len(form))

    def all_nearer(width: float) -> bool:
        here = replace(section, form=form / width)
        for shell in SHELLS:
            states = section.centre[:, None] + shell * width * directions
            values = _returned(here, states, rounds, stop)
            if stop[0] or not (values <= allowed * shell**2).all():
                return False
        return True

    widths = np.geomspace(WIDEST, NARROWEST, WIDTHS) * float(np.linalg.norm(section.centre))
    first = bisect_left(widths.tolist(), True, key=all_nearer)
    return float(widths[first]) if first < WIDTHS else 0.0


def _returned(section: CycleSection, states: Values, rounds: int, stop: Stop) -> Values:
    """Return V of states after some rounds; infinite where they do not return."""
    cycle, values = section.cycle, np.empty(states.shape[1])
    if cycle.is_autonomous:
        before = (rounds - 1) * cycle.duration
        times = before + FIRST_RETURN * cycle.duration, before + LAST_RETURN * cycle.duration
        measure_returns(states, cycle.rotor, section.row, times, TOLERANCE, values, stop)
        return values
    labels, times_taken = np.full(values.size, NOT_COMPUTED, np.int16), np.zeros(values.size, "f4")
    nothing = np.empty(0, REGION), NO_CONTACT_FREE, np.empty(0, SECTION)
    follow(states, labels, times_taken, cycle.rotor, *nothing, rounds * cycle.duration, TOLERANCE,
           stop)  # fmt: skip
    values[:] = np.square(section.form @ (states - section.centre[:, None])).sum(axis=0)
    return np.where(labels == NOT_FORWARDS, np.inf, values)


def _sphere(count: int, dimensions: int) -> Values:
    """Return directions spread evenly over the sphere, shape (3, count), or drawn from one in 4."""
    if dimensions > 3:
        drawn = np.random.default_rng(0).normal(size=(dimensions, count))
        return np.asarray(drawn / np.linalg.norm(drawn, axis=0))
    place = (np.arange(count) + 0.5) / count
    height = 1.0 - 2.0 * place
    angle = math.pi * (1.0 + math.sqrt(5.0)) * count * place
    across = np.sqrt(1.0 - height**2)
    return np.stack([across * np.cos(angle), across * np.sin(angle), height])
