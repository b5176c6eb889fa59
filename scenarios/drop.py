"""A rotor that loses its magnetic bearing and falls into the touchdown ring.

A rotor of 20 kg at 15,000 rpm, balanced to G 6.3, is let go in a touchdown ring 0.2 mm below:
plausible numbers, of no machine in particular. Until then it turned about its centre of mass, at
rest on the axis. It falls, hits the ring after 6.4 ms and bounces. If the ring takes enough of each
impact, it is at rest within some hundredths of a second: it stays on the ring, in the whirl that
the unbalance keeps up, and rocks at the bottom. If the ring takes too little, the unbalance gives
back what the impacts lose, and the rotor bounces on. How much is enough, how long it takes and how
large the forces get is mapped over clearance and contact damping.

At rest means: on the ring for the last quarter of a second simulated, and the time to rest is that
of the last entry. The speed is held, and the ring has no friction, which in a machine may drive a
whirl backwards.

Writes both drops in SI units (resting.nc, bouncing.nc), the map (map.nc), and the figures as PNG
and SVG.
"""

import math
import sys
from collections.abc import Mapping
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.patheffects import withStroke
from scipy.optimize import brentq

from rotor_ida import DimensionalRotor, contact_forces, dimensional, impact, simulate
from rotor_ida.paper.scenario import Settings, progress_bar, run_script
from rotor_ida.plot import mixed_panels, plot_history, plot_orbit, shared_legend, style
from rotor_ida.plot.appearance import DASHES, GREY, INK, RED, look

GRAVITY = 9.80665  # m/s^2
MASS = 20.0  # kg
CLEARANCE = 0.2e-3  # m
# Contact damping with which the drop ends in rest, and with which it does not [s/m].
DROPS = {"resting": 10.0, "bouncing": 3.0}
UNITS = {"length": "mm", "force": "kN"}
SHOWN = 0.1  # s
LASTS = 1.0  # s, simulated
STAYS = 0.25  # s on the ring, by which a rotor is told to be at rest
FORCES = [1.0, 5.0, 20.0, 40.0]  # contact damping of the curves of forces [s/m]


def main(settings: Settings) -> None:
    runs = {}
    for name, contact_damping in DROPS.items():
        machine = machine_with(contact_damping, CLEARANCE)
        run = drop(machine, SHOWN, samples=8001)
        runs[name] = dimensional(with_force(run), machine, units=UNITS)
        settings.keep(runs[name], name)
    draw_drops(runs, settings)
    mapped = map_of(
        contact_damping=np.geomspace(1.0, 40.0, 6 if settings.quick else 24),
        clearance=np.linspace(0.05e-3, 0.4e-3, 8 if settings.quick else 29),
        settings=settings,
    )
    settings.keep(mapped, "map")
    draw_map(mapped, settings)


def machine_with(contact_damping: float, clearance: float) -> DimensionalRotor:
    """Return the rotor in a touchdown ring with this contact damping [s/m] and clearance [m]."""
    return DimensionalRotor(
        mass=MASS,
        contact_stiffness=2e9,  # N/m^1.5
        damping=50.0,  # N s/m
        eccentricity=4e-6,  # m
        clearance=clearance,
        speed=15_000.0 * 2.0 * math.pi / 60.0,  # rad/s
        contact_damping=contact_damping,
        load=MASS * GRAVITY,
    )


def drop(machine: DimensionalRotor, duration: float, *, samples: int = 2) -> xr.Dataset:
    """Return the motion of a rotor that is let go while its centre of mass rests on the axis."""
    rotor = machine.rotor()
    return simulate(
        rotor,
        start=(-1.0, 0.0, 0.0, -rotor.omega),
        duration=duration / machine.time_scale,
        samples=samples,
        method="taylor",
    )


def with_force(run: xr.Dataset) -> xr.Dataset:
    """Return a run with the contact force over time."""
    return run.assign(force=contact_forces(run).force)


def time_to_rest(run: xr.Dataset, machine: DimensionalRotor) -> float:
    """Return when the rotor has entered the ring for good [s]; NaN if it has not."""
    last = run.entry_time.values[-1] * machine.time_scale
    stays = np.isnan(run.exit_time.values[-1]) and last <= LASTS - STAYS
    return float(last) if stays else math.nan


def impact_speed(clearance: float) -> float:
    """Return the speed after a fall through the clearance [m/s]."""
    return math.sqrt(2.0 * GRAVITY * clearance)


def restitution(machine: DimensionalRotor) -> float:
    """Return what the first impact gives back of the speed, by the closed form."""
    given = machine.rotor().given
    speed = impact_speed(machine.clearance) / machine.velocity_scale
    hit = impact(entry_speed=speed, contact_damping=given.get("contact_damping", 0.0))
    return hit.restitution.item()


def elastic_force(clearance: float) -> float:
    """Return the force of a first fall without damping and unbalance [N], by its energy."""
    machine = machine_with(0.0, clearance)
    stiffness, power = machine.contact_stiffness, machine.contact_exponent + 1.0

    def left(depth: float) -> float:
        return stiffness * depth**power / power - machine.load * (clearance + depth)

    return stiffness * float(brentq(left, 1e-9, 1e-2, xtol=1e-15)) ** machine.contact_exponent


def map_of(*, contact_damping: np.ndarray, clearance: np.ndarray, settings: Settings) -> xr.Dataset:
    """Return the largest force and the time to rest of a drop at each damping and clearance."""
    dampings = np.unique(np.concatenate([contact_damping, FORCES]))
    places = [(damping, each) for damping in dampings for each in clearance]

    def figures_at(place: tuple[float, float]) -> tuple[float, float]:
        machine = machine_with(*place)
        run = drop(machine, LASTS)
        return float(run.peak_force.max()) * machine.force_scale, time_to_rest(run, machine)

    rows = []
    with progress_bar("drops") as progress, ThreadPoolExecutor(settings.workers) as pool:
        for row in pool.map(figures_at, places):
            rows.append(row)
            progress(len(rows), len(places))
    force, rest = np.array(rows).reshape(dampings.size, clearance.size, 2).transpose(2, 0, 1)
    columns = {
        "largest_force": (force, "largest contact force of the drop", "N"),
        "time_to_rest": (rest, "time of the entry after which the rotor stays on the ring", "s"),
    }
    coordinates = {
        "damping": (dampings, "contact damping of Hunt and Crossley", "s m-1"),
        "clearance": (clearance, "radial clearance of the touchdown ring", "m"),
    }
    return xr.Dataset(
        {name: (tuple(coordinates), values, {"long_name": words, "units": unit})
         for name, (values, words, unit) in columns.items()},
        {name: (name, values, {"long_name": words, "units": unit})
         for name, (values, words, unit) in coordinates.items()},
        {"title": "Drops into a touchdown ring over its clearance and contact damping"},
    )  # fmt: skip


def draw_drops(runs: Mapping[str, xr.Dataset], settings: Settings) -> None:
    figure, axes = mixed_panels(3, 2, height=8.0)
    counted = {}
    for column, (name, run) in enumerate(runs.items()):
        machine = machine_with(DROPS[name], CLEARANCE)
        counted[name] = drop(machine, LASTS)
        orbit, height, force = axes[column::2]
        plot_orbit(run, ax=orbit).set_title("")
        orbit.set_aspect("equal", adjustable="box")
        orbit.set(xlim=(-0.32, 0.32), ylim=(-0.32, 0.24))
        plot_history(run, "y", ax=height)
        draw_bounces(height, run)
        with style():
            force.plot(run.t, run.force, color=RED, lw=0.8, label="contact")
            weight = MASS * GRAVITY * run.attrs["force_scale"] / machine.force_scale
            force.axhline(weight, color=GREY, lw=1.0, label="weight")
            force.set(xlabel="time $T$ [s]", ylabel="contact force $F$ [kN]", ylim=(0.0, 1.9))
            force.set_xlim(0.0, SHOWN)
            height.set_title(f"$\\lambda$ = {DROPS[name]:g} s/m: {told(counted[name], machine)}")
    shared_legend(figure, axes, columns=7, outer=False)
    first = 1e3 * runs["resting"].event_time.values[0]
    free = 1e3 * math.sqrt(2.0 * CLEARANCE / GRAVITY)
    forces = [run.peak_force.max().item() for run in runs.values()]
    weights = [1e3 * force / (MASS * GRAVITY) for force in forces]
    ends = " ".join(
        f"With {DROPS[name]:g} s/m the first impact leaves "
        f"{restitution(machine_with(DROPS[name], CLEARANCE)):.2f} of the speed, and the rotor is "
        f"{told(run, machine_with(DROPS[name], CLEARANCE))}: {run.sizes['contact']} contacts in "
        f"{LASTS:g} s."
        for name, run in counted.items()
    )
    settings.show(
        figure, "drop", archives=list(runs),
        shows=f"A rotor of {MASS:g} kg at 15,000 rpm falls into a touchdown ring with a clearance "
        "of 0.2 mm, with two contact dampings λ: orbit, height and contact force.",
        found=f"It touches after {first:.3f} ms; a free fall of its centre of mass takes "
        f"{free:.3f} ms. {ends} The ring bears up to {forces[0]:.2f} and {forces[1]:.2f} kN, "
        f"{weights[0]:.1f} and {weights[1]:.1f} times the weight.",
    )  # fmt: skip


def told(run: xr.Dataset, machine: DimensionalRotor) -> str:
    """Return in words when a rotor is at rest."""
    rest = time_to_rest(run, machine)
    if math.isnan(rest):
        return f"not at rest within {LASTS - STAYS:g} s"
    return f"at rest after {rest:.3f} s"


def draw_bounces(ax: Axes, run: xr.Dataset) -> None:
    """Mark entries and exits."""
    for kind, marker, face, words in ((1, "^", RED, "entry"), (-1, "v", "white", "exit")):
        here = run.event_kind.values == kind
        ax.plot(run.event_time[here], run.event_y[here], ls="", marker=marker, ms=4.0, mec=RED,
                mfc=face, mew=0.7, label=words, zorder=3.0)  # fmt: skip
    with style():
        ax.axhline(-CLEARANCE * 1e3, color=INK, lw=0.9, ls=DASHES, label="clearance")
        ax.set_ylim(-0.3, 0.02)


def draw_map(mapped: xr.Dataset, settings: Settings) -> None:
    figure, (forces, rest) = mixed_panels(1, 2, height=3.4)
    millimetres = 1e3 * mapped.clearance
    with style():
        for number, damping in enumerate(FORCES):
            colour, dashes = look(number)
            forces.plot(millimetres, 1e-3 * mapped.largest_force.sel(damping=damping), color=colour,
                        ls=dashes, label=f"$\\lambda$ = {damping:g} s/m")  # fmt: skip
        elastic = [1e-3 * elastic_force(each) for each in mapped.clearance.values]
        forces.plot(millimetres, elastic, color=GREY, lw=2.4, zorder=1.5,
                    label="elastic fall, no unbalance")  # fmt: skip
        forces.set(xlabel="clearance [mm]", ylabel="largest force $F$ [kN]", ylim=(0.0, None))
        forces.legend(loc="lower right")
        forces.set_title("force: about that of an elastic fall", fontsize=9.5)
        shown = rest.pcolormesh(
            millimetres, mapped.damping, 1e3 * mapped.time_to_rest, cmap="viridis_r", vmin=0.0,
            vmax=100.0, shading="nearest", rasterized=True,
        )  # fmt: skip
        rest.set_facecolor("#c9d1d0")
        figure.colorbar(shown, ax=rest, label="time to rest [ms]", extend="max")
        lines = np.array(
            [[restitution(machine_with(damping, each)) for each in mapped.clearance.values]
             for damping in mapped.damping.values]
        )  # fmt: skip
        contours = rest.contour(millimetres, mapped.damping, lines, levels=[0.4, 0.6, 0.8, 0.9],
                                colors=INK, linewidths=0.8)  # fmt: skip
        for words in rest.clabel(contours, fmt="$e$ = %.1f", fontsize=8.0):
            words.set_path_effects([withStroke(linewidth=2.0, foreground="white")])
        rest.set(xlabel="clearance [mm]", ylabel="contact damping $\\lambda$ [s/m]", yscale="log")
        rest.set_yticks([1, 2, 5, 10, 20, 40], ["1", "2", "5", "10", "20", "40"])
        rest.minorticks_off()
        rest.set_title(f"grey: not at rest within {LASTS - STAYS:g} s", fontsize=9.5)
        rest.grid(visible=False)
    stays = mapped.time_to_rest.notnull()
    always = mapped.damping.values > mapped.damping.values[~stays.all("clearance").values].max()
    worst = float(mapped.time_to_rest.isel(damping=always).max())
    settings.show(
        figure, "map", archives=["map"],
        shows="Drops over clearance and contact damping: the largest force, and the time to rest "
        "with the restitution e of the first impact; grey bounces on.",
        found=f"Of {mapped.time_to_rest.size} drops {int(stays.sum())} end in rest within "
        f"{LASTS - STAYS:g} s. From {mapped.damping.values[always].min():.3g} s/m on all do, in "
        f"{1e3 * worst:.0f} ms or less; with less damping some do and some do not, by the phase of "
        "the unbalance that the bounces meet. The largest force grows with the clearance about as "
        "that of an elastic fall, in waves by the phase of the first impact; damping lowers it "
        "little, and raises it where it is strong.",
    )  # fmt: skip


if __name__ == "__main__":
    sys.exit(run_script(main, description=__doc__, script=__file__))
