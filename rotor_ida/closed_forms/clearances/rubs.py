"""What follows a touch of a clearance: synchronous rubs with the scaled unbalance, and dry whip."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt
import xarray as xr

from rotor_ida.arrays import Values
from rotor_ida.closed_forms.clearances.critical_speeds import Mode
from rotor_ida.closed_forms.clearances.response import Cases, Response, about
from rotor_ida.closed_forms.whirls.dry_whip import Whip, dry_whips
from rotor_ida.closed_forms.whirls.synchronous import whirls_of_system
from rotor_ida.errors import InputError
from rotor_ida.model.assembly import assemble
from rotor_ida.model.axisymmetric import forward_motions, no_circles
from rotor_ida.model.rotor_system import RotorSystem
from rotor_ida.schema import STABILITY

# Continuous speeds at which rubs are sought, and as many from rest to the trip speed.
RUB_SPEEDS = 41
# The cells beside the hardest rub are divided so often, at these parts: at last to 2e-8 of a cell.
DIVISIONS, PARTS = 11, np.linspace(0.2, 0.8, 4)


@dataclass(frozen=True, slots=True)
class Rubs:
    """The hardest rub of each contact: a stable one, unless there is none."""

    force: Values
    speed: Values
    stability: npt.NDArray[np.int8]

    def or_harder(self, other: Rubs) -> Rubs:
        """Return the harder rub of each contact in these and others; a stable one comes first."""
        stable, others = (each.stability == STABILITY["stable"] for each in (self, other))
        is_harder = np.isnan(self.force) | (other.force > self.force)
        taken = np.where(stable == others, is_harder, others) & ~np.isnan(other.force)
        return Rubs(
            np.where(taken, other.force, self.force),
            np.where(taken, other.speed, self.speed),
            np.where(taken, other.stability, self.stability),
        )


@dataclass(frozen=True, slots=True)
class Touching:
    """What follows a touch at continuous speeds and on the way there, or why it is not known."""

    running: Rubs
    passing: Rubs
    whips: list[Whip | None]
    not_exact: str = ""


def hardest_rubs(found: Sequence[xr.Dataset], count: int) -> Rubs:
    """Return the hardest rub of each of a number of contacts in the whirls of several cases."""
    force, speed = np.full((2, count), np.nan)
    stability = np.full(count, STABILITY["absent"], np.int8)
    for number in range(count):
        for word in ("unstable", "stable"):  # a stable one replaces it
            rubs = []
            for whirls in found:
                own = whirls.isel(contact=number)
                chosen = (own["in_contact"] == 1) & (own["stability"] == STABILITY[word])
                forces = np.where(chosen.values, own["normal_force"].values, -np.inf).max(axis=1)
                rubs += list(zip(forces.tolist(), own["speed"].values.tolist(), strict=True))
            hardest = max(rubs, default=(-np.inf, np.nan))
            if hardest[0] > -np.inf:
                (force[number], speed[number]), stability[number] = hardest, STABILITY[word]
    return Rubs(force, speed, stability)


def _hardest(
    systems: Sequence[RotorSystem], speeds: Values, found: Sequence[xr.Dataset], count: int
) -> Rubs:
    """Return the hardest rubs from the lowest to the highest of some speeds.

    `found` are the whirls of each system at these speeds. A rub may be hardest in between, often at
    the fold where it ends.
    """
    rubs = hardest_rubs(found, count)
    for _ in range(DIVISIONS):
        best = np.searchsorted(speeds, np.unique(rubs.speed[np.isfinite(rubs.speed)]))
        if not best.size:
            break
        cells = np.unique(np.clip([best - 1, best], 0, speeds.size - 2))
        between = speeds[cells, np.newaxis] + np.outer(np.diff(speeds)[cells], PARTS)
        closer = np.setdiff1d(between, speeds)
        if not closer.size:
            break
        beside = [whirls_of_system(system, closer) for system in systems]
        rubs = rubs.or_harder(hardest_rubs(beside, count))
        speeds = np.union1d(speeds, closer)
    return rubs


def touching_of(
    response: Response,
    modes: Sequence[Mode],
    cases: Cases,
    scales: Values,
) -> Touching:
    """Return the rubs with the scaled unbalance, and dry whip."""
    problem = response.problem
    assembly, count = problem.assembly, len(problem.assembly.contacts)
    first = assembly.films.reach[0]
    speeds = np.concatenate([np.linspace(first, problem.trip, RUB_SPEEDS + 1), about(modes),
                             np.linspace(problem.low, problem.high, RUB_SPEEDS)])  # fmt: skip
    speeds = np.unique(speeds[(speeds > 0.0) & (speeds >= first) & (speeds <= problem.trip)])
    try:  # what is not axisymmetric is refused
        systems = [
            replace(
                assembly.system,
                unbalance=[replace(each, moment=scale * each.moment) for each in case],
            )
            for case, scale in zip(cases, scales.tolist(), strict=True)
        ]
        found = [whirls_of_system(system, speeds) for system in systems]
    except InputError as error:
        none = hardest_rubs([], count)
        return Touching(none, none, [None] * count, no_circles(error))
    motions = forward_motions(assemble(assembly.system.at(problem.high)))
    inside = (speeds >= problem.low) & (speeds <= problem.high)
    running = _hardest(
        systems, speeds[inside], [whirls.isel(speed=inside) for whirls in found], count
    )
    whips = [_first_stable(dry_whips(motions, number, each, problem.high))
             for number, each in enumerate(assembly.contacts)]  # fmt: skip
    return Touching(running, _hardest(systems, speeds, found, count), whips)


def _first_stable(whips: Sequence[Whip]) -> Whip | None:
    """Return the slowest stable whirl, or else the slowest."""
    return next((each for each in whips if each.growth_rate < 0.0), next(iter(whips), None))
