"""Figures 10 and 11: amplitude over speed for four clearances, exact and simulated.

Figure 10 shows every synchronous whirl at zeta = 0.07 with its stability, its folds and the
backbone. From delta0 = 1 on the contacting whirls are an isola beside the contact-free family.
Phases have separate figures. Figure 11 adds simulated responses, from rest and with the speed going
up and down. It also shows the branches of limit cycles on which the rotor bounces for ever or stays
in contact at an oscillating radius. No one-harmonic curve can show them, yet they are as exact.
Each branch is a band from the smallest to the largest radius, stable or not, with its folds and
period doublings. With a clearance of 2 the rotor never reaches the contacting whirls from rest. A
sweep settles at each speed, but a machine does not wait. Run-ups and run-downs at a finite rate are
therefore drawn beside the quasi-static ones: they jump later.

Writes the exact curves (fig10.nc), the backbones (backbone.nc), the sweeps with all their contact
events (fig11_from_rest.nc, fig11_up_down.nc), the comparison (fig11.nc), the branches of limit
cycles (fig11_cycles_1.nc and so on), and the figures as PNG and SVG.
"""

import sys
from collections.abc import Sequence

import numpy as np
import xarray as xr
from rich.box import SIMPLE_HEAD
from rich.console import Console
from rich.table import Table

from rotor_ida import (
    bifurcation_diagram,
    branches_through,
    compare,
    folds,
    sweep,
    synchronous_response,
)
from rotor_ida.closed_forms import free_periods, response_curve
from rotor_ida.paper.printed import phase_31
from rotor_ida.paper.scenario import Settings, progress_bar, run_script, scientific
from rotor_ida.plot import (
    panels,
    plot_amplitude,
    plot_branch,
    plot_phase,
    shared_legend,
    style,
)
from rotor_ida.plot.palette import BLUE, RED
from rotor_ida.schema import RESPONSE, SPECIAL
from rotor_ida.verification.compare import summarise

ZETA = 0.07
CLEARANCES = [2.0, 1.0, 0.5, 0.0]
LOWEST, HIGHEST = 0.05, 3.0
RATE = 1e-3
COLUMNS = ["delta0", "points", "on_whirl", "on_cycle", "fewest_digits", "median_digits",
           "touching", "chaotic", "unresolved", "failed"]  # fmt: skip
DIRECTIONS = {0: "rest", 1: "up", -1: "down"}


def main(settings: Settings) -> None:
    parameters = {"zeta": ZETA, "delta0": CLEARANCES}
    exact = xr.merge(
        [response_curve(**parameters, limits=(LOWEST, HIGHEST)), folds(**parameters)],
        compat="equals", join="exact", combine_attrs="override",
    )  # fmt: skip
    settings.keep(exact, "fig10")
    backbone = free_periods(amplitude=np.linspace(0.01, 14.0, 400), delta0=CLEARANCES)
    settings.keep(backbone, "backbone")
    draw("fig10", exact, None, settings, backbone)

    speeds = np.linspace(LOWEST, HIGHEST, 4 if settings.quick else 60)
    with progress_bar("each speed from rest") as progress:
        from_rest = sweep(omega=speeds, **parameters, workers=settings.workers, progress=progress)
    settings.keep(from_rest, "fig11_from_rest")
    with progress_bar("speed up and down   ") as progress:
        up_down = sweep(
            omega=speeds, **parameters, direction="both",
            workers=settings.workers, progress=progress,
        )  # fmt: skip
    settings.keep(up_down, "fig11_up_down")

    simulated = xr.concat(
        [from_rest, up_down], "direction",
        data_vars="minimal", coords="minimal", compat="equals", join="exact",
        combine_attrs="override",
    ).sortby("direction")  # fmt: skip
    compared = compare(simulated)
    settings.keep(compared, "fig11")
    with progress_bar("limit cycles        ") as progress:
        branches = branches_through(compared, limits=(LOWEST, HIGHEST), progress=progress)
    for number, branch in enumerate(branches, start=1):
        settings.keep(branch, f"fig11_cycles_{number}")
    draw("fig11", exact, simulated, settings, compared=compared, branches=branches)
    draw_cycles(exact, simulated, branches, settings)
    draw_run_ups(exact, up_down, settings)
    Console().print(table(compared))


def draw(
    name: str,
    exact: xr.Dataset,
    simulated: xr.Dataset | None,
    settings: Settings,
    backbone: xr.Dataset | None = None,
    compared: xr.Dataset | None = None,
    branches: Sequence[xr.Dataset] = (),
) -> None:
    for plot, quantity in ((plot_amplitude, "amplitude"), (plot_phase, "phase")):
        figure, axes = panels(2, 2, height=5.6 if simulated is None else 7.4)
        for ax, delta0 in zip(axes, CLEARANCES, strict=True):
            here = exact.sel(delta0=delta0)
            beside = None if simulated is None else simulated.sel(delta0=delta0)
            plot(here, simulated=beside, fold_points=here, ax=ax)
            for branch in of_clearance(branches, delta0) if quantity == "amplitude" else ():
                plot_branch(of_kinds(branch, "fold", "period_doubling"), ax=ax)
            if backbone is not None and quantity == "amplitude":
                free = backbone.sel(delta0=delta0)
                ax.plot(2.0 * np.pi / free.circular_period, free.amplitude, color="#6b7673", lw=0.9,
                        ls=(0, (1, 2)), label="backbone", zorder=2.2)  # fmt: skip
        shared_legend(figure, axes, columns=5 if simulated is None else 4)
        ending = "" if quantity == "amplitude" else "_phase"
        texts = (
            of_curves(quantity, exact)
            if compared is None
            else of_sweeps(quantity, compared, branches)
        )
        archives = [name, *(f"{name}_cycles_{number + 1}" for number in range(len(branches)))]
        settings.show(figure, f"{name}{ending}", archives=archives, **texts)


def of_clearance(branches: Sequence[xr.Dataset], delta0: float) -> list[xr.Dataset]:
    """Return the branches at one clearance."""
    return [branch for branch in branches if float(branch.delta0) == delta0]


def of_kinds(branch: xr.Dataset, *kinds: str) -> xr.Dataset:
    """Return a branch with special points of some kinds only."""
    wanted = np.isin(branch.special_kind, [SPECIAL[kind] for kind in kinds])
    return branch.isel(special=np.flatnonzero(wanted))


def draw_cycles(
    exact: xr.Dataset, simulated: xr.Dataset, branches: Sequence[xr.Dataset], settings: Settings
) -> None:
    """Draw the branches of limit cycles alone, at their full range."""
    with_cycles = [delta0 for delta0 in CLEARANCES if of_clearance(branches, delta0)]
    if not with_cycles:
        return
    figure, axes = panels(len(with_cycles), 1, height=0.9 + 2.7 * len(with_cycles), shared=False)
    for ax, delta0 in zip(axes, with_cycles, strict=True):
        here, cycles = exact.sel(delta0=delta0), of_clearance(branches, delta0)
        plot_amplitude(here, simulated=simulated.sel(delta0=delta0), fold_points=here, ax=ax)
        for branch in cycles:
            plot_branch(branch, ax=ax)
        ax.set_ylim(0.0, 1.08 * max(float(branch.radius_max.max()) for branch in cycles))
        ax.set(xlim=(LOWEST, HIGHEST), ylabel="amplitude $A$, radius $|z|$")
    shared_legend(figure, axes, columns=4)
    counted = "; ".join(
        f"{len(of_clearance(branches, delta0))} at δ₀ = {delta0:g}, from ω = "
        f"{min(float(each.omega.min()) for each in of_clearance(branches, delta0)):.4f} on"
        for delta0 in with_cycles[::-1]
    )
    archives = [f"fig11_cycles_{number + 1}" for number in range(len(branches))]
    settings.show(
        figure,
        "fig11_cycles",
        archives=archives,
        shows="The limit cycles of Fig. 11 alone: branches over the speed, with folds, period "
        "doublings and grazes.",
        found=f"Branches reached by a simulated rotor: {counted}. Most are parts of isolas: "
        "closed curves that no continuation from a whirl can reach.",
    )


def draw_run_ups(exact: xr.Dataset, up_down: xr.Dataset, settings: Settings) -> None:
    """Draw real run-ups and run-downs beside quasi-static ones."""
    speeds = np.linspace(LOWEST, HIGHEST, 30 if settings.quick else 296)
    rate = 10.0 * RATE if settings.quick else RATE
    with progress_bar("real run-ups        ") as progress:
        ramps = bifurcation_diagram(
            omega=speeds, zeta=ZETA, delta0=CLEARANCES, starts=[(0, 0, 0, 0)], direction="both",
            rate=rate, method="taylor", workers=settings.workers, progress=progress,
        )  # fmt: skip
    settings.keep(ramps, "fig11_run_up")
    figure, axes = panels(2, 2, height=7.0)
    for ax, delta0 in zip(axes, CLEARANCES, strict=True):
        here, beside = exact.sel(delta0=delta0), up_down.sel(delta0=delta0)
        plot_amplitude(here, simulated=beside, fold_points=here, ax=ax)
        with style():
            for way, colour, words in ((1, RED, "real run-up"), (-1, BLUE, "real run-down")):
                band = ramps.sel(delta0=delta0, direction=way).squeeze()
                ax.fill_between(speeds, band.radius_min, band.radius_max, color=colour, alpha=0.25,
                                lw=0.0, zorder=1.5)  # fmt: skip
                ax.plot(speeds, band.radius_max, color=colour, lw=1.0, zorder=1.6,
                        label=f"{words}: largest $|z|$, range")  # fmt: skip
    shared_legend(figure, axes, columns=4)
    largest = ", ".join(
        " and ".join(
            f"{float(each.radius_max.sel(delta0=d, direction=1).max()):.2f}"
            for each in (ramps, up_down)
        )
        + f" at δ₀ = {d:g}"
        for d in CLEARANCES[::-1]
    )
    settings.show(
        figure,
        "fig11_run_up",
        archives=["fig11_run_up", "fig11_up_down", "fig10"],
        shows=f"Fig. 11 from real run-ups and run-downs at a rate of {rate:g}: the range of |z| "
        "over the speed, beside the quasi-static ones, which settle at each speed.",
        found="Along a whirl a real run-up agrees with the quasi-static one. Past the fold it "
        "jumps later, and oscillates about the new response. It may miss a whirl that exists only "
        f"over a short range of speeds. The largest |z| of real and quasi-static run-ups is "
        f"{largest}.",
    )


def of_curves(quantity: str, exact: xr.Dataset) -> dict[str, str]:
    """Return the gallery text on Fig. 10."""
    counts = exact.fold_omega.notnull().sum("fold").squeeze()
    peaks = exact.amplitude.where(exact.in_contact == 1).max("point").squeeze()
    rows = ", ".join(
        f"{int(counts.sel(delta0=d))} folds and a peak of {float(peaks.sel(delta0=d)):.2f} at "
        f"δ₀ = {d:g}"
        for d in CLEARANCES[::-1]
    )
    shows = (
        f"Every synchronous whirl at ζ = {ZETA}: {quantity} over speed for four clearances, "
        "with stability and folds."
    )
    isola = (
        "From δ₀ = 1 on the contacting whirls are an isola, a closed curve beside the "
        "contact-free family."
    )
    if quantity == "amplitude":
        return {
            "shows": shows,
            "paper": "The amplitude is reduced and shifted to the left by more clearance.",
            "verdict": "True of the peak; below resonance more clearance raises the amplitude.",
            "found": f"{rows}. {isola}",
        }
    given = {"omega": 1.2, "zeta": ZETA, "delta0": 0.5}
    whirl = synchronous_response(**given).isel(branch=0)
    printed = phase_31(whirl.amplitude.item(), **given)
    return {
        "shows": shows,
        "paper": "Eq. (31) has f(A)/A² for the stiffness.",
        "verdict": "Wrong: f(A)/A.",
        "found": f"At ω = 1.2, δ₀ = 0.5 the lag is {whirl.phase_lag.item():.5f}; eq. (31) "
        f"as printed gives {printed:.5f}. {isola}",
    }


def of_sweeps(
    quantity: str, compared: xr.Dataset, branches: Sequence[xr.Dataset]
) -> dict[str, str]:
    """Return the gallery text on Fig. 11."""
    rows = summarise(compared.sel(direction=[0]))[::-1]
    counted = ", ".join(
        f"{row['on_whirl']} and {row['on_cycle']} of {row['points']} at δ₀ = {row['delta0']:g}"
        for row in rows
    )
    everywhere = summarise(compared)
    exact = sum(row["on_whirl"] + row["on_cycle"] for row in everywhere)
    points = sum(row["points"] for row in everywhere)
    others = {
        kind: count
        for kind in RESPONSE
        if (count := sum(row[kind] for row in everywhere))
    }  # fmt: skip
    rest = ", ".join(f"{count} {kind.replace('_', ' ')}" for kind, count in others.items())
    digits = float(compared.digits.min())
    reached = int((compared.response.sel(delta0=2.0, direction=0) == RESPONSE["synchronous"]).sum())
    texts = {
        "shows": f"The exact {quantity} and simulated responses, from rest and with "
        "the speed going up and down.",
        "paper": "The numerical results are in good agreement with the theoretical ones.",
    }
    if quantity == "phase":
        error = float(np.abs(compared.phase_error).max())
        return texts | {
            "found": f"On an exact whirl the simulated lag is right to {scientific(error)}. A "
            "rotor that bounces or swings has many harmonics; the lag shown is that of the one at "
            "the spin speed."
        }
    specials = [np.isin(each.special_kind, [SPECIAL[kind] for kind in ("fold", "period_doubling")])
                for each in branches]  # fmt: skip
    texts["shows"] = texts["shows"][:-1] + (
        f"; with the {len(branches)} branches of limit cycles that it reaches, as bands of |z|, "
        f"and their {sum(int(each.sum()) for each in specials)} folds and period doublings."
    )
    times = f"{reached} times" if reached else "never"
    return texts | {
        "verdict": "Without clearance they are; with clearance the rotor often settles on limit "
        "cycles, which the theory does not contain.",
        "found": f"From rest on an exact whirl and on an exact limit cycle: {counted}. Of all "
        f"{points} responses {exact} lie on one or the other, to {digits:.1f} digits or more"
        + (f"; the rest: {rest}. " if rest else ". ")
        + f"From rest the rotor settles {times} on the contacting whirls at δ₀ = 2.",
    }


def table(compared: xr.Dataset) -> Table:
    """Return how many points lie on an exact response, to how many digits, and what others do."""
    title = f"Simulated responses beside exact whirls and limit cycles at ζ = {ZETA}"
    shown = Table("speed", title=title, box=SIMPLE_HEAD, padding=0, show_edge=False)
    for name in COLUMNS:
        shown.add_column(name.replace("_", "\n"), justify="right")
    for direction, words in DIRECTIONS.items():
        for row in summarise(compared.sel(direction=[direction])):
            cells = [
                f"{row[name]:.1f}" if "digits" in name else f"{row[name]:g}" for name in COLUMNS
            ]
            shown.add_row(words, *cells, end_section=row["delta0"] == CLEARANCES[-1])
    return shown


if __name__ == "__main__":
    sys.exit(run_script(main, description=__doc__, script=__file__))
