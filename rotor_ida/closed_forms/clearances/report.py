"""Whether a rotor system keeps clear of its close clearances, in the manner of API 617.

1. *Cases*: unbalance at the antinodes of each mode near the speeds of the machine.
2. *Response*: the largest axis of each orbit over the speed, at probes and clearances.
3. *Scale*: all is enlarged until the probes see the vibration limit at running speeds.
4. *Shares*: the scaled axes over the diametral clearances, and the margins of critical speeds.
5. *Rubs*: what follows a touch, computed exactly: synchronous rubs, and dry whip.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from typing import Unpack

import numpy as np
import xarray as xr

from rotor_ida.arrays import Column
from rotor_ida.checks import (
    LARGEST_NUMBER,
    check_axis,
    check_between,
    check_count,
    check_increasing,
    check_positive,
    shown,
)
from rotor_ida.closed_forms.clearances.critical_speeds import Peak, critical_modes, margins
from rotor_ida.closed_forms.clearances.response import (
    REACH,
    Cases,
    Problem,
    Response,
    cases_of,
    own_mass,
    peaks_of,
    response_to,
    scales_of,
)
from rotor_ida.closed_forms.clearances.rubs import Rubs, Touching, touching_of
from rotor_ida.closed_forms.clearances.words import ALLOWED, sentences
from rotor_ida.closed_forms.whirls.dry_whip import Whip
from rotor_ida.errors import InputError
from rotor_ida.model.assembly import Assembly, assemble, canonical
from rotor_ida.model.growth import growth_between, growth_of
from rotor_ida.model.rotor_system import RotorSystem, SystemParameters, changed_system
from rotor_ida.model.system_parts import check_clearances
from rotor_ida.results.archived_system import described_problem
from rotor_ida.results.growth_words import BEGINS, growing
from rotor_ida.results.in_si import takes_system
from rotor_ida.results.si_units import with_system_units
from rotor_ida.schema import STABILITY, VERDICT, labelled_dataset
from rotor_ida.units import SPEED_UNITS

# Vibration limit [m] up to a speed [rpm], and its part of the speed above.
LIMIT, LIMIT_SPEED = 25.4e-6, 12_000.0
MOST_POINTS = 20_000
# Least and largest multiple of the residual unbalance.
MULTIPLES = (1e-6, 1e6)
# Decay rates below this part of a critical speed are rounding.
UNDAMPED = 1e-12
# Largest part of the constant forces that may be left without balance.
HELD = 1e-6
REFERENCES = (
    "Public statements of API 617, 6.8.2, and API RP 684, SP6.8.2; H. F. Black, Journal of "
    "Mechanical Engineering Science 10, 1968, for dry whip"
)


@takes_system
def clearance_report(
    system: RotorSystem,
    *,
    speed: Sequence[float],
    probes: Sequence[str] | None = None,
    multiple: float = 2.0,
    vibration_limit: float | None = None,
    mass: float | None = None,
    points: int = 300,
    **changed: Unpack[SystemParameters],
) -> xr.Dataset:
    """Check the unbalance response of a rotor system at its close clearances, as API 617 does.

    Parameters
    ----------
    system : RotorSystem, Rotor or DimensionalRotor
        The rotor; its contacts are the close clearances. Its unbalance is the residual one; without
        any, that of each mode up to 1.5 times the maximum continuous speed, at its antinodes (see
        Notes). It need not be axisymmetric; what follows a touch is computed where it is.
    speed : sequence of float, shape (2,) or (3,)
        Minimum and maximum continuous speed, and the trip speed.
    probes : sequence of str, optional
        Nodes at which vibration is measured. Those near bearings see less than others, so that the
        scale factor is larger. Default: the nodes of the contacts.
    multiple : float
        How many times the residual unbalance is applied.
    vibration_limit : float, optional
        From peak to peak. Default: 25.4 um, times the root of 12,000 rpm over the maximum
        continuous speed where this is faster.
    mass : float, optional
        Mass of the rotor, for the residual unbalance. Default: that which moves with all nodes.
    points : int
        Number of speeds, besides those about each critical speed.
    contacts, unbalance, supports, bearings, gravity, static_force : optional
        In place of those of the system, as in `simulate`.

    Returns
    -------
    Dataset
        On ``(case, speed, contact)`` and ``(case, speed, probe)``: ``major_axis`` and
        ``probe_major_axis`` of the orbits, from peak to peak, before scaling; on ``case``:
        ``scale_factor``; on ``(case, contact)``: ``running_share`` of the diametral clearance that
        the scaled axis fills at continuous speeds, at the worst ``running_share_speed``, and
        ``passage_share``, from rest to the trip speed. On ``contact``: ``clearance_verdict``, as
        flags ``passes``, ``fails`` (above 75 per cent) and ``touches``; ``first_touch_speed``, the
        lowest up to the trip speed at which the scaled orbit fills the clearance; the largest
        ``rub_force`` of a synchronous rub with the scaled unbalance at continuous speeds, its
        ``rub_speed`` and ``rub_stability``; the same from rest to the trip speed, as
        ``passage_rub_force`` and so on;
        and of dry whip at the maximum continuous speed ``whip_speed``,
        ``whip_amplitude``, ``whip_force`` and ``whip_stability``. On ``critical``:
        ``critical_speed``, ``amplification_factor``, ``separation_margin`` and
        ``required_margin``. The attribute ``sentence`` has a line for each clearance.

    Raises
    ------
    InputError
        If an argument cannot be used; if a critical speed has no damping; if the motion without
        contact grows at one of `speed` or at a critical speed below the last of them: the message
        has rate and whirl speed.

    Notes
    -----
    *Unbalance.* `multiple` times ``6350 W/N`` g mm of the mass W [kg] at N [rpm], and at least
    0.254 g mm for each kg, is placed at the node of each lobe of a mode that moves most, with
    opposite phases on opposite sides. W is divided equally among the antinodes. The standard takes
    the static load of the nearest journal or an overhung mass, which the matrices do not contain:
    for these give the system an unbalance.

    *Scale.* The vibration limit ``A = min(25.4, 25.4 sqrt(12000/N))`` um over the largest axis at a
    probe at continuous speeds, at most 6. Scaled axes may fill 75 per cent of the diametral
    clearance. A static deflection or an offset centre is not counted in the verdict; the sentence
    adds it, by ``sag_share``, as if it pointed along the largest axis.

    *Margins.* Amplification factors are the speed of a peak over its width at 0.707 of the height
    (half power, ``1/sqrt(2)``);
    see `rotor_ida.closed_forms.clearances.critical_speeds.margins`.

    *Not public*, and left out: the wording of the 9th edition, its exceptions, and what it asks of
    models of bearings, seals and supports. The sources below apply the residual unbalance once;
    twice is what public discussions say of the 9th edition.

    *Bearings* with a table over the speed must have the continuous and the trip speed in it. "From
    rest" is from the lowest speed of the tables then, and nothing is sought above the highest.

    *Touches.* Rubs are those of `synchronous_response`, of one contact or two at a time, at 41
    continuous speeds, at as many from rest to the trip speed, about each critical speed, and then
    ever closer to the hardest. One that is stable only between two of these speeds may be missed.
    For dry whip see `rotor_ida.closed_forms.whirls.dry_whip`. Both need an axisymmetric rotor and
    stators; otherwise the attribute ``not_exact`` says why they are left out.

    References
    ----------
    ROSS, ``ross/api_report.py`` of July 2020, cites API RP 684, SP6.8.2.1, SP6.8.2.10, SP6.8.2.11
    and API 617, 4.8.2.11, for these formulas. K. Brun and R. Kurz, eds., "Compression Machinery
    for Oil and Gas", 2019, chapter 3, for the unbalance, ranges and the factor of 2.5.

    Examples
    --------
    >>> from rotor_ida import Contact
    >>> seal = Contact(node="disc", clearance=100e-6, stiffness=1e8, exponent=1.0, friction=0.1,
    ...                radius=0.05)
    >>> system = RotorSystem(mass=20 * np.eye(2), damping=4e3 * np.eye(2),
    ...                      stiffness=4e6 * np.eye(2), nodes={"disc": (0, 1)}, contacts=[seal])
    >>> report = clearance_report(system, probes=["disc"], speed=(800.0, 1000.0))
    >>> report.scale_factor.values.round(3), report.running_share.values.round(4)
    (array([6.]), array([[0.1091]]))
    >>> print(report.attrs["sentence"].split(";")[0])
    Contact 0 at 'disc' passes: the scaled orbit fills at most 11 % of the clearance at 7,639 rpm
    """
    system = changed_system(clearance_report, system, changed)
    problem = _problem(system, speed, probes, vibration_limit)
    multiple = check_between("multiple", multiple, *MULTIPLES)
    count = check_count("points", points, 2, MOST_POINTS)
    told: dict[str, object] = {"multiple": multiple, "points": count}
    if mass is not None:
        mass = check_positive("mass", mass, LARGEST_NUMBER)
    modes = critical_modes(problem.assembly, min(REACH * problem.high, problem.top))
    _check_stable(problem, [each.speed for each in modes])
    for mode in modes:
        if abs(mode.decay) <= UNDAMPED * mode.speed:
            raise InputError(
                "system must be damped at its critical speeds for a report, got no damping at "
                "{speed:.6g}",
                speed=mode.speed,
            )
    if system.unbalance:
        cases: Cases = [[replace(each, moment=multiple * each.moment) for each in system.unbalance]]
        own = [0] * len(modes)
    elif system.units != "SI":
        raise InputError("unbalance must be given without SI units, got None")
    elif not modes:
        raise InputError("unbalance must be given for a system without a critical speed, got None")
    else:
        told["rotor_mass"] = whole = mass or own_mass(problem)
        cases, own = cases_of(problem, modes, multiple * whole)
    unstable = growth_between(canonical(problem.assembly), problem.trip, problem.top)
    if unstable:
        told[BEGINS] = unstable[0][0]
    response = response_to(problem, modes, cases, count)
    touching = touching_of(response, modes, cases, scales_of(response))
    return _dataset(response, cases, peaks_of(response, modes, own), touching, told)


def _problem(system: RotorSystem, speed: object, probes: object, limit: object) -> Problem:
    """Return the checked problem."""
    speeds = check_increasing("speed", check_axis("speed", speed, largest=LARGEST_NUMBER))
    if speeds.size not in {2, 3}:
        raise InputError(f"speed must be two or three speeds, got {speeds.size}")
    check_positive("speed", speeds[0])
    assembly = assemble(system, speeds=speeds)
    if not system.contacts:
        raise InputError("contacts must be at least one clearance, got none")
    check_clearances(system.contacts)
    low, high, trip = (*speeds.tolist(), speeds[-1].item())[:3]
    if limit is None:
        if system.units != "SI":
            raise InputError("vibration_limit must be given without SI units, got None")
        limit = LIMIT * min(1.0, math.sqrt(LIMIT_SPEED * SPEED_UNITS["rpm"] / high))
    limit = check_positive("vibration_limit", limit, LARGEST_NUMBER)
    return Problem(assembly, low, high, trip, _probes(assembly, probes), limit)


def _check_stable(problem: Problem, critical: Sequence[float]) -> None:
    """Refuse a system whose motion without contact grows at one of the speeds that it reaches."""
    system = problem.assembly.system
    units = system.units
    reached = [each for each in critical if each < problem.trip]
    for speed in sorted({*reached, problem.low, problem.high, problem.trip}):
        if growth := growth_of(canonical(assemble(system.at(speed))), speed):
            raise InputError(
                "system must be stable for a report: at {speed} its motion without contact "
                f"{growing(growth.rate, growth.whirl_speed, units)}",
                speed=speed,
            )


def _probes(assembly: Assembly, given: object) -> tuple[str, ...]:
    """Return the names of nodes of a system, by default those of its contacts."""
    if given is None:
        return tuple(dict.fromkeys(each.node for each in assembly.contacts))
    if isinstance(given, str) or not isinstance(given, Sequence) or not given:
        raise InputError(f"probes must be a list of names of nodes, got {shown(given)}")
    for node in given:
        if not isinstance(node, str):
            raise InputError(f"probes must be a list of names of nodes, got {shown(given)}")
        assembly.system.rows(node)  # refuses an unknown one
    return tuple(given)


def _dataset(
    response: Response,
    cases: Cases,
    peaks: Sequence[Peak],
    touching: Touching,
    told: dict[str, object],
) -> xr.Dataset:
    """Return the report as a labelled dataset."""
    problem = response.problem
    assembly, count = problem.assembly, len(problem.assembly.contacts)
    both = np.array([margins(peak, problem.low, problem.high) for peak in peaks]).reshape(-1, 2)
    variables: dict[str, Column] = {
        "major_axis": (("case", "speed", "contact"), response.axes[..., :count]),
        "probe_major_axis": (("case", "speed", "probe"), response.axes[..., count:]),
        **_shares(response), **_sag(problem),
        **_applied(cases, list(assembly.system.nodes)),
        "critical_speed": ("critical", np.array([each.speed for each in peaks])),
        "amplification_factor": ("critical", np.array([each.amplification for each in peaks])),
        "separation_margin": ("critical", both[:, 0]),
        "required_margin": ("critical", both[:, 1]),
        **_rubs("rub", touching.running), **_rubs("passage_rub", touching.passing),
        **_whips(touching.whips),
        **described_problem(assembly),
    }  # fmt: skip
    coordinates: dict[str, Column] = {
        "speed": ("speed", response.speeds), "case": ("case", np.arange(len(cases))),
        "node": ("node", np.array(list(assembly.system.nodes), str)),
        "probe": ("probe", np.array(problem.probes, str)),
    }  # fmt: skip
    told = {
        "source": "rotor_ida closed forms", "references": REFERENCES, **told,
        "running_speeds": np.array([problem.low, problem.high, problem.trip]),
    }  # fmt: skip
    if touching.not_exact:
        told["not_exact"] = touching.not_exact
    dataset = labelled_dataset(
        "Close clearances of a rotor system", variables, coordinates, told, kind="clearance_report"
    )
    dataset = with_system_units(dataset, assembly.system)
    return dataset.assign_attrs(sentence=sentences(dataset))


def _shares(response: Response) -> dict[str, Column]:
    """Return how much of each clearance the scaled orbits fill, and the verdicts."""
    problem, scales = response.problem, scales_of(response)
    running, passing = (
        np.array([[response.largest(case, place, low, high)
                   for place in range(problem.diameters.size)]
                  for case in range(len(response.axes))])
        for low, high in ((problem.low, problem.high), (response.speeds[0], problem.trip))
    )  # fmt: skip
    part = scales[:, np.newaxis] / problem.diameters
    with np.errstate(divide="ignore"):  # without unbalance it never touches
        sizes = problem.diameters / scales[:, np.newaxis]
    touches = [[response.reached(case, place, size, problem.trip)
                for place, size in enumerate(sizes[case])]
               for case in range(len(response.axes))]  # fmt: skip
    shares = running[..., 1] * part
    worst = shares.max(axis=0)
    verdict = np.where(worst > ALLOWED, VERDICT["fails"], VERDICT["passes"])
    verdict[worst >= 1.0] = VERDICT["touches"]
    along = ("case", "contact")
    return {
        "scale_factor": ("case", scales), "vibration_limit": ((), problem.limit),
        "running_share": (along, shares), "running_share_speed": (along, running[..., 0]),
        "passage_share": (along, passing[..., 1] * part),
        "first_touch_speed": ("contact", np.fmin.reduce(np.array(touches), axis=0)),
        "clearance_verdict": ("contact", verdict.astype(np.int8)),
    }  # fmt: skip


def _sag(problem: Problem) -> dict[str, Column]:
    """Return how much of each clearance the rotor fills at rest, where supports alone hold it."""
    assembly, parts = problem.assembly, []
    centres = np.array([each.centre for each in assembly.contacts])
    if not assembly.force.any():
        return {}
    for speed in (problem.low, problem.high):
        stiffness = assembly.stiffness_at(speed)
        at_rest = np.linalg.lstsq(stiffness, assembly.force)[0]
        if not np.allclose(
            stiffness @ at_rest, assembly.force, rtol=0.0, atol=HELD * np.abs(assembly.force).max()
        ):
            return {}
        aside = (assembly.rows @ at_rest).reshape(centres.shape) - centres
        parts.append(2.0 * np.hypot(*aside.T) / problem.diameters[: len(centres)])
    return {"sag_share": ("contact", np.max(parts, axis=0))}


def _applied(cases: Cases, names: list[str]) -> dict[str, Column]:
    """Return the unbalance of each case at each node."""
    applied = np.zeros((len(cases), len(names)), complex)
    for row, case in zip(applied, cases, strict=True):
        for each in case:
            row[names.index(each.node)] += each.moment * np.exp(1j * each.phase)
    along = ("case", "node")
    return {
        "applied_unbalance": (along, np.abs(applied)),
        "applied_phase": (along, np.angle(applied) + 0.0),
    }


def _rubs(prefix: str, rubs: Rubs) -> dict[str, Column]:
    return {
        f"{prefix}_{name}": ("contact", getattr(rubs, name))
        for name in ("force", "speed", "stability")
    }


def _whips(whips: Sequence[Whip | None]) -> dict[str, Column]:
    """Return dry whip at each contact, NaN where friction cannot hold any."""
    table = np.array([
        (np.nan,) * 3 if each is None else (each.whirl_speed, each.amplitude, each.normal_force)
        for each in whips
    ]).reshape(-1, 3)  # fmt: skip
    words = ["absent" if each is None else "stable" if each.growth_rate < 0.0 else "unstable"
             for each in whips]  # fmt: skip
    return {
        "whip_speed": ("contact", table[:, 0]), "whip_amplitude": ("contact", table[:, 1]),
        "whip_force": ("contact", table[:, 2]),
        "whip_stability": ("contact", np.array([STABILITY[each] for each in words], np.int8)),
    }  # fmt: skip
