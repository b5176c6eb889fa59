"""A piece of a run-up or run-down: the motion while the speed changes, and the folds on its way."""

from __future__ import annotations

import math
from collections.abc import Iterator
from functools import lru_cache

import numpy as np

from rotor_ida.closed_forms.folds import folds
from rotor_ida.closed_forms.synchronous import synchronous_response
from rotor_ida.errors import InputError
from rotor_ida.explorer.answers import Answer
from rotor_ida.explorer.motion import facts_of, states_of, values_of
from rotor_ida.explorer.questions import Question
from rotor_ida.explorer.responses import MOST_KEPT, at_rest, of_whirls
from rotor_ida.explorer.tracking import keep_tail, tail_of, tracked
from rotor_ida.model.equations import rotated
from rotor_ida.model.parameters import Rotor
from rotor_ida.schema import STABILITY
from rotor_ida.signals.forces import power_in_contact
from rotor_ida.simulation.options import Method
from rotor_ida.simulation.run_up import run_up

# As of the run that is drawn.
RTOL = 1e-10
METHOD: Method = "taylor"
# So many samples a revolution, or in a time of 2 pi where that is shorter.
SAMPLES, MOST_SAMPLES = 48, 4096
# The whirls of a fold are counted so far, as a part of its speed, on either side of it.
BESIDE = 1e-4
# At a fold from which it is no further to the next whirl, as a part of the radius, nobody sees a
# jump: such are those close to the first touch.
LEAST_JUMP = 0.2


def show_run_up(question: Question) -> Iterator[Answer]:
    """Yield the radius on one piece of a ramp, and the state from which the next one goes on.

    That state is turned back by the angle of the unbalance, as each piece begins with the unbalance
    along x.
    """
    rotor, to, rate = question.rotor, question.to, question.rate
    assert to is not None
    assert rate is not None
    duration = (to - rotor.omega) / rate
    turns = max(0.5 * (rotor.omega + to), 1.0) * duration / (2.0 * math.pi)
    drawn = np.linspace(0.0, duration, min(max(math.ceil(SAMPLES * turns), 2), MOST_SAMPLES) + 1)
    record = tail_of(question)
    sampled = record.times_until(duration)
    times = np.union1d(drawn, sampled)
    run = values_of(
        run_up(
            rotor, start=question.start, to=to, rate=rate, samples=times,
            rtol=RTOL, atol=RTOL, method=METHOD,
        )
    )  # fmt: skip
    angle = run["angle"]
    end = rotated(states_of(run, "")[-1:], -angle[-1:])[0]
    seen = np.searchsorted(times, sampled)
    z = run["x"][seen] + 1j * run["y"][seen]
    record, signals = tracked(
        record, duration, float(run["speed"][-1]), float(angle[-1]), angle[seen], z
    )
    keep_tail(question, tuple(end.tolist()), record)
    normal = power_in_contact(run, rotor).normal_force
    force = max(float(normal.max()), float(run["peak_force"].max(initial=0.0)))
    facts: dict[str, object] = {
        **facts_of(question),
        "end": end.tolist(),
        "speed": float(run["speed"][-1]),
        "largest_force": force,
        "folds": list(_folds_of(at_rest(rotor))),
    }
    here = np.searchsorted(times, drawn)
    arrays = {
        "speed": run["speed"][here], "angle": angle[here],
        "radius": np.hypot(run["x"], run["y"])[here], **signals,
    }  # fmt: skip
    yield Answer("run_up", facts, arrays)


@lru_cache(maxsize=MOST_KEPT)
def _folds_of(rotor: Rotor) -> tuple[dict[str, float], ...]:
    """Return where a whirl ends on the way up (1) or down (-1): speed, radius, and what is left.

    That is, of the whirls that are left there, the one with the nearest radius.
    """
    if rotor.load > 0.0:
        return ()
    try:
        table = folds(**of_whirls(rotor))
    except InputError:
        return ()
    found = []
    omegas, amplitudes = (table[f"fold_{name}"].values.ravel() for name in ("omega", "amplitude"))
    for omega, amplitude in zip(omegas.tolist(), amplitudes.tolist(), strict=True):
        if math.isnan(omega):
            continue
        (many_below, below), (many_above, above) = (
            _whirls_at(rotor, omega * (1.0 + sign * BESIDE)) for sign in (-1.0, 1.0)
        )
        left = above if many_below > many_above else below
        if many_below == many_above or not left:
            continue
        other = min(left, key=lambda each: abs(each - amplitude))
        if abs(amplitude - other) > LEAST_JUMP * amplitude:
            found.append({
                "omega": omega, "radius": amplitude, "other": other,
                "way": 1.0 if many_below > many_above else -1.0,
            })  # fmt: skip
    return tuple(found)


def _whirls_at(rotor: Rotor, omega: float) -> tuple[int, list[float]]:
    """Return how many whirls there are at a speed, and the radii of those that are not unstable."""
    found = synchronous_response(omega=omega, **of_whirls(rotor))
    radii, stability = found["amplitude"].values.ravel(), found["stability"].values.ravel()
    held = np.isfinite(radii) & (stability != STABILITY["unstable"])
    return int(np.isfinite(radii).sum()), radii[held].tolist()
