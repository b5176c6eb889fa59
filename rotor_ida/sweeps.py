"""Sweep speed, damping and clearance, and see on which response the rotor settles."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import closing
from dataclasses import dataclass
from typing import Literal

import numpy as np
import numpy.typing as npt
import xarray as xr

from rotor_ida.checks import State, check_axis, check_choice, check_state
from rotor_ida.dataset.sweep import sweep_dataset
from rotor_ida.ensemble import Lost, Progress, Stop, choose, run_all
from rotor_ida.errors import InputError
from rotor_ida.parameters import Rotor
from rotor_ida.settling import FAILED, Settled, failed, settle
from rotor_ida.simulator.limits import check_can_be_followed
from rotor_ida.simulator.options import Backend, Flight, Method, Options

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
    starts: Sequence[State] = (REST,),
    direction: Direction | None = None,
    rtol: float = 1e-10,
    atol: float = 1e-12,
    method: Method = "adams",
    flight: Flight = "exact",
    backend: Backend = "auto",
    workers: int | None = None,
    executor: str = "auto",
    progress: Progress | None = None,
) -> xr.Dataset:
    """Follow the rotor until it has settled, at every speed, damping and clearance.

    Parameters
    ----------
    omega, zeta, delta0 : array_like, shape (n,) or scalar
        The parameters to combine [1].
    starts : sequence of tuple of float
        Starts ``(x, y, vx, vy)`` [1].
    direction : {"up", "down", "both"}, optional
        Without it each speed begins from the starts. With it only the first does (the last,
        going down), and each further one from the end of the one before, so that jumps and
        their hysteresis appear.
    rtol, atol, method, flight, backend
        As for `simulate`.
    workers : int, optional
        How many chains of points to follow at a time; by default one for each core, or only one
        with the Python backend and ``executor="auto"``.
    executor : {"auto", "serial", "threads", "processes", "dask"} or str
        What follows them. ``"auto"`` means threads with the compiled backend; with the Python
        backend, which holds the interpreter's lock so that threads would gain nothing, processes
        if `workers` is above 1, and else ``"serial"``, this very process. ``"dask"`` is a cluster
        of `workers` processes for this call, and an address such as ``"tcp://host:8786"`` the
        cluster of that scheduler, with all its workers: see docs/clusters.md. With processes or
        ``"dask"`` a script must guard its main part with ``if __name__ == "__main__":``. The
        result is the same, bit for bit.
    progress : callable, optional
        Called with the number of points done and their total.

    Returns
    -------
    Dataset
        On ``(omega, zeta, delta0, start, direction)``: ``response`` (its kind, as a flag),
        ``amplitude`` and ``phase_lag`` of the motion at the spin speed, ``radius_min``,
        ``radius_max``, ``status``, ``message``, the final window and the state at its end on
        the rotating axes; the events of all runs in one table, ``event_count`` rows each.

    Raises
    ------
    InputError
        If an argument cannot be used. A point that fails does not raise: its ``status`` and
        ``message`` say why; so do those of a chain whose workers of dask keep dying.
    SimulationError
        If one of ``"processes"`` died, or the scheduler.

    Examples
    --------
    >>> responses = sweep(omega=[1.2, 1.7], zeta=0.5, delta0=0.5)
    >>> responses.amplitude.squeeze().values.round(8)
    array([0.84973087, 0.93446294])
    """
    axes = {
        name: check_axis(name, values)
        for name, values in (("omega", omega), ("zeta", zeta), ("delta0", delta0))
    }
    checked = _check_starts(starts)
    if direction is not None:
        check_choice("direction", direction, ("up", "down", "both"))
        if (axes["omega"][1:] <= axes["omega"][:-1]).any():
            raise InputError("omega must increase in a sweep up or down")
    options = Options(rtol=rtol, atol=atol, method=method, flight=flight, backend=backend)
    place, count = choose(executor, workers, compiled=options.backend != "python")
    directions = DIRECTIONS[direction]
    sizes = [axes[name].size for name in ("omega", "zeta", "delta0")]
    chains = list(_chains(sizes, len(checked), directions))
    jobs = [_job(chain, axes, checked, options) for chain in chains]
    for job in jobs:
        for rotor in job.rotors:
            check_can_be_followed(rotor, job.start, settling=True)
    total = sum(len(chain.indices) for chain in chains)
    points: dict[tuple[int, ...], Settled] = {}
    order = sorted(range(len(jobs)), key=lambda number: _haste(jobs[number]))
    waiting = (jobs[number] for number in order)
    count = count and min(count, len(jobs))  # the cluster at an address has its own
    with closing(run_all(_follow, waiting, workers=count, executor=place)) as ended:
        for turn, found in ended:
            number = order[turn]
            settled = _all_failed(jobs[number], found) if isinstance(found, Lost) else found
            points.update(zip(chains[number].indices, settled, strict=True))
            if progress is not None:
                progress(len(points), total)
    return sweep_dataset(axes, checked, directions, points, options)


@dataclass(frozen=True, slots=True)
class _Chain:
    """Points in the order in which one follows from the other."""

    indices: list[tuple[int, int, int, int, int]]


@dataclass(frozen=True, slots=True)
class _Job:
    """A chain with all that a process needs to follow it."""

    rotors: list[Rotor]
    start: State
    options: Options


def _check_starts(starts: object) -> list[State]:
    try:
        listed = list(starts)  # type: ignore[call-overload]
    except TypeError:
        raise InputError(f"starts must be a sequence of starts, got {starts!r}") from None
    if not listed:
        raise InputError("starts must hold at least one start, got none")
    return [check_state("start", start) for start in listed]


def _chains(sizes: Sequence[int], starts: int, directions: Sequence[int]) -> Iterator[_Chain]:
    """Yield the chains of a sweep; where each speed begins anew, chains of one point."""
    speeds, dampings, clearances = sizes
    for d, direction in enumerate(directions):
        for zeta in range(dampings):
            for delta0 in range(clearances):
                for start in range(starts):
                    indices = [(omega, zeta, delta0, start, d) for omega in range(speeds)]
                    if direction == 0:
                        yield from (_Chain([index]) for index in indices)
                    else:
                        yield _Chain(indices[::direction])


def _job(
    chain: _Chain, axes: dict[str, npt.NDArray[np.float64]], starts: list[State], options: Options
) -> _Job:
    rotors = [
        Rotor(
            omega=float(axes["omega"][omega]),
            zeta=float(axes["zeta"][zeta]),
            delta0=float(axes["delta0"][delta0]),
        )
        for omega, zeta, delta0, _, _ in chain.indices
    ]
    return _Job(rotors, starts[chain.indices[0][3]], options)


def _haste(job: _Job) -> tuple[int, float]:
    """Return what is smallest for the chain to begin with, so that none is left over at the end.

    Long chains take longest, and those with much clearance, where the rotor bounces.
    """
    return (-len(job.rotors), -job.rotors[0].delta0)


def _follow(job: _Job, stop: Stop) -> list[Settled]:
    """Follow one chain: each point begins where the last one that did not fail has ended."""
    state, settled = job.start, []
    for rotor in job.rotors:
        if stop[0]:
            break
        try:
            point = settle(rotor, state, job.options, stop=stop)
        except Exception as error:  # whatever it is, it is this point's own affair
            point = failed(state, f"{type(error).__name__}: {error}".rstrip(": "))
        if point.response != FAILED:
            state = point.end
        settled.append(point)
    return settled


def _all_failed(job: _Job, lost: Lost) -> list[Settled]:
    return [failed(job.start, lost.reason) for _ in job.rotors]
