"""A machine in SI units, and the check of eq. (9): omega_0^2 = k sqrt(D)/m, not k/m.

A disc of 4 kg with an eccentricity of 10 micrometres turns at 3,000 rpm in a ring with 20
micrometres of clearance. The run gives micrometres, milliseconds and newtons. The dimensional
equation (7), integrated on its own by another program (SciPy, DOP853), lands on the same orbit when
lengths are scaled with the eccentricity D and times with sqrt(m/(k sqrt(D))); with the printed k/m
it is another orbit.

Writes the run in SI units (machine.nc), the check (scaling.nc), and the figures as PNG and SVG.
"""

import math
import sys

import numpy as np
import xarray as xr
from scipy.integrate import solve_ivp

from rotor_ida import DimensionalRotor, Rotor, contact_summary, dimensional, simulate
from rotor_ida.plot import mixed_panels, plot_machine, style
from rotor_ida.printed import reference_frequency
from rotor_ida.scenario import Settings, run_script
from rotor_ida.schema import labelled

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
    machine = dimensional(run, MACHINE)
    settings.keep(machine, "machine")
    force = float(contact_summary(run).largest_force) * MACHINE.force_scale
    settings.show(
        plot_machine(machine), "machine", archives=["machine"],
        shows=f"A disc of {MACHINE.mass:g} kg from rest at 3,000 rpm: orbit, radius and contact "
        "force.",
        found=f"omega = {rotor.omega:.4g}, zeta = {rotor.zeta:.4g}, delta0 = {rotor.delta0:.4g}: "
        f"{run.sizes['contact']} contacts in {1e3 * duration * MACHINE.time_scale:.0f} ms; the "
        f"ring bears up to {force:.2f} N, the disc comes out to "
        f"{1e6 * float(np.hypot(machine.x, machine.y).max()):.1f} micrometres.",
    )  # fmt: skip

    checked = check_scaling(20.0)
    settings.keep(checked, "scaling")
    draw_check(checked, settings)


def check_scaling(duration: float) -> xr.Dataset:
    """Hold the dimensional equation against dimensionless runs with the two reference speeds."""
    machine = MACHINE
    frequencies = {"k sqrt(D)/m": machine.reference_frequency, "k/m": reference_frequency(machine)}
    end = duration * machine.time_scale
    times = np.linspace(0.0, end, 401)
    start = (2.5e-5, 0.0, 0.0, 0.0)
    orbit = dimensional_orbit(start, times)
    table = []
    for frequency in frequencies.values():
        rotor = Rotor(
            omega=machine.speed / frequency,
            zeta=machine.damping / (2.0 * machine.mass * frequency),
            delta0=machine.clearance / machine.eccentricity,
        )
        scaled = times * frequency
        samples = np.append(scaled[:-1], scaled[-1])
        run = simulate(
            rotor, start=(start[0] / machine.eccentricity, 0.0, 0.0, 0.0),
            duration=float(scaled[-1]), samples=samples, rtol=1e-13, atol=1e-15,
        )  # fmt: skip
        table.append((run.x + 1j * run.y).values * machine.eccentricity)
    seconds = {**labelled("time", (), 0.0).attrs, "units": "s", "long_name": "time"}
    metres = {"units": "m"}
    dims = ("frequency", "time")
    return xr.Dataset(
        {
            "X": ("time", orbit.real, {**metres, "long_name": "displacement by eq. (7)"}),
            "Y": ("time", orbit.imag, {**metres, "long_name": "displacement by eq. (7)"}),
            "scaled_X": (dims, np.real(table), {**metres, "long_name": "scaled displacement"}),
            "scaled_Y": (dims, np.imag(table), {**metres, "long_name": "scaled displacement"}),
        },
        {"time": ("time", times, seconds), "frequency": list(frequencies)},
        {"title": "The dimensional equation beside dimensionless runs, scaled by two rules"},
    )


def dimensional_orbit(start, times) -> np.ndarray:
    """Return Z(T) of eq. (7) by SciPy, knowing nothing of scales."""
    m, k, n = MACHINE.mass, MACHINE.contact_stiffness, MACHINE.damping
    D, d, W = MACHINE.eccentricity, MACHINE.clearance, MACHINE.speed

    def rate(time, state):
        X, Y, VX, VY = state
        R = math.hypot(X, Y)
        stiffness = k * max(R - d, 0.0) ** 1.5 / max(R, d)
        unbalance = m * D * W * W
        return [
            VX,
            VY,
            (unbalance * math.cos(W * time) - n * VX - stiffness * X) / m,
            (unbalance * math.sin(W * time) - n * VY - stiffness * Y) / m,
        ]

    solved = solve_ivp(
        rate, (0.0, times[-1]), start, "DOP853", times, rtol=3e-14, atol=1e-19,
        max_step=times[-1] / 400,
    )  # fmt: skip
    return solved.y[0] + 1j * solved.y[1]


def deviations(checked: xr.Dataset) -> dict[str, float]:
    """Return the largest distance of each scaled run from eq. (7), in eccentricities."""
    distance = np.hypot(checked.scaled_X - checked.X, checked.scaled_Y - checked.Y)
    return {
        str(name): float(distance.sel(frequency=name).max()) / MACHINE.eccentricity
        for name in checked.frequency.values
    }


def draw_check(checked: xr.Dataset, settings: Settings) -> None:
    figure, (ax,) = mixed_panels(1, 1, height=2.8)
    with style():
        ms = 1e3 * checked.time
        ax.plot(ms, 1e6 * checked.X, color="#1a1a1a", lw=2.2, label="eq. (7), by SciPy")
        for name, colour, line in (("k sqrt(D)/m", "#e76300", "--"), ("k/m", "#3f90da", ":")):
            ax.plot(ms, 1e6 * checked.scaled_X.sel(frequency=name), color=colour, ls=line,
                    label=f"scaled with $\\omega_0^2$ = {name}")  # fmt: skip
        ax.set(xlabel="time $T$ [ms]", ylabel="displacement $X$ [µm]")
        ax.legend(loc="upper center", bbox_to_anchor=(0.5, 1.14), ncols=3)
    apart = deviations(checked)
    settings.show(
        figure, "scaling", archives=["scaling"],
        shows="Eq. (7) in SI units beside dimensionless runs, scaled with the right and with the "
        "printed reference frequency.",
        paper="omega_0^2 = k/m, above eq. (8).",
        found=f"With k sqrt(D)/m the runs differ by {apart['k sqrt(D)/m']:.0e} eccentricities, "
        f"with k/m by {apart['k/m']:.2g}; k/m is no frequency squared, since k is in N/m^1.5.",
    )  # fmt: skip


if __name__ == "__main__":
    sys.exit(run_script(main, description=__doc__, script=__file__))
