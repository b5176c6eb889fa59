"""Practitioners' plots of simulated and measured signals.

A machine runs up through its critical speed with contact. Bode and polar plot, order tracks,
cascade and spectrogram show the run-up in rpm, Hz and micrometres, over the exact response of the
rotor. A CSV file with noisy signals of two probes at 45 and 135 degrees gives the same Bode plot. A
bouncing rotor shows the orbit, the full spectrum and the lines of its exact cycle. A heavy rotor
shows the shaft centreline in the clearance.

Writes the runs (run_up.nc, bouncing.nc, heavy.nc), the measured file (probes.csv) and the figures
as PNG and SVG.
"""

import sys
from collections.abc import Sequence
from pathlib import Path

import numpy as np
import xarray as xr
from matplotlib.axes import Axes

from rotor_ida import (
    DimensionalRotor,
    Rotor,
    dimensional,
    folds,
    limit_cycle,
    orders,
    read_signals,
    run_up,
    simulate,
)
from rotor_ida.closed_forms import response_curve
from rotor_ida.paper.scenario import Settings, run_script
from rotor_ida.plot import (
    plot_bode,
    plot_cascade,
    plot_centre_line,
    plot_full_spectrum,
    plot_orbit,
    plot_orders,
    plot_polar,
    plot_spectrogram,
    plot_trace,
)

MACHINE = DimensionalRotor(
    mass=4.0,  # kg
    contact_stiffness=3.2e7,  # N/m^1.5
    damping=89.1,  # N s/m
    eccentricity=10e-6,  # m
    clearance=25e-6,  # m
    speed=31.416,  # rad/s, where the run-up begins
    shaft_stiffness=5e4,  # N/m
)
LAST = 4000  # rpm
RPM = 2.0 * np.pi / 60.0  # rad/s
UNITS = {"length": "µm", "speed": "rpm"}
NOISE = 0.2  # of a probe, in micrometres
SHARP = 10.0  # of the pulses of the keyphasor: a few samples wide at the highest speed
REST = (0.0, 0.0, 0.0, 0.0)
BOUNCING = Rotor(omega=2.0, zeta=0.07, delta0=2.0)
HEAVY = Rotor(omega=0.1, zeta=0.2, delta0=2.0, shaft_stiffness=0.3, load=0.45)


def main(settings: Settings) -> None:
    up = up_of_machine(rate=200.0 if settings.quick else 40.0)
    settings.keep(up, "run_up")
    curve, fold_points = exact_of_machine()
    draw_up(up, [curve, fold_points], settings)
    draw_measured(up, [curve, fold_points], settings)

    cycle = limit_cycle(BOUNCING, start=(2.6, 0.75, 0.66, -1.65), period=4.5)
    bouncing = simulate(BOUNCING, start=(2.6, 0.75, 0.66, -1.65), duration=400.0, samples=8001)
    settings.keep(bouncing, "bouncing")
    draw_bouncing(bouncing, cycle, settings)

    heavy = run_up(HEAVY, start=(0.0, -1.5, 0.0, 0.0), to=1.2, rate=0.002, samples=8001)
    settings.keep(heavy, "heavy")
    show(
        plot_centre_line(heavy, revolutions=4), "centre_line", settings, ["heavy"],
        "The mean position of a heavy rotor as its speed rises, in the circle of the clearance.",
        "At low speed it hangs 1.5 eccentricities below the axis. In a rub the stator lifts the "
        "mean position by a third of that and moves it sideways; above the rub it sinks back.",
    )  # fmt: skip


def up_of_machine(rate: float) -> xr.Dataset:
    """Return the run-up of the machine, at a rate in rpm/s, in SI units."""
    duration = (LAST - 300.0) / rate
    samples = round(1000.0 * duration) + 1
    run = run_up(MACHINE, to=LAST * RPM, rate=rate * RPM, samples=samples)
    return dimensional(run, units=UNITS)


def exact_of_machine() -> tuple[xr.Dataset, xr.Dataset]:
    """Return the exact response curve of the machine's rotor, without dimensions, and its folds."""
    rotor = MACHINE.rotor()
    given = {
        "zeta": rotor.zeta, "delta0": rotor.delta0, "shaft_stiffness": rotor.shaft_stiffness,
    }  # fmt: skip
    first = rotor.omega
    return response_curve(**given, limits=(first, first * LAST / 300.0)), folds(**given)


def draw_up(up: xr.Dataset, exact: Sequence[xr.Dataset], settings: Settings) -> None:
    """Draw the run-up over its speed."""
    show(
        plot_bode(up, beneath=exact), "bode", settings, ["run_up"],
        "Amplitude and phase lag of the order 1 over the speed, on the exact response curve.",
        "The run-up follows the stable whirl to its fold, and jumps late.",
    )  # fmt: skip
    show(
        plot_polar(up, beneath=exact), "polar", settings, ["run_up"],
        "The same as a vector, with marks of the speed.",
        "The lag grows clockwise, against the rotation: 90° at the fold.",
    )  # fmt: skip
    show(
        plot_orders(up, orders=[0.5, 1, 2], logarithmic=True, beneath=exact[:1]), "orders",
        settings, ["run_up"],
        "Amplitudes of the orders ½, 1 and 2, forward and backward.",
        "On the whirl the order 1 is three decades above the others; after the jump free vibration "
        "decays.",
    )  # fmt: skip
    show(
        plot_cascade(up), "cascade", settings, ["run_up"],
        "Full spectra over the speed, with lines along the orders.",
        "Forward whirl along 1X, largest at the jump, where free vibration below the speed "
        "decays.",
    )  # fmt: skip
    show(
        plot_spectrogram(up), "spectrogram", settings, ["run_up"],
        "The same in colour, down to a thousandth of the largest amplitude.",
        "The free vibration after the jump spreads from forward to backward whirl; no order does.",
    )  # fmt: skip
    rubs = float(up["entry_time"][0])
    part = up.sel(t=slice(rubs - 0.3, rubs + 0.5))
    show(
        plot_trace(part), "trace", settings, ["run_up"],
        "Displacements over time round the first touch; contacts are shaded.",
        "From the first touch on the rotor stays in contact: a full annular rub.",
    )  # fmt: skip


def draw_measured(up: xr.Dataset, exact: Sequence[xr.Dataset], settings: Settings) -> None:
    """Write the signals of the run-up as measured by probes, read them back and draw them."""
    path = settings.folder / "probes.csv"
    write_probes(path, up)
    signals = read_signals(
        path, columns={"x": "A", "y": "B"}, units={"x": "um", "y": "um"}, probe_angles=(45, 135)
    )
    beneath = [dimensional(each, MACHINE) for each in exact]
    tracked = orders(signals, revolutions=4)  # a pulse is located to a fraction of a sample only
    show(
        plot_bode(tracked, beneath=beneath), "measured", settings, ["run_up"],
        "The Bode plot of two probes at 45° and 135° with noise and a keyphasor, read from a CSV "
        "file.",
        "It equals that of the simulation: the same lines of code draw a file and a run.",
    )  # fmt: skip


def write_probes(path: Path, up: xr.Dataset) -> None:
    """Write a table of times, two probes at 45 and 135 degrees and a sampled keyphasor."""
    rng = np.random.default_rng(28)
    x, y = up.x.values, up.y.values
    readings = np.stack([x + y, y - x]) / np.sqrt(2.0)
    readings += NOISE * rng.normal(size=readings.shape)
    # half-way up where the unbalance points along x, so that phases are those of the run
    pulse = np.exp(SHARP * (np.cos(up.angle.values - np.arccos(1.0 - np.log(2.0) / SHARP)) - 1.0))
    table = np.stack([up.t.values, *readings, pulse], axis=1)
    np.savetxt(path, table, delimiter=",", header="t [s],A,B,keyphasor", comments="",
               fmt=["%.6f", "%.3f", "%.3f", "%.3f"])  # fmt: skip


def draw_bouncing(bouncing: xr.Dataset, cycle: xr.Dataset, settings: Settings) -> None:
    """Draw the motion and the spectrum of the bouncing rotor."""
    late = bouncing.sel(t=slice(370.0, None))
    show(
        plot_orbit(late, keyphasor=True, beneath=cycle), "orbit", settings, ["bouncing"],
        "The orbit of a bouncing rotor over that of its exact cycle, with a dot at each keyphasor "
        "pulse.",
        "The dots move: beside the order 1 there is a whirl at another frequency.",
    )  # fmt: skip
    show(
        plot_full_spectrum(bouncing, beneath=cycle), "full_spectrum", settings, ["bouncing"],
        "Forward and backward lines, with their bandwidth and the noise floor.",
        "Each line belongs to the exact cycle; only 1X is at a multiple of the speed.",
    )  # fmt: skip


def show(
    drawn: Axes | list[Axes],
    name: str,
    settings: Settings,
    archives: Sequence[str],
    shows: str,
    found: str,
) -> None:
    """Show a figure."""
    figure = (drawn[0] if isinstance(drawn, list) else drawn).figure
    settings.show(figure, name, archives=archives, shows=shows, found=found)


if __name__ == "__main__":
    sys.exit(run_script(main, description=__doc__, script=__file__))
