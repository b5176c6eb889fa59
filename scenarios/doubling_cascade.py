"""A cascade of period doublings into chaos, at delta0 = 2.

At zeta = 0.07 the rotor bounces on a stable cycle at omega = 2. As the speed falls, this cycle
doubles its period near omega = 1.803. The doubled cycle doubles again, and so on, at distances that
shrink by Feigenbaum's factor 4.669. Each doubling is located on its exact branch, and the next
branch starts there. A simulation with slowly falling speed shows the same: the largest radii split,
and past the end of the cascade they fill bands. The exponent at which neighbours approach a cycle,
from its exact multipliers, rises to zero at each doubling. Where no stable cycle is left, the
largest Lyapunov exponent is positive.

Writes the branches (branch_1.nc and so on), the sweep (down.nc), its largest radii and exponents
(radii.nc), and the figure as PNG and SVG; prints the table of doublings.
"""

import sys

import numpy as np
import xarray as xr
from rich.box import SIMPLE_HEAD
from rich.console import Console
from rich.table import Table

from rotor_ida import (
    Rotor,
    continue_cycle,
    limit_cycle,
    poincare_section,
    sweep,
)
from rotor_ida.paper.scenario import Settings, progress_bar, run_script
from rotor_ida.plot import panels, shared_legend, style
from rotor_ida.plot.labels import LABELS
from rotor_ida.plot.palette import BLUE, GREY, ORANGE
from rotor_ida.schema import RESPONSE, SPECIAL, labelled, labelled_dataset

ZETA, DELTA0 = 0.07, 2.0
NAMES = ("x", "y", "vx", "vy")
# The first branch, and speeds of the simulated rotor.
LIMITS = (1.6, 2.1)
HIGHEST, MIDDLE, LOWEST = 1.82, 1.71, 1.685
# Each further branch is continued down by this fraction of the previous doubling distance.
AHEAD = 0.6
REVOLUTIONS = 150
PERIODS = 2
FEIGENBAUM = 4.669201609


def main(settings: Settings) -> None:
    branches = cascade(3 if settings.quick else 6)
    for number, branch in enumerate(branches, start=1):
        settings.keep(branch, f"branch_{number}")
    places = [first_doubling(branch) for branch in branches]
    end = places[-1][0] - (places[-2][0] - places[-1][0]) / (FEIGENBAUM - 1.0)

    each = 6 if settings.quick else 36
    speeds = np.unique([np.linspace(LOWEST, MIDDLE, each), np.linspace(MIDDLE, HIGHEST, each)])
    begin = limit_cycle(Rotor(omega=2.0, zeta=ZETA, delta0=DELTA0), start=(0, 0, 0, 0))
    start = [float(begin[name][0]) for name in NAMES]
    with progress_bar("speed down") as progress:
        down = sweep(
            omega=speeds, zeta=ZETA, delta0=DELTA0, starts=[start], direction="down",
            method="taylor", workers=1, progress=progress,
        )  # fmt: skip
    settings.keep(down, "down")
    radii = largest_radii(down.squeeze(["zeta", "delta0", "start", "direction"]))
    settings.keep(radii, "radii")
    draw(places, end, radii, settings)
    Console().print(table(places))


def cascade(count: int) -> list[xr.Dataset]:
    """Return `count` branches: that of the cycle at omega = 2, and those it doubles into."""
    rotor = Rotor(omega=2.0, zeta=ZETA, delta0=DELTA0)
    branches = [continue_cycle(rotor, start=(0, 0, 0, 0), limits=LIMITS)]
    places = [first_doubling(branches[0])]
    while len(branches) < count:
        omega, _, number = places[-1]
        gap = places[-2][0] - omega if len(places) > 1 else omega - LIMITS[0]
        branches.append(
            continue_cycle(
                rotor,
                start=branches[-1].isel(special=number),
                limits=(omega - AHEAD * gap, LIMITS[1]),
            )
        )
        places.append(first_doubling(branches[-1], before=omega))
    return branches


def first_doubling(branch: xr.Dataset, before: float = np.inf) -> tuple[float, float, int]:
    """Return speed, period and number of the uppermost doubling of a branch below a speed."""
    own = branch.special_kind.values == SPECIAL["period_doubling"]
    own &= branch.special_value.values < before - 1e-9
    number = int(np.argmax(np.where(own, branch.special_value.values, -np.inf)))
    return float(branch.special_value[number]), float(branch.special_period[number]), number


def largest_radii(down: xr.Dataset) -> xr.Dataset:
    """Return the local maxima of |z| and the largest exponent beside that of a shift."""
    radii, exponents, errors = [], [], []
    for omega in down.omega.values.tolist():
        here = down.sel(omega=omega)
        rotor = Rotor(omega=omega, zeta=ZETA, delta0=DELTA0)
        start = [float(here[f"end_{name}"]) for name in NAMES]
        revolutions, exponent, error = REVOLUTIONS, *chaos_of(here)
        if np.isfinite(here.period):
            cycle = limit_cycle(rotor, start=start, period=float(here.period))
            revolutions = int(np.ceil(PERIODS * float(cycle.period) * omega / (2.0 * np.pi)))
            exponent, error = exponent_of(cycle), 0.0
        touches = int(here.response) != RESPONSE["contact_free"]
        section = poincare_section(rotor, start=start, revolutions=revolutions, at="peak")
        peaks = np.hypot(section.rotating_x.values, section.rotating_y.values)
        radii.append(peaks if touches else np.empty(0))
        exponents.append(exponent)
        errors.append(error)
    counts = np.array([part.size for part in radii])
    variables = {
        "extremum_count": labelled("extremum_count", "omega", counts),
        "extremum_row": labelled("extremum_row", "omega", np.cumsum(counts) - counts),
        "extremum_radius": labelled("extremum_radius", "extremum", np.concatenate(radii)),
        "lyapunov_exponent": labelled("lyapunov_exponent", "omega", exponents),
        "lyapunov_error": labelled("lyapunov_error", "omega", errors),
        "response": down.response.variable,
    }
    variables["extremum_count"].attrs["sample_dimension"] = "extremum"
    coordinates = {name: down[name].variable for name in ("omega", "zeta", "delta0")}
    return labelled_dataset("Largest radii and exponents, speed going down", variables, coordinates)


def chaos_of(here: xr.Dataset) -> tuple[float, float]:
    """Return the exponent and its error from the sweep, NaN where it computed none."""
    return float(here.lyapunov_exponent), float(here.lyapunov_error)


def exponent_of(cycle: xr.Dataset) -> float:
    """Return the slowest decay rate of disturbances of a cycle, from its multipliers."""
    sizes = np.hypot(cycle.multiplier_real.values, cycle.multiplier_imag.values)
    others = np.delete(sizes, np.argmin(np.abs(cycle.multiplier_real.values - 1.0)))
    return float(np.log(others.max()) / cycle.period)


def draw(
    places: list[tuple[float, float, int]], end: float, radii: xr.Dataset, settings: Settings
) -> None:
    figure, axes = panels(3, 1, height=8.6, shared=False)
    omega = np.repeat(radii.omega.values, radii.extremum_count.values)
    chaotic = radii.response.values == RESPONSE["chaotic"]
    with style():
        for ax in axes[:2]:
            ax.plot(omega, radii.extremum_radius, ls="", marker="o", ms=1.4, mec="none", mfc=BLUE,
                    rasterized=True)  # fmt: skip
            ax.plot([], [], ls="", marker="o", ms=3.0, mec="none", mfc=BLUE, label="simulated")
            ax.set_ylabel("maxima of $|z|$")
        for chosen, face, words in ((~chaotic, "white", "limit cycle"), (chaotic, BLUE, "chaos")):
            part = radii.isel(omega=np.flatnonzero(chosen))
            axes[2].errorbar(
                part.omega, part.lyapunov_exponent, yerr=part.lyapunov_error, fmt="o", ms=3.0,
                color=BLUE, mfc=face, elinewidth=0.8, label=words,
            )  # fmt: skip
        axes[2].axhline(0.0, color=GREY, lw=0.8)
        for ax in axes:
            for number, (place, _, _) in enumerate(places):
                ax.axvline(place, color=ORANGE, lw=0.9, ls="--", zorder=1.5,
                           label="period doubling" if number == 0 else None)  # fmt: skip
            ax.axvline(end, color="k", lw=0.9, ls=":", label="end of the cascade")
        axes[0].set(xlim=(LOWEST, HIGHEST), title=rf"$\zeta = {ZETA},\ \delta_0 = {DELTA0:g}$")
        axes[1].set_xlim(LOWEST, MIDDLE)
        axes[2].set(xlim=(LOWEST, MIDDLE), xlabel=LABELS["omega"], ylabel="largest exponent")
        shared_legend(figure, axes, columns=5, outer=False)
    told = ", ".join(
        f"{value:.4f} ± {error:.4f} at ω = {speed:.4f}"
        for speed, value, error in zip(
            radii.omega.values[chaotic], radii.lyapunov_exponent.values[chaotic],
            radii.lyapunov_error.values[chaotic], strict=True,
        )
    )  # fmt: skip
    words = f"exponents {told}" if told else "none of the speeds simulated is chaotic"
    ratios = ratios_of(places)
    settings.show(
        figure,
        "doubling_cascade",
        archives=["down", "radii", *(f"branch_{number + 1}" for number in range(len(places)))],
        shows="The largest radii of a simulated rotor as the speed falls, with the exact period "
        "doublings; the same enlarged; and the largest exponent beside that of a shift.",
        found=f"Doublings at ω = {', '.join(f'{place:.9f}' for place, _, _ in places)}. Their "
        f"distances shrink by {', '.join(f'{ratio:.4f}' for ratio in ratios)}; Feigenbaum's factor "
        f"is 4.6692. By it the cascade ends at ω = {end:.6f}; below it: {words}.",
    )


def ratios_of(places: list[tuple[float, float, int]]) -> list[float]:
    """Return the ratios of successive distances between doublings."""
    gaps = -np.diff([place for place, _, _ in places])
    return (gaps[:-1] / gaps[1:]).tolist()


def table(places: list[tuple[float, float, int]]) -> Table:
    """Return the doublings as a table."""
    shown = Table("doubling", title="Period doublings", box=SIMPLE_HEAD, padding=0, show_edge=False)
    for name in ("omega", "period", "ratio of distances"):
        shown.add_column(name, justify="right")
    ratios = ["", "", *(f"{ratio:.5f}" for ratio in ratios_of(places))]
    for number, (omega, period, _) in enumerate(places):
        shown.add_row(f"{number + 1}", f"{omega:.12f}", f"{period:.9f}", ratios[number])
    return shown


if __name__ == "__main__":
    sys.exit(run_script(main, description=__doc__, script=__file__))
