"""Effect of shaft stiffness on amplitude over speed: no shaft, a soft one and a stiff one.

Most publications on rotor-stator contact have a shaft and a linear stator; the rotor of the paper
has neither. Here they are compared at zeta = 0.07 and delta0 = 2: no shaft, a soft and a stiff one,
in a linear and in a Hertzian stator. Without a shaft the contacting whirls are an isola, which a
rotor from rest never reaches. A shaft adds a critical speed. The isola remains as long as the whirl
does not reach the stator there. With a stiffer shaft the isola joins the resonance, and a rotor
from rest climbs it. Bouncing limit cycles lie on further isolas, at higher speeds for a stiffer
shaft. Simulated rotors, from rest with the speed going up and down and from pushes at each speed,
agree with the exact results.

Writes the exact curves (curves.nc), the sweeps (up_down.nc, pushed.nc), the branches of limit
cycles (cycles_1.nc and so on), and the figure as PNG and SVG.
"""

import sys
from collections.abc import Sequence

import numpy as np
import xarray as xr

from rotor_ida import branches_through, compare, folds, sweep
from rotor_ida.closed_forms import response_curve
from rotor_ida.paper.scenario import Settings, progress_bar, run_script, scientific
from rotor_ida.plot import panels, plot_amplitude, plot_branch, shared_legend
from rotor_ida.schema import EXACT, RESPONSE, SPECIAL

ZETA, DELTA0 = 0.07, 2.0
SHAFTS = {0.0: "no shaft", 0.05: "soft shaft", 0.25: "stiff shaft"}
RINGS = {1.0: "linear stator", 1.5: "Hertzian stator"}
LIMITS = (0.05, 4.2)
PUSHES = [(4.0, 0.0, 0.0, 0.0), (0.0, 4.0, -2.0, 2.0), (-3.0, 0.0, 0.0, 3.0)]
WHIRLS, CYCLES = [RESPONSE["synchronous"]], [RESPONSE["bouncing"], RESPONSE["full_contact"]]


def main(settings: Settings) -> None:
    given = {"zeta": ZETA, "delta0": DELTA0}
    beyond = {"shaft_stiffness": list(SHAFTS), "contact_exponent": list(RINGS)}
    exact = xr.merge(
        [response_curve(**given, **beyond, limits=LIMITS), folds(**given, **beyond)],
        compat="equals", join="exact", combine_attrs="override",
    )  # fmt: skip
    settings.keep(exact, "curves")
    sweeps = []
    for name, number, how in (
        ("up_down", 24 if settings.quick else 60, {"direction": "both"}),
        ("pushed", 6 if settings.quick else 20, {"starts": PUSHES}),
    ):
        with progress_bar(name.replace("_", " and ")) as progress:
            sweeps.append(
                sweep(
                    omega=np.linspace(0.2, 4.0, number), **given, **beyond, **how,
                    method="taylor", workers=settings.workers, progress=progress,
                )
            )  # fmt: skip
        settings.keep(sweeps[-1], name)
    compared = [compare(swept) for swept in sweeps]
    branches = branches_through(compared[1], limits=LIMITS)
    for number, branch in enumerate(branches, start=1):
        settings.keep(branch, f"cycles_{number}")
    draw(exact, compared, branches, settings)


def of_rotor(branches: Sequence[xr.Dataset], here: xr.Dataset) -> list[xr.Dataset]:
    """Return the branches with the shaft and the stator of a point."""
    shaft, ring = here.shaft_stiffness.item(), here.contact_exponent.item()
    return [
        branch for branch in branches
        if (float(branch.get("shaft_stiffness", 0.0)), float(branch.get("contact_exponent", 1.5)))
        == (shaft, ring)
    ]  # fmt: skip


def agreement(compared: Sequence[xr.Dataset], kinds: Sequence[int]) -> tuple[int, int, float]:
    """Return the count of responses of some kinds, the exact ones among them, and their error."""
    met = exactly = 0
    missed = 0.0
    for each in compared:
        is_such = each.response.isin(kinds)
        is_exact = is_such & (each.lies_on != EXACT["nothing"])
        met, exactly = met + int(is_such.sum()), exactly + int(is_exact.sum())
        missed = max(missed, float((10.0**-each.digits).where(is_exact, 0.0).max()))
    return met, exactly, missed


def draw(
    exact: xr.Dataset,
    compared: Sequence[xr.Dataset],
    branches: Sequence[xr.Dataset],
    settings: Settings,
) -> None:
    figure, axes = panels(3, 2, height=8.6)
    places = [(shaft, ring) for shaft in SHAFTS for ring in RINGS]
    for ax, (shaft, ring) in zip(axes, places, strict=True):
        here = {"shaft_stiffness": shaft, "contact_exponent": ring}
        curve = exact.sel(here)
        for each in compared:
            plot_amplitude(curve, simulated=each.sel(here), fold_points=curve, ax=ax)
        for branch in of_rotor(branches, curve):
            without = np.flatnonzero(branch.special_kind != SPECIAL["graze"])
            plot_branch(branch.isel(special=without), ax=ax)
        size = axes[0].title.get_fontsize()
        form = "an isola" if is_isola(curve) else "grown out of the resonance"
        ax.set_title(f"{SHAFTS[shaft]}, {RINGS[ring]}: {form}", fontsize=size)
        ax.set(xlim=(0.0, LIMITS[1]), ylabel="amplitude $A$, radius $|z|$")
    shared_legend(figure, axes, columns=4)
    settings.show(
        figure, "shaft",
        archives=["curves", "up_down", "pushed",
                  *(f"cycles_{number + 1}" for number in range(len(branches)))],
        shows=f"Amplitude over speed at ζ = {ZETA}, δ₀ = {DELTA0:g} without a shaft, with a soft "
        f"(κ = 0.05) and a stiff one (κ = 0.25), in a linear stator and in a Hertzian one: exact "
        "whirls, branches of limit cycles, and simulated rotors.",
        found=told(exact, compared, branches),
    )  # fmt: skip


def is_isola(curve: xr.Dataset) -> bool:
    """Return whether the whirls in contact form a separate closed curve."""
    piece = curve.piece.values.ravel()
    points = np.flatnonzero(piece == piece.max())
    ends = curve.omega.values.ravel()[points[[0, -1]]]
    return bool(ends[0] == ends[1])


def told(exact: xr.Dataset, compared: Sequence[xr.Dataset], branches: Sequence[xr.Dataset]) -> str:
    """Return the gallery text on the figure."""
    rows, leading = [], {}
    for ring, name in RINGS.items():
        reached = []
        for shaft, words in SHAFTS.items():
            here = {"shaft_stiffness": shaft, "contact_exponent": ring}
            from_rest = compared[0].sel(here)
            largest = (np.nanmax(each.amplitude.values) for each in (from_rest, exact.sel(here)))
            reached.append(" of ".join(f"{each:.2f}" for each in largest))
            if (from_rest.response == RESPONSE["synchronous"]).any():
                leading[words] = True
        rows.append(f"in the {name}, {', '.join(reached[:-1])} and {reached[-1]}")
    whirls, exact_whirls, whirls_missed = agreement(compared, WHIRLS)
    cycles, exact_cycles, cycles_missed = agreement(compared, CYCLES)
    closed = sum(int(branch.attrs["closed"]) for branch in branches)
    return (
        f"From rest, with the speed going up and down, the radius reaches, {'; '.join(rows)}, "
        "without a shaft, with the soft and with the stiff one. Shafts with which the rotor "
        f"reaches the whirls in contact from rest: {' and '.join(leading) or 'none'}. Of {whirls} "
        f"simulated whirls in contact {exact_whirls} are exact ones, to "
        f"{scientific(whirls_missed)}. Pushed rotors bounce or stay in contact {cycles} times, "
        f"{exact_cycles} of them on one of {len(branches)} branches of limit cycles, {closed} of "
        f"these isolas, to {scientific(cycles_missed)}."
    )


if __name__ == "__main__":
    sys.exit(run_script(main, description=__doc__, script=__file__))
