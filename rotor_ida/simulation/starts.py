"""The states that begin motions of one disc: as given, where results end, or drawn from a box."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Literal

import numpy as np
import numpy.typing as npt
import xarray as xr

from rotor_ida.arrays import Values
from rotor_ida.checks import (
    COMPONENTS,
    STARTS,
    State,
    check_choice,
    check_state,
    check_states,
    check_vector,
    is_scalar,
    listed,
)
from rotor_ida.errors import InputError
from rotor_ida.model.disc_starts import begun
from rotor_ida.model.rotor import Rotor
from rotor_ida.results.kinds import KINDS, kind_of
from rotor_ida.results.si_units import dimensionless
from rotor_ida.simulation.options import LARGEST

# Several starts: rows of states, results that end in one, or one such result.
Starts = npt.ArrayLike | xr.Dataset | Sequence[npt.ArrayLike | xr.Dataset]
# One start, as functions take it: a state, a word, or a result that ends in a state.
Start = npt.ArrayLike | Literal["settled", "rest"] | xr.Dataset
# A start of any rotor: a state, or the word for one that depends on the rotor.
GivenStart = State | str
# Under a load the unbalance must be where it is at time 0, to this part of a radian.
IN_STEP = 1e-6


def state_of(name: str, start: object, rotor: Rotor) -> State:
    """Return a start of a rotor, ``(x, y, vx, vy)`` with the unbalance along x.

    Raise `InputError` if there is none.

    Parameters
    ----------
    name : str
        The argument, for messages.
    start : array_like, shape (4,), "settled", "rest" or Dataset
        The state; a word, as `rotor_ida.model.disc_starts` states it; or a result that ends in
        one: a run or run-up, one point of a sweep or of many run-ups, a limit cycle, or one point
        of a branch.

    Notes
    -----
    A run ends with its last sample, at some angle of the unbalance. The state is turned back by
    this angle, as the equations are the same along all axes; under a load they are not.

    Examples
    --------
    >>> from rotor_ida import Rotor, simulate
    >>> rotor = Rotor(omega=2.0, zeta=0.1, delta0=3.0)
    >>> run = simulate(rotor, start=(0, 0, 0, 0), duration=math.pi / 2.0)
    >>> x, y, vx, vy = state_of("start", run, rotor)
    >>> abs(x + run.x[-1].item()) < 1e-12, abs(vy + run.vy[-1].item()) < 1e-12
    (True, True)
    """
    return begun(given_start(name, start, loaded=rotor.load > 0.0), rotor)


def given_start(name: str, start: object, *, loaded: bool) -> GivenStart:
    """Return a start as `state_of` takes it, as a state or a word, or raise `InputError`."""
    if isinstance(start, str):
        return str(check_choice(name, start, STARTS))
    if not isinstance(start, xr.Dataset):
        return check_state(name, start)
    found = dimensionless(start)
    prefix = "end_" if "end_x" in found else ""
    names = [f"{prefix}{each}" for each in COMPONENTS]
    if any(
        each not in found or not found[each].size or "node" in found[each].dims for each in names
    ):
        raise InputError(
            f"{name} must be a state (x, y, vx, vy), or end in one as a run, a limit cycle or one "
            f"point of a sweep of one disc does, got: {KINDS[kind_of(start)].meaning}"
        )
    dims = [str(dim) for dim in found[names[0]].dims if prefix or dim != "t"]
    if dims:
        raise InputError(f"{name} must be one point of a result, got all over {listed(dims)}")
    # a cycle is stored from its start on, with the unbalance along x
    last = 0 if "period" in found else -1
    x, y, vx, vy = (float(found[each].values.flat[last]) for each in names)
    turn = np.exp(-1j * _angle_in(name, found, prefix, last, loaded=loaded))
    place, velocity = complex(x, y) * turn, complex(vx, vy) * turn
    return check_state(name, (place.real, place.imag, velocity.real, velocity.imag))


def _angle_in(name: str, found: xr.Dataset, prefix: str, last: int, *, loaded: bool) -> float:
    """Return the angle of the unbalance at the end of a result, less whole revolutions."""
    if f"{prefix}angle" in found:
        angle = float(found[f"{prefix}angle"].values.flat[last])
    elif prefix or "period" in found:  # on axes that turn with the unbalance
        return 0.0
    else:
        angle = float(found["omega"]) * float(found["t"].values.flat[last])
    angle = math.remainder(angle, math.tau)
    if loaded or ("load" in found and float(found["load"]) != 0.0):
        if abs(angle) > IN_STEP:
            raise InputError(
                f"{name} must end after whole revolutions under a load, got a run that ends with "
                f"the unbalance at {angle:.6g} rad"
            )
        return 0.0
    return angle


def states_of(name: str, starts: object, *, loaded: bool = False) -> list[GivenStart]:
    """Return starts, each as for `given_start`; a result or a word alone is one start."""
    if isinstance(starts, xr.Dataset | str):
        return [given_start(name, starts, loaded=loaded)]
    if isinstance(starts, list | tuple) and any(
        isinstance(each, xr.Dataset | str) for each in starts
    ):
        return [given_start("start", each, loaded=loaded) for each in starts]
    return [*check_states(name, starts)]


def drawn_from(box: Values, seed: int, first: int, last: int) -> Values:
    """Return starts `first` to `last` of a box, shape (4, n), as if all were drawn at once."""
    bits = np.random.PCG64(seed)
    bits.advance(len(COMPONENTS) * first)
    chance = np.random.Generator(bits).random((last - first, len(COMPONENTS)))
    return np.asarray(box[:, :1] + (box[:, 1:] - box[:, :1]) * chance.T)


def box_of(ranges: Mapping[str, npt.ArrayLike], starts: int) -> Values:
    """Return the ends of the four ranges, shape (4, 2), from which `starts` are drawn."""
    box = np.array([range_of(name, ranges[name]) for name in COMPONENTS])
    if starts > 1 and (box[:, 0] == box[:, 1]).all():
        raise InputError(f"x, y, vx or vy must be a range, got numbers for {starts} starts")
    return box


def range_of(name: str, value: object) -> tuple[float, float]:
    """Return the ends of a range; a number is a range of length zero."""
    ends = check_vector(name, value, largest=LARGEST).tolist()
    if len(ends) > 2 or (len(ends) == 1 and not is_scalar(name, value)):
        raise InputError(
            "{name} must be a number or a range (low, high), got {value}", name=name, value=ends
        )
    low, high = ends[0], ends[-1]
    if low > high:
        raise InputError(
            "{name} must be a range (low, high) with low <= high, got {value}",
            name=name, value=(low, high),
        )  # fmt: skip
    return low, high
