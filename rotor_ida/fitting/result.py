"""The result of a fit as a dataset."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import numpy as np
import numpy.typing as npt
import xarray as xr

from rotor_ida.arrays import Values
from rotor_ida.fitting.arguments import AnyRotor
from rotor_ida.fitting.contact_times import matched
from rotor_ida.fitting.identifiability import (
    ANGLE,
    Identifiability,
    identify,
    left_in_words,
    widening,
)
from rotor_ida.fitting.motion import Motion
from rotor_ida.fitting.problem import APART, FitProblem
from rotor_ida.fitting.trials import Trial
from rotor_ida.model.rotor_system import RotorSystem
from rotor_ida.results.provenance import provenance
from rotor_ida.schema import Column

# How a search ends that has found a minimum.
CONVERGED = "converged"
# Values below this part of their size count as 0.
NEARLY_0 = 1e-6


def dataset_of(
    problem: FitProblem,
    machine: AnyRotor,
    solution: Values,
    search: str,
    level: float,
) -> xr.Dataset:
    """Return the solution as a dataset, with confidence intervals, and how its search ended."""
    _, slopes, motions = problem.at(solution)
    matching = problem.apart(Trial(solution, motions), matched_only=True)
    chi_square, freedom = float((matching**2).sum()), problem.freedom(solution)
    slopes = slopes / widening(chi_square, freedom)
    names = [each.name for each in problem.trials.unknown]
    told = identify(slopes, _scales(problem, solution), names)
    words = [*told.words, *_at_bounds(problem, solution)]
    if search != CONVERGED:
        told = _of_no_minimum(names)
        words = told.words
    variables: dict[str, Column] = {
        **_estimates(problem, solution, told, level),
        **_tracks(problem, Trial(solution, motions)),
        **_touches(problem, motions),
        "chi_square": ((), chi_square),
        "degrees_of_freedom": ((), freedom),
        "noise": ((), problem.noise / problem.trials.records[0].metre),
    }
    coordinates: dict[str, Column] = {
        "unknown": ("unknown", names),
        "unknown_too": ("unknown_too", names),
        **{name: variables.pop(name) for name in ("t", "speed", "record", "node", "order")},
    }
    if not isinstance(machine, RotorSystem):
        coordinates.pop("node")
    where = _worst_node(problem, motions) if widening(chi_square, freedom) > 1.0 else ""
    left = left_in_words(chi_square, freedom, stated=search == CONVERGED)
    attributes = provenance({"method": "taylor"}) | {
        "machine": type(machine).__name__,
        **{f"given_{name}": value for name, value in getattr(machine, "given", {}).items()},
        "search": search,
        "identifiability": "; ".join(words),
        "remainder": left + where,
        "confidence": level,
        "evaluations": problem.trials.evaluations,
    }
    if "compared" in variables:
        attributes["contact_times"] = _touches_in_words(variables)
    plain = replace(problem.trials.records[0].record, coordinates={}, attributes=attributes)
    return plain.dataset("Fit of a machine to signals", variables, coordinates, kind="fit")


def _of_no_minimum(names: list[str]) -> Identifiability:
    """Return that nothing is identified and no error known: errors hold only near a minimum."""
    words = (
        f"the search did not converge, so the signals do not yet determine {', '.join(names)}: "
        "start nearer, fit fewer unknowns or a shorter part, or search longer if a limit stopped it"
    )
    count = len(names)
    unknown = np.full((count, count), math.nan)
    return Identifiability(unknown, np.zeros(count, dtype=np.bool_), [words])


def _scales(problem: FitProblem, solution: Values) -> Values:
    """Return the scale of each unknown's error: its value, or its size where that is nearly 0."""
    return np.array([
        abs(value) if abs(value) > NEARLY_0 * each.size and each.name != ANGLE else each.size
        for each, value in zip(problem.trials.unknown, solution.tolist(), strict=False)
    ])  # fmt: skip


def _worst_node(problem: FitProblem, motions: list[Motion]) -> str:
    """Return in words at which of several nodes the residuals are largest."""
    squares: dict[str, list[float]] = {}
    for each, motion in zip(problem.trials.records, motions, strict=True):
        left = each.tracks.weighed(motion.z - each.z) / problem.noise
        for node, column in zip(each.nodes, left.T, strict=True):
            squares.setdefault(node, []).append(float((column**2).mean()))
    if len(squares) == 1:
        return ""
    worst = max(squares, key=lambda node: np.mean(squares[node]))
    mean = np.mean(squares[worst])
    return f"; most at node {worst!r}, where their mean square is {mean:.3g} of that of the noise"


def _at_bounds(problem: FitProblem, solution: Values) -> list[str]:
    """Return a sentence for each unknown at its lower bound."""
    return [
        f"{each.name} is at its smallest allowed value {each.least:g}: its interval is one-sided"
        for each, value in zip(problem.trials.unknown, solution.tolist(), strict=False)
        if math.isfinite(each.least)
        and value - each.least <= 1e-6 * max(abs(each.guess), abs(value))
    ]


def _estimates(
    problem: FitProblem, solution: Values, told: Identifiability, level: float
) -> dict[str, Column]:
    """Return the numbers of each unknown."""
    from scipy.stats import norm  # noqa: PLC0415 - takes long to import

    quantile = float(norm.ppf(0.5 + 0.5 * level))
    values = np.array([
        math.remainder(value, 2.0 * math.pi) if each.name == ANGLE else value
        for each, value in zip(problem.trials.unknown, solution.tolist(), strict=False)
    ])  # fmt: skip
    errors = np.sqrt(np.diag(told.covariance))
    least = np.array([each.least for each in problem.trials.unknown])
    return {
        "estimate": ("unknown", values),
        "standard_error": ("unknown", errors),
        "lower": ("unknown", np.maximum(values - quantile * errors, least)),
        "upper": ("unknown", values + quantile * errors),
        "first_guess": ("unknown", [each.guess for each in problem.trials.unknown]),
        "told": ("unknown", told.told.astype(np.int8)),
        "unit": ("unknown", [each.unit for each in problem.trials.unknown]),
        "covariance": (("unknown", "unknown_too"), told.covariance),
    }


def _tracks(problem: FitProblem, trial: Trial) -> dict[str, Column]:
    """Return measured and fitted tracks of all records and nodes, and their residuals."""
    found: dict[str, list[npt.NDArray[Any]]] = {}
    residuals = problem.tracks_apart(trial)
    records = problem.trials.records
    for number, (each, motion) in enumerate(zip(records, trial.motions, strict=True)):
        tracks = each.tracks
        errors = problem.noise * np.sqrt(np.einsum("wkk->wk", tracks.inverse).real)
        # the orders are symmetric about 0, and both lags are delays
        ahead = np.flatnonzero(tracks.orders >= 0.0)
        ways = ("forward", ahead, -1.0), ("backward", tracks.orders.size - 1 - ahead, 1.0)
        apart = np.moveaxis(-residuals[number], 2, 0)
        for node, measured, fitted, left in zip(
            each.nodes, each.z.T, motion.z.T, apart, strict=True
        ):
            parts: dict[str, npt.NDArray[Any]] = {
                "record": np.full(tracks.windows.times.size, number),
                "node": np.full(tracks.windows.times.size, node),
                "t": tracks.windows.times / each.second + each.begin,
                "speed": tracks.windows.speeds * each.second,
            }
            both = tracks.amplitudes(np.column_stack([measured, fitted]))
            for way, places, lag in ways:
                parts[f"{way}_amplitude_error"] = errors[:, places] / each.metre
                parts[f"{way}_residual_real"] = left[:, places].real
                parts[f"{way}_residual_imag"] = left[:, places].imag
                for words, whirl in (("", both[:, places, 0]), ("fitted_", both[:, places, 1])):
                    parts[f"{words}{way}_whirl_amplitude"] = np.abs(whirl) / each.metre
                    parts[f"{words}{way}_phase_lag"] = lag * np.angle(whirl)
            for name, values in parts.items():
                found.setdefault(name, []).append(values)
    columns: dict[str, Column] = {
        name: (("window", "order") if values[0].ndim > 1 else "window", np.concatenate(values))
        for name, values in found.items()
    }
    tracked = problem.trials.records[0].tracks.orders
    return columns | {"order": ("order", tracked[tracked >= 0.0])}


def _touches(problem: FitProblem, motions: list[Motion]) -> dict[str, Column]:
    """Return measured and fitted contact times; NaN where no computed contact matches."""
    parts: dict[str, list[npt.NDArray[Any]]] = {}
    for number, (each, motion) in enumerate(zip(problem.trials.records, motions, strict=True)):
        for kind, found in problem.touches(number, motion).items():
            whole = matched(found.times, motion, kind)
            times = np.where(whole.compared, found.times + whole.apart, np.nan)
            own: dict[str, npt.NDArray[Any]] = {
                "measured_time": found.times / each.second + each.begin,
                "fitted_time": times / each.second + each.begin,
                "event_kind": np.full(times.size, kind, np.int8),
                "touch_record": np.full(times.size, number),
                "compared": found.compared.astype(np.int8),
            }
            for name, values in own.items():
                parts.setdefault(name, []).append(values)
    if not parts:
        return {}
    columns: dict[str, Column] = {
        name: ("touch", np.concatenate(values)) for name, values in parts.items()
    }
    return columns | {"time_error": ((), problem.time_error / problem.trials.records[0].second)}


def _touches_in_words(variables: Mapping[str, Column]) -> str:
    """Return in words how many contact times are compared, and why others are not."""
    compared, fitted = (np.asarray(variables[name][1]) for name in ("compared", "fitted_time"))
    alone = int(np.isnan(fitted).sum())
    grazes = compared.size - alone - int(compared.sum())
    why = [f"{alone} have no computed contact near them"] if alone else []
    if grazes:
        why.append(
            f"{grazes} are within {APART:g} time errors of another event, at a graze or in chatter"
        )
    words = f"{int(compared.sum())} of {compared.size} are compared"
    return f"{words}; {'; '.join(why)}" if why else words
