"""Sheets of drops: what they were computed from, one drop, and many."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import xarray as xr

from rotor_ida.cli.variables import line_of
from rotor_ida.results.sheets import Interval, Line, Sheet, facts
from rotor_ida.schema import OF_BEARING, OF_DROP, WHIRL_DIRECTION
from rotor_ida.steady.drop_words import cells_in, count_of, place_of, places_in, varying
from rotor_ida.units import number, quantity

SHARES = {
    "backward_whirl": "with a backward whirl of three turns", "rest": "in contact at the end",
    "decided": "whose largest force comes before the horizon",
    "overload": "whose largest force is above the load capacity",
}  # fmt: skip
# Cells of a grid that a page lists; the archive has all. Digits of figures of bearings.
MOST_CELLS, DIGITS = 200, 4


def tables_of(run: xr.Dataset, drops: xr.Dataset | None) -> list[Sheet]:
    """Return what a report tells of one drop and of many, and from what they were computed."""
    many = [] if drops is None else drops_tables(drops)
    found = [*acceptance(run, drops), *run_tables(run), *many, _conditions(run)]
    if run.sizes.get("support"):
        loads = run["support_load"].values
        noise = 1e-9 * float(np.abs(loads).max(initial=0.0))
        lines = [
            Line(f"static load {axis}", [0.0 if abs(each) <= noise else each for each in values],
                 "N", DIGITS)
            for axis, values in zip("xy", loads.T.tolist(), strict=True)
        ]  # fmt: skip
        lines.append(Line("fails", run["support_fails"].values.astype(bool).tolist()))
        found.append(Sheet("Magnetic bearings before the drop", lines, _names(run["support_node"])))
    return found if drops is None else [*found, _varied(drops)]


def _conditions(run: xr.Dataset) -> Sheet:
    """Return the conditions of one drop."""
    phase = float(run.attrs["phase"])
    speed = float(run.attrs.get("start_speed", run.attrs.get("speed", math.nan)))
    lines = [Line("speed at the drop", [speed], "rad/s"),
             Line("duration", [float(run.attrs["duration"])], "s"),
             Line("angle of the rotor at the drop", [phase], "radian")]  # fmt: skip
    if "inertia" in run.attrs:
        drag = float(np.ravel(run.attrs["torque"])[1])
        lines += [Line("inertia about the axis", [float(run.attrs["inertia"])], "kg m2"),
                  Line("drag torque of the rotor over speed", [drag], "N m s")]  # fmt: skip
    return facts("Conditions", lines)


def _varied(drops: xr.Dataset) -> Sheet:
    """Return what varies between drops."""
    is_grid, lines = "cell" in drops.sizes, []
    for name, words in OF_DROP.items():
        if f"drop_{name}" in drops.variables:
            values = np.unique(drops[f"drop_{name}"].values)
            ends: list[object] = [float(values[0]), float(values[-1])]
            line = line_of(drops, f"drop_{name}", ends + [values.size] * is_grid, DIGITS)
            lines.append(replace(line, name=words))
    note = "All combinations of the values." if is_grid else ""
    if "seed" in drops.attrs:
        note = f"Drawn at random, each evenly from its range, with seed {drops.attrs['seed']}."
    heads = ["smallest", "largest", *["values"] * is_grid]
    return Sheet(f"What varies in {drops.sizes['drop']} drops", lines, heads, note)


def acceptance(run: xr.Dataset, drops: xr.Dataset | None) -> list[Sheet]:
    """Return loads over capacities and gaps left, of one drop and of the worst of many, if any."""
    lines, both = [], [each for each in (run, drops) if each is not None]
    if "load_capacity" in run.variables:
        for place, node in enumerate(run["contact_node"].values):
            allowed = float(run["load_capacity"][place])
            if math.isfinite(allowed):
                forces = [float(each["largest_force"][..., place].max()) for each in both]
                told = [f"{quantity(each, 'N')} ({number(100.0 * each / allowed, 3)} %)"
                        for each in forces]  # fmt: skip
                lines.append(
                    Line(f"force in the bearing at {node!s}", [quantity(allowed, "N"), *told])
                )
    if "node_clearance" in run.variables:
        for node in run["node"].values[np.isfinite(run["node_clearance"].values)]:
            gap = float(run["node_clearance"].sel(node=node))
            told = [_of_gap(gap, float(each["node_excursion"].sel(node=node).max()))
                    if "node_excursion" in each.variables else "" for each in both]  # fmt: skip
            lines.append(Line(f"radius at {node!s}", [quantity(gap, "m"), *told]))
    heads = ["allowed", "one drop"]
    heads += [] if drops is None else [f"worst of {drops.sizes['drop']} drops"]
    note = "Capacities and clearances are as given in the system file."
    return [Sheet("Compared with what is allowed", lines, heads, note)] if lines else []


def _of_gap(gap: float, ratio: float) -> str:
    left = gap * (1.0 - ratio)
    words = f"gap left {quantity(left, 'm', 3)}" if left > 0.0 else "touches"
    return f"{quantity(gap * ratio, 'm')} ({words})"


def run_tables(run: xr.Dataset) -> list[Sheet]:
    """Return what one drop delivers."""
    found = [_of_rotor(run), of_bearings(run)]
    if "node_excursion" in run.variables:
        own = run.isel(node=np.isfinite(run["node_excursion"].values))
        lines = [
            _line(own, name) for name in ("node_clearance", "largest_radius", "node_excursion")
        ]
        note = "A ratio above 1 is a touch there. Radii are the largest of the samples."
        found.append(Sheet("One drop: other close clearances", lines, _names(own["node"]), note))
    return found


def of_bearings(run: xr.Dataset) -> Sheet:
    """Return what one drop delivers of each bearing."""
    names = [name for name in (*OF_BEARING, "load_ratio") if name in run.variables]
    lines = [_line(run, name) for name in names]
    words = {each: word for word, each in WHIRL_DIRECTION.items()}
    senses = ["none" if not each else words[int(each)] for each in run["whirl_sense"].values]
    lines.insert(names.index("whirl_turns"), Line("whirl of three turns or more", senses))
    beyond = np.maximum(0.0, (run["excursion"].values - 1.0) * run["clearance"].values)
    unit = str(run["clearance"].attrs.get("units", "1"))
    lines.append(Line("largest radius beyond the clearance", beyond.tolist(), unit, 3))
    note = "Turns and frequency of a backward whirl are negative."
    return Sheet("One drop: each bearing", lines, _names(run["contact_node"]), note)


def _of_rotor(run: xr.Dataset) -> Sheet:
    """Return what one drop delivers of the whole rotor."""
    touches, errors = run["event_time"].values, run["event_time_error"].values
    end, standstill = float(run["t"][-1]), float(run["standstill_time"])
    lines = [Line("first touch", [float(touches[0]) if touches.size else "none"], "s"),
             Line("contacts in all bearings", [int(run["contact_count"].sum())])]  # fmt: skip
    if "speed" in run.variables:
        first, last = (float(run["speed"][place]) for place in (0, -1))
        slow = quantity(0.01 * first, "rad/s")
        stands = standstill if math.isfinite(standstill) else f"not within {quantity(end, 's')}"
        lines += [Line("speed at the end", [last], "rad/s"),
                  Line("mean deceleration", [(first - last) / end], "rad/s2", DIGITS),
                  Line(f"below 1 % of the speed at the drop ({slow}) from",
                       [stands], "s")]  # fmt: skip
    lines.append(line_of(run, "horizon", [float(run["horizon"])]))
    largest = float(np.nanmax(errors)) if np.isfinite(errors).any() else math.nan
    lines.append(Line("largest estimated error of an event time", [largest], "s", 2))
    return facts("One drop: the rotor", lines)


def drops_tables(drops: xr.Dataset) -> list[Sheet]:
    """Return the distributions over many drops, a table for each bearing, and other clearances."""
    count, nodes = drops.sizes["drop"], drops["contact_node"].values
    failed = int((drops["status"].values != 0).sum())
    lost = f"{failed} drops failed and are left out. " if failed else ""
    found = []
    for place, node in enumerate(nodes):
        own = drops.isel(contact=place)
        lines = [_statistics(own, name) for name in OF_BEARING if f"{name}_mean" in own.variables]
        found.append(Sheet(f"{count} drops: bearing at {node!s}", lines, _heads(drops),
                           f"{lost}{_shares(own)} {_how(drops)}"))  # fmt: skip
    if "node_excursion_mean" in drops.variables:
        lines = [replace(_statistics(drops.isel(node=place), "node_excursion"), name=str(node))
                 for place, node in enumerate(drops["node"].values)]  # fmt: skip
        found.append(Sheet(f"{count} drops: largest radius over other close clearances",
                           lines, _heads(drops)))  # fmt: skip
    return found + ([_cells(drops)] if "cell" in drops.sizes else [])


def _heads(drops: xr.Dataset) -> list[str]:
    if "cell" in drops.sizes:
        return ["smallest", "at", "mean", "change", "largest", "at"]
    levels = [f"{100.0 * float(each):g} % below" for each in drops["quantile"].values]
    return ["mean", *("median" if each == "50 % below" else each for each in levels)]


def _how(drops: xr.Dataset) -> str:
    if "cell" in drops.sizes:
        return (f"Extremes with where they lie: {places_in(drops)}. Means and shares are integrals "
                "over the grid, not estimates from a sample: no sampling error applies. The change "
                "is that when every other value of each axis is left out (unknown with too few "
                "values).")  # fmt: skip
    return ("In brackets 95 % intervals for a sample of this size; no intervals and no quantiles "
            "of what fewer than six drops have.")  # fmt: skip


def _shares(own: xr.Dataset) -> str:
    """Return the fractions of the drops in words."""
    said = []
    for name, words in SHARES.items():
        if f"{name}_fraction" not in own.variables:
            continue
        share = 100.0 * float(own[f"{name}_fraction"])
        if "cell" in own.sizes:
            change = 100.0 * float(own[f"{name}_fraction_change"])
            margin = "change unknown" if math.isnan(change) else f"change {number(change, 2)} %"
        else:
            low, high = (100.0 * float(own[f"{name}_fraction_{end}"]) for end in ("low", "high"))
            margin = f"{number(low, 3)} to {number(high, 3)} %"
        said.append(f"{number(share, 3)} % ({margin}) {words}")
    return f"Drops: {'; '.join(said)}."


def _statistics(own: xr.Dataset, name: str) -> Line:
    """Return the statistics of a figure."""
    count, total = count_of(own, name), int((own["status"].values == 0).sum())

    def values(end: str) -> list[float]:
        found = own[f"{name}_{end}"]
        return [float(each) for each in np.ravel(found)]

    if "cell" in own.sizes:
        at = [place_of(own, int(own[f"{name}_{end}_drop"])) for end in ("min", "max")]
        mean = [*values("mean"), *values("mean_change")]
        told: Sequence[object] = [*values("min"), at[0], *mean, *values("max"), at[1]]
    else:
        told = [Interval(*each)
                for what in ("mean", "quantile")
                for each in zip(*(values(f"{what}{end}") for end in ("", "_low", "_high")),
                                strict=True)]  # fmt: skip
    line = line_of(own, name, told, DIGITS if "cell" in own.sizes else 3)
    return replace(line, name=line.name + (f", in {count} of {total} drops" * (count < total)))


def _cells(drops: xr.Dataset) -> Sheet:
    """Return the cells of a grid: what varies besides the phase, and what happens there."""
    shown = drops.isel(cell=slice(MOST_CELLS))
    lines = [line_of(shown, name, shown[name].values.tolist(), DIGITS) for name in cells_in(drops)]
    lines = [replace(each, name=each.name.removeprefix("cell ")) for each in lines]
    lines = lines or [Line("cell", ["all"])]
    for name, words in (("backward_whirl_fraction", "whirl"), ("largest_force", "largest force")):
        for place, node in enumerate(drops["contact_node"].values):
            own = shown[f"cell_{name}"].values[:, place].tolist()
            lines.append(replace(line_of(shown, f"cell_{name}", own, DIGITS),
                                 name=f"{words}, {node!s}"))  # fmt: skip
    phases = varying(drops).count("phase") and np.unique(drops["drop_phase"].values).size
    note = f"Share of the {phases} angles, and the largest over them. " if phases else ""
    count = drops.sizes["cell"]
    note += f"The first {MOST_CELLS} of {count} cells." if count > MOST_CELLS else ""
    return Sheet("Backward whirl by cell", lines, note=note.strip())


def _line(dataset: xr.Dataset, name: str) -> Line:
    """Return a figure of each bearing or node."""
    return line_of(dataset, name, dataset[name].values.tolist(), DIGITS)


def _names(nodes: xr.DataArray) -> list[str]:
    return [str(each) for each in nodes.values]
