"""Tables of the report on a drop: what it was computed from, one drop, and many."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from rotor_ida.cli.drop_grids import cells_in, count_of, place_of, places_in, varying
from rotor_ida.schema import OF_BEARING, OF_DROP, WHIRL_DIRECTION

if TYPE_CHECKING:
    import xarray as xr

RPM = 60.0 / math.tau
# Units in which an engineer reads a figure, with its parts and the size from which it is used.
READ_IN = {
    "s": [("ms", 1e3, 0.0), ("s", 1.0, 10.0)],
    "s-1": [("rpm", RPM, 0.0)],
    "m": [("µm", 1e6, 0.0), ("mm", 1e3, 1e-2)],
    "N": [("N", 1.0, 0.0), ("kN", 1e-3, 1e3)],
    "J": [("J", 1.0, 0.0), ("kJ", 1e-3, 1e4)],
}
WORDS = {
    "excursion": "largest radius over clearance", "contact_count": "number of contacts",
    "total_contact_time": "time in contact", "longest_contact_time": "longest contact",
    "mean_contact_force": "mean force in contact", "total_impulse": "impulse of all contacts",
    "largest_impulse": "largest impulse of a contact",
    "node_clearance": "clearance", "node_excursion": "largest radius over clearance",
    "total_contact_loss": "loss by contact damping",
    "total_heat": "heat of friction",
    "rest_time": "in contact to the end from", "first_roll_time": "first rolling at",
    "largest_force_time": "largest force at", "race_speed_time": "largest race speed at",
    "whirl_turns": "turns of the longest whirl", "whirl_speed": "whirl frequency",
    "load_ratio": "largest force over load capacity",
}  # fmt: skip
# Parameters of the bearings and their mounts, with the parts of their units.
OF_CONTACTS = {
    "law_stiffness": ("contact stiffness [N/m^exponent]", 1.0), "law_exponent": ("exponent", 1.0),
    "law_damping": ("contact damping [s/m]", 1.0), "law_friction": ("friction", 1.0),
    "law_radius": ("radius of the rotor [mm]", 1e3), "load_capacity": ("load capacity [kN]", 1e-3),
    "race_radius": ("radius of the race [mm]", 1e3),
    "race_inertia": ("inertia of the race [kg m2]", 1.0),
    "race_drag": ("drag torque of the race over speed [N m s]", 1.0),
}  # fmt: skip
OF_STATORS = {
    "stator_mass": "mass of the mount [kg]", "stator_stiffness": "stiffness of the mount [N/m]",
    "stator_damping": "damping of the mount [N s/m]",
}  # fmt: skip
FACTS = {
    "backward_whirl": "with a backward whirl of three turns", "rest": "in contact at the end",
    "decided": "whose largest force comes before the horizon",
    "overload": "whose largest force is above the load capacity",
}  # fmt: skip
# Cells of a grid that a page lists; the archive has all.
MOST_CELLS = 200


@dataclass(frozen=True, slots=True)
class Listed:
    """A table of the report."""

    title: str
    heads: list[str]
    rows: list[list[str]]
    note: str = ""


def number(value: float, digits: int = 4) -> str:
    """Return a number with some digits, without an exponent where it has a common size.

    Examples
    --------
    >>> number(19940.3), number(0.012345678), number(2.18e10), number(250.0), number(np.nan)
    ('19940', '0.01235', '2.18e+10', '250', '-')
    """
    size = abs(value)
    if math.isnan(value):
        return "-"
    if not 1e-4 <= size < 1e7:
        return f"{value:.{digits}g}"
    places = max(0, digits - 1 - math.floor(math.log10(size)))
    said = f"{value:.{places}f}"
    return said.rstrip("0").rstrip(".") if "." in said else said


def read_in(unit: str, values: npt.ArrayLike) -> tuple[str, float]:
    """Return the unit in which an engineer reads values, and its parts.

    Examples
    --------
    >>> read_in("N", [20.0, 1500.0]), read_in("s-1", [np.nan])[0], read_in("N m", [1.0])
    (('kN', 0.001), 'rpm', ('N m', 1.0))
    """
    base, *rest = unit.split(" ")
    if base not in READ_IN or rest not in ([], ["s"]) or (rest and base != "N"):
        return unit.removeprefix("1"), 1.0
    sizes = np.abs(np.asarray(values, float))
    largest = float(np.max(sizes, where=np.isfinite(sizes), initial=0.0))
    name, parts = next((word, parts) for word, parts, least in reversed(READ_IN[base])
                       if largest >= least)  # fmt: skip
    return " ".join([name, *rest]), parts


def given_tables(run: xr.Dataset, drops: xr.Dataset | None) -> list[Listed]:
    """Return what the drops were computed from: conditions, supports, bearings and what varies."""
    found = [_conditions(run)]
    if run.sizes["support"]:
        found.append(_supports(run))
    found.append(_bearings(run))
    if drops is not None:
        found.append(_varied(drops))
    return found


def _conditions(run: xr.Dataset) -> Listed:
    """Return the conditions of one drop."""
    phase = math.degrees(float(run.attrs["phase"]))
    speed = float(run.attrs.get("start_speed", run.attrs.get("speed", math.nan)))
    rows = [["speed at the drop [rpm]", number(speed * RPM, 5)],
            ["duration [ms]", number(1e3 * float(run.attrs["duration"]), 5)],
            ["angle of the rotor at the drop [deg]", number(phase)]]  # fmt: skip
    if "inertia" in run.attrs:
        drag = float(np.ravel(run.attrs["torque"])[1])
        rows += [["inertia about the axis [kg m2]", number(float(run.attrs["inertia"]))],
                 ["drag torque of the rotor over speed [N m s]", number(drag)]]  # fmt: skip
    angles = np.degrees(run["unbalance_phase"].values) - phase
    for node, moment, angle in zip(run["unbalance_node"].values, run["unbalance_moment"].values,
                                   angles, strict=True):  # fmt: skip
        turned = number(round(float(angle), 9) + 0.0)
        rows.append([f"unbalance at {node!s} [g mm], at angle [deg]",
                     f"{number(1e6 * float(moment))}, {turned}"])  # fmt: skip
    return Listed("Conditions", ["", "value"], rows)


def _supports(run: xr.Dataset) -> Listed:
    """Return the magnetic bearings."""
    heads = ["", *(str(each) for each in run["support_node"].values)]
    loads = run["support_load"].values
    noise = 1e-9 * float(np.abs(loads).max(initial=0.0))
    rows = [[f"{words} {axis} [{unit}]",
             *(number(float(each) if abs(each) > noise else 0.0) for each in values)]
            for name, words, unit in (("support_stiffness", "stiffness", "N/m"),
                                      ("support_damping", "damping", "N s/m"),
                                      ("support_load", "static load", "N"))
            for axis, values in zip("xy", run[name].values.T, strict=True)]  # fmt: skip
    rows.append(["fails", *("yes" if each else "no" for each in run["support_fails"].values)])
    return Listed("Magnetic bearings", heads, rows)


def _bearings(run: xr.Dataset) -> Listed:
    """Return the touchdown bearings."""
    heads = ["", *(str(each) for each in run["contact_node"].values)]
    rows = [["clearance [µm]", *(number(1e6 * float(each)) for each in run["clearance"].values)]]
    for name, (words, parts) in OF_CONTACTS.items():
        values = run[name].values if name in run.variables else np.array([math.nan])
        if np.isfinite(values).any():
            rows.append([words, *(number(parts * float(each)) for each in values)])
    places = run["stator_number"].values
    for name, words in OF_STATORS.items() if (places >= 0).any() else ():
        values = run[name].values.reshape(run.sizes["stator"], -1)[:, 0]
        rows.append([words, *(number(float(values[each])) if each >= 0 else "-"
                              for each in places)])  # fmt: skip
    return Listed("Touchdown bearings", heads, rows)


def _varied(drops: xr.Dataset) -> Listed:
    """Return what varies between drops."""
    heads, rows = ["", "smallest", "largest"], []
    is_grid = "cell" in drops.sizes
    for name, words in OF_DROP.items():
        if f"drop_{name}" not in drops.variables:
            continue
        varied = drops[f"drop_{name}"]
        values = np.unique(varied.values)
        unit = {"radian": " [deg]", "s m-1": " [s/m]"}.get(str(varied.attrs.get("units")), "")
        if name == "phase":
            values = np.degrees(values)
        rows.append([words + unit, number(float(values[0])), number(float(values[-1]))])
        rows[-1] += [str(values.size)] if is_grid else []
    if is_grid:
        heads.append("values")
    note = "All combinations of the values." if is_grid else ""
    if "seed" in drops.attrs:
        note = f"Drawn at random, each evenly from its range, with seed {drops.attrs['seed']}."
    return Listed(f"What varies in {drops.sizes['drop']} drops", heads, rows, note)


def acceptance(run: xr.Dataset, drops: xr.Dataset | None) -> Listed | None:
    """Return loads over capacities and gaps left, of one drop and of the worst of many."""
    rows = []
    if "load_capacity" in run.variables:
        for place, node in enumerate(run["contact_node"].values):
            allowed = float(run["load_capacity"][place])
            if math.isfinite(allowed):
                forces = [float(each["largest_force"][..., place].max())
                          for each in (run, drops) if each is not None]  # fmt: skip
                rows.append([f"force in the bearing at {node!s} [kN]", number(1e-3 * allowed),
                             *(f"{number(1e-3 * each)} ({number(100.0 * each / allowed, 3)} %)"
                               for each in forces)])  # fmt: skip
    if "node_clearance" in run.variables:
        for node in run["node"].values[np.isfinite(run["node_clearance"].values)]:
            gap = 1e6 * float(run["node_clearance"].sel(node=node))
            ratios = [float(each["node_excursion"].sel(node=node).max())
                      for each in (run, drops)
                      if each is not None and "node_excursion" in each.variables]  # fmt: skip
            rows.append([f"radius at {node!s} [µm]", number(gap),
                         *(_of_gap(gap, ratio) for ratio in ratios)])  # fmt: skip
    if not rows:
        return None
    heads = ["", "allowed", "one drop"]
    heads += [] if drops is None else [f"worst of {drops.sizes['drop']} drops"]
    rows = [row + ["-"] * (len(heads) - len(row)) for row in rows]
    return Listed("Compared with what is allowed", heads, rows,
                  "Capacities and clearances are as given in the system file.")  # fmt: skip


def _of_gap(gap: float, ratio: float) -> str:
    left = gap * (1.0 - ratio)
    words = f"gap left {number(left, 3)}" if left > 0.0 else "touches"
    return f"{number(gap * ratio)} ({words})"


def run_tables(run: xr.Dataset) -> list[Listed]:
    """Return what one drop delivers."""
    heads = ["", *(str(each) for each in run["contact_node"].values)]
    names = [name for name in (*OF_BEARING, "load_ratio") if name in run.variables]
    rows = [_row(run, name) for name in names]
    place = names.index("whirl_turns")
    words = {each: word for word, each in WHIRL_DIRECTION.items()}
    senses = ["none" if not each else words[int(each)] for each in run["whirl_sense"].values]
    rows.insert(place, ["whirl of three turns or more", *senses])
    beyond = 1e6 * (run["excursion"].values - 1.0) * run["clearance"].values
    rows.append(["largest radius beyond the clearance [µm]",
                 *(number(max(0.0, float(each)), 3) for each in beyond)])  # fmt: skip
    note = "Turns and frequency of a backward whirl are negative."
    found = [_of_rotor(run), Listed("One drop: each bearing", heads, rows, note)]
    if "node_excursion" in run.variables:
        own = run.isel(node=np.isfinite(run["node_excursion"].values))
        heads = ["", *(str(each) for each in own["node"].values)]
        rows = [_row(own, name) for name in ("node_clearance", "largest_radius", "node_excursion")]
        note = "A ratio above 1 is a touch there. Radii are the largest of the samples."
        found.append(Listed("One drop: other close clearances", heads, rows, note))
    return found


def _of_rotor(run: xr.Dataset) -> Listed:
    """Return what one drop delivers of the whole rotor."""
    touches, errors = run["event_time"].values, run["event_time_error"].values
    end, standstill = float(run["t"][-1]), float(run["standstill_time"])
    rows = [["first touch [ms]", number(1e3 * float(touches[0])) if touches.size else "none"],
            ["contacts in all bearings", str(int(run["contact_count"].sum()))]]  # fmt: skip
    if "speed" in run.variables:
        first, last = (RPM * float(run["speed"][place]) for place in (0, -1))
        rows += [["speed at the end [rpm]", number(last, 5)],
                 ["mean deceleration [rpm/s]", number((first - last) / end)],
                 [f"below 1 % of the speed at the drop ({number(0.01 * first)} rpm) from [ms]",
                  number(1e3 * standstill) if math.isfinite(standstill)
                  else f"not within {number(1e3 * end)}"]]  # fmt: skip
    rows.append(["determined by the parameters up to [ms]", number(1e3 * float(run["horizon"]), 5)])
    largest = float(np.nanmax(errors)) if np.isfinite(errors).any() else math.nan
    rows.append(["largest estimated error of an event time [s]", number(largest, 2)])
    return Listed("One drop: the rotor", ["", "value"], rows)


def drops_tables(drops: xr.Dataset) -> list[Listed]:
    """Return the distributions over many drops, a table for each bearing, and other clearances."""
    count, nodes = drops.sizes["drop"], drops["contact_node"].values
    failed = int((drops["status"].values != 0).sum())
    lost = f"{failed} drops failed and are left out. " if failed else ""
    found = []
    for place, node in enumerate(nodes):
        own = drops.isel(contact=place)
        names = [name for name in OF_BEARING if name in own.variables]
        rows = [_statistics(own, name) for name in names]
        found.append(Listed(f"{count} drops: bearing at {node!s}", _heads(drops), rows,
                            f"{lost}{_facts(own)} {_how(drops)}"))  # fmt: skip
    if "node_excursion" in drops.variables:
        rows = []
        for place, node in enumerate(drops["node"].values):
            own = drops.isel(node=place)
            rows.append([str(node), *_statistics(own, "node_excursion")[1:]])
        found.append(Listed(f"{count} drops: largest radius over other close clearances",
                            _heads(drops), rows))  # fmt: skip
    return found + ([_cells(drops)] if "cell" in drops.sizes else [])


def _heads(drops: xr.Dataset) -> list[str]:
    if "cell" in drops.sizes:
        return ["", "smallest", "at", "mean (change)", "largest", "at"]
    levels = [f"{100.0 * float(each):g} % below" for each in drops["quantile"].values]
    return ["", "mean", *("median" if each == "50 % below" else each for each in levels)]


def _how(drops: xr.Dataset) -> str:
    if "cell" in drops.sizes:
        return (f"Extremes with where they lie: {places_in(drops)}. Means and shares are integrals "
                "over the grid, not estimates from a sample: no sampling error applies. In "
                "brackets by how much they change when every other value of each axis is left out "
                "(unknown with too few values).")  # fmt: skip
    return ("In brackets 95 % intervals for a sample of this size; no intervals and no quantiles "
            "of what fewer than six drops have.")  # fmt: skip


def _facts(own: xr.Dataset) -> str:
    """Return the fractions of the drops in words."""
    said = []
    for name, words in FACTS.items():
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


def _statistics(own: xr.Dataset, name: str) -> list[str]:
    """Return the statistics of a figure as a row."""
    unit, parts = _unit(own[name], name)
    count, total = count_of(own, name), int((own["status"].values == 0).sum())
    head = _head(name, unit) + (f", in {count} of {total} drops" if count < total else "")

    def one(end: str) -> float:
        return parts * float(own[f"{name}_{end}"])

    if "cell" in own.sizes:
        change = one("mean_change")
        margin = "unknown" if math.isnan(change) else number(change, 2)
        mean = "-" if math.isnan(one("mean")) else f"{number(one('mean'))} ({margin})"
        at = [place_of(own, int(own[f"{name}_{end}_drop"])) for end in ("min", "max")]
        return [head, number(one("min")), at[0], mean, number(one("max")), at[1]]
    ends = [parts * own[f"{name}_quantile{end}"].values for end in ("", "_low", "_high")]
    mean_of = (one("mean"), one("mean_low"), one("mean_high"))
    return [head, *(_with_interval(*each) for each in [mean_of, *zip(*ends, strict=True)])]


def _cells(drops: xr.Dataset) -> Listed:
    """Return the cells of a grid: what varies besides the phase, and what happens there."""
    names, nodes = cells_in(drops), drops["contact_node"].values
    force, parts = _unit(drops["cell_largest_force"], "cell_largest_force")
    heads = [name.removeprefix("cell_").replace("_", " ") for name in names] or ["cell"]
    heads += [f"{words}, {node!s}" for words in ("whirl [%]", f"largest force [{force}]")
              for node in nodes]  # fmt: skip
    whirls = 100.0 * drops["cell_backward_whirl_fraction"].values
    forces = parts * drops["cell_largest_force"].values
    count = drops.sizes["cell"]
    rows = [[*([number(float(drops[name][place])) for name in names] or ["all"]),
             *(number(float(each), 3) for each in whirls[place]),
             *(number(float(each)) for each in forces[place])]
            for place in range(min(count, MOST_CELLS))]  # fmt: skip
    phases = varying(drops).count("phase") and np.unique(drops["drop_phase"].values).size
    note = f"Share of the {phases} angles, and the largest over them. " if phases else ""
    note += f"The first {MOST_CELLS} of {count} cells." if count > MOST_CELLS else ""
    return Listed("Backward whirl by cell", heads, rows, note.strip())


def _unit(values: xr.DataArray, name: str) -> tuple[str, float]:
    """Return unit and parts of a figure; a frequency of whirl is in Hz."""
    unit = str(values.attrs.get("units", ""))
    if name == "whirl_speed" and unit == "s-1":
        return "Hz", 1.0 / math.tau
    return read_in(unit, values.values)


def _row(dataset: xr.Dataset, name: str) -> list[str]:
    """Return a figure of the bearings as a row, with its name and unit."""
    unit, parts = _unit(dataset[name], name)
    return [_head(name, unit), *(number(parts * float(each)) for each in dataset[name].values)]


def _head(name: str, unit: str) -> str:
    words = WORDS.get(name, name.replace("_", " "))
    return f"{words} [{unit}]" if unit else words


def _with_interval(value: float, low: float, high: float) -> str:
    """Return a value with its interval, if it has one, of which an end may be unknown.

    Examples
    --------
    >>> _with_interval(2.0, 1.0, 3.5), _with_interval(2.0, -np.inf, 3.0)
    ('2 (1 to 3.5)', '2 (below 3)')
    >>> _with_interval(2.0, 1.0, np.inf), _with_interval(2.0, -np.inf, np.inf)
    ('2 (above 1)', '2 (unknown)')
    >>> _with_interval(2.0, np.nan, np.nan), _with_interval(np.nan, np.nan, np.nan)
    ('2', '-')
    """
    if math.isnan(value) or math.isnan(low):
        return number(float(value), 3)
    first, last = number(float(low), 3), number(float(high), 3)
    known = math.isfinite(low), math.isfinite(high)
    words = {(True, True): f"{first} to {last}", (False, True): f"below {last}",
             (True, False): f"above {first}", (False, False): "unknown"}  # fmt: skip
    return f"{number(float(value), 3)} ({words[known]})"
