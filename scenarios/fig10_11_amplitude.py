"""Figures 10 and 11: amplitude over speed, for four clearances, beside simulations.

Figure 10 draws every synchronous whirl at zeta = 0.07 with its stability and its folds. Figure 11
adds what a simulated rotor settles on, from rest and with the speed going up and down. It shows
that the curve is right wherever the rotor follows it, and where the rotor does something that no
curve of one harmonic can show: it bounces on the ring for ever, or stays in contact at a radius
that oscillates. With a clearance of 2 it never comes to the contacting branch from rest.

Writes the exact curves (fig10.nc), the sweeps with all their contact events (fig11_from_rest.nc,
fig11_up_down.nc), the comparison (fig11.nc), and the figures as PNG and SVG.
"""

import sys

import numpy as np
import xarray as xr
from rich.box import SIMPLE_HEAD
from rich.console import Console
from rich.table import Table

from rotor_ida import compare, folds, save, sweep, synchronous_response
from rotor_ida.comparison import summarise
from rotor_ida.plot import panels, plot_amplitude, plot_phase, save_figure, shared_legend
from rotor_ida.scenario import Settings, progress_bar, run_script, speeds_of_curves

ZETA = 0.07
CLEARANCES = [2.0, 1.0, 0.5, 0.0]
LOWEST, HIGHEST = 0.05, 3.0
COLUMNS = ["delta0", "points", "on_branch", "fewest_digits", "median_digits", "bouncing",
           "full_contact", "unresolved", "failed"]  # fmt: skip
DIRECTIONS = {0: "rest", 1: "up", -1: "down"}


def main(settings: Settings) -> None:
    parameters = {"zeta": ZETA, "delta0": CLEARANCES}
    dense = speeds_of_curves(**parameters, lowest=LOWEST, highest=HIGHEST)
    fold_points = folds(**parameters)
    exact = xr.merge(
        [synchronous_response(omega=dense, **parameters), fold_points],
        compat="equals", join="exact", combine_attrs="override",
    )  # fmt: skip
    save(exact, settings.folder / "fig10.nc", overwrite=settings.force)
    draw("fig10", exact, None, settings)

    speeds = np.linspace(LOWEST, HIGHEST, 9 if settings.quick else 60)
    with progress_bar("each speed from rest") as progress:
        from_rest = sweep(omega=speeds, **parameters, workers=settings.workers, progress=progress)
    save(from_rest, settings.folder / "fig11_from_rest.nc", overwrite=settings.force)
    with progress_bar("speed up and down   ") as progress:
        up_down = sweep(
            omega=speeds, **parameters, direction="both",
            workers=settings.workers, progress=progress,
        )  # fmt: skip
    save(up_down, settings.folder / "fig11_up_down.nc", overwrite=settings.force)

    # Tables of events cannot be joined by direction; they stay in the archives of the sweeps.
    simulated = xr.concat(
        [from_rest.drop_dims("event"), up_down.drop_dims("event")], "direction",
        data_vars="minimal", coords="minimal", compat="equals", join="exact",
        combine_attrs="override",
    )  # fmt: skip
    compared = compare(simulated)
    save(compared, settings.folder / "fig11.nc", overwrite=settings.force)
    draw("fig11", exact, simulated, settings)
    Console().print(table(compared))


def draw(name: str, exact: xr.Dataset, simulated: xr.Dataset | None, settings: Settings) -> None:
    for plot, ending in ((plot_amplitude, ""), (plot_phase, "_phase")):
        figure, axes = panels(2, 2, height=5.6 if simulated is None else 6.2)
        for ax, delta0 in zip(axes, CLEARANCES, strict=True):
            here = exact.sel(delta0=delta0)
            beside = None if simulated is None else simulated.sel(delta0=delta0)
            plot(here, simulated=beside, fold_points=here, ax=ax)
        shared_legend(figure, axes)
        save_figure(figure, settings.folder / f"{name}{ending}", overwrite=settings.force)


def table(compared: xr.Dataset) -> Table:
    """Return how many points lie on an exact branch, to how many digits, and what others do."""
    title = f"Simulated responses beside the exact whirls at zeta = {ZETA}"
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
