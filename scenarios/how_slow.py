"""How slow is slow enough: peak force and outcome of a run-up through resonance over its rate.

A rotor on a shaft runs up through its critical speed in a stator, from rest on the axis. At a slow
rate it follows the exact response: it touches, rides up the stiffened resonance, and reaches the
largest force where that response ends. The force is 92 % of the exact maximum or more if the speed
rises by less than 5 % of the critical speed during the decay time of a free vibration. At a fast
rate the rotor never touches. At any damping its radius stays below Lewis' 1.467/sqrt(a) plus one
eccentricity, where a is the rate over the critical speed squared. Run-ups over rate and clearance
show the range between, beside the largest force on the exact response. Run-ups over rate and
friction, for four initial angles of the unbalance, end out of contact, in a rub, or in dry whip.

The same in SI units for the rotor of the scenario drop on its magnetic bearing: 20 kg balanced to
G 6.3, with 0.2 mm of clearance to the touchdown bearing and a stiffness of 2 MN/m. Its critical
speed is 3,020 rpm; it runs up from 1,000 to 6,000 rpm.

Writes the run-ups (forces.nc, endings.nc), those of the machine in SI units (machine_forces.nc,
machine_endings.nc), and the figures as PNG and SVG.
"""

import math
import sys

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.colors import ListedColormap
from matplotlib.figure import Figure
from matplotlib.patches import Patch

from rotor_ida import DimensionalRotor, Rotor, dimensional, run_ups, synchronous_response
from rotor_ida.closed_forms import peaks
from rotor_ida.model.contact import contact_force
from rotor_ida.paper.scenario import Settings, progress_bar, run_script
from rotor_ida.plot import mixed_panels, style
from rotor_ida.plot.palette import DASHES, GREY, INK, look
from rotor_ida.schema import ENDING

# The largest radius of an undamped run-up through a critical speed of 1 tends to this over the
# root of the rate as the rate goes to 0: Lewis, 1932. Up to a rate of 1 it is larger by less
# than MORE.
LEWIS, MORE = 1.46720, 1.0
# A slow run-up has a rate below this times the damping ratio and the critical speed squared.
SLOW = 0.05

METHOD = "taylor"
SHAFT = {"zeta": 0.02, "shaft_stiffness": 1.0}
FROM, TO = 0.2, 3.5
DISC_RADIUS = 20.0
CLEARANCES = [2.0, 5.0, 10.0, 20.0]
RUBS_AT = 5.0  # clearance of the run-ups with friction
FRICTIONS = [0.0, 0.05, 0.1, 0.3]
RADIANS = 2.0 * math.pi / 60.0  # rad/s in one rpm

SUSPENSION = 2e6  # N/m, of the magnetic bearing
RUN = (1000.0, 6000.0)  # rpm
RING = [0.1e-3, 0.2e-3, 0.3e-3]  # m
SMOOTH = 0.05  # friction of a stator that lets the rotor slide
# Outcomes of a run-up, from best to worst, with their colours.
ENDS = {
    "never touches": "white",
    "touches, then leaves": "#cfe3f5",
    "ends in a rub": "#d7b3ea",
    "ends in dry whip": "#8a4f3d",
}


def main(settings: Settings) -> None:
    quick = settings.quick
    forces = run_over(
        "clearance", settings, omega=FROM, to=TO, **SHAFT,
        rate=np.geomspace(1e-2 if quick else 3e-4, 1.0, 5 if quick else 36),
        delta0=np.unique(np.append(np.geomspace(1.0, 24.0, 2 if quick else 24), CLEARANCES)),
    )  # fmt: skip
    settings.keep(forces, "forces")
    endings = run_over(
        "friction", settings, omega=FROM, to=TO, **SHAFT, delta0=RUBS_AT, disc_radius=DISC_RADIUS,
        rate=np.geomspace(1e-2 if quick else 1e-3, 0.3, 3 if quick else 20),
        friction=frictions(0.8, quick=quick), phase=phases(quick=quick),
        starts=[(0.2 * RUBS_AT, 0.0, 0.0, 0.0)],
    )  # fmt: skip
    settings.keep(endings, "endings")
    draw(forces, endings, settings)
    machine_forces = of_machine(
        RING, [SMOOTH], rate=np.geomspace(200.0 if quick else 50.0, 5000.0, 4 if quick else 31),
        settings=settings,
    )  # fmt: skip
    settings.keep(machine_forces, "machine_forces")
    machine_endings = of_machine(
        RING[1:2], np.geomspace(0.03 if quick else 0.01, 0.3, 2 if quick else 10),
        rate=np.geomspace(400.0 if quick else 50.0, 1000.0, 3 if quick else 12),
        settings=settings,
    )  # fmt: skip
    settings.keep(machine_endings, "machine_endings")
    draw_machine(machine_forces, machine_endings, settings)


def frictions(largest: float, *, quick: bool) -> np.ndarray:
    """Return coefficients of friction, those of the curves among them."""
    return np.unique(np.append(np.geomspace(0.01, largest, 1 if quick else 12), FRICTIONS))


def phases(*, quick: bool) -> np.ndarray:
    """Return angles of the unbalance at the beginning."""
    return np.linspace(0.0, 2.0 * math.pi, 1 if quick else 4, endpoint=False)


def run_over(what: str, settings: Settings, **given: object) -> xr.Dataset:
    """Return run-ups over the rate and a second quantity."""
    with progress_bar(f"run-ups over rate and {what}") as progress:
        return run_ups(
            **given, method=METHOD, rtol=1e-8, workers=settings.workers, progress=progress
        )


def machine_with(clearance: float, friction: float = 0.0) -> DimensionalRotor:
    """Return the rotor of the scenario drop on its magnetic bearing."""
    return DimensionalRotor(
        mass=20.0,
        contact_stiffness=2e9,  # N/m^1.5
        damping=50.0,  # N s/m
        eccentricity=4e-6,  # m
        clearance=clearance,
        speed=RUN[0] * RADIANS,
        shaft_stiffness=SUSPENSION,
        contact_damping=10.0,  # s/m
        friction=friction,
        disc_radius=20e-3,  # m
    )


def of_machine(
    clearances: list[float], frictions: list[float] | np.ndarray, *, rate: np.ndarray,
    settings: Settings,
) -> xr.Dataset:  # fmt: skip
    """Return run-ups of the machine in stators with these clearances [m], at rates in rpm/s."""
    machine = machine_with(clearances[0])
    frequency, given = machine.reference_frequency, machine.rotor().given
    given |= {
        "to": RUN[1] * RADIANS / frequency,
        "rate": rate * RADIANS / frequency**2,
        "delta0": np.array(clearances) / machine.eccentricity,
        "friction": np.asarray(frictions),
    }
    found = run_over("the machine's stator", settings, **given)
    found = dimensional(found, machine, units={"speed": "rpm"})
    return found.assign_coords(
        rate_rpm=("rate", rate, {"long_name": "change of the speed", "units": "rpm s-1"}),
        clearance=("delta0", clearances, {"long_name": "radial clearance", "units": "m"}),
    )  # fmt: skip


def steady_force(rotor: Rotor, to: float) -> float:
    """Return the largest force on the exact response that a slow run-up follows up to a speed."""
    given = {name: value for name, value in rotor.given.items() if name != "omega"}
    given = {name: given[name] for name in given if name not in {"disc_radius", "contact_damping"}}
    best = peaks(**given)
    if not best.peak_omega.item() > to:
        return float(best.peak_contact_force.fillna(0.0).item())
    amplitude = synchronous_response(omega=to, **given).amplitude.max().item()
    return float(contact_force(amplitude, rotor.delta0, rotor.contact_exponent))


def never_touches_from(rotor: Rotor) -> float:
    """Return the rate above which an undamped rotor does not reach the stator, after Lewis."""
    return LEWIS**2 * rotor.shaft_stiffness / (rotor.delta0 - MORE) ** 2


def worst(found: xr.Dataset) -> xr.DataArray:
    """Return the outcome of run-ups, as numbers of `ENDS`: the worst over the phases."""
    touches = (found.contact_count > 0).astype(float)
    comes = xr.where(found.ending == ENDING["contact_free"], touches, 2.0)
    comes = xr.where(found.ending == ENDING["whip"], 3.0, comes).where(found.status == 0)
    return comes.max(["phase", "start"]).squeeze()


def part_of_steady(forces: xr.Dataset) -> xr.DataArray:
    """Return the largest forces relative to the exact response, by rate and clearance."""
    steady = [
        steady_force(Rotor(omega=FROM, delta0=clearance, **SHAFT), TO)
        for clearance in forces.delta0.values
    ]
    return forces.largest_force.squeeze() / xr.DataArray(steady, dims="delta0")


def rate_at(part: xr.DataArray, level: float) -> float:
    """Return the rate at which the fraction of the steady force has fallen to a level."""
    below = np.flatnonzero(part.values < level)
    if not below.size or not below[0]:
        return math.nan
    (low, high), ends = part.values[below[0] - 1 : below[0] + 1], part.rate.values[below[0] - 1 :]
    return float(ends[0] * (ends[1] / ends[0]) ** ((low - level) / (low - high)))


def draw(forces: xr.Dataset, endings: xr.Dataset, settings: Settings) -> None:
    figure, axes = mixed_panels(2, 2, height=6.4)
    rate = forces.rate.values
    with style():
        for number, clearance in enumerate(CLEARANCES):
            colour, dashes = look(number)
            one = forces.largest_force.sel(delta0=clearance).squeeze()
            axes[0].plot(rate, one.where(one > 0.0), color=colour, ls=dashes,
                         label=f"$\\delta_0$ = {clearance:g}")  # fmt: skip
            rotor = Rotor(omega=FROM, delta0=clearance, **SHAFT)
            axes[0].axhline(steady_force(rotor, TO), color=colour, lw=0.6, ls=dashes, alpha=0.6)
            axes[0].axvline(never_touches_from(rotor), ymax=0.06, color=colour, lw=2.0)
        axes[0].set(xscale="log", yscale="log", ylim=(0.1, 2e3), xlabel="rate $a$",
                    ylabel="largest normal force")  # fmt: skip
        axes[0].legend(loc="upper right", frameon=True, bbox_to_anchor=(1.0, 0.8))
        draw_part(axes[1], part_of_steady(forces))
        for number, friction in enumerate(FRICTIONS):
            colour, dashes = look(number)
            some = endings.largest_force.sel(friction=friction).max(["phase", "start"]).squeeze()
            axes[2].plot(endings.rate, some.where(some > 0.0), color=colour, ls=dashes,
                         label=f"$\\mu$ = {friction:g}")  # fmt: skip
        axes[2].set(xscale="log", yscale="log", xlabel="rate $a$", ylabel="largest normal force",
                    xlim=(endings.rate.min(), endings.rate.max()), ylim=(0.1, 2e3))  # fmt: skip
        axes[2].legend(loc="lower left")
        axes[2].set_title(f"$\\delta_0$ = {RUBS_AT:g}")
        draw_endings(axes[3], endings, endings.rate.values)
        axes[3].set_xlabel("rate $a$")
        axes[3].set_title(f"$\\delta_0$ = {RUBS_AT:g},  $\\rho$ = {DISC_RADIUS:g}")
        legend_of_endings(figure)
    settings.show(
        figure, "how_slow", archives=["forces", "endings"],
        shows="Run-ups through a critical speed of 1 over their rate, ζ = 0.02: (a) the largest "
        "force for four clearances, the largest on the exact response (horizontal), "
        "and the rate above which an undamped rotor does not touch (marks on the axis); (b) the "
        "force over rate and clearance as a fraction of that on the exact response, the rule for "
        f"slow run-ups (white: {SLOW:g} ζ) and that for fast ones (grey); (c) the force with "
        "friction; (d) how run-ups end over rate and friction, the worst of the phases of the "
        "unbalance.",
        found=told(forces, endings),
    )  # fmt: skip


def draw_part(ax: Axes, part: xr.DataArray) -> None:
    """Draw the fraction of the steady force, over rate and clearance."""
    part = part.transpose("rate", "delta0")
    mesh = ax.pcolormesh(part.delta0, part.rate, part.where(part > 0.0), cmap="YlOrBr", vmin=0.0,
                         vmax=1.0, shading="nearest", rasterized=True)  # fmt: skip
    ax.figure.colorbar(mesh, ax=ax, label="fraction of the steady force", pad=0.02)
    for level, dashes, colour in ((0.9, "-", "white"), (0.5, "--", INK), (0.1, ":", INK)):
        rates = [rate_at(part.isel(delta0=place), level) for place in range(part.delta0.size)]
        ax.plot(part.delta0, rates, color=INK, lw=0.9, ls=dashes)
        if math.isfinite(rates[0]):
            ax.annotate(f"{100.0 * level:.0f} %", (1.15, 1.1 * rates[0]), color=colour)
    clearance = np.geomspace(1.1 * MORE, part.delta0.max(), 200)
    ax.plot(clearance, LEWIS**2 / (clearance - MORE) ** 2, color=GREY, lw=2.4)
    ax.axhline(SLOW * SHAFT["zeta"], color="white", lw=1.2, ls=DASHES)
    ax.annotate("slow", (2.5, 0.9 * SLOW * SHAFT["zeta"]), color="white", va="top")
    ax.annotate("never touches", (0.97, 0.95), xycoords="axes fraction", ha="right", va="top")
    ax.set(xscale="log", yscale="log", xlabel="clearance $\\delta_0$", ylabel="rate $a$",
           ylim=(part.rate.min(), part.rate.max()),
           xlim=(part.delta0.min(), part.delta0.max()))  # fmt: skip
    ax.grid(visible=False)


def draw_endings(ax: Axes, endings: xr.Dataset, rate: np.ndarray) -> None:
    """Draw how run-ups end, over rate and friction."""
    some = worst(endings.isel(friction=endings.friction.values > 0.0)).transpose("friction", "rate")
    ax.set_facecolor(GREY)
    ax.pcolormesh(rate, some.friction, some, cmap=ListedColormap(list(ENDS.values())), vmin=-0.5,
                  vmax=3.5, shading="nearest", rasterized=True)  # fmt: skip
    ax.set(xscale="log", yscale="log", ylabel="friction $\\mu$")
    ax.grid(visible=False)


def legend_of_endings(figure: Figure) -> None:
    """Explain the colours of the endings under the panels."""
    patches = [Patch(fc=colour, ec=INK, lw=0.6, label=words) for words, colour in ENDS.items()]
    figure.legend(handles=patches, loc="outside lower center", ncols=len(patches))


def told(forces: xr.Dataset, endings: xr.Dataset) -> str:
    """Return the gallery text on run-ups over rate, clearance and friction."""
    part = part_of_steady(forces)
    said = []
    for clearance in CLEARANCES:
        one = part.sel(delta0=clearance)
        rotor = Rotor(omega=FROM, delta0=clearance, **SHAFT)
        steady = steady_force(rotor, TO)
        touched = one.rate.values[one.values > 0.0]
        said.append(
            f"δ₀ = {clearance:g}: {steady:.3g}, 90% of it up to a rate of {rate_at(one, 0.9):.2g}, "
            f"half of it up to {rate_at(one, 0.5):.2g}, no touch above "
            f"{touched.max(initial=0.0):.2g} (by the rule {never_touches_from(rotor):.2g})"
        )
    some = worst(endings)
    whips = some.where(some == 3.0, drop=True)
    slowest = f"up to a rate of {whips.rate.max().item():.2g}" if whips.size else "nowhere"
    return (
        "Largest forces on the exact response, and how they fall with the rate: "
        f"{'; '.join(said)}. With friction run-ups end in dry whip {slowest}."
    )


def draw_machine(forces: xr.Dataset, endings: xr.Dataset, settings: Settings) -> None:
    figure, (left, right) = mixed_panels(1, 2, height=3.8)
    rate = forces.rate_rpm.values
    with style():
        for number, clearance in enumerate(RING):
            colour, dashes = look(number)
            machine = machine_with(clearance, SMOOTH)
            one = forces.largest_force.isel(delta0=number).squeeze()
            left.plot(rate, one.where(one > 0.0), color=colour, ls=dashes,
                      label=f"{1e3 * clearance:g} mm")  # fmt: skip
            left.axhline(steady_in_newtons(machine), color=colour, lw=0.6, ls=dashes)
            left.axvline(never_touches_in_rpm(machine), ymax=0.06, color=colour, lw=2.0)
        left.set(xscale="log", yscale="log", xlabel="rate [rpm/s]", ylim=(1.0, 1e3),
                 ylabel="largest normal force [N]", xlim=(rate.min(), rate.max()))  # fmt: skip
        left.set_title(f"$\\mu$ = {SMOOTH:g}")
        left.legend(loc="lower left")
        draw_endings(right, endings, endings.rate_rpm.values)
        right.set_xlabel("rate [rpm/s]")
        right.set_title(f"clearance {1e3 * RING[1]:g} mm")
        legend_of_endings(figure)
    settings.show(
        figure, "machine", archives=["machine_forces", "machine_endings"],
        shows="The rotor of the scenario drop on its magnetic bearing, run up from 1,000 to 6,000 "
        "rpm through its critical speed of 3,020 rpm: (a) the largest force on the stator over the "
        f"rate with μ = {SMOOTH:g}, for three clearances, that on the exact response (horizontal), "
        "and the rate above which an undamped rotor does not touch (marks on the axis); (b) how "
        "run-ups end over rate and friction.",
        found=told_of_machine(forces, endings),
    )  # fmt: skip


def steady_in_newtons(machine: DimensionalRotor) -> float:
    """Return the largest force on the exact response up to the last speed [N]."""
    to = RUN[1] * RADIANS / machine.reference_frequency
    return steady_force(machine.rotor(), to) * machine.force_scale


def never_touches_in_rpm(machine: DimensionalRotor) -> float:
    """Return the rate above which an undamped rotor does not reach the stator [rpm/s]."""
    return never_touches_from(machine.rotor()) * machine.reference_frequency**2 / RADIANS


def told_of_machine(forces: xr.Dataset, endings: xr.Dataset) -> str:
    """Return the gallery text on the machine in SI units."""
    said = []
    for number, clearance in enumerate(RING):
        machine = machine_with(clearance, SMOOTH)
        one = forces.largest_force.isel(delta0=number).squeeze()
        touched = forces.rate_rpm.values[one.values > 0.0].max(initial=0.0)
        said.append(
            f"a clearance of {1e3 * clearance:g} mm is touched up to {touched:.0f} rpm/s (by the "
            f"rule {never_touches_in_rpm(machine):.0f}), with up to {float(one.max()):.3g} N "
            f"({steady_in_newtons(machine):.3g} N on the exact response)"
        )
    some = worst(endings)
    whips = some.where(some == 3.0, drop=True)
    ends = (
        f"end in dry whip from μ = {whips.friction.min().item():.2g} on, at "
        f"{1e-3 * endings.largest_force.max().item():.0f} kN, which no machine survives"
        if whips.size
        else "end in no dry whip"
    )
    return f"With μ = {SMOOTH:g} {'; '.join(said)}. Run-ups that touch {ends}."


if __name__ == "__main__":
    sys.exit(run_script(main, description=__doc__, script=__file__))
