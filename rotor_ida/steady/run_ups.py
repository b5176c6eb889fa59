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
from rotor_ida.results.question import Question
from rotor_ida.results.studies.results import Folder
from rotor_ida.schema import ENDING, ENDS_IN_WORDS, labelled
from rotor_ida.simulation.course import SYSTEM_LIMITS, course_of, ramp_of
from rotor_ida.simulation.options import LARGEST, Backend, Method, check_can_be_followed
from rotor_ida.simulation.starts import Starts, start_of_system
from rotor_ida.simulation.system_flow import SettlingProblem
from rotor_ida.steady.grid import Answers, Array, Ramps, check_size, labelled_points, run_study
from rotor_ida.steady.points import (
    FEATURES,
    Turnings,
    VariedDisc,
    VariedSystem,
    check_varied_can_be_followed,
    clearances_of,
)
from rotor_ida.steady.run_up_outcome import (
    OF_RAMP,
    ONLY_WITH,
    SUMMARY,
    RunUp,
    columns_of,
    follow_run_up,
    follow_system_run_up,
)
from rotor_ida.steady.sweep import study_dataset

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
    starts: Starts = (None,),
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
        Speed at the end of the ramps [dimensionless]; that of a `RotorSystem` must not be 0.
    rate : array_like, shape (n,) or scalar
        Changes of speed per unit time [dimensionless]: all positive (up), or all negative (down).
    phase : array_like, shape (n,) or scalar
        Angles of the unbalance at time 0, from the x axis [rad]. Without a load this is equivalent
        to rotating the start the other way.
    starts : array_like, shape (n, 4), "settled", "rest", Dataset, or sequence of these
        Starts ``(x, y, vx, vy)`` at time 0, on fixed axes [dimensionless], words for those at the
        first speed, or results that end in one. Those of a `RotorSystem` as for `sweep`.
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
        Parameters of `Rotor` by name [dimensionless], as for `sweep`; ``omega`` are the speeds at
        time 0.
    clearance, friction, unbalance, damping, stiffness : float or array_like, shape (n,), optional
        Parameters of a `RotorSystem`, as for `sweep`; each array becomes a dimension of the result.
    contacts, unbalance, supports, bearings, gravity, static_force : optional
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
    asked: VariedDisc | VariedSystem
    if isinstance(rotor, RotorSystem):
        speeds = check_distinct(SPEED, check_vector(SPEED, speed))
        given = varied_system_of(run_ups, rotor, varied, speeds)
        asked = VariedSystem.of(given, starts, modes, rtol)
    else:
        given = varied_of(run_ups, rotor, varied)
        asked = VariedDisc.of(given, starts, rtol=rtol, atol=atol, method=method, backend=backend)
    chosen = choose(executor, workers, compiled=asked.is_compiled)
    most = (LARGEST, math.tau) if isinstance(asked, VariedDisc) else (math.inf, math.inf)
    rates, phases = (
        check_distinct(name, check_vector(name, each, largest=largest))
        for (name, each), largest in zip({"rate": rate, "phase": phase}.items(), most, strict=True)
    )
    points = asked.varied.over(rate=rates, phase=phases, start=np.arange(len(asked.starts)))
    check_size(points, study)
    question = Question("run_ups", {
        **points.design, "rate": rates, "phase": phases, "to": last, "starts": asked.kept,
        **asked.arguments,
    })  # fmt: skip
    answers: Answers[RunUp, Any]
    if isinstance(asked, VariedSystem):
        kind = columns_of(_checked_system(points, asked, last))
        answers = Answers(partial(follow_system_run_up, asked.rtol), kind)
    else:
        _check_can_be_followed(points, asked, last)
        answers = Answers(partial(follow_run_up, asked.options), POINT)

    def point_at(place: Sequence[int]) -> RunUp:
        at = {name: float(each) for name, each in points.at(place).items()}
        one = points.rotor(place) if points.system is None else points.system_at(place)
        return RunUp(one, at[asked.speed], last, at["rate"], at["phase"])

    columns = run_study(
        Ramps(points, asked.starts, answers, point_at), question, word="run-up", study=study,
        workers=chosen, progress=reports,
    ).points  # fmt: skip
    return _dataset(points, asked, columns, last, question)


def _check_can_be_followed(points: Varied, asked: VariedDisc, to: float) -> None:
    """Check each ramp of one disc, each value of a parameter and each start once."""
    axes, rotors = points.axes, points.extremes()
    for rotor, rate in product(rotors[: axes["omega"].size], axes["rate"].tolist()):
        ramp_of(rotor, to, rate, asked.options.backend)
    check_varied_can_be_followed(points, asked.starts, settling=False)
    check_can_be_followed(replace(rotors[0], omega=to), AT_REST, settling=True)


def _checked_system(grid: Varied, asked: VariedSystem, to: float) -> SettlingProblem:
    """Check each ramp of a rotor system, the last speed and each start; return the stiffest."""
    if to == 0.0:
        raise InputError("to must not be 0 in run-ups of a rotor system, got 0.0")
    for first, change in product(grid.axes[SPEED].tolist(), grid.axes["rate"].tolist()):
        course_of(first, {"to": to, "rate": change}, None, SYSTEM_LIMITS)
    problem = Turnings(asked.varied, asked.rtol).checked(np.array([to]))
    for each in asked.starts:
        start_of_system(problem.assembly, each, float(grid.axes[SPEED][0]))
    return problem


def _dataset(
    varied: Varied, asked: VariedDisc | VariedSystem, columns: Mapping[str, Array], to: float,
    question: Question,
) -> xr.Dataset:  # fmt: skip
    """Return run-ups as a labelled dataset."""
    rate = labelled("rate", "rate", varied.axes["rate"])
    rate.attrs["long_name"] = "change of the spin speed in a unit of time"
    coordinates: dict[str, Column | xr.Variable] = {"to": ((), to), "rate": rate}
    if varied.system is None:
        variables = _variables(varied, columns)
        for parameter, names in ONLY_WITH.items():
            if not varied.values(parameter).any():
                variables = {name: each for name, each in variables.items() if name not in names}
        coordinates |= asked.coordinates(varied)
    else:
        behind = asked.behind | dict.fromkeys((*OF_RAMP, "contact_count"), ("contact",))
        variables = _variables(varied, columns, {**behind, "node_largest_radius": ("node",)})
        variables |= _of_contacts(varied, variables["largest_radius"])
        coordinates["node"] = ("node", np.array(list(varied.base.nodes), str))
    found = study_dataset(
        asked, varied, f"{asked.title}: run-ups over a range of speeds", variables, coordinates,
        asked.attributes | question.attribute(), "run_ups",
    )  # fmt: skip
    of_last, of_ramp = ("radius_min", "radius_max"), ("contact_count", "largest_force")
    for names, words in ((of_last, " at the last speed"), (of_ramp, " on the ramp")):
        for name in names:
            found[name].attrs["long_name"] += words
    return found


def _of_contacts(varied: Varied, far: xr.Variable) -> dict[str, xr.Variable]:
    """Return what belongs to the contacts of a system, by the largest distances from them."""
    far.attrs["long_name"] = (
        "largest distance of the contact from the centre of its stator on the ramp"
    )
    contacts = varied.base.contacts
    gaps = {name: labelled(name, *each) for name, each in clearances_of(varied).items()}
    radii = [each.radius or math.nan for each in contacts]
    (gap,) = gaps.values()
    return gaps | {
        "contact_node": labelled("contact_node", "contact", [each.node for each in contacts]),
        "law_radius": labelled("law_radius", "contact", radii),
        "excursion": labelled("excursion", far.dims, (far / gap).transpose(*far.dims).values),
    }


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
    return variables


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
