"""Sweeps: the settled response at each speed, damping and clearance.

The points of the grid form ramps (quasi-static run-up and run-down, of the speed or of another
parameter): each point of a ramp begins where the one before has ended. Without a direction each
point is a separate ramp.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from functools import partial
from typing import Any, Unpack

import numpy.typing as npt
import xarray as xr

from rotor_ida.arrays import Column
from rotor_ida.checks import check_flag, check_progress
from rotor_ida.model.rotor import DimensionalRotor, Rotor
from rotor_ida.model.rotor_system import RotorSystem
from rotor_ida.model.system_parameters import SPEED, AnyAxes
from rotor_ida.model.varied import Varied, varied_of, varied_system_of
from rotor_ida.parallel import Progress, choose, shows_progress
from rotor_ida.results.checked_run import event_columns, kinds_of_events
from rotor_ida.results.in_si import takes_rotors
from rotor_ida.results.question import QUESTION, Question
from rotor_ida.results.rows import counted
from rotor_ida.results.studies.results import Folder
from rotor_ida.schema import labelled, labelled_dataset
from rotor_ida.simulation.options import Backend, Flight, Method
from rotor_ida.simulation.starts import Starts
from rotor_ida.steady.grid import (
    Columns,
    Direction,
    Ramps,
    check_size,
    in_order,
    labelled_points,
    run_study,
)
from rotor_ida.steady.points import (
    EVENT,
    VariedDisc,
    VariedSystem,
    answer_of_disc,
    turning_speeds,
    with_meanings,
)


@takes_rotors(
    disc=("events", "atol", "method", "flight", "backend"), system=("modes",), varies=True
)
@shows_progress
def sweep(
    rotor: Rotor | DimensionalRotor | RotorSystem | None = None,
    *,
    speed: npt.ArrayLike | None = None,
    starts: Starts = (None,),
    direction: Direction | None = None,
    along: str | None = None,
    events: bool = False,
    modes: int | None = None,
    rtol: float = 1e-10,
    atol: float = 1e-12,
    method: Method | None = None,
    flight: Flight = "exact",
    backend: Backend = "auto",
    workers: int | None = None,
    executor: str = "auto",
    study: Folder | None = None,
    progress: Progress | bool | None = None,
    **varied: Unpack[AnyAxes],
) -> xr.Dataset:
    """Compute the settled response at every speed, damping and clearance.

    Parameters
    ----------
    rotor : Rotor, DimensionalRotor or RotorSystem
        The rotor. Without it, ``omega``, ``zeta`` and ``delta0`` must be given.
    speed : float or array_like, shape (n,)
        Spin speeds of a `RotorSystem`, not 0. Those of a `DimensionalRotor` are a parameter of it.
    starts : array_like, shape (n, 4), "settled", "rest", Dataset, or sequence of these
        Starts ``(x, y, vx, vy)`` [dimensionless], words for those at each speed, or results that
        end in one, as for `simulate`. Those of a `RotorSystem` are a sequence of ``(q, velocity)``,
        words, None or results, or one result. Default: one, at rest, as None is for `simulate`.
    direction : {"up", "down", "both"}, optional
        Quasi-static run-up or run-down: only the first speed (the last, going down) begins from
        the starts, and each other from the end of the one before, so that jumps and their
        hysteresis appear. By default each speed begins from the starts.
    along : str, optional
        Name of the parameter that rises or falls with a direction, in increasing order. Default:
        the speed if it varies, else the only parameter that does. The other parameters are
        combined with it.
    events : bool
        Whether to keep the contact events of all runs, in one table beside the points. Only of one
        disc.
    modes : int, optional
        Of a `RotorSystem`, as for `simulate`.
    rtol, atol, flight, backend
        As for `simulate`. A `RotorSystem` has `rtol` alone, from 1e-14 to 1e-4.
    method : {"adams", "bdf", "ida", "taylor"}, optional
        As for `simulate`; default: Taylor series, or ``"adams"`` where they do not go with flight,
        backend or ``rtol``. The attribute ``method`` of the result gives which. Systems are always
        simulated by Taylor series.
    workers : int, optional
        Number of ramps to simulate at a time; default: one for each core, or only one
        with the Python backend and ``executor="auto"``.
    executor : {"auto", "serial", "threads", "processes", "dask"} or str
        Where they run. ``"auto"`` means threads with the compiled backend. The Python backend keeps
        the interpreter's lock, so that ``"auto"`` means processes if `workers` is above 1, and
        otherwise ``"serial"``, this process. ``"dask"`` is a cluster of `workers` processes for
        this call, and an address such as ``"tcp://host:8786"`` the cluster of that scheduler, with
        all its workers: see docs/clusters.md. With processes or ``"dask"`` a script must guard its
        main part with ``if __name__ == "__main__":``. The result is the same, bit for bit.
    study : path-like, optional
        Folder in which points are stored as they are done. Points already stored there are not
        computed again; the result has the same bits. The folder must be new, empty, or a study of
        the same sweep, begun with the same versions of the software.
    progress : callable or bool, optional
        Called with the number of points done and their total; True shows a bar on standard error.
    **varied : float or array_like, shape (n,)
        Parameters of `Rotor` by name [dimensionless], in place of those of `rotor`; all are
        combined. An array becomes a dimension of the result, with each value once. ``omega``,
        ``zeta`` and ``delta0`` always are dimensions; of the others, a number other than the
        default becomes a scalar coordinate.
    clearance, friction, unbalance : float or array_like, shape (n,), optional
        Of a `RotorSystem` the largest clearance and friction coefficient of the contacts, and the
        largest moment of the unbalance, in the units of the system. The other contacts or
        unbalances keep their ratios to it; where all are 0, each gets it. An array becomes a
        dimension of the result, with each value once, and a number a scalar coordinate.
    damping, stiffness : float or array_like, shape (n,), optional
        Factors of the damping and stiffness matrices of a `RotorSystem`, with supports; 1 leaves
        them as they are.
    contacts, unbalance, supports, bearings, gravity, static_force : optional
        In place of those of a `RotorSystem`, as in `simulate`.

    Returns
    -------
    Dataset
        On ``(omega, zeta, delta0, start, direction)``, with any other axes before ``start``:
        ``response`` (its kind, as a flag),
        ``amplitude`` and ``phase_lag`` of the motion at the spin speed, ``radius_min``,
        ``radius_max``, ``period`` (on the rotating axes, of bouncing and full-contact motions, and
        under a load whole revolutions; else NaN), ``lyapunov_exponent`` and ``lyapunov_error``
        (the largest; NaN where not needed), ``status``, ``message``, ``event_count``, the final
        window and the state at its end on the rotating axes. With `events` also the events of all
        runs in one table, ``event_count`` rows each. With a direction the attribute ``along`` is
        the parameter that rises or falls. `rotor_ida.to_dataframe` returns one row for each point.

        Of a `RotorSystem` on ``(speed, start, direction)``, with any other axes before ``start``:
        ``response``, with the words and numbers of one disc, ``period`` of a motion that is not
        synchronous, ``cycle_distance`` (the estimated distance from the settled motion at the end,
        relative to its size), ``lyapunov_exponent`` and ``lyapunov_error`` where needed,
        ``revolutions`` for which it was followed, ``status`` and ``message``. On ``contact`` too:
        ``amplitude`` and ``phase_lag`` of the displacement at the spin speed, ``radius_min``,
        ``radius_max``, ``largest_force`` and ``touched``. On ``node``: ``node_amplitude``,
        ``node_phase_lag``, ``node_radius_min``, ``node_radius_max``. On ``component``:
        ``final_state``, with the unbalance at angle 0. The attribute ``design`` is the system and
        its starts as JSON; with ``clearance``, that of each contact is ``contact_clearance``.

    Raises
    ------
    InputError
        If an argument cannot be used. A point that fails does not raise: its ``status`` and
        ``message`` give the reason, also on a ramp whose dask workers keep dying.
    SimulationError
        If one of the ``"processes"``, or the scheduler, died.

    Warns
    -----
    UserWarning
        Before the sweep of a `RotorSystem` starts, if it takes minutes: where the cube of the
        degrees of freedom times the largest rate of vibration over the speed, added over all
        points, exceeds 1e8. The warning names a number of `modes` that is enough.

    Notes
    -----
    The motion is observed over a window: first after 24/zeta (2,000 at most), then whenever the
    time has doubled, until its response is decided, or until 60/zeta (at least 40,000, at most
    600,000; for a weak shaft with strong damping, 60 of its longer decay times). A motion of one
    disc that approaches a stable cycle by then is followed until it is there, for ten times as long
    at most. The response is, in this order,

    - ``touching`` if it is on the contact-free whirl and that reaches the stator to within 1e-9 of
      the clearance; ``synchronous`` or ``contact_free`` if it whirls steadily in contact, or has
      left the stator for good: all three follow from one state;
    - ``bouncing`` or ``full_contact`` if the states of largest radius recur throughout a window of
      at least three periods, and their differences and the cycle's slowest multiplier show that it
      is within 1e-9 of the cycle;
    - ``rolling`` (dry whip) instead, if it whirls backwards, stays in contact, and rolls on the
      stator at some time in each period; or in each revolution, if it has no period on the rotating
      axes and could be ``chaotic``;
    - ``touching`` if it touches once a revolution and 1/h, h the indentation, grows from touch to
      touch as `rotor_ida.closed_forms.touch_fading` predicts, to 10 %. Within 1e-6 of a whirl that
      just reaches the stator Taylor series follow it with every compiled `method`: contacts there
      have hardly any depth;
    - ``chaotic`` if it has not settled after 3,000 and 20/zeta, and its largest Lyapunov exponent,
      over a further 20,000 or more, exceeds five of its standard errors and stretches small
      differences by more than ``exp(20)``. Chaos that lasts longer may still be a transient;
    - ``quasi_periodic``, on a torus, if that exponent is zero instead, under a load or with
      friction or contact damping, and the motion is as large at the end of that time;
    - ``unresolved`` if it is none of these: then ``message`` gives for how long it was followed,
      and what still moved. Without damping nothing settles, and only the first window is observed.

    A motion on an unstable whirl or cycle (a small deviation grows in a period by more than
    1e-5 of it) is displaced by 0.001 clearances, along the growing motions, and followed again.

    A load rotates on the rotating axes. Under a load a motion is ``bouncing`` or ``full_contact``
    if its states once a revolution recur throughout such a window; ``contact_free`` around the
    point to which load and shaft deflect the rotor; ``touching`` only on a whirl that just reaches
    the stator; and ``quasi_periodic``, on
    a torus, if it might be ``chaotic`` but its largest exponent is zero (neighbours diverge or
    converge by less than 1 % in that time). A cycle whose period is not a whole number of
    revolutions becomes quasi-periodic under a slight load. A rotor at speed 0 comes to rest:
    ``contact_free``, or on the stator, which is reported as ``synchronous``.

    With friction or contact damping there are tori without a load too, on which the two largest
    exponents are zero.

    Period and extreme radii are those of the simulated motion in its last period: the roots of
    ``r r'``, found by simulating the window again with samples there. All runs use a tenth of the
    given tolerances, down to an ``rtol`` of 1e-12, since errors add up round a cycle.

    An axisymmetric `RotorSystem` is autonomous on axes that rotate with the unbalance: there a
    synchronous whirl stands still, and other periodic motions are cycles of any period. Of any
    other system the states once a revolution are compared, and periods are whole revolutions.

    The motion of a `RotorSystem` is followed until it shows to which stable cycle it leads;
    Newton's method then finds that cycle, from where the simulation goes on
    (`rotor_ida.steady.landing`). Only a motion that misses itself by less than 1e-9 of its size
    over a window is periodic. With slight damping this saves thousands of revolutions. A motion
    that shows no cycle is followed for 60 times the slowest decay time of a free motion, at least
    1,500 and at most 4,000 revolutions. After 450 revolutions and 20 decay times, or 1,500
    revolutions, its largest Lyapunov exponents decide whether it is ``chaotic`` or
    ``quasi_periodic``: by
    neighbours over 2,000 revolutions, or 8,000 in doubt. Chaos that lasts longer may still be a
    transient.

    A motion on an unstable equilibrium, whirl or cycle is displaced too. Without contact no motion
    is chaotic: one that grows there stays ``unresolved``, or fails.

    A system is ``rolling`` (dry whip) if a contact stays closed, whirls backwards, and rolls in
    every period or revolution. Fading touches are ``touching`` where no stiffness returns the
    rotor to the axis.

    Examples
    --------
    >>> responses = sweep(omega=[1.2, 1.7], zeta=0.5, delta0=0.5)
    >>> responses.amplitude.squeeze().values.round(8)
    array([0.84973087, 0.93446294])
    >>> responses.amplitude.sel(omega=1.7, method="nearest").item() == responses.amplitude[1].item()
    True
    >>> from rotor_ida import Rotor
    >>> rotor = Rotor(omega=1.5, zeta=0.07, delta0=0.5)
    >>> both = sweep(rotor, delta0=[0.0, 0.5, 1.5], direction="both")
    >>> both.amplitude.squeeze().sel(direction=1).values.round(4)
    array([6.408 , 7.48  , 9.4107])
    >>> both.amplitude.squeeze().sel(direction=-1).values.round(4)
    array([6.408 , 1.3259, 0.9957])

    >>> import numpy as np
    >>> from rotor_ida import Contact, RotorSystem, Unbalance, decode_flags
    >>> system = RotorSystem(
    ...     mass=np.eye(2), damping=0.1 * np.eye(2), stiffness=np.eye(2), nodes={"disc": (0, 1)},
    ...     contacts=[Contact(node="disc", clearance=1.5, stiffness=4.0, exponent=1.0)],
    ...     unbalance=[Unbalance(node="disc", moment=1.0)], units="1")
    >>> responses = sweep(system, speed=[0.5, 0.9], direction="up")
    >>> decode_flags(responses.response).values.ravel().tolist()
    ['contact_free', 'synchronous']
    >>> responses.amplitude.values.ravel().round(6).tolist()
    [0.332595, 1.622132]
    """
    reports = check_progress(progress)
    check_flag("events", events)
    asked: VariedDisc | VariedSystem
    more: dict[str, Any] = {}
    if isinstance(rotor, RotorSystem):
        speeds = turning_speeds(speed, "in a sweep of a rotor system")
        given = varied_system_of(sweep, rotor, varied, speeds)
        asked = VariedSystem.of(given, starts, modes, rtol)
    else:
        asked = VariedDisc.of(
            varied_of(sweep, rotor, varied), starts, rtol=rtol, atol=atol, method=method,
            flight=flight, backend=backend,
        )  # fmt: skip
        more = {"flight": asked.options.flight, "events": events}
    chosen = choose(executor, workers, compiled=asked.is_compiled)
    points, way = in_order(asked.varied, len(asked.starts), direction, along, asked.speed)
    check_size(points, study)
    told = {"along": way} if way not in {"", SPEED} else {}
    question = Question("sweep", {
        **points.design, "starts": asked.kept, "direction": direction, **told, **asked.arguments,
        **more,
    })  # fmt: skip
    plan: Ramps[Any, Any] = asked.ramps(points, way)
    if events and isinstance(asked, VariedDisc):
        work = partial(answer_of_disc, asked.options, events=True)
        plan = replace(plan, answers=replace(plan.answers, work=work, event=EVENT))
    columns = run_study(
        plan, question, word="points of a sweep", study=study, workers=chosen, progress=reports
    )
    return _dataset(asked, points, columns, told, question)


def _dataset(
    asked: VariedDisc | VariedSystem, points: Varied, columns: Columns, told: Mapping[str, Any],
    question: Question,
) -> xr.Dataset:  # fmt: skip
    """Return a sweep as a labelled dataset."""
    variables, table = labelled_points(points, columns.points, asked.behind), columns.events
    if table:
        variables |= counted("event_count", variables["event_count"], "event")
        variables |= {name: labelled(name, "event", column) for name, column in table.items()}
        variables |= event_columns(
            table["event_time"], table["event_kind"], kinds_of_events(*points.extremes())
        )
    coordinates, key = asked.coordinates(points), question.attribute()
    if isinstance(asked, VariedSystem):
        coordinates |= {"initial_state": (("start", "component"), asked.initial_states(points))}
        # however long: as variables its matrices would be columns of its table
        key = {QUESTION: question.text()}
    return study_dataset(
        asked, points, f"{asked.title}: responses over a range of speeds", variables, coordinates,
        {**asked.attributes, **told, **key}, "sweep",
    )  # fmt: skip


def study_dataset(
    asked: VariedDisc | VariedSystem, points: Varied, title: str,
    variables: Mapping[str, xr.Variable], coordinates: Mapping[str, Column | xr.Variable],
    attributes: Mapping[str, Any], kind: str,
) -> xr.Dataset:  # fmt: skip
    """Return the answers of a study of any rotor as a labelled dataset.

    `kind` is that of one disc, and for a rotor system stands behind ``system_``.
    """
    found = labelled_dataset(
        title, variables, {**points.coordinates, **coordinates}, attributes,
        kind=kind if points.system is None else f"system_{kind}",
    )  # fmt: skip
    return with_meanings(asked.labelled(found), points, attributes)
