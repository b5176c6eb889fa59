"""Many run-ups over rate, phase of the unbalance and parameters."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace
from itertools import product
from typing import Any, Unpack

import numpy as np
import numpy.typing as npt
import xarray as xr

from rotor_ida.arrays import Column
from rotor_ida.checks import (
    AT_REST,
    check_distinct,
    check_progress,
    check_real,
    check_vector,
)
from rotor_ida.model.parameters import Parameters
from rotor_ida.model.rotor import DimensionalRotor, Rotor
from rotor_ida.model.varied import Varied, varied_of
from rotor_ida.parallel import Progress, choose, shows_progress
from rotor_ida.results.in_si import varies_in_si
from rotor_ida.results.provenance import provenance
from rotor_ida.results.question import Question
from rotor_ida.results.studies.results import Folder
from rotor_ida.schema import ENDING, ENDS_IN_WORDS, labelled, labelled_dataset
from rotor_ida.simulation.course import ramp_of
from rotor_ida.simulation.options import (
    LARGEST,
    Backend,
    Method,
    Options,
    check_can_be_followed,
    options_of_study,
)
from rotor_ida.simulation.starts import GivenStart, Starts, states_of
from rotor_ida.steady.grid import (
    Array,
    Task,
    check_size,
    form_of,
    representative,
    run_study,
    start_coordinates,
    start_words,
)
from rotor_ida.steady.members import Members, as_they_are, lost
from rotor_ida.steady.run_up_outcome import ONLY_WITH, SUMMARY, follow_run_up
from rotor_ida.steady.sweep import FEATURES

POINT = np.dtype(
    [
        ("ending", np.int8),
        ("response", np.int8),
        *((name, np.int64 if name == "contact_count" else np.float64) for name in SUMMARY),
        *((name, np.float64) for name in FEATURES),
        ("status", np.int8),
    ]
)
FORM = form_of("run-up", "run_ups", POINT)
# The dimensions over which the endings are counted.
COUNTED = ("phase", "start")


@varies_in_si
@shows_progress
def run_ups(
    rotor: Rotor | DimensionalRotor | None = None,
    *,
    to: float,
    rate: npt.ArrayLike,
    phase: npt.ArrayLike = 0.0,
    starts: Starts = (AT_REST,),
    rtol: float = 1e-10,
    atol: float = 1e-12,
    method: Method | None = None,
    backend: Backend = "auto",
    workers: int | None = None,
    executor: str = "auto",
    study: Folder | None = None,
    progress: Progress | bool | None = None,
    **varied: Unpack[Parameters],
) -> xr.Dataset:
    """Run rotors up or down at every rate, phase, damping and clearance, and classify the endings.

    Each rotor is simulated along a ramp of its speed, as by `run_up`, and then at the last speed
    until it has settled, as by `sweep`.

    Parameters
    ----------
    rotor : Rotor or DimensionalRotor, optional
        The rotor, at its speed at time 0. Without it, ``omega``, ``zeta`` and ``delta0`` must be
        given.
    to : float
        Speed at the end of the ramps [1].
    rate : array_like, shape (n,) or scalar
        Changes of speed per unit time [1]: all positive (up), or all negative (down).
    phase : array_like, shape (n,) or scalar
        Angles of the unbalance at time 0, from the x axis [rad]. Without a load this is equivalent
        to rotating the start the other way.
    starts : array_like, shape (n, 4), "settled", "rest", Dataset, or sequence of these
        Starts ``(x, y, vx, vy)`` at time 0, on fixed axes [1], words for those at the first speed,
        or results that end in one.
    rtol, atol, backend
        As for `run_up`.
    method : {"adams", "bdf", "ida", "taylor"}, optional
        As for `run_up`; default: Taylor series, or ``"adams"`` where they do not go with backend or
        ``rtol``. The attribute ``method`` of the result gives which.
    workers, executor, study, progress
        As for `sweep`, with run-ups instead of points. The result is the same, bit for bit.
    **varied : float or array_like, shape (n,)
        Parameters of `Rotor` by name [1], as for `sweep`; ``omega`` are the speeds at time 0.

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
    """
    grid = varied_of(run_ups, rotor, varied)
    rates = check_distinct("rate", check_vector("rate", rate, largest=LARGEST))
    phases = check_distinct("phase", check_vector("phase", phase, largest=math.tau))
    options = options_of_study(rtol=rtol, atol=atol, method=method, backend=backend)
    progress = check_progress(progress)
    chosen = choose(executor, workers, compiled=options.backend != "python")
    is_loaded = bool(grid.values("load").any())
    speed, states = check_real("to", to), states_of("starts", starts, loaded=is_loaded)
    grid = grid.over(rate=rates, phase=phases, start=np.arange(len(states)))
    check_size(grid, study)
    _check_can_be_followed(grid, states, speed, options)
    plan = Members({"starts": states, "to": speed, "options": options}, grid, POINT)
    how = {name: getattr(options, name) for name in ("rtol", "atol", "method")}
    asked = {**grid.design, "rate": rates, "phase": phases, "to": speed, "starts": states, **how}
    task = Task(follow_run_up, lost, as_they_are, FORM, POINT)
    question = Question("run_ups", asked)
    columns = run_study(plan, task, question, study=study, workers=chosen, progress=progress)
    return _dataset(grid, columns.points, plan.case).assign_attrs(question.attribute())


def _check_can_be_followed(
    grid: Varied, given: Sequence[GivenStart], to: float, options: Options
) -> None:
    """Check each ramp, each value of a parameter and each start once."""
    axes, rotors = grid.axes, grid.extremes()
    starts = representative(given)
    for rotor, rate in product(rotors[: axes["omega"].size], axes["rate"].tolist()):
        ramp_of(rotor, to, rate, options.backend)
    for rotor in rotors:
        check_can_be_followed(rotor, starts[0])
    for start in starts[1:]:
        check_can_be_followed(rotors[0], start)
    check_can_be_followed(replace(rotors[0], omega=to), starts[0], settling=True)


def _dataset(varied: Varied, columns: dict[str, Array], case: dict[str, Any]) -> xr.Dataset:
    """Return run-ups of one disc as a labelled dataset."""
    for parameter, names in ONLY_WITH.items():
        if not varied.values(parameter).any():
            columns = {name: each for name, each in columns.items() if name not in names}
    coordinates = start_coordinates(case["starts"])
    how = provenance(case["options"].attributes()) | start_words(case["starts"])
    title = "Rotor in a clearance: run-ups over a range of speeds"
    coordinates |= {"to": ((), case["to"])}
    return labelled_run_ups(varied, columns, coordinates, how, title, kind="run_ups")


def labelled_run_ups(
    varied: Varied,
    columns: Mapping[str, Array],
    coordinates: Mapping[str, Column],
    how: Mapping[str, object],
    title: str,
    *,
    kind: str,
    behind: Mapping[str, tuple[str, ...]] = {},
) -> xr.Dataset:
    """Return run-ups as a labelled dataset, with the fractions of their endings.

    `behind` has the dimensions of columns besides those of the grid.
    """
    variables = {
        name: labelled(name, (*varied.dims, *behind.get(name, ())),
                       each.reshape(*varied.shape, *each.shape[1:]))
        for name, each in columns.items()
    }  # fmt: skip
    counted = tuple(varied.dims.index(name) for name in COUNTED)
    others = [name for name in varied.dims if name not in COUNTED]
    fractions = fractions_of(variables["ending"].values, counted)
    variables |= {name: labelled(name, others, values) for name, values in fractions.items()}
    for name in ("radius_min", "radius_max"):
        variables[name].attrs["long_name"] += " at the last speed"
    for name in ("contact_count", "largest_force"):
        variables[name].attrs["long_name"] += " on the ramp"
    rate = labelled("rate", "rate", varied.axes["rate"])
    rate.attrs["long_name"] = "change of the spin speed in a unit of time"
    return labelled_dataset(
        title, variables, {**varied.coordinates, **coordinates, "rate": rate}, how, kind=kind
    )


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
