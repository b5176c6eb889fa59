"""Effects of friction: rubs, Hopf points, and the smallest knock that starts dry whip.

Friction brakes a whirl that rubs on the stator. Its amplitude falls, and past Hopf points it is no
longer circular but swings in contact (zeta = 0.07, delta0 = 0.5, mu = 0, 0.05, 0.1 and 0.2). All
this is exact, and simulated rotors that start near each whirl agree with it. Friction can also
drive a backward whirl until the disc rolls on the stator in dry whip (zeta = 0.1, mu = 0.2,
delta0 = 1, rho = 10). The slipping backward whirl is a saddle that separates knocks that die away
from knocks that lead to whip. Its radius without unbalance is known in closed form. The smallest
knock that starts whip is found by bisection, over the speed and at several angles of the unbalance.
The smaller the unbalance, the closer it is to the saddle.

Writes the exact curves (curves.nc), the ends of simulated rotors (simulated.nc), two knocks
(dies.nc and whips.nc), the smallest knocks (knocks.nc), and the figures as PNG and SVG.
"""

import math
import sys
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import xarray as xr
from matplotlib.axes import Axes

from rotor_ida import Rotor, backward_whirl, hopf_points, simulate, synchronous_response
from rotor_ida.closed_forms import response_curve
from rotor_ida.paper.scenario import Settings, progress_bar, run_script, scientific
from rotor_ida.paper.whip import is_whip
from rotor_ida.plot import mixed_panels, panels, plot_amplitude, plot_orbit, shared_legend, style
from rotor_ida.plot.palette import (
    BLUE,
    BROWN,
    DARK_BROWN,
    DASHES,
    GREY,
    INK,
    ORANGE,
    PURPLE,
    RED,
    SHADE,
)
from rotor_ida.schema import MODE, STABILITY

ZETA, DELTA0, RHO = 0.07, 0.5, 10.0
FRICTIONS = (0.0, 0.05, 0.1, 0.2)
LIMITS = (0.05, 3.0)
LASTS = (300.0, 10_000.0)  # shortest and longest run beside the exact curves
ENDS = {"contact_free": 0, "synchronous": 1, "full_contact": 2, "bouncing": 3, "whip": 4}
LOOKS = {"full_contact": (PURPLE, "in full contact"), "bouncing": (ORANGE, "bouncing"),
         "whip": (RED, "in dry whip")}  # fmt: skip

KNOCKED = {"zeta": 0.1, "friction": 0.2}
OMEGA = 0.62962981  # twice the speed at which whip is born
KNOCKS = {"dies": 5.0, "whips": 5.5}  # speed along the stator, backwards
SHOWN = 100.0
CLEARANCES = (1.0, 30.0)  # over eccentricity
ANGLES = 4  # of the unbalance


def main(settings: Settings) -> None:
    frictions = FRICTIONS[::3] if settings.quick else FRICTIONS
    given = {"zeta": ZETA, "delta0": DELTA0, "friction": list(frictions)}
    curves = xr.merge(
        [response_curve(**given, limits=LIMITS), hopf_points(**given)],
        compat="equals", join="exact", combine_attrs="override",
    )  # fmt: skip
    settings.keep(curves, "curves")
    ends = simulated_ends(np.linspace(0.15, 2.85, 4 if settings.quick else 28), frictions, settings)
    settings.keep(ends, "simulated")
    draw_curves(curves, ends, settings)

    runs = {name: knocked(rotor_at(OMEGA), speed, SHOWN, 4001) for name, speed in KNOCKS.items()}
    for name, run in runs.items():
        runs[name] = with_forces(run)
        settings.keep(runs[name], name)
    draw_knocks(runs, settings)

    smallest = smallest_knocks(
        np.linspace(0.2, 1.6, 3 if settings.quick else 29),
        np.array([0.5]) if settings.quick else np.linspace(0.35, 1.15, 9),
        settings,
    )
    settings.keep(smallest, "knocks")
    draw_smallest(smallest, settings)


def simulated_ends(
    speeds: np.ndarray, frictions: Sequence[float], settings: Settings
) -> xr.Dataset:
    """Return the final response of rotors that start beside each whirl in contact."""
    whirls = synchronous_response(omega=speeds, zeta=ZETA, delta0=DELTA0, friction=list(frictions))
    whirls = whirls.squeeze(["zeta", "delta0"]).transpose("omega", "friction", "branch")
    places = np.argwhere(whirls.in_contact.values == 1)
    table = np.full((*whirls.amplitude.shape, 4), np.nan)
    table[..., 3] = -1.0

    def end_at(place: Sequence[int]) -> tuple[float, float, float, int]:
        whirl = whirls.isel(dict(zip(whirls.amplitude.dims, place, strict=True)))
        run = beside(whirl)
        return *late_radii(run), kind_of_end(run)

    with progress_bar("rubs") as progress, ThreadPoolExecutor(settings.workers) as pool:
        for number, (place, end) in enumerate(
            zip(places, pool.map(end_at, places), strict=True), start=1
        ):
            table[tuple(place)] = end
            progress(number, len(places))
    names = {"radius_mean": "mean", "radius_min": "smallest", "radius_max": "largest"}
    dims = whirls.amplitude.dims
    end = (dims, table[..., 3].astype(np.int8), {
        "long_name": "response at the end, -1 where none was simulated",
        "flag_values": np.array([-1, *ENDS.values()], dtype=np.int8),
        "flag_meanings": " ".join(["not_started", *ENDS]),
    })  # fmt: skip
    return whirls.assign(end=end).assign(
        {
            name: (dims, table[..., column],
                   {"long_name": f"{words} distance from the bearing axis in the last fifth",
                    "units": "1"})
            for column, (name, words) in enumerate(names.items())
        }
    )  # fmt: skip


def beside(whirl: xr.Dataset) -> xr.Dataset:
    """Return the motion of a rotor from 1% beside a synchronous whirl, 10% where it is unstable.

    Its duration follows from the growth rate of the whirl.
    """
    mu, omega = whirl.friction.item(), whirl.omega.item()
    rotor = Rotor(
        omega=omega, zeta=ZETA, delta0=DELTA0, friction=mu, disc_radius=RHO if mu > 0.0 else None
    )
    stable = whirl.stability.item() == STABILITY["stable"]
    off, needed = (1.01, 20.0) if stable else (1.1, 10.0)
    duration = float(np.clip(needed / abs(whirl.growth_rate.item()), *LASTS))
    z = off * whirl.amplitude.item() * np.exp(-1j * whirl.phase_lag.item())
    start = (z.real, z.imag, -omega * z.imag, omega * z.real)
    samples = 5 * math.ceil(duration)
    return simulate(rotor, start=start, duration=duration, samples=samples, method="taylor")


def late_radii(run: xr.Dataset) -> tuple[float, float, float]:
    """Return the mean, smallest and largest radius of the last fifth of a run."""
    late = run.isel(t=slice(4 * run.sizes["t"] // 5, None))
    radius = np.hypot(late.x.values, late.y.values)
    return float(radius.mean()), float(radius.min()), float(radius.max())


def kind_of_end(run: xr.Dataset) -> int:
    mean, smallest, largest = late_radii(run)
    if largest < DELTA0:
        return ENDS["contact_free"]
    if largest - smallest < 1e-6 * mean:
        return ENDS["synchronous"]
    if "friction" in run.variables and is_whip(run):
        return ENDS["whip"]
    return ENDS["full_contact" if smallest > DELTA0 else "bouncing"]


def missed(ends: xr.Dataset) -> tuple[int, float]:
    """Return the count of synchronous ends, and their distance from the nearest stable whirl."""
    stable = ends.amplitude.where((ends.stability == STABILITY["stable"]) & (ends.in_contact == 1))
    nearest = np.abs(stable.rename(branch="other") / ends.radius_mean - 1.0).min("other")
    synchronous = ends.end == ENDS["synchronous"]
    return int(synchronous.sum()), float(nearest.where(synchronous, 0.0).fillna(np.inf).max())


def draw_curves(curves: xr.Dataset, ends: xr.Dataset, settings: Settings) -> None:
    frictions = curves.friction.values
    rows = -(-frictions.size // 2)
    figure, axes = panels(rows, 2, height=1.2 + 2.6 * rows)
    for ax, mu in zip(axes, frictions, strict=True):
        curve, here = curves.sel(friction=mu), ends.sel(friction=mu)
        plot_amplitude(curve, hopf_points=curve, ax=ax)
        with style():
            draw_ends(ax, here)
        ax.set_title(f"$\\mu = {mu:g}$", fontsize=9.5)
        ax.set(xlim=(0.0, LIMITS[1]), ylabel="amplitude $A$, radius $|z|$")
    axes[0].set(yscale="log", ylim=(0.1, 50.0))
    axes[0].set_yticks([0.1, 1.0, 10.0], ["0.1", "1", "10"])
    shared_legend(figure, axes, columns=3)
    settings.show(
        figure, "curves", archives=["curves", "simulated"],
        shows=f"Amplitude over speed at ζ = {ZETA}, δ₀ = {DELTA0:g} and a disc of radius "
        f"{RHO:g} with increasing friction: exact whirls with their Hopf points, and where "
        "rotors end that start 1% off each stable and 10% off each unstable one.",
        found=told_of_curves(curves, ends),
    )  # fmt: skip


def draw_ends(ax: Axes, ends: xr.Dataset) -> None:
    """Draw simulated rotors: whirls as points, all others as ranges of the radius."""
    speeds = np.broadcast_to(ends.omega.values[:, None], ends.end.shape)
    # starts beside several whirls at one speed are drawn side by side
    aside = speeds + 0.02 * ends.branch.values
    chosen = ends.end.values == ENDS["synchronous"]
    ax.plot(speeds[chosen], ends.radius_mean.values[chosen], ls="", marker="o", ms=4.2, color=BLUE,
            mfc="none", mew=1.0, label="simulated, synchronous", zorder=3.0)  # fmt: skip
    for name, (colour, words) in LOOKS.items():
        chosen = ends.end.values == ENDS[name]
        if chosen.any():
            ax.vlines(
                aside[chosen], ends.radius_min.values[chosen], ends.radius_max.values[chosen],
                color=colour, lw=1.6, label=f"simulated, {words}: its range", zorder=2.0,
            )  # fmt: skip


def told_of_curves(curves: xr.Dataset, ends: xr.Dataset) -> str:
    """Return the gallery text on the curves."""
    rows = []
    for mu in curves.friction.values:
        curve = curves.sel(friction=mu)
        hopf = curve.hopf_omega.values[np.isfinite(curve.hopf_omega.values)]
        row = f"{float(curve.amplitude.max()):.2f} with μ = {mu:g}"
        if hopf.size:
            points = " and ".join(f"{each:.4f}" for each in hopf)
            row += f" (Hopf point{'s' * (hopf.size > 1)} at ω = {points})"
        rows.append(row)
    number, worst = missed(ends)
    others = ", ".join(
        f"{int((ends.end == ENDS[name]).sum())} {words}" for name, (_, words) in LOOKS.items()
    )
    return (
        f"The largest amplitude is {', '.join(rows)}. Of {int((ends.end >= 0).sum())} simulated "
        f"rotors {number} end on an exact stable whirl, to {scientific(worst)} of its amplitude. "
        f"Past Hopf points and beside other unstable whirls they end otherwise: {others}."
    )


def rotor_at(omega: float, delta0: float = 1.0) -> Rotor:
    """Return the rotor that is knocked; at any clearance whip is born at the same speed."""
    known = Rotor(omega=omega, delta0=1.0, disc_radius=RHO, **KNOCKED)
    wider = Rotor(omega=omega, delta0=delta0, disc_radius=RHO, **KNOCKED)
    disc_radius = RHO * saddle_of(wider)[0] / saddle_of(known)[0]
    return Rotor(omega=omega, delta0=delta0, disc_radius=disc_radius, **KNOCKED)


def saddle_of(rotor: Rotor) -> tuple[float, float]:
    """Return radius and whirl speed of the saddle, which do not depend on the speed."""
    fast = Rotor(**(rotor.given | {"omega": 1e3}))
    slipping = backward_whirl(fast).isel(whirl=0)
    return slipping.amplitude.item(), slipping.whirl_speed.item()


def knocked(rotor: Rotor, speed: float, duration: float, samples: int) -> xr.Dataset:
    """Return the motion of a rotor that touches the stator and is knocked backwards along it."""
    return simulate(
        rotor, start=(rotor.delta0, 0.0, 0.0, -speed), duration=duration, samples=samples,
        method="taylor",
    )  # fmt: skip


def whirling(rotor: Rotor, radius: float, angle: float, duration: float) -> xr.Dataset:
    """Return the motion from a backward whirl as fast as the saddle, at an angle of the unbalance.

    The unbalance begins along x, so the start is rotated instead.
    """
    z = radius * np.exp(1j * angle)
    v = 1j * saddle_of(rotor)[1] * z
    return simulate(
        rotor, start=(z.real, z.imag, v.real, v.imag), duration=duration, samples=301,
        method="taylor",
    )  # fmt: skip


def with_forces(run: xr.Dataset) -> xr.Dataset:
    """Return a run with its whirl speed, friction force and largest static friction force."""
    names = ("omega", "zeta", "delta0", "friction", "disc_radius")
    rotor = Rotor(**{name: run[name].item() for name in names})
    radius = np.hypot(run.x, run.y)
    radial = (run.x * run.vx + run.y * run.vy) / radius
    surface = rotor.disc_radius * rotor.omega
    holding = rotor.omega**2 * np.sin(rotor.omega * run.t - np.arctan2(run.y, run.x))
    holding = holding + surface * (2.0 * rotor.zeta + radial / radius)
    limit = rotor.friction * run.normal_force
    sliding = limit * np.sign(run.slip_speed)
    columns = {
        "whirl_speed": (
            (run.x * run.vy - run.y * run.vx) / radius**2, "whirl speed, negative backwards"),
        "holding_force": (
            xr.where(run["mode"] == MODE["rolling"], holding, sliding), "tangential contact force"),
        "force_limit": (limit, "largest tangential force of static friction"),
    }  # fmt: skip
    return run.assign(
        {
            name: ("t", values.values, {"long_name": words, "units": "1"})
            for name, (values, words) in columns.items()
        }
    )


def smallest(starts_whip: Callable[[float], bool], tries: np.ndarray, near: float) -> float:
    """Return the smallest knock that starts whip, by bisection below the first that does.

    It is 0 if the smallest knock tried does, and NaN if none does.
    """
    below = None
    for above in tries.tolist():
        if starts_whip(above):
            break
        below = above
    else:
        return math.nan
    if below is None:
        return 0.0 if above == 0.0 else math.nan
    while above - below > near * above:
        middle = 0.5 * (above + below)
        below, above = (below, middle) if starts_whip(middle) else (middle, above)
    return float(above)


def smallest_speed(omega: float) -> float:
    """Return the smallest backward speed along the stator that leads to whip."""
    rotor = rotor_at(omega)
    return smallest(
        lambda speed: is_whip(knocked(rotor, speed, 250.0, 301)), np.linspace(0.0, 12.0, 13), 2e-3
    )


def smallest_radius(omega: float, delta0: float, angle: float, *, near: float = 1e-3) -> float:
    """Return the smallest radius, over that of the saddle, that leads to whip."""
    rotor = rotor_at(omega, delta0)
    saddle = saddle_of(rotor)[0]
    return smallest(
        lambda factor: is_whip(whirling(rotor, factor * saddle, angle, 250.0)),
        np.array([0.0, 0.4, 0.7, 1.0, 1.4, 2.0]), near,
    )  # fmt: skip


def smallest_knocks(speeds: np.ndarray, sparse: np.ndarray, settings: Settings) -> xr.Dataset:
    """Return the smallest knocks over the speed, beside the exact saddle."""
    angles = np.arange(ANGLES) * 2.0 * math.pi / ANGLES
    places = [(omega, delta0, angle) for omega in sparse for delta0 in CLEARANCES
              for angle in angles]  # fmt: skip
    with (
        progress_bar("smallest knocks") as progress,
        ThreadPoolExecutor(settings.workers) as pool,
    ):
        number, found = speeds.size + len(places), []
        for work in (pool.map(smallest_speed, speeds),
                     pool.map(lambda place: smallest_radius(*place), places)):  # fmt: skip
            for value in work:
                found.append(value)
                progress(len(found), number)
    radii = np.reshape(found[speeds.size :], (sparse.size, len(CLEARANCES), ANGLES))
    dims = ("sparse_omega", "clearance", "angle")
    words = {
        "knock_speed": ("omega", found[: speeds.size], "smallest knock that starts whip"),
        "radius_ratio": (dims, radii, "smallest radius that starts whip over that of the saddle"),
        "birth_omega": ((), backward_whirl(rotor_at(OMEGA)).birth_omega.item(),
                        "speed from which whip exists without unbalance"),
    }  # fmt: skip
    coordinates = {
        "omega": (speeds, "spin speed over the reference frequency"),
        "sparse_omega": (sparse, "spin speed at which radii are sought"),
        "clearance": (list(CLEARANCES), "radial clearance over eccentricity"),
        "angle": (angles, "angle from the unbalance to the start"),
    }
    return xr.Dataset(
        {name: (dims, values, {"long_name": text, "units": "1"})
         for name, (dims, values, text) in words.items()},
        {name: (name, values, {"long_name": text, "units": "1"})
         for name, (values, text) in coordinates.items()},
        {"title": "Smallest knocks that start dry whip"} | KNOCKED,
    )  # fmt: skip


def draw_knocks(runs: dict[str, xr.Dataset], settings: Settings) -> None:
    figure, axes = mixed_panels(4, 2, height=10.6)
    grid = axes[0].get_gridspec()
    if grid is not None:
        grid.set_height_ratios([1.7, 1.0, 1.0, 1.0])
    whip = backward_whirl(rotor_at(OMEGA))
    for column, (name, run) in enumerate(runs.items()):
        orbit, speed, slip, force = axes[column::2]
        plot_orbit(run, ax=orbit)
        orbit.set_title(f"knock {KNOCKS[name]:g}: {'whip' if name == 'whips' else 'dies away'}",
                        fontsize=9.5)  # fmt: skip
        orbit.set_aspect("equal", adjustable="box")
        orbit.set(xlim=(-5.6, 5.6), ylim=(-5.6, 5.6))
        with style():
            speed.plot(run.t, run.whirl_speed, color=INK, lw=0.8, label="simulated")
            for value, words, look in zip(
                whip.whirl_speed.values, ("slipping whirl (exact)", "whip (exact)"),
                ((BROWN, DASHES), (BLUE, (0, (1.2, 1.4)))), strict=True,
            ):  # fmt: skip
                speed.axhline(value, color=look[0], ls=look[1], label=words)
            speed.set(ylabel="whirl speed $\\varphi$′", ylim=(-5.0, 2.0))
            slip.plot(run.t, run.slip_speed, color=INK, lw=0.8, label="simulated")
            slip.set(ylabel="slip speed $v_s$", ylim=(-0.5, 9.5))
            force.fill_between(run.t, -run.force_limit, run.force_limit, color=SHADE, lw=0.0,
                               label="limit of friction")  # fmt: skip
            force.plot(run.t, run.holding_force, color=INK, lw=0.8, label="simulated")
            force.set(ylabel="tangential force $T$", ylim=(-2.2, 2.2))
            for ax in (speed, slip, force):
                ax.set(xlabel="time $t$", xlim=(0.0, SHOWN))
            draw_rolls(run, ((slip, run.slip_speed), (force, run.holding_force)))
    shared_legend(figure, axes, columns=5, outer=False)
    settings.show(
        figure, "knocks", archives=list(runs),
        shows="A rotor that touches the stator is knocked backwards along it (ζ = 0.1, μ = 0.2, "
        f"δ₀ = 1, ρ = 10, ω = {OMEGA:.4f}), by too little for whip and by enough: orbit, whirl "
        "speed, slip speed, and the friction force within its limits.",
        found=told_of_knocks(runs, whip),
    )  # fmt: skip


def draw_rolls(run: xr.Dataset, rows: Sequence[tuple[Axes, xr.DataArray]]) -> None:
    """Mark each start and end of rolling; the force jumps where the disc begins to roll."""
    for kind, face, words in ((2, DARK_BROWN, "roll"), (-2, "white", "slip")):
        times = run.event_time.values[run.event_kind.values == kind]
        for ax, values in rows:
            after = values.values[np.searchsorted(run.t.values, times)]
            ax.plot(times, after, ls="", marker="o", ms=3.0, mec=DARK_BROWN, mfc=face, mew=0.6,
                    label=words, zorder=3.0)  # fmt: skip


def told_of_knocks(runs: dict[str, xr.Dataset], whip: xr.Dataset) -> str:
    """Return the gallery text on both knocks."""
    dies, whips = runs.values()
    kinds = whips.event_kind.values
    leaves = dies.event_time.values[(dies.event_kind.values == -1) & (dies.event_time > 20.0)][0]
    first = whips.event_time.values[kinds == 2][0]
    late = whips.isel(t=whips.t.values > first)
    slow, fast = (float(each) for each in (late.whirl_speed.max(), late.whirl_speed.min()))
    share = float((late["mode"] == MODE["rolling"]).mean())
    return (
        f"After the knock of {KNOCKS['dies']:g} the rotor whirls backwards, more and more slowly, "
        f"until it leaves the stator at t = {leaves:.1f}. The whirl after one of "
        f"{KNOCKS['whips']:g} grows: at t = {first:.1f} the disc begins to roll, and from then on "
        f"it rolls and slips by turns ({int((kinds == 2).sum())} times up to t = {SHOWN:g}), as "
        f"the unbalance pulls one way and the other, and rolls {100.0 * share:.0f}% of the time. "
        f"It then whirls at −{-fast:.3f} to −{-slow:.3f}, where whip without unbalance has exactly "
        f"−{-whip.whirl_speed.values[1]:.6f}, against ω = {OMEGA:.3f} of the spin."
    )


def draw_smallest(found: xr.Dataset, settings: Settings) -> None:
    figure, (speeds, radii) = mixed_panels(1, 2, height=3.5)
    birth = found.birth_omega.item()
    with style():
        speeds.plot(found.omega, found.knock_speed, color=RED, marker="o", ms=3.2, lw=0.9,
                    label="smallest knock")  # fmt: skip
        speeds.set(xlabel=r"spin speed $\omega$", ylabel="speed along the stator, backwards",
                   ylim=(0.0, None), xlim=(0.0, float(found.omega.max())))  # fmt: skip
        speeds.set_title("smallest knock that starts whip", fontsize=9.5)
        radii.axhline(1.0, color=INK, lw=1.2, label="saddle, exact without unbalance")
        for delta0, colour, marker in zip(CLEARANCES, (ORANGE, BLUE), ("s", "o"), strict=True):
            here = found.radius_ratio.sel(clearance=delta0)
            radii.plot(
                np.repeat(found.sparse_omega.values, ANGLES), here.values.ravel(), ls="",
                marker=marker, ms=3.8, mfc="none", mew=0.9, color=colour,
                label=f"simulated, $\\delta_0$ = {delta0:g}",
            )  # fmt: skip
        radii.set(xlabel=r"spin speed $\omega$", ylabel="smallest radius / saddle's $r_w$",
                  xlim=(0.0, 1.2), ylim=(0.0, 1.15))  # fmt: skip
        radii.set_title("smallest whirl at the saddle's speed", fontsize=9.5)
        for ax in (speeds, radii):
            ax.axvspan(0.0, birth, color=GREY, alpha=0.3, lw=0.0, label="no whip exists (exact)")
    shared_legend(figure, [speeds, radii], columns=3, outer=False)
    settings.show(
        figure, "smallest", archives=["knocks"],
        shows="The smallest knock along the stator that leads to whip (ζ = 0.1, "
        "μ = 0.2, δ₀ = 1), over the speed, and the smallest radius of a backward whirl as fast as "
        "the saddle, beside its exact radius, at four angles of the unbalance and two clearances.",
        found=told_of_smallest(found),
    )  # fmt: skip


def told_of_smallest(found: xr.Dataset) -> str:
    """Return the gallery text on the smallest knocks."""
    reached = found.omega.values[found.knock_speed.notnull()]
    radius, speed = saddle_of(rotor_at(OMEGA))
    spread = {
        delta0: float(np.abs(found.radius_ratio.sel(clearance=delta0) - 1.0).max())
        for delta0 in CLEARANCES
    }
    least = found.isel(omega=int(np.nanargmin(found.knock_speed.values)))
    return (
        f"Whip exists from ω = {found.birth_omega.item():.6f} on (exact); of the speeds tried the "
        f"first at which a knock starts it is {reached.min():.2f}. The least knock is "
        f"{least.knock_speed.item():.2f}, at ω = {least.omega.item():.2f}. The saddle has the "
        f"radius {radius:.6f} and the whirl speed −{-speed:.6f} at any speed of the spin. With a "
        f"clearance of one eccentricity the smallest whirl lies up to "
        f"{100.0 * spread[CLEARANCES[0]]:.0f}% off that radius, depending on the angle of the "
        f"unbalance; with {CLEARANCES[1]:g} eccentricities up to "
        f"{100.0 * spread[CLEARANCES[1]]:.1f}%."
    )


if __name__ == "__main__":
    sys.exit(run_script(main, description=__doc__, script=__file__))
