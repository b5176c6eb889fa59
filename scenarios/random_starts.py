"""Figure 11 from random starts: basin fractions of the attractors.

Three parameter points are each computed from two independent samples of starts in the box
|x|, |y| <= 10, |x'|, |y'| <= 10, which must agree within their sampling errors. The attractors of
four clearances are continued over the speed.

Writes the basin fractions (netCDF) and a figure as PNG and SVG, and prints the comparison of the
samples.
"""

import sys

import numpy as np
import xarray as xr

from rotor_ida import Rotor, basin_fractions, continue_attractors
from rotor_ida.paper.scenario import Settings, progress_bar, run_script
from rotor_ida.plot import panels, plot_attractors, shared_legend
from rotor_ida.schema import RESPONSE

ZETA = 0.07
POINTS = ((1.7, 0.5), (2.0, 2.0), (3.0, 0.5))
CLEARANCES = (0.0, 0.5, 1.0, 2.0)
BOX = dict.fromkeys(("x", "y", "vx", "vy"), (-10.0, 10.0))


def main(settings: Settings) -> None:
    starts = 300 if settings.quick else 3000
    furthest = 0.0
    for omega, delta0 in POINTS:
        pair = [reached(omega, delta0, starts, seed, settings) for seed in (1, 2)]
        for number, found in enumerate(pair, start=1):
            settings.keep(found, f"omega_{omega:g}_delta0_{delta0:g}_sample_{number}")
        furthest = max(furthest, apart(*pair))
        print(f"omega {omega:g}, delta0 {delta0:g}: {in_words(pair[0])}")
    print(f"two samples differ by at most {furthest:.1f} standard errors")

    speeds = np.linspace(0.2, 3.0, 4 if settings.quick else 57)
    each = 40 if settings.quick else 400
    figure, axes = panels(2, 2, height=6.0)
    most: list[str] = []
    again = alike = 0.0
    for ax, delta0 in zip(axes, CLEARANCES, strict=True):
        with progress_bar(f"attractors at clearance {delta0:g}") as progress:
            over_speed = continue_attractors(
                omega=speeds, zeta=ZETA, delta0=delta0, **BOX, starts=each, seed=3,
                workers=settings.workers, progress=progress,
            )  # fmt: skip
        settings.keep(over_speed, f"over_speed_delta0_{delta0:g}")
        plot_attractors(over_speed, ax=ax)
        most += off_the_curve(over_speed, delta0)
        again += float(over_speed.agreement_count.sum())
        alike += float((over_speed.agreement * over_speed.agreement_count).sum())
        if delta0 == 0.0:
            on_whirls = part_on_whirls(over_speed)
    shared_legend(figure, axes, columns=5)
    settings.show(
        figure, "basin_fractions",
        archives=[f"over_speed_delta0_{delta0:g}" for delta0 in CLEARANCES],
        shows="The fraction of random starts that ends on each attractor, over the speed, for four "
        "clearances; shades of one colour are attractors of one kind of response.",
        paper="Analytical and numerical results are in good agreement for every clearance.",
        verdict="Without clearance they are; with clearance not for most starts at high speed.",
        found=f"Without clearance {on_whirls:.2%} of the starts end on a synchronous whirl. With "
        "clearance most starts bounce or stay in contact at a radius that is not constant "
        f"{', '.join(most)}. Two samples at three points differ by at most {furthest:.1f} "
        f"standard errors. Of {again:.0f} labels over the speed that were recomputed with a "
        f"smaller error {alike / again:.2%} are the same.",
    )  # fmt: skip


def reached(omega, delta0, starts, seed, settings):
    """Return the basin fractions from random starts in the box."""
    rotor = Rotor(omega=float(omega), zeta=ZETA, delta0=delta0)
    return basin_fractions(rotor, **BOX, starts=starts, seed=seed, workers=settings.workers)


def part_on_whirls(over_speed: xr.Dataset) -> float:
    """Return the fraction of all starts that end on synchronous whirls."""
    whirls = over_speed.kind == RESPONSE["synchronous"]
    return float(over_speed.fraction.where(whirls, 0.0).sum("attractor").mean())


def off_the_curve(over_speed: xr.Dataset, delta0: float) -> list[str]:
    """Return the speed from which most starts end off every response curve, in words."""
    off = over_speed.kind.isin([RESPONSE[kind] for kind in ("bouncing", "full_contact", "chaotic")])
    most = over_speed.fraction.where(off, 0.0).sum("attractor").squeeze().values > 0.5
    if not most.any():
        return []
    return [f"from ω = {over_speed.omega[most].min().item():.2g} on at δ₀ = {delta0:g}"]


def apart(one: xr.Dataset, other: xr.Dataset) -> float:
    """Return the largest difference of two samples' fractions, in standard errors."""
    difference = np.abs(one.response_fraction - other.response_fraction)
    error = np.hypot(one.response_fraction_error, other.response_fraction_error)
    return float((difference / error.where(error > 0.0, np.inf)).max())


def in_words(found: xr.Dataset) -> str:
    words = str(found.response.attrs["flag_meanings"]).split()
    numbers = list(found.response.attrs["flag_values"])
    parts = [
        f"{words[numbers.index(kind)]} {share:.3f} +- {error:.3f}"
        for kind, share, error in zip(
            found.response.values,
            found.response_fraction.values,
            found.response_fraction_error.values,
            strict=True,
        )
        if share > 0.0
    ]
    return ", ".join(parts)


if __name__ == "__main__":
    sys.exit(run_script(main, description=__doc__, script=__file__))
