"""Many run-ups over rate, phase of the unbalance and parameters."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace
from functools import partial
from itertools import product
from typing import Any, Unpack

import numpy as np
import numpy.typing as npt
import xarray as xr

from rotor_ida.arrays import Column
from rotor_ida.checks import AT_REST, check_distinct, check_progress, check_real, check_vector
from rotor_ida.errors import InputError
from rotor_ida.model.rotor import DimensionalRotor, Rotor
from rotor_ida.model.rotor_system import RotorSystem
from rotor_ida.model.system_parameters import SPEED, AnyAxes
from rotor_ida.model.varied import Varied, varied_of, varied_system_of
from rotor_ida.parallel import Progress, choose, shows_progress
from rotor_ida.results.in_si import takes_rotors
from rotor_ida.results.provenance import provenance
from rotor_ida.results.question import QUESTION, Question
from rotor_ida.results.studies.results import Folder
from rotor_ida.results.system_units import with_system_units
from rotor_ida.schema import ENDING, ENDS_IN_WORDS, labelled, labelled_dataset
from rotor_ida.simulation.course import SYSTEM_LIMITS, course_of, ramp_of
from rotor_ida.simulation.options import (
    LARGEST,
    Backend,
    Method,
    Options,
    check_can_be_followed,
    options_of_study,
)
from rotor_ida.simulation.starts import GivenStart, Starts, start_of, states_of
from rotor_ida.simulation.systems.flow import SettlingProblem
from rotor_ida.steady.grid import (
    Array,
    check_size,
    labelled_points,
    representative,
    start_coordinates,
    start_words,
)
from rotor_ida.steady.ramps import Answers, Ramps, answered
from rotor_ida.steady.run_up_outcome import (
    OF_RAMP,
    ONLY_WITH,
    SUMMARY,
    RunUp,
    columns_of,
    follow_run_up,
    follow_system_run_up,
)
from rotor_ida.steady.sweep import FEATURES
from rotor_ida.steady.system_sweep import (
    OF_CONTACT,
    OF_NODE,
    Turnings,
    VariedSystem,
    checked_starts,
    clearances_of,
    with_meanings,
)

POINT = np.dtype(
    [
        ("ending", np.int8),
        ("response", np.int8),
        *((name, np.int64 if name == "contact_count" else np.float64) for name in SUMMARY),
        *((name, np.float64) for name in FEATURES),
        ("status", np.int8),
    ]
)
# The dimensions over which the endings are counted.
COUNTED = ("phase", "start")


@takes_rotors(disc=("atol", "method", "backend"), system=("modes",), varies=True)
@shows_progress
def run_ups(
    rotor: Rotor | DimensionalRotor | RotorSystem | None = None,
    *,
    speed: npt.ArrayLike | None = None,
    to: float,
    rate: npt.ArrayLike,
    phase: npt.ArrayLike = 0.0,
    starts: Starts = (AT_REST,),
    modes: int | None = None,
    rtol: float = 1e-10,
    atol: float = 1e-12,
    method: Method | None = None,
    backend: Backend = "auto",
    workers: int | None = None,
    executor: str = "auto",
    study: Folder | None = None,
    progress: Progress | bool | None = None,
    **varied: Unpack[AnyAxes],
) -> xr.Dataset:
    """Run rotors up or down at every rate, phase, damping and clearance, and classify the endings.

    Each rotor is simulated along a ramp of its speed, as by `run_up`, and then at the last speed
    until it has settled, as by `sweep`.

    Parameters
    ----------
    rotor : Rotor, DimensionalRotor or RotorSystem
        The rotor, one disc at its speed at time 0. Without it, ``omega``, ``zeta`` and ``delta0``
        must be given.
    speed : float or array_like, shape (n,)
        Speeds of a `RotorSystem` at time 0. Those of a `DimensionalRotor` are a parameter of it.
    to : float
        Speed at the end of the ramps [1]; that of a `RotorSystem` must not be 0.
    rate : array_like, shape (n,) or scalar
        Changes of speed per unit time [1]: all positive (up), or all negative (down).
    phase : array_like, shape (n,) or scalar
        Angles of the unbalance at time 0, from the x axis [rad]. Without a load this is equivalent
        to rotating the start the other way.
    starts : array_like, shape (n, 4), "settled", "rest", Dataset, or sequence of these
        Starts ``(x, y, vx, vy)`` at time 0, on fixed axes [1], words for those at the first speed,
        or results that end in one. Those of a `RotorSystem` as for `sweep`.
    modes : int, optional
        Of a `RotorSystem`, as for `simulate`.
    rtol, atol, backend
        As for `run_up`. A `RotorSystem` has `rtol` alone.
    method : {"adams", "bdf", "ida", "taylor"}, optional
        As for `run_up`; default: Taylor series, or ``"adams"`` where they do not go with backend or
        ``rtol``. The attribute ``method`` of the result gives which. Systems are always simulated
        by Taylor series.
    workers, executor, study, progress
        As for `sweep`, with run-ups instead of points. The result is the same, bit for bit.
    **varied : float or array_like, shape (n,)
        Parameters of `Rotor` by name [1], as for `sweep`; ``omega`` are the speeds at time 0.
    clearance, friction, unbalance, damping, stiffness : float or array_like, shape (n,), optional
        Parameters of a `RotorSystem`, as for `sweep`; each array becomes a dimension of the result.
    contacts, unbalance, supports, gravity, static_force : optional
        In place of those of a `RotorSystem`, as in `simulate`.

    Returns
    -------
    Dataset
        On ``(omega, zeta, delta0, rate, phase, start)`` and any other axes, for each run-up:

        - ``ending``, as a flag: ``contact_free``, ``rub``, ``whip``, ``unresolved`` or
          ``failed``; ``response``, the kind of response at the last speed, and its ``amplitude``,
          ``phase_lag``, ``radius_min``, ``radius_max``, ``period``, ``lyapunov_exponent`` and
          ``lyapunov_error``, as from `sweep`;
        - for the ramp ``largest_radius``, ``largest_force`` (0 without a contact) and their
          speeds, ``largest_radius_speed`` and ``largest_force_speed``;
          ``first_touch_speed`` and ``last_exit_speed``; ``contact_count`` and ``contact_time``;
          with friction ``first_roll_speed`` and ``total_heat``, with contact damping
          ``total_contact_loss``; the state at its end on fixed axes and the angle of the
          unbalance there, ``end_x``, ``end_y``, ``end_vx``, ``end_vy`` and ``end_angle``. The
          speed of an event that did not occur is NaN;
        - ``status`` and ``message``.

        On the same dimensions except phase and start, the fractions of the endings among the
        run-ups that did not fail: ``contact_free_fraction``, ``rub_fraction``, ``whip_fraction``
        and ``unresolved_fraction``, each with its standard error (such as ``whip_fraction_error``),
        and ``failed_count``.

        Of a `RotorSystem` on ``(speed, rate, phase, start)``, with any other axes before ``rate``,
        the same, but that what happens on the ramp is on ``contact`` too: ``largest_radius`` from
        the centre of the stator, ``largest_force``, ``first_touch_speed`` and so on; and so are
        ``amplitude``, ``phase_lag``, ``radius_min`` and ``radius_max`` at the last speed. On
        ``node``: ``node_largest_radius`` on the ramp and, at the last speed, ``node_amplitude``,
        ``node_phase_lag``, ``node_radius_min`` and ``node_radius_max``. On ``component``:
        ``final_state`` at the end of the ramp, where the unbalance is at ``end_angle``.
        ``horizon`` is the time up to which the start determines the ramp.

    Raises
    ------
    InputError
        If an argument cannot be used. A run-up that fails does not raise: its ``status`` and
        ``message`` give the reason.
    SimulationError
        If one of the ``"processes"``, or the scheduler, died.

    Notes
    -----
    After the ramp the last speed is kept. The settled response decides the ending:
    ``contact_free`` if it is contact-free, or touches ever more slightly; ``whip`` if it whirls
    backwards and stays in contact, with the disc rolling on the stator or, if the unbalance is too
    strong for that, alternately sliding both ways; ``rub`` for any other motion in contact;
    ``unresolved`` as in `sweep`.

    The standard error of a fraction p of n run-ups is ``sqrt(p (1 - p)/n)``, as if phases and
    starts were drawn at random. Without a load and from rest on the axis all phases are
    equivalent. With contact damping ``largest_force_speed`` is the speed at the largest indentation
    of that contact, shortly after the largest force.

    A largest radius of a `RotorSystem` without contact is that of the samples, 32 in each
    revolution. It ends in ``whip`` if a contact with friction stays closed and whirls backwards.

    The events of the ramps are not kept; use `run_up` for those of a single one. Torques and
    piecewise speeds are available only in `run_up`.

    Examples
    --------
    >>> ended = run_ups(omega=0.3, to=1.6, rate=[0.003, 0.3], zeta=0.1, delta0=2.0,
    ...                 shaft_stiffness=1.0)
    >>> ended.largest_force.values.ravel().round(3), ended.first_touch_speed.values.ravel().round(3)
    (array([11.969,  0.   ]), array([0.848,   nan]))
    >>> ended.rub_fraction.values.ravel(), ended.contact_free_fraction.values.ravel()
    (array([1., 0.]), array([0., 1.]))
    >>> system = Rotor(omega=1.0, zeta=0.1, delta0=2.0, shaft_stiffness=1.0).system()
    >>> found = run_ups(system, speed=0.3, to=1.6, rate=0.3, clearance=[1.0, 2.0])
    >>> found.largest_force.values.ravel().round(3)
    array([0.603, 0.   ])
    """
    reports, last = check_progress(progress), check_real("to", to)
    how: dict[str, Any]
    kept: Sequence[Any]
    if isinstance(rotor, RotorSystem):
        speeds = check_distinct(SPEED, check_vector(SPEED, speed))
        asked = varied_system_of(run_ups, rotor, varied, speeds)
        system = VariedSystem.of(asked, checked_starts(starts), modes, rtol)
        given, kept, chosen = system.varied, system.kept, choose(executor, workers, compiled=True)
        how = {"rotor": asked.base, "modes": modes, "rtol": system.rtol}
    else:
        given = varied_of(run_ups, rotor, varied)
        options = options_of_study(rtol=rtol, atol=atol, method=method, backend=backend)
        chosen = choose(executor, workers, compiled=options.backend != "python")
        states = kept = states_of("starts", starts, loaded=bool(given.values("load").any()))
        how = {name: getattr(options, name) for name in ("rtol", "atol", "method")}
    most = (LARGEST, math.tau) if given.system is None else (math.inf, math.inf)
    rates, phases = (
        check_distinct(name, check_vector(name, each, largest=largest))
        for (name, each), largest in zip({"rate": rate, "phase": phase}.items(), most, strict=True)
    )
    grid = given.over(rate=rates, phase=phases, start=np.arange(len(kept)))
    check_size(grid, study)
    question = Question("run_ups", {
        **grid.design, "rate": rates, "phase": phases, "to": last, "starts": kept, **how
    })  # fmt: skip
    if isinstance(rotor, RotorSystem):
        problem = _checked_system(grid, system, last)
        settling = Answers(partial(follow_system_run_up, system.rtol), columns_of(problem))
        begun: Sequence[Any] = system.starts
    else:
        _check_can_be_followed(grid, states, last, options)
        settling, begun = Answers(partial(follow_run_up, options), POINT), states

    def point_at(place: Sequence[int]) -> RunUp:
        at = {name: float(each) for name, each in grid.at(place).items()}
        one = grid.rotor(place) if grid.system is None else grid.system_at(place)
        return RunUp(one, at["omega" if grid.system is None else SPEED], last, at["rate"],
                     at["phase"])  # fmt: skip

    columns = answered(
        Ramps(grid, begun, settling, point_at), question, word="run-up", table="run_ups",
        study=study, workers=chosen, progress=reports,
    )  # fmt: skip
    if isinstance(rotor, RotorSystem):
        return _system_dataset(grid, columns, problem, last, question)
    how = provenance(options.attributes()) | start_words(states) | question.attribute()
    return _dataset(grid, columns, states, last, how)


def _check_can_be_followed(
    grid: Varied, given: Sequence[GivenStart], to: float, options: Options
) -> None:
    """Check each ramp of one disc, each value of a parameter and each start once."""
    axes, rotors = grid.axes, grid.extremes()
    starts = representative(given)
    for rotor, rate in product(rotors[: axes["omega"].size], axes["rate"].tolist()):
        ramp_of(rotor, to, rate, options.backend)
    for rotor in rotors:
        check_can_be_followed(rotor, starts[0])
    for start in starts[1:]:
        check_can_be_followed(rotors[0], start)
    check_can_be_followed(replace(rotors[0], omega=to), starts[0], settling=True)


def _checked_system(grid: Varied, asked: VariedSystem, to: float) -> SettlingProblem:
    """Check each ramp of a rotor system, the last speed and each start; return the stiffest."""
    if to == 0.0:
        raise InputError("to must not be 0 in run-ups of a rotor system, got 0.0")
    for first, change in product(grid.axes[SPEED].tolist(), grid.axes["rate"].tolist()):
        course_of(first, {"to": to, "rate": change}, None, SYSTEM_LIMITS)
    problem = Turnings(asked.varied, asked.rtol).checked(np.array([to]))
    for each in asked.starts:
        start_of(problem.assembly, each, float(grid.axes[SPEED][0]))
    return problem


def _dataset(
    varied: Varied, columns: Mapping[str, Array], starts: Sequence[GivenStart], to: float,
    attributes: Mapping[str, Any],
) -> xr.Dataset:  # fmt: skip
    """Return run-ups of one disc as a labelled dataset."""
    left_out = [name for parameter, names in ONLY_WITH.items() for name in names
                if not varied.values(parameter).any()]  # fmt: skip
    kept = {name: each for name, each in columns.items() if name not in left_out}
    title = "Rotor in a clearance: run-ups over a range of speeds"
    return labelled_dataset(
        title, _variables(varied, kept), _coordinates(varied, to) | start_coordinates(starts),
        attributes, kind="run_ups",
    )  # fmt: skip


def _system_dataset(
    varied: Varied, columns: Mapping[str, Array], problem: SettlingProblem, to: float,
    question: Question,
) -> xr.Dataset:  # fmt: skip
    """Return run-ups of a rotor system as a labelled dataset."""
    system, contacts = varied.base, varied.base.contacts
    behind = dict.fromkeys((*OF_CONTACT, *OF_RAMP, "contact_count"), ("contact",))
    behind |= dict.fromkeys((*OF_NODE, "node_largest_radius"), ("node",))
    variables = _variables(varied, columns, behind | {"final_state": ("component",)})
    variables["largest_radius"].attrs["long_name"] = (
        "largest distance of the contact from the centre of its stator on the ramp"
    )
    gaps = {name: labelled(name, *each) for name, each in clearances_of(varied).items()}
    radii = [each.radius or math.nan for each in contacts]
    (gap,), far = gaps.values(), variables["largest_radius"]
    variables |= gaps | {
        "contact_node": labelled("contact_node", "contact", [each.node for each in contacts]),
        "law_radius": labelled("law_radius", "contact", radii),
        "excursion": labelled("excursion", far.dims, (far / gap).transpose(*far.dims).values),
    }
    dataset = labelled_dataset(
        "Rotor system: run-ups over a range of speeds", variables,
        _coordinates(varied, to) | {"node": ("node", np.array(list(system.nodes), str))},
        provenance({"method": "taylor", "rtol": problem.rtol}) | {QUESTION: question.text()},
        kind="system_run_ups",
    )  # fmt: skip
    dataset["to"].attrs["long_name"] = "spin speed at the end of the ramp"
    return with_meanings(with_system_units(dataset, system), varied)


def _variables(
    varied: Varied, columns: Mapping[str, Array], behind: Mapping[str, tuple[str, ...]] = {}
) -> dict[str, xr.Variable]:
    """Return columns of run-ups as variables, with the fractions of their endings.

    `behind` has the dimensions of columns besides those of the grid.
    """
    variables = labelled_points(varied, columns, behind)
    counted = tuple(varied.dims.index(name) for name in COUNTED)
    others = [name for name in varied.dims if name not in COUNTED]
    fractions = fractions_of(variables["ending"].values, counted)
    variables |= {name: labelled(name, others, values) for name, values in fractions.items()}
    for name in ("radius_min", "radius_max"):
        variables[name].attrs["long_name"] += " at the last speed"
    for name in ("contact_count", "largest_force"):
        variables[name].attrs["long_name"] += " on the ramp"
    return variables


def _coordinates(varied: Varied, to: float) -> dict[str, Column | xr.Variable]:
    """Return the axes of run-ups, and their last speed."""
    rate = labelled("rate", "rate", varied.axes["rate"])
    rate.attrs["long_name"] = "change of the spin speed in a unit of time"
    return {**varied.coordinates, "to": ((), to), "rate": rate}


def fractions_of(endings: Array, counted: tuple[int, ...]) -> dict[str, Array]:
    """Return the fractions of the endings over some axes, among those that did not fail.

    The standard error of a fraction p of n run-ups is ``sqrt(p (1 - p)/n)``.

    Examples
    --------
    >>> counted = fractions_of(np.array([[3, 2, 3, -1, 3]]), (1,))
    >>> counted["whip_fraction"], counted["whip_fraction_error"].round(6), counted["failed_count"]
    (array([0.75]), array([0.216506]), array([1]))
    """
    failures = (endings == ENDING["failed"]).sum(axis=counted)
    total = np.prod([endings.shape[axis] for axis in counted], dtype=np.int64) - failures
    fractions: dict[str, Array] = {"failed_count": failures}
    for word in ENDS_IN_WORDS:
        count = (endings == ENDING[word]).sum(axis=counted)
        fraction = np.divide(count, total, out=np.full(total.shape, np.nan), where=total > 0)
        fractions[f"{word}_fraction"] = fraction
        spread = fraction * (1.0 - fraction)
        fractions[f"{word}_fraction_error"] = np.sqrt(
            np.divide(spread, total, out=np.full(total.shape, np.nan), where=total > 0)
        )
    return fractions
