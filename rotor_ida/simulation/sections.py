"""Sections through a motion: its states once a revolution, or at each contact event."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from typing import Any, Literal, NamedTuple, Unpack

import numpy as np
import xarray as xr

from rotor_ida.arrays import Values
from rotor_ida.checks import (
    MOST_NUMBERS,
    check_between,
    check_choice,
    check_count,
    check_duration,
    check_nonnegative,
    check_progress,
    check_real,
    listed,
    shown,
)
from rotor_ida.core.runs import NO_STOP
from rotor_ida.errors import InputError
from rotor_ida.model.assembly import Assembly
from rotor_ida.model.equations import rotated
from rotor_ida.model.rotor import DimensionalRotor, Rotor
from rotor_ida.model.rotor_system import RotorSystem, SystemParameters, changed_system
from rotor_ida.parallel import Progress, Stop, interruptible, percentage, shows_progress
from rotor_ida.results.archived_system import described_problem
from rotor_ida.results.checked_run import parameter_coordinates
from rotor_ida.results.in_si import takes_rotors
from rotor_ida.results.provenance import provenance
from rotor_ida.results.question import Question
from rotor_ida.results.si_units import with_system_units
from rotor_ida.schema import Column, labelled_dataset
from rotor_ida.simulation.course import MOST_RADIANS
from rotor_ida.simulation.crossings import (
    EVENTS,
    RUBS,
    Crossings,
    check_knots,
    crossings_of,
)
from rotor_ida.simulation.flow import DiscFlow, Flow
from rotor_ida.simulation.options import Method, Options, check_can_be_followed, passes_soon
from rotor_ida.simulation.runs import LOOSEST_RTOL, TIGHTEST_RTOL
from rotor_ida.simulation.simulate import DEFAULTS
from rotor_ida.simulation.starts import Start, begun_in_modes, start_of, start_of_system
from rotor_ida.simulation.system_flow import SAMPLES_A_REVOLUTION, SettlingProblem, SystemFlow

At = Literal["revolution", "entry", "exit", "peak", "roll", "slip", "reverse"]

PLACES = ("revolution", "entry", "exit", "peak", *RUBS)
# How often a motion of a system is simulated until its peaks are located, about.
RUNS_TO_PEAKS = 8
# The absolute tolerance of one disc; a rotor system scales its own.
ATOL = 1e-12
NAMES = ("rotating_x", "rotating_y", "rotating_vx", "rotating_vy")


@shows_progress
@takes_rotors(disc=("atol",), system=("contact", "modes"), needed=(), defaults=DEFAULTS)
def poincare_section(
    rotor: Rotor | DimensionalRotor | RotorSystem,
    *,
    speed: float | None = None,
    start: Start = None,
    revolutions: int,
    skip: int = 0,
    at: At = "revolution",
    contact: int | str | None = None,
    phase: float = 0.0,
    modes: int | None = None,
    rtol: float = 1e-10,
    atol: float = ATOL,
    method: Method | None = None,
    progress: Progress | bool | None = None,
    **changed: Unpack[SystemParameters],
) -> xr.Dataset:
    """Return the states at which a motion crosses a section, in the rotating frame.

    Parameters
    ----------
    rotor : Rotor, DimensionalRotor or RotorSystem
        The rotor, with a speed above 0. For a `DimensionalRotor` numbers with a unit are in SI
        units, as for `simulate`.
    speed : float, optional
        Spin speed of a `RotorSystem`, not 0; it may be negative. That of one disc is a parameter of
        the rotor.
    start : array_like, shape (4,), (q, velocity), "settled", "rest" or Dataset, optional
        ``(x, y, vx, vy)`` at time 0 [dimensionless], a word, or a result that ends in a state;
        default: at rest, in equilibrium with the load. See `rotor_ida.simulate`, also for a
        `RotorSystem`.
    revolutions : int
        Number of revolutions in the section, at most 10 million.
    skip : int
        Number of earlier revolutions to skip as a transient, at most 10 million.
    at : {"revolution", "entry", "exit", "peak", "roll", "slip", "reverse"}
        Once a revolution, when the unbalance points along x; at each contact entry or exit; at
        each local maximum of the distance from the bearing axis; or, with friction, where the disc
        begins to roll or to slip, or reverses its sliding. A peak of a `RotorSystem` is a local
        maximum of the distance of a contact from the centre of its stator.
    contact : int or str, optional
        Of a `RotorSystem` the contact whose events or peaks are meant: its number from 0 on, or the
        name of its node. It must be given where there are several.
    phase : float
        Angle of the unbalance from x at the section by revolutions, below 2 pi [rad]; of a
        `RotorSystem` that of the mark from which the phases of its unbalance are counted. Under a
        load the section depends on it.
    modes : int, optional
        Of a `RotorSystem`, as in `simulate`.
    rtol, atol : float
        Relative and absolute tolerance [dimensionless]. A `RotorSystem` has the relative one alone,
        from 1e-14 to 1e-4.
    method : {"adams", "bdf", "ida", "taylor"}, optional
        Solver of the contacts of one disc, and its default, as for `rotor_ida.simulate`. Peaks
        and a `RotorSystem` are computed by Taylor series.
    progress : callable or bool, optional
        As for `rotor_ida.simulate`.
    contacts, unbalance, supports, bearings, gravity, static_force : optional
        In place of those of a `RotorSystem`, as in `simulate`.

    Returns
    -------
    Dataset
        ``crossing_time``, counted from the start, and ``rotating_x rotating_y rotating_vx
        rotating_vy`` on ``crossing`` [dimensionless]. Of a `RotorSystem` these are those of each
        node, on ``(crossing, node)``. ``crossing_state`` is q and velocity on fixed axes, and
        ``final_state`` the state after the last revolution, a start of another call.

    Raises
    ------
    InputError
        If an argument cannot be used.
    SimulationError
        If the solver gives up.

    Notes
    -----
    In the rotating frame the motion is autonomous. A synchronous whirl is one point of the
    section by revolutions. A response of period n revolutions is n points, a quasi-periodic one
    a closed curve. Events and peaks lie on a surface of the phase space: there a motion that is
    periodic in the rotating frame is a few points, whatever its period.
    A load rotates in this frame. Under a load only the section by revolutions is a map, the
    stroboscopic one, whose fixed points and cycles are the periodic motions; sections at events
    and peaks ignore the angle of the load. While the disc rolls on the stator the section has at
    most three dimensions, since the tangential velocity is that of the rim.
    Revolutions are sampled at exactly ``(phase + 2 pi n)/omega``. Entries, exits and the like are
    the events of the simulation. Peaks are roots of ``x vx + y vy``, polished to about 1e-12 of the
    state. A constant radius has no peaks. Those of a `RotorSystem` lie between 64 samples in a
    revolution, and between events: of two that lie closer together both may be missed.

    References
    ----------
    F. C. Moon, "Chaotic and Fractal Dynamics", Wiley, 1992, chapter 2.

    Examples
    --------
    >>> section = poincare_section(Rotor(omega=2.0, zeta=0.07, delta0=0.0), start=(0, 0, 0, 0),
    ...                            revolutions=3, skip=150)
    >>> section.rotating_x.values.round(6)
    array([-1.40959, -1.40959, -1.40959, -1.40959])

    The same disc as a system:

    >>> disc = Rotor(omega=2.0, zeta=0.07, delta0=2.0).system()
    >>> same = poincare_section(disc, speed=2.0, revolutions=20, skip=150, at="entry")
    >>> same.rotating_x.dims, float(same.rotating_x.std("crossing").max()) < 1e-7
    (('crossing', 'node'), True)
    """
    progress = check_progress(progress)
    count, left_out = check_count("revolutions", revolutions), check_count("skip", skip, minimum=0)
    angle, watch = _checked_place(at, phase), list[Callable[[], float]]()
    if isinstance(rotor, RotorSystem):
        check_taylor(method, "a section")
        given = changed_system(poincare_section, rotor, changed)
        asked = _of_system(given, start, {
            "speed": _checked_speed(speed), "revolutions": count, "skip": left_out, "at": at,
            "contact": contact, "phase": angle, "modes": modes,
            "rtol": check_between("rtol", rtol, TIGHTEST_RTOL, LOOSEST_RTOL),
        })  # fmt: skip
    else:
        assert isinstance(rotor, Rotor)
        assert method is not None
        options = Options(rtol=rtol, atol=atol, method=method)
        asked = _of_disc(rotor, start, options, count, left_out, at, angle)
    flow, lead = asked.flow, left_out * asked.flow.revolution

    def follow(stop: Stop) -> Crossings:
        own = flow.but(stop=stop, watch=watch)
        begun = _later(own, asked.state, lead) if left_out else asked.state
        return crossings_of(own, begun, count, at, angle, asked.contact)

    runs = RUNS_TO_PEAKS if at == "peak" and isinstance(flow, SystemFlow) else 1
    told = percentage(progress, watch, lead + runs * count * flow.revolution)
    soon = isinstance(flow, DiscFlow) and passes_soon(
        flow.rotor, asked.state, lead + count * flow.revolution, flow.options.method
    )
    found = interruptible(follow, told=told, at_once=soon)
    if progress is not None:
        progress(100, 100)
    return _dataset(flow, found._replace(times=lead + found.times), asked.attributes)


class _Asked(NamedTuple):
    """A section that is asked for: how a rotor moves, and from where; at which contact."""

    flow: Flow
    state: Values
    contact: int
    attributes: Mapping[str, Any]


def _later(flow: Flow, state: Values, duration: float) -> Values:
    """Return the state after a time; of one disc by the method of the section."""
    if isinstance(flow, DiscFlow):
        end = flow.orbit(state, duration, np.empty(0)).end
        return rotated(end, -flow.speed * duration)
    return flow.after(state, duration)


def _dataset(flow: Flow, crossings: Crossings, attributes: Mapping[str, Any]) -> xr.Dataset:
    """Return a section through a motion as a labelled dataset."""
    dims = ("crossing", "node")
    columns: dict[str, Column] = {"crossing_time": ("crossing", crossings.times)}
    columns |= {name: (dims[: each.ndim], np.ascontiguousarray(each))
                for name, each in zip(NAMES, crossings.states, strict=True)}  # fmt: skip
    coordinates: dict[str, Column] = {"crossing": ("crossing", np.arange(crossings.times.size))}
    if isinstance(flow, DiscFlow):
        coordinates = parameter_coordinates(flow.rotor) | coordinates
        return labelled_dataset(
            "Section through one motion", columns, coordinates, attributes, kind="section"
        )
    assert isinstance(flow, SystemFlow)
    assembly, moved = flow.problem.assembly, flow.problem.found.to_q(crossings.motions)
    coordinates["node"] = ("node", np.array(list(assembly.system.nodes), str))
    columns |= {
        "crossing_state": (("crossing", "coordinate"), moved.reshape(-1, 2 * assembly.size)),
        "final_state": ("component", flow.in_q(crossings.end)), **described_problem(assembly),
    }  # fmt: skip
    found = labelled_dataset(
        "Rotor system: section through one motion",
        columns,
        coordinates,
        attributes,
        kind="system_section",
    )
    return with_system_units(found, assembly.system)


def check_taylor(method: object, what: str) -> None:
    """Refuse another method than Taylor series of a rotor system."""
    if not (method is None or (isinstance(method, str) and method == "taylor")):
        raise InputError(f"method must be taylor for {what} of a rotor system, got {shown(method)}")


def _checked_place(at: object, phase: object) -> float:
    """Return the angle of a section, which only one by revolutions has."""
    check_choice("at", at, PLACES)
    angle = checked_angle(phase)
    if at != "revolution" and angle:
        raise InputError(f"phase must be 0 for a section at each {at}, got {angle!r}")
    return angle


def checked_angle(phase: object) -> float:
    """Return an angle of the unbalance within a revolution."""
    if (angle := check_nonnegative("phase", phase)) >= 2.0 * math.pi:
        raise InputError(f"phase must be below 2 pi, got {angle!r}")
    return angle


def _of_disc(
    rotor: Rotor, start: Any, options: Options, count: int, skip: int, at: At, angle: float
) -> _Asked:
    """Return a section that is asked for of one disc, checked."""
    first = start_of(rotor, start)
    check_can_be_followed(rotor, first)
    if rotor.omega == 0.0:
        raise InputError(
            "{name} must be positive for a section, got {value}", name="omega", value=0.0
        )
    if at in RUBS and rotor.friction == 0.0:
        raise InputError(f"friction must be positive for a section at each {at}, got 0.0")
    if at in EVENTS and rotor.delta0 == 0.0:
        raise InputError(
            "{name} must be positive for a section at each {at}, got {value}",
            name="delta0", at=at, value=0.0,
        )  # fmt: skip
    flow = DiscFlow(rotor, options=options)
    duration = (skip + count) * flow.revolution
    check_duration("the time of skip and revolutions", duration, rotor.omega)
    if at == "peak":
        check_knots("the time of revolutions", rotor, count * flow.revolution)
    told: dict[str, Any] = {
        "section": at, "start": np.array(first), "revolutions": count, "skip": skip,
    }  # fmt: skip
    told |= {"phase": angle} if at == "revolution" else {}
    return _Asked(flow, np.array(first), 0, provenance(options.attributes()) | told)


def _of_system(system: RotorSystem, start: Any, told: dict[str, Any]) -> _Asked:
    """Return a section that is asked for of a rotor system by arguments, checked."""
    at, modes, contact = told["at"], told["modes"], told["contact"]
    assembly, begun = begun_in_modes(system, modes, start)
    if at == "revolution" and contact is not None:
        raise InputError(
            f"contact must be left out for a section once a revolution, got {shown(contact)}"
        )
    number = None if at == "revolution" else _number_of(assembly, contact, at)
    problem, first = (
        SettlingProblem.of(assembly, told["rtol"]), start_of_system(assembly, begun, told["speed"])
    )  # fmt: skip
    flow = SystemFlow.at(problem, told["speed"], NO_STOP)
    _check_size(flow, told["skip"], told["revolutions"], at)
    known = {name: each for name, each in (told | {"contact": number}).items() if each is not None}
    left = {"at"} if number is None else {"at", "phase"}
    attributes = provenance({"method": "taylor"}) | {"section": at}
    attributes |= {name: each for name, each in known.items() if name not in left}
    kept = begun if isinstance(start, xr.Dataset) else start
    question = Question("poincare_section", {"rotor": system, "start": kept, **known})
    state = flow.given_state(np.append(first, problem.race_speeds))
    return _Asked(flow, state, number or 0, attributes | question.attribute())


def _checked_speed(speed: object) -> float:
    """Return the speed of a rotor system at which there are revolutions."""
    if speed is None:
        raise InputError("speed must be given for a section of a rotor system, got None")
    omega = check_real("speed", speed)
    if omega == 0.0:
        raise InputError("{name} must not be 0 for a section, got {value}", name="speed", value=0.0)
    return omega


def _check_size(flow: SystemFlow, skip: int, count: int, at: str) -> None:
    """Refuse a motion that would take hours, or whose samples do not fit into memory."""
    longest = MOST_RADIANS["system"] / (flow.request.fastest + abs(flow.speed))
    if not (duration := (skip + count) * flow.revolution) <= longest:
        raise InputError(
            "skip and revolutions must last at most {duration:.4g}, as the system moves at up to "
            "{fastest:.4g}, got {time:.4g}; fewer modes lower that",
            duration=longest, fastest=flow.request.fastest, time=duration,
        )  # fmt: skip
    each = 2 * flow.problem.assembly.size * (SAMPLES_A_REVOLUTION if at == "peak" else 1)
    check_count("revolutions", count, maximum=max(MOST_NUMBERS // each, 1))


def _number_of(assembly: Assembly, contact: object, at: str) -> int:
    """Return the number of the contact that is meant, by its number or the name of its node."""
    nodes = [each.node for each in assembly.contacts]
    if not nodes:
        raise InputError(f"at must be revolution for a system without contacts, got {shown(at)}")
    if contact is None and len(nodes) > 1:
        allowed = listed([f"{number} at {shown(each)}" for number, each in enumerate(nodes)], "or")
        raise InputError(f"contact must be given for a section at each {at}: {allowed}")
    number = _named(nodes, contact)
    if at in RUBS and assembly.contacts[number].friction == 0.0:
        raise InputError(f"friction must be positive for a section at each {at}, got 0.0")
    return number


def _named(nodes: Sequence[str], contact: object) -> int:
    """Return the number of a contact, given as that or by the name of its node."""
    if contact is None:
        return 0
    if not isinstance(contact, str):
        return check_count("contact", contact, minimum=0, maximum=len(nodes) - 1)
    if (here := nodes.count(contact)) == 1:
        return nodes.index(contact)
    if here:
        raise InputError(f"contact must be a number, as {shown(contact)} has {here} contacts")
    allowed = listed([shown(each) for each in dict.fromkeys(nodes)], "or")
    raise InputError(f"contact must be {allowed}, got {shown(contact)}")
