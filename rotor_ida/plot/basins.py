"""Plots of basins of attraction on a plane of starts, and of basin fractions."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Iterable, Sequence
from itertools import cycle

import numpy as np
import xarray as xr
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.colors import BoundaryNorm, ListedColormap, LogNorm
from matplotlib.patches import Patch

from rotor_ida.arrays import Values
from rotor_ida.checks import COMPONENTS, check_choice
from rotor_ida.errors import InputError
from rotor_ida.model.contact import HERTZ_EXPONENT, contact_force
from rotor_ida.model.parameters import PARAMETERS
from rotor_ida.model.system_parameters import SPEED
from rotor_ida.plot import palette
from rotor_ida.plot.appearance import circle, draw_ring, drawing
from rotor_ida.plot.datasets import (
    check_dataset,
    clearance_of,
    is_of_disc,
    parameters_in,
    table_of,
    units_in,
)
from rotor_ida.plot.labels import (
    KIND_WORDS,
    LABELS,
    SEPARATOR,
    label_axis,
    label_of,
    label_parameter,
    lengths_text,
    number_text,
    title_of,
    unit_of,
)
from rotor_ida.plot.legends import legend_below
from rotor_ida.results.si_units import dimensionless, is_in_si, scale_of
from rotor_ida.schema import FATE, QUANTITIES, RESPONSE, flags_of, words_of
from rotor_ida.units import read_in

NEEDED = ("label", "kind", "amplitude", "radius_min", "radius_max", "count")
OF_CONTACTS = ("speed", "contact_node", "contact_stator", "clearance", "centre_x", "centre_y")
UNDECIDED, NOT_COMPUTED = palette.INK, "white"
NOTHING_ELSE = "#d5e8d4"
FATE_WORDS = {"undecided": "undecided", "not_computed": "not computed"}
CONSTANT_RADIUS = 1e-3
MOST_IN_A_COLUMN = 6
ROUNDING = 1e-9
SHARE = "fraction of starts"


def plot_basin(dataset: xr.Dataset, *, ax: Axes | None = None) -> Axes:
    """Draw basins of attraction.

    The legend names the attractors that starts end on: the kind, with the amplitude or the range of
    the radius. Of a rotor system these are at the contact of the node whose starts are drawn, or
    at the contact that takes most of its clearance. Clearance circles are drawn on the plane of x
    and y, those of the node where it touches the ground.

    Parameters
    ----------
    dataset : Dataset
        Result of `rotor_ida.basin`.
    ax : Axes, optional
        Axes to draw on and return; default: those of a new figure.

    Raises
    ------
    InputError
        If the dataset is no basin, or has fewer than two starts in a direction.

    Examples
    --------
    >>> import numpy as np
    >>> from rotor_ida import Rotor, basin
    >>> axis = np.linspace(-15.0, 15.0, 16)
    >>> ax = plot_basin(basin(Rotor(omega=1.7, zeta=0.07, delta0=0.0), x=axis, y=axis))
    >>> [text.get_text() for text in ax.get_legend().get_texts()]
    ['synchronous response, $A = 1.88$', 'synchronous response, $A = 9.49$']
    """
    dataset = check_dataset("dataset", dataset, NEEDED, OF_CONTACTS)
    horizontal, vertical = _directions(dataset["label"])
    label = dataset["label"]
    count = dataset.sizes["attractor"]
    colours = [NOT_COMPUTED, UNDECIDED, *_shades(dataset["kind"])]
    with drawing(ax, width=4.6, height=5.2) as ax:
        label_axis(ax.xaxis, horizontal, dataset[horizontal])
        label_axis(ax.yaxis, vertical, dataset[vertical])
        ax.grid(visible=False)
        ax.pcolormesh(
            dataset[horizontal].values, dataset[vertical].values,
            label.transpose(vertical, horizontal).values, cmap=ListedColormap(colours),
            norm=BoundaryNorm(np.arange(FATE["not_computed"], count + 1) - 0.5, len(colours)),
            shading="nearest", rasterized=True,
        )  # fmt: skip
        if QUANTITIES[horizontal].scale == QUANTITIES[vertical].scale:
            ax.set_aspect("equal")
        else:
            ax.set_box_aspect(1.0)
        if (horizontal, vertical) == ("x", "y"):
            _draw_rings(ax, dataset)
        ax.set_title(_title(dataset))
        handles = _handles(_at_one_contact(dataset), colours)
        handles += ax.get_legend_handles_labels()[0][:1]
        legend_below(ax, columns=1 + (len(handles) > MOST_IN_A_COLUMN), handles=handles)
    return ax


def plot_basin_fractions(dataset: xr.Dataset, *, ax: Axes | None = None) -> Axes:
    """Draw the fractions of starts by kind of response over the speed, stacked.

    Parameters
    ----------
    dataset : Dataset
        Result of `rotor_ida.basin_fractions`, joined along ``omega``, for one ``zeta`` and one
        ``delta0``.
    ax : Axes, optional
        Axes to draw on and return; default: those of a new figure.

    Examples
    --------
    >>> found = xr.Dataset(
    ...     {"response_fraction": (("omega", "response"), [[1.0, 0.0], [0.25, 0.75]])},
    ...     {"omega": [1.0, 2.0], "response": [2, 3], "zeta": 0.07, "delta0": 0.5})
    >>> plot_basin_fractions(found).get_ylabel()
    'fraction of starts'
    """
    check_dataset("dataset", dataset, ("omega", "zeta", "delta0", "response", "response_fraction"))
    table = table_of("dataset", dataset, "response_fraction", ("omega", "response"))
    if table.sizes["omega"] < 2:
        raise InputError(
            "dataset must contain at least 2 omega, got 1: plot_attractor_fractions draws one rotor"
        )
    numbers = table["response"].values
    shares = [
        (table.values[:, numbers == RESPONSE[kind]].sum(axis=1), colour, KIND_WORDS[kind])
        for kind, (colour, *_) in palette.KIND_SHADES.items()
    ]
    alone = ax is None
    with drawing(ax) as ax:
        _draw_shares(ax, label_parameter(ax.xaxis, "omega", dataset), shares)
        ax.set_title(title_of("dataset", dataset, ("zeta", "delta0")))
        if alone:
            legend_below(ax)
    return ax


def plot_attractor_fractions(dataset: xr.Dataset, *, ax: Axes | None = None) -> Axes:
    """Draw the fractions of starts that end on each attractor of one rotor, with their errors.

    Parameters
    ----------
    dataset : Dataset
        Result of `rotor_ida.basin_fractions`.
    ax : Axes, optional
        Axes to draw on and return; default: those of a new figure.

    Examples
    --------
    >>> from rotor_ida import Rotor, basin_fractions
    >>> found = basin_fractions(Rotor(omega=1.7, zeta=0.07, delta0=0.0), x=(-15, 15), y=(-15, 15),
    ...                         starts=50)
    >>> [text.get_text() for text in plot_attractor_fractions(found).get_yticklabels()]
    ['synchronous response, $A = 1.88$', 'synchronous response, $A = 9.49$']
    """
    needed = ("kind", "fraction", "fraction_error", "amplitude", "radius_min", "radius_max")
    dataset = _at_one_contact(check_dataset("dataset", dataset, needed, OF_CONTACTS))
    for name in needed:
        table_of("dataset", dataset, name, ("attractor",))
    shares = dataset["fraction"].values
    shades = _shades(dataset["kind"])
    names = [_name(dataset.isel(attractor=number)) for number in range(shares.size)]
    errors = dataset["fraction_error"].values.tolist()
    rows = [*zip(names, shares.tolist(), errors, shades, strict=True)]
    rest = 1.0 - float(shares.sum())
    if rest > ROUNDING:
        rows.append((FATE_WORDS["undecided"], rest, 0.0, UNDECIDED))
    rows.sort(key=lambda row: row[1])
    with drawing(ax, width=6.4, height=1.4 + 0.3 * len(rows)) as ax:
        for place, (_, share, error, colour) in enumerate(rows):
            ax.barh(place, share, xerr=error or None, color=colour, height=0.7,
                    error_kw={"lw": 0.9, "capsize": 2.5, "ecolor": palette.INK})  # fmt: skip
        ax.set_yticks(range(len(rows)), [name for name, *_ in rows])
        ax.grid(visible=False, axis="y")
        ax.set_xlim(0.0, 1.0)
        ax.set_xlabel(SHARE)
        ax.set_title(_title(dataset))
    return ax


def plot_attractors(dataset: xr.Dataset, *, ax: Axes | None = None) -> Axes:
    """Draw the fractions of starts by attractor over a parameter, stacked.

    Attractors of one kind of response have shades of one colour, and are numbered in the legend;
    where there are more of a kind than shades, the last shade is that of all others.

    Parameters
    ----------
    dataset : Dataset
        Result of `rotor_ida.continue_attractors`, over one parameter.
    ax : Axes, optional
        Axes to draw on and return; default: those of a new figure.

    Raises
    ------
    InputError
        If the dataset is no such result, or not over exactly one parameter.

    Examples
    --------
    >>> import numpy as np
    >>> from rotor_ida import continue_attractors
    >>> found = continue_attractors(omega=np.linspace(1.6, 1.8, 3), zeta=0.07, delta0=0.0,
    ...                             x=(-15, 15), y=(-15, 15), starts=50)
    >>> plot_attractors(found).get_ylabel()
    'fraction of starts'
    """
    dataset = check_dataset("dataset", dataset, ("attractor", "fraction", "kind"), (SPEED,))
    varying, line = _varying_part(dataset, 1, "one parameter to be drawn")
    (name,) = varying
    shares = _shares_by_attractor(line)
    alone = ax is None
    with drawing(ax) as ax:
        places = label_parameter(ax.xaxis, name, dataset)
        top = _draw_shares(ax, places, shares)
        if (top < 1.0 - ROUNDING).any():
            ax.fill_between(places, top, 1.0, color=UNDECIDED, lw=0.0, label="undecided")
        ax.set_title(_title(line, varying))
        if alone:
            legend_below(ax)
    return ax


def _shares_by_attractor(line: xr.Dataset) -> list[tuple[Values, str, str]]:
    """Return the fraction of each attractor along a line, with its shade and its name."""
    found: dict[str, list[Values]] = {}
    for number in range(line.sizes["attractor"]):
        own = line.isel(attractor=number)
        here = np.isfinite(own["fraction"].values)
        if here.any():
            kind, _ = Counter(words_of(own["kind"][here])).most_common(1)[0]
            found.setdefault(kind, []).append(np.nan_to_num(own["fraction"].values))
    shares = []
    for kind, members in found.items():
        shades, words = palette.KIND_SHADES[kind], KIND_WORDS[kind]
        for number, share in enumerate(members):
            last = min(number, len(shades) - 1)
            is_shared = len(members) > len(shades) and last == len(shades) - 1
            others = " and others" if is_shared else ""
            name = f"{words} {last + 1}{others}" if len(members) > 1 else words
            shares.append((share, shades[last], name))
    return shares


def plot_attractor_map(dataset: xr.Dataset, *, by: str = "kind", ax: Axes | None = None) -> Axes:
    r"""Draw the most frequent response over two parameters, or its force or robustness.

    Parameters
    ----------
    dataset : Dataset
        Result of `rotor_ida.continue_attractors`, over two parameters.
    by : {"kind", "force", "shock"}
        Coloured quantity: the most frequent kind of response, with a legend; or a property of its
        most frequent attractor, with a colour bar: the largest contact force, or the smallest
        change of velocity that moves the rotor to another attractor.
    ax : Axes, optional
        Axes to draw on and return; default: those of a new figure.

    Raises
    ------
    InputError
        If the dataset is no such result, or not over exactly two parameters.

    Examples
    --------
    >>> from rotor_ida import continue_attractors
    >>> found = continue_attractors(omega=[1.6, 1.8], zeta=0.07, delta0=[0.0, 0.5],
    ...                             x=(-15, 15), y=(-15, 15), starts=20)
    >>> plot_attractor_map(found).get_ylabel()
    'clearance $\\delta_0$'
    """
    needed = ("attractor", "fraction", "kind", "radius_max")
    dataset = check_dataset("dataset", dataset, needed, (SPEED,))
    check_choice("by", by, ("kind", "force", "shock"))
    if by == "shock" and "velocity_shock" not in dataset:
        raise InputError("dataset must have been computed with shocks to be mapped by them")
    varying, plane = _varying_part(dataset, 2, "two parameters to be mapped")
    right, upwards = varying
    alone = ax is None
    with drawing(ax, width=5.0, height=4.4) as ax:
        ax.grid(visible=False)
        places = (
            label_parameter(ax.xaxis, right, dataset), label_parameter(ax.yaxis, upwards, dataset)
        )  # fmt: skip
        if by == "kind":
            _colour_by_kind(ax, places, plane)
        else:
            _colour_by_number(ax, places, plane, by)
        ax.set_title(_title(plane, varying))
        if alone and ax.get_legend_handles_labels()[1]:
            legend_below(ax)
    return ax


def _draw_shares(ax: Axes, places: Values, shares: Iterable[tuple[Values, str, str]]) -> Values:
    """Draw stacked fractions of starts; return their upper edges."""
    base, named = np.zeros(places.size), set[str]()
    for share, colour, words in shares:
        if share.any():
            ax.fill_between(places, base, base + share, facecolor=colour, edgecolor="white",
                            lw=0.3, label=None if words in named else words)  # fmt: skip
            named.add(words)
        base = base + share
    ax.set_xlim(float(places.min()), float(places.max()))
    ax.set_ylim(0.0, 1.0)
    ax.set_ylabel(SHARE)
    return base


def _varying_part(dataset: xr.Dataset, number: int, what: str) -> tuple[list[str], xr.Dataset]:
    """Return the varying parameters, and a dataset over these in reverse order."""
    names = parameters_in(dataset)
    varying = [name for name in names if dataset[name].size > 1]
    if len(varying) != number:
        raise InputError(f"dataset must be over {what}, got {len(varying)}")
    fixed = {name: 0 for name in names if name not in varying}
    part = dataset.isel(fixed, missing_dims="ignore")
    return varying, part.transpose(*reversed(varying), ..., "attractor")


def _colour_by_kind(ax: Axes, places: tuple[Values, Values], plane: xr.Dataset) -> None:
    """Colour a plane by the most frequent kind of response."""
    flags = flags_of(plane["kind"])
    shares = [
        plane["fraction"].where(plane["kind"] == flags[kind], 0.0).sum("attractor").values
        for kind in palette.KIND_SHADES
    ]
    numbers = np.argmax(shares, axis=0)
    shades = [family[0] for family in palette.KIND_SHADES.values()]
    ax.pcolormesh(
        *places, numbers, cmap=ListedColormap(shades), vmin=-0.5, vmax=len(shades) - 0.5,
        shading="nearest", rasterized=True,
    )  # fmt: skip
    for number, (kind, shade) in enumerate(zip(palette.KIND_SHADES, shades, strict=True)):
        if (numbers == number).any():
            ax.fill_between([], [], color=shade, lw=0.0, label=KIND_WORDS[kind])


def _colour_by_number(ax: Axes, places: tuple[Values, Values], plane: xr.Dataset, by: str) -> None:
    """Colour a plane by the force or the smallest shock of the most frequent attractor."""
    likeliest = plane.isel(attractor=plane["fraction"].fillna(-1.0).argmax("attractor"))
    if by == "force":
        shown, words = _largest_force(likeliest), "largest contact force"
    else:
        shown = likeliest["velocity_shock"].min("target", keep_attrs=True)
        words = "smallest change of velocity that leaves it"
    values = shown.values
    known = np.isfinite(values)
    if not known.all():
        ax.set_facecolor(NOTHING_ELSE)
        ax.fill_between([], [], color=NOTHING_ELSE, lw=0.0, label="no shock was found")
    mesh = ax.pcolormesh(
        *places, values, cmap="Greys" if by == "force" else "Greys_r",
        norm=LogNorm() if by == "shock" and known.any() else None, shading="nearest",
        rasterized=True,
    )  # fmt: skip
    if known.any():
        ax.figure.colorbar(mesh, ax=ax, label=label_of(by, shown, words=words))


def _largest_force(attractors: xr.Dataset) -> xr.DataArray:
    """Return the largest contact force of attractors; 0 where there is none."""
    if "largest_force" in attractors:  # of each contact of a rotor system
        return attractors["largest_force"].max("contact", keep_attrs=True).fillna(0.0)
    plain = dimensionless(attractors)
    exponent = float(plain.get("contact_exponent", HERTZ_EXPONENT))
    force = np.nan_to_num(contact_force(plain["radius_max"], plain["delta0"], exponent))
    force = force * scale_of(attractors, "force")
    unit, parts = read_in("N", [force.max()]) if is_in_si(attractors) else ("1", 1.0)
    return xr.DataArray(force / parts, attrs={"units": unit})


def _directions(label: xr.DataArray) -> tuple[str, str]:
    """Return the horizontal and the vertical coordinate."""
    if label.ndim != 2 or min(label.shape) < 2:
        sizes = dict(label.sizes)
        raise InputError(f"dataset must contain at least 2 x 2 starts to be drawn, got {sizes}")
    horizontal, vertical = (name for name in COMPONENTS if name in label.dims)
    return horizontal, vertical


def _at_one_contact(dataset: xr.Dataset) -> xr.Dataset:
    """Return the attractors of a rotor system at one contact: that of the node, or the closest."""
    if "contact" not in dataset.dims:
        return dataset
    own = dataset["contact_node"].values == dataset.attrs.get("knocked_node")
    share = (dataset["radius_max"] / dataset["clearance"]).max("attractor").fillna(0.0).values
    return dataset.isel(contact=int(np.argmax(np.where(own, np.inf, share))))


def _rings(dataset: xr.Dataset) -> list[tuple[float, complex]]:
    """Return clearance and centre of each circle about a node that its stator does not move."""
    if "contact" not in dataset.dims:
        return [(clearance_of(dataset, "dataset"), 0j)]
    own = dataset["contact_node"].values == dataset.attrs.get("knocked_node")
    on_ground = dataset.isel(contact=own & (dataset["contact_stator"].values == ""))
    columns = (on_ground[name].values for name in ("clearance", "centre_x", "centre_y"))
    return [(clearance, complex(x, y)) for clearance, x, y in zip(*columns, strict=True)]


def _draw_rings(ax: Axes, dataset: xr.Dataset) -> None:
    """Draw the clearance circles that cross the plane of starts."""
    (left, right), (bottom, top) = limits = ax.get_xlim(), ax.get_ylim()
    for clearance, centre in _rings(dataset):
        x, y = circle(clearance)
        x, y = x + centre.real, y + centre.imag
        if ((left <= x) & (x <= right) & (bottom <= y) & (y <= top)).any():
            draw_ring(ax, clearance, centre)
    ax.set(xlim=limits[0], ylim=limits[1])


def _title(dataset: xr.Dataset, varying: Sequence[str] = ()) -> str:
    """Return what does not vary, of a system node and speed, and the fixed start, as a title."""
    if not is_of_disc(dataset):
        node = dataset.attrs.get("knocked_node", "")
        dataset = dataset.drop_dims("node", errors="ignore").assign_coords(node=node)
    held = [name for name in PARAMETERS if name not in varying]
    words = [title_of("dataset", dataset, held)]
    for name in COMPONENTS:
        if name in dataset.coords and dataset[name].ndim == 0 and float(dataset[name]) != 0.0:
            symbol = LABELS[name].partition(" ")[2]
            value = number_text(float(dataset[name]), "g")
            words.append(f"{symbol} $= {value}$ {unit_of(dataset[name])}".rstrip())
    return SEPARATOR.join(words)


def _shades(kinds: xr.DataArray) -> list[str]:
    """Return a colour for each attractor, from the family of its kind."""
    families = {kind: cycle(family) for kind, family in palette.KIND_SHADES.items()}
    return [next(families[kind]) for kind in words_of(kinds)]


def _handles(dataset: xr.Dataset, colours: list[str]) -> list[Artist]:
    """Return a patch for each attractor that a start ends on, then for unknown ends."""
    shift = -FATE["not_computed"]
    handles: list[Artist] = [
        Patch(facecolor=colours[number + shift], label=_name(dataset.isel(attractor=number)))
        for number in range(dataset.sizes["attractor"])
        if dataset["count"].values[number] > 0
    ]
    handles += [
        Patch(
            facecolor=colours[FATE[fate] + shift], edgecolor=palette.INK, linewidth=0.5, label=words
        )
        for fate, words in FATE_WORDS.items()
        if (dataset["label"] == FATE[fate]).any()
    ]
    return handles


def _name(attractor: xr.Dataset) -> str:
    """Return the kind of an attractor with its amplitude or range of the radius."""
    (word,) = words_of(attractor["kind"])
    kind = KIND_WORDS[word]
    if word == "touching":  # its kind implies its limit
        return kind
    unit = units_in(attractor["amplitude"])
    low, high = float(attractor["radius_min"]), float(attractor["radius_max"])
    amplitude = float(attractor["amplitude"])
    if math.isnan(high) or high - low <= CONSTANT_RADIUS * high:
        # a circle that does not turn at the spin speed, as dry whip, has another radius
        is_synchronous = not abs(amplitude - high) > CONSTANT_RADIUS * high
        symbol, size = ("A", amplitude) if is_synchronous else ("|z|", high)
        (said,), unit = lengths_text(unit, size)
        return f"{kind}, ${symbol} = {said}$ {unit}".rstrip()
    (least, most), unit = lengths_text(unit, low, high)
    if least == most:
        return f"{kind}, $|z| = {most}$ {unit}".rstrip()
    return f"{kind}, ${least} \\leq |z| \\leq {most}$ {unit}".rstrip()
