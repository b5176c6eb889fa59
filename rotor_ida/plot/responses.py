"""Response curves over spin speed or clearance, with simulated responses."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
import xarray as xr
from matplotlib.axes import Axes

from rotor_ida.arrays import Values
from rotor_ida.checks import COMPONENTS
from rotor_ida.errors import InputError
from rotor_ida.model.parameters import OF_ROTOR, OPTIONAL, PARAMETERS
from rotor_ida.model.system_parameters import PARAMETERS_OF_SYSTEM
from rotor_ida.plot.appearance import (
    BLUE,
    CONTACT_FREE,
    DARK_BROWN,
    FOLD,
    FROM_REST,
    FROM_START,
    FROM_WHIRL,
    GOING_DOWN,
    GOING_UP,
    GREEN,
    GREY,
    HOPF,
    INK,
    NEUTRAL,
    ORANGE,
    PURPLE,
    RED,
    STABLE,
    UNSTABLE,
    draw_marks,
    drawing,
    own_legend,
    raise_limit,
)
from rotor_ida.plot.datasets import (
    check_dataset,
    check_same_parameters,
    check_same_units,
    fixed_parameters,
    one_value,
    parameters_in,
)
from rotor_ida.plot.labels import (
    KIND_WORDS,
    LABELS,
    in_lines,
    label_axis,
    label_parameter,
    parameter_text,
)
from rotor_ida.results.si_units import scale_of
from rotor_ida.schema import flags_of

LINES = {
    "stable": (STABLE, "-", 1.3),
    "unstable": (UNSTABLE, (0, (4, 2)), 1.0),
    "neutral": (NEUTRAL, (0, (7, 1.6, 1.2, 1.6)), 1.0),
}
CURVE = ("omega", "zeta", "delta0", "amplitude", "phase_lag", "stability", "in_contact", "piece")
NO_CURVE = "no exact curve"
SIMULATED = ("response", "amplitude", "phase_lag", "radius_min", "radius_max", "direction")
# Results drawn beside a curve, and the variables that they need.
BESIDE = {
    "whirls": (*PARAMETERS, "amplitude", "phase_lag"),
    "simulated": (*PARAMETERS, *SIMULATED),
    "fold_points": ("zeta", "delta0", "fold_omega", "fold_amplitude"),
    "hopf_points": ("zeta", "delta0", "hopf_omega", "hopf_amplitude"),
}


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
KINDS = {
    "synchronous": _Look(BLUE, True, False),
    "contact_free": _Look(BLUE, False, False),
    "bouncing": _Look(ORANGE, False, True),
    "full_contact": _Look(PURPLE, True, True),
    "rolling": _Look(DARK_BROWN, True, True, LONG),
    "touching": _Look(INK, False, False),
    "quasi_periodic": _Look(GREEN, False, True),
    "chaotic": _Look(RED, True, True, DOTS),
    "unresolved": _Look(GREY, False, True, DOTS),
}
DIRECTIONS = {0: ("o", 4.2), 1: ("^", 3.4), -1: ("v", 3.4)}


def plot_amplitude(
    exact: xr.Dataset | None,
    *,
    whirls: xr.Dataset | None = None,
    simulated: xr.Dataset | None = None,
    fold_points: xr.Dataset | None = None,
    hopf_points: xr.Dataset | None = None,
    ax: Axes | None = None,
) -> Axes:
    """Draw the amplitude of every whirl over the spin speed.

    Parameters
    ----------
    exact : Dataset or None
        Result of `rotor_ida.closed_forms.response_curve`, for one ``zeta``, one ``delta0``
        and one of each other parameter. None for `simulated` alone, where no curve exists: under
        a load.
    whirls : Dataset, optional
        Result of `rotor_ida.synchronous_response`, for the same parameters: the whirls at
        its speeds are marked.
    simulated : Dataset, optional
        Result of `rotor_ida.sweep`, for the same parameters. Synchronous, contact-free and
        touching responses are marks at their amplitude, by direction of the sweep. All others
        are bars over the range of the distance from the bearing axis.
    fold_points : Dataset, optional
        Result of `rotor_ida.folds`, for the same parameters: the folds are marked.
    hopf_points : Dataset, optional
        Result of `rotor_ida.hopf_points`, for the same parameters: they are marked.
    ax : Axes, optional
        Axes to draw on and return; default: those of a new figure.

    Raises
    ------
    InputError
        If a dataset is of another kind, has several values of a parameter, or values other than
        `exact`; if there is nothing to draw.

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
    beside = {"whirls": whirls, "simulated": simulated, "fold_points": fold_points,
              "hopf_points": hopf_points}  # fmt: skip
    return _plot_over_speed("amplitude", exact, beside, ax)


def plot_phase(
    exact: xr.Dataset | None,
    *,
    whirls: xr.Dataset | None = None,
    simulated: xr.Dataset | None = None,
    fold_points: xr.Dataset | None = None,
    ax: Axes | None = None,
) -> Axes:
    r"""Draw the phase by which every whirl lags the unbalance over the spin speed.

    Parameters
    ----------
    exact, whirls, simulated, fold_points, ax
        As for `plot_amplitude`. For a simulated response that is neither synchronous nor
        contact-free, the mark is the phase of the component at the spin speed.

    Examples
    --------
    >>> from rotor_ida.closed_forms import response_curve
    >>> ax = plot_phase(response_curve(zeta=0.5, delta0=0.0, limits=(0.5, 2.0)))
    >>> ax.get_ylabel()
    'phase lag $\\theta$'
    """
    beside = {"whirls": whirls, "simulated": simulated, "fold_points": fold_points}
    return _plot_over_speed("phase_lag", exact, beside, ax)


def plot_over_clearance(
    exact: xr.Dataset, *, simulated: xr.Dataset | None = None, ax: Axes | None = None
) -> Axes:
    r"""Draw the whirls at one speed over the clearance, with simulated responses.

    Parameters
    ----------
    exact : Dataset
        Result of `rotor_ida.closed_forms.clearance_curve`, for one ``omega`` and one
        ``zeta``.
    simulated : Dataset, optional
        Result of `rotor_ida.sweep` at the same speed and damping. Responses on a whirl are
        marks, by direction of the sweep, all others bars over the range of the distance from the
        bearing axis.
    ax : Axes, optional
        Axes to draw on and return; default: those of a new figure.

    Examples
    --------
    >>> from rotor_ida.closed_forms import clearance_curve
    >>> exact = clearance_curve(omega=1.2, zeta=0.07, limits=(0.0, 3.0))
    >>> plot_over_clearance(exact).get_xlabel()
    'clearance $\\delta_0$'
    """
    exact = check_dataset("exact", exact, CURVE)
    parameters = fixed_parameters("exact", exact, ("omega", "zeta"))
    if simulated is not None:
        simulated = check_dataset("simulated", simulated, ("delta0", *SIMULATED))
        optional = {name: value for name, value in parameters.items() if name in OPTIONAL}
        check_same_parameters("simulated", fixed_parameters("simulated", simulated, ()), optional)
        check_same_units("simulated", simulated, exact)
    with drawing(ax) as ax:
        draw_curve(ax, exact, over="delta0", quantity="amplitude")
        if simulated is not None:
            draw_simulated(ax, simulated, "amplitude", over="delta0")
        ax.set_xlabel(LABELS["delta0"])
        label_axis(ax.yaxis, "amplitude", exact["amplitude"])
        ax.set_ylim(bottom=0.0)
        ax.set_title(in_lines(parameter_text(parameters)))
        own_legend(ax)
    return ax


def plot_along(
    simulated: xr.Dataset, *, whirls: xr.Dataset | None = None, ax: Axes | None = None
) -> Axes:
    r"""Draw the responses of a sweep up or down over the parameter that rises and falls.

    Parameters
    ----------
    simulated : Dataset
        Result of `rotor_ida.sweep` with a direction, for one value of each other parameter. The
        attribute ``along`` names the parameter on the axis. Responses on a whirl are marks at their
        amplitude, by direction; all others are bars over the range of the distance from the bearing
        axis.
    whirls : Dataset, optional
        Result of `rotor_ida.synchronous_response` over many values of that parameter, which are
        drawn as dots.
    ax : Axes, optional
        Axes to draw on and return; default: those of a new figure.

    Examples
    --------
    >>> from rotor_ida import sweep
    >>> both = sweep(omega=1.5, zeta=0.5, delta0=[0.5, 1.0], direction="both")
    >>> plot_along(both).get_xlabel()
    'clearance $\\delta_0$'
    """
    simulated = check_dataset("simulated", simulated, (*PARAMETERS, *SIMULATED))
    over = str(simulated.attrs.get("along", "omega"))
    names = [name for name in parameters_in(simulated) if name != over]
    held = {name: one_value("simulated", simulated, name) for name in names}
    with drawing(ax) as ax:
        if whirls is not None:
            whirls = check_dataset("whirls", whirls, (over, "amplitude", "stability"))
            check_same_units("whirls", whirls, simulated)
            draw_beneath(ax, whirls[over], whirls)
        draw_simulated(ax, simulated, "amplitude", over=over)
        label_parameter(ax.xaxis, over, simulated)
        label_axis(ax.yaxis, "amplitude", simulated["amplitude"])
        ax.set_ylim(bottom=0.0)
        ax.set_title(in_lines(parameter_text(held)))
        own_legend(ax)
    return ax


def draw_beneath(ax: Axes, across: xr.DataArray, whirls: xr.Dataset) -> None:
    """Draw exact whirls as small dots by their stability, close enough to be read as lines."""
    same = xr.broadcast(across, whirls["amplitude"], whirls["stability"])
    places, heights, stability = (each.values.ravel() for each in same)
    for word, (label, *_) in LINES.items():
        chosen = (stability == flags_of(whirls["stability"])[word]) & np.isfinite(heights)
        if chosen.any():
            colour = GREY if word == "unstable" else INK
            draw_marks(ax, places[chosen], heights[chosen], "o", colour, size=1.5, edge=0.0,
                       label=f"exact, {label}", level=2.5)  # fmt: skip


def _plot_over_speed(
    quantity: str,
    exact: xr.Dataset | None,
    beside: Mapping[str, xr.Dataset | None],
    ax: Axes | None,
) -> Axes:
    """Draw amplitude or phase of a curve over the speed, with the other results."""
    given = {
        name: check_dataset(name, dataset, BESIDE[name])
        for name, dataset in beside.items()
        if dataset is not None
    }
    simulated = given.get("simulated")
    if exact is not None:
        shown = exact = check_dataset("exact", exact, CURVE)
    elif simulated is not None:
        shown = simulated
    else:
        raise InputError("exact must be a Dataset, or None beside simulated, got neither")
    parameters = fixed_parameters("simulated" if exact is None else "exact", shown)
    for name, dataset in given.items():
        check_same_parameters(name, fixed_parameters(name, dataset), parameters)
        check_same_units(name, dataset, shown)
    with drawing(ax) as ax:
        if exact is not None:
            draw_curve(ax, exact, over="omega", quantity=quantity)
        _draw_points(ax, quantity, given, shown, parameters["zeta"])
        if simulated is not None:
            draw_simulated(ax, simulated, quantity)
        label_parameter(ax.xaxis, "omega", shown)
        label_axis(ax.yaxis, quantity, shown[quantity])
        ax.set_xlim(0.0, 1.02 * float(shown["omega"].max()))
        if quantity == "amplitude":
            heights = [shown["amplitude"]]
            heights += [] if simulated is None else [simulated["radius_max"]]
            raise_limit(ax, max(float(each.max()) for each in heights))
        else:
            ax.set_ylim(0.0, 1.06 * math.pi)
            ax.set_yticks([0.0, 0.5 * math.pi, math.pi], ["0", r"$\pi/2$", r"$\pi$"])
        ax.set_title(
            _without_curve(parameters) if exact is None else in_lines(parameter_text(parameters))
        )
        own_legend(ax)
    return ax


def _without_curve(parameters: Mapping[str, float]) -> str:
    """Return the title of a panel without a curve, with the reason."""
    last = {name: value for name, value in parameters.items() if name == "load"}
    before = {name: value for name, value in parameters.items() if name != "load"}
    reason = f"{parameter_text(last)}: {NO_CURVE} under a load" if last else NO_CURVE
    return f"{parameter_text(before)}\n{reason}"


def _draw_points(
    ax: Axes, quantity: str, given: Mapping[str, xr.Dataset], shown: xr.Dataset, zeta: float
) -> None:
    """Mark the whirls at given speeds, folds and Hopf points, if any."""
    if "whirls" in given:
        whirls = given["whirls"]
        across, up = xr.broadcast(whirls["omega"], whirls[quantity])
        draw_marks(ax, across.values.ravel(), up.values.ravel(), "o", BLUE, size=3.6,
                   label="whirl at a given speed", level=3.1)  # fmt: skip
    if "fold_points" in given:
        folds = given["fold_points"]
        omega, height = _special_points(folds, "fold", shown)
        if quantity == "phase_lag":
            # A = omega sin(theta)/(2 zeta), and at every fold the lag is beyond a quarter turn
            sine = 2.0 * zeta * height / scale_of(folds, "length") / omega
            height = math.pi - np.arcsin(np.minimum(sine, 1.0))
        if omega.size:
            draw_marks(ax, omega, height, "D", INK, size=4.0, face="white", label=FOLD, level=3.7)
    if "hopf_points" in given:
        omega, height = _special_points(given["hopf_points"], "hopf", shown)
        if omega.size:
            draw_marks(ax, omega, height, "o", INK, size=4.6, face="white", label=HOPF, level=3.7)


def _special_points(dataset: xr.Dataset, name: str, exact: xr.Dataset) -> tuple[Values, Values]:
    """Return speed and amplitude of folds or Hopf points within the range of the curve."""
    omega = dataset[f"{name}_omega"].values.ravel()
    here = (omega >= float(exact["omega"].min())) & (omega <= float(exact["omega"].max()))
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
    for word, (label, dashes, width) in LINES.items():
        flag = flags[word]
        if flag not in lines:
            continue
        # without damping contacting whirls are neutral too
        free = word == "neutral" and not in_contact[stability == flag].any()
        ax.plot(*np.concatenate(lines[flag], axis=1), ls=dashes, lw=width, color=INK,
                label=CONTACT_FREE if free else label, zorder=2.5)  # fmt: skip


def _of_each_kind(
    simulated: xr.Dataset, names: Sequence[str]
) -> Iterator[tuple[str, _Look, dict[str, Values]]]:
    """Yield the kinds of response in a sweep, how each is drawn, and its values by name."""
    same = xr.broadcast(*(simulated[name] for name in ("response", *names)))
    response, *columns = (each.values.ravel() for each in same)
    flags = flags_of(simulated["response"])
    for kind, look in KINDS.items():
        of_kind = response == flags.get(kind)
        if of_kind.any():
            points = zip(names, columns, strict=True)
            yield kind, look, {name: values[of_kind] for name, values in points}


def _range_words(kind: str, reach: str = "|z|") -> str:
    return f"{KIND_WORDS[kind]}: range of ${reach}$"


def draw_simulated(
    ax: Axes, simulated: xr.Dataset, quantity: str, *, over: str = "omega", reach: str = "|z|"
) -> None:
    """Draw the responses of a sweep: marks where a curve can show them, bars where it cannot.

    `reach` is the symbol of the distance whose range is drawn.
    """
    for kind, look, points in _of_each_kind(simulated, (over, *SIMULATED[1:])):
        if look.is_range and quantity == "amplitude":
            ax.vlines(
                points[over], points["radius_min"], points["radius_max"], color=look.colour,
                lw=1.8 if look.filled else 0.9, ls=look.dashes, zorder=3.0,
                label=_range_words(kind, reach),
            )  # fmt: skip
            for end in ("radius_min", "radius_max"):
                _draw_by_direction(ax, look, points, over, points[end], 0.75)
            continue
        _draw_by_direction(ax, look, points, over, points[quantity], 1.0)
        draw_marks(ax, [], [], "s", look.colour, size=4.5, face=look.face, edge=0.9,
                   label=KIND_WORDS[kind])  # fmt: skip
    along = str(simulated.attrs.get("along", "omega"))
    words = {
        0: _words_of(over, _start_words(simulated)),
        1: _words_of(along, GOING_UP),
        -1: _words_of(along, GOING_DOWN),
    }
    for direction in np.unique(simulated["direction"]).tolist():
        marker, size = DIRECTIONS[direction]
        draw_marks(ax, [], [], marker, INK, size=size, face="none", edge=0.8,
                   label=words[direction])  # fmt: skip


def _draw_by_direction(
    ax: Axes, look: _Look, points: dict[str, Values], over: str, heights: Values, scale: float
) -> None:
    """Mark points by the direction of their sweep, triangles over the larger circles."""
    for direction, (marker, size) in DIRECTIONS.items():
        here = points["direction"] == direction
        draw_marks(
            ax, points[over][here], heights[here], marker, look.colour, size=scale * size,
            face=look.face, edge=0.7, level=3.2 if direction else 3.1,
        )  # fmt: skip


def _words_of(name: str, words: str) -> str:
    """Return words about the speed as words about a parameter."""
    known = OF_ROTOR.get(name) or PARAMETERS_OF_SYSTEM.get(name)
    return words if known is None or name == "omega" else words.replace("speed", known.label)


def _start_words(simulated: xr.Dataset) -> str:
    words = {*str(simulated.attrs.get("start_words", "")).split()}
    if words in ({"rest"}, {"settled"}):
        return FROM_REST if words == {"rest"} else FROM_WHIRL
    # older sweeps of systems have another name
    of_system = [name for name in ("initial_state", "start_state") if name in simulated]
    starts = of_system or [f"start_{name}" for name in COMPONENTS]
    at_rest = all(name in simulated and not simulated[name].values.any() for name in starts)
    return FROM_REST if at_rest else FROM_START
