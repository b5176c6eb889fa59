"""How runs, sweeps, run-ups and basins of one disc are verified."""

from __future__ import annotations

import math
from functools import partial
from typing import Any

import numpy as np
import xarray as xr

from rotor_ida.basins import basin, basin_fractions
from rotor_ida.basins.atlas import continue_attractors
from rotor_ida.checks import COMPONENTS
from rotor_ida.model.parameters import ALL_PARAMETERS, PARAMETERS
from rotor_ida.parallel import Progress
from rotor_ida.schema import RESPONSE
from rotor_ida.signals.path import rotating
from rotor_ida.simulation.run_up import run_up
from rotor_ida.simulation.simulate import simulate
from rotor_ida.steady.bifurcation_diagram import bifurcation_diagram
from rotor_ida.steady.response import BOUNCING, CONTACT_FREE, FULL_CONTACT, SYNCHRONOUS
from rotor_ida.steady.run_ups import run_ups
from rotor_ida.steady.sweep import DIRECTIONS, sweep
from rotor_ida.testing import assert_events_close
from rotor_ida.verification.variables import OF_ONE_STRETCH, PERIODIC
from rotor_ida.verification.verify import (
    Verdict,
    Verification,
    counts_of,
    relative_differences,
    rotor_in,
)

HOW = ("rtol", "atol", "method", "flight")
# Attributes of the speed of a run-up.
CHANGES = ("to", "rate", "speeds", "torque", "inertia")
# Responses whose numbers belong to the motion, not to one stretch of it.
OF_MOTION = {
    **dict.fromkeys(("amplitude", "phase_lag"), (CONTACT_FREE, SYNCHRONOUS)),
    **dict.fromkeys(
        ("radius_min", "radius_max", "period"),
        (CONTACT_FREE, SYNCHRONOUS, BOUNCING, FULL_CONTACT),
    ),
}
# Relative difference of numbers allowed between machines; and how much more numbers of a contact
# may differ than its times do over its duration.
CLOSE, LATE = 1e-6, 100.0
TRANSIENT = "depends on the way to the steady state"
# What motions of one disc are computed from.
ROTOR = tuple(ALL_PARAMETERS)


def _run(dataset: xr.Dataset, _workers: int | None, _progress: Progress | None) -> xr.Dataset:
    given = dataset.attrs
    how = {name: given[name] for name in ("start", "duration", *HOW)}
    if "event_speed" in dataset:
        del how["flight"]
        changes = change_in(dataset)
        run = run_up(rotor_in(dataset), samples=dataset["t"].values, **how, **changes)
    else:
        run = simulate(rotor_in(dataset), samples=dataset["t"].values, **how)
    return rotating(run) if "rotating_x" in dataset else run


def change_in(dataset: xr.Dataset) -> dict[str, Any]:
    """Return the change of speed of a run-up, as arguments of it."""
    changes = {name: dataset.attrs[name] for name in CHANGES if name in dataset.attrs}
    if "speeds" in changes:
        changes["speeds"] = np.reshape(changes["speeds"], (-1, 2))
    return changes


def direction_of(dataset: xr.Dataset) -> Any:
    """Return the direction of a sweep, in the word by which it was asked for."""
    turns = tuple(dataset["direction"].values.tolist())
    return next((word for word, each in DIRECTIONS.items() if each == turns), "unknown")


def _sweep(dataset: xr.Dataset, workers: int | None, progress: Progress | None) -> xr.Dataset:
    starts = zip(*(dataset[f"start_{name}"].values.tolist() for name in COMPONENTS), strict=True)
    given: dict[str, Any] = axes_in(dataset)
    given |= {name: dataset.attrs[name] for name in HOW}
    given |= {"starts": list(starts), "direction": direction_of(dataset)}
    given["along"] = dataset.attrs.get("along")
    return sweep(**given, workers=workers, progress=progress)


def _diagram(dataset: xr.Dataset, workers: int | None, progress: Progress | None) -> xr.Dataset:
    starts = zip(*(dataset[f"start_{name}"].values.tolist() for name in COMPONENTS), strict=True)
    given: dict[str, Any] = axes_in(dataset)
    names = ("rtol", "atol", "method", "extrema_time", "rate")
    given |= {name: dataset.attrs[name] for name in names if name in dataset.attrs}
    if "direction" in dataset.dims:
        given |= {"direction": direction_of(dataset), "along": dataset.attrs.get("along")}
    return bifurcation_diagram(**given, starts=list(starts), workers=workers, progress=progress)


def _of_stretches(_again: xr.Dataset, archived: xr.Dataset) -> dict[str, str]:
    """Return why extrema are not compared where some are those of a motion without a period."""
    periodic = archived["response"].isin([RESPONSE[word] for word in PERIODIC]).all()
    names = ("extremum", "extremum_count", "extremum_row")
    return {} if periodic else dict.fromkeys(names, OF_ONE_STRETCH)


def _run_ups(dataset: xr.Dataset, workers: int | None, progress: Progress | None) -> xr.Dataset:
    starts = zip(*(dataset[f"start_{name}"].values.tolist() for name in COMPONENTS), strict=True)
    given: dict[str, Any] = axes_in(dataset)
    given |= {name: dataset[name].values[()] for name in ("to", "rate", "phase")}
    given |= {name: dataset.attrs[name] for name in ("rtol", "atol", "method")}
    return run_ups(**given, starts=list(starts), workers=workers, progress=progress)


def _basin(dataset: xr.Dataset, workers: int | None, progress: Progress | None) -> xr.Dataset:
    starts: dict[str, Any] = {name: dataset[name].values[()] for name in COMPONENTS}
    starts["rtol"] = dataset.attrs["labelling_rtol"]
    return basin(rotor_in(dataset), **starts, workers=workers, progress=progress)


def _fractions(dataset: xr.Dataset, workers: int | None, progress: Progress | None) -> xr.Dataset:
    return basin_fractions(rotor_in(dataset), **_drawn(dataset), workers=workers, progress=progress)


def _atlas(dataset: xr.Dataset, workers: int | None, progress: Progress | None) -> xr.Dataset:
    given = dataset.attrs
    asked: dict[str, Any] = axes_in(dataset)
    if "seed" in given:
        asked |= _drawn(dataset)
    else:
        asked |= {"starts": np.reshape(given["starts"], (-1, 4)), "rtol": given["labelling_rtol"]}
    return continue_attractors(**asked, workers=workers, progress=progress)


def axes_in(dataset: xr.Dataset) -> dict[str, Any]:
    """Return the parameters of many rotors, each a number or an axis, as given."""
    return {name: dataset[name].values[()] for name in ALL_PARAMETERS if name in dataset.variables}


def _drawn(dataset: xr.Dataset) -> dict[str, Any]:
    """Return how random starts were drawn and simulated."""
    given = dataset.attrs
    ranges = {name: tuple(np.atleast_1d(given[f"range_{name}"]).tolist()) for name in COMPONENTS}
    how = {"starts": given["starts"], "seed": given["seed"], "rtol": given["labelling_rtol"]}
    return ranges | how


def compare_events(again: xr.Dataset, archived: xr.Dataset) -> Verdict:
    """Compare the events of two runs."""
    trouble = ""
    try:
        assert_events_close(again, archived)
    except AssertionError as difference:
        trouble = "; ".join(str(difference).splitlines()[1:])
    common = min(again.sizes["event"], archived.sizes["event"])
    apart = again["event_time"].values[:common] - archived["event_time"].values[:common]
    stated = archived["event_time_error"].values[:common]
    return {
        "events": int(again.sizes["event"]),
        "archived_events": int(archived.sizes["event"]),
        "largest_difference": float(np.abs(apart).max(initial=0.0)),
        "largest_stated_error": float(stated.max(initial=0.0)),
    }, trouble


def compare_points(name: str, again: xr.Dataset, archived: xr.Dataset) -> Verdict:
    """Compare points, starts or attractors by one variable, and by their numbers."""
    trouble, differing, apart = "", 0, 0.0
    archived = archived.drop_dims("target", errors="ignore")  # shocks are not computed again
    if dict(again.sizes) != dict(archived.sizes):
        sizes = {dim: size for dim, size in again.sizes.items() if archived.sizes.get(dim) != size}
        trouble = f"computed again, it has {sizes}, archived {dict(archived.sizes)}"
    else:
        # earlier versions wrote labels the other way round
        archived = archived.transpose(*again[name].dims, ...)
        differs = again[name].values != archived[name].values
        differing = int(differs.sum())
        numbers = [each for each in OF_MOTION if each in archived]
        apart = max(_apart_in_motion(again, archived, each) for each in numbers)
        if differing:
            place = dict(zip(again[name].dims, np.argwhere(differs)[0].tolist(), strict=True))
            one, other = again[name].isel(place).item(), archived[name].isel(place).item()
            trouble = f"{differing} of {differs.size} differ in {name}; the first: "
            trouble += f"{place}, computed again {one}, archived {other}"
        elif not apart <= CLOSE:
            trouble = f"amplitudes, radii or periods differ by {apart:.3g} of their size"
    return counts_of(archived[name].size, differing, apart), trouble


def _apart_in_motion(again: xr.Dataset, archived: xr.Dataset, name: str) -> float:
    """Return the largest difference of a number of the motions, relative to the larger value.

    Numbers of one stretch of a motion are skipped: another machine may give another stretch.
    """
    kinds = archived["kind" if "kind" in archived else "response"].values
    told = np.isin(kinds, [RESPONSE[kind] for kind in OF_MOTION[name]])
    apart = relative_differences(again[name].values, archived[name].values)
    # numbers of each contact of a system have one dimension more
    told = told.reshape(*told.shape, *(1,) * (apart.ndim - told.ndim))
    return float(np.where(told, apart, 0.0).max(initial=0.0))


def tolerance_of_run(run: xr.Dataset) -> float:
    """Return the difference allowed for numbers of a run: its events are as late as is stated."""
    stated = float(run["event_time_error"].max()) if run["event_time_error"].size else 0.0
    lasting = run["contact_duration"].values if "contact_duration" in run else np.zeros(0)
    shortest = float(lasting[lasting > 0.0].min(initial=math.inf))
    return max(CLOSE, float(run.attrs["rtol"]) * 1e4, LATE * stated / shortest)


def _of_transients(_again: xr.Dataset, archived: xr.Dataset) -> dict[str, str]:
    """Return why numbers of the way to a steady state are not compared."""
    names = ("event", "event_count", "event_row", *(f"end_{name}" for name in COMPONENTS))
    return {name: TRANSIENT for name in names if name in (*archived.dims, *archived.variables)}


NUMBERS = ("amplitude", "phase_lag", "radius_min", "radius_max")
_STARTS = tuple(f"start_{name}" for name in COMPONENTS)
_RANGES = tuple(f"range_{name}" for name in COMPONENTS)
RUN = Verification(
    ("event_time", "event_time_error", "t"),
    (*PARAMETERS, "start", "duration", *HOW),
    _run,
    compare_events,
    (*ROTOR, "t"),
    tolerance=tolerance_of_run,
)
SWEEP = Verification(
    ("event_count", "response", "direction", *_STARTS, *PARAMETERS, *NUMBERS),
    HOW,
    _sweep,
    partial(compare_points, "response"),
    (*ROTOR, *_STARTS, "start", "direction"),
    _of_transients,
)
RUN_UPS = Verification(
    ("ending", "response", "rate", "phase", "to", *_STARTS, *PARAMETERS, *NUMBERS),
    ("rtol", "atol", "method"),
    _run_ups,
    partial(compare_points, "response"),
    (*ROTOR, *_STARTS, "start", "rate", "phase", "to"),
)
DIAGRAM = Verification(
    ("extremum_radius", "extremum_count", "response", *_STARTS, *PARAMETERS),
    ("rtol", "atol", "method", "extrema_time"),
    _diagram,
    lambda _, __: ({}, ""),
    (*ROTOR, *_STARTS, "start", "direction"),
    _of_stretches,
)
BASIN = Verification(
    ("label", "settling_time", "kind", *COMPONENTS, *NUMBERS),
    (*PARAMETERS, "labelling_rtol"),
    _basin,
    partial(compare_points, "label"),
    (*ROTOR, *COMPONENTS),
)
FRACTIONS = Verification(
    ("response_fraction", "count", "kind", *NUMBERS),
    (*PARAMETERS, "labelling_rtol", "starts", "seed", *_RANGES),
    _fractions,
    partial(compare_points, "count"),
    ROTOR,
)
ATLAS = Verification(
    ("missed_fraction", "count", "kind", *PARAMETERS, *NUMBERS),
    ("labelling_rtol", "starts"),
    _atlas,
    partial(compare_points, "count"),
    ROTOR,
    lambda _, __: {"target": "shocks are not computed again"},
)
