"""The response of a rotor to the unbalance of each mode, at its clearances and probes."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np
from scipy.optimize import brentq

from rotor_ida.arrays import ComplexValues, Values
from rotor_ida.closed_forms.clearances.critical_speeds import (
    PLACED,
    Mode,
    Peak,
    antinodes,
    largest_between,
    orbit_axes,
    peak_between,
)
from rotor_ida.errors import InputError
from rotor_ida.model.assembly import Assembly
from rotor_ida.model.rotor_system import unbalance_of
from rotor_ida.model.system_parts import Unbalance
from rotor_ida.units import SPEED_UNITS

# Modes and responses are sought up to this many times the largest continuous speed.
REACH = 1.5
LARGEST_SCALE = 6.0
# Residual unbalance [kg m rpm/kg] of a mass, and the least eccentricity [m], at 25,000 rpm.
RESIDUAL, LEAST_ECCENTRICITY = 6350e-6, 0.254e-6
# Half-widths of a resonance, and how many speeds, about each mode.
ABOUT = np.linspace(-4.0, 4.0, 17)


@dataclass(frozen=True, slots=True)
class Problem:
    """A rotor with its clearances, the speeds of the machine, and its probes."""

    assembly: Assembly
    low: float
    high: float
    trip: float
    probes: tuple[str, ...]
    limit: float

    @property
    def top(self) -> float:
        """The largest speed at which modes and responses are sought: within the tables of films."""
        return min(max(REACH * self.high, self.trip), self.assembly.films.reach[1])

    @property
    def rows(self) -> Values:
        """Displacements of the clearances, then of the probes, by q."""
        names = list(self.assembly.system.nodes)
        nodes = self.assembly.node_rows()
        return np.concatenate([self.assembly.rows, nodes[[names.index(n) for n in self.probes]]])

    @property
    def diameters(self) -> Values:
        """The diametral clearances."""
        return 2.0 * np.array([each.clearance for each in self.assembly.contacts])


@dataclass(frozen=True, slots=True)
class Response:
    """Largest axes at clearances and probes, shape (case, speed, place), and the unbalance."""

    problem: Problem
    speeds: Values
    axes: Values
    forces: ComplexValues

    def at(self, case: int, place: int, omega: float) -> float:
        """Return the largest axis at one place and speed."""
        found = orbit_axes(self.problem.assembly, self.problem.rows[place : place + 1],
                           self.forces[:, case : case + 1], np.array([omega]))  # fmt: skip
        return float(found[0, 0, 0])

    def largest(self, case: int, place: int, low: float, high: float) -> tuple[float, float]:
        """Return where the largest axis is largest between two speeds, and how large."""
        return largest_between(lambda omega: self.at(case, place, omega), self.speeds,
                               self.axes[case, :, place], low, high)  # fmt: skip

    def reached(self, case: int, place: int, axis: float, high: float) -> float:
        """Return the lowest speed, up to one, at which an axis is that large; NaN without one."""
        where, most = self.largest(case, place, self.speeds[0], high)
        if most < axis:
            return np.nan
        before = self.speeds < where
        reach = self.axes[case, before, place] >= axis
        first = int(reach.argmax()) if reach.any() else reach.size
        if first == 0:
            return float(self.speeds[0])
        end = float(self.speeds[first]) if first < reach.size else where
        return float(brentq(lambda omega: self.at(case, place, omega) - axis,
                            self.speeds[first - 1], end, rtol=PLACED))  # fmt: skip

    def peak(self, case: int, low: float, high: float) -> Peak | None:
        """Return the largest peak at a probe between two speeds."""
        first = len(self.problem.assembly.contacts)
        places = range(first, first + len(self.problem.probes))
        inside = (self.speeds >= low) & (self.speeds <= high)
        best = max(places, key=lambda place: float(self.axes[case, inside, place].max()))
        return peak_between(lambda omega: self.at(case, best, omega), self.speeds,
                            self.axes[case, :, best], low, high)  # fmt: skip


Cases = Sequence[Sequence[Unbalance]]


def own_mass(problem: Problem) -> float:
    """Return the mass that moves where all nodes do, without fluid."""
    system = problem.assembly.system
    try:
        return float(system.unit_translations()[:, 0] @ system.weight((1.0, 0.0)))
    except InputError as error:
        raise InputError(f"mass must be given: {error}") from error


def cases_of(problem: Problem, modes: Sequence[Mode], mass: float) -> tuple[Cases, list[int]]:
    """Return the unbalance of each case, that of a mass at the antinodes of a mode, and its modes.

    Modes with the same antinodes, as those along two axes have them, share a case: the numbers are
    those of the case of each mode.
    """
    system = problem.assembly.system
    eccentricity = max(RESIDUAL * SPEED_UNITS["rpm"] / problem.high, LEAST_ECCENTRICITY)
    names = list(system.nodes)
    stators = {each.stator for each in problem.assembly.contacts if isinstance(each.stator, str)}
    along = system.positions or dict.fromkeys(names, 0.0)
    order = sorted((i for i, name in enumerate(names) if name not in stators),
                   key=lambda i: along[names[i]])  # fmt: skip
    every = [antinodes(mode, order) for mode in modes]
    different = [places for number, places in enumerate(every) if places not in every[:number]]
    cases = [
        [Unbalance(node=names[i], moment=eccentricity * mass / len(places), phase=phase)
         for i, phase in places]
        for places in different
    ]  # fmt: skip
    return cases, [different.index(places) for places in every]


def response_to(problem: Problem, modes: Sequence[Mode], cases: Cases, points: int) -> Response:
    """Return the response to all cases, at speeds that resolve each critical speed."""
    first, top = problem.assembly.films.reach[0], problem.top
    ends = [problem.low, problem.high, problem.trip]
    every = np.concatenate([np.linspace(first, top, points + 1), ends, about(modes)])
    every = np.unique(every[(every > 0.0) & (every >= first) & (every <= top)])
    forces = np.array([
        both[0] - 1j * both[1] for both in
        (unbalance_of(replace(problem.assembly.system, unbalance=case), problem.assembly.size)
         for case in cases)
    ]).T  # fmt: skip
    return Response(problem, every, orbit_axes(problem.assembly, problem.rows, forces, every),
                    forces)  # fmt: skip


def about(modes: Sequence[Mode]) -> Values:
    """Return speeds about the critical speeds of modes."""
    return np.concatenate([mode.speed + mode.decay * ABOUT for mode in modes] or [ABOUT[:0]])


def scales_of(response: Response) -> Values:
    """Return the scale factor of each case."""
    problem = response.problem
    first = len(problem.assembly.contacts)
    seen = np.array([
        max(response.largest(case, place, problem.low, problem.high)[1]
            for place in range(first, first + len(problem.probes)))
        for case in range(len(response.axes))
    ])  # fmt: skip
    return np.asarray(problem.limit / np.maximum(seen, problem.limit / LARGEST_SCALE))


def peaks_of(response: Response, modes: Sequence[Mode], own: Sequence[int]) -> list[Peak]:
    """Return the peak of each mode in its own case, between the neighbouring modes."""
    speeds = [mode.speed for mode in modes]
    between = [0.5 * (one + other) for one, other in pairwise(speeds)]
    ends = [0.0, *between, float(response.speeds[-1])]
    found = []
    for number, (mode, case) in enumerate(zip(modes, own, strict=True)):
        inside = response.speeds[
            (response.speeds >= ends[number]) & (response.speeds <= ends[number + 1])
        ]
        peak = response.peak(case, inside[0], inside[-1]) if inside.size > 2 else None
        found.append(peak or Peak(mode.speed, np.nan))
    return found
