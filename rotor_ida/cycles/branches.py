"""All branches of limit cycles on which the responses of a sweep lie."""

from __future__ import annotations

import numpy as np
import xarray as xr

from rotor_ida.checks import (
    COMPONENTS,
    MOST_NUMBERS,
    check_count,
    check_instance,
    check_progress,
)
from rotor_ida.cycles.continue_cycle import branch_from, check_limits
from rotor_ida.cycles.guess import Guess
from rotor_ida.cycles.shooting import close_orbit
from rotor_ida.errors import InputError, SimulationError
from rotor_ida.model.parameters import ALL_PARAMETERS, PARAMETERS
from rotor_ida.model.rotor import Rotor
from rotor_ida.parallel import Progress, shows_progress
from rotor_ida.results.in_si import keeps_si
from rotor_ida.schema import EXACT, check_as_computed, spread
from rotor_ida.simulation.flow import DiscFlow

NEEDED = ("lies_on", "exact_period", "exact_radius_max", *(f"end_{name}" for name in COMPONENTS))
# Two cycles of one rotor are the same if period and largest radius differ by less than this.
SAME_CYCLE = 1e-7
# Between points of a branch its cycles are interpolated linearly, with errors of up to 0.004 on the
# isolas. A guess that agrees with a cycle to this fraction is worth closing.
WORTH_CLOSING = 0.02


@keeps_si
@shows_progress
def branches_through(
    compared: xr.Dataset,
    *,
    limits: tuple[float, float],
    points: int = 2000,
    progress: Progress | bool | None = None,
) -> list[xr.Dataset]:
    """Compute the branches over the speed of all limit cycles found by a sweep.

    Parameters
    ----------
    compared : Dataset
        Result of `rotor_ida.compare` for a sweep.
    limits : tuple of float
        The lowest and the highest speed to which they are followed [dimensionless].
    points : int
        The largest number of points of each branch, each way.
    progress : callable or bool, optional
        Called with the number of responses processed and their total; True shows a bar on standard
        error.

    Returns
    -------
    list of Dataset
        The branches as of `rotor_ida.continue_cycle`, each once, in the order found.

    Raises
    ------
    InputError
        If the dataset is not such a comparison.

    Examples
    --------
    >>> from rotor_ida import compare, sweep
    >>> swept = sweep(omega=[2.7, 3.0], zeta=0.07, delta0=0.5, starts=[(3, 1, 0, 0)])
    >>> branches = branches_through(compare(swept), limits=(0.05, 5.0))
    >>> [branch.attrs["closed"] for branch in branches]
    [1]
    """
    check_instance("compared", compared, xr.Dataset)
    count = check_count("points", points, minimum=2, maximum=MOST_NUMBERS)
    progress = check_progress(progress)
    check_as_computed("compared", compared)
    missing = [name for name in (*NEEDED, *PARAMETERS) if name not in compared.variables]
    if missing:
        raise InputError(f"compared must be a comparison of a sweep; it lacks {', '.join(missing)}")
    lies_on = compared["lies_on"]
    parameters = [name for name in ALL_PARAMETERS if name in compared.variables]
    given = spread(compared, (*NEEDED, *parameters), lies_on)
    places = np.argwhere(lies_on.values == EXACT["cycle"])
    branches: list[xr.Dataset] = []
    for number, place in enumerate(map(tuple, places), start=1):
        here = {name: float(values[place]) for name, values in given.items()}
        rotor = Rotor(**{name: here[name] for name in parameters})
        period, radius = here["exact_period"], here["exact_radius_max"]
        if not any(holds_cycle(branch, rotor, period, radius) for branch in branches):
            state = np.array([here[f"end_{name}"] for name in COMPONENTS])
            guess = Guess(DiscFlow(rotor), state, period)
            bounds = check_limits("omega", limits, guess.flow)
            branches.append(branch_from(guess, "omega", bounds, count, {}))
        if progress is not None:
            progress(number, len(places))
    return branches


def holds_cycle(branch: xr.Dataset, rotor: Rotor, period: float, radius: float) -> bool:
    """Return whether a limit cycle lies on a branch."""
    given = {name: float(branch[name]) for name in ALL_PARAMETERS[1:] if name in branch.variables}
    if Rotor(**given | {"omega": rotor.omega}) != rotor:
        return False
    speeds = branch["omega"].values - rotor.omega
    for place in np.flatnonzero(speeds[:-1] * speeds[1:] <= 0.0).tolist():
        near = _between(branch, place, rotor.omega)
        if abs(near["period"] - period) > WORTH_CLOSING * period:
            continue
        if abs(near["radius_max"] - radius) > WORTH_CLOSING * radius:
            continue
        state = np.array([near[name] for name in COMPONENTS])
        try:
            cycle = close_orbit(DiscFlow(rotor), state, near["period"])
        except SimulationError:
            continue
        apart = max(abs(cycle.duration / period - 1.0), abs(cycle.radius_max / radius - 1.0))
        if apart <= SAME_CYCLE:
            return True
    return False


def _between(branch: xr.Dataset, place: int, omega: float) -> dict[str, float]:
    """Return period, largest radius and state between two points of a branch."""
    low, high = branch["omega"].values[place : place + 2].tolist()
    part = (omega - low) / (high - low) if high != low else 0.0
    names = ("period", "radius_max", *COMPONENTS)
    ends = {name: branch[name].values[place : place + 2].tolist() for name in names}
    return {name: one + part * (other - one) for name, (one, other) in ends.items()}
