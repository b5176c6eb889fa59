"""Assertions for regression tests on contact-event timing."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt
import xarray as xr

from rotor_ida.arrays import Values
from rotor_ida.schema import DAMPED_EVENT_KIND, OF_FRICTION_EVENT_KIND, by_number

NAMES = by_number(DAMPED_EVENT_KIND | OF_FRICTION_EVENT_KIND)


def assert_events_close(
    actual: xr.Dataset,
    expected: xr.Dataset,
    *,
    atol: float | None = None,
    rtol: float = 0.0,
) -> None:
    """Raise unless two runs have the same contact events at the same times.

    Parameters
    ----------
    actual, expected : Dataset
        Runs, or other datasets with ``event_time`` and ``event_kind`` on ``event``.
    atol : float, optional
        Largest allowed difference of two event times [dimensionless]. Default: the sum of the
        datasets' ``event_time_error``, or 0 if neither has any.
    rtol : float
        Additional allowed difference, relative to the expected time [dimensionless].

    Raises
    ------
    AssertionError
        If the events differ: the message shows the first difference.

    Examples
    --------
    >>> from rotor_ida import Rotor, simulate
    >>> rotor = Rotor(omega=2.0, zeta=0.07, delta0=2.0)
    >>> run = simulate(rotor, start=(0, 0, 0, 0), duration=20.0)
    >>> assert_events_close(run, simulate(rotor, start=(0, 0, 0, 0), duration=20.0, method="bdf"))
    >>> assert_events_close(run, run.assign(event_time=run.event_time + 1e-3), atol=1e-6)
    Traceback (most recent call last):
    ...
    AssertionError: contact events differ
    Mismatched events: 7 / 7 (100%)
    First difference: event 0, entry: actual 1.09854511..., expected 1.09954511...
    Difference: -0.001, allowed: 1e-06
    Max absolute difference: 0.001
    """
    times, wanted = actual["event_time"].values, expected["event_time"].values
    kinds, wanted_kinds = actual["event_kind"].values, expected["event_kind"].values
    common = min(times.size, wanted.size)
    allowed = _allowed(actual, expected, common, atol) + rtol * np.abs(wanted[:common])
    difference = times[:common] - wanted[:common]
    wrong = ~(np.abs(difference) <= allowed) | (kinds[:common] != wanted_kinds[:common])
    if times.size == wanted.size and not wrong.any():
        return
    lines = ["contact events differ"]
    if times.size != wanted.size:
        lines.append(f"Number of events: actual {times.size}, expected {wanted.size}")
    if wrong.any():
        place = int(np.argmax(wrong))
        share = 100.0 * wrong.sum() / common
        lines += [
            f"Mismatched events: {wrong.sum()} / {common} ({share:.3g}%)",
            f"First difference: event {place}, {_kinds(kinds, wanted_kinds, place)}: "
            f"actual {times[place]!s}, expected {wanted[place]!s}",
            f"Difference: {difference[place]:.6g}, allowed: {allowed[place]:.6g}",
            f"Max absolute difference: {np.abs(difference).max():.6g}",
        ]
    else:
        lines.append(_first_surplus(times, kinds, wanted, wanted_kinds))
    raise AssertionError("\n".join(lines))


def _allowed(actual: xr.Dataset, expected: xr.Dataset, common: int, atol: float | None) -> Values:
    if atol is not None:
        return np.full(common, atol)
    stated = np.zeros(common)
    for dataset in (actual, expected):
        if "event_time_error" in dataset:
            stated = stated + dataset["event_time_error"].values[:common]
    return stated


def _kinds(kinds: npt.NDArray[np.int8], wanted: npt.NDArray[np.int8], place: int) -> str:
    here, there = NAMES[int(kinds[place])], NAMES[int(wanted[place])]
    return here if here == there else f"{here} instead of {there}"


def _first_surplus(
    times: Values,
    kinds: npt.NDArray[np.int8],
    wanted: Values,
    wanted_kinds: npt.NDArray[np.int8],
) -> str:
    place = min(times.size, wanted.size)
    side, more, sort = (
        ("actual", times, kinds) if times.size > place else ("expected", wanted, wanted_kinds)
    )
    return f"First surplus event: {side} {NAMES[int(sort[place])]} at {more[place]!s}"
