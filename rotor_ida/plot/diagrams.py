"""Plots of bifurcation diagrams: extrema of the radius, or states once a revolution."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Literal, NamedTuple

import numpy as np
import numpy.typing as npt
import xarray as xr
from matplotlib.axes import Axes

from rotor_ida.arrays import Values
from rotor_ida.checks import check_choice
from rotor_ida.errors import InputError
from rotor_ida.model.contact import SMALL_INDENTATION
from rotor_ida.model.parameters import OPTIONAL, PARAMETERS
from rotor_ida.plot.appearance import (
    BLUE,
    DASHES,
    GREY,
    INK,
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
    drawn_over,
    is_of_disc,
    one_value,
    units_in,
)
from rotor_ida.plot.labels import (
    SEPARATOR,
    in_lines,
    label_axis,
    label_parameter,
    text_of,
    unit_of,
)
from rotor_ida.plot.responses import plot_amplitude
from rotor_ida.results.archived_system import clearance_of_contacts
from rotor_ida.results.rows import own_rows
from rotor_ida.results.si_units import scale_of
from rotor_ida.schema import flags_of
from rotor_ida.texts import in_figure
from rotor_ida.units import number

# Parts of a bifurcation diagram.
FREE = "extremum, free or unresolved"
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

    Notes
    -----
    The clearance is a dashed line. Extrema that are pressed into the stator by more than the
    contact law can predict (more than a tenth of the radius of the rotor there or, of a machine,
    more than the clearance) do not set the scale: they are arrows at the upper edge.

    Examples
    --------
    >>> from rotor_ida import bifurcation_diagram
    >>> found = bifurcation_diagram(omega=[1.2, 1.7], zeta=0.5, delta0=0.5, starts=[(0, 0, 0, 0)])
    >>> plot_extrema(found).get_ylabel()
    'radius $|z|$'
    """
    found = _checked(found, node, WITH_EXTREMA)
    if exact is not None:
        found = _on_curve(found, exact)
    over, held = drawn_over("found", found)
    gaps, limit = _clearances(found), _limit_of_model(found)
    with drawing(ax, width=5.6, height=4.2) as ax:
        if exact is not None:
            plot_amplitude(exact, fold_points=fold_points, ax=ax)
        places = label_parameter(ax.xaxis, over, found)
        label_axis(ax.yaxis, "radius", found["extremum_radius"])
        extrema = _extrema_of(found, found[over].copy(data=places))
        within = extrema.radius <= limit
        size = 2.6 if extrema.radius.size < FEW_EXTREMA else 1.2
        for words, (colour, of_kind) in extrema.groups.items():
            chosen = of_kind & within
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
        for gap in gaps:
            ax.plot(places, np.broadcast_to(gap, places.shape), color=INK, lw=0.9, ls=DASHES,
                    marker="" if places.size > 1 else "_", label="clearance",
                    zorder=2.3)  # fmt: skip
        highest = [extrema.radius[within].max(initial=0.0), *(gap.max() for gap in gaps)]
        highest += [] if exact is None else [min(float(exact["amplitude"].max()), limit)]
        ax.set_ylim(bottom=min(0.0, ax.get_ylim()[0]), top=HEADROOM * max(highest))
        _mark_beyond(ax, extrema, ~within, found["extremum_radius"])
        ax.set_title(_title(found, held))
        own_legend(ax)
    return ax


class _Extrema(NamedTuple):
    """The extrema of a diagram as flat arrays, and which are of each kind."""

    across: Values
    radius: Values
    groups: dict[str, tuple[str, npt.NDArray[np.bool_]]]


def _checked(found: object, node: str | None, needed: tuple[str, ...]) -> xr.Dataset:
    """Return a diagram of a disc, or at a node of a system."""
    is_system = isinstance(found, xr.Dataset) and "node" in found.variables
    own = OF_SYSTEM if is_system else PARAMETERS
    return at_node(check_dataset("found", found, (*own, *needed)), node)


def _on_curve(found: xr.Dataset, exact: xr.Dataset) -> xr.Dataset:
    """Return the part of a diagram for the clearance of an exact curve of the same disc."""
    if not is_of_disc(found):
        raise InputError("exact must be left out for a rotor system")
    exact = check_dataset("exact", exact, ("omega", "amplitude", "zeta", "delta0"))
    check_same_units("exact", exact, found)
    delta0 = one_value("exact", exact, "delta0")
    if delta0 not in found["delta0"].values:
        raise InputError(f"found must contain the delta0 of exact, {delta0!r}, it does not")
    found = found.sel(delta0=[delta0])
    own, there = (
        {each: one_value(name, dataset, each) for each in ("zeta", *OPTIONAL)
         if each in dataset.variables}
        for name, dataset in (("found", found), ("exact", exact))
    )  # fmt: skip
    check_same_parameters("found", own, there)
    return found


def _clearances(found: xr.Dataset) -> list[Values]:
    """Return the clearances of the contacts that are shown: numbers, or along the axis."""
    if is_of_disc(found):
        return [np.asarray(found["delta0"].values, float) * scale_of(found, "length")]
    node, gaps = str(found["node"].values), clearance_of_contacts(found)
    here = np.flatnonzero(found["contact_node"].values == node).tolist()
    return [np.atleast_1d(gaps.isel(contact=number).squeeze().values) for number in here]


def _limit_of_model(found: xr.Dataset) -> float:
    """Return the largest radius at which the law of a contact holds, as far as that is known."""
    gaps = _clearances(found)
    in_si = units_in(found["extremum_radius"]) != "1"
    depths = [gap.max() for gap in gaps if in_si and gap.max() > 0.0]
    if "disc_radius" in found.variables:
        radius = float(np.max(found["disc_radius"].values)) * scale_of(found, "length")
        depths.append(SMALL_INDENTATION * radius)
    return max(float(gap.max()) for gap in gaps) + min(depths) if depths else math.inf


def _mark_beyond(
    ax: Axes, extrema: _Extrema, beyond: npt.NDArray[np.bool_], radius: xr.DataArray
) -> None:
    """Mark extrema beyond the model at the upper edge, and tell the largest."""
    if beyond.any():
        largest = f"{number(extrema.radius[beyond].max(), 3)} {unit_of(radius)}".rstrip()
        across = np.unique(extrema.across[beyond])
        draw_marks(ax, across, np.full(across.size, 0.985 * ax.get_ylim()[1]), "^", INK, size=3.4,
                   face="white", edge=0.7, label=f"beyond the model, up to {largest}",
                   level=3.2)  # fmt: skip


def _title(found: xr.Dataset, held: Mapping[str, float], words: str = "") -> str:
    """Return the node of a system, and the parameters that do not vary."""
    node = [] if is_of_disc(found) else [f"node {in_figure(str(found['node'].values))}"]
    told = SEPARATOR.join([*node, *([text_of(found, held)] if held else [])])
    return f"{in_lines(told)}\n{words}".strip()


def _extrema_of(found: xr.Dataset, over: xr.DataArray) -> _Extrema:
    """Return the extrema over a parameter."""
    found = own_rows(found)
    counts = found["extremum_count"]
    across, response = (
        np.repeat(place.transpose(*counts.dims).values.ravel(), counts.values.ravel())
        for place in xr.broadcast(over, found["response"], counts)[:2]
    )
    if over.name == "omega" and "extremum_speed" in found.variables:
        across = found["extremum_speed"].values / scale_of(found, "speed")
    # the extrema of an unresolved motion may not last
    free = _is_of(response, found["response"], FREE_KINDS)
    of_kind = {
        kind: _is_of(found["extremum_kind"].values, found["extremum_kind"], (kind,))
        for kind in EXTREMA
    }
    swinging = free & ~of_kind["constant"]
    groups = {
        words: (colour, of_kind[kind] & ~swinging) for kind, (words, colour) in EXTREMA.items()
    }
    groups[FREE] = (GREY, swinging)
    return _Extrema(across, found["extremum_radius"].values, groups)


def _is_of(
    numbers: Values, variable: xr.DataArray, kinds: tuple[str, ...]
) -> npt.NDArray[np.bool_]:
    """Return a mask of the flags that are of some kinds."""
    flags = flags_of(variable)
    return np.isin(numbers, [flags[kind] for kind in kinds if kind in flags])


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
    found = _checked(found, node, ("response", name))
    over, held = drawn_over("found", found)
    ways = found["direction"].values.ravel().tolist() if "direction" in found.variables else [0]
    with drawing(ax) as ax:
        places = found[over].copy(data=label_parameter(ax.xaxis, over, found))
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
        ax.set_title(_title(found, held, words))
        if ax.get_legend_handles_labels()[1]:
            legend_below(ax)  # points fill the axes
    return ax
