"""A rotor in SI units, and a check of eq. (9): ω₀² = k√D/m, not k/m.

A disc of 4 kg with an eccentricity of 10 micrometres runs at 3,000 rpm in a stator with 20
micrometres of clearance. The run is in micrometres, milliseconds and newtons. An independent
integration of the dimensional equation (7) (SciPy, DOP853) gives the same orbit when lengths are
scaled with the eccentricity D and times with sqrt(m/(k sqrt(D))). With the printed k/m the orbit
differs.

Writes the run (run.nc), the same in SI units (machine.nc), the check (scaling.nc), and the figures
as PNG and SVG.
"""

import math
import sys

import numpy as np
import xarray as xr

from rotor_ida import DimensionalRotor, contact_summary, dimensional, simulate
from rotor_ida.paper.errata import check_scaling, deviations
from rotor_ida.paper.scenario import Settings, run_script, scientific
from rotor_ida.plot import mixed_panels, plot_run, style

MACHINE = DimensionalRotor(
    mass=4.0,  # kg
    contact_stiffness=3.2e7,  # N/m^1.5
    damping=89.1,  # N s/m
    eccentricity=10e-6,  # m
    clearance=20e-6,  # m
    speed=3000.0 * 2.0 * math.pi / 60.0,  # rad/s
)


def main(settings: Settings) -> None:
    rotor = MACHINE.rotor()
    duration = 40.0 if settings.quick else 80.0
    start = (0.0, 0.0, 0.0, 0.0)
    run = simulate(rotor, start=start, duration=duration, samples=4001)
    machine = dimensional(run, MACHINE, units={"length": "µm", "time": "ms"})
    settings.keep(run, "run")
    settings.keep(machine, "machine")
    force = float(contact_summary(run).largest_force) * MACHINE.force_scale
    settings.show(
        plot_run(machine), "machine", archives=["machine", "run"],
        shows=f"A disc of {MACHINE.mass:g} kg from rest at 3,000 rpm: orbit, radius and contact "
        "force.",
        found=f"ω = {rotor.omega:.4g}, ζ = {rotor.zeta:.4g}, δ₀ = {rotor.delta0:.4g}: "
        f"{run.sizes['contact']} contacts in {1e3 * duration * MACHINE.time_scale:.0f} ms; the "
        f"force reaches {force:.2f} N and the radius "
        f"{1e6 * float(np.hypot(machine.x, machine.y).max()):.1f} µm.",
    )  # fmt: skip

    checked = check_scaling(MACHINE, duration=20.0)
    settings.keep(checked, "scaling")
    draw_check(checked, settings)


def draw_check(checked: xr.Dataset, settings: Settings) -> None:
    figure, (ax,) = mixed_panels(1, 1, height=2.8)
    with style():
        ms = 1e3 * checked.t
        ax.plot(ms, 1e6 * checked.X, color="#1a1a1a", lw=2.2, label="eq. (7), by SciPy")
        for name, formula, colour, line in (
            ("k sqrt(D)/m", r"k\sqrt{D}/m", "#e76300", "--"), ("k/m", "k/m", "#3f90da", ":")
        ):  # fmt: skip
            ax.plot(ms, 1e6 * checked.scaled_X.sel(frequency=name), color=colour, ls=line,
                    label=f"scaled with $\\omega_0^2 = {formula}$")  # fmt: skip
        ax.set(xlabel="time $T$ [ms]", ylabel="displacement $X$ [µm]", xlim=(0.0, float(ms[-1])))
        ax.legend(loc="upper center", bbox_to_anchor=(0.5, 1.14), ncols=3)
    apart = deviations(checked)
    settings.show(
        figure, "scaling", archives=["scaling"],
        shows="Eq. (7) in SI units beside dimensionless runs, scaled with the correct and with the "
        "printed reference frequency.",
        paper="ω₀² = k/m, above eq. (8).",
        verdict="Wrong: k√D/m.",
        found=f"With k√D/m the runs differ by {scientific(apart['k sqrt(D)/m'])} of the "
        f"largest displacement, with k/m by {apart['k/m']:.2g} of it; k/m is not a squared "
        "frequency, because k is in N/(m√m).",
    )  # fmt: skip


if __name__ == "__main__":
    sys.exit(run_script(main, description=__doc__, script=__file__))
