"""Many run-ups: along ramps of the speed, over rate, phase of the unbalance and parameters."""

from __future__ import annotations

import os
from collections.abc import Iterator
from itertools import product

import numpy as np
import numpy.typing as npt
import xarray as xr

from rotor_ida.checks import (
    MOST_NUMBERS,
    MOST_POINTS_OF_STUDY,
    check_axis,
    check_points,
    check_progress,
    check_real,
    check_states,
    check_vector,
    is_scalar,
)
from rotor_ida.model.parameters import Rotor
from rotor_ida.model.table import DEFAULTS
from rotor_ida.parallel import Progress, choose
from rotor_ida.results.provenance import computing
from rotor_ida.results.studies.results import open_results
from rotor_ida.simulation.options import LARGEST, Backend, Method, Options, check_can_be_followed
from rotor_ida.simulation.run_up import ramp_of
from rotor_ida.steady.jobs import Task, do_all
from rotor_ida.steady.passage import TURN, lost, pass_through
from rotor_ida.steady.ramps import Places
from rotor_ida.steady.run_ups_dataset import FORM, RunUps, rows_of, run_ups_dataset
from rotor_ida.steady.sweep import REST
from rotor_ida.steady.sweep_dataset import Rows


def run_ups(
    *,
    omega: npt.ArrayLike,
    to: float,
    rate: npt.ArrayLike,
    zeta: npt.ArrayLike,
    delta0: npt.ArrayLike,
    phase: npt.ArrayLike = 0.0,
    shaft_stiffness: npt.ArrayLike = 0.0,
    contact_exponent: npt.ArrayLike = 1.5,
    contact_damping: npt.ArrayLike = 0.0,
    load: npt.ArrayLike = 0.0,
    friction: npt.ArrayLike = 0.0,
    disc_radius: npt.ArrayLike | None = None,
    starts: npt.ArrayLike = (REST,),
    rtol: float = 1e-10,
    atol: float = 1e-12,
    method: Method = "adams",
    backend: Backend = "auto",
    workers: int | None = None,
    executor: str = "auto",
    study: str | os.PathLike[str] | None = None,
    progress: Progress | None = None,
) -> xr.Dataset:
    """Run rotors up, or down, at every rate, phase, damping and clearance, and say how they end.

    Each rotor is followed along a ramp of its speed, as by `run_up`, and on at the last speed until
    it has settled, as by `sweep`.

    Parameters
    ----------
    omega : array_like, shape (n,) or scalar
        Speeds at time 0 [1].
    to : float
        Speed at the end of the ramps [1].
    rate : array_like, shape (n,) or scalar
        Changes of the speed in a unit of time [1]: all positive up, or all negative down.
    zeta, delta0 : array_like, shape (n,) or scalar
        Damping ratios and clearances to combine [1].
    phase : array_like, shape (n,) or scalar
        Angles of the unbalance at time 0, from the x axis [rad]. Without a load this is the same as
        to turn the start the other way.
    shaft_stiffness, contact_exponent, contact_damping, load, friction, disc_radius
        What a machine has beyond the paper's rotor [1], as for `sweep`.
    starts : array_like, shape (n, 4)
        Starts ``(x, y, vx, vy)`` at time 0, on fixed axes [1].
    rtol, atol, method, backend
        As for `run_up`.
    workers, executor, study, progress
        As for `sweep`: run-ups take the place of its points. The result is the same, bit for bit.

    Returns
    -------
    Dataset
        On ``(omega, zeta, delta0, rate, phase, start)`` and what else is an axis, of each run-up:

        - ``ending``, as a flag: ``contact_free``, ``rub``, ``whip``, ``unresolved`` or
          ``failed``; ``response``, the kind of response at the last speed, and its ``amplitude``,
          ``phase_lag``, ``radius_min``, ``radius_max``, ``period``, ``lyapunov_exponent`` and
          ``lyapunov_error``, as of `sweep`;
        - of the ramp ``largest_radius``, ``largest_force`` (0 without a contact) and the speeds
          where they were met, ``largest_radius_speed`` and ``largest_force_speed``;
          ``first_touch_speed`` and ``last_exit_speed``; ``contact_count`` and ``contact_time``;
          with friction ``first_roll_speed`` and ``total_heat``, with contact damping
          ``total_contact_loss``; the state at its end on fixed axes and the angle of the
          unbalance there, ``end_x``, ``end_y``, ``end_vx``, ``end_vy`` and ``end_angle``. Speeds
          of what did not happen are NaN;
        - ``status`` and ``message``.

        On the same dimensions but phase and start the fractions of the endings among the run-ups
        that did not fail, ``contact_free_fraction``, ``rub_fraction``, ``whip_fraction`` and
        ``unresolved_fraction``, each with its standard error (``whip_fraction_error``), and
        ``failed_count``.

    Raises
    ------
    InputError
        If an argument cannot be used. A run-up that fails does not raise: its ``status`` and
        ``message`` say why.
    SimulationError
        If one of ``"processes"`` died, or the scheduler.

    Notes
    -----
    After the ramp the last speed is held. A run-up ends ``contact_free`` if the response that it
    settles on then is contact-free, or touches ever more slightly; in ``whip`` if it whirls
    backwards and stays in contact, the disc rolling on the ring, or sliding both ways by turns
    where the unbalance is too strong for that; in a ``rub`` if it is anything else in contact; and
    it is ``unresolved`` where `sweep` would call it so.

    The standard error of a fraction p of n run-ups is ``sqrt(p (1 - p)/n)``, as if phases and
    starts were drawn at random. Without a load and from rest on the axis no phase differs from
    another. Where a contact has contact damping, ``largest_force_speed`` is the speed at its
    largest indentation, shortly after the largest force.

    The events of the ramps are not kept: `run_up` has them of any single one. Its drive by a
    torque, and speeds piece by piece, are not for many.

    Examples
    --------
    >>> found = run_ups(omega=0.3, to=1.6, rate=[0.003, 0.3], zeta=0.1, delta0=2.0,
    ...                 shaft_stiffness=1.0)
    >>> found.largest_force.values.ravel().round(3), found.first_touch_speed.values.ravel().round(3)
    (array([11.969,  0.   ]), array([0.848,   nan]))
    >>> found.rub_fraction.values.ravel(), found.contact_free_fraction.values.ravel()
    (array([1., 0.]), array([0., 1.]))
    """
    beyond = {
        "shaft_stiffness": shaft_stiffness, "contact_exponent": contact_exponent,
        "contact_damping": contact_damping, "load": load, "friction": friction,
        **({} if disc_radius is None else {"disc_radius": disc_radius}),
    }  # fmt: skip
    given = {"omega": omega, "zeta": zeta, "delta0": delta0, **beyond}
    axes = {name: check_axis(name, values) for name, values in given.items()}
    numbers = {name for name, values in beyond.items() if is_scalar(name, values)}
    defaults = DEFAULTS
    absent = {name for name in numbers if axes[name].tolist() == [defaults[name]]}
    axes = {name: axis for name, axis in axes.items() if name not in absent}
    axes["rate"] = check_vector("rate", rate, largest=LARGEST)
    axes["phase"] = check_vector("phase", phase, largest=TURN)
    options = Options(rtol=rtol, atol=atol, method=method, backend=backend)
    check_progress(progress)
    place, count = choose(executor, workers, compiled=options.backend != "python")
    asked = RunUps(
        axes, check_real("to", to), check_states("starts", starts), options,
        frozenset(numbers - absent),
    )  # fmt: skip
    most = MOST_NUMBERS if study is None else MOST_POINTS_OF_STUDY
    check_points(*axes.values(), asked.starts, most=most)
    _check_can_be_followed(asked)
    with open_results(study, _design(asked), asked.points, FORM) as kept:
        do_all(asked, Task(pass_through, lost, rows_of), kept, place, count, progress)

        def pieces() -> Iterator[tuple[Places, Rows]]:
            return ((np.array([number]), rows) for number, rows in kept.results())

        return run_ups_dataset(asked, pieces, kept.folder)


def _design(asked: RunUps) -> dict[str, object]:
    """Return all that decides on the bits of many run-ups."""
    options = asked.options
    return {
        "kind": "run_ups",
        **{
            name: values.item() if name in asked.numbers else values.tolist()
            for name, values in asked.axes.items()
        },
        "to": asked.to,
        "starts": [list(start) for start in asked.starts],
        **{name: getattr(options, name) for name in ("rtol", "atol", "method")},
        **computing(),
    }


def _check_can_be_followed(asked: RunUps) -> None:
    """Check each ramp, each value of a parameter and each start once."""
    parameters = {name: axis for name, axis in asked.axes.items() if name not in {"rate", "phase"}}
    largest = {name: float(values.max()) for name, values in parameters.items()}
    for omega, rate in product(parameters["omega"].tolist(), asked.axes["rate"].tolist()):
        ramp_of(Rotor(**largest | {"omega": omega}), asked.to, rate, asked.options.backend)
    rotors = [
        Rotor(**largest | {name: value})
        for name, values in parameters.items()
        if name not in {"zeta", "shaft_stiffness"}
        for value in values.tolist()
    ]
    for rotor in rotors:
        check_can_be_followed(rotor, asked.starts[0])
    for start in asked.starts[1:]:
        check_can_be_followed(rotors[0], start)
    settles = Rotor(**largest | {"omega": asked.to})
    check_can_be_followed(settles, asked.starts[0], settling=True)
