"""The drop of a rotor that magnetic bearings levitate on its touchdown bearings.

When a support fails, its spring, its damper and its static load are gone at once. A support that
stays keeps its spring, its damper and the load that it carried: its integrator is too slow for a
drop.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Unpack

import numpy as np
import numpy.typing as npt
import xarray as xr

from rotor_ida.arrays import Column, Values
from rotor_ida.checks import (
    check_choice,
    check_nonnegative,
    check_positive,
    check_real,
    shown,
)
from rotor_ida.closed_forms.receptances import solved_motions
from rotor_ida.errors import InputError
from rotor_ida.model.assembly import Assembly, assemble
from rotor_ida.model.data_sheet import GRAVITY
from rotor_ida.model.reduction import check_modes, in_modes
from rotor_ida.model.rotor_system import (
    RotorSystem,
    SystemParameters,
    changed_system,
    held_at_centre,
    with_supports,
)
from rotor_ida.model.system_parts import Support
from rotor_ida.parallel import Progress, shows_progress
from rotor_ida.results.in_si import takes_system
from rotor_ida.results.si_units import with_system_units
from rotor_ida.schema import labelled
from rotor_ida.simulation.course import MOST_RADIANS, SYSTEM_LIMITS, Course, course_of, held
from rotor_ida.simulation.runs import SystemMethod, run_of_cases
from rotor_ida.simulation.starts import Start, begun_in_modes
from rotor_ida.steady.drop_figures import figures_of_drop

TITLE = "Rotor system: drop on its touchdown bearings"


@shows_progress
@takes_system
def drop(
    system: RotorSystem,
    *,
    speed: float,
    duration: float,
    failing: Sequence[str] | None = None,
    phase: float = 0.0,
    inertia: float | None = None,
    drag: float = 0.0,
    clearances: Mapping[str, float] | None = None,
    capacities: Mapping[str, float] | None = None,
    start: tuple[npt.ArrayLike, npt.ArrayLike] | xr.Dataset | None = None,
    samples: int | npt.ArrayLike | None = None,
    modes: int | None = None,
    more_modes: int | None = None,
    rtol: float = 1e-10,
    method: SystemMethod = "taylor",
    progress: Progress | bool | None = None,
    **changed: Unpack[SystemParameters],
) -> xr.Dataset:
    """Simulate the drop of a levitated rotor: fall, impacts, sliding, rolling, whirl, coast-down.

    Parameters
    ----------
    system : RotorSystem, Rotor or DimensionalRotor
        The rotor; its stiffness may be singular. Its supports are the magnetic bearings; without
        any the rotor starts where it would whirl freely. Its contacts are the touchdown bearings,
        and whatever else it may touch: at least 1. Its gravity is (0, -9.80665) in SI units unless
        given.
    speed : float
        Spin speed at the drop.
    duration : float
        Time to simulate from the drop on.
    failing : sequence of str, optional
        Nodes of the supports that fail at time 0. Default: all. The others keep springs, dampers
        and the static load that they carried.
    phase : float
        Angle by which the rotor is turned at the drop [rad]: it adds to that of each unbalance.
    inertia : float, optional
        Moment of inertia of the rotor about its axis: the drive is off, and friction and drag
        decelerate the rotor. Default: the speed is held.
    drag : float
        Drag torque over speed, with an inertia.
    clearances : mapping of str to float, optional
        Other close clearances by node: only compared with the motion, not touched.
    capacities : mapping of str to float, optional
        Load capacities of the bearings by node, such as static load ratings of ball bearings: only
        compared with the largest force.
    start : (q, velocity) or Dataset, optional
        State at the drop, or a result that ends in it. Default: the levitated steady state.
    samples, modes, more_modes, rtol, method, progress : optional
        As in `simulate`. By default the samples resolve the whirls in the bearings too; of
        given ones, a whirl that turns by half a turn between two shows the wrong sense.
    contacts, unbalance, supports, bearings, gravity, static_force : optional
        In place of those of the system, as in `simulate`.

    Returns
    -------
    Dataset
        A run as from `run_up`, at time 0 in the state of the drop; and on ``contact``:
        ``largest_force``, ``mean_contact_force`` while in contact, ``largest_impulse`` of one
        complete contact, ``total_impulse``, ``contact_count``, ``total_contact_time``,
        ``longest_contact_time``, ``excursion`` over the clearance, ``total_heat``,
        ``total_contact_loss``, ``first_roll_time``, ``largest_race_speed`` (in size, between
        events too) and its ``race_speed_time`` (NaN if it is that at the drop), the longest whirl
        by its ``whirl_turns``, ``whirl_speed`` and ``whirl_sense`` (from three turns on), and
        ``rest_time``, from which the contact lasts to the end; with capacities also ``load_ratio``,
        the largest force over them. On ``node`` ``largest_radius`` (at samples); on ``support`` its
        ``support_load``; and ``standstill_time``, an event after which the speed stays below
        one per cent of that at the drop, and ``standstill_time_error``; NaN if it does not, as of
        a rotor that rocks.

    Raises
    ------
    InputError
        If an argument cannot be used, or the levitated rotor touches a bearing.
    SimulationError
        If the integration fails.
    InvariantError
        If the result contradicts the mechanics.

    Notes
    -----
    Before the drop each support holds its node at the centre, whatever static load that takes, and
    the rotor whirls about this position by its unbalance, as linear springs and dampers allow. At
    time 0 the failing supports are gone. Then ``J Omega' = -drag Omega - sum R_j T_j - (reaction of
    the unbalance) + sum m e x g``, the last by the weight of each unbalance.

    After the `horizon` of the run the motion depends on rounding: see `drop_ensemble`.

    Examples
    --------
    A rigid rotor of 20 kg falls through 0.2 mm in 6.4 ms:

    >>> from rotor_ida import Contact
    >>> bearing = Contact(node="disc", clearance=2e-4, stiffness=2e9, damping=1.0, friction=0.1,
    ...                   radius=0.03)
    >>> system = RotorSystem(mass=np.diag([20.0, 20.0]), stiffness=np.zeros((2, 2)),
    ...                      nodes={"disc": (0, 1)}, contacts=[bearing],
    ...                      supports=[Support(node="disc", stiffness=2e6, damping=2e3)])
    >>> run = drop(system, speed=500.0, duration=0.2, inertia=0.08)
    >>> float(run.event_time[0].round(6)), float(run.peak_force[0].round(1))
    (0.006387, 1574.7)
    >>> run.support_load.values.round(1)
    array([[  0. , 196.1]])
    """
    system = changed_system(drop, system, changed)
    if not system.contacts:
        raise InputError("contacts must be at least one for a drop, got none")
    omega, turned = check_real("speed", speed), check_real("phase", phase)
    end = check_positive("duration", duration)
    if not abs(omega) * end <= MOST_RADIANS["system"]:
        raise InputError(
            "{name} must be at most {most:.4g} in a duration of {duration}, got {value}",
            name="speed", most=MOST_RADIANS["system"] / end, duration=end, value=omega,
        )  # fmt: skip
    gaps = _by_node(("clearances", "clearance"), clearances, list(system.nodes))
    limits = _by_node(
        ("capacities", "capacity"), capacities, [each.node for each in system.contacts]
    )
    check_modes(modes, more_modes)
    fails = _check_failing(system.supports, failing)
    has_weight = system.gravity is not None or system.gravity_in_static_force is not None
    if not has_weight and system.units == "SI":
        system = replace(system, gravity=(0.0, -GRAVITY))
    free = replace(with_unbalance_at(system, turned), supports=())
    course = _course(omega, end, inertia, drag)
    if course.profile.is_held:
        free = free.at(omega)
    if isinstance(start, xr.Dataset):
        if turned:
            raise InputError(f"phase must be left out with a result as the start, got {phase!r}")
        _, start = begun_in_modes(free, modes, start)
    all_modes = [modes] if more_modes is None else [modes, more_modes]
    cases = [_released(*in_modes(free, number, start), system.supports, fails, omega)
             for number in all_modes]  # fmt: skip
    run = run_of_cases(
        [(left, begun) for left, begun, _ in cases], course,
        samples=samples, rtol=rtol, method=method, progress=progress,
        modes={"modes": modes, "more_modes": more_modes}, whirls=True,
    )  # fmt: skip
    columns = figures_of_drop(run, gaps, limits) | cases[0][2]
    return _dataset(system, run, columns, {"phase": turned})


def with_unbalance_at(system: RotorSystem, angle: float) -> RotorSystem:
    """Return a system whose unbalance is ahead by an angle."""
    ahead = [replace(each, phase=each.phase + angle) for each in system.unbalance]
    return replace(system, unbalance=ahead)


def _course(speed: float, duration: float, inertia: float | None, drag: float) -> Course:
    """Return the course of the speed, held or by drag and friction."""
    resistance = check_nonnegative("drag", drag)
    if inertia is None:
        if resistance > 0.0:
            raise InputError("inertia must be given with drag, got {drag=} alone", drag=resistance)
        return held(speed, duration)
    given = {"torque": (0.0, resistance), "inertia": inertia}
    return course_of(speed, given, duration, SYSTEM_LIMITS)


def _by_node(
    names: tuple[str, str], given: Mapping[str, float] | None, nodes: Sequence[str]
) -> dict[str, float]:
    """Return positive numbers by known nodes; all of them, and one, have names."""
    if given is None:
        return {}
    several, one = names
    if not isinstance(given, Mapping):
        raise InputError(f"{several} must be numbers by nodes, got {shown(given)}")
    for node in given:
        check_choice(f"node in {several}", node, nodes)
    return {node: check_positive(f"{one} at {shown(node)}", each) for node, each in given.items()}


def _check_failing(supports: Sequence[Support], failing: object) -> list[bool]:
    """Return which supports fail."""
    names = [each.node for each in supports]
    if failing is None:
        return [True] * len(names)
    if isinstance(failing, str) or not isinstance(failing, Sequence) or not failing:
        raise InputError(f"failing must be a list of nodes of supports, got {shown(failing)}")
    if not names:
        raise InputError("failing must be left out, as there are no supports")
    for name in failing:
        check_choice("support in failing", name, names)
    return [name in failing for name in names]


def _levitated(
    assembly: Assembly, supports: Sequence[Support], speed: float
) -> tuple[Values, Values]:
    """Return the steady state of a system whose supports hold their nodes at the centre.

    It is displacement and velocity on the steady whirl, shape (2, n); with it come the static
    forces of the supports on the rotor, shape (support, 2).

    Parameters
    ----------
    assembly : Assembly
        The system with the springs and dampers of its supports.
    supports : sequence of Support
        Its supports.
    speed : float
        Spin speed.

    Notes
    -----
    At rest ``K q = f + B' p`` and ``B q = 0``, with the rows B of the supports and their loads p.
    The whirl ``Re(z exp(i Omega t))`` about it has
    ``(K - Omega**2 M + i Omega (C + Omega G)) z = Omega**2 (u_c - i u_s)``.
    """
    size, system = assembly.size, assembly.system
    rows = np.zeros((2 * len(supports), size))
    for number, each in enumerate(supports):
        rows[2 * number : 2 * number + 2, : system.size] = system.rows(each.node)
    still, loads = held_at_centre(assembly.stiffness, assembly.force, rows)
    force = speed**2 * (assembly.unbalance[0] - 1j * assembly.unbalance[1])
    whirl = np.zeros(size, complex)
    if force.any():
        whirl = solved_motions(assembly, np.array([speed]), force[:, np.newaxis])[0, :, 0]
    start = np.array([still + whirl.real, (1j * speed * whirl).real])
    return start, loads.reshape(-1, 2)


def _released(
    free: RotorSystem, start: Start, supports: Sequence[Support], fails: Sequence[bool],
    speed: float,
) -> tuple[RotorSystem, Start, dict[str, Column]]:  # fmt: skip
    """Return the system that the failing supports have left, its start, and what supports are."""
    held = assemble(with_supports(free, supports)).at(speed)
    state, loads = _levitated(held, supports, speed)
    if start is None:
        for number, contact in enumerate(held.contacts):
            reach = float(np.hypot(*(held.rows[number] @ state[0] - contact.centre)))
            if not reach < contact.clearance:
                raise InputError(
                    "contacts must be clear of the levitated rotor, got contact {number} at node "
                    "{node!r} at {reach:.4g} with {clearance=}",
                    number=number, node=contact.node, reach=reach, clearance=contact.clearance,
                )  # fmt: skip
        start = (state[0], state[1])
    stays = [each for each, gone in zip(supports, fails, strict=True) if not gone]
    own = np.zeros(free.size) if free.static_force is None else free.static_force.copy()
    for each, load, gone in zip(supports, loads, fails, strict=True):
        own[: free.size] += 0.0 if gone else free.rows(each.node).T @ load
    left = with_supports(free, stays) if stays else free
    system = replace(left, static_force=own if own.any() else None)
    return system, start, _told(supports, fails, loads)


def _told(supports: Sequence[Support], fails: Sequence[bool], loads: Values) -> dict[str, Column]:
    """Return the supports as variables."""
    both = ("support", "axis")

    def column(name: str) -> Values:
        return np.array([getattr(each, name) for each in supports], float).reshape(-1, 2)

    return {
        "support_node": ("support", np.array([each.node for each in supports], str)),
        "support_fails": ("support", np.array(fails, np.int8)),
        "support_stiffness": (both, column("stiffness")),
        "support_damping": (both, column("damping")),
        "support_load": (both, loads),
    }


def _dataset(
    system: RotorSystem, run: xr.Dataset, columns: Mapping[str, Column], told: Mapping[str, object]
) -> xr.Dataset:
    """Return a run as that of a drop."""
    variables = {name: labelled(name, *column) for name, column in columns.items()}
    dataset = with_system_units(run.assign(variables), system)
    dataset["total_impulse"].attrs["long_name"] = "impulse of all contacts"
    dataset.attrs |= {**told, "title": TITLE, "result_kind": "drop"}
    return dataset
