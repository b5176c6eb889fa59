"""Compute an archived result again, from its own attributes, and hold it against the archive."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import xarray as xr

from rotor_ida.analysis.verified_cycles import (
    NEEDED_OF_CYCLES,
    cycles_again,
    differences_of_cycles,
)
from rotor_ida.atlas import continue_attractors
from rotor_ida.basins import basin, basin_fractions
from rotor_ida.checks import COMPONENTS
from rotor_ida.errors import InputError
from rotor_ida.parallel import Progress
from rotor_ida.parameters import PARAMETERS, Rotor
from rotor_ida.schema import RESPONSE
from rotor_ida.simulation.options import Method
from rotor_ida.simulation.simulate import simulate
from rotor_ida.steady_state.response import BOUNCING, CONTACT_FREE, FULL_CONTACT, SYNCHRONOUS
from rotor_ida.sweeps.sweep import DIRECTIONS, sweep
from rotor_ida.testing import assert_events_close

STARTS = tuple(f"start_{name}" for name in COMPONENTS)
RANGES = tuple(f"range_{name}" for name in COMPONENTS)
HOW = ("rtol", "atol", "method", "flight")
# What tells one response from another.
NUMBERS = ("amplitude", "phase_lag", "radius_min", "radius_max")
# Of which motions the numbers are those of the motion, not of one stretch of it.
OF_MOTION = {
    **dict.fromkeys(("amplitude", "phase_lag"), (CONTACT_FREE, SYNCHRONOUS)),
    **dict.fromkeys(
        ("radius_min", "radius_max", "period"),
        (CONTACT_FREE, SYNCHRONOUS, BOUNCING, FULL_CONTACT),
    ),
}
# Variables by which a kind of result is known, and attributes that it takes to compute it again.
NEEDED = {
    "run": (("event_time", "event_time_error", "t"), (*PARAMETERS, "start", "duration", *HOW)),
    "sweep": (("event_count", "response", "direction", *STARTS, *PARAMETERS, *NUMBERS), HOW),
    "basin": (
        ("label", "settling_time", "kind", *COMPONENTS, *NUMBERS),
        (*PARAMETERS, "labelling_rtol"),
    ),
    "basin_fractions": (
        ("response_fraction", "count", "kind", *NUMBERS),
        (*PARAMETERS, "labelling_rtol", "starts", "seed", *RANGES),
    ),
    "atlas": (
        ("missed_fraction", "count", "kind", *PARAMETERS, *NUMBERS),
        ("labelling_rtol", "starts"),
    ),
    **NEEDED_OF_CYCLES,
}
# How far these numbers may be off on another machine.
CLOSE = 1e-6


def rerun(
    dataset: xr.Dataset,
    *,
    method: Method | None = None,
    workers: int | None = None,
    progress: Progress | None = None,
) -> xr.Dataset:
    """Compute a result again, as its own attributes say, or by another method.

    Parameters
    ----------
    dataset : Dataset
        A result of `simulate`, `sweep`, `basin`, `basin_fractions`, `continue_attractors`,
        `limit_cycle`, `continue_cycle` or `bifurcation_curve`, for instance one that was loaded
        from an archive.
    method : {"adams", "bdf", "ida", "taylor"}, optional
        Another solver of the contacts of a run or sweep: a witness that shares no step with the
        first.
    workers, progress
        As for the function that computed it; a single run or cycle needs neither.

    Returns
    -------
    Dataset
        The same result, made anew; an atlas without its shocks.

    Raises
    ------
    InputError
        If the dataset is no such result, or its attributes cannot be used.

    Examples
    --------
    >>> from rotor_ida import Rotor, simulate
    >>> from rotor_ida.testing import assert_events_close
    >>> rotor = Rotor(omega=2.0, zeta=0.07, delta0=2.0)
    >>> run = simulate(rotor, start=(0, 0, 0, 0), duration=20.0)
    >>> assert_events_close(rerun(run, method="taylor"), run)
    """
    kind = _kind_of(dataset)
    if method is not None:
        dataset = _by(dataset, kind, method)
    if "time_scale" in dataset.attrs:
        raise InputError("a result in SI units cannot be verified: verify the dimensionless one")
    if kind == "run":
        return _run(dataset)
    if kind in NEEDED_OF_CYCLES:
        return cycles_again(dataset, kind, progress)
    again: dict[str, Callable[..., xr.Dataset]] = {
        "sweep": _sweep,
        "basin": _basin,
        "basin_fractions": _basin_fractions,
        "atlas": _atlas,
    }
    return again[kind](dataset, workers=workers, progress=progress)


def differences(again: xr.Dataset, archived: xr.Dataset) -> dict[str, object]:
    """Hold a result made again against that of the archive.

    Parameters
    ----------
    again, archived : Dataset
        The two results, of the same kind.

    Returns
    -------
    dict
        ``agrees``, and ``trouble``: the first difference in words. Of runs the numbers of events,
        the largest difference of two event times and the largest error stated for one [1]; of the
        others the number of points, starts or numbers of limit cycles that were compared, of those
        that differ, and the largest difference of two amplitudes, radii, periods or such numbers,
        relative to the larger one. And ``core``: whether the compiled core is the same; another
        gives other last bits.

    Examples
    --------
    >>> from rotor_ida import Rotor, simulate
    >>> run = simulate(Rotor(omega=2.0, zeta=0.07, delta0=2.0), start=(0, 0, 0, 0), duration=20.0)
    >>> differences(rerun(run), run)["agrees"]
    True
    """
    kind = _kind_of(archived)
    if kind in NEEDED_OF_CYCLES:
        found = differences_of_cycles(again, archived, kind)
    elif kind == "run":
        found = _of_events(again, archived)
    else:
        found = _of_responses(again, archived, kind)
    return found | {"core": _core_of(again, archived)}


def _core_of(again: xr.Dataset, archived: xr.Dataset) -> str:
    """Return in words whether the core that computed both is the same, of which bits depend."""
    same = again.attrs.get("core_sources") == archived.attrs.get("core_sources")
    return "the same" if same else "another than that of the archive"


def _kind_of(dataset: xr.Dataset) -> str:
    for kind, (variables, attributes) in NEEDED.items():
        if set(variables) <= set(dataset.variables):
            missing = [name for name in attributes if name not in dataset.attrs]
            if missing:
                raise InputError(f"this {kind} cannot be verified: it lacks {', '.join(missing)}")
            words = [name for name in variables if dataset[name].dtype.kind not in "iuf"]
            if words:
                raise InputError(f"{words[0]} must be numbers, got {dataset[words[0]].dtype}")
            return kind
    raise InputError(
        "only what simulate, sweep, basin, basin_fractions, continue_attractors, limit_cycle, "
        "continue_cycle and bifurcation_curve have computed can be verified, got a dataset of "
        f"{', '.join(map(str, dataset.data_vars)) or 'nothing'}"
    )


def _by(dataset: xr.Dataset, kind: str, method: Method) -> xr.Dataset:
    """Return a result that says that it was computed by another method."""
    if kind not in ("run", "sweep"):
        raise InputError(f"method must be left out for a {kind}, got {method!r}")
    how: dict[str, object] = {"method": method}
    if method == "taylor":
        how["flight"] = "exact"
    return dataset.assign_attrs(how)


def _run(dataset: xr.Dataset) -> xr.Dataset:
    given = dataset.attrs
    return simulate(
        _rotor(dataset),
        start=given["start"],
        duration=given["duration"],
        samples=dataset["t"].values,
        **{name: given[name] for name in HOW},
    )


def _sweep(dataset: xr.Dataset, workers: int | None, progress: Progress | None) -> xr.Dataset:
    turns = tuple(dataset["direction"].values.tolist())
    direction = next((word for word, each in DIRECTIONS.items() if each == turns), "unknown")
    starts = zip(*(dataset[f"start_{name}"].values.tolist() for name in COMPONENTS), strict=True)
    given: dict[str, Any] = {name: dataset[name].values for name in PARAMETERS}
    given |= {name: dataset.attrs[name] for name in HOW}
    given |= {"starts": list(starts), "direction": direction}
    return sweep(**given, workers=workers, progress=progress)


def _basin(dataset: xr.Dataset, workers: int | None, progress: Progress | None) -> xr.Dataset:
    starts: dict[str, Any] = {name: dataset[name].values[()] for name in COMPONENTS}
    starts["rtol"] = dataset.attrs["labelling_rtol"]
    return basin(_rotor(dataset), **starts, workers=workers, progress=progress)


def _basin_fractions(
    dataset: xr.Dataset, workers: int | None, progress: Progress | None
) -> xr.Dataset:
    return basin_fractions(_rotor(dataset), **_drawn(dataset), workers=workers, progress=progress)


def _atlas(dataset: xr.Dataset, workers: int | None, progress: Progress | None) -> xr.Dataset:
    given = dataset.attrs
    asked: dict[str, Any] = {name: dataset[name].values for name in PARAMETERS}
    if "seed" in given:
        asked |= _drawn(dataset)
    else:
        asked |= {"starts": np.reshape(given["starts"], (-1, 4)), "rtol": given["labelling_rtol"]}
    return continue_attractors(**asked, workers=workers, progress=progress)


def _drawn(dataset: xr.Dataset) -> dict[str, Any]:
    """Return how random starts were drawn and followed."""
    given = dataset.attrs
    ranges = {name: tuple(np.atleast_1d(given[f"range_{name}"]).tolist()) for name in COMPONENTS}
    how = {"starts": given["starts"], "seed": given["seed"], "rtol": given["labelling_rtol"]}
    return ranges | how


def _rotor(dataset: xr.Dataset) -> Rotor:
    return Rotor(**{name: dataset.attrs[name] for name in PARAMETERS})


def _of_events(again: xr.Dataset, archived: xr.Dataset) -> dict[str, object]:
    trouble = ""
    try:
        assert_events_close(again, archived)
    except AssertionError as difference:
        trouble = "; ".join(str(difference).splitlines()[1:])
    common = min(again.sizes["event"], archived.sizes["event"])
    apart = again["event_time"].values[:common] - archived["event_time"].values[:common]
    stated = archived["event_time_error"].values[:common]
    return {
        "agrees": not trouble,
        "events": int(again.sizes["event"]),
        "archived_events": int(archived.sizes["event"]),
        "largest_difference": float(np.abs(apart).max(initial=0.0)),
        "largest_stated_error": float(stated.max(initial=0.0)),
        "trouble": trouble,
    }


def _of_responses(again: xr.Dataset, archived: xr.Dataset, kind: str) -> dict[str, object]:
    """Compare the kinds of response point by point, or start by start, and their numbers."""
    name = {"sweep": "response", "basin": "label", "basin_fractions": "count", "atlas": "count"}[
        kind
    ]
    trouble, differing, apart = "", 0, 0.0
    archived = archived.drop_dims("target", errors="ignore")  # shocks are not sought again
    if dict(again.sizes) != dict(archived.sizes):
        sizes = {dim: size for dim, size in again.sizes.items() if archived.sizes.get(dim) != size}
        trouble = f"made again, it has {sizes}, archived {dict(archived.sizes)}"
    else:
        differs = again[name].values != archived[name].values
        differing = int(differs.sum())
        apart = max(_apart(again, archived, each) for each in OF_MOTION if each in archived)
        if differing:
            place = dict(zip(again[name].dims, np.argwhere(differs)[0].tolist(), strict=True))
            one, other = again[name].isel(place).item(), archived[name].isel(place).item()
            trouble = f"{differing} of {differs.size} differ in {name}; the first: "
            trouble += f"{place}, made again {one}, archived {other}"
        elif not apart <= CLOSE:
            trouble = f"amplitudes, radii or periods differ by {apart:.3g} of their size"
    return {
        "agrees": not trouble,
        "compared": int(archived[name].size),
        "differing": differing,
        "largest_difference": apart,
        "trouble": trouble,
    }


def _apart(again: xr.Dataset, archived: xr.Dataset, name: str) -> float:
    """Return the largest difference of a number of the motions, relative to the larger value.

    Numbers of one stretch of a motion are passed over: another machine may see another stretch.
    What is not told by either counts as equal.
    """
    one, other = again[name].values, archived[name].values
    kinds = archived["kind" if "kind" in archived else "response"].values
    told = np.isin(kinds, [RESPONSE[kind] for kind in OF_MOTION[name]])
    same = (one == other) | (np.isnan(one) & np.isnan(other)) | ~told
    scale = np.maximum(np.abs(one), np.abs(other))
    part = np.divide(np.abs(one - other), scale, out=np.zeros_like(scale), where=~same)
    return float(np.nan_to_num(part, nan=np.inf).max(initial=0.0))
