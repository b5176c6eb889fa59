"""What a shaft that springs back does: amplitude over speed, without, with a soft and a stiff one.

Most publications on rotors that touch their stator have a shaft and a linear ring; the rotor of the
paper has neither. Here both are put side by side, at zeta = 0.07 and delta0 = 2: no shaft, a soft
and a stiff one, in a linear ring and in one of Hertz. Without a shaft the whirls in contact are an
isola, which a rotor from rest never comes to. A shaft has a critical speed of its own; as long as
the whirl does not reach the ring there, the isola stays one. With a stiffer shaft the isola grows
out of the resonance, and a rotor from rest climbs it. Beside the whirls lie limit cycles on which
the rotor bounces, on isolas of their own, at higher speeds the stiffer the shaft. Simulated rotors,
from rest with the speed going up and down and from pushes at each speed, lie on the exact results.

Writes the exact curves (curves.nc), the sweeps (up_down.nc, pushed.nc), the branches of limit
cycles (cycles_1.nc and so on), and the figure as PNG and SVG.
"""

import sys
from collections.abc import Sequence

import numpy as np
import xarray as xr

from rotor_ida import Rotor, continue_cycle, folds, limit_cycle, sweep, synchronous_response
from rotor_ida.closed_forms import response_curve
from rotor_ida.paper.scenario import Settings, progress_bar, run_script, scientific
from rotor_ida.plot import panels, plot_amplitude, plot_branch, shared_legend
from rotor_ida.schema import RESPONSE, SPECIAL

ZETA, DELTA0 = 0.07, 2.0
SHAFTS = {0.0: "no shaft", 0.05: "soft shaft", 0.25: "stiff shaft"}
RINGS = {1.0: "linear ring", 1.5: "ring of Hertz"}
LIMITS = (0.05, 4.2)
PUSHES = [(4.0, 0.0, 0.0, 0.0), (0.0, 4.0, -2.0, 2.0), (-3.0, 0.0, 0.0, 3.0)]
CYCLES = [RESPONSE["bouncing"], RESPONSE["full_contact"]]
# Cycles whose largest radii at one speed are as near as this are one.
NEAR = 0.03


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
    branches = branches_of(sweeps[1])
    for number, branch in enumerate(branches, start=1):
        settings.keep(branch, f"cycles_{number}")
    draw(exact, sweeps, branches, settings)


def branches_of(swept: xr.Dataset) -> list[xr.Dataset]:
    """Return the branches of limit cycles that simulated rotors are met on."""
    branches: list[xr.Dataset] = []
    for point in responses(swept, CYCLES):
        rotor = rotor_at(point)
        if nearest(point, of_rotor(branches, point)) is None:
            start = [point[f"start_{name}"].item() for name in ("x", "y", "vx", "vy")]
            branches.append(continue_cycle(rotor, start=start, limits=LIMITS))
    return branches


def responses(swept: xr.Dataset, kinds: Sequence[int]) -> list[xr.Dataset]:
    """Return the points of a sweep at which the rotor has a response of some kinds."""
    flat = swept.drop_dims("event").stack(point=swept.response.dims)
    chosen = np.flatnonzero(np.isin(flat.response, kinds))
    return [flat.isel(point=number) for number in chosen]


def rotor_at(point: xr.Dataset) -> Rotor:
    names = ("omega", "zeta", "delta0", "shaft_stiffness", "contact_exponent")
    return Rotor(**{name: point[name].item() for name in names})


def of_rotor(branches: Sequence[xr.Dataset], here: xr.Dataset) -> list[xr.Dataset]:
    """Return the branches with the shaft and the ring of a point."""
    shaft, ring = here.shaft_stiffness.item(), here.contact_exponent.item()
    return [
        branch for branch in branches
        if (float(branch.get("shaft_stiffness", 0.0)), float(branch.get("contact_exponent", 1.5)))
        == (shaft, ring)
    ]  # fmt: skip


def nearest(point: xr.Dataset, branches: Sequence[xr.Dataset]) -> xr.Dataset | None:
    """Return the point of a branch nearest to a simulated cycle, if one passes it."""
    omega, radius = point.omega.item(), point.radius_max.item()
    for branch in branches:
        before = branch.omega.values[:-1] - omega
        after = branch.omega.values[1:] - omega
        for place in np.flatnonzero(before * after <= 0.0):
            part = before[place] / (before[place] - after[place])
            low, high = branch.radius_max.values[place : place + 2]
            if abs(low + part * (high - low) - radius) < NEAR:
                return branch.isel(point=place + round(part))
    return None


def furthest_from_whirls(swept: xr.Dataset) -> float:
    """Return by how much simulated whirls in contact miss the amplitude of exact ones, at most."""
    missed = 0.0
    for point in responses(swept, [RESPONSE["synchronous"]]):
        whirls = synchronous_response(**rotor_at(point).given)
        apart = np.abs(whirls.amplitude.values - point.amplitude.item())
        missed = max(missed, float(np.nanmin(apart)) / point.amplitude.item())
    return missed


def furthest_from_cycles(
    swept: xr.Dataset, branches: Sequence[xr.Dataset]
) -> tuple[int, int, float]:
    """Return how many simulated cycles there are, how many are exact ones, and how nearly."""
    missed, points = [], responses(swept, CYCLES)
    for point in points:
        near = nearest(point, of_rotor(branches, point))
        if near is None:
            continue
        start = [near[name].item() for name in ("x", "y", "vx", "vy")]
        cycle = limit_cycle(rotor_at(point), start=start, period=near.period.item())
        missed.append(abs(cycle.radius_max.item() / point.radius_max.item() - 1.0))
    return len(points), len(missed), max(missed, default=0.0)


def draw(
    exact: xr.Dataset,
    sweeps: Sequence[xr.Dataset],
    branches: Sequence[xr.Dataset],
    settings: Settings,
) -> None:
    figure, axes = panels(3, 2, height=8.6)
    places = [(shaft, ring) for shaft in SHAFTS for ring in RINGS]
    for ax, (shaft, ring) in zip(axes, places, strict=True):
        here = {"shaft_stiffness": shaft, "contact_exponent": ring}
        curve = exact.sel(here)
        for swept in sweeps:
            plot_amplitude(curve, simulated=swept.sel(here), fold_points=curve, ax=ax)
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
        f"(κ = 0.05) and a stiff one (κ = 0.25), in a linear ring and in one of Hertz: exact "
        "whirls, branches of limit cycles, and simulated rotors.",
        found=told(exact, sweeps, branches),
    )  # fmt: skip


def is_isola(curve: xr.Dataset) -> bool:
    """Return whether the whirls in contact are a closed curve of their own."""
    piece = curve.piece.values.ravel()
    points = np.flatnonzero(piece == piece.max())
    ends = curve.omega.values.ravel()[points[[0, -1]]]
    return bool(ends[0] == ends[1])


def told(exact: xr.Dataset, sweeps: Sequence[xr.Dataset], branches: Sequence[xr.Dataset]) -> str:
    """Return what the gallery says of the figure."""
    rows, leading = [], {}
    for ring, name in RINGS.items():
        reached = []
        for shaft, words in SHAFTS.items():
            here = {"shaft_stiffness": shaft, "contact_exponent": ring}
            from_rest = sweeps[0].sel(here)
            largest = (np.nanmax(each.amplitude.values) for each in (from_rest, exact.sel(here)))
            reached.append(" of ".join(f"{each:.2f}" for each in largest))
            if (from_rest.response == RESPONSE["synchronous"]).any():
                leading[words] = True
        rows.append(f"in the {name} to {', '.join(reached[:-1])} and {reached[-1]}")
    whirls = max(furthest_from_whirls(swept) for swept in sweeps)
    counted = [furthest_from_cycles(swept, branches) for swept in sweeps]
    met, exactly = (sum(each[place] for each in counted) for place in (0, 1))
    closed = sum(int(branch.attrs["closed"]) for branch in branches)
    return (
        f"From rest, with the speed going up and down, the rotor comes {'; '.join(rows)}, without "
        "a shaft, with the soft and with the stiff one. What leads from rest to the whirls in "
        f"contact: {' and '.join(leading) or 'none'}. Simulated whirls in contact are exact to "
        f"{scientific(whirls)}. Pushed rotors bounce or stay in contact {met} times, {exactly} of "
        f"them on one of {len(branches)} branches of limit cycles, {closed} of these isolas, to "
        f"{scientific(max(each[2] for each in counted))} of the radius."
    )


if __name__ == "__main__":
    sys.exit(run_script(main, description=__doc__, script=__file__))
