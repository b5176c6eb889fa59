"""Map the most frequent response, its contact force and its robustness over speed and clearance.

The paper advises a larger clearance. At each speed and clearance, starts in the box
|x|, |y| <= 10, |x'|, |y'| <= 10 are followed to their attractors. The map also shows the folds of
the synchronous whirls, and the folds and period doublings of the bouncing cycle. A coarser grid
shows the smallest change of velocity that moves the rotor off the most frequent attractor.

Writes both atlases and the curves (netCDF) and a figure as PNG and SVG.
"""

import sys

import numpy as np
import xarray as xr

from rotor_ida import Rotor, bifurcation_curve, continue_attractors, continue_cycle, folds
from rotor_ida.paper.scenario import Settings, progress_bar, run_script
from rotor_ida.plot import panels, plot_attractor_map, plot_curves, shared_legend
from rotor_ida.schema import RESPONSE, SPECIAL

ZETA = 0.07
BOX = dict.fromkeys(("x", "y", "vx", "vy"), (-10.0, 10.0))
PLANE = {"omega": (0.2, 4.2), "delta0": (0.1, 3.0)}
CYCLE = Rotor(omega=2.0, zeta=ZETA, delta0=2.0)


def main(settings: Settings) -> None:
    speeds = np.linspace(*PLANE["omega"], 5 if settings.quick else 33)
    clearances = np.linspace(*PLANE["delta0"], 3 if settings.quick else 13)
    with progress_bar("speeds and clearances") as progress:
        found = continue_attractors(
            omega=speeds, zeta=ZETA, delta0=clearances, **BOX, workers=settings.workers,
            starts=20 if settings.quick else 200, progress=progress,
        )  # fmt: skip
    settings.keep(found, "atlas")
    with progress_bar("shocks") as progress:
        shocked = continue_attractors(
            omega=speeds[1::3], zeta=ZETA, delta0=clearances[::2], **BOX,
            workers=settings.workers, starts=20 if settings.quick else 200,
            shocks=64 if settings.quick else 512, progress=progress,
        )  # fmt: skip
    settings.keep(shocked, "shocks")
    curves = curves_of_the_cycle(15 if settings.quick else 400)
    for number, curve in enumerate(curves, start=1):
        settings.keep(curve, f"curve_{number}")
    whirls = folds(zeta=ZETA, delta0=np.linspace(*PLANE["delta0"], 60))
    figure, axes = panels(3, 1, width=6.4, height=12.0)
    for ax, by in zip(axes, ("kind", "force", "shock"), strict=True):
        plot_attractor_map(shocked if by == "shock" else found, by=by, ax=ax)
        plot_curves(curves, fold_points=whirls, ax=ax)
        ax.set(xlim=PLANE["omega"], ylim=PLANE["delta0"])
    shared_legend(figure, axes, columns=4)
    settings.show(
        figure, "atlas",
        archives=["atlas", "shocks", *(f"curve_{k + 1}" for k in range(len(curves)))],
        shows="The most frequent response, the largest contact force on its most frequent "
        "attractor, and the smallest change of velocity that leaves it, over speed and clearance.",
        paper="A larger clearance lowers the amplitude.",
        verdict=verdict_on(found), found=f"{in_words(found)} {on_shocks(shocked)}",
    )  # fmt: skip


def curves_of_the_cycle(points: int) -> list[xr.Dataset]:
    """Return where the bouncing cycle folds, and where its period doubles."""
    branch = continue_cycle(CYCLE, start=(0, 0, 0, 0), limits=PLANE["omega"])
    curves = []
    for kind in ("fold", "period_doubling"):
        places = np.flatnonzero(branch.special_kind.values == SPECIAL[kind])
        chosen = branch.isel(special=int(places[np.argmax(branch.special_value.values[places])]))
        curves.append(
            bifurcation_curve(CYCLE, start=chosen, kind=kind, limits=PLANE, points=points)
        )
    return curves


def in_lasting_contact(found: xr.Dataset) -> xr.DataArray:
    """Return the fraction of starts that end in lasting contact, by clearance."""
    kinds = ("synchronous", "bouncing", "full_contact", "chaotic")
    hard = found.kind.isin([RESPONSE[kind] for kind in kinds])
    return found.fraction.where(hard, 0.0).sum("attractor").squeeze()


def in_words(found: xr.Dataset) -> str:
    """Return the verdict text on the smallest and the largest clearance."""
    share = in_lasting_contact(found)
    parts = [
        f"at δ₀ = {float(row.delta0):.2g} {float(row.mean()):.0%} of all starts end in lasting "
        f"contact, above ω = 2 {float(row.sel(omega=slice(2.0, None)).mean()):.0%}"
        for row in (share.isel(delta0=0), share.isel(delta0=-1))
    ]
    return "; ".join(parts).capitalize() + "."


def on_shocks(shocked: xr.Dataset) -> str:
    """Return the text on the weakest most frequent response."""
    likeliest = shocked.fraction.fillna(-1.0).argmax("attractor")
    least = shocked.velocity_shock.min("target").isel(attractor=likeliest).squeeze()
    place = least.isel(least.fillna(np.inf).argmin(("omega", "delta0")))
    part = float(np.isfinite(least).mean())
    return (
        f"At {part:.0%} of the speeds and clearances a shock ends the most frequent "
        f"response; the smallest, {float(place):.2g}, at ω = {float(place.omega):.2g} and "
        f"δ₀ = {float(place.delta0):.2g}."
    )


def verdict_on(found: xr.Dataset) -> str:
    """Return the text on the largest contact force of the most frequent attractor."""
    likeliest = found.fraction.fillna(-1.0).argmax("attractor")
    depth = (found.radius_max - found.delta0).isel(attractor=likeliest).squeeze().fillna(0.0)
    place = depth.isel(depth.argmax(("omega", "delta0")))
    force, where = float(place) ** 1.5, float(place.delta0)
    least = "" if where == float(found.delta0.min()) else "not "
    return (
        f"The largest contact force of the most frequent response is {force:.1f}, at ω = "
        f"{float(place.omega):.2g} and δ₀ = {where:.2g}, {least}the smallest clearance."
    )


if __name__ == "__main__":
    sys.exit(run_script(main, description=__doc__, script=__file__))
