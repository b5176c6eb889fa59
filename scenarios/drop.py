"""Drop of a rotor from its magnetic bearing into the touchdown bearing.

A rotor of 20 kg at 15,000 rpm, balanced to G 6.3, is released in a touchdown bearing with 0.2 mm of
clearance: plausible numbers of no particular machine. At release it rotates about its centre of
mass, at rest on the axis. It falls, hits the bearing after 6.4 ms and bounces. With enough contact
damping it comes to rest within some hundredths of a second: it stays in contact, in the whirl that
the unbalance drives, and rocks at the bottom. With too little, the unbalance restores the energy
that impacts lose, and the rotor keeps bouncing. The necessary damping, the time to rest and the
forces are mapped over clearance and contact damping.

"At rest" means in contact for the last quarter of a second simulated. The time to rest is that of
the last entry into contact. The speed is constant.

These drops have no friction. With friction the rim, which moves at 31 m/s, drives the rotor
backwards round the bearing. If it is driven past the slipping backward whirl, only rolling ends the
acceleration: dry whip, at a force that no machine survives. The fraction of drops that end in whip,
from several release points near the axis, is mapped over friction and damping for both contact
dampings. The exact limit above which no whip exists is drawn too.

Writes both drops in SI units (resting.nc, bouncing.nc), the map (map.nc), a drop that rests and one
that whirls (lies.nc, whirls.nc), the fractions (whip.nc), and the figures as PNG and SVG.
"""

import math
import sys
from collections.abc import Mapping
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.patheffects import withStroke
from scipy.optimize import brentq

from rotor_ida import (
    DimensionalRotor,
    backward_whirl,
    contact_forces,
    dimensional,
    impact,
    simulate,
)
from rotor_ida.paper.scenario import Settings, progress_bar, run_script
from rotor_ida.paper.whip import is_whip
from rotor_ida.plot import mixed_panels, plot_orbit, plot_trace, shared_legend, style
from rotor_ida.plot.palette import BLUE, DASHES, GREY, INK, RED, look

GRAVITY = 9.80665  # m/s^2
MASS = 20.0  # kg
CLEARANCE = 0.2e-3  # m
DAMPING = 50.0  # N s/m
# Contact damping with which the drop ends in rest, and with which it does not [s/m].
DROPS = {"resting": 10.0, "bouncing": 3.0}
UNITS = {"length": "mm", "force": "kN"}
SHOWN = 0.1  # s
LASTS = 1.0  # s, simulated
STAYS = 0.25  # s in contact after which a rotor counts as at rest
FORCES = [1.0, 5.0, 20.0, 40.0]  # contact damping of the curves of forces [s/m]
DISC_RADIUS = 20e-3  # m, where the rotor touches
PUSHED = {"lies": 0.2, "whirls": 0.4}  # friction of two drops
DECIDED = 0.2  # s, after which a drop either has ended in whip or will not
AWAY = 0.1  # distance from the axis at release, over the clearance
HARD = 20e3  # N, a hundred times the weight


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
    rubs = {name: rubbed(friction) for name, friction in PUSHED.items()}
    for name, run in rubs.items():
        settings.keep(run, name)
    shares = whip_shares(
        friction=np.geomspace(0.1, 1.0, 4 if settings.quick else 12),
        damping=np.geomspace(20.0, 4e4, 4 if settings.quick else 10),
        angles=np.linspace(0.0, 2.0 * math.pi, 2 if settings.quick else 8, endpoint=False),
        settings=settings,
    )
    settings.keep(shares, "whip")
    draw_whip(rubs, shares, settings)


def machine_with(
    contact_damping: float, clearance: float = CLEARANCE, friction: float = 0.0
) -> DimensionalRotor:
    """Return the rotor in a stator with this contact damping [s/m], clearance [m] and friction."""
    return DimensionalRotor(
        mass=MASS,
        contact_stiffness=2e9,  # N/m^1.5
        damping=DAMPING,
        eccentricity=4e-6,  # m
        clearance=clearance,
        speed=15_000.0 * 2.0 * math.pi / 60.0,  # rad/s
        contact_damping=contact_damping,
        load=MASS * GRAVITY,
        friction=friction,
        disc_radius=DISC_RADIUS if friction > 0.0 else None,
    )


def drop(
    machine: DimensionalRotor, duration: float, *, samples: int = 2, away: complex = 0.0
) -> xr.Dataset:
    """Return the motion of a rotor released while its centre of mass is at rest.

    It is at rest on the axis, or `away` from it (over the clearance).
    """
    rotor = machine.rotor()
    place = away * rotor.delta0 - 1.0
    return simulate(
        rotor,
        start=(place.real, place.imag, 0.0, -rotor.omega),
        duration=duration / machine.time_scale,
        samples=samples,
        method="taylor",
    )


def with_force(run: xr.Dataset) -> xr.Dataset:
    """Return a run with the contact force over time."""
    return run.assign(force=contact_forces(run).force)


def time_to_rest(run: xr.Dataset, machine: DimensionalRotor) -> float:
    """Return the time of the last entry into contact [s]; NaN if there is none."""
    last = run.entry_time.values[-1] * machine.time_scale
    stays = np.isnan(run.exit_time.values[-1]) and last <= LASTS - STAYS
    return float(last) if stays else math.nan


def impact_speed(clearance: float) -> float:
    """Return the speed after a fall through the clearance [m/s]."""
    return math.sqrt(2.0 * GRAVITY * clearance)


def restitution(machine: DimensionalRotor) -> float:
    """Return the restitution of the first impact, by the closed form."""
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
        "time_to_rest": (rest, "time of the entry after which the rotor stays in contact", "s"),
    }
    coordinates = {
        "damping": (dampings, "contact damping of Hunt and Crossley", "s m-1"),
        "clearance": (clearance, "radial clearance of the touchdown bearing", "m"),
    }
    return xr.Dataset(
        {name: (tuple(coordinates), values, {"long_name": words, "units": unit})
         for name, (values, words, unit) in columns.items()},
        {name: (name, values, {"long_name": words, "units": unit})
         for name, (values, words, unit) in coordinates.items()},
        {"title": "Drops into a touchdown bearing over its clearance and contact damping"},
    )  # fmt: skip


def rubbed(friction: float) -> xr.Dataset:
    """Return the drop of a rotor with friction until it rests or rolls, in SI units."""
    machine = machine_with(DROPS["resting"], friction=friction)
    run = drop(machine, 0.06, samples=6001)
    return dimensional(run, machine, units=UNITS)


def largest_whip_damping(friction: float) -> float:
    """Return the damping [N s/m] above which no whip exists without load and unbalance.

    Rolling backwards takes ``n V`` of friction along the stator and has ``N = m r Omega**2`` across
    it, so that ``n <= mu m |Omega|``; damping does not change Omega.
    """
    machine = replace(machine_with(0.0, friction=friction), load=0.0, damping=0.0)
    rolling = backward_whirl(machine.rotor()).whirl_speed.values[1]
    return float(-friction * MASS * rolling / machine.time_scale)


def whip_shares(
    *, friction: np.ndarray, damping: np.ndarray, angles: np.ndarray, settings: Settings
) -> xr.Dataset:
    """Return the fraction of drops that end in whip, released at angles round the axis."""
    dampings = list(DROPS.values())
    places = [(contact, each, mu) for contact in dampings for each in damping for mu in friction]

    def share(place: tuple[float, float, float]) -> float:
        machine = replace(machine_with(place[0], friction=place[2]), damping=place[1])
        whips = [
            is_whip(drop(machine, DECIDED, samples=201, away=complex(AWAY * np.exp(1j * angle))))
            for angle in angles
        ]
        return float(np.mean(whips))

    found = []
    with (
        progress_bar("drops with friction") as progress,
        ThreadPoolExecutor(settings.workers) as pool,
    ):
        for value in pool.map(share, places):
            found.append(value)
            progress(len(found), len(places))
    coordinates = {
        "contact_damping": (dampings, "contact damping of Hunt and Crossley", "s m-1"),
        "damping": (damping, "viscous damping", "N s m-1"),
        "friction": (friction, "coefficient of friction in the contact", "1"),
    }
    shares = np.reshape(found, [len(values) for values, _, _ in coordinates.values()])
    border = [largest_whip_damping(mu) for mu in friction]
    return xr.Dataset(
        {
            "whip_share": (tuple(coordinates), shares, {
                "long_name": "fraction of drops that end in dry whip", "units": "1"}),
            "largest_whip_damping": ("friction", border, {
                "long_name": "damping above which no dry whip exists, exact without load and "
                "unbalance", "units": "N s m-1"}),
        },
        {name: (name, values, {"long_name": words, "units": unit})
         for name, (values, words, unit) in coordinates.items()},
        {"title": "Drops into a touchdown bearing with friction", "starts": angles.size},
    )  # fmt: skip


def draw_drops(runs: Mapping[str, xr.Dataset], settings: Settings) -> None:
    figure, axes = mixed_panels(3, 2, height=8.0)
    counted = {}
    for column, (name, run) in enumerate(runs.items()):
        machine = machine_with(DROPS[name], CLEARANCE)
        counted[name] = drop(machine, LASTS)
        orbit, height, force = axes[column::2]
        plot_orbit(run, ax=orbit)
        orbit.set_aspect("equal", adjustable="box")
        orbit.set(xlim=(-0.32, 0.32), ylim=(-0.32, 0.24))
        plot_trace(run, names=("y",), ax=height)
        draw_bounces(height, run)
        with style():
            force.plot(run.t, run.force, color=RED, lw=0.8, label="contact")
            weight = MASS * GRAVITY * run.attrs["force_scale"] / machine.force_scale
            force.axhline(weight, color=GREY, lw=1.0, label="weight")
            force.set(xlabel="time $T$ [s]", ylabel="contact force $F$ [kN]", ylim=(0.0, 1.9))
            force.set_xlim(0.0, SHOWN)
            words = f"$\\lambda$ = {DROPS[name]:g} s/m: {told(counted[name], machine)}"
            orbit.set_title(words, fontsize=9.5)
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
        shows=f"A rotor of {MASS:g} kg at 15,000 rpm falls into a touchdown bearing with a "
        "clearance of 0.2 mm, with two contact dampings λ: orbit, height and contact force.",
        found=f"It touches after {first:.3f} ms; a free fall of its centre of mass takes "
        f"{free:.3f} ms. {ends} The largest forces are {forces[0]:.2f} and {forces[1]:.2f} kN, "
        f"{weights[0]:.1f} and {weights[1]:.1f} times the weight.",
    )  # fmt: skip


def told(run: xr.Dataset, machine: DimensionalRotor) -> str:
    """Return the time to rest in words."""
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
        rest.set(xlabel="clearance [mm]", ylabel="contact damping $\\lambda$ [s/m]", yscale="log",
                 ylim=mapped.damping.values[[0, -1]])  # fmt: skip
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
        "that of an elastic fall, in waves with the phase of the first impact. Damping lowers it "
        "little; strong damping raises it.",
    )  # fmt: skip


def draw_whip(runs: Mapping[str, xr.Dataset], shares: xr.Dataset, settings: Settings) -> None:
    figure, axes = mixed_panels(2, 2, height=6.8)
    orbit, force, *maps = axes
    draw_rubs(runs, orbit, force)
    fine = np.geomspace(shares.friction.values[0], shares.friction.values[-1], 200)
    border = [largest_whip_damping(mu) for mu in fine]
    for ax, contact in zip(maps, sorted(DROPS.values()), strict=True):
        with style():
            shown = ax.pcolormesh(
                shares.friction, shares.damping, shares.whip_share.sel(contact_damping=contact),
                cmap="Reds", vmin=0.0, vmax=1.0, shading="nearest", rasterized=True,
            )  # fmt: skip
            ax.plot(fine, border, color=INK, lw=1.6, label="above it no whip exists (exact)")
            ax.set(xscale="log", yscale="log", xlabel=r"friction $\mu$", xlim=fine[[0, -1]],
                   ylabel="damping $n$ [N s/m]", ylim=shares.damping.values[[0, -1]])  # fmt: skip
            ax.set_xticks([0.1, 0.2, 0.5, 1.0], ["0.1", "0.2", "0.5", "1"])
            ax.minorticks_off()
            ax.grid(visible=False)
            ax.set_title(f"drops with $\\lambda$ = {contact:g} s/m", fontsize=9.5)
            figure.colorbar(shown, ax=ax, label="fraction that ends in whip")
            for mu, colour in zip(PUSHED.values(), (BLUE, RED), strict=True):
                if contact == DROPS["resting"]:
                    ax.plot(
                        mu, DAMPING, ls="", marker="o", ms=5.0, mfc=colour, mec="white", mew=0.8
                    )
    shared_legend(figure, axes, columns=5, outer=False)
    settings.show(
        figure, "whip", archives=[*runs, "whip"],
        shows=f"The rotor of {MASS:g} kg with friction, with its rim at a radius of "
        f"{1e3 * DISC_RADIUS:g} mm: two drops, and the fraction of drops that end in dry whip over "
        "friction and damping, for two contact dampings λ; above the line no whip exists (exact "
        "without load and unbalance).",
        found=told_of_whip(runs, shares),
    )  # fmt: skip


def draw_rubs(runs: Mapping[str, xr.Dataset], orbit: Axes, force: Axes) -> None:
    """Draw orbits until the force exceeds a hundred weights, and forces over time."""
    looks = {"lies": (BLUE, "rests"), "whirls": (RED, "whirls")}
    around = np.exp(2j * math.pi * np.linspace(0.0, 1.0, 361)) * CLEARANCE * 1e3
    with style():
        orbit.plot(around.real, around.imag, color=INK, lw=0.9, ls=DASHES, label="clearance")
        for name, run in runs.items():
            colour, words = looks[name]
            words = f"$\\mu$ = {PUSHED[name]:g}: {words}"
            before = run.t < beyond(run, HARD)
            orbit.plot(run.x.where(before), run.y.where(before), color=colour, lw=0.9)
            pressed = run.normal_force.where(run.normal_force > 0.0)
            force.plot(1e3 * run.t, pressed, color=colour, lw=0.9, label=words)
        for ax in (orbit, force):
            ax.set_title(
                f"$\\lambda$ = {DROPS['resting']:g} s/m, $n$ = {DAMPING:g} N s/m", fontsize=9.5
            )
        orbit.set_aspect("equal", adjustable="box")
        orbit.set(xlabel="displacement $X$ [mm]", ylabel="displacement $Y$ [mm]",
                  xlim=(-0.6, 0.6), ylim=(-0.6, 0.6))  # fmt: skip
        force.axhline(1e-3 * MASS * GRAVITY, color=GREY, lw=1.0, label="weight")
        force.set(xlabel="time $T$ [ms]", ylabel="normal force $N$ [kN]", yscale="log",
                  xlim=(0.0, 60.0), ylim=(0.01, 2e4))  # fmt: skip


def beyond(run: xr.Dataset, force: float) -> float:
    """Return when the normal force first exceeds a force [N], in s; infinity if it does not."""
    over = run.t.values[1e3 * run.normal_force.values > force]
    return float(over[0]) if over.size else math.inf


def told_of_whip(runs: Mapping[str, xr.Dataset], shares: xr.Dataset) -> str:
    """Return the gallery text on drops with friction."""
    whirls = runs["whirls"]
    rows = []
    for contact in sorted(DROPS.values()):
        share = shares.whip_share.sel(contact_damping=contact)
        some = shares.friction.values[(share > 0.0).any("damping").values]
        light = shares.friction.values[(share.isel(damping=0) == 1.0).values]
        rows.append(
            f"with λ = {contact:g} s/m {100.0 * float(share.mean()):.0f}% end in whip, some from "
            f"μ = {some.min():.2f} on, all with the least damping from μ = {light.min():.2f} on"
        )
    exists = shares.damping <= shares.largest_whip_damping
    there = float(shares.whip_share.where(exists).mean())
    outside = float(shares.whip_share.where(~exists).max())
    rests, goes_round = PUSHED.values()
    return (
        f"With λ = {DROPS['resting']:g} s/m and μ = {rests:g} the rotor stays in contact, on the "
        f"side to which friction pulls it. With μ = {goes_round:g} it goes round: the force "
        f"exceeds {1e-3 * HARD:g} kN, a hundred weights, {1e3 * beyond(whirls, HARD):.1f} ms after "
        "release, and grows until the disc rolls at "
        f"{1e-3 * float(whirls.normal_force[-1]):.1f} MN, which no real "
        f"bearing survives. Of all drops {'; '.join(rows)}. Where whip exists {100.0 * there:.0f}% "
        f"of drops end in it, elsewhere {'none does' if outside == 0.0 else 'some do'}: the first "
        "impacts must drive the rotor round the stator faster than the slipping whirl, which is "
        "faster with more damping and less friction."
    )


if __name__ == "__main__":
    sys.exit(run_script(main, description=__doc__, script=__file__))
