"""Limit cycles and chaos that no response curve shows.

At zeta = 0.07 most starts end in bouncing at omega = 2, delta0 = 2, and in lasting contact at an
oscillating radius at omega = 3, delta0 = 0.5. On the axes that rotate with the unbalance, both are
limit cycles: closed orbits with sections on a curve, spectral lines beside the spin speed and
backward ones, and a largest Lyapunov exponent of zero. In a narrow range of speeds about
omega = 1.38, at delta0 = 1, the largest exponent is positive: the motion is chaotic, and it lasts.

Writes for each case the run, its section, spectrum, forces and Lyapunov exponents (netCDF), and one
figure of all as PNG and SVG.
"""

import math
import sys
from dataclasses import replace

import numpy as np

from rotor_ida import (
    Rotor,
    contact_forces,
    full_spectrum,
    lyapunov_exponent,
    poincare_section,
    rotating,
    simulate,
)
from rotor_ida.paper.scenario import Settings, run_script
from rotor_ida.plot import (
    panels,
    plot_exponents,
    plot_forces,
    plot_full_spectrum,
    plot_orbit,
    plot_section,
    plot_trace,
    shared_legend,
)
from rotor_ida.plot.appearance import draw_ring, drawing
from rotor_ida.plot.labels import LABELS, label_axis
from rotor_ida.plot.legends import legend_below
from rotor_ida.plot.motion import draw_motion
from rotor_ida.plot.palette import RED
from rotor_ida.signals.path import path_of
from rotor_ida.units import with_error

CASES = {
    "bouncing": Rotor(omega=2.0, zeta=0.07, delta0=2.0),
    "full_contact": Rotor(omega=3.0, zeta=0.07, delta0=0.5),
    "window": Rotor(omega=1.38, zeta=0.07, delta0=1.0),
}
WORDS = {
    "bouncing": "Bouncing",
    "full_contact": "Lasting contact at an oscillating radius",
    "window": "A narrow range of speeds with chaos",
}
REST = (0.0, 0.0, 0.0, 0.0)
STARTS = {"bouncing": REST, "full_contact": REST, "window": (1.5, -0.25, 0.0, 0.0)}
# A Lyapunov exponent further from zero than this many standard errors is not zero.
CLEAR = 5.0
NAMES = ("x", "y", "vx", "vy")
SAMPLES = 64  # a revolution
SHOWN = 12  # revolutions of the orbit and of the force


def main(settings: Settings) -> None:
    skip, revolutions = (120, 100) if settings.quick else (300, 600)
    duration = 4000.0 if settings.quick else 20000.0
    for name, rotor in CASES.items():
        start = settled(rotor, STARTS[name], skip)
        long = run_on(rotor, start, revolutions)
        results = {
            "run": rotating(run_on(rotor, start, SHOWN)),
            "section": poincare_section(rotor, start=start, revolutions=revolutions),
            "spectrum": full_spectrum(long.isel(t=slice(None, -1))),
            "forces": contact_forces(long),
            "exponents": lyapunov_exponent(rotor, start=start, duration=duration),
        }
        at = "entry" if long.sizes["contact"] > 1 else "peak"
        results[at] = poincare_section(rotor, start=start, revolutions=revolutions, at=at)
        for part, result in results.items():
            settings.keep(result, f"{name}_{part}")
        found = results["exponents"]
        shown = ", ".join(
            with_error(value, error, most=5)
            for value, error in zip(
                found.lyapunov_exponent.values, found.lyapunov_error.values, strict=True
            )
        ).replace("-", "−")
        print(f"{name}: Lyapunov exponents {shown}")
        settings.show(
            draw(results, results[at]), name, archives=[f"{name}_{part}" for part in results],
            shows=f"{WORDS[name]}: orbit in both frames, sections once a revolution and at each "
            f"{'entry' if at == 'entry' else 'largest radius'}, spectrum with forward and backward "
            "whirl, Lyapunov exponents, contact forces.",
            paper="",
            found=f"Lyapunov exponents {shown}, with the standard error of the last digits in "
            f"brackets: {meaning(found)}. Minus their sum is {-found.exponent_sum.item():.5f}, "
            "and must be 4ζ.",
        )  # fmt: skip


def meaning(found) -> str:
    """Interpret the Lyapunov exponents, given their errors."""
    clear = found.lyapunov_exponent.values / (CLEAR * found.lyapunov_error.values)
    if clear[0] > 1.0:
        return "the largest exceeds its error, so the motion is chaotic"
    if clear[0] > -1.0 and (clear[1:] < -1.0).all():
        return "one is zero and the others are negative, so the motion is a limit cycle on the axes"
    return "they do not decide the kind of motion"


def settled(rotor: Rotor, start: tuple[float, ...], revolutions: int) -> tuple[float, ...]:
    """Return the state after a transient of whole revolutions."""
    duration = 2.0 * math.pi * revolutions / rotor.omega
    run = simulate(rotor, start=start, duration=duration, samples=2)
    return tuple(float(run[name][-1]) for name in NAMES)


def run_on(rotor: Rotor, start: tuple[float, ...], revolutions: int):
    """Return a run over whole revolutions."""
    times = 2.0 * math.pi / rotor.omega * np.arange(revolutions * SAMPLES + 1) / SAMPLES
    return simulate(rotor, start=start, duration=times[-1], samples=times)


def draw(results, events):
    """Return the figure of one case."""
    figure, axes = panels(4, 2, width=7.2, height=10.6, shared=False)
    plot_orbit(results["run"], ax=axes[0])
    draw_rotating_orbit(results["run"], axes[1])
    shared_legend(figure, axes[:2], columns=6, outer=False)
    plot_section(results["section"], ax=axes[2])
    plot_section(events, ax=axes[3])
    plot_full_spectrum(results["spectrum"], ax=axes[4])
    plot_exponents(results["exponents"], ax=axes[5])
    plot_forces(results["forces"].isel(t=slice(0, SHOWN * SAMPLES)), ax=axes[6])
    if results["forces"].sizes["contact"] > 1:
        draw_force_peaks(results["forces"], axes[7])
    else:
        plot_trace(results["run"], names=("radius",), ax=axes[7])
        axes[7].set_ylim(bottom=0.0)
    return figure


def draw_rotating_orbit(run, ax):
    """Draw the orbit on axes that rotate with the unbalance: a synchronous whirl is a point."""
    path = path_of(run)
    z = (path.x + 1j * path.y) * np.exp(-1j * float(run.omega) * path.time)
    x, y = z.real, z.imag
    with drawing(ax):
        label_axis(ax.xaxis, "rotating_x", run.x)
        label_axis(ax.yaxis, "rotating_y", run.y)
        draw_ring(ax, float(run.delta0))
        draw_motion(ax, replace(path, x=x, y=y), x, y, width=0.7, heavier=1.2)
        ax.set_aspect("equal", adjustable="datalim")
        legend_below(ax)


def draw_force_peaks(forces, ax):
    """Draw the cumulative distribution of the peaks of whole contacts."""
    whole = forces.peak_force[np.isfinite(forces.peak_fraction.values)]
    with drawing(ax):
        label_axis(ax.xaxis, "peak_force", forces.peak_force)
        ax.ecdf(whole, color=RED)
        ax.set_xlim(0.0, 1.08 * float(whole.max()))
        ax.set_ylabel(LABELS["peak_fraction"])


if __name__ == "__main__":
    sys.exit(run_script(main, description=__doc__, script=__file__))
