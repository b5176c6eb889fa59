"""Sweeps: the settled response at each speed, damping and clearance."""

from __future__ import annotations

import os
from collections.abc import Iterator, Mapping, Sequence
from typing import Literal

import numpy as np
import numpy.typing as npt
import xarray as xr

from rotor_ida.checks import (
    MOST_NUMBERS,
    MOST_POINTS_OF_STUDY,
    State,
    check_axis,
    check_choice,
    check_increasing,
    check_points,
    check_progress,
    check_states,
    is_scalar,
)
from rotor_ida.model.parameters import Rotor
from rotor_ida.model.table import DEFAULTS
from rotor_ida.parallel import Progress, choose
from rotor_ida.results.provenance import computing
from rotor_ida.results.studies.results import open_results
from rotor_ida.simulation.options import Backend, Flight, Method, Options, check_can_be_followed
from rotor_ida.steady.jobs import Task, do_all
from rotor_ida.steady.ramps import Places, Ramps, follow, lost
from rotor_ida.steady.sweep_dataset import FORM, Rows, rows_of, sweep_dataset

Direction = Literal["up", "down", "both"]

DIRECTIONS: dict[str | None, tuple[int, ...]] = {
    None: (0,),
    "up": (1,),
    "down": (-1,),
    "both": (1, -1),
}
REST: State = (0.0, 0.0, 0.0, 0.0)


def sweep(
    *,
    omega: npt.ArrayLike,
    zeta: npt.ArrayLike,
    delta0: npt.ArrayLike,
    shaft_stiffness: npt.ArrayLike = 0.0,
    contact_exponent: npt.ArrayLike = 1.5,
    contact_damping: npt.ArrayLike = 0.0,
    load: npt.ArrayLike = 0.0,
    friction: npt.ArrayLike = 0.0,
    disc_radius: npt.ArrayLike | None = None,
    starts: npt.ArrayLike = (REST,),
    direction: Direction | None = None,
    rtol: float = 1e-10,
    atol: float = 1e-12,
    method: Method = "adams",
    flight: Flight = "exact",
    backend: Backend = "auto",
    workers: int | None = None,
    executor: str = "auto",
    study: str | os.PathLike[str] | None = None,
    progress: Progress | None = None,
) -> xr.Dataset:
    """Follow the rotor until it has settled, at every speed, damping and clearance.

    Parameters
    ----------
    omega, zeta, delta0 : array_like, shape (n,) or scalar
        The parameters to combine [1].
    shaft_stiffness, contact_exponent, contact_damping, load, friction : array_like or scalar
        What a machine has beyond the paper's rotor [1], numbers or of shape (n,): more to combine,
        a dimension where an axis is given, a coordinate where a number is given that is not the
        default.
    disc_radius : array_like, shape (n,) or scalar, optional
        The radius of the disc [1], which friction needs; likewise.
    starts : array_like, shape (n, 4)
        Starts ``(x, y, vx, vy)`` [1].
    direction : {"up", "down", "both"}, optional
        Without it each speed begins from the starts. With it only the first does (the last,
        going down), and each further one from the end of the one before, so that jumps and
        their hysteresis appear.
    rtol, atol, method, flight, backend
        As for `simulate`.
    workers : int, optional
        How many ramps of points to follow at a time; by default one for each core, or only one
        with the Python backend and ``executor="auto"``.
    executor : {"auto", "serial", "threads", "processes", "dask"} or str
        What follows them. ``"auto"`` means threads with the compiled backend; with the Python
        backend, which holds the interpreter's lock so that threads would gain nothing, processes
        if `workers` is above 1, and else ``"serial"``, this very process. ``"dask"`` is a cluster
        of `workers` processes for this call, and an address such as ``"tcp://host:8786"`` the
        cluster of that scheduler, with all its workers: see docs/clusters.md. With processes or
        ``"dask"`` a script must guard its main part with ``if __name__ == "__main__":``. The
        result is the same, bit for bit.
    study : path-like, optional
        Folder in which points are kept as they are done. If it holds some of them already, only
        the others are followed, to the same bits. It must be new, empty, or of a study of this
        very sweep, begun with the same versions of what computes.
    progress : callable, optional
        Called with the number of points done and their total.

    Returns
    -------
    Dataset
        On ``(omega, zeta, delta0, start, direction)``: ``response`` (its kind, as a flag),
        ``amplitude`` and ``phase_lag`` of the motion at the spin speed, ``radius_min``,
        ``radius_max``, ``period`` (on the rotating axes, of bouncing and full-contact motions, and
        under a load whole revolutions; else NaN), ``lyapunov_exponent`` and ``lyapunov_error``
        (the largest; NaN where the response was decided without), ``status``, ``message``, the
        final window and the state at its end on the rotating axes; the events of all runs in one
        table, ``event_count`` rows each.

    Raises
    ------
    InputError
        If an argument cannot be used. A point that fails does not raise: its ``status`` and
        ``message`` say why; so do those of a ramp whose workers of dask keep dying.
    SimulationError
        If one of ``"processes"`` died, or the scheduler.

    Notes
    -----
    The motion is seen over a window: first after 24/zeta (2,000 at most), then whenever the time
    has doubled, until its response is decided, or until 40,000. It is, in this order,

    - ``synchronous`` or ``contact_free`` if it whirls steadily in contact, or has left the ring for
      good: both follow from one state;
    - ``bouncing`` or ``full_contact`` if the states at which its radius is largest come again all
      over a window that holds three periods, and their misses and the cycle's slowest multiplier
      say that it is within 1e-9 of the cycle;
    - ``rolling`` (dry whip) instead, if it whirls backwards, stays in contact, and has a stretch of
      rolling on the ring in each period; or in each revolution, where it has no period on the
      rotating axes and could be ``chaotic``;
    - ``touching`` if it touches once a revolution and 1/h, h the indentation, grows from touch to
      touch by what `rotor_ida.closed_forms.touch_fading` says, to 10 %;
    - ``chaotic`` if it has not settled after 3,000 and 20/zeta, and its largest Lyapunov exponent,
      over 20,000 or more from there on, exceeds five of its errors. Chaos that lasts longer may
      still be a transient;
    - ``unresolved`` if it is none of these. Without damping nothing settles, and only the first
      window is seen.

    A load turns on the rotating axes. Under one a motion is ``bouncing`` or ``full_contact`` if its
    states once a revolution come again all over such a window; ``contact_free`` round the place
    where the shaft holds the load; ``touching`` never; ``quasi_periodic``, on a torus, if it might
    be ``chaotic``, but its largest exponent is zero: by it neighbours neither part nor come
    together by 1 % in that time. A cycle whose period is no whole number of revolutions becomes
    that under a slight load. A rotor that does not turn comes to rest, ``contact_free``, or on the
    ring, which is told as ``synchronous``.

    With friction, or contact damping, there are tori without a load too: on these the two largest
    exponents are zero.

    Period and extreme radii are those of the simulated motion in its last period: the roots of
    ``r r'``, found by simulating the window again with samples there. All runs are made with a
    tenth of the tolerances given, down to an ``rtol`` of 1e-12, since errors add up round a cycle.

    Examples
    --------
    >>> responses = sweep(omega=[1.2, 1.7], zeta=0.5, delta0=0.5)
    >>> responses.amplitude.squeeze().values.round(8)
    array([0.84973087, 0.93446294])
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
    checked = check_states("starts", starts)
    if direction is not None:
        check_choice("direction", direction, ("up", "down", "both"))
        check_increasing("omega", axes["omega"], "in a sweep up or down")
    options = Options(rtol=rtol, atol=atol, method=method, flight=flight, backend=backend)
    check_progress(progress)
    place, count = choose(executor, workers, compiled=options.backend != "python")
    ramps = Ramps(axes, checked, DIRECTIONS[direction], options, frozenset(numbers - absent))
    most = MOST_NUMBERS if study is None else MOST_POINTS_OF_STUDY
    check_points(*axes.values(), checked, ramps.directions, most=most)
    _check_can_be_followed(axes, checked)
    with open_results(study, _design(ramps, direction), ramps.points, FORM) as kept:
        do_all(ramps, Task(follow, lost, rows_of), kept, place, count, progress)

        def pieces() -> Iterator[tuple[Places, Rows]]:
            return ((ramps.places(number), rows) for number, rows in kept.results())

        return sweep_dataset(ramps, pieces, kept.folder)


def _design(ramps: Ramps, direction: Direction | None) -> dict[str, object]:
    """Return all that decides on the bits of a sweep."""
    options = ramps.options
    return {
        "kind": "sweep",
        **{
            name: values.item() if name in ramps.numbers else values.tolist()
            for name, values in ramps.axes.items()
        },
        "starts": [list(start) for start in ramps.starts],
        "direction": direction,
        **{name: getattr(options, name) for name in ("rtol", "atol", "method", "flight")},
        **computing(),
    }


def _check_can_be_followed(
    axes: Mapping[str, npt.NDArray[np.float64]], starts: Sequence[State]
) -> None:
    """Check each speed, each clearance and each start once, and the largest damping."""
    largest = {name: float(values.max()) for name, values in axes.items()}
    rotors = [
        Rotor(**largest | {name: value})
        for name in axes
        if name not in {"zeta", "shaft_stiffness"}
        for value in axes[name].tolist()
    ]
    for rotor in rotors:
        check_can_be_followed(rotor, starts[0], settling=True)
    for start in starts[1:]:
        check_can_be_followed(rotors[0], start, settling=True)
