"""Sweeps: the settled response at each speed, damping and clearance.

The points of the grid form ramps (quasi-static run-up and run-down, of the speed or of another
parameter): each point of a ramp begins where the one before has ended. Without a direction each
point is a separate ramp.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, fields, replace
from typing import Unpack

import numpy as np
import xarray as xr

from rotor_ida.checks import AT_REST, check_flag, check_progress
from rotor_ida.model.disc_starts import begun
from rotor_ida.model.parameters import OF_ROTOR, Parameters
from rotor_ida.model.rotor import DimensionalRotor, Rotor
from rotor_ida.model.varied import Varied, varied_of
from rotor_ida.parallel import Progress, Stop, Workers, choose, shows_progress
from rotor_ida.results.in_si import varies_in_si
from rotor_ida.results.provenance import provenance
from rotor_ida.results.question import Question
from rotor_ida.results.rows import counted
from rotor_ida.results.run import event_columns
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
from rotor_ida.simulation.starts import GivenStart, Starts, states_of
from rotor_ida.steady.follow import FAILED, SettledResponse, failed, follow_to_steady_state
from rotor_ida.steady.grid import (
    NO_COLUMNS,
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


@varies_in_si
@shows_progress
def sweep(
    rotor: Rotor | DimensionalRotor | None = None,
    *,
    starts: Starts = (AT_REST,),
    direction: Direction | None = None,
    along: str | None = None,
    events: bool = False,
    rtol: float = 1e-10,
    atol: float = 1e-12,
    method: Method | None = None,
    flight: Flight = "exact",
    backend: Backend = "auto",
    workers: int | None = None,
    executor: str = "auto",
    study: Folder | None = None,
    progress: Progress | bool | None = None,
    **varied: Unpack[Parameters],
) -> xr.Dataset:
    """Compute the settled response at every speed, damping and clearance.

    Parameters
    ----------
    rotor : Rotor or DimensionalRotor, optional
        The rotor. Without it, ``omega``, ``zeta`` and ``delta0`` must be given.
    starts : array_like, shape (n, 4), "settled", "rest", Dataset, or sequence of these
        Starts ``(x, y, vx, vy)`` [1], words for those at each speed, or results that end in one, as
        for `simulate`.
    direction : {"up", "down", "both"}, optional
        Quasi-static run-up or run-down: only the first speed (the last, going down) begins from
        the starts, and each other from the end of the one before, so that jumps and their
        hysteresis appear. By default each speed begins from the starts.
    along : str, optional
        Name of the parameter that rises or falls with a direction, in increasing order. Default:
        ``"omega"`` if the speed varies, else the only parameter that does. The other parameters
        are combined with it.
    events : bool
        Whether to keep the contact events of all runs, in one table beside the points.
    rtol, atol, flight, backend
        As for `simulate`.
    method : {"adams", "bdf", "ida", "taylor"}, optional
        As for `simulate`; default: Taylor series, or ``"adams"`` where they do not go with flight,
        backend or ``rtol``. The attribute ``method`` of the result gives which.
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

    Returns
    -------
    Dataset
        On ``(omega, zeta, delta0, start, direction)``, with any other axes before ``start``:
        ``response`` (its kind, as a flag),
        ``amplitude`` and ``phase_lag`` of the motion at the spin speed, ``radius_min``,
        ``radius_max``, ``period`` (on the rotating axes, of bouncing and full-contact motions, and
        under a load whole revolutions; else NaN), ``lyapunov_exponent`` and ``lyapunov_error``
        (the largest; NaN where not needed), ``status``, ``message``, ``event_count``, the final
        window and the state at its end on the rotating axes. ``to_dataframe`` returns one row for
        each point. With `events` also the events of all runs in one table, ``event_count`` rows
        each. With a direction the attribute
        ``along`` is the parameter that rises or falls.

    Raises
    ------
    InputError
        If an argument cannot be used. A point that fails does not raise: its ``status`` and
        ``message`` give the reason, also on a ramp whose dask workers keep dying.
    SimulationError
        If one of the ``"processes"``, or the scheduler, died.

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

    Examples
    --------
    >>> responses = sweep(omega=[1.2, 1.7], zeta=0.5, delta0=0.5)
    >>> responses.amplitude.squeeze().values.round(8)
    array([0.84973087, 0.93446294])
    >>> responses.amplitude.sel(omega=1.7, method="nearest").item() == responses.amplitude[1].item()
    True
    >>> len(responses.to_dataframe())
    2
    >>> from rotor_ida import Rotor
    >>> rotor = Rotor(omega=1.5, zeta=0.07, delta0=0.5)
    >>> both = sweep(rotor, delta0=[0.0, 0.5, 1.5], direction="both")
    >>> both.amplitude.squeeze().sel(direction=1).values.round(4)
    array([6.408 , 7.48  , 9.4107])
    >>> both.amplitude.squeeze().sel(direction=-1).values.round(4)
    array([6.408 , 1.3259, 0.9957])
    """
    asked = varied_of(sweep, rotor, varied)
    options = options_of_study(rtol=rtol, atol=atol, method=method, flight=flight, backend=backend)
    progress = check_progress(progress)
    chosen = choose(executor, workers, compiled=options.backend != "python")
    check_flag("events", events)
    return sweep_varied(
        asked, starts, direction, along, options, chosen, events=events, study=study,
        progress=progress,
    )  # fmt: skip


def sweep_varied(
    varied: Varied,
    starts: Starts,
    direction: Direction | None,
    along: str | None,
    options: Options,
    workers: Workers,
    *,
    events: bool = False,
    study: Folder | None = None,
    progress: Progress | None = None,
) -> xr.Dataset:
    """Follow rotors until they have settled, as `sweep` does."""
    states = states_of("starts", starts, loaded=bool(varied.values("load").any()))
    varied, way = in_order(varied, len(states), direction, along, "omega")
    check_size(varied, study)
    check_varied_can_be_followed(varied, states)
    told = {"along": way} if way else {}
    how = {name: getattr(options, name) for name in ("rtol", "atol", "method", "flight")}
    question = Question("sweep", {
        **varied.design, "starts": states, "direction": direction, **told, **how, "events": events,
    })  # fmt: skip
    axis = varied.dims.index(way or "omega")
    plan: Ramps[Rotor, GivenStart, SettledResponse] = Ramps(
        varied, states, DiscSettling(options), varied.rotor, axis
    )
    event = EVENT if events else NO_COLUMNS
    form = form_of("points of a sweep", "points", POINT, event)
    rows = rows_of if events else points_of
    task: Task[DiscJob, list[SettledResponse]] = Task(settle_along, lost, rows, form, POINT, event)
    columns = run_study(plan, task, question, study=study, workers=workers, progress=progress)
    variables = labelled_points(varied, columns.points)
    if events:
        table = columns.events
        variables |= counted("event_count", variables["event_count"], "event")
        variables |= {name: labelled(name, "event", column) for name, column in table.items()}
        variables |= event_columns(table["event_time"], table["event_kind"], *varied.extremes())
    coordinates = varied.coordinates | start_coordinates(states)
    title = "Rotor in a clearance: responses over a range of speeds"
    attributes = provenance(options.attributes()) | told | start_words(states)
    attributes |= question.attribute()
    swept = labelled_dataset(title, variables, coordinates, attributes, kind="sweep")
    return with_direction_named(swept, way)


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
        return follow_to_steady_state(rotor, begun(start, rotor), self.options, stop=stop)

    def failed(self, rotor: Rotor, start: GivenStart, reason: str) -> SettledResponse:
        """Return the response of a rotor that could not be followed."""
        return failed(rotor, begun(start, rotor), self.options, reason)

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
