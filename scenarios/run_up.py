"""Run-ups, run-downs and a drive of limited power beside exact results.

In flight the motion at a constant acceleration is given by error functions. Without damping the
largest amplitude through resonance tends to Lewis' value as the rate falls. In contact a run-up
follows the exact whirl to its fold and jumps late: at the rate a by
2.33811 a^(2/3)/|alpha b|^(1/3), with coefficients from the exact response. The remainder,
a (K ln(1/a) + C), is known up to one constant. Run-ups and run-downs therefore leave a hysteresis
about the exact folds, which widens with the rate. A drive of limited power, whose torque falls with
the speed, settles where its line meets the stable parts of Sommerfeld's curve. With more torque the
speed rises little until the whirl is lost, and then it jumps.

Writes flights through resonance (flight.nc, resonance.nc), late jumps (late.nc), run-ups and
run-downs beside the exact response (hysteresis.nc, response.nc), Sommerfeld's curve and the speeds
at which drives settle (curve.nc, settled.nc), and the figures as PNG and SVG.
"""

import math
import sys
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from typing import Any

import numpy as np
import xarray as xr
from matplotlib.axes import Axes

from rotor_ida import Rotor, folds, run_up, synchronous_response
from rotor_ida.closed_forms import (
    late_jumps,
    ramp_flight,
    response_curve,
    sommerfeld_curve,
    whirl_torque,
)
from rotor_ida.paper.scenario import Settings, progress_bar, run_script, scientific
from rotor_ida.plot import mixed_panels, panels, plot_amplitude, shared_legend, style
from rotor_ida.plot.palette import BLUE, DASHES, GREY, INK, LOOKS, RED
from rotor_ida.schema import STABILITY

METHOD = "taylor"
Parameters = dict[str, float]

# Through resonance, without contact.
SHAFT = {"delta0": 1e3, "shaft_stiffness": 1.0}
DAMPED, AT_RATES = 0.02, (0.02, -0.02, 0.005)
LEWIS = {"height": 1.46720, "place": 2.15742}

# Machines, the fold that is passed, and the definition of the jump.
JUMPS: dict[str, tuple[Parameters, int]] = {
    "up, off the large whirl": ({"zeta": 0.1, "delta0": 1.0}, 1),
    "up, with friction 0.05": (
        {"zeta": 0.1, "delta0": 1.0, "friction": 0.05, "disc_radius": 10.0}, 1,
    ),
    "down, to the larger whirl": ({"zeta": 0.07, "delta0": 0.5}, 2),
}  # fmt: skip
WIDTHS = 15.0  # of the passage before the fold, in which a run begins

RUB = {"zeta": 0.07, "delta0": 0.5}
RATES = (1e-2, 1e-3, 1e-4)
LIMITS = (0.05, 3.0)
SAMPLES_A_REVOLUTION = 32

MOTOR = {"slope": 0.5, "inertia": 5.0}
DRIVEN = {"zeta": 0.2, "delta0": 0.5, "friction": 0.05, "disc_radius": 5.0}
SETTLES = 600.0


def main(settings: Settings) -> None:
    flown = flights(settings)
    settings.keep(flown, "flight")
    passed = through_resonance(settings)
    settings.keep(passed, "resonance")
    draw_flights(flown, passed, settings)
    late = jumps(settings)
    settings.keep(late, "late")
    draw_jumps(late, settings)
    courses = hysteresis(settings)
    settings.keep(courses, "hysteresis")
    draw_hysteresis(courses, settings)
    settled = settled_speeds(settings)
    settings.keep(settled, "settled")
    draw_sommerfeld(settled, settings)


def column(dims: Any, values: Any, words: str) -> tuple[Any, Any, dict[str, str]]:
    """Return a variable with its name in words."""
    return dims, values, {"long_name": words, "units": "1"}


def side_by_side(
    words: str, work: Callable[..., Any], places: Sequence[Any], settings: Settings
) -> list[Any]:
    """Return the result at every place, with a progress bar."""
    found = []
    with progress_bar(words) as progress, ThreadPoolExecutor(settings.workers) as pool:
        for number, each in enumerate(pool.map(lambda place: work(*place), places), start=1):
            found.append(each)
            progress(number, len(places))
    return found


# ---- Through resonance, without contact ----


def flights(settings: Settings) -> xr.Dataset:
    """Return run-ups and run-downs through resonance, simulated and by error functions."""
    size = 201 if settings.quick else 801
    rates = AT_RATES[:2] if settings.quick else AT_RATES
    table = np.empty((len(rates), 3, size))
    for number, rate in enumerate(rates):
        omega, to = (0.4, 1.6) if rate > 0.0 else (1.6, 0.4)
        rotor = Rotor(omega=omega, zeta=DAMPED, **SHAFT)
        z = omega**2 / (SHAFT["shaft_stiffness"] - omega**2 + 2j * DAMPED * omega)
        start = (z.real, z.imag, -omega * z.imag, omega * z.real)
        run = run_up(
            rotor, start=start, to=to, rate=rate, samples=size, method=METHOD,
            rtol=1e-12, atol=1e-14,
        )  # fmt: skip
        exact = ramp_flight(run.t.values, rotor=rotor, start=start, rate=rate)
        off = np.hypot(run.x.values - exact[0], run.y.values - exact[1])
        table[number] = run.speed.values, np.hypot(*exact[:2]), off
    names = {"speed": "spin speed", "radius": "exact distance from the bearing axis",
             "deviation": "distance between simulated and exact position"}  # fmt: skip
    return xr.Dataset(
        {
            name: column(("rate", "sample"), table[:, place], words)
            for place, (name, words) in enumerate(names.items())
        },
        {"rate": column("rate", list(rates), "change of the spin speed in a unit of time")},
        {"title": "Flights on ramps of the speed through resonance"},
    )


def through_resonance(settings: Settings) -> xr.Dataset:
    """Return the largest radius without damping and the speed there, over the rate."""
    rates = np.array([4e-3, 1e-3]) if settings.quick else np.geomspace(1e-2, 1e-5, 13)
    found = np.array([highest_of(rate) for rate in rates])
    root = np.sqrt(rates)
    return xr.Dataset(
        {
            "height": column("rate", found[:, 0] * root, "largest radius times root of the rate"),
            "place": column("rate", (found[:, 1] - 1.0) / root,
                            "speed there less 1, over the root of the rate"),
        },
        {"rate": column("rate", rates, "change of the spin speed in a unit of time")},
        {"title": "Largest radius on the way through resonance, without damping"},
    )  # fmt: skip


def highest_of(rate: float) -> tuple[float, float]:
    """Return the largest radius of an undamped run-up, by error functions, and the speed there.

    It begins on the whirl far below resonance. Ripples at twice the speed are smoothed.
    """
    root = math.sqrt(rate)
    begin = max(1.0 - 30.0 * root, 0.3)
    whirl = begin**2 / (1.0 - begin**2)
    speed = np.linspace(1.0 + 1.5 * root, 1.0 + 2.8 * root, 4001)
    rotor = Rotor(omega=begin, zeta=0.0, **SHAFT)
    times = (speed - begin) / rate
    x, y = ramp_flight(times, rotor=rotor, start=(whirl, 0.0, 0.0, begin * whirl), rate=rate)[:2]
    curve = np.polynomial.Polynomial.fit(speed, np.hypot(x, y), 8)
    tops = [each.real for each in curve.deriv().roots() if abs(each.imag) < 1e-9]
    place = max((each for each in tops if speed[0] < each < speed[-1]), key=curve)
    return float(curve(place)), float(place)


def draw_flights(flown: xr.Dataset, passed: xr.Dataset, settings: Settings) -> None:
    figure, (motion, error, height, place) = mixed_panels(2, 2, height=6.2)
    root = np.sqrt(passed.rate.values)
    with style():
        for (colour, dashes), rate in zip(LOOKS, flown.rate.values, strict=False):
            here, words = flown.sel(rate=rate), "up" if rate > 0.0 else "down"
            label = f"{words} at a rate of {abs(rate):g}"
            motion.plot(here.speed, here.radius, color=colour, ls=dashes, lw=1.1, label=label)
            error.plot(here.speed, here.deviation.where(here.deviation > 0.0), color=colour,
                       ls=dashes, lw=0.9)  # fmt: skip
        for ax, name, words in (
            (height, "height", "largest $|z|\\,\\sqrt{a}$"),
            (place, "place", "$(\\omega - 1)/\\sqrt{a}$ there"),
        ):
            ax.plot(root, passed[name], ls="", marker="o", ms=4.0, mfc="none", mec=BLUE,
                    label="undamped run-up, by error functions")  # fmt: skip
            ax.axhline(LEWIS[name], color=INK, lw=0.9, ls=DASHES, label="Lewis' limit")
            ax.set(xlabel="root of the rate $\\sqrt{a}$", ylabel=words, xlim=(0.0, None))
        motion.set(xlabel="speed $\\omega$", ylabel="radius $|z|$, exact")
        error.set(xlabel="speed $\\omega$", ylabel="simulated less exact", yscale="log")
    shared_legend(figure, (motion, error, height, place), columns=3, outer=False)
    worst, (least, *_) = float(flown.deviation.max()), np.sort(passed.rate.values)
    last = passed.sel(rate=least)
    settings.show(
        figure, "flight", archives=["flight", "resonance"],
        shows=f"A rotor on a shaft (κ = 1, ζ = {DAMPED}) through resonance without contact: the "
        "radius over the speed by error functions, and the error of the simulated one; without "
        "damping the largest radius and its speed, over the rate.",
        found=f"Simulated run-ups and run-downs lie on the error functions to {scientific(worst)}. "
        f"Without damping the largest radius times √a tends to Lewis' 1.46720 (at a = "
        f"{scientific(float(least))} it is {last.height.item():.5f}) and its speed to 1 + 2.15742 "
        f"√a ({last.place.item():.5f}): the difference falls as √a, or faster.",
    )  # fmt: skip


# ---- Late jumps ----


def jumps(settings: Settings) -> xr.Dataset:
    """Return the speeds at which slow run-ups and run-downs jump, and the asymptotic law."""
    rates = np.geomspace(1e-3, 1e-5, 3) if settings.quick else np.geomspace(1e-3, 1e-8, 11)
    laws = [law_of(machine, fold, rates) for machine, fold in JUMPS.values()]
    places = [(name, rate) for name in JUMPS for rate in rates.tolist()]
    found = np.reshape(side_by_side("late jumps", jump_speed, places, settings), (-1, rates.size))
    table = xr.concat(laws, "case", join="exact", coords="minimal", compat="override")
    return xr.Dataset(
        {
            "found_omega": column(("case", "rate"), found, "speed at which the rotor jumps"),
            "law_omega": column(("case", "rate"), table.jump_omega.values, "the same by the law"),
            **{
                name: column("case", table[name].values, table[name].attrs["long_name"])
                for name in ("fold_drift", "fold_curvature", "fold_remainder")
            },
            "passed_omega": column("case", table.fold_omega.values, "exact speed of the fold"),
        },
        {
            "case": ("case", list(JUMPS), {"long_name": "fold that is passed"}),
            "rate": column("rate", rates, "change of the spin speed in a unit of time"),
        },
        {"title": "Late jumps of run-ups and run-downs at exact folds"},
    )


def law_of(machine: Parameters, fold: int, rate: Any) -> xr.Dataset:
    """Return the exact data of one fold."""
    given = {name: value for name, value in machine.items() if name != "disc_radius"}
    found = late_jumps(rate=rate, **given).isel(zeta=0, delta0=0, fold=fold, drop=True)
    return found.drop_vars("friction", errors="ignore").transpose(
        ..., "rate", missing_dims="ignore"
    )


def jump_speed(name: str, rate: float) -> float:
    """Return the jump speed of a run that begins on the exact whirl before the fold.

    A jump is where the radius has fallen to half of that at the fold, or grown by half.
    """
    machine, fold = JUMPS[name]
    law = law_of(machine, fold, rate)
    way, omega_fold = law.fold_passage.item(), law.fold_omega.item()
    width = rate ** (2 / 3) / abs(law.fold_drift * law.fold_curvature).item() ** (1 / 3)
    begin = max(omega_fold - way * WIDTHS * width, 0.3 * omega_fold)
    to = law.jump_omega.item() + way * (2.0 * width + 60.0 * rate)
    start = whirl_near(machine, begin, law.fold_amplitude.item())
    last = abs(to - begin) / rate
    run = run_up(
        Rotor(omega=begin, **machine), start=start, to=to, rate=way * rate, method=METHOD,
        samples=np.linspace(abs(omega_fold - begin) / rate, last, 20_001), rtol=1e-10,
    )  # fmt: skip
    grown = -way  # the large whirl is lost going up, the small one going down
    radius = np.hypot(run.x.values, run.y.values) / law.fold_amplitude.item()
    beyond = grown * (radius - 1.0) - 0.5
    after = int(np.argmax(beyond > 0.0))
    if after == 0:
        return math.nan
    share = beyond[after - 1] / (beyond[after - 1] - beyond[after])
    before, behind = run.speed.values[after - 1 : after + 1]
    return float(before + share * (behind - before))


def whirl_near(machine: Parameters, omega: float, amplitude: float) -> tuple[float, ...]:
    """Return the state on the stable whirl in contact whose amplitude is nearest to one."""
    given = {name: value for name, value in machine.items() if name != "disc_radius"}
    whirls = synchronous_response(omega=omega, **given).isel(omega=0, zeta=0, delta0=0)
    stable = (whirls.stability == STABILITY["stable"]) & (whirls.in_contact == 1)
    off = np.where(stable, np.abs(whirls.amplitude - amplitude), np.inf)
    whirl = whirls.isel(branch=int(off.argmin()))
    z = whirl.amplitude.item() * np.exp(-1j * whirl.phase_lag.item())
    return z.real, z.imag, -omega * z.imag, omega * z.real


def draw_jumps(late: xr.Dataset, settings: Settings) -> None:
    figure, (delay, rest) = mixed_panels(1, 2, height=3.6)
    rates = late.rate.values
    with style():
        for (colour, dashes), name in zip(LOOKS, late.case.values, strict=False):
            here = late.sel(case=name)
            found, law = (np.abs(here[each] - here.passed_omega) for each in
                          ("found_omega", "law_omega"))  # fmt: skip
            delay.plot(rates, law, color=colour, ls=dashes, lw=1.0)
            left = (found - law) / rates
            marks = {"ls": "", "marker": "o", "ms": 4.0, "mfc": "none", "mec": colour}
            delay.plot(rates, found, **marks)
            rest.plot(rates, left, **marks)
            slope = here.fold_remainder.item()
            rest.plot(rates, left[-1].item() + slope * np.log(rates[-1] / rates), color=colour,
                      ls=dashes, lw=1.0)  # fmt: skip
            delay.plot([], [], color=colour, ls=dashes, marker="o", ms=4.0, mfc="none", mec=colour,
                       label=str(name))  # fmt: skip
        delay.set(xlabel="rate $a$", ylabel="jump less fold, in speed", xscale="log", yscale="log")
        delay.set_title("lines: the law", fontsize=9.5)
        rest.set(xlabel="rate $a$", ylabel="remainder of the law over $a$", xscale="log")
        rest.set_title("lines: the slope is known, $K\\,\\ln(1/a)$", fontsize=9.5)
    shared_legend(figure, (delay, rest), columns=3, outer=False)
    shares = np.abs((late.found_omega - late.law_omega) / (late.law_omega - late.passed_omega))
    least = shares.isel(rate=-1)
    decades = math.log10(rates[0] / rates[-1])
    settings.show(
        figure, "late", archives=["late"],
        shows="How late run-ups and run-downs jump that begin on the exact whirl before a fold: "
        "beside the law 2.33811 a²ᐟ³/|αb|¹ᐟ³, and the remainder, over the rate a. A jump "
        "is where the radius has fallen by half, or grown by half.",
        found=f"Over {decades:.0f} decade{'s' * (decades > 1.5)} the jumps follow the law; at the "
        f"slowest rate they miss it by {', '.join(f'{100 * each:.1f}%' for each in least.values)} "
        f"of itself ({'; '.join(map(str, late.case.values))}). The remainder over the rate is a "
        "straight line over ln a, with the slope from the exact response: it falls faster than "
        "the law.",
    )  # fmt: skip


# ---- Hysteresis ----


def hysteresis(settings: Settings) -> xr.Dataset:
    """Return the largest and smallest radius of run-ups and run-downs, over the speed."""
    rates = RATES[:1] if settings.quick else RATES
    edges = np.linspace(*LIMITS, 60 if settings.quick else 296)
    places = [(rate, way, edges) for rate in rates for way in (1, -1)]
    found = np.array(side_by_side("up and down", course_of, places, settings))
    found = found.reshape(len(rates), 2, 2, edges.size - 1)
    dims = ("rate", "way", "speed")
    return xr.Dataset(
        {
            "radius_min": column(dims, found[:, :, 0], "smallest distance from the bearing axis"),
            "radius_max": column(dims, found[:, :, 1], "largest distance from the bearing axis"),
        },
        {
            "rate": column("rate", list(rates), "change of the spin speed in a unit of time"),
            "way": column("way", [1, -1], "1 up, -1 down"),
            "speed": column("speed", 0.5 * (edges[1:] + edges[:-1]), "spin speed"),
        },
        {"title": "Radius on run-ups from rest and on run-downs, over the speed"},
    )


def course_of(rate: float, way: int, edges: np.ndarray) -> np.ndarray:
    """Return the smallest and the largest radius between edges of the speed, shape (2, n)."""
    low, high = edges[[0, -1]]
    begin, to = (low, high) if way > 0 else (high, low)
    turns = 0.5 * (low + high) * (high - low) / rate / (2.0 * math.pi)
    start = (0.0, 0.0, 0.0, 0.0) if way > 0 else whirl_near(RUB, begin, 0.0)
    run = run_up(
        Rotor(omega=begin, **RUB), start=start, to=to, rate=way * rate, method=METHOD,
        samples=2 * math.ceil(turns * SAMPLES_A_REVOLUTION), rtol=1e-8,
    )  # fmt: skip
    radius = np.hypot(run.x.values, run.y.values)
    place = np.clip(np.searchsorted(edges, run.speed.values) - 1, 0, edges.size - 2)
    found = np.full((2, edges.size - 1), np.nan)
    for row, choose in enumerate((np.fmin, np.fmax)):
        choose.at(found[row], place, radius)
    return found


def draw_hysteresis(courses: xr.Dataset, settings: Settings) -> None:
    exact = xr.merge(
        [response_curve(**RUB, limits=LIMITS), folds(**RUB)],
        compat="equals", join="exact", combine_attrs="override",
    )  # fmt: skip
    settings.keep(exact, "response")
    curve = exact.isel(zeta=0, delta0=0)
    rows = courses.sizes["rate"]
    figure, axes = panels(rows, 1, height=1.2 + 2.5 * rows)
    for ax, rate in zip(axes, courses.rate.values, strict=True):
        plot_amplitude(curve, fold_points=curve, ax=ax)
        with style():
            for way, colour, words in ((1, RED, "run-up from rest"), (-1, BLUE, "run-down")):
                here = courses.sel(rate=rate, way=way)
                ax.fill_between(here.speed, here.radius_min, here.radius_max, color=colour,
                                alpha=0.25, lw=0.0, step="mid")  # fmt: skip
                ax.plot(here.speed, here.radius_max, color=colour, lw=1.0,
                        label=f"{words}: largest radius, range")  # fmt: skip
        ax.set_title(f"rate {rate:g}", fontsize=9.5)
        ax.set(xlim=(0.0, LIMITS[1]), ylabel="amplitude $A$, radius $|z|$")
    shared_legend(figure, axes, columns=3)
    settings.show(
        figure, "hysteresis", archives=["hysteresis", "response"],
        shows=f"Run-ups from rest and run-downs at ζ = {RUB['zeta']}, δ₀ = {RUB['delta0']:g} at "
        "different rates: the range of the radius over the speed, beside every exact whirl with "
        "its folds.",
        found=told_of_hysteresis(courses, curve),
    )  # fmt: skip


def told_of_hysteresis(courses: xr.Dataset, curve: xr.Dataset) -> str:
    """Return the jumps of run-ups and run-downs and the folds, in words."""
    speeds = curve.fold_omega.values[np.isfinite(curve.fold_omega.values)]
    rows = []
    for rate in courses.rate.values:
        falls, rises = (jump_of(courses.sel(rate=rate, way=way)) for way in (1, -1))
        rows.append(f"at the rate {scientific(float(rate))} at ω = {falls:.2f} and {rises:.2f}")
    return (
        f"The folds between which the response is hysteretic lie at ω = {speeds[-1]:.4f}, where "
        f"the large whirl ends, and {speeds[-2]:.4f}, where the small one does. A run-up falls off "
        f"the large whirl, and a run-down rises to it, {'; '.join(rows)}."
    )


def jump_of(course: xr.Dataset) -> float:
    """Return the highest speed at which the radius exceeds half of its largest."""
    large = course.radius_max.values > 0.5 * np.nanmax(course.radius_max.values)
    places = course.speed.values[large]
    return float(places.max())


# ---- Limited power ----


def settled_speeds(settings: Settings) -> xr.Dataset:
    """Return the settled speeds of a drive as its torque rises step by step, then falls."""
    up = np.linspace(1.0, 4.6, 4 if settings.quick else 19)
    torques = np.concatenate([up, up[-2::-1]])
    rows, state, omega = [], None, 0.5
    with progress_bar("limited power") as progress:
        for number, tau0 in enumerate(torques.tolist(), start=1):
            start = whirl_near(DRIVEN, omega, 1.0) if state is None else state
            run = run_up(
                Rotor(omega=omega, **DRIVEN), start=start, torque=(tau0, MOTOR["slope"]),
                inertia=MOTOR["inertia"], duration=SETTLES, samples=2, method=METHOD, rtol=1e-11,
                atol=1e-13,
            )  # fmt: skip
            state, omega = turned_back(run), float(run.speed.values[-1])
            rows.append(
                (omega, math.hypot(*state[:2]), missed(tau0, omega, math.hypot(*state[:2])))
            )
            progress(number, torques.size)
    table = np.array(rows)
    words = (
        "spin speed at which the drive settles",
        "radius of the whirl there",
        "torque of the drive less that of Sommerfeld's curve, the same speed and amplitude",
    )
    return xr.Dataset(
        {
            name: column("step", table[:, place], words[place])
            for place, name in enumerate(("speed", "radius", "missed_torque"))
        } | {"tau0": column("step", torques, "torque of the drive at rest")},
        {"step": column("step", np.arange(torques.size), "number of the step of the torque")},
        {"title": "Speeds at which a drive of limited power settles"},
    )  # fmt: skip


def turned_back(run: xr.Dataset) -> tuple[float, ...]:
    """Return the end of a run, rotated so that the unbalance points along x."""
    back = np.exp(-1j * run.angle.values[-1])
    z = complex(run.x.values[-1], run.y.values[-1]) * back
    v = complex(run.vx.values[-1], run.vy.values[-1]) * back
    return z.real, z.imag, v.real, v.imag


def missed(tau0: float, omega: float, radius: float) -> float:
    """Return the torque of a settled drive less that of the exact whirl at its speed."""
    given = {name: value for name, value in DRIVEN.items() if name != "disc_radius"}
    amplitudes = synchronous_response(omega=omega, **given).amplitude.values.ravel()
    exact = amplitudes[np.nanargmin(np.abs(amplitudes - radius))]
    law = whirl_torque(exact, omega=omega, **DRIVEN)
    return float(tau0 - MOTOR["slope"] * omega - law)


def draw_sommerfeld(settled: xr.Dataset, settings: Settings) -> None:
    curve = sommerfeld_curve(**DRIVEN, **MOTOR, limits=(0.1, 6.0), points=1000)
    settings.keep(curve, "curve")
    here = curve.isel(zeta=0, delta0=0)
    figure, (torque, steps) = mixed_panels(1, 2, height=4.0)
    speed, held = here.omega.values, here.driven_stability.values != STABILITY["unstable"]
    drive = here.torque.values + MOTOR["slope"] * speed
    turn = settled.sizes["step"] // 2
    with style():
        for ax, taken in ((torque, here.torque.values), (steps, drive)):
            across, up = (speed, taken) if ax is torque else (taken, speed)
            for chosen, dashes, words in ((held, "-", "held"), (~held, DASHES, "not held")):
                ax.plot(np.where(chosen, across, np.nan), np.where(chosen, up, np.nan), color=INK,
                        ls=dashes, lw=1.2, label=f"exact whirl, {words}")  # fmt: skip
            for part, colour, marker, words in (
                (slice(0, turn + 1), RED, "^", "torque raised"),
                (slice(turn, None), BLUE, "v", "torque lowered"),
            ):
                each = settled.isel(step=part)
                given = each.tau0 - MOTOR["slope"] * each.speed if ax is torque else each.tau0
                ax.plot(
                    *((each.speed, given) if ax is torque else (given, each.speed)), ls="",
                    marker=marker, ms=4.5, mfc="none", mec=colour, mew=0.9,
                    label=f"simulated, {words}",
                )  # fmt: skip
        draw_motors(torque, *limits_of(here))
        torque.set(xlabel="speed $\\omega$", ylabel="torque", xlim=(0.0, 6.0), ylim=(0.0, 4.5))
        steps.set(xlabel="torque of the drive at rest $\\tau_0$", ylabel="speed $\\omega$",
                  xlim=(0.0, 5.0), ylim=(0.0, 6.0))  # fmt: skip
    shared_legend(figure, (torque, steps), columns=3, outer=False)
    raised, lowered = limits_of(here)
    settings.show(
        figure, "sommerfeld", archives=["curve", "settled"],
        shows=f"A drive of limited power, τ₀ − {MOTOR['slope']:g} ω, and a rotor that rubs "
        f"(ζ = {DRIVEN['zeta']}, δ₀ = {DRIVEN['delta0']:g}, μ = {DRIVEN['friction']}, ρ = "
        f"{DRIVEN['disc_radius']:g}, j = {MOTOR['inertia']:g}): the torque that every exact whirl "
        "takes, and where the drive settles as τ₀ is raised step by step, and lowered again.",
        found=f"All {settled.sizes['step']} settled speeds lie on stable parts of the curve,"
        f" to {scientific(float(np.abs(settled.missed_torque).max()))} of torque. The drive can "
        f"hold the large whirl up to τ₀ = {raised:.3f}; above that the speed jumps from "
        f"{before_jump(settled, 1)[0]:.2f} to {before_jump(settled, 1)[1]:.2f}. As τ₀ falls it "
        f"jumps back below τ₀ = {lowered:.3f}, from {before_jump(settled, -1)[0]:.2f} to "
        f"{before_jump(settled, -1)[1]:.2f}.",
    )  # fmt: skip


def limits_of(curve: xr.Dataset) -> tuple[float, float]:
    """Return the largest torque that sustains the large whirl, and the least for the small."""
    speed, held = curve.omega.values, curve.driven_stability.values != STABILITY["unstable"]
    drive = curve.torque.values + MOTOR["slope"] * speed
    edges = np.flatnonzero(np.diff(held.astype(int)))[-2:]
    return float(drive[edges[0]]), float(drive[edges[1] + 1])


def draw_motors(ax: Axes, raised: float, lowered: float) -> None:
    """Draw the lines of the drive at which the speed jumps."""
    across = np.array([0.0, 6.0])
    for tau0 in (raised, lowered):
        ax.plot(across, tau0 - MOTOR["slope"] * across, color=GREY, lw=0.9,
                label="drive at which the speed jumps")  # fmt: skip


def before_jump(settled: xr.Dataset, way: int) -> tuple[float, float]:
    """Return the speeds before and after the largest jump, up or down."""
    rises = way * np.diff(settled.speed.values)
    place = int(rises.argmax())
    before, after = settled.speed.values[place : place + 2]
    return float(before), float(after)


if __name__ == "__main__":
    sys.exit(run_script(main, description=__doc__, script=__file__))
