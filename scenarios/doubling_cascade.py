"""A cascade of period doublings into chaos, at delta0 = 2.

At zeta = 0.07 the stable cycle on which the rotor bounces at omega = 2 doubles its period near
omega = 1.803 when the speed falls; the doubled cycle doubles again, and so on, ever faster: the
distances shrink in the end by Feigenbaum's factor 4.669. Each doubling is located on its exact
branch, and the next branch is entered there. A simulated rotor that is led down slowly shows the
same: its largest radii split, and beyond the end of the cascade they fill bands, where the largest
Lyapunov exponent is positive.

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
    lyapunov_exponent,
    poincare_section,
    sweep,
)
from rotor_ida.paper.scenario import Settings, progress_bar, run_script
from rotor_ida.plot import panels
from rotor_ida.plot.appearance import BLUE, GREY, ORANGE, own_legend, style
from rotor_ida.plot.labels import LABELS
from rotor_ida.schema import RESPONSE, SPECIAL, labelled, labelled_dataset

ZETA, DELTA0 = 0.07, 2.0
NAMES = ("x", "y", "vx", "vy")
# The first branch, and speeds of the simulated rotor.
LIMITS = (1.6, 2.1)
HIGHEST, LOWEST = 1.82, 1.685
# Each further branch is followed down by so much of the distance between the doublings before.
AHEAD = 0.6
REVOLUTIONS = 150
FEIGENBAUM = 4.669201609


def main(settings: Settings) -> None:
    branches = cascade(3 if settings.quick else 6)
    for number, branch in enumerate(branches, start=1):
        settings.keep(branch, f"branch_{number}")
    places = [first_doubling(branch) for branch in branches]
    end = places[-1][0] - (places[-2][0] - places[-1][0]) / (FEIGENBAUM - 1.0)

    speeds = np.linspace(LOWEST, HIGHEST, 12 if settings.quick else 109)
    begin = limit_cycle(Rotor(omega=2.0, zeta=ZETA, delta0=DELTA0), start=(0, 0, 0, 0))
    start = [float(begin[name][0]) for name in NAMES]
    with progress_bar("speed down") as progress:
        down = sweep(
            omega=speeds, zeta=ZETA, delta0=DELTA0, starts=[start], direction="down",
            workers=1, progress=progress,
        )  # fmt: skip
    settings.keep(down, "down")
    radii = largest_radii(down.squeeze(["zeta", "delta0", "start", "direction"]))
    settings.keep(radii, "radii")
    draw(places, end, radii, settings)
    Console().print(table(places))


def cascade(count: int) -> list[xr.Dataset]:
    """Return the branch of the cycle at omega = 2, and so many less one that it doubles into."""
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
    """Return the local maxima of |z| and the largest Lyapunov exponent at each speed."""
    radii, exponents, errors = [], [], []
    for omega in down.omega.values.tolist():
        here = down.sel(omega=omega)
        rotor = Rotor(omega=omega, zeta=ZETA, delta0=DELTA0)
        start = [float(here[f"end_{name}"]) for name in NAMES]
        if int(here.response) == RESPONSE["contact_free"]:
            radii.append(np.empty(0))
            exponents.append(np.nan)
            errors.append(np.nan)
            continue
        section = poincare_section(rotor, start=start, revolutions=REVOLUTIONS, at="peak")
        radii.append(np.hypot(section.rotating_x.values, section.rotating_y.values))
        found = lyapunov_exponent(rotor, start=start, transient=200.0, duration=4000.0)
        # a shift along the orbit has the exponent 0: the next one tells, where none is positive
        largest = int(np.argmax(found.lyapunov_exponent.values))
        exponents.append(float(found.lyapunov_exponent[largest]))
        errors.append(float(found.lyapunov_error[largest]))
    variables = {
        "extremum_count": labelled("extremum_count", "omega", [part.size for part in radii]),
        "extremum_radius": labelled("extremum_radius", "extremum", np.concatenate(radii)),
        "lyapunov_exponent": labelled("lyapunov_exponent", "omega", exponents),
        "lyapunov_error": labelled("lyapunov_error", "omega", errors),
        "response": down.response.variable,
    }
    variables["extremum_count"].attrs["sample_dimension"] = "extremum"
    coordinates = {name: down[name].variable for name in ("omega", "zeta", "delta0")}
    return labelled_dataset("Largest radii and exponents, speed going down", variables, coordinates)


def draw(
    places: list[tuple[float, float, int]], end: float, radii: xr.Dataset, settings: Settings
) -> None:
    figure, (above, below) = panels(2, 1, height=6.4, shared=False)
    omega = np.repeat(radii.omega.values, radii.extremum_count.values)
    with style():
        above.plot(omega, radii.extremum_radius, ls="", marker="o", ms=1.3, mec="none", mfc=BLUE,
                   rasterized=True, label="simulated, speed going down")  # fmt: skip
        below.errorbar(
            radii.omega, radii.lyapunov_exponent, yerr=radii.lyapunov_error, fmt="o", ms=2.5,
            color=BLUE, elinewidth=0.8, label="largest Lyapunov exponent",
        )  # fmt: skip
        below.axhline(0.0, color=GREY, lw=0.8)
        for ax in (above, below):
            for number, (place, _, _) in enumerate(places):
                ax.axvline(place, color=ORANGE, lw=0.9, ls="--", zorder=1.5,
                           label="period doubling" if number == 0 else None)  # fmt: skip
            ax.axvline(end, color="k", lw=0.8, ls=":", label="end of the cascade")
            ax.set_xlim(LOWEST, HIGHEST)
            ax.tick_params(labelbottom=True)
            own_legend(ax)
        above.set(ylabel="maxima of $|z|$", title=r"$\zeta = 0.07,\ \delta_0 = 2$")
        below.set(xlabel=LABELS["omega"], ylabel="exponent")
    ratios = ratios_of(places)
    chaotic = radii.omega.values[radii.response.values == RESPONSE["chaotic"]]
    if chaotic.size:
        told = ", ".join(
            f"{float(radii.lyapunov_exponent.sel(omega=each)):.4f} at ω = {each:.5f}"
            for each in chaotic
        )
        words = f"The simulated rotor is chaotic at {chaotic.size} of the speeds: {told}."
    else:
        words = "At none of the speeds simulated is the rotor chaotic."
    settings.show(
        figure,
        "doubling_cascade",
        archives=["down", "radii", *(f"branch_{number + 1}" for number in range(len(places)))],
        shows="The largest radii of a simulated rotor led down in speed, with the exact period "
        "doublings; and its largest Lyapunov exponent.",
        found=f"Doublings at ω = {', '.join(f'{place:.9f}' for place, _, _ in places)}. Their "
        f"distances shrink by {', '.join(f'{ratio:.4f}' for ratio in ratios)}; Feigenbaum's factor "
        f"is 4.6692. By it the cascade ends at ω = {end:.6f}. {words}",
    )


def ratios_of(places: list[tuple[float, float, int]]) -> list[float]:
    """Return by what factor the distance of two doublings shrinks to the next one."""
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
