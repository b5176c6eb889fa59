"""What the rotor does where no response curve can show it.

At zeta = 0.07 most starts end bouncing on the ring at omega = 2, delta0 = 2, and in contact for
ever with an oscillating radius at omega = 3, delta0 = 0.5. Both are limit cycles on the axes that
turn with the unbalance: closed curves there, a section on a curve, lines beside the spin speed and
backward ones in the spectrum, and a largest Lyapunov exponent of zero. With little damping, at
omega = 1.5, zeta = 0.01, delta0 = 1.4, the rotor bounces chaotically: the largest exponent is
positive. That may be a transient, but a long one: it lasts tens of thousands of units of time.

Writes for each case the run, its section, spectrum, forces and Lyapunov exponents (netCDF), and one
figure of all as PNG and SVG.
"""

import math
import sys

import numpy as np

from rotor_ida import (
    Rotor,
    contact_forces,
    lyapunov_exponent,
    poincare_section,
    rotating,
    simulate,
    spectrum,
)
from rotor_ida.paper.scenario import Settings, run_script
from rotor_ida.plot import (
    panels,
    plot_exponents,
    plot_force_peaks,
    plot_forces,
    plot_history,
    plot_orbit,
    plot_rotating_orbit,
    plot_section,
    plot_spectrum,
    shared_legend,
    with_error,
)

CASES = {
    "bouncing": Rotor(omega=2.0, zeta=0.07, delta0=2.0),
    "full_contact": Rotor(omega=3.0, zeta=0.07, delta0=0.5),
    "chaotic": Rotor(omega=1.5, zeta=0.01, delta0=1.4),
}
WORDS = {
    "bouncing": "A rotor that bounces for ever",
    "full_contact": "A rotor that stays in contact at a radius that is not constant",
    "chaotic": "A rotor with little damping that bounces chaotically",
}
REST = (0.0, 0.0, 0.0, 0.0)
NAMES = ("x", "y", "vx", "vy")
SAMPLES = 64  # a revolution
SHOWN = 12  # revolutions of the orbit and of the force


def main(settings: Settings) -> None:
    skip, revolutions = (120, 100) if settings.quick else (300, 600)
    duration = 1000.0 if settings.quick else 20000.0
    for name, rotor in CASES.items():
        start = settled(rotor, skip)
        long = run_on(rotor, start, revolutions)
        results = {
            "run": rotating(run_on(rotor, start, SHOWN)),
            "section": poincare_section(rotor, start=start, revolutions=revolutions),
            "spectrum": spectrum(long.isel(t=slice(None, -1))),
            "forces": contact_forces(long),
            "exponents": lyapunov_exponent(rotor, start=start, duration=duration),
        }
        at = "entry" if long.sizes["contact"] > 1 else "peak"
        results[at] = poincare_section(rotor, start=start, revolutions=revolutions, at=at)
        for part, result in results.items():
            settings.keep(result, f"{name}_{part}")
        found = results["exponents"]
        shown = ", ".join(
            with_error(value, error)
            for value, error in zip(
                found.lyapunov_exponent.values, found.lyapunov_error.values, strict=True
            )
        ).replace("-", "−")
        print(f"{name}: Lyapunov exponents {shown}")
        largest, error = found.lyapunov_exponent[0].item(), found.lyapunov_error[0].item()
        meaning = (
            "the largest is positive, the motion chaotic, perhaps as a long transient"
            if largest > 5.0 * error + 1e-3
            else "the largest is zero, the motion a limit cycle on the rotating axes"
        )
        settings.show(
            draw(results, results[at]), name, archives=[f"{name}_{part}" for part in results],
            shows=f"{WORDS[name]}: orbit in both frames, sections once a revolution and at each "
            f"{'entry' if at == 'entry' else 'largest radius'}, spectrum with forward and backward "
            "whirl, Lyapunov exponents, contact forces.",
            paper="",
            found=f"Lyapunov exponents {shown}, with the standard error of the last digits in "
            f"brackets: {meaning}. Minus their sum is {-found.exponent_sum.item():.5f}, "
            "and must be 4ζ.",
        )  # fmt: skip


def settled(rotor: Rotor, revolutions: int) -> tuple[float, ...]:
    """Return the state after a transient of whole revolutions, from rest."""
    duration = 2.0 * math.pi * revolutions / rotor.omega
    run = simulate(rotor, start=REST, duration=duration, samples=2)
    return tuple(float(run[name][-1]) for name in NAMES)


def run_on(rotor: Rotor, start: tuple[float, ...], revolutions: int):
    """Return a run over whole revolutions."""
    times = 2.0 * math.pi / rotor.omega * np.arange(revolutions * SAMPLES + 1) / SAMPLES
    return simulate(rotor, start=start, duration=times[-1], samples=times)


def draw(results, events):
    """Return the figure of one case."""
    figure, axes = panels(4, 2, width=7.2, height=10.6, shared=False)
    plot_orbit(results["run"], ax=axes[0])
    plot_rotating_orbit(results["run"], ax=axes[1])
    shared_legend(figure, axes[:2], columns=6, outer=False)
    plot_section(results["section"], ax=axes[2])
    plot_section(events, ax=axes[3])
    plot_spectrum(results["spectrum"], ax=axes[4])
    plot_exponents(results["exponents"], ax=axes[5])
    plot_forces(results["forces"].isel(t=slice(0, SHOWN * SAMPLES)), ax=axes[6])
    if results["forces"].sizes["contact"] > 1:
        plot_force_peaks(results["forces"], ax=axes[7])
    else:
        plot_history(results["run"], "radius", ax=axes[7])
        axes[7].set_ylim(bottom=0.0)
    return figure


if __name__ == "__main__":
    sys.exit(run_script(main, description=__doc__, script=__file__))
