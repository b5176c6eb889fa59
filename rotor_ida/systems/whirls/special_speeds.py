"""Speeds at which the synchronous whirls of a rotor system change: folds, Hopf points, grazes.

1. *Grid*: all rubs of each set of contacts, at many speeds. Folds and grazes join it, from both
   sides and in several distances, until no other is found: so no cell has two of them.
2. *Folds*: where the number of rubs changes by two between neighbouring speeds, the change is
   enclosed by halving, and Newton's method finds where the balance of forces and its determinant
   vanish together.
3. *Branches*: between neighbouring speeds without a fold each rub is followed to its successor.
4. *Grazes and Hopf points*: along a branch, where another contact is just touched, and where the
   real part of a pair of eigenvalues vanishes.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import combinations, pairwise

import numpy as np
import xarray as xr
from scipy.optimize import brentq, linear_sum_assignment

from rotor_ida.arrays import ROUNDING, Column, ComplexValues, Values
from rotor_ida.checks import LARGEST_NUMBER, check_array, check_axis, check_count, shown
from rotor_ida.errors import InputError
from rotor_ida.model.contact import HERTZ_EXPONENT
from rotor_ida.model.rotor_system import RotorSystem
from rotor_ida.model.system_parts import Contact, Unbalance
from rotor_ida.schema import SPECIAL, labelled_dataset
from rotor_ida.systems.assembly import Assembly, assemble
from rotor_ida.systems.axisymmetric import (
    ForwardMotions,
    check_axisymmetric_parts,
    check_masses,
    check_no_races,
    forward_motions,
)
from rotor_ida.systems.receptances import Receptances, receptances
from rotor_ida.systems.units import with_system_units
from rotor_ida.systems.whirls.at_speeds import (
    MOST_TOUCHING,
    effects,
    rubbing_whirls,
    rubs,
    touching_sets,
)
from rotor_ida.systems.whirls.double_rubs import balance
from rotor_ida.systems.whirls.synchronous import synchronous_response_system
from rotor_ida.systems.whirls.turning_axes import (
    NEUTRAL,
    Whirls,
    eigenvalues_in_contact,
    eigenvalues_without_contact,
)

MOST_POINTS = 100_000
# Variables of whirls that a result of special speeds has by another name, or not at all.
OF_WHIRLS = (
    "amplitude", "phase_lag", "normal_force", "in_contact", "node_amplitude", "node_phase_lag",
    "stability", "growth_rate",
)  # fmt: skip
# Number of halvings of an interval of speeds around a fold. Largest number of Newton steps, and the
# relative size of the last.
_HALVINGS, _STEPS, _SOLVED = 12, 30, 1e-11
# Parts of the range at which speeds are added beside folds and grazes, and how often these are
# sought again. None are added for rubs of two contacts at once: beside their folds the subdivision
# takes millions of boxes.
_BESIDE, _ROUNDS = np.array([1e-4, 1e-6, 1e-8, 1e-10]), 5
# Relative step of the differences in it, and the distance of rubs that are one.
_DIFFERENCE, _SAME_ROOT = 1e-6, 1e-4

Touching = tuple[int, ...]
# The unknowns of each rub at each speed: shapes (rub, contacts that touch).
Roots = list[Values]


@dataclass(frozen=True, slots=True)
class RubProblem:
    """A system whose whirls are followed over the speed."""

    assembly: Assembly
    motions: ForwardMotions

    @property
    def clearances(self) -> Values:
        """The clearances of the contacts."""
        return np.array([each.clearance for each in self.assembly.contacts])

    def hertz(self, touching: Touching) -> list[bool]:
        """Return which of some contacts are Hertz contacts."""
        return [self.assembly.contacts[j].exponent == HERTZ_EXPONENT for j in touching]

    def response(self, speeds: Sequence[float] | Values) -> Receptances:
        """Return the receptances at speeds."""
        return receptances(self.assembly, np.asarray(speeds, float))

    def roots(self, touching: Touching, speeds: Values) -> Roots:
        """Return all rubs of a set of contacts, whether or not the others are free."""
        if not touching:
            return [np.zeros((1, 0))] * speeds.size
        contacts = self.assembly.contacts
        rows, depths = rubs(contacts, self.response(speeds), speeds, touching)
        v = depths / self.clearances[list(touching)]
        v = np.where(self.hertz(touching), np.sqrt(v), v)
        order = np.lexsort((*v.T[::-1], rows))
        return np.split(v[order], np.searchsorted(rows[order], np.arange(1, speeds.size)))

    def balance(self, touching: Touching, v: Values, omega: float) -> tuple[Values, Values]:
        """Return what vanishes in a rub, and its slopes."""
        speeds, chosen = np.array([omega]), list(touching)
        free, effect = effects(self.assembly.contacts, self.response(speeds), speeds)
        own = effect[:, chosen][:, :, chosen]
        left, slope = balance(free[:, chosen], own, self.hertz(touching), v[np.newaxis])
        return left[0], slope[0]

    def whirls(self, touching: Touching, v: Values, speeds: Values) -> Whirls:
        """Return rubs as whirls, one for each speed."""
        response, rows = self.response(speeds), np.arange(speeds.size)
        depths = np.where(self.hertz(touching), v * v, v) * self.clearances[list(touching)]
        if not touching:
            return Whirls(rows, np.zeros((speeds.size, len(self.clearances))), response.free)
        return rubbing_whirls(self.assembly, response, speeds, rows, touching, depths)

    def eigenvalues(self, touching: Touching, v: Values, speeds: Values) -> ComplexValues:
        """Return the eigenvalues of rubs on turning axes, one row for each speed."""
        if not touching:
            found = eigenvalues_without_contact(self.motions, speeds)
            return np.asarray(found - 1j * speeds[:, np.newaxis])
        whirls = self.whirls(touching, v, speeds)
        return eigenvalues_in_contact(self.motions, self.assembly.contacts, speeds, whirls)


@dataclass(frozen=True, slots=True)
class _Point:
    """A special point: speed, kind, what touches, unknowns, frequency, and what it grazes."""

    speed: float
    kind: str
    touching: Touching
    v: Values
    frequency: float = np.nan
    grazed: float = np.nan


@dataclass(frozen=True, slots=True)
class _Piece:
    """A branch between two neighbouring speeds, with its unknowns at both."""

    touching: Touching
    speeds: tuple[float, float]
    ends: tuple[Values, Values]

    def at(self, problem: RubProblem, omega: float) -> Values:
        """Return the unknowns between the ends: the rub nearest to the line between them."""
        (first, last), (v, w) = self.speeds, self.ends
        part = (omega - first) / (last - first)
        guess = (1.0 - part) * v + part * w
        (roots,) = problem.roots(self.touching, np.array([omega]))
        apart = np.abs(roots - guess).sum(axis=1)
        return roots[np.argmin(apart)] if len(roots) else guess


def special_speeds(
    system: RotorSystem,
    *,
    contacts: Sequence[Contact],
    unbalance: Sequence[Unbalance],
    limits: tuple[float, float],
    points: int = 200,
) -> xr.Dataset:
    """Compute the speeds at which the synchronous whirls of a rotor system change.

    Parameters
    ----------
    system, contacts, unbalance
        As for `synchronous_response_system`.
    limits : (float, float)
        Lowest and highest speed.
    points : int
        Number of speeds in between, at equal distances, by which changes are noticed. Two that
        undo each other between neighbouring speeds, such as the folds of a small isola, are not;
        nor may be Hopf points of rubs at two contacts at once beside their folds.

    Returns
    -------
    Dataset
        On ``special``, in order of speed: ``special_speed`` and ``special_kind``: ``fold``, where
        two whirls meet and vanish; ``hopf``, where a whirl loses its stability to an oscillation,
        with ``hopf_frequency`` on turning axes; and ``graze``, where a whirl just touches another
        contact, the number ``grazed_contact``. On ``(special, contact)``: ``amplitude`` and
        ``in_contact``. The whirls between: ``branch_amplitude`` on ``(speed, branch, contact)``
        and ``branch_stability``.

    Raises
    ------
    InputError
        As from `synchronous_response_system`; if `limits` are not two speeds, the lower one first.

    Notes
    -----
    A fold is a double root of the equations of `single_rubs` or `double_rubs`. In a linear contact
    two whirls may also meet at a graze. A Hopf point of the contact-free whirl is the onset of
    instability of the rotor itself.

    Examples
    --------
    >>> from rotor_ida import Rotor
    >>> system, contacts, unbalance = Rotor(omega=1.0, zeta=0.07, delta0=0.5).system()
    >>> found = special_speeds(system, contacts=contacts, unbalance=unbalance, limits=(0.1, 3.0))
    >>> found.special_speed.values.round(6), found.special_kind.values
    (array([1.340701, 1.859769]), array([1, 1], dtype=int8))
    """
    low, high = _limits(limits)
    speeds = np.linspace(low, high, check_count("points", points, 2, MOST_POINTS))
    assembly = assemble(system, contacts, unbalance, None, None)
    check_axisymmetric_parts(assembly)
    check_no_races(assembly)
    check_masses(assembly)
    problem = RubProblem(assembly, forward_motions(assembly))
    grid = _Grid(problem, speeds)
    found = grid.refined(_BESIDE * (high - low))
    for touching in grid.roots:
        found += _hopf_points(problem, grid.pieces(touching))
    whirls = synchronous_response_system(
        system, contacts=contacts, unbalance=unbalance, speed=np.linspace(low, high, points)
    )
    kept = sorted((each for each in found if _is_free(problem, each)), key=lambda each: each.speed)
    return _dataset(problem, kept, whirls).assign_attrs(limits=np.array([low, high]), points=points)


def _limits(given: object) -> tuple[float, float]:
    """Return the lowest and the highest speed."""
    ends = check_array("limits", given)
    if ends.shape != (2,):
        raise InputError(f"limits must be two speeds, got {shown(given)}")
    low, high = check_axis("limits", ends, largest=LARGEST_NUMBER).tolist()
    if not low < high:
        raise InputError(
            "{name} must be two speeds, the lower one first, got {value}",
            name="limits", value=(low, high),
        )  # fmt: skip
    return low, high


class _Grid:
    """All rubs of each set of contacts at speeds that increase, to which more are added."""

    def __init__(self, problem: RubProblem, speeds: Values) -> None:
        self.problem = problem
        sets: list[Touching] = [(), *touching_sets(problem.assembly.contacts)]
        self.speeds = dict.fromkeys(sets, speeds)
        self.roots = {touching: problem.roots(touching, speeds) for touching in sets}

    def add(self, speeds: Values) -> None:
        """Add speeds within the range, but for rubs of two contacts at once."""
        for touching, known in self.roots.items():
            own = self.speeds[touching]
            if len(touching) > 1:
                continue
            fresh = np.setdiff1d(speeds[(speeds > own[0]) & (speeds < own[-1])], own)
            every = np.concatenate([own, fresh])
            order = np.argsort(every)
            roots = [*known, *self.problem.roots(touching, fresh)]
            self.roots[touching] = [roots[i] for i in order.tolist()]
            self.speeds[touching] = every[order]

    def pieces(self, touching: Touching) -> list[_Piece]:
        """Return the branches of a set of contacts between neighbouring speeds."""
        return list(_pieces(touching, self.roots[touching], self.speeds[touching]))

    def refined(self, distances: Values) -> list[_Point]:
        """Return all folds and grazes, and add speeds beside each."""
        found: list[_Point] = []
        for _ in range(_ROUNDS):
            every = [
                each for touching in self.roots
                for each in (*_grazes(self.problem, self.pieces(touching)), *self._folds(touching))
            ]  # fmt: skip
            fresh = [
                each for each in every
                if not any(_is_same(each, other, distances[-1]) for other in found)
            ]  # fmt: skip
            if not fresh:
                break
            found += fresh
            places = np.array([each.speed for each in fresh])[:, np.newaxis]
            self.add(np.concatenate([places - distances, places + distances], axis=1).ravel())
        return found

    def _folds(self, touching: Touching) -> Iterator[_Point]:
        """Yield the folds of a set of contacts between neighbouring speeds."""
        roots, speeds = self.roots[touching], self.speeds[touching].tolist()
        for ends, both in zip(pairwise(speeds), pairwise(roots), strict=True):
            yield from _folds_between(self.problem, touching, ends, both, _HALVINGS)


def _is_same(one: _Point, other: _Point, distance: float) -> bool:
    """Return whether two points are one, found in different rounds."""
    return (
        one.kind == other.kind
        and one.touching == other.touching
        and (np.isnan(one.grazed) or one.grazed == other.grazed)
        and abs(one.speed - other.speed) <= distance
        and bool(np.allclose(one.v, other.v, rtol=_SAME_ROOT))
    )


def _folds_between(
    problem: RubProblem,
    touching: Touching,
    ends: tuple[float, float],
    roots: tuple[Values, Values],
    halvings: int,
) -> Iterator[_Point]:
    """Yield the folds where the numbers of rubs at two speeds differ."""
    if len(roots[0]) == len(roots[1]):
        return
    if halvings:
        middle = 0.5 * (ends[0] + ends[1])
        (here,) = problem.roots(touching, np.array([middle]))
        for side, both in (((ends[0], middle), (roots[0], here)),
                           ((middle, ends[1]), (here, roots[1]))):  # fmt: skip
            yield from _folds_between(problem, touching, side, both, halvings - 1)
        return
    more = int(len(roots[1]) > len(roots[0]))
    if abs(len(roots[1]) - len(roots[0])) < 2:
        return  # one rub begins where a contact is just touched
    v = roots[more]
    one, other = min(
        combinations(range(len(v)), 2),
        key=lambda pair: float(np.abs(np.log(v[pair[0]] / v[pair[1]])).max()),
    )
    fold = _solved_fold(problem, touching, 0.5 * (v[one] + v[other]), ends[more])
    width = ends[1] - ends[0]
    if fold is not None and abs(fold.speed - ends[0]) <= 2.0 * width:
        yield fold


def _solved_fold(problem: RubProblem, touching: Touching, v: Values, omega: float) -> _Point | None:
    """Return the fold near a guess, by Newton's method with differences; None without one."""

    def equations(state: Values) -> Values:
        left, slope = problem.balance(touching, state[:-1], float(state[-1]))
        return np.append(left, np.linalg.det(slope))

    state = np.append(v, omega)
    for _ in range(_STEPS):
        steps = np.diag(_DIFFERENCE * np.abs(state))
        try:
            slopes = np.array([
                (equations(state + step) - equations(state - step)) / (2.0 * step.sum())
                for step in steps
            ]).T  # fmt: skip
            step = np.linalg.solve(slopes, equations(state))
        except np.linalg.LinAlgError:
            return None
        state = state - step
        if not (state > 0.0).all():
            return None
        if (np.abs(step) < _SOLVED * np.abs(state)).all():
            return _Point(float(state[-1]), "fold", touching, state[:-1])
    return None


def _pieces(touching: Touching, roots: Roots, speeds: Values) -> Iterator[_Piece]:
    """Yield the branches between neighbouring speeds with the same number of rubs."""
    for ends, (before, behind) in zip(pairwise(speeds.tolist()), pairwise(roots), strict=True):
        if len(before) != len(behind):
            continue
        order = range(len(before))  # at one contact, in order of size
        if len(touching) > 1:
            apart = np.abs(before[:, np.newaxis] - behind).sum(axis=2)
            order = linear_sum_assignment(apart)[1]
        for one, other in enumerate(order):
            yield _Piece(touching, ends, (before[one], behind[other]))


def _ends_of(pieces: Sequence[_Piece]) -> tuple[Values, Values]:
    """Return unknowns and speeds of both ends of pieces, one after the other."""
    speeds = np.array([each.speeds for each in pieces]).ravel()
    return np.concatenate([end for each in pieces for end in [*each.ends]]).reshape(
        speeds.size, -1
    ), speeds


def _grazes(problem: RubProblem, pieces: Sequence[_Piece]) -> Iterator[_Point]:
    """Yield where another contact is just touched along branches."""
    if not pieces:
        return
    touching = pieces[0].touching
    gaps = _gaps(problem, touching, *_ends_of(pieces)).reshape(len(pieces), 2, -1)
    for piece, ends in zip(pieces, gaps, strict=True):
        for other in np.nonzero(ends[0] * ends[1] < 0.0)[0]:

            def gap(omega: float, piece: _Piece = piece, other: int = int(other)) -> float:
                v = piece.at(problem, omega)
                return float(_gaps(problem, touching, v[np.newaxis], np.array([omega]))[0, other])

            yield replace(_between(problem, piece, gap, "graze"), grazed=float(other))


def _gaps(problem: RubProblem, touching: Touching, v: Values, speeds: Values) -> Values:
    """Return the distances of whirls from the contacts that they do not touch, else NaN."""
    displacement = problem.whirls(touching, v, speeds).displacement
    gaps = problem.clearances - np.abs(displacement)
    gaps[:, list(touching)] = np.nan
    return np.asarray(gaps)


def _hopf_points(problem: RubProblem, pieces: Sequence[_Piece]) -> Iterator[_Point]:
    """Yield where the real part of a pair of eigenvalues vanishes along branches."""
    if not pieces:
        return
    touching = pieces[0].touching
    found = problem.eigenvalues(touching, *_ends_of(pieces))
    grows = found.real > NEUTRAL * np.abs(found).max(axis=1, keepdims=True)
    for piece, (before, behind) in zip(pieces, grows.sum(axis=1).reshape(-1, 2), strict=True):
        for number in range(min(before, behind), max(before, behind), 2 if touching else 1):

            def eigenvalue(omega: float, piece: _Piece = piece, number: int = number) -> complex:
                v = piece.at(problem, omega)
                here = problem.eigenvalues(touching, v[np.newaxis], np.array([omega]))[0]
                return complex(here[np.argsort(-here.real)[number]])

            point = _between(problem, piece, lambda omega: eigenvalue(omega).real, "hopf")
            frequency = abs(eigenvalue(point.speed).imag)
            if frequency > NEUTRAL * float(np.abs(found).max()):
                yield _Point(point.speed, "hopf", touching, point.v, frequency)


def _between(
    problem: RubProblem, piece: _Piece, function: Callable[[float], float], kind: str
) -> _Point:
    """Return where a function of the speed vanishes on a piece of a branch."""
    low, high = piece.speeds
    omega = float(brentq(function, low, high, xtol=1e-300, rtol=4.0 * ROUNDING, maxiter=200))
    return _Point(omega, kind, piece.touching, piece.at(problem, omega))


def _is_free(problem: RubProblem, point: _Point) -> bool:
    """Return whether a point touches no further contact, but for the one that it grazes."""
    gaps = _gaps(problem, point.touching, point.v[np.newaxis], np.array([point.speed]))[0]
    gaps = np.sort(gaps[np.isfinite(gaps)])
    rounded = -_SOLVED * problem.clearances.max(initial=0.0)
    return bool((gaps >= rounded).all())


def _dataset(problem: RubProblem, points: Sequence[_Point], whirls: xr.Dataset) -> xr.Dataset:
    """Return special points in order of speed, with the whirls and what they are computed from."""
    assembly = problem.assembly
    amplitude = np.zeros((len(points), len(assembly.contacts)))
    touches = np.zeros(amplitude.shape, np.int8)
    for number, each in enumerate(points):
        whirl = problem.whirls(each.touching, each.v[np.newaxis], np.array([each.speed]))
        amplitude[number] = np.abs(whirl.displacement[0])
        touches[number, list(each.touching)] = 1
    kinds = np.array([SPECIAL[each.kind] for each in points], np.int8)
    variables: dict[str, Column] = {
        "special_speed": ("special", np.array([each.speed for each in points])),
        "special_kind": ("special", kinds),
        "hopf_frequency": ("special", np.array([each.frequency for each in points])),
        "grazed_contact": ("special", np.array([each.grazed for each in points])),
        "amplitude": (("special", "contact"), amplitude),
        "in_contact": (("special", "contact"), touches),
    }
    others = {str(n): each for n, each in whirls.variables.items() if n not in OF_WHIRLS}
    found = {
        "branch_amplitude": (whirls["amplitude"].dims, whirls["amplitude"].values),
        "branch_stability": (whirls["stability"].dims, whirls["stability"].values),
    }
    dataset = labelled_dataset(
        "Special points of the synchronous whirls of a rotor system",
        {**variables, **found, **{n: e for n, e in others.items() if n not in whirls.coords}},
        {name: each for name, each in others.items() if name in whirls.coords},
        {"source": "rotor_ida closed forms", "most_touching": MOST_TOUCHING},
        kind="system_special_points",
    )
    return with_system_units(dataset, assembly.system)
