"""Plots of bifurcation diagrams: extrema of the radius, or states once a revolution."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from typing import Literal, NamedTuple

import numpy as np
import numpy.typing as npt
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from rotor_ida.arrays import Values
from rotor_ida.checks import check_choice, check_instance
from rotor_ida.errors import InputError
from rotor_ida.model.parameters import PARAMETERS
from rotor_ida.plot.appearance import (
    BLUE,
    GREY,
    ORANGE,
    PURPLE,
    draw_marks,
    drawing,
    legend_below,
    own_legend,
)
from rotor_ida.plot.datasets import (
    at_node,
    check_dataset,
    check_same_parameters,
    check_same_units,
    fixed_parameters,
    one_value,
    parameters_in,
    touching_nodes,
)
from rotor_ida.plot.labels import SEPARATOR, in_lines, label_axis, label_parameter, parameter_text
from rotor_ida.plot.responses import plot_amplitude
from rotor_ida.plot.system_sweeps import held_in, label_over, text_of_system
from rotor_ida.plot.system_whirls import panels_of_contacts
from rotor_ida.results.rows import own_rows
from rotor_ida.results.si_units import scale_of
from rotor_ida.schema import flags_of
from rotor_ida.texts import in_figure

# Parts of a bifurcation diagram.
FREE = "extremum, contact-free or unresolved"
FREE_KINDS = ("contact_free", "touching", "unresolved")
EXTREMA = {
    "constant": ("constant radius", BLUE),
    "maximum": ("local maximum of $|z|$", ORANGE),
    "minimum": ("local minimum of $|z|$", PURPLE),
}
FEW_EXTREMA = 3000
# Top of the axes over the largest extremum.
HEADROOM = 1.06
WITH_EXTREMA = ("response", "extremum_count", "extremum_radius", "extremum_kind")
OF_SYSTEM = ("speed", "node", "contact_node")
# States once a revolution, by the direction of a sweep.
WAYS = {0: ("once a revolution", BLUE), 1: ("going up", BLUE), -1: ("going down", ORANGE)}
UNRESOLVED = "unresolved"
# Size of the points going up over that of those going down, which may lie on them.
BENEATH = 1.5


def plot_extrema(
    found: xr.Dataset,
    *,
    node: str | None = None,
    exact: xr.Dataset | None = None,
    fold_points: xr.Dataset | None = None,
    ax: Axes | None = None,
) -> Axes:
    """Draw the extrema of the radius over the varying parameter.

    Parameters
    ----------
    found : Dataset
        Result of `rotor_ida.bifurcation_diagram`, in which one parameter varies. It may contain
        several ``delta0`` beside `exact`.
    node : str, optional
        Name of a node of a rotor system; by default that of the first contact.
    exact : Dataset, optional
        Result of `rotor_ida.closed_forms.response_curve` for the same disc, parameters and one
        ``delta0``. It is drawn under the extrema over the speed, which are shown for this
        clearance only.
    fold_points : Dataset, optional
        Result of `rotor_ida.folds` for the same parameters.
    ax : Axes, optional
        Axes to draw on and return; default: those of a new figure.

    Examples
    --------
    >>> from rotor_ida import bifurcation_diagram
    >>> found = bifurcation_diagram(omega=[1.2, 1.7], zeta=0.5, delta0=0.5, starts=[(0, 0, 0, 0)])
    >>> plot_extrema(found).get_ylabel()
    'radius $|z|$'
    """
    is_system = isinstance(found, xr.Dataset) and "node" in found.variables
    needed = OF_SYSTEM if is_system else PARAMETERS
    found = at_node(check_dataset("found", found, (*needed, *WITH_EXTREMA)), node)
    if is_system and exact is not None:
        raise InputError("exact must be left out for a rotor system")
    over, held = held_in(found) if is_system else _varied(found, exact)
    delta0 = None if over == "delta0" else held.get("delta0")
    with drawing(ax) as ax:
        places = label_over(ax, found, over)
        extrema = _extrema_of(found, found[over].copy(data=places), delta0)
        if is_system:
            _title_node(ax, found, held)
        elif exact is None:
            ax.set_title(in_lines(parameter_text(held)))
        else:
            plot_amplitude(exact, fold_points=fold_points, ax=ax)
        size = 2.6 if extrema.here.sum() < FEW_EXTREMA else 1.2
        for words, (colour, chosen) in extrema.groups.items():
            if not chosen.any():
                continue
            steady = words == EXTREMA["constant"][0]
            face = "none" if steady else colour
            ax.plot(
                extrema.across[chosen], extrema.radius[chosen], ls="", marker="o",
                ms=3.4 if steady else size, mec=colour if steady else "none", mfc=face, mew=0.7,
                rasterized=True, zorder=2.4 if words == FREE else 3.0,
            )  # fmt: skip
            draw_marks(ax, [], [], "o", colour, size=3.4, face=face, edge=0.7, label=words)
        if exact is not None:  # whose amplitudes may be the smaller
            highest = extrema.radius[extrema.here].max(initial=0.0)
            ax.set_ylim(top=max(ax.get_ylim()[1], HEADROOM * highest))
        if exact is not None:  # which has labelled it otherwise
            label_parameter(ax.xaxis, over, found)
        label_axis(ax.yaxis, "radius", found["extremum_radius"])
        own_legend(ax)
    return ax


class _Extrema(NamedTuple):
    """The extrema of a diagram as flat arrays: which are shown, and each kind."""

    across: Values
    radius: Values
    here: npt.NDArray[np.bool_]
    groups: dict[str, tuple[str, npt.NDArray[np.bool_]]]


def _extrema_of(found: xr.Dataset, over: xr.DataArray, delta0: float | None) -> _Extrema:
    """Return the extrema over a parameter, for one clearance or all."""
    found = own_rows(found)
    counts = found["extremum_count"]
    clearances = found["delta0"] if "delta0" in found.variables else xr.DataArray(np.nan)
    places = xr.broadcast(over, clearances, found["response"], counts)
    across, clearance, response = (
        np.repeat(place.transpose(*counts.dims).values.ravel(), counts.values.ravel())
        for place in places[:3]
    )
    if over.name == "omega" and "extremum_speed" in found.variables:
        across = found["extremum_speed"].values / scale_of(found, "speed")
    here = np.full(clearance.shape, True) if delta0 is None else clearance == delta0
    # the extrema of an unresolved motion may not last
    free = _is_of(response, found["response"], FREE_KINDS)
    of_kind = {
        kind: here & _is_of(found["extremum_kind"].values, found["extremum_kind"], (kind,))
        for kind in EXTREMA
    }
    swinging = free & ~of_kind["constant"]
    groups = {
        words: (colour, of_kind[kind] & ~swinging) for kind, (words, colour) in EXTREMA.items()
    }
    groups[FREE] = (GREY, here & swinging)
    return _Extrema(across, found["extremum_radius"].values, here, groups)


def _is_of(
    numbers: Values, variable: xr.DataArray, kinds: tuple[str, ...]
) -> npt.NDArray[np.bool_]:
    """Return a mask of the flags that are of some kinds."""
    flags = flags_of(variable)
    return np.isin(numbers, [flags[kind] for kind in kinds if kind in flags])


def _varied(found: xr.Dataset, exact: xr.Dataset | None) -> tuple[str, dict[str, float]]:
    """Return the varying parameter of a diagram, and the values of the others."""
    names = parameters_in(found)
    if exact is None:
        varied = [name for name in names if found[name].size > 1]
        over = varied[0] if len(varied) == 1 else "omega"
        others = {name: one_value("found", found, name) for name in names if name != over}
        return over, others
    exact = check_dataset("exact", exact, ("omega", "amplitude"))
    check_same_units("exact", exact, found)
    others = {name: one_value("found", found, name) for name in names[1:] if name != "delta0"}
    check_same_parameters("found", others, fixed_parameters("exact", exact, ("zeta",)))
    delta0 = one_value("exact", exact, "delta0")
    if delta0 not in found["delta0"].values:
        raise InputError(f"found must contain the delta0 of exact, {delta0!r}, it does not")
    return "omega", others | {"delta0": delta0}


def plot_strobes(
    found: xr.Dataset,
    *,
    axis: Literal["x", "y"] = "x",
    node: str | None = None,
    ax: Axes | None = None,
) -> Axes:
    """Draw a stroboscopic bifurcation diagram: a displacement once a revolution, over a parameter.

    Parameters
    ----------
    found : Dataset
        Result of `rotor_ida.bifurcation_diagram` with ``at="revolution"``, in which one parameter
        varies.
    axis : {"x", "y"}
        The displacement that is drawn: along the unbalance, or across it.
    node : str, optional
        Name of a node of a rotor system; by default that of the first contact.
    ax : Axes, optional
        Axes to draw on and return; default: those of a new figure.

    Examples
    --------
    >>> from rotor_ida import bifurcation_diagram
    >>> found = bifurcation_diagram(
    ...     omega=[1.2, 1.7], zeta=0.5, delta0=0.5, starts=[(0, 0, 0, 0)], at="revolution"
    ... )
    >>> plot_strobes(found).get_title().splitlines()[-1]
    'once a revolution'
    """
    name = f"rotating_{check_choice('axis', axis, ('x', 'y'))}"
    is_system = isinstance(found, xr.Dataset) and "node" in found.variables
    needed = OF_SYSTEM if is_system else PARAMETERS
    found = at_node(check_dataset("found", found, (*needed, "response", name)), node)
    over, held = held_in(found) if is_system else _varied(found, None)
    ways = found["direction"].values.ravel().tolist() if "direction" in found.variables else [0]
    with drawing(ax) as ax:
        places = found[over].copy(data=label_over(ax, found, over))
        places, values, response = xr.broadcast(places, found[name], found["response"])
        size = 2.6 if values.size < FEW_EXTREMA else 1.2
        edge = BENEATH if len(ways) > 1 else 1.0
        unresolved = _is_of(response.values, found["response"], (UNRESOLVED,))
        groups = [(UNRESOLVED, GREY, unresolved)]
        for way in ways:
            here = xr.full_like(response, True, bool)
            if len(ways) > 1:
                here = xr.broadcast(found["direction"] == way, response)[0]
            groups.append((*WAYS[way], here.transpose(*response.dims).values & ~unresolved))
        for words, colour, chosen in groups:
            if chosen.any():
                larger = edge if words == WAYS[1][0] else 1.0  # what lies on it hides it otherwise
                ax.plot(places.values[chosen], values.values[chosen], ls="", marker="o",
                        ms=larger * size, mec="none", mfc=colour, rasterized=True)  # fmt: skip
                if len(ways) > 1 or words == UNRESOLVED:
                    draw_marks(ax, [], [], "o", colour, size=3.4, label=words)
        label_axis(ax.yaxis, name, found[name])
        phase = float(found.attrs.get("phase", 0.0))
        words = f"unbalance at {math.degrees(phase):.4g}°" if phase else "once a revolution"
        if is_system:
            _title_node(ax, found, held, words)
        else:
            ax.set_title(f"{in_lines(parameter_text(held))}\n{words}")
        if ax.get_legend_handles_labels()[1]:
            legend_below(ax)  # points fill the axes
    return ax


def _title_node(ax: Axes, found: xr.Dataset, held: Mapping[str, float], words: str = "") -> None:
    """Name the node, and the values of the parameters that do not vary."""
    named = [f"node {in_figure(str(found['node'].values))}", text_of_system(found, held)]
    ax.set_title("\n".join(filter(None, [SEPARATOR.join(filter(None, named)), words])))


def diagram_figure(found: xr.Dataset) -> Figure:
    """Draw a bifurcation diagram of a rotor system: a panel for each node that touches a stator.

    Parameters
    ----------
    found : Dataset
        Result of `rotor_ida.bifurcation_diagram` for a rotor system.

    Examples
    --------
    >>> from rotor_ida import Rotor, bifurcation_diagram
    >>> system = Rotor(omega=1.0, zeta=0.07, delta0=0.5).system()
    >>> found = bifurcation_diagram(system, speed=[0.5, 1.0], revolutions=8)
    >>> len(diagram_figure(found).axes)
    1
    """
    found = check_instance("found", found, xr.Dataset)
    draw: Callable[..., Axes] = plot_strobes if "rotating_x" in found.variables else plot_extrema
    check_dataset("found", found, OF_SYSTEM)
    nodes = touching_nodes(found)
    return panels_of_contacts(len(nodes), lambda number, ax: draw(found, node=nodes[number], ax=ax))
