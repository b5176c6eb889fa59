"""Sweeps: the settled response at each speed, damping and clearance.

The points of the grid form ramps (quasi-static run-up and run-down, of the speed or of another
parameter): each point of a ramp begins where the one before has ended. Without a direction each
point is a separate ramp.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, fields, replace
from typing import Any, Unpack

import numpy as np
import numpy.typing as npt
import xarray as xr

from rotor_ida.checks import AT_REST, check_flag, check_progress
from rotor_ida.model.parameters import OF_ROTOR
from rotor_ida.model.rotor import DimensionalRotor, Rotor
from rotor_ida.model.rotor_system import RotorSystem
from rotor_ida.model.system_parameters import SPEED, AnyAxes
from rotor_ida.model.varied import Varied, varied_of, varied_system_of
from rotor_ida.parallel import Progress, Stop, choose, shows_progress
from rotor_ida.results.in_si import takes_rotors
from rotor_ida.results.provenance import provenance
from rotor_ida.results.question import Question
from rotor_ida.results.rows import counted
from rotor_ida.results.run import event_columns, kinds_of_events
from rotor_ida.results.studies.results import Folder
from rotor_ida.schema import RESPONSE, STATUS, labelled, labelled_dataset
from rotor_ida.simulation.options import (
    Backend,
    Flight,
    Method,
    Options,
    check_can_be_followed,
    options_of_study,
)
from rotor_ida.simulation.starts import GivenStart, Starts, start_of, states_of
from rotor_ida.steady.follow import FAILED, SettledResponse, failed, follow_to_steady_state
from rotor_ida.steady.grid import (
    NO_COLUMNS,
    Columns,
    Rows,
    Task,
    check_size,
    form_of,
    labelled_points,
    representative,
    run_study,
    start_coordinates,
    start_words,
)
from rotor_ida.steady.ramps import Direction, RampJob, Ramps, in_order, lost, settle_along
from rotor_ida.steady.response import Features
from rotor_ida.steady.system_sweep import (
    VariedSystem,
    checked_starts,
    sweep_of_system,
    turning_speeds,
)

FEATURES = tuple(each.name for each in fields(Features))
# The columns of a sweep with a number for each point, and those with one for each event.
POINT = np.dtype(
    [
        ("response", np.int8),
        *((name, np.float64) for name in (*FEATURES, "window_start", "window_end")),
        ("status", np.int8),
        ("event_count", np.int64),
        *((name, np.float64) for name in ("end_x", "end_y", "end_vx", "end_vy")),
    ]
)
EVENT_STATES = ("event_x", "event_y", "event_vx", "event_vy")
EVENT = np.dtype(
    [
        ("event_time", np.float64),
        ("event_kind", np.int8),
        *((name, np.float64) for name in EVENT_STATES),
    ]
)


@takes_rotors(
    disc=("events", "atol", "method", "flight", "backend"), system=("modes",), varies=True
)
@shows_progress
def sweep(
    rotor: Rotor | DimensionalRotor | RotorSystem | None = None,
    *,
    speed: npt.ArrayLike | None = None,
    starts: Starts = (AT_REST,),
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
        Starts ``(x, y, vx, vy)`` [1], words for those at each speed, or results that end in one, as
        for `simulate`. Those of a `RotorSystem` are a sequence of ``(q, velocity)``, words, None
        (at rest at 0) or results, or one result. Default: one, at rest on the axis.
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
        Parameters of `Rotor` by name [1], in place of those of `rotor`; all are combined. An array
        becomes a dimension of the result, with each value once. ``omega``, ``zeta`` and ``delta0``
        always are dimensions; of the others, a number other than the default becomes a scalar
        coordinate.
    clearance, friction, unbalance : float or array_like, shape (n,), optional
        Of a `RotorSystem` the largest clearance and friction coefficient of the contacts, and the
        largest moment of the unbalance, in the units of the system. The other contacts or
        unbalances keep their ratios to it; where all are 0, each gets it. An array becomes a
        dimension of the result, with each value once, and a number a scalar coordinate.
    damping, stiffness : float or array_like, shape (n,), optional
        Factors of the damping and stiffness matrices of a `RotorSystem`, with supports; 1 leaves
        them as they are.
    contacts, unbalance, supports, gravity, static_force : optional
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
    600,000; for a weak shaft with strong damping, 60 of its longer decay times). The response is,
    in this order,

    - ``synchronous`` or ``contact_free`` if it whirls steadily in contact, or has left the stator
      for good: both follow from one state;
    - ``bouncing`` or ``full_contact`` if the states of largest radius recur throughout a window of
      at least three periods, and their differences and the cycle's slowest multiplier show that it
      is within 1e-9 of the cycle;
    - ``rolling`` (dry whip) instead, if it whirls backwards, stays in contact, and rolls on the
      stator at some time in each period; or in each revolution, if it has no period on the rotating
      axes and could be ``chaotic``;
    - ``touching`` if it touches once a revolution and 1/h, h the indentation, grows from touch to
      touch as `rotor_ida.closed_forms.touch_fading` predicts, to 10 %; or if it is on the
      contact-free whirl and that reaches the stator to within 1e-9 of the clearance. Within 1e-6
      Taylor series follow it with every compiled `method`: contacts there have hardly any depth;
    - ``chaotic`` if it has not settled after 3,000 and 20/zeta, and its largest Lyapunov exponent,
      over a further 20,000 or more, exceeds five of its standard errors and stretches small
      differences by more than ``exp(20)``. Chaos that lasts longer may still
      be a transient;
    - ``unresolved`` if it is none of these: then ``message`` gives for how long it was followed,
      and what still moved. Without damping nothing settles, and only the first window is observed.

    A motion that sits on an unstable whirl or cycle (a small change grows in a period by more than
    1e-5 of it) is moved off by 0.001 clearances, along the motions that grow, and followed anew.

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

    An axisymmetric `RotorSystem` is autonomous on axes that turn with the unbalance: there a
    synchronous whirl stands still, and other periodic motions are cycles of any period. Of any
    other system the states once a revolution are compared, and periods are whole revolutions.

    The motion of a `RotorSystem` is followed until it shows to which stable cycle it leads;
    Newton's method then finds that cycle, from where the simulation goes on
    (`rotor_ida.steady.landing`). Only a motion that misses itself by less than 1e-9 of its size
    over a window is periodic. So slight damping costs no thousands of revolutions. A motion that
    shows no cycle is followed for 60 times the slowest decay time of a free motion, at least 1,500
    and at most 4,000 revolutions. After 450 revolutions and 20 decay times, or 1,500 revolutions,
    its largest Lyapunov exponents decide whether it is ``chaotic`` or ``quasi_periodic``: by
    neighbours over 2,000 revolutions, or 8,000 in doubt. Chaos that lasts longer may still be a
    transient.

    A motion that sits on an unstable equilibrium, whirl or cycle is moved off too. Without contact
    nothing is chaotic: what grows there stays ``unresolved``, or fails.

    A system is ``rolling`` (dry whip) if a contact stays closed, whirls backwards, and rolls in
    every period or revolution. The kind ``touching`` of one disc is not told from ``unresolved``
    ones.

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
    how: dict[str, Any]
    kept: Sequence[Any]
    if isinstance(rotor, RotorSystem):
        speeds = turning_speeds(speed, "in a sweep of a rotor system")
        asked = varied_system_of(sweep, rotor, varied, speeds)
        system = VariedSystem.of(asked, checked_starts(starts), modes, rtol)
        given, kept, chosen = system.varied, system.kept, choose(executor, workers, compiled=True)
        how = {"rotor": asked.base, "modes": modes, "rtol": system.rtol}
    else:
        given = varied_of(sweep, rotor, varied)
        options = options_of_study(
            rtol=rtol, atol=atol, method=method, flight=flight, backend=backend
        )
        chosen = choose(executor, workers, compiled=options.backend != "python")
        states = kept = states_of("starts", starts, loaded=bool(given.values("load").any()))
        how = {name: getattr(options, name) for name in ("rtol", "atol", "method", "flight")}
        how["events"] = events
    first = "omega" if given.system is None else SPEED
    points, way = in_order(given, len(kept), direction, along, first)
    check_size(points, study)
    told = {"along": way} if way not in {"", SPEED} else {}
    question = Question("sweep", {
        **points.design, "starts": kept, "direction": direction, **told, **how
    })  # fmt: skip
    axis = points.dims.index(way or first)
    jobs: dict[str, Any] = {"study": study, "workers": chosen, "progress": reports}
    if isinstance(rotor, RotorSystem):
        return sweep_of_system(points, system.starts, axis, system.rtol, question, told, jobs)
    check_varied_can_be_followed(points, states)
    plan: Ramps[Rotor, GivenStart, SettledResponse] = Ramps(
        points, states, DiscSettling(options), points.rotor, axis
    )
    columns = _followed(plan, question, jobs, events=events)
    attributes = provenance(options.attributes()) | told | start_words(states)
    attributes |= question.attribute()
    return with_direction_named(_dataset(points, columns, states, attributes, events=events), way)


def _followed(
    plan: Ramps[Rotor, GivenStart, SettledResponse], question: Question, jobs: dict[str, Any],
    *, events: bool,
) -> Columns:  # fmt: skip
    """Return the columns of one disc that is followed until it has settled."""
    event = EVENT if events else NO_COLUMNS
    form = form_of("points of a sweep", "points", POINT, event)
    rows = rows_of if events else points_of
    task: Task[DiscJob, list[SettledResponse]] = Task(settle_along, lost, rows, form, POINT, event)
    return run_study(plan, task, question, **jobs)


def _dataset(
    varied: Varied, columns: Columns, starts: Sequence[GivenStart], attributes: dict[str, Any],
    *, events: bool,
) -> xr.Dataset:  # fmt: skip
    """Return a sweep of one disc as a labelled dataset."""
    variables = labelled_points(varied, columns.points)
    if events:
        table = columns.events
        variables |= counted("event_count", variables["event_count"], "event")
        variables |= {name: labelled(name, "event", column) for name, column in table.items()}
        variables |= event_columns(
            table["event_time"], table["event_kind"], kinds_of_events(*varied.extremes())
        )
    return labelled_dataset(
        "Rotor in a clearance: responses over a range of speeds", variables,
        varied.coordinates | start_coordinates(starts), attributes, kind="sweep",
    )  # fmt: skip


def with_direction_named(swept: xr.Dataset, along: str) -> xr.Dataset:
    """Return a result whose direction says which parameter is swept, if it is not the speed."""
    if along not in {"", "omega"}:
        words = f"direction in which the {OF_ROTOR[along].label} is swept"
        swept["direction"].attrs["long_name"] = words
    return swept


def check_varied_can_be_followed(varied: Varied, starts: Sequence[GivenStart]) -> None:
    """Check each speed, each clearance and each start once, and the largest damping."""
    rotors = varied.extremes()
    first, *others = representative(starts)
    for rotor in rotors:
        check_can_be_followed(rotor, first, settling=True)
    for start in others:
        check_can_be_followed(rotors[0], start, settling=True)


DiscJob = RampJob[Rotor, GivenStart, SettledResponse]


@dataclass(frozen=True, slots=True)
class DiscSettling:
    """How one disc is followed: see `rotor_ida.steady.ramps.Settling`."""

    options: Options

    def settle(self, rotor: Rotor, start: GivenStart, stop: Stop) -> SettledResponse:
        """Return the response on which a rotor settles."""
        return follow_to_steady_state(rotor, start_of(rotor, start), self.options, stop=stop)

    def failed(self, rotor: Rotor, start: GivenStart, reason: str) -> SettledResponse:
        """Return the response of a rotor that could not be followed."""
        return failed(rotor, start_of(rotor, start), self.options, reason)

    def end(self, settled: SettledResponse) -> GivenStart | None:
        """Return the state at the end."""
        return None if settled.response == FAILED else settled.end


def points_of(points: Sequence[SettledResponse]) -> Rows:
    """Return points as rows, without their events."""
    return replace(rows_of(points), events=None)


def rows_of(points: Sequence[SettledResponse]) -> Rows:
    """Return points as rows, and the events of all."""
    rows = [
        (
            RESPONSE[point.response],
            *(getattr(point.features, name) for name in FEATURES),
            point.window_start,
            point.window_end,
            STATUS["failed" if point.response == FAILED else "done"],
            point.event_times.size,
            *point.end,
        )
        for point in points
    ]
    events = np.empty(sum(point.event_times.size for point in points), dtype=EVENT)
    events["event_time"] = np.concatenate([point.event_times for point in points])
    events["event_kind"] = np.concatenate([point.event_kinds for point in points])
    states = np.concatenate([point.event_states for point in points])
    for name, column in zip(EVENT_STATES, states.T, strict=True):
        events[name] = column
    return Rows(np.array(rows, dtype=POINT), [point.message for point in points], events)
