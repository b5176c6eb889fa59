"""Figures 10 and 11: amplitude over speed, for four clearances, beside simulations.

Figure 10 draws every synchronous whirl at zeta = 0.07 with its stability, its folds and the
backbone; from delta0 = 1 on the contacting whirls are an isola beside the contact-free family.
Phases have figures of their own. Figure 11 adds what a simulated rotor settles on, from rest and
with the speed going up and down. It shows that the curve is right wherever the rotor follows it,
and where the rotor does something that no curve of one harmonic can show: it bounces on the ring
for ever, or stays in contact at a radius that oscillates. With a clearance of 2 it never comes to
the contacting branch from rest.

Writes the exact curves (fig10.nc), the backbones (backbone.nc), the sweeps with all their contact
events (fig11_from_rest.nc, fig11_up_down.nc), the comparison (fig11.nc), and the figures as PNG and
SVG.
"""

import sys

import numpy as np
import xarray as xr
from rich.box import SIMPLE_HEAD
from rich.console import Console
from rich.table import Table

from rotor_ida import compare, folds, sweep, synchronous_response
from rotor_ida.analysis.comparison import summarise
from rotor_ida.closed_forms import free_periods, response_curve
from rotor_ida.paper.printed import phase_31
from rotor_ida.paper.scenario import Settings, progress_bar, run_script, scientific
from rotor_ida.plot import panels, plot_amplitude, plot_backbone, plot_phase, shared_legend
from rotor_ida.schema import RESPONSE

ZETA = 0.07
CLEARANCES = [2.0, 1.0, 0.5, 0.0]
LOWEST, HIGHEST = 0.05, 3.0
COLUMNS = ["delta0", "points", "on_branch", "fewest_digits", "median_digits", "bouncing",
           "full_contact", "touching", "chaotic", "unresolved", "failed"]  # fmt: skip
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

    # Tables of events cannot be joined by direction; they stay in the archives of the sweeps.
    simulated = xr.concat(
        [from_rest.drop_dims("event"), up_down.drop_dims("event")], "direction",
        data_vars="minimal", coords="minimal", compat="equals", join="exact",
        combine_attrs="override",
    ).sortby("direction")  # fmt: skip
    compared = compare(simulated)
    settings.keep(compared, "fig11")
    draw("fig11", exact, simulated, settings, compared=compared)
    Console().print(table(compared))


def draw(
    name: str,
    exact: xr.Dataset,
    simulated: xr.Dataset | None,
    settings: Settings,
    backbone: xr.Dataset | None = None,
    compared: xr.Dataset | None = None,
) -> None:
    for plot, quantity in ((plot_amplitude, "amplitude"), (plot_phase, "phase")):
        figure, axes = panels(2, 2, height=5.6 if simulated is None else 6.2)
        for ax, delta0 in zip(axes, CLEARANCES, strict=True):
            here = exact.sel(delta0=delta0)
            beside = None if simulated is None else simulated.sel(delta0=delta0)
            plot(here, simulated=beside, fold_points=here, ax=ax)
            if backbone is not None and quantity == "amplitude":
                plot_backbone(backbone.sel(delta0=delta0), ax=ax)
        shared_legend(figure, axes, columns=5 if simulated is None else 4)
        ending = "" if quantity == "amplitude" else "_phase"
        texts = of_curves(quantity, exact) if compared is None else of_sweeps(quantity, compared)
        settings.show(figure, f"{name}{ending}", archives=[name], **texts)


def of_curves(quantity: str, exact: xr.Dataset) -> dict[str, str]:
    """Return what the gallery says of Fig. 10."""
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
        "From δ₀ = 1 on the contacting whirls are a curve of their own, an isola, beside the "
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


def of_sweeps(quantity: str, compared: xr.Dataset) -> dict[str, str]:
    """Return what the gallery says of Fig. 11."""
    rows = ", ".join(
        f"{row['on_branch']} of {row['points']} at δ₀ = {row['delta0']:g}"
        for row in summarise(compared.sel(direction=[0]))[::-1]
    )
    digits = float(compared.digits.min())
    at_two = compared.response.sel(delta0=2.0, direction=0)
    reached = int((at_two == RESPONSE["synchronous"]).sum())
    texts = {
        "shows": f"The exact {quantity} and what a simulated rotor settles on, from rest and with "
        "the speed going up and down.",
        "paper": "The numerical results are in good agreement with the theoretical ones.",
    }
    if quantity == "phase":
        error = float(np.abs(compared.phase_error).max())
        return texts | {
            "found": f"On an exact whirl the simulated lag is right to {scientific(error)}. A "
            "rotor that bounces or swings has many harmonics: marked is the lag of the one at the "
            "spin speed."
        }
    times = f"{reached} times" if reached else "never"
    return texts | {
        "verdict": "Without clearance they are; with clearance only where the rotor comes to a "
        "whirl.",
        "found": f"From rest on one of the exact whirls: {rows}. There curve and simulation agree "
        f"to {digits:.1f} digits or more. Elsewhere the rotor bounces, or its radius oscillates; "
        f"from rest it comes {times} to the contacting branch at δ₀ = 2.",
    }


def table(compared: xr.Dataset) -> Table:
    """Return how many points lie on an exact branch, to how many digits, and what others do."""
    title = f"Simulated responses beside the exact whirls at ζ = {ZETA}"
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
