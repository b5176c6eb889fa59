"""Convergence of event times with the tolerance.

Free planar vibration with clearance (omega = zeta = 0) has exact event times. The script compares
the simulated ones with them for Adams, BDF and IDA, with flight in closed form, over tolerances
from 1e-6 to 1e-12. The error falls in proportion to the tolerance: the integration loses no order
where contact begins and ends.

Writes event_time_convergence.nc, and the figure as PNG and SVG.
"""

import math
import sys

import numpy as np
import xarray as xr
from scipy.special import beta

from rotor_ida import Rotor, simulate
from rotor_ida.paper.scenario import Settings, run_script
from rotor_ida.plot import panels, style

AMPLITUDE, CLEARANCE = 2.0, 1.0
METHODS = {
    "adams": ("Adams", "o", "-", "#3f90da"),
    "bdf": ("BDF", "s", "--", "#e76300"),
    "ida": ("IDA", "^", "-.", "#832db6"),
}


def main(settings: Settings) -> None:
    duration = 20.0 if settings.quick else 200.0
    tolerances = 10.0 ** np.arange(-6, -13, -2 if settings.quick else -1)
    exact = exact_event_times(duration)
    rotor = Rotor(omega=0.0, zeta=0.0, delta0=CLEARANCE)
    errors = np.empty((len(METHODS), tolerances.size))
    stated = np.empty_like(errors)
    for row, method in enumerate(METHODS):
        for column, rtol in enumerate(tolerances):
            run = simulate(
                rotor, start=(AMPLITUDE, 0, 0, 0), duration=duration, samples=2,
                rtol=rtol, atol=rtol / 100, method=method,
            )  # fmt: skip
            errors[row, column] = np.abs(run.event_time.values - exact).max()
            stated[row, column] = run.event_time_error.values.max()
    result = xr.Dataset(
        {
            "largest_error": (("solver", "rtol"), errors, described("largest true error")),
            "largest_stated_error": (("solver", "rtol"), stated, described("largest stated error")),
        },
        {"rtol": ("rtol", tolerances, described("relative tolerance")), "solver": list(METHODS)},
        {"title": "Convergence of event times", "duration": duration, "events": exact.size},
    )
    settings.keep(result, "event_time_convergence")
    with style():
        figure, (ax,) = panels(1, 1, height=3.4)
        draw(result, ax)
    decades = np.log10(result.rtol[0] / result.rtol[-1]).item()
    fall = np.log10(result.largest_error[:, 0] / result.largest_error[:, -1]).values
    ratio = float((result.largest_stated_error / result.largest_error).min())
    fallen = ", ".join(
        f"{each:.1f} ({words})" for each, (words, *_) in zip(fall, METHODS.values(), strict=True)
    )
    settings.show(
        figure, "event_time_convergence", archives=["event_time_convergence"],
        shows="The largest error of an event time over the tolerance, for three methods.",
        found=f"Over {decades:.0f} decades of tolerance the error falls by {fallen} decades, with "
        "no floor where contact begins and ends. The largest error estimate of a run is "
        f"{ratio:.1f} times the true one or more.",
    )  # fmt: skip


def exact_event_times(duration: float) -> np.ndarray:
    """Return the exact events of planar vibration from rest at AMPLITUDE."""
    depth = AMPLITUDE - CLEARANCE
    leaving = beta(0.4, 0.5) / math.sqrt(5.0) * depth**-0.25
    crossing = 2.0 * CLEARANCE / (math.sqrt(0.8) * depth**1.25)
    period = crossing + 2.0 * leaving
    entries = leaving + crossing + period * np.arange(duration / period + 1)
    times = np.sort(np.concatenate([entries - crossing, entries]))
    return times[times <= duration]


def described(long_name: str) -> dict[str, str]:
    return {"long_name": long_name, "units": "1"}


def draw(result: xr.Dataset, ax) -> None:
    for method, (words, marker, line, colour) in METHODS.items():
        part = result.sel(solver=method)
        ax.loglog(
            part.rtol, part.largest_error, line, marker=marker, ms=4.2, color=colour,
            label=f"{words}, true error",
        )  # fmt: skip
        ax.loglog(
            part.rtol, part.largest_stated_error, ":", marker=marker, ms=3.4, mfc="white",
            color=colour, lw=0.9, label=f"{words}, as stated",
        )  # fmt: skip
    ax.loglog(result.rtol, 100.0 * result.rtol, color="0.6", lw=0.8, label="100 × tolerance")
    ax.invert_xaxis()
    ax.set_xlabel("relative tolerance")
    ax.set_ylabel("largest error of an event time")
    ax.set_title(f"{result.attrs['events']} events of planar vibration, $\\delta_0 = 1$")
    ax.legend(loc="center left", bbox_to_anchor=(1.02, 0.5))


if __name__ == "__main__":
    sys.exit(run_script(main, description=__doc__, script=__file__))
