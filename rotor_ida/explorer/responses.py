"""Response curve, settled response, and the branch of limit cycles through it."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import replace
from functools import lru_cache
from typing import Any

import numpy as np
import xarray as xr

from rotor_ida.arrays import Arrays
from rotor_ida.closed_forms.backward_whirl import backward_whirl
from rotor_ida.closed_forms.contact_free import static_sag
from rotor_ida.closed_forms.folds import folds
from rotor_ida.closed_forms.hopf import hopf_points
from rotor_ida.closed_forms.response_curve import response_curve
from rotor_ida.cycles.branches import branches_through, holds_cycle
from rotor_ida.errors import InputError, RotorError
from rotor_ida.explorer.cases import METHOD, Node
from rotor_ida.explorer.endings import ending, forced
from rotor_ida.explorer.messages import Answer, Question
from rotor_ida.explorer.motion import exact_lines
from rotor_ida.explorer.whirls import FOLD, HOPF, NO_WHIRLS, show_whirls
from rotor_ida.explorer.words import (
    numbers_of_response,
    sheet_of,
    verdict_of,
    words_of_response,
    words_of_transient,
    words_of_whip,
)
from rotor_ida.model.parameters import PARAMETERS
from rotor_ida.model.rotor import Rotor
from rotor_ida.schema import EXACT, RESPONSE, STABILITY, by_number
from rotor_ida.simulation.sections import poincare_section
from rotor_ida.simulation.simulate import simulate
from rotor_ida.steady.sweep import sweep
from rotor_ida.verification.compare import compare

POINTS_OF_CURVE, POINTS_OF_WHIP = 40, 60
# Most points of a branch of limit cycles.
MOST_POINTS_OF_BRANCH = 2000
# Duration of the record of the settled response: whole periods, or this many revolutions.
REVOLUTIONS, SAMPLES = 32, 64
CROSSINGS, CROSSINGS_OF_CHAOS = 256, 4096
# A run has not settled if its radii differ by more than this fraction of the largest one, which
# counts as at least a small part of the eccentricity.
NEAR, SMALL = 0.05, 1e-3
# Number of rotors whose branches are cached.
MOST_KEPT = 64

# Severities beside "clear" and "rub", by the kind of the response.
LEVELS = {"failed": "unknown", "rolling": "whip"}
# A sweep of one point has one value of each.
ONE = (*PARAMETERS, "start", "direction")
KIND_OF = by_number(RESPONSE)
STABILITY_OF = by_number(STABILITY)


def show_responses(question: Question) -> Iterator[Answer]:
    """Yield the response curve; of one disc its settled response, section and branch, too."""
    if question.machine is None:
        yield from show_whirls(question)
        return
    rotor = question.rotor
    curve = _curve(question)
    yield curve
    for branch in branches_of(at_rest(rotor), question.speeds):
        yield _branch_answer(question, branch)
    if rotor.zeta == 0.0:
        return  # nothing settles
    swept = sweep(rotor, starts=[question.start], method=METHOD, executor="serial")
    compared = compare(swept).squeeze(ONE)
    settled = {**_seen(swept.squeeze(ONE)), **_exact(compared)}
    yield _settled(question, settled, swept)
    if rotor.friction > 0.0 and rotor.load == 0.0 and curve.arrays["omega"].size:
        yield _with_hopf_points(question, curve)
    if settled["response"] == "failed" or rotor.omega == 0.0:
        return
    yield _section(question, settled, swept)
    if settled["lies_on"] == "cycle":
        yield from _branch(question, settled, compared)


def _curve(question: Question) -> Answer:
    """Return the whirls over the speed with their special points, or the reason for none.

    The Hopf points of rubs take longer than the curve and follow later.
    """
    rotor = question.rotor
    facts = Node(question).facts
    try:
        why, arrays = _arrays_of_curve(at_rest(rotor), question.speeds)
    except InputError as error:
        return Answer("curve", {**facts, "why": f"No exact curve: {error}."}, NO_WHIRLS)
    return Answer("curve", facts | ({"why": f"{why[0].upper()}{why[1:]}."} if why else {}), arrays)


def at_rest(rotor: Rotor) -> Rotor:
    """Return the rotor at speed 0, which represents all its speeds."""
    return replace(rotor, omega=0.0)


@lru_cache(maxsize=MOST_KEPT)
def _arrays_of_curve(rotor: Rotor, speeds: tuple[float, float]) -> tuple[str, Arrays]:
    """Return the response curve with its folds and Hopf points, except those of rubs.

    Under a load its radius is the largest one, from the axis; with it, why it ends at the touch.
    """
    curve = response_curve(rotor, limits=speeds, points=POINTS_OF_CURVE)
    names = ("omega", "amplitude", "phase_lag", "stability", "in_contact", "piece")
    arrays = {name: curve[name].values[0, 0] for name in names}
    if rotor.load > 0.0:
        radius = arrays["amplitude"] + static_sag(rotor.load, rotor.shaft_stiffness)
        return str(curve.attrs["not_exact"]), NO_WHIRLS | arrays | {"amplitude": radius}
    arrays |= _marked(folds(rotor), FOLD, (0.0, math.inf))
    if rotor.friction > 0.0:
        nothing = dict.fromkeys(HOPF, np.empty(0))
        return "", arrays | nothing | _backward_whirls(rotor, speeds)
    return "", arrays | _marked(hopf_points(rotor), HOPF, speeds)


def _marked(found: xr.Dataset, marks: tuple[str, str], limits: tuple[float, float]) -> Arrays:
    """Return speed and amplitude of the special points of a curve."""
    omega, (low, high) = found[marks[0]].values[0, 0], limits
    are_there = np.isfinite(omega) & (low <= omega) & (omega <= high)
    return {name: found[name].values[0, 0][are_there] for name in marks}


def _with_hopf_points(question: Question, curve: Answer) -> Answer:
    """Return a curve of rubs with its Hopf points."""
    found = _hopf_points(at_rest(question.rotor), question.speeds)
    return replace(curve, arrays=curve.arrays | found)


@lru_cache(maxsize=MOST_KEPT)
def _hopf_points(rotor: Rotor, speeds: tuple[float, float]) -> Arrays:
    return _marked(hopf_points(rotor), HOPF, speeds)


def _backward_whirls(rotor: Rotor, speeds: tuple[float, float]) -> Arrays:
    """Return the friction-driven whirls over the speed: the slipping one and dry whip."""
    birth = float(backward_whirl(rotor)["birth_omega"])
    low, high = max(birth, speeds[0]), speeds[1]
    omega = np.linspace(low, high, POINTS_OF_WHIP) if low <= high else np.empty(0)
    found = [backward_whirl(replace(rotor, omega=each)).amplitude.values for each in omega.tolist()]
    slipping, rolling = np.reshape(found, (omega.size, 2)).T
    return {"whip_omega": omega, "saddle_radius": slipping, "whip_radius": rolling}


def _seen(swept: xr.Dataset) -> dict[str, object]:
    """Return the results of a sweep of one point as facts."""
    names = ("amplitude", "phase_lag", "radius_min", "radius_max", "period", "lyapunov_exponent")
    found: dict[str, object] = {name: float(swept[name]) for name in names if name in swept}
    found["response"] = KIND_OF[int(swept["response"])]
    found["message"] = str(swept["message"].item())
    return found


def _exact(compared: xr.Dataset) -> dict[str, object]:
    """Return the exact response beside the simulated one."""
    lies_on = int(compared["lies_on"])
    found: dict[str, object] = {
        "lies_on": next(word for word, number in EXACT.items() if number == lies_on),
        "digits": float(compared["digits"]),
    }
    if lies_on == EXACT["whirl"]:
        branch = compared.isel(branch=int(compared["matched_branch"]))
        found["exact_amplitude"] = float(branch["exact_amplitude"])
        found["stability"] = STABILITY_OF[int(branch["stability"])]
    elif lies_on == EXACT["cycle"]:
        for name in ("exact_period", "exact_radius_min", "exact_radius_max"):
            found[name] = float(compared[name])
        found["stability"] = STABILITY_OF[int(compared["cycle_stability"])]
    return found


def _settled(question: Question, settled: dict[str, object], swept: xr.Dataset) -> Answer:
    """Return the settled response and its contact forces, from a run that continues its end."""
    rotor = question.rotor
    facts = {**Node(question).facts, **settled}
    if settled["response"] != "failed":
        run = simulate(
            rotor, start=_end(swept), duration=2.0 * _watched(rotor, settled),
            samples=2 * REVOLUTIONS * SAMPLES + 1, method=METHOD,
        )  # fmt: skip
        facts |= ending(forced(run, rotor), rotor)
        facts |= {name: settled[name] for name in ("radius_min", "radius_max")}
        facts["end"] = _end(swept)
    words, sheets = [words_of_response(question.disc, facts)], list[dict[str, Any]]()
    if settled["response"] != "failed":
        told = numbers_of_response(rotor, facts)
        sheets = sheet_of("What it settles on", Node(question).scales, told)
    if rotor.friction > 0.0 and rotor.load == 0.0:
        words.append(words_of_whip(question.disc, *_whip(rotor)))
    if _is_repeated(settled) and _is_under_way(question, facts):
        drawn, by = Node(question).duration, float(swept["window_start"].item())
        words.append(words_of_transient(question.disc, rotor.omega, drawn, by))
    arrays = exact_lines(rotor, settled["lies_on"], settled, _end(swept))
    level = "rub" if facts.get("contact_fraction", 0.0) > 0.0 else "clear"
    level = LEVELS.get(str(facts["response"]), level)
    verdict = {"verdict": verdict_of(question.disc, facts), "level": level}
    return Answer("settled", {**facts, **verdict, "words": words, "sheets": sheets}, arrays)


def _whip(rotor: Rotor) -> tuple[float, float, float]:
    """Return the radii of the slipping whirl and of dry whip, and the speed at which they begin."""
    found = backward_whirl(rotor)
    slipping, rolling = found["amplitude"].values.tolist()
    return slipping, rolling, float(found["birth_omega"])


def _is_repeated(settled: Mapping[str, object]) -> bool:
    """Return whether the settled response repeats itself, so that a run can converge to it."""
    return settled["response"] not in {"failed", "quasi_periodic", "chaotic", "unresolved"}


def _is_under_way(question: Question, settled: Mapping[str, Any]) -> bool:
    """Return whether the drawn run ends before it reaches the settled response."""
    rotor = question.rotor
    shown = Node(question)
    drawn = ending(shown.seen(shown.run()), rotor)
    if (drawn["contact_fraction"] > 0.0) != (settled["contact_fraction"] > 0.0):
        return True
    near = NEAR * max(settled["radius_max"], SMALL)
    return any(abs(drawn[name] - settled[name]) > near for name in ("radius_min", "radius_max"))


def _watched(rotor: Rotor, settled: dict[str, object]) -> float:
    """Return the duration of the record: whole periods, and enough revolutions."""
    length, period = REVOLUTIONS * 2.0 * math.pi / (rotor.omega or 1.0), settled["period"]
    if isinstance(period, float) and period > 0.0:
        return math.ceil(length / period) * period
    return length


def _section(question: Question, settled: dict[str, object], swept: xr.Dataset) -> Answer:
    """Return the section of the settled response once a revolution."""
    chaotic = settled["response"] in {"quasi_periodic", "chaotic", "unresolved"}
    found = poincare_section(
        question.rotor,
        start=_end(swept),
        revolutions=CROSSINGS_OF_CHAOS if chaotic else CROSSINGS,
        method=METHOD,
    )
    arrays: Arrays = {
        "section_x": found["rotating_x"].values, "section_y": found["rotating_y"].values
    }  # fmt: skip
    return Answer("section", Node(question).facts, arrays)


def _end(swept: xr.Dataset) -> list[float]:
    """Return the state on the rotating axes at which a sweep of one point ended."""
    return [float(swept[f"end_{name}"].item()) for name in ("x", "y", "vx", "vy")]


@lru_cache(maxsize=MOST_KEPT)
def branches_of(_rotor: Rotor, _speeds: tuple[float, float]) -> list[xr.Dataset]:
    """Return the branches of limit cycles that are known of a rotor at rest; more are added."""
    return []


def _branch(
    question: Question, settled: dict[str, object], compared: xr.Dataset
) -> Iterator[Answer]:
    """Yield the branch of limit cycles through the settled response, if not cached."""
    known = branches_of(at_rest(question.rotor), question.speeds)
    period, radius = (float(str(settled[name])) for name in ("exact_period", "exact_radius_max"))
    if any(holds_cycle(branch, question.rotor, period, radius) for branch in known):
        return
    low, high = min(question.speeds[0], question.rotor.omega), question.speeds[1]
    limits = (max(low, 1e-3), max(high, question.rotor.omega))
    wanted = compared.expand_dims(("omega", "zeta", "delta0"))
    try:
        found = branches_through(wanted, limits=limits, points=MOST_POINTS_OF_BRANCH)
    except RotorError as error:
        yield Answer("note", {"message": f"The branch of limit cycles is not drawn: {error}"})
        return
    known += found
    for branch in found:
        yield _branch_answer(question, branch)


def _branch_answer(question: Question, branch: xr.Dataset) -> Answer:
    """Return a branch of limit cycles over the speed."""
    names = ("omega", "radius_min", "radius_max")
    arrays: Arrays = {name: branch[name].values for name in names}
    arrays["stability"] = branch["stability"].values.astype(np.int8)
    arrays["special_omega"] = branch["special_value"].values
    arrays["special_kind"] = branch["special_kind"].values.astype(np.int8)
    arrays["special_point"] = branch["special_point"].values.astype(np.float64)
    return Answer("branch", Node(question).facts, arrays)
