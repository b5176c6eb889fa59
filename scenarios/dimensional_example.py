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
from scipy.integrate import solve_ivp

from rotor_ida import DimensionalRotor, Rotor, contact_summary, dimensional, simulate
from rotor_ida.paper.printed import reference_frequency
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


def check_scaling(machine: DimensionalRotor, *, duration: float) -> xr.Dataset:
    """Integrate eq. (7) in SI units, from 2.5 eccentricities at rest, beside two scaled runs."""
    times = np.linspace(0.0, duration * machine.time_scale, 401)
    D = machine.eccentricity
    orbit = dimensional_orbit(machine, times)
    found = {"X": ("t", orbit[0]), "Y": ("t", orbit[1])}
    frequencies = {"k sqrt(D)/m": machine.reference_frequency, "k/m": reference_frequency(machine)}
    runs = []
    for frequency in frequencies.values():
        rotor = Rotor(
            omega=machine.speed / frequency, delta0=machine.clearance / D,
            zeta=machine.damping / (2.0 * machine.mass * frequency),
        )  # fmt: skip
        scaled = times * frequency
        runs.append(simulate(rotor, start=(2.5, 0.0, 0.0, 0.0), duration=scaled[-1], samples=scaled,
                             rtol=1e-13, atol=1e-15))  # fmt: skip
    for name in ("x", "y"):
        values = np.array([D * run[name].values for run in runs])
        found[f"scaled_{name.upper()}"] = (("frequency", "t"), values)
    axes = {"t": ("t", times, {"long_name": "time", "units": "s"}), "frequency": list(frequencies)}
    title = "Eq. (7) beside dimensionless runs, scaled by two rules"
    checked = xr.Dataset(found, axes, {"title": title})
    for name, variable in checked.data_vars.items():
        way = "of a scaled run" if "scaled" in str(name) else "by eq. (7)"
        variable.attrs = {"long_name": f"displacement {str(name)[-1]} {way}", "units": "m"}
    return checked


def dimensional_orbit(machine: DimensionalRotor, times: np.ndarray) -> np.ndarray:
    """Return X and Y of eq. (7) by SciPy, which knows of no scaling."""
    m, k, n = machine.mass, machine.contact_stiffness, machine.damping
    D, d, W = machine.eccentricity, machine.clearance, machine.speed

    def rate(T: float, state: np.ndarray) -> list[float]:
        X, Y, VX, VY = state
        R = math.hypot(X, Y)
        stiffness = k * (R - d) ** 1.5 / R if d < R else 0.0
        push = m * D * W * W
        return [VX, VY, (push * math.cos(W * T) - n * VX - stiffness * X) / m,
                (push * math.sin(W * T) - n * VY - stiffness * Y) / m]  # fmt: skip

    return solve_ivp(rate, (0.0, times[-1]), (2.5 * D, 0.0, 0.0, 0.0), "DOP853", times,
                     rtol=3e-14, atol=1e-14 * D, max_step=times[-1] / times.size).y[:2]  # fmt: skip


def deviations(checked: xr.Dataset) -> dict[str, float]:
    """Return the largest distance of each scaled run, over the largest displacement."""
    distance = np.hypot(checked.scaled_X - checked.X, checked.scaled_Y - checked.Y).max("t")
    largest = np.hypot(checked.X, checked.Y).max()
    return {str(name): float(distance.sel(frequency=name) / largest)
            for name in checked.frequency.values}  # fmt: skip


if __name__ == "__main__":
    sys.exit(run_script(main, description=__doc__, script=__file__))
