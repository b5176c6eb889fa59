"""Compare simulated responses with exact ones: synchronous whirls and limit cycles.

The simulated numbers come from the sweep alone. A whirl is compared with the closed forms, a
periodic motion with the limit cycle that Newton's method finds from its end.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from contextlib import closing
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt
import xarray as xr

from rotor_ida.arrays import Stop, Values
from rotor_ida.checks import COMPONENTS, check_instance, check_progress
from rotor_ida.closed_forms import rest, synchronous_response
from rotor_ida.closed_forms.contact_free import static_sag
from rotor_ida.cycles.multipliers import is_stable
from rotor_ida.cycles.orbit import Orbit
from rotor_ida.cycles.shooting import close_orbit
from rotor_ida.errors import InputError, SimulationError
from rotor_ida.model.parameters import ALL_PARAMETERS, PARAMETERS
from rotor_ida.model.rotor import Rotor
from rotor_ida.parallel import Progress, Workers, choose, run_all, shows_progress
from rotor_ida.results.in_si import keeps_si
from rotor_ida.schema import (
    EXACT,
    RESPONSE,
    STABILITY,
    check_as_computed,
    labelled,
    labelled_dataset,
    origin_of,
    spread,
)
from rotor_ida.simulation.flow import DiscFlow

NEEDED = ("response", "amplitude", "phase_lag")
# A settled whirl lies on a branch when it is this near, as a part of its amplitude: far above
# any simulation's error, far below the distance between branches.
ON_BRANCH = 1e-5
# Variables of a periodic motion, and of the state from which Newton's method begins.
OF_CYCLES = ("period", "radius_min", "radius_max")
ENDS = tuple(f"end_{name}" for name in COMPONENTS)
UNDER_LOAD = (
    "under a load no whirl in contact is synchronous; rest, the contact-free whirl of a rotor with "
    "a shaft and limit cycles are exact"
)
# Decimal digits of a double.
ALL_DIGITS = 16.0


@keeps_si
@shows_progress
def compare(
    dataset: xr.Dataset,
    *,
    workers: int | None = None,
    progress: Progress | bool | None = None,
) -> xr.Dataset:
    """Compare each simulated response of a sweep with the exact one.

    Parameters
    ----------
    dataset : Dataset
        A sweep: ``response``, ``amplitude`` and ``phase_lag`` on ``omega``, ``zeta`` and
        ``delta0`` and any other dimensions, such as parameters of the rotor; for limit cycles also
        ``period``, ``radius_min``, ``radius_max`` and the final states.
    workers : int, optional
        Number of limit cycles sought at a time; default: one for each core.
    progress : callable or bool, optional
        Called with the number of limit cycles done and their total; True shows a bar on standard
        error.

    Returns
    -------
    Dataset
        On the dimensions of the sweep: ``response``, the kind of each point; ``lies_on`` (nothing,
        a whirl or a cycle); ``digits``, the number of decimal digits to which simulated and exact
        numbers agree, NaN where there is no exact response. For whirls: ``matched_branch`` (-1 if
        none), ``amplitude_error`` [dimensionless] and ``phase_error`` [rad]; with ``branch`` added
        ``branch_amplitude_error`` and ``branch_phase_error``; on ``branch`` and the parameters
        that are dimensions ``exact_amplitude``, ``exact_phase_lag``, ``stability`` and
        ``in_contact``, and under a load ``exact_offset``. For limit cycles: the simulated
        ``period``, ``radius_min``, ``radius_max`` and final state, and ``exact_period``,
        ``exact_radius_min``, ``exact_radius_max`` [dimensionless] and ``cycle_stability``.

    Raises
    ------
    InputError
        If the dataset is not a sweep.

    Notes
    -----
    Only a contact-free response, or one in contact at constant radius, can lie on a branch. It
    does if the complex amplitudes ``A exp(-i theta)`` differ by less than 1e-5 of the exact
    amplitude; ``digits`` is minus the decimal logarithm of that difference. A periodic response is
    compared with the limit cycle that Newton's method finds from its end by Taylor series. It lies
    on the cycle if period and extremes of the radius differ by less than 1e-5 of the exact ones;
    ``digits`` is that of the largest of the three differences.

    Under a load there is no synchronous whirl in contact, as the attribute ``comment`` states. Two
    exact responses remain. One is the contact-free whirl of a rotor with a shaft,
    ``z = -i gamma/kappa + A_f exp(i (omega t - theta))``, if it fits into the clearance,
    ``gamma/kappa + A_f <= delta0``; the load shifts only its centre. The other is the rest of a
    rotor that does not rotate, which counts as a whirl at ``z = -i A`` that lags by a quarter turn.
    A motion that is periodic after whole revolutions is compared with its limit cycle.

    With friction the synchronous whirls, on which the disc slides forwards whatever its radius,
    are exact too, and dry whip with unbalance is compared with its limit cycle. Rest on the stator
    under a load has no exact counterpart, as friction may hold the disc at many places.

    Examples
    --------
    >>> from rotor_ida import sweep
    >>> compared = compare(sweep(omega=1.7, zeta=0.5, delta0=0.5))
    >>> compared.matched_branch.item(), bool(abs(compared.amplitude_error.item()) < 1e-8)
    (0, True)
    """
    _check_is_sweep(dataset)
    progress = check_progress(progress)
    chosen = choose("threads", workers, compiled=True)
    dims = dataset["response"].dims
    exact = _exact_whirls(dataset)
    dataset = _with_rest(dataset)
    nearest, distance = _nearest_whirl(dataset, exact)
    matched = distance < ON_BRANCH
    errors = _errors_on_branches(dataset, exact)
    columns = {"matched_branch": nearest.where(matched, -1).astype(np.int8)}
    columns |= {name: each.isel(branch=nearest).where(matched) for name, each in errors.items()}
    variables = {
        name: labelled(name, dims, column.transpose(*dims).values)
        for name, column in columns.items()
    }
    cycles = _cycles_beside(dataset, chosen, progress)
    on_whirl = matched.transpose(*dims).values
    off = np.where(on_whirl, distance.transpose(*dims).values, cycles.pop("distance"))
    on = np.where(on_whirl, EXACT["whirl"], np.where(off < ON_BRANCH, EXACT["cycle"], 0))
    variables["lies_on"] = labelled("lies_on", dims, on.astype(np.int8))
    digits = np.where(on == EXACT["nothing"], np.nan, -np.log10(np.maximum(off, 10.0**-ALL_DIGITS)))
    variables["digits"] = labelled("digits", dims, digits)
    variables |= {name: labelled(name, dims, column) for name, column in cycles.items()}
    with_branch = (*dims, "branch")
    for name, error in errors.items():
        values = error.transpose(*with_branch).values
        variables[f"branch_{name}"] = labelled(f"branch_{name}", with_branch, values)
    variables |= _exact_variables(exact)
    given = [name for name in (*NEEDED, *OF_CYCLES, *ENDS) if name in dataset]
    variables |= {name: dataset[name].variable for name in given}
    coordinates = {
        str(name): each.variable
        for name, each in {**dataset["response"].coords, "branch": exact["branch"]}.items()
    }
    title = "Simulated responses and the exact ones"
    comment = {"comment": UNDER_LOAD} if "exact_offset" in exact else {}
    attributes = origin_of(dataset) | comment
    return labelled_dataset(title, variables, coordinates, attributes, kind="comparison")


def _with_rest(dataset: xr.Dataset) -> xr.Dataset:
    """Return responses with the place of rest under a load, at speed 0, as amplitude and phase."""
    if "load" not in dataset.variables or "radius_max" not in dataset.variables:
        return dataset
    turns = (dataset["omega"] > 0.0) | (dataset["load"] == 0.0)
    dims = dataset["amplitude"].dims
    return dataset.assign(
        amplitude=dataset["amplitude"].where(turns, dataset["radius_max"]).transpose(*dims),
        phase_lag=dataset["phase_lag"].where(turns, 0.5 * np.pi).transpose(*dims),
    )


def _nearest_whirl(dataset: xr.Dataset, exact: xr.Dataset) -> tuple[xr.DataArray, xr.DataArray]:
    """Return the number of the nearest branch on which a response may lie, and its distance."""
    difference = _relative_distance(dataset["amplitude"], dataset["phase_lag"], exact)
    allowed = exact["in_contact"] == (dataset["response"] == RESPONSE["synchronous"])
    could_lie = dataset["response"].isin([RESPONSE["synchronous"], RESPONSE["contact_free"]])
    candidates = difference.where(allowed & could_lie)
    nearest = candidates.fillna(np.inf).reduce(np.argmin, "branch")
    return nearest, candidates.isel(branch=nearest).drop_vars("branch")


def _errors_on_branches(dataset: xr.Dataset, exact: xr.Dataset) -> dict[str, xr.DataArray]:
    """Return the errors of amplitude and phase, were a response on each of the branches."""
    amplitude, lag = dataset["amplitude"], dataset["phase_lag"]
    # from -pi to pi
    phase_error = (lag - exact["phase_lag"] + np.pi) % (2.0 * np.pi) - np.pi
    return {
        "amplitude_error": (amplitude - exact["amplitude"]) / exact["amplitude"],
        "phase_error": phase_error,
    }


def summarise(compared: xr.Dataset) -> list[dict[str, object]]:
    """Count, for each clearance, the responses that lie on an exact one, and their digits.

    Parameters
    ----------
    compared : Dataset
        A result of `compare`.

    Returns
    -------
    list of dict
        One row for each ``delta0``: the numbers of points, of those on a whirl and of those on a
        limit cycle; the smallest and the median number of digits of these; the number of every
        other kind.

    Examples
    --------
    >>> from rotor_ida import sweep
    >>> row, = summarise(compare(sweep(omega=1.7, zeta=0.5, delta0=0.5)))
    >>> row["points"], row["on_whirl"], row["on_cycle"], row["bouncing"]
    (1, 1, 0, 0)
    """
    rows = []
    for delta0 in compared["delta0"].values:
        part = compared.sel(delta0=delta0)
        on = part["lies_on"].values
        digits = part["digits"].values[on != EXACT["nothing"]]
        other = part["response"].values[on == EXACT["nothing"]]
        row: dict[str, object] = {
            "delta0": float(delta0),
            "points": int(on.size),
            "on_whirl": int((on == EXACT["whirl"]).sum()),
            "on_cycle": int((on == EXACT["cycle"]).sum()),
            "fewest_digits": float(digits.min()) if digits.size else float("nan"),
            "median_digits": float(np.median(digits)) if digits.size else float("nan"),
        }
        row |= {kind: int((other == flag).sum()) for kind, flag in RESPONSE.items()}
        rows.append(row)
    return rows


def _check_is_sweep(dataset: xr.Dataset) -> None:
    check_instance("dataset", dataset, xr.Dataset)
    check_as_computed("dataset", dataset)
    missing = [name for name in (*NEEDED, *PARAMETERS) if name not in dataset.variables]
    if missing:
        names = ", ".join(missing)
        raise InputError(f"compare needs a sweep over omega, zeta and delta0; it lacks {names}")
    single = [name for name in PARAMETERS if name not in dataset.dims]
    if single:
        raise InputError(
            f"compare needs a sweep over omega, zeta and delta0 as dimensions, got {single[0]} as "
            f"a single value: select with a list, such as .sel({single[0]}=[...])"
        )


def _exact_whirls(dataset: xr.Dataset) -> xr.Dataset:
    """Return the exact whirls of all rotors of a sweep."""
    given: dict[str, Any] = {
        name: dataset[name].values[()]
        for name in ALL_PARAMETERS
        if name in dataset.variables and name != "disc_radius"
    }
    exact = synchronous_response(**given)
    return _under_load(exact) if "load" in exact.variables else exact


def _under_load(exact: xr.Dataset) -> xr.Dataset:
    """Return exact whirls with the offset of their centres under a load, and the place of rest."""
    load, kappa = exact["load"], exact.get("shaft_stiffness", xr.zeros_like(exact["load"]))
    turns = (load == 0.0) | (exact["omega"] > 0.0)
    offset = xr.apply_ufunc(static_sag, *xr.broadcast(load, kappa))
    absent: dict[Any, float] = {"stability": STABILITY["absent"], "in_contact": 0}
    dims = exact["amplitude"].dims
    found = exact[["amplitude", "phase_lag", *absent]]
    columns = {name: found[name].where(turns, absent.get(name, np.nan)) for name in found.data_vars}
    columns["exact_offset"] = offset.where(columns["amplitude"].notnull())
    whirls = xr.Dataset({
        name: labelled(str(name), dims,
                       column.transpose(*dims).values.astype(found.get(name, offset).dtype))
        for name, column in columns.items()
    }, exact["amplitude"].coords)  # fmt: skip
    _rest_beside(whirls)
    return whirls


def _rest_beside(exact: xr.Dataset) -> None:
    """Add rest under a load to the whirls, as the first branch where the rotor does not rotate."""
    of_parameters = exact["amplitude"].isel(branch=0)
    given = spread(exact, ALL_PARAMETERS, of_parameters)
    for place in zip(*np.nonzero((given["omega"] == 0.0) & (given["load"] > 0.0)), strict=True):
        at = {name: float(values[place]) for name, values in given.items()}
        if at.pop("friction", 0.0) > 0.0:  # which holds it wherever it is
            continue
        rotor = Rotor(**at)
        if rotor.delta0 == 0.0 and rotor.contact_damping > 0.0:
            continue
        lying = rest(rotor)
        first = (*place, 0)
        exact["amplitude"].values[first] = -float(lying["y"])
        exact["phase_lag"].values[first] = 0.5 * np.pi
        exact["stability"].values[first] = int(lying["stability"])
        exact["in_contact"].values[first] = int(float(lying["indentation"]) > 0.0)
        exact["exact_offset"].values[first] = -float(lying["y"])


def _relative_distance(
    amplitude: xr.DataArray, lag: xr.DataArray, exact: xr.Dataset
) -> xr.DataArray:
    """Return the distance of complex amplitudes, relative to the exact one."""
    simulated = amplitude * np.exp(-1j * lag)
    expected = exact["amplitude"] * np.exp(-1j * exact["phase_lag"])
    distance = abs(simulated - expected)
    # A rotor at rest is exactly on its branch of amplitude 0.
    scale = exact["amplitude"].where(exact["amplitude"] != 0.0, 1.0)
    return distance / scale


def _cycles_beside(
    dataset: xr.Dataset, workers: Workers, progress: Progress | None
) -> dict[str, npt.NDArray[np.generic]]:
    """Return the exact limit cycles for the periodic responses, and the distances to them.

    Parameters
    ----------
    dataset : Dataset
        A sweep.
    workers, progress
        As for `compare`: workers that seek cycles, and a callable that is told the number done.

    Returns
    -------
    dict
        ``exact_period``, ``exact_radius_min`` and ``exact_radius_max``, NaN where there is none,
        ``cycle_stability``, and ``distance``: the largest difference from the simulated numbers,
        relative to the exact one, infinite where there is none.
    """
    response = dataset["response"]
    found = {f"exact_{name}": np.full(response.shape, np.nan) for name in OF_CYCLES}
    stability = np.full(response.shape, STABILITY["absent"], dtype=np.int8)
    distance = np.full(response.shape, np.inf)
    table: dict[str, npt.NDArray[np.generic]] = {**found, "cycle_stability": stability}
    table["distance"] = distance
    if any(name not in dataset for name in (*OF_CYCLES, *ENDS)):
        return table
    parameters = [name for name in ALL_PARAMETERS if name in dataset.variables]
    given = spread(dataset, (*OF_CYCLES, *ENDS, *parameters), response)
    places = list(zip(*np.nonzero(np.isfinite(given["period"])), strict=True))
    guesses = (
        _Guess(
            Rotor(**{name: float(given[name][place]) for name in parameters}),
            np.array([given[name][place] for name in ENDS]), float(given["period"][place]),
        )
        for place in places
    )  # fmt: skip
    for place, cycle in _cycles_near(guesses, places, workers, progress):
        stability[place] = STABILITY["stable" if is_stable(cycle) else "unstable"]
        exact = np.array([cycle.duration, cycle.radius_min, cycle.radius_max])
        simulated = np.array([given[name][place] for name in OF_CYCLES])
        # a rotor that passes near the centre has a tiny smallest radius
        sizes = np.array([cycle.duration, cycle.radius_max, cycle.radius_max])
        distance[place] = (np.abs(simulated - exact) / sizes).max()
        for name, value in zip(OF_CYCLES, exact.tolist(), strict=True):
            found[f"exact_{name}"][place] = value
    return table


class _Guess(NamedTuple):
    """A rotor with a state near a limit cycle, and the period."""

    rotor: Rotor
    state: Values
    period: float


def _cycles_near(
    guesses: Iterable[_Guess],
    places: Sequence[tuple[np.intp, ...]],
    workers: Workers,
    progress: Progress | None,
) -> Iterator[tuple[tuple[np.intp, ...], Orbit]]:
    """Yield the places of guesses, each with its limit cycle if Newton's method finds one."""
    ran = run_all(_cycle_near, guesses, workers=workers.number, executor=workers.executor)
    with closing(ran) as ended:
        for done, (number, cycle) in enumerate(ended, start=1):
            if progress is not None:
                progress(done, len(places))
            if isinstance(cycle, Orbit):
                yield places[number], cycle


def _cycle_near(guess: _Guess, stop: Stop) -> Orbit | None:
    try:
        return close_orbit(DiscFlow(guess.rotor, stop), guess.state, guess.period)
    except SimulationError:
        return None


def _exact_variables(exact: xr.Dataset) -> dict[str, xr.Variable]:
    dims = exact["amplitude"].dims
    variables = {
        "exact_amplitude": labelled("exact_amplitude", dims, exact["amplitude"].values),
        "exact_phase_lag": labelled("exact_phase_lag", dims, exact["phase_lag"].values),
        "stability": exact["stability"].variable,
        "in_contact": exact["in_contact"].variable,
    }
    if "exact_offset" in exact:
        variables["exact_offset"] = exact["exact_offset"].variable
    return variables
