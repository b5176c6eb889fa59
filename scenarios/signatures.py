"""Rub signatures: orbit, full spectrum and cascade of eight motions.

One rotor on a shaft (zeta = 0.04, kappa = 0.04, a linear stator, mu = 0.1, rho = 20, delta0 = 2)
shows all eight. Upright it whirls forward in contact. Past a Hopf point it swings in contact, past
a graze it leaves the stator in each swing, and past a fold of these cycles it rolls backwards in
dry whip. Horizontal, under a load, it touches once a revolution or, faster, every second one, with
lines at exact halves of the speed; faster still it is chaotic. In a stator too wide to touch it
runs up without contact through resonance. Each motion is shown to be an attractor by its
eigenvalues, multipliers or exponents, and its lines are known exactly. The signals of two probes
are compared with what is published on rubs.

Writes the signs of all motions (signs.nc), the branch (branch.nc), of each motion a record (records
such as whip.nc) and a run-up or run-down (such as whip_cascade.nc), and the figures as PNG and SVG.
"""

import math
import sys
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from typing import Any

import numpy as np
import xarray as xr
from matplotlib.axes import Axes

from rotor_ida import (
    Rotor,
    centre_line,
    continue_cycle,
    limit_cycle,
    lyapunov_exponent,
    orders,
    rub_signs,
    run_up,
    signals_of,
    simulate,
    synchronous_response,
)
from rotor_ida.paper.scenario import Settings, run_script, scientific
from rotor_ida.plot import (
    mixed_panels,
    plot_cascade,
    plot_full_spectrum,
    plot_orbit,
    shared_legend,
    style,
)
from rotor_ida.schema import RESPONSE, SPECIAL, STABILITY

MACHINE = {
    "zeta": 0.04, "delta0": 2.0, "shaft_stiffness": 0.04, "contact_exponent": 1.0, "friction": 0.1,
    "disc_radius": 20.0,
}  # fmt: skip
LOAD = 0.06
WIDE = 4.0  # clearance that is not touched: the largest contact-free whirl is 2.5 wide
UNBALANCE, NEAR_WHIP, LOW = (3.0, 1.0, 0.0, 0.0), (6.0, 0.0, 0.0, -7.0), (0.0, -1.0, 0.0, 0.0)

REVOLUTIONS, SAMPLES = 256, 64  # of a record, and in a revolution
OFF = 1.01  # distance from the attractor at which a run begins
FORGOTTEN = 25.0  # in time constants, after which that distance is negligible
SHOWN = 12  # revolutions of an orbit
CHAOS = {"transient": 2000.0, "duration": 10_000.0}
SEGMENT = 32  # revolutions of a spectrum of chaos
FAINTEST = 1e-5  # line in a figure


@dataclass(frozen=True, slots=True)
class Motion:
    """One motion of the machine: where it occurs, and a run-up or run-down that passes it.

    Parameters
    ----------
    words : str
        Name of the motion.
    omega : float
        Speed of its record.
    start : tuple of float
        State that leads to its attractor at `found_at`, which is then followed to `omega`.
    ramp : tuple of float
        First and last speed of the cascade.
    rate : float
        Rate of change of the speed (absolute value).
    found_at : float, optional
        Speed at which the start leads to it; default: `omega`.
    changes : dict, optional
        Parameters that differ from the machine.
    spectrum, cascade : float
        Largest frequency shown over the speed, over the largest speed.
    """

    words: str
    omega: float
    start: tuple[float, ...]
    ramp: tuple[float, float]
    rate: float
    found_at: float | None = None
    changes: tuple[tuple[str, float], ...] = ()
    spectrum: float = 4.0
    cascade: float = 3.0

    def rotor(self, omega: float) -> Rotor:
        """Return the rotor at a speed."""
        return Rotor(omega=omega, **(MACHINE | dict(self.changes)))


DRAWN_QUICKLY = ("synchronous", "whip", "chaos")
ON_ITS_SIDE = (("load", LOAD),)
ROUND = ("free", "synchronous")  # whirls that are circles
MOTIONS = {
    "free": Motion("run-up without contact", 0.5, (0.0,) * 4, (0.05, 0.8), 5e-5,
                   changes=(("delta0", WIDE),), cascade=2.0),
    "synchronous": Motion("synchronous rub", 0.5, (0.0,) * 4, (0.05, 0.63), 5e-5,
                          cascade=2.0),
    "annular": Motion("full annular rub", 0.65, UNBALANCE, (0.7, 0.6), 2e-5, found_at=0.66,
                      cascade=2.0),
    "partial": Motion("partial rub", 0.75, UNBALANCE, (0.67, 0.835), 4e-5, cascade=2.0),
    "whip": Motion("dry whip", 0.9, NEAR_WHIP, (0.75, 1.3), 2e-4, cascade=2.0),
    "once": Motion("partial rub once a revolution, under a load", 0.25, LOW, (0.13, 0.35), 1e-4,
                   changes=ON_ITS_SIDE),
    "half": Motion("partial rub every other revolution, under a load", 0.8, LOW, (0.72, 0.845),
                   5e-5, changes=ON_ITS_SIDE, spectrum=2.5, cascade=2.0),
    "chaos": Motion("chaos", 0.925, LOW, (0.82, 0.94), 2e-5, changes=ON_ITS_SIDE, spectrum=2.5,
                    cascade=2.0),
}  # fmt: skip


def main(settings: Settings) -> None:
    with ThreadPoolExecutor(settings.workers) as pool:
        found = dict(zip(MOTIONS, pool.map(exact_of, MOTIONS), strict=True))
        records = dict(zip(MOTIONS, pool.map(record_of, MOTIONS, found.values()), strict=True))
        ramps = dict(zip(MOTIONS, pool.map(ramp_of, MOTIONS), strict=True))
    branch = branch_to_whip()
    settings.keep(branch, "branch")
    signs = signs_of_all(found, records)
    settings.keep(signs, "signs")
    for name in MOTIONS:
        settings.keep(records[name], name)
        settings.keep(ramps[name], f"{name}_cascade")
    for name in DRAWN_QUICKLY if settings.quick else MOTIONS:
        draw(name, found[name], records[name], ramps[name], signs, branch, settings)


# ---- What is exact ----


def exact_of(name: str) -> xr.Dataset:
    """Return the exact whirl or cycle of a motion at its speed; in chaos an unstable one."""
    motion = MOTIONS[name]
    if name in ROUND:
        return stable_whirl(whirls_of(motion, [motion.omega]))
    return cycles_along("half" if name == "chaos" else name, [motion.omega])[0]


def whirls_of(motion: Motion, speeds: Any) -> xr.Dataset:
    """Return the exact whirls of a rotor at some speeds."""
    given = {name: value for name, value in motion.rotor(1.0).given.items()
             if name not in ("omega", "disc_radius")}  # fmt: skip
    return synchronous_response(omega=speeds, **given)


def cycles_along(name: str, speeds: Any) -> list[xr.Dataset]:
    """Return the exact cycles of a motion at some speeds, each the guess for the next.

    If the kind of cycle changes on the way, each is computed anew.
    """
    motion = MOTIONS[name]
    if name in ("whip", "once"):
        return [limit_cycle(motion.rotor(speed), start=motion.start) for speed in speeds]
    omega = motion.found_at or motion.omega
    cycle = limit_cycle(motion.rotor(omega), start=motion.start)
    found = []
    for speed in speeds:
        count = max(1, math.ceil(abs(speed - omega) / 0.02))
        for between in np.linspace(omega, speed, count + 1)[1:]:
            # under a load the period is a number of revolutions
            period = cycle.period.item() * (omega / between if name == "half" else 1.0)
            cycle = limit_cycle(motion.rotor(between), start=state_of(cycle), period=period)
            omega = between
        found.append(cycle)
    return found


def state_of(exact: xr.Dataset) -> tuple[float, ...]:
    """Return the state on an exact whirl or cycle at time 0."""
    if "period" in exact.variables:
        return tuple(float(exact[each].values[0]) for each in ("x", "y", "vx", "vy"))
    omega = exact.omega.item()
    z = exact.amplitude.item() * np.exp(-1j * exact.phase_lag.item())
    return z.real, z.imag, -omega * z.imag, omega * z.real


def stable_whirl(whirls: xr.Dataset) -> xr.Dataset:
    """Return the stable whirl at a speed; if there are two, that in contact."""
    stable = np.flatnonzero(whirls.stability.values.ravel() == STABILITY["stable"])
    touching = stable[whirls.in_contact.values.ravel()[stable] == 1]
    return whirls.isel(branch=[int((touching if touching.size else stable)[0])])


def decay_of(exact: xr.Dataset) -> float:
    """Return the rate at which the slowest disturbance of a stable whirl or cycle decays."""
    if "period" not in exact.variables:
        return -exact.growth_rate.item()
    sizes = np.hypot(exact.multiplier_real.values, exact.multiplier_imag.values)
    if "load" not in exact.coords:  # a shift along the cycle neither grows nor decays
        sizes = np.delete(sizes, np.abs(exact.multiplier_real.values - 1.0).argmin())
    return -math.log(sizes.max()) / exact.period.item()


def branch_to_whip() -> xr.Dataset:
    """Return the branch of cycles from the Hopf point of the synchronous rub."""
    motion = MOTIONS["partial"]
    return continue_cycle(
        motion.rotor(0.7), start=motion.start, parameter="omega", limits=(0.5, 1.2)
    )  # fmt: skip


def special(branch: xr.Dataset, kind: str) -> float:
    """Return the speed of the first special point of a kind along the branch from its birth."""
    return float(branch.special_value.values[branch.special_kind.values == SPECIAL[kind]][0])


# ---- What is simulated ----


def record_of(name: str, exact: xr.Dataset) -> xr.Dataset:
    """Return the signals of two probes after the transient of a motion."""
    motion = MOTIONS[name]
    revolution = 2.0 * math.pi / motion.omega
    lasts = CHAOS["transient"] if name == "chaos" else FORGOTTEN / decay_of(exact)
    lead = math.ceil(lasts / revolution)
    times = revolution * (lead + np.arange(REVOLUTIONS * SAMPLES) / SAMPLES)
    start = tuple(OFF * each for each in state_of(exact))
    return simulate(
        motion.rotor(motion.omega), start=start, duration=float(times[-1]), samples=times,
        method="taylor",
    )  # fmt: skip


def ramp_of(name: str) -> xr.Dataset:
    """Return a run-up or run-down that passes a motion, from the exact one at the first speed."""
    motion = MOTIONS[name]
    first, last = motion.ramp
    if name in (*ROUND, "once"):
        start = motion.start
    else:
        at = {"whip": "partial", "chaos": "half"}.get(name, name)
        start = state_of(cycles_along(at, [first])[0])
    duration = abs(last - first) / motion.rate
    samples = math.ceil(SAMPLES / 2 * duration * max(first, last) / (2.0 * math.pi))
    return run_up(
        motion.rotor(first), start=start, to=last, rate=math.copysign(motion.rate, last - first),
        samples=samples, method="taylor",
    )  # fmt: skip


# ---- What the signals show ----


def signs_of_all(found: dict[str, xr.Dataset], records: dict[str, xr.Dataset]) -> xr.Dataset:
    """Return the signs of every motion, with evidence that it is an attractor."""
    rows = [signs_of(name, found[name], records[name]) for name in MOTIONS]
    return xr.Dataset(
        {
            name: ("motion", [row[name] for row in rows], {"long_name": words, "units": "1"})
            for name, words in SIGNS.items()
        },
        {"motion": ("motion", list(MOTIONS), {"long_name": "motion"})},
        {"title": "Signs of rubs in the signals of two probes"},
    )


SIGNS = {
    "speed": "spin speed",
    "response": "kind of response, by the numbers of a sweep",
    "growth": "largest rate at which disturbances grow, negative where they decay",
    "growth_error": "error of that rate, of chaos",
    "in_contact": "part of the time in contact",
    "smallest_radius": "smallest distance from the bearing axis",
    "largest_radius": "largest distance from the bearing axis",
    "whirl_over_spin": "whirl speed over spin speed",
    "forward": "amplitude of 1X forward",
    "backward": "amplitude of 1X backward",
    "twice": "amplitude of 2X, forward and backward",
    "order": "order of the strongest line beside 1X, negative backwards",
    "amplitude": "amplitude of that line",
    "exact_order": "exact order of the line",
    "exact_amplitude": "exact amplitude of the line",
    "counterpart": "amplitude at the same order in the other direction",
    "offset": "distance of the mean position from the bearing axis",
    "flatness": "least crest of the probes over that of a sine, below 1 where it is clipped",
    "phase_spread": "standard deviation of the phase of 1X over windows of a revolution",
    "floor": "lower quartile of the full spectrum between 0.1X and 0.9X, over the highest line",
}
# Of these `rub_signs` tells some.
FOUND = {
    "whirl_over_spin": "whirl_over_spin", "forward": "forward_whirl_amplitude",
    "backward": "backward_whirl_amplitude", "twice": "twice_amplitude", "order": "line_order",
    "amplitude": "line_amplitude", "counterpart": "line_opposite_amplitude",
    "flatness": "least_crest", "floor": "floor_ratio",
}  # fmt: skip


def signs_of(name: str, exact: xr.Dataset, record: xr.Dataset) -> dict[str, float]:
    """Return the signs of one motion; those of `FOUND` by `rub_signs`."""
    radius = np.hypot(record.x.values, record.y.values)
    signals = signals_of(record)
    found = rub_signs(signals)
    signs = {name: found[each].item() for name, each in FOUND.items()}
    mean = centre_line(signals, revolutions=REVOLUTIONS).isel(window=0)
    lags = orders(signals).forward_phase_lag.values
    order, amplitude = exact_line(exact, signs["order"])
    return {
        "speed": record.omega.item(),
        **known_of(name, exact),
        "in_contact": float((radius > record.delta0.item()).mean()),
        "smallest_radius": float(radius.min()),
        "largest_radius": float(radius.max()),
        **signs,
        "exact_order": math.nan if name == "chaos" else order,
        "exact_amplitude": math.nan if name == "chaos" else amplitude,
        "offset": math.hypot(mean.offset_x.item(), mean.offset_y.item()),
        "phase_spread": spread(lags),
    }


def known_of(name: str, exact: xr.Dataset) -> dict[str, float]:
    """Return the kind of response and the evidence that it is an attractor."""
    error = math.nan
    if name == "chaos":
        motion = MOTIONS[name]
        known = lyapunov_exponent(motion.rotor(motion.omega), start=motion.start, **CHAOS)
        growth, error = (
            float(known[each][0]) for each in ("lyapunov_exponent", "lyapunov_error")
        )  # fmt: skip
        kind = RESPONSE["chaotic"] if growth > 5.0 * error else RESPONSE["unresolved"]
    elif "period" in exact.variables:
        growth, kind = -decay_of(exact), int(exact.response)
    else:
        growth = -decay_of(exact)
        kind = RESPONSE["synchronous" if exact.in_contact.item() else "contact_free"]
    return {"response": kind, "growth": growth, "growth_error": error}


def exact_line(exact: xr.Dataset, near: float) -> tuple[float, float]:
    """Return order and amplitude of the line of a cycle that is next to an order."""
    if "frequency" not in exact.variables or math.isnan(near):
        return math.nan, math.nan
    order = exact.frequency.values / exact.omega.item()
    place = int(np.abs(order - near).argmin())
    return float(order[place]), float(exact.whirl_amplitude.values[place])


def spread(lags: np.ndarray) -> float:
    """Return the standard deviation of angles about their mean direction [rad]."""
    about = np.angle(np.exp(1j * lags) / np.exp(1j * lags).mean())
    return float(about.std())


# ---- Figures ----


def draw(
    name: str, exact: xr.Dataset, record: xr.Dataset, ramp: xr.Dataset, signs: xr.Dataset,
    branch: xr.Dataset, settings: Settings,
) -> None:  # fmt: skip
    motion, chaotic = MOTIONS[name], name == "chaos"
    figure, axes = mixed_panels(1, 3, width=10.6, height=4.3)
    orbit, lines, cascade = axes
    signals = signals_of(record)
    shown = signals.isel(t=slice(0, SHOWN * SAMPLES + 1))
    plot_orbit(shown, beneath=() if chaotic else exact, ax=orbit)
    segment = SEGMENT * SAMPLES if chaotic else None
    plot_full_spectrum(
        signals, span=motion.spectrum, segment=segment, beneath=exact, ax=lines
    )  # fmt: skip
    beneath = lines_along(name, branch, 3 if settings.quick else 6)
    plot_cascade(ramp, span=motion.cascade, beneath=beneath, ax=cascade)
    finish(axes, motion)
    shared_legend(figure, axes, columns=5, outer=False)
    settings.show(
        figure, name, archives=[name, f"{name}_cascade", "signs", "branch"],
        shows=shows(motion, chaotic), found=told(name, signs, ramp, branch),
    )  # fmt: skip


def lines_along(name: str, branch: xr.Dataset, count: int) -> list[xr.Dataset]:
    """Return exact whirls and cycles along a ramp, for their lines in the cascade."""
    motion = MOTIONS[name]
    first, last = motion.ramp
    speeds = np.linspace(first, last, count + 2)[1:-1]
    if name in ROUND:
        return [stable_whirl(whirls_of(motion, [speed])) for speed in speeds]
    if name == "annular":  # below the Hopf point the whirl is stable
        born = special(branch, "hopf")
        return [*cycles_along(name, speeds[speeds > born]),
                whirls_of(motion, speeds[speeds < born])]  # fmt: skip
    if name == "whip":  # before the fold the run-up is still on the partial rub
        lost = special(branch, "fold")
        return [*cycles_along("partial", speeds[speeds < lost]),
                *cycles_along(name, speeds[speeds > lost])]  # fmt: skip
    return cycles_along("half" if name == "chaos" else name, speeds)


def finish(axes: list[Axes], motion: Motion) -> None:
    """Set the titles of the panels, and remove labels that all share."""
    first, last = motion.ramp
    digit, power = f"{motion.rate:.0e}".split("e")
    digit = "" if digit == "1" else rf"{digit} \cdot "
    titles = (
        f"orbit at $\\omega = {motion.omega:g}$",
        f"full spectrum at $\\omega = {motion.omega:g}$",
        f"run-{'up' if last > first else 'down'} at the rate ${digit}10^{{{int(power)}}}$",
    )
    with style():
        for ax, title in zip(axes, titles, strict=True):
            ax.set_title(title, fontsize=9.5, pad=16.0)
        axes[1].set_ylim(bottom=FAINTEST)
        for artist in axes[1].get_children():
            if str(artist.get_label()).startswith(("noise floor", "bandwidth")):
                artist.remove()


def shows(motion: Motion, chaotic: bool) -> str:
    """Return the gallery caption of a figure."""
    rotor = motion.rotor(motion.omega)
    lies = f", horizontal, under a load γ = {rotor.load:g}" if rotor.load else ""
    marked = "of an unstable cycle within it" if chaotic else "that are known exactly"
    return (
        f"{motion.words[0].upper()}{motion.words[1:]}: orbit over {SHOWN} revolutions, full "
        f"spectrum and cascade of a rotor on a shaft (κ = {rotor.shaft_stiffness:g}, "
        f"ζ = {rotor.zeta:g}) in a linear stator (δ₀ = {rotor.delta0:g}, μ = {rotor.friction:g}, "
        f"ρ = {rotor.disc_radius:g}){lies}; the lines {marked} are marked."
    )


def told(name: str, signs: xr.Dataset, ramp: xr.Dataset, branch: xr.Dataset) -> str:
    """Return the gallery text on a motion."""
    here = {each: float(signs[each].sel(motion=name)) for each in signs.data_vars}
    if name in ROUND:
        off, turned = beside_the_curve(MOTIONS[name], ramp)
        return (
            f"Only 1X, which agrees with the exact curve to {scientific(off)} of the "
            f"largest amplitude throughout; its phase lag grows by {turned:.0f}°."
        )
    where = {
        "annular": f"Born at the Hopf point {special(branch, 'hopf'):.7f}, the whirl swings in "
        f"contact up to the graze at {special(branch, 'graze'):.7f}. ",
        "partial": f"From the graze at {special(branch, 'graze'):.7f} on, up to the fold at "
        f"{special(branch, 'fold'):.7f}, the rotor leaves the stator in each swing. ",
        "whip": f"Beyond the fold of partial rub at {special(branch, 'fold'):.7f} the disc rolls "
        "backwards on the stator. ",
    }.get(name, "")  # fmt: skip
    contact = f"It is in contact for {here['in_contact']:.0%} of the time. "
    if name == "chaos":
        return (
            f"The largest exponent is {here['growth']:.3f} ± {here['growth_error']:.3f}. Between "
            f"0.1X and 0.9X three quarters of the spectrum lie above {here['floor']:.1g} of 1X. "
            "Only 1X and the mean of the unstable cycle within it appear as lines."
        )
    order = f"{here['exact_order']:.4f}".replace("-", "−")
    apart = abs(here["amplitude"] / here["exact_amplitude"] - 1.0)
    return (
        f"{where}{contact}Beside 1X the strongest line is at {order}X, "
        f"{here['amplitude'] / here['forward']:.2f} times as high; it agrees with the exact "
        f"amplitude to {scientific(max(apart, 1e-9))}."
    )


def beside_the_curve(motion: Motion, ramp: xr.Dataset) -> tuple[float, float]:
    """Return the relative error of 1X of a run-up, and the growth of its lag [degree].

    Only windows after the initial transient are compared.
    """
    tracked = orders(ramp, revolutions=2).isel(order=0)
    tracked = tracked.isel(window=tracked.t.values > FORGOTTEN / 4.0 / motion.rotor(1.0).zeta)
    whirls = whirls_of(motion, tracked.speed.values)
    stable = whirls.amplitude.where(whirls.stability == STABILITY["stable"])
    exact = stable.max("branch").values.ravel()
    off = np.abs(tracked.forward_whirl_amplitude.values - exact) / exact.max()
    turned = np.degrees(np.unwrap(tracked.forward_phase_lag.values))
    return float(off.max()), float(np.ptp(turned))


if __name__ == "__main__":
    sys.exit(run_script(main, description=__doc__, script=__file__))
