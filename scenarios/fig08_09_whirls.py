"""Figures 8 and 9: the small and the large whirl, and a rotor that bounces.

At omega = 1.7, zeta = 0.07, delta0 = 0 the rotor settles on one of two whirls. The paper's
captions are exchanged: from rest it reaches the small one, from (10, 0, 0, 0) the large one.
A third run, with clearance, enters and leaves contact for ever.

Writes the three runs (small.nc, large.nc, bouncing.nc) and the figures as PNG and SVG.
"""

import sys

import numpy as np
import xarray as xr

from rotor_ida import Rotor, simulate, synchronous_response
from rotor_ida.paper.scenario import Settings, run_script
from rotor_ida.plot import (
    mixed_panels,
    parameter_text,
    plot_orbit,
    plot_trace,
    shared_legend,
    style,
)
from rotor_ida.plot.appearance import finish_solid
from rotor_ida.plot.labels import LABELS
from rotor_ida.plot.motion import draw_motion
from rotor_ida.signals.path import path_of

ROTOR = Rotor(omega=1.7, zeta=0.07, delta0=0.0)
BOUNCING = Rotor(omega=2.0, zeta=0.07, delta0=2.0)
# The amplitude converges to eight digits in this time; the first part is drawn.
SETTLED, DRAWN = 300.0, 90.0


def main(settings: Settings) -> None:
    exact = synchronous_response(omega=1.7, zeta=0.07, delta0=0.0).amplitude.values.ravel()
    for name, start, number, right, wrong in (
        ("fig08_large", (10.0, 0.0, 0.0, 0.0), 2, "(10, 0, 0, 0)", "(0, 0, 0, 0)"),
        ("fig09_small", (0.0, 0.0, 0.0, 0.0), 0, "(0, 0, 0, 0)", "(10, 0, 0, 0)"),
    ):
        size = name.rpartition("_")[2]
        run = follow(ROTOR, start, SETTLED)
        settings.keep(run, size)
        reached = float(np.hypot(run.x[-1], run.y[-1]))
        draw(
            name, run, size, settings,
            shows=f"The {size} whirl over time, as an orbit, and x and y, from {right}.",
            paper=f"The {size} periodic solution is that for the initial condition {wrong}.",
            verdict=f"Wrong: for {right}; the captions of Figs 8 and 9 are exchanged.",
            found=f"From {right} the amplitude settles at {reached:.7f}; the exact {size} whirl "
            f"has {exact[number]:.7f}. The captions of Figs 8 and 9 are exchanged.",
        )  # fmt: skip
    run = follow(BOUNCING, (0.0, 0.0, 0.0, 0.0), DRAWN)
    settings.keep(run, "bouncing")
    radius = np.hypot(run.x, run.y).sel(t=slice(0.5 * DRAWN, None))
    draw(
        "bouncing", run, "bouncing", settings,
        shows="With a clearance of 2, at ω = 2, from rest: contact and flight by "
        "colour.",
        paper="",
        found=f"The rotor enters and leaves contact for ever, from t = {0.5 * DRAWN:g} on with |z| "
        f"between {float(radius.min()):.2f} and {float(radius.max()):.2f}; no synchronous whirl "
        "does that.",
    )  # fmt: skip


def follow(rotor: Rotor, start: tuple[float, float, float, float], duration: float) -> xr.Dataset:
    return simulate(rotor, start=start, duration=duration, samples=int(20 * duration) + 1)


def draw(name: str, run: xr.Dataset, archive: str, settings: Settings, **texts: str) -> None:
    shown = run.sel(t=slice(0.0, DRAWN))
    figure, axes = mixed_panels(2, 2, height=6.0, solid=[0])
    draw_over_time(axes[0], shown)
    plot_orbit(shown, ax=axes[1])
    axes[1].set_title("")
    for ax, along in zip(axes[2:], "xy", strict=True):
        plot_trace(shown, names=(along,), ax=ax)
    shared_legend(figure, axes, columns=6, outer=False)
    with style():
        parameters = {each: float(run[each]) for each in ("omega", "zeta", "delta0")}
        figure.suptitle(parameter_text(parameters), fontsize=10.0)
    settings.show(figure, name, archives=[archive], **texts)


def draw_over_time(ax, run: xr.Dataset) -> None:
    """Draw the orbit over time in three dimensions, with contact and flight in colour."""
    path = path_of(run)
    with style():
        draw_motion(ax, path, path.time, path.x, path.y, width=0.7)
        ax.set(xlabel=LABELS["t"], ylabel=LABELS["x_alone"], zlabel=LABELS["y_alone"])
        ax.xaxis.labelpad, ax.yaxis.labelpad, ax.zaxis.labelpad = -4, -6, -6
        ax.view_init(elev=22, azim=-58)
        finish_solid(ax, zoom=1.12)


if __name__ == "__main__":
    sys.exit(run_script(main, description=__doc__, script=__file__))
