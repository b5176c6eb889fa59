"""The full spectrum of a run, and the lines of the cycle that it settles on."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence

import numpy as np
import numpy.typing as npt

from rotor_ida.explorer.answers import Answer
from rotor_ida.explorer.motion import (
    FASTEST_LINE,
    METHOD,
    facts_of,
    run_of,
    states_of,
    values_of,
)
from rotor_ida.explorer.questions import Question
from rotor_ida.model.equations import rotated
from rotor_ida.model.parameters import Rotor
from rotor_ida.signals.spectra import full_spectrum
from rotor_ida.simulation.simulate import simulate

Arrays = dict[str, npt.NDArray[np.generic]]

# Samples of one period of a cycle, and how small its lines may be beside the largest.
SAMPLES = 512
LEAST = 1e-9


def show_lines(question: Question) -> Iterator[Answer]:
    """Yield the full spectrum of the last half of a run, over the spin speed."""
    omega = question.rotor.omega or 1.0
    run = run_of(question)
    seen = full_spectrum(run.isel(t=slice((run.sizes["t"] - 1) // 2, -1)))
    over = seen["frequency"].values / omega
    shown = np.abs(over) <= FASTEST_LINE
    facts = {**facts_of(question), "bandwidth_over_omega": float(seen["bandwidth"]) / omega}
    arrays: Arrays = {
        "line_over_omega": over[shown], "line_amplitude": seen["whirl_amplitude"].values[shown]
    }  # fmt: skip
    yield Answer("lines", facts, arrays)


def exact_lines(
    rotor: Rotor, lies_on: object, settled: dict[str, object], end: Sequence[float]
) -> Arrays:
    """Return order and amplitude of the lines of the whirl or cycle that is settled on.

    Of a cycle over one period, from a state on it; without any where it never repeats itself.
    """
    nothing: Arrays = {"exact_order": np.empty(0), "exact_amplitude": np.empty(0)}
    if lies_on == "whirl":
        height = float(str(settled["exact_amplitude"]))
        return {"exact_order": np.ones(1), "exact_amplitude": np.array([height])}
    if lies_on != "cycle" or rotor.omega == 0.0:
        return nothing
    period = float(str(settled["exact_period"]))
    times = np.linspace(0.0, period, SAMPLES, endpoint=False)
    run = values_of(simulate(rotor, start=end, duration=period, samples=times, method=METHOD))
    turned = rotated(states_of(run, ""), -rotor.omega * run["t"])
    heights = np.abs(np.fft.fft(turned[:, 0] + 1j * turned[:, 1])) / SAMPLES
    orders = 1.0 + np.fft.fftfreq(SAMPLES, 1.0 / SAMPLES) * 2.0 * math.pi / (period * rotor.omega)
    kept = (heights > LEAST * heights.max()) & (np.abs(orders) <= FASTEST_LINE)
    place = np.argsort(orders[kept])
    return {"exact_order": orders[kept][place], "exact_amplitude": heights[kept][place]}
