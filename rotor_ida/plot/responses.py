"""Whirls and settled responses of any rotor over its speed or another parameter."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
import xarray as xr
from matplotlib.axes import Axes

from rotor_ida.arrays import Values
from rotor_ida.checks import COMPONENTS
from rotor_ida.closed_forms.contact_free import static_sag
from rotor_ida.errors import InputError
from rotor_ida.model.parameters import OF_ROTOR, OPTIONAL, PARAMETERS
from rotor_ida.model.system_parameters import PARAMETERS_OF_SYSTEM, SPEED
from rotor_ida.plot import legends, palette
from rotor_ida.plot.appearance import draw_marks, drawing, raise_limit
from rotor_ida.plot.datasets import (
    at_contact,
    check_dataset,
    check_same_parameters,
    check_same_units,
    clearances_in,
    contact_text,
    drawn_over,
    is_of_disc,
    is_of_kind,
    one_value,
    units_in,
)
from rotor_ida.plot.labels import (
    KIND_WORDS,
    label_axis,
    label_parameter,
    lengths_text,
    speeds_in,
    text_of,
)
from rotor_ida.plot.legends import legend_below, own_legend
from rotor_ida.results.si_units import scale_of
from rotor_ida.schema import SPECIAL, flags_of
from rotor_ida.texts import in_figure

# Whirls by their stability: their words, line and width on a curve, and colour of points.
LINES = {
    "stable": (legends.STABLE, "-", 1.3, palette.INK),
    "unstable": (legends.UNSTABLE, (0, (4, 2)), 1.0, palette.GREY),
    "neutral": (legends.NEUTRAL, (0, (7, 1.6, 1.2, 1.6)), 1.0, palette.BROWN),
}
SPECIALS = {"fold": (legends.FOLD, "D", 4.0), "hopf": (legends.HOPF, "o", 4.6),
            "graze": (legends.GRAZE, "s", 4.0)}  # fmt: skip
CURVE = ("omega", "zeta", "delta0", "amplitude", "phase_lag", "stability", "in_contact", "piece")
LINEAR = "linear up to the touch, limit_cycle beyond"
ON_STATOR = "no linear response: at rest on the stator"
SIMULATED = ("response", "amplitude", "phase_lag", "radius_min", "radius_max", "direction")
# Whirls of more points than this are dots that are read as lines, of fewer points are marks.
FEW_POINTS = 120
# The whirls of a result of special speeds, by their names in one of whirls.
BRANCHES = {"branch_amplitude": "amplitude", "branch_stability": "stability"}
# Results drawn together, and the variables that they need, for one disc beside its parameters.
NEEDED = {
    "exact": ("stability",),
    "whirls": ("stability",),
    "simulated": SIMULATED,
    "fold_points": ("fold_omega", "fold_amplitude"),
    "hopf_points": ("hopf_omega", "hopf_amplitude"),
    "special": ("special_speed", "special_kind", "amplitude"),
}
# Nodes of an unbalance response that are drawn at most.
MOST_NODES = 5


@dataclass(frozen=True, slots=True)
class _Look:
    """How one kind of response is drawn."""

    colour: str
    filled: bool
    is_range: bool
    dashes: object = "-"

    @property
    def face(self) -> str:
        """Colour of what is inside a mark."""
        return self.colour if self.filled else "white"


DOTS, LONG = (0, (1, 1.6)), (0, (4, 1.4))
_SHADE = {kind: shades[0] for kind, shades in palette.KIND_SHADES.items()}
KINDS = {
    "synchronous": _Look(_SHADE["synchronous"], True, False),
    "contact_free": _Look(_SHADE["synchronous"], False, False),
    "bouncing": _Look(_SHADE["bouncing"], False, True),
    "full_contact": _Look(_SHADE["full_contact"], True, True),
    "rolling": _Look(palette.DARK_BROWN, True, True, LONG),
    "touching": _Look(palette.INK, False, False),
    "quasi_periodic": _Look(_SHADE["quasi_periodic"], False, True),
    "chaotic": _Look(_SHADE["chaotic"], True, True, DOTS),
    "unresolved": _Look(palette.GREY, False, True, DOTS),
}
RANGES = [kind for kind, drawn in KINDS.items() if drawn.is_range]
# Responses larger than all below them by this factor do not set the scale.
FAR = 5.0
# Whirls of constant amplitude, whose distance from the centre may vary by this part of it.
STEADY, ASIDE = ("synchronous", "contact_free"), 1e-2
DIRECTIONS = {0: ("o", 4.2), 1: ("^", 3.4), -1: ("v", 3.4)}


class _Axis(NamedTuple):
    """The parameter over which results are drawn, and the values of the others."""

    over: str
    held: dict[str, float]


def plot_amplitude(
    exact: xr.Dataset | None, *, whirls: xr.Dataset | None = None,
    simulated: xr.Dataset | None = None, fold_points: xr.Dataset | None = None,
    hopf_points: xr.Dataset | None = None, special: xr.Dataset | None = None,
    contact: int | str = 0, ax: Axes | None = None,
) -> Axes:  # fmt: skip
    """Draw the amplitude of whirls and settled responses over the parameter that varies.

    Parameters
    ----------
    exact : Dataset or None
        The exact whirls: a curve of `rotor_ida.closed_forms.response_curve` or
        `rotor_ida.closed_forms.clearance_curve`, or points of `rotor_ida.synchronous_response` or
        `rotor_ida.special_speeds`, for one value of each parameter but one. None for `simulated`
        alone. Under a load the whirl is drawn up to the touch, by its largest distance from the
        centre of the stator.
    whirls : Dataset, optional
        Result of `rotor_ida.synchronous_response` for the same rotor: its whirls are marked.
    simulated : Dataset, optional
        Result of `rotor_ida.sweep`, for the same rotor. Synchronous, contact-free and touching
        responses are marks at their amplitude, by direction of the sweep. All others are bars over
        the range of the distance from the centre of the stator. So are all where a whirl is not
        about that centre, as under the weight of the rotor; the axis is that of the radius then.
    fold_points, hopf_points : Dataset, optional
        Results of `rotor_ida.folds` and `rotor_ida.hopf_points` for the same disc.
    special : Dataset, optional
        Result of `rotor_ida.special_speeds`, for the same system: its folds, Hopf points and grazes
        are marked, and its thresholds of instability are vertical lines.
    contact : int or str
        Contact of a rotor system, by its number or its node. Its clearance is a dashed line.
    ax : Axes, optional
        Axes to draw on and return; default: those of a new figure.

    Raises
    ------
    InputError
        If a dataset is of another kind, has several values of a parameter, or values other than
        `exact`; if it has no such contact; if there is nothing to draw.

    Examples
    --------
    >>> from rotor_ida import folds
    >>> from rotor_ida.closed_forms import response_curve
    >>> ax = plot_amplitude(
    ...     response_curve(zeta=0.07, delta0=0.5, limits=(0.05, 3.0)),
    ...     fold_points=folds(zeta=0.07, delta0=0.5),
    ... )
    >>> ax.get_ylabel()
    'amplitude $A$'
    """
    given = {"exact": exact, "whirls": whirls, "simulated": simulated, "fold_points": fold_points,
             "hopf_points": hopf_points, "special": special}  # fmt: skip
    return _plot("amplitude", given, contact, ax)


def plot_phase(
    exact: xr.Dataset | None, *, whirls: xr.Dataset | None = None,
    simulated: xr.Dataset | None = None, fold_points: xr.Dataset | None = None,
    contact: int | str = 0, ax: Axes | None = None,
) -> Axes:  # fmt: skip
    r"""Draw the phase by which every whirl lags the unbalance over the spin speed.

    Parameters
    ----------
    exact, whirls, simulated, fold_points, contact, ax
        As for `plot_amplitude`. For a simulated response that is neither synchronous nor
        contact-free, the mark is the phase of the component at the spin speed.

    Examples
    --------
    >>> from rotor_ida.closed_forms import response_curve
    >>> ax = plot_phase(response_curve(zeta=0.5, delta0=0.0, limits=(0.5, 2.0)))
    >>> ax.get_ylabel()
    'phase lag $\\theta$'
    """
    given = {"exact": exact, "whirls": whirls, "simulated": simulated, "fold_points": fold_points}
    return _plot("phase_lag", given, contact, ax)


def _plot(
    quantity: str, given: dict[str, xr.Dataset | None], contact: int | str, ax: Axes | None
) -> Axes:
    """Draw amplitude or phase of results over the parameter that varies."""
    found, axis = _checked(quantity, given, contact)
    shown = next(iter(found.values()))
    simulated, reach = found.get("simulated"), _reach(found)
    with drawing(ax, width=5.6, height=4.2) as ax:
        label_parameter(ax.xaxis, axis.over, shown)
        aside = quantity == "amplitude" and (
            _is_loaded(shown) or (simulated is not None and _lies_aside(simulated))
        )
        label_axis(ax.yaxis, "radius" if aside else quantity, shown[quantity])
        if quantity == "amplitude":
            draw_clearance(ax, found.get("simulated", shown), over=axis.over)
        for name in ("exact", "whirls"):
            if name in found:
                _draw_whirls(ax, found[name], axis.over, quantity, given=name == "whirls")
        _draw_specials(ax, found, quantity, axis)
        if simulated is not None:
            _draw_simulated(ax, simulated, quantity, axis.over, reach[1], as_ranges=aside)
        if quantity == "amplitude":
            raise_limit(ax, *reach)
        else:
            ax.set_ylim(0.0, 1.06 * math.pi)
            ax.set_yticks([0.0, 0.5 * math.pi, math.pi], ["0", r"$\pi/2$", r"$\pi$"])
        if "special" in found:
            _draw_thresholds(ax, found["special"])
        ax.set_title(_title(shown, axis))
        # bars across the axes leave no room
        has_bars = aside or ("simulated" in found and bool(_are_ranges(found["simulated"]).any()))
        own_legend(ax, inside=False if has_bars else None)
    return ax


def _checked(
    quantity: str, given: Mapping[str, xr.Dataset | None], contact: int | str
) -> tuple[dict[str, xr.Dataset], _Axis]:
    """Return results of one rotor at a contact, the exact ones first, and what varies in them."""
    given = dict(given)
    exact = given.get("exact")
    if isinstance(exact, xr.Dataset) and "special_speed" in exact.variables:
        given["special"] = exact
        exact = check_dataset("special", exact, (*NEEDED["special"], *BRANCHES))
        exact = exact.drop_vars(["amplitude", "stability"], errors="ignore").rename(BRANCHES)
        given["exact"] = exact
    found: dict[str, xr.Dataset] = {}
    for name, dataset in given.items():
        if dataset is None:
            continue
        alone = name in ("fold_points", "hopf_points")
        drawn = PARAMETERS[1:] if alone else () if name == "special" else (quantity,)
        of_system = () if alone else ("contact_node",)
        found[name] = check_dataset(name, dataset, (*NEEDED[name], *drawn), of_system)
    if not {"exact", "simulated", "whirls"} & set(found):
        raise InputError("exact must be a Dataset, or None beside simulated, got neither")
    first, shown = next(iter(found.items()))
    axis = _Axis(*drawn_over(first, shown))
    for name, dataset in found.items():
        check_same_units(name, dataset, shown)
        if is_of_disc(shown):
            _check_parameters(name, dataset, axis)
    found = {name: at_contact(dataset, contact) for name, dataset in found.items()}
    if quantity == "amplitude":
        found |= {name: _from_axis(found[name]) for name in ("exact", "whirls") if name in found}
    if (
        is_of_disc(shown) and "simulated" in found
    ):  # whirls without friction have no radius of the disc
        held = drawn_over("simulated", found["simulated"].assign_attrs(along=axis.over))[1]
        axis.held.update({name: held[name] for name in held if name in OPTIONAL})
    return found, axis


def _is_loaded(shown: xr.Dataset) -> bool:
    """Return whether a result is of one disc under a load."""
    return is_of_disc(shown) and bool((shown.get("load", xr.DataArray(0.0)) > 0.0).any())


def _from_axis(whirls: xr.Dataset) -> xr.Dataset:
    """Return whirls of one disc under a load by their largest distance from the axis."""
    if not _is_loaded(whirls):
        return whirls
    kappa = whirls.get("shaft_stiffness", xr.zeros_like(whirls["load"]))
    sag = xr.apply_ufunc(static_sag, *xr.broadcast(whirls["load"], kappa))
    radius = whirls["amplitude"] + sag * scale_of(whirls, "length")
    return whirls.assign(amplitude=radius.assign_attrs(whirls["amplitude"].attrs))


def _check_parameters(name: str, dataset: xr.Dataset, axis: _Axis) -> None:
    """Refuse a result of another disc than that of the results that it is drawn with."""
    special = name in ("fold_points", "hopf_points")
    names = [each for each in PARAMETERS[special:] if each != axis.over]
    names += [each for each in OPTIONAL if each in dataset.variables and each != axis.over]
    here = {each: one_value(name, dataset, each) for each in names}
    there = {each: value for each, value in axis.held.items() if each in {*names, *OPTIONAL}}
    check_same_parameters(name, here, there)


def _reach(found: Mapping[str, xr.Dataset]) -> tuple[float, float]:
    """Return the smallest and largest amplitude, radius or clearance that an axis shows."""
    simulated = found.get("simulated")
    shown = [found[name]["amplitude"] for name in ("exact", "whirls") if name in found]
    shown.append(clearances_in(next(iter(found.values())) if simulated is None else simulated))
    lowest, heights = list(shown), np.empty(0)
    if simulated is not None:
        is_range = _are_ranges(simulated)
        shown += [simulated[name].where(~is_range) for name in ("amplitude", "radius_max")]
        lowest += [simulated[name] for name in ("amplitude", "radius_min")]
        heights = simulated["radius_max"].values
    highest = below_outliers(max(float(each.max()) for each in shown), heights) or 1.0
    return float(np.nanmin([each.min() for each in lowest])), highest


def below_outliers(reference: float, heights: Values) -> float:
    """Return the largest height that is not larger by a factor than all below, and a reference.

    Where all are, as in a sweep of dry whip alone, they set the scale.

    Examples
    --------
    >>> below_outliers(1.0, np.array([0.5, 3.0, 90.0, 99.0])), below_outliers(1.0, np.array([90.0]))
    (3.0, 90.0)
    """
    rising = np.sort(heights[np.isfinite(heights)])
    below = np.maximum(np.append(0.0, rising[:-1]), reference)
    last = [*np.flatnonzero(rising > FAR * below), rising.size][0]
    return max(reference, float(rising[(last or rising.size) - 1])) if rising.size else reference


def _are_ranges(simulated: xr.Dataset) -> xr.DataArray:
    """Return whether each response is drawn as a range of the distance from the centre."""
    return is_of_kind(simulated["response"], RANGES)


def _title(shown: xr.Dataset, axis: _Axis) -> str:
    """Return the contact of a system, and the parameters that are held."""
    held = text_of(shown, axis.held) if axis.held else ""
    if not is_of_disc(shown):
        return f"{contact_text(shown, shown['contact'].item())}\n{held}".rstrip()
    if not axis.held.get("load"):
        return held
    before = {name: value for name, value in axis.held.items() if name != "load"}
    last = text_of(shown, {"load": axis.held["load"]})
    sag = static_sag(axis.held["load"], axis.held.get("shaft_stiffness", 0.0))
    lies = bool(sag >= axis.held.get("delta0", math.inf))
    return f"{text_of(shown, before)}\n{last}: {ON_STATOR if lies else LINEAR}"


def draw_clearance(ax: Axes, part: xr.Dataset, *, over: str = SPEED) -> None:
    """Draw the clearance of a contact over a parameter, unless it is 0."""
    line: Any = {"color": palette.GREY, "lw": 0.9, "ls": "--", "zorder": 1.5, "label": "clearance"}
    gaps = clearances_in(part).values
    if over in ("clearance", "delta0"):
        ax.plot(part[over].values.ravel(), gaps.ravel(), **line)
    elif gaps.item() > 0.0:
        ax.axhline(gaps.item(), **line)


def mark_beyond(
    ax: Axes, across: Values, heights: Values, variable: xr.DataArray, words: str, colour: str
) -> None:
    """Mark at the upper edge what lies above it, and tell how far."""
    if across.size:
        (least, most), unit = lengths_text(units_in(variable), heights.min(), heights.max())
        told = " to ".join(dict.fromkeys([least, most]))
        ax.plot(across, np.full(across.size, 0.985), ls="", marker="^", ms=3.6, mec=colour,
                mfc="white", mew=0.8, label=f"{words}: off the axis, {told} {unit}".rstrip(),
                zorder=3.3, transform=ax.get_xaxis_transform())  # fmt: skip


def _draw_whirls(ax: Axes, whirls: xr.Dataset, over: str, quantity: str, *, given: bool) -> None:
    """Draw exact whirls: the lines of a curve, points by their stability, or marks beside these."""
    if "piece" in whirls.variables:
        draw_curve(ax, whirls, over=over, quantity=quantity)
        return
    values = speeds_in(whirls[over]) if over == SPEED else whirls[over]
    same = xr.broadcast(values, whirls[quantity], whirls["stability"])
    places, heights, stability = (each.values.ravel() for each in same)
    if given:
        draw_marks(ax, places, heights, "o", palette.BLUE, size=3.6, label="whirl at a given speed",
                   level=3.1)  # fmt: skip
        return
    size = 1.5 if values.size > FEW_POINTS else 3.0
    touches = whirls.get("in_contact")
    is_free = touches is not None and "special" not in touches.dims and not touches.values.any()
    for word, (label, _, _, colour) in LINES.items():
        chosen = (stability == flags_of(whirls["stability"])[word]) & np.isfinite(heights)
        if chosen.any():
            draw_marks(ax, places[chosen], heights[chosen], "o", colour, size=size, edge=0.0,
                       label=legends.CONTACT_FREE if is_free and word == "neutral" else label,
                       level=2.5)  # fmt: skip


def _draw_specials(ax: Axes, found: Mapping[str, xr.Dataset], quantity: str, axis: _Axis) -> None:
    """Mark folds, Hopf points and grazes, if any are given."""
    for word, (label, mark, size) in SPECIALS.items():
        if f"{word}_points" in found:
            points = found[f"{word}_points"]
            speeds, heights = _special_points(points, word, found.get("exact", points))
            if quantity == "phase_lag":
                # A = omega sin(theta)/(2 zeta), and at every fold the lag is beyond a quarter turn
                sine = 2.0 * axis.held["zeta"] * heights / scale_of(points, "length") / speeds
                heights = math.pi - np.arcsin(np.minimum(sine, 1.0))
        elif "special" in found:
            special = found["special"]
            chosen = special["special_kind"].values == SPECIAL[word]
            if word == "graze":
                chosen &= special["grazed_contact"].values == special["contact"].item()
            speeds = speeds_in(special["special_speed"]).values[chosen]
            heights = special["amplitude"].values[chosen]
        else:
            continue
        if speeds.size:
            draw_marks(ax, speeds, heights, mark, palette.INK, size=size, face="white", label=label,
                       level=3.7)  # fmt: skip


def _draw_thresholds(ax: Axes, special: xr.Dataset) -> None:
    """Draw a line at the speeds beyond which the linear system is unstable, or no longer is."""
    chosen = special["special_kind"].values == SPECIAL["threshold"]
    for speed in np.unique(speeds_in(special["special_speed"]).values[chosen]).tolist():
        ax.axvline(speed, color=palette.DARK_BROWN, lw=0.9, ls=DOTS, zorder=1.6,
                   label=legends.THRESHOLD)  # fmt: skip


def _special_points(dataset: xr.Dataset, name: str, exact: xr.Dataset) -> tuple[Values, Values]:
    """Return speed and amplitude of folds or Hopf points within the range of the curve."""
    omega = dataset[f"{name}_omega"].values.ravel()
    here = np.isfinite(omega)
    if "omega" in exact.variables:
        here &= (omega >= float(exact["omega"].min())) & (omega <= float(exact["omega"].max()))
    return omega[here], dataset[f"{name}_amplitude"].values.ravel()[here]


def draw_curve(ax: Axes, curve: xr.Dataset, *, over: str, quantity: str) -> None:
    """Draw the pieces of a response curve, a line for each stability."""
    x, y = curve[over].values.ravel(), curve[quantity].values.ravel()
    stability, piece = curve["stability"].values.ravel(), curve["piece"].values.ravel()
    flags = flags_of(curve["stability"])
    in_contact = curve["in_contact"].values.ravel() == 1
    turns = np.flatnonzero((np.diff(piece) != 0) | (np.diff(stability) != 0)) + 1
    lines: dict[int, list[Values]] = {}
    for points in np.split(np.arange(x.size), turns):
        first, last = int(points[0]), int(points[-1])
        if first > 0 and piece[first - 1] == piece[first]:
            first -= 1  # the fold, where the line before ends
        line = np.stack([x[first : last + 1], y[first : last + 1]])
        lines.setdefault(int(stability[last]), []).extend((line, np.full((2, 1), math.nan)))
    for word, (label, dashes, width, _) in LINES.items():
        flag = flags[word]
        if flag not in lines:
            continue
        # without damping contacting whirls are neutral too
        free = word == "neutral" and not in_contact[stability == flag].any()
        ax.plot(*np.concatenate(lines[flag], axis=1), ls=dashes, lw=width, color=palette.INK,
                label=legends.CONTACT_FREE if free else label, zorder=2.5)  # fmt: skip


def _of_each_kind(
    simulated: xr.Dataset, names: Sequence[str]
) -> Iterator[tuple[str, _Look, dict[str, Values]]]:
    """Yield the kinds of response in a sweep, how each is drawn, and its values by name."""
    same = xr.broadcast(*(simulated[name] for name in ("response", *names)))
    response, *columns = (each.values.ravel() for each in same)
    flags = flags_of(simulated["response"])
    for kind, drawn in KINDS.items():
        of_kind = response == flags.get(kind)
        if of_kind.any():
            points = zip(names, columns, strict=True)
            yield kind, drawn, {name: values[of_kind] for name, values in points}


def _lies_aside(simulated: xr.Dataset) -> bool:
    """Return whether whirls of a sweep are not about the centre, as under the weight of a rotor.

    Then their amplitude is no distance from the centre, which is that of all other responses.
    """
    apart = simulated["radius_max"] - simulated["radius_min"] > ASIDE * simulated["radius_max"]
    return bool((is_of_kind(simulated["response"], STEADY) & apart).any())


def _draw_simulated(
    ax: Axes, simulated: xr.Dataset, quantity: str, over: str, highest: float, *, as_ranges: bool
) -> None:
    """Draw the responses of a sweep: marks where a curve can show them, bars where it cannot."""
    if over == SPEED:
        simulated = simulated.assign_coords({over: speeds_in(simulated[over])})
    for kind, drawn, points in _of_each_kind(simulated, (over, *SIMULATED[1:])):
        if as_ranges or (drawn.is_range and quantity == "amplitude"):
            low, high = points["radius_min"], points["radius_max"]
            within = high <= highest
            mark_beyond(ax, points[over][~within], high[~within], simulated["radius_max"],
                        KIND_WORDS[kind], drawn.colour)  # fmt: skip
            if within.any():
                ax.vlines(
                    points[over][within], low[within], high[within], color=drawn.colour,
                    lw=1.8 if drawn.filled else 0.9, ls=drawn.dashes, zorder=3.0,
                    label=f"{KIND_WORDS[kind]}: range of $|z|$",
                )  # fmt: skip
            for end in (low, high):
                _draw_by_direction(ax, drawn, points, over, np.where(within, end, np.nan), 0.75)
            continue
        _draw_by_direction(ax, drawn, points, over, points[quantity], 1.0)
        draw_marks(ax, [], [], "s", drawn.colour, size=4.5, face=drawn.face, edge=0.9,
                   label=KIND_WORDS[kind])  # fmt: skip
    along = str(simulated.attrs.get("along", "omega"))
    words = {
        0: _words_of(over, _start_words(simulated)),
        1: _words_of(along, legends.GOING_UP),
        -1: _words_of(along, legends.GOING_DOWN),
    }
    for direction in np.unique(simulated["direction"]).tolist():
        marker, size = DIRECTIONS[direction]
        draw_marks(ax, [], [], marker, palette.INK, size=size, face="none", edge=0.8,
                   label=words[direction])  # fmt: skip


def _draw_by_direction(
    ax: Axes, drawn: _Look, points: dict[str, Values], over: str, heights: Values, scale: float
) -> None:
    """Mark points by the direction of their sweep, triangles over the larger circles."""
    for direction, (marker, size) in DIRECTIONS.items():
        here = points["direction"] == direction
        draw_marks(
            ax, points[over][here], heights[here], marker, drawn.colour, size=scale * size,
            face=drawn.face, edge=0.7, level=3.2 if direction else 3.1,
        )  # fmt: skip


def _words_of(name: str, words: str) -> str:
    """Return words about the speed as words about a parameter."""
    known = OF_ROTOR.get(name) or PARAMETERS_OF_SYSTEM.get(name)
    return words if known is None or name == "omega" else words.replace("speed", known.label)


def _start_words(simulated: xr.Dataset) -> str:
    words = {*str(simulated.attrs.get("start_words", "")).split()}
    if words in ({"rest"}, {"settled"}):
        return legends.FROM_REST if words == {"rest"} else legends.FROM_WHIRL
    starts = (
        [f"start_{name}" for name in COMPONENTS] if is_of_disc(simulated) else ["initial_state"]
    )
    at_rest = all(name in simulated and not simulated[name].values.any() for name in starts)
    return legends.FROM_REST if at_rest else legends.FROM_START


def plot_unbalance_response(
    whirls: xr.Dataset, *, special: xr.Dataset | None = None, ax: Axes | None = None
) -> Axes:
    """Draw the largest axis of the orbit of each node by unbalance over the spin speed.

    Parameters
    ----------
    whirls : Dataset
        Result of `rotor_ida.synchronous_response` for a rotor system. Of more than five nodes,
        those with the largest orbits are drawn. Beyond a touch, where the response is not linear,
        lines are thin and dotted.
    special : Dataset, optional
        Result of `rotor_ida.special_speeds` for the same system, whose thresholds of instability
        are vertical lines.
    ax : Axes, optional
        Axes to draw on and return; default: those of a new figure.

    Examples
    --------
    >>> from rotor_ida import Rotor, synchronous_response
    >>> system = Rotor(omega=1.0, zeta=0.07, delta0=0.5).system()
    >>> whirls = synchronous_response(system, contacts=[], speed=[0.5, 1.0, 1.5])
    >>> plot_unbalance_response(whirls).lines[0].get_label()
    'disc'
    """
    whirls = check_dataset(
        "whirls", whirls, ("speed", "node_major_axis", "node", "unbalance_radius")
    )
    linear = (whirls["unbalance_radius"] <= clearances_in(whirls)).all("contact").values
    axes, names = whirls["node_major_axis"].values, whirls["node"].values
    chosen = np.sort(np.argsort(-axes.max(axis=0), kind="stable")[:MOST_NODES])
    with drawing(ax) as ax:
        speeds = label_parameter(ax.xaxis, SPEED, whirls)
        label_axis(
            ax.yaxis, "node_major_axis", whirls["node_major_axis"],
            words="largest axis, peak to peak",
        )  # fmt: skip
        for number, node in enumerate(chosen):
            colour, dashes = palette.look(number)
            if not linear.all():
                ax.plot(speeds, axes[:, node], color=colour, lw=0.7, ls=DOTS)
            ax.plot(speeds, np.where(linear, axes[:, node], np.nan), color=colour, ls=dashes,
                    label=in_figure(names[node]))  # fmt: skip
        if not linear.all():
            ax.plot([], [], color=palette.GREY, lw=0.7, ls=DOTS, label=legends.BEYOND_TOUCH)
        if special is not None:
            _draw_thresholds(ax, special)
        ax.set_yscale("log")
        ax.set_title("unbalance response by node")
        legend_below(ax, columns=4)
    return ax
