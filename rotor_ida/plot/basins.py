"""Basins: a plane of starts, one colour for each attractor, and fractions over a parameter."""

from __future__ import annotations

import math
from itertools import cycle

import numpy as np
import numpy.typing as npt
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.colors import BoundaryNorm, ListedColormap, LogNorm
from matplotlib.patches import Patch

from rotor_ida.arrays import Values
from rotor_ida.checks import COMPONENTS, check_choice
from rotor_ida.errors import InputError
from rotor_ida.model.table import ALL_PARAMETERS, PARAMETERS
from rotor_ida.plot.appearance import (
    INK,
    KIND_SHADES,
    axes_or_new,
    check_dataset,
    legend_below,
    lines_of,
    own_legend,
    style,
    title_of,
)
from rotor_ida.plot.labels import KIND_WORDS, LABELS, label_axis, number_text, unit_of
from rotor_ida.schema import FATE, QUANTITIES, RESPONSE, check_dimensionless, flags_of

NEEDED = (*PARAMETERS, "label", "kind", "amplitude", "radius_min", "radius_max", "count")
UNDECIDED, NOT_COMPUTED = INK, "white"
NOTHING_ELSE = "#d5e8d4"
FATE_WORDS = {"undecided": "undecided", "not_computed": "not computed"}
CONSTANT_RADIUS = 1e-3
MOST_IN_A_COLUMN = 6
ROUNDING = 1e-9


def plot_basin(dataset: xr.Dataset, ax: Axes | None = None) -> Axes:
    """Draw which start ends on which attractor.

    The legend names the attractors that starts end on, by kind, with their amplitude, or the range
    of the radius where that is not constant.

    Parameters
    ----------
    dataset : Dataset
        What `rotor_ida.basin` returned.
    ax : Axes, optional
        Where to draw, and what is returned; by default the axes of a new figure.

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
    dataset = check_dataset("dataset", dataset, NEEDED)
    horizontal, vertical = _directions(dataset["label"])
    label = dataset["label"]
    count = dataset.sizes["attractor"]
    colours = [NOT_COMPUTED, UNDECIDED, *_shades(dataset["kind"])]
    with style():
        ax = axes_or_new(ax, width=4.6, height=5.0)
        label_axis(ax.xaxis, horizontal, dataset[horizontal])
        label_axis(ax.yaxis, vertical, dataset[vertical])
        ax.grid(visible=False)
        ax.pcolormesh(
            dataset[horizontal].values,
            dataset[vertical].values,
            label.transpose(vertical, horizontal).values,
            cmap=ListedColormap(colours),
            norm=BoundaryNorm(np.arange(FATE["not_computed"], count + 1) - 0.5, len(colours)),
            shading="nearest",
            rasterized=True,
        )
        if QUANTITIES[horizontal].scale == QUANTITIES[vertical].scale:
            ax.set_aspect("equal")
        else:
            ax.set_box_aspect(1.0)
        ax.set_title(_title(dataset))
        handles = _handles(dataset, colours)
        legend_below(ax, columns=1 + (len(handles) > MOST_IN_A_COLUMN), handles=handles)
    return ax


def plot_basin_fractions(dataset: xr.Dataset, ax: Axes | None = None) -> Axes:
    """Draw the fractions of starts by kind of response over the speed, one upon the other.

    Parameters
    ----------
    dataset : Dataset
        What `rotor_ida.basin_fractions` returned, joined along ``omega``, for one ``zeta`` and one
        ``delta0``.
    ax : Axes, optional
        Where to draw, and what is returned; by default the axes of a new figure.

    Examples
    --------
    >>> found = xr.Dataset(
    ...     {"response_fraction": (("omega", "response"), [[1.0, 0.0], [0.25, 0.75]])},
    ...     {"omega": [1.0, 2.0], "response": [2, 3], "zeta": 0.07, "delta0": 0.5})
    >>> plot_basin_fractions(found).get_ylabel()
    'share of starts'
    """
    check_dataset("dataset", dataset, ("omega", "zeta", "delta0", "response", "response_fraction"))
    words = {number: kind for kind, number in RESPONSE.items()}
    table = dataset["response_fraction"].transpose("omega", "response")
    alone = ax is None
    with style():
        ax = axes_or_new(ax)
        base = np.zeros(table.sizes["omega"])
        for kind, (colour, *_) in KIND_SHADES.items():
            columns = [words[number] == kind for number in table["response"].values.tolist()]
            top = base + table.values[:, columns].sum(axis=1)
            if (top > base).any():
                ax.fill_between(
                    table["omega"].values, base, top, color=colour, lw=0.0,
                    label=KIND_WORDS[kind],
                )  # fmt: skip
            base = top
        ax.set_xlim(float(table["omega"].min()), float(table["omega"].max()))
        ax.set_ylim(0.0, 1.0)
        ax.set_xlabel(LABELS["omega"])
        ax.set_ylabel("share of starts")
        ax.set_title(title_of("dataset", dataset, ("zeta", "delta0")))
        if alone:
            own_legend(ax)
    return ax


def plot_attractor_fractions(dataset: xr.Dataset, ax: Axes | None = None) -> Axes:
    """Draw the fractions of starts that end on each attractor of one rotor, with their errors.

    Parameters
    ----------
    dataset : Dataset
        What `rotor_ida.basin_fractions` returned.
    ax : Axes, optional
        Where to draw, and what is returned; by default the axes of a new figure.

    Examples
    --------
    >>> from rotor_ida import Rotor, basin_fractions
    >>> found = basin_fractions(Rotor(omega=1.7, zeta=0.07, delta0=0.0), x=(-15, 15), y=(-15, 15),
    ...                         starts=50)
    >>> [text.get_text() for text in plot_attractor_fractions(found).get_yticklabels()]
    ['synchronous response, $A = 1.88$', 'synchronous response, $A = 9.49$']
    """
    needed = (*PARAMETERS, "kind", "fraction", "fraction_error", "amplitude", "radius_min",
              "radius_max")  # fmt: skip
    dataset = check_dataset("dataset", dataset, needed)
    shades, shares = _shades(dataset["kind"]), dataset["fraction"].values
    names = [_name(dataset.isel(attractor=number)) for number in range(shares.size)]
    errors = dataset["fraction_error"].values.tolist()
    rows = [*zip(names, shares.tolist(), errors, shades, strict=True)]
    lost = 1.0 - float(shares.sum())
    if lost > ROUNDING:
        rows.append((FATE_WORDS["undecided"], lost, 0.0, UNDECIDED))
    rows.sort(key=lambda row: row[1])
    with style():
        ax = axes_or_new(ax, width=6.4, height=1.4 + 0.3 * len(rows))
        for place, (_, share, error, colour) in enumerate(rows):
            ax.barh(place, share, xerr=error or None, color=colour, height=0.7,
                    error_kw={"lw": 0.9, "capsize": 2.5, "ecolor": INK})  # fmt: skip
        ax.set_yticks(range(len(rows)), [name for name, *_ in rows])
        ax.grid(visible=False, axis="y")
        ax.set_xlim(0.0, 1.0)
        ax.set_xlabel("share of starts")
        ax.set_title(lines_of("dataset", dataset))
    return ax


def plot_attractors(dataset: xr.Dataset, ax: Axes | None = None) -> Axes:
    """Draw the fractions of starts by attractor over a parameter, one upon the other.

    Attractors of one kind of response have shades of one colour; each keeps its own throughout. The
    legend names the kinds.

    Parameters
    ----------
    dataset : Dataset
        What `rotor_ida.continue_attractors` returned, over one parameter.
    ax : Axes, optional
        Where to draw, and what is returned; by default the axes of a new figure.

    Raises
    ------
    InputError
        If the dataset is no such result, or over more or less than one parameter.

    Examples
    --------
    >>> import numpy as np
    >>> from rotor_ida import continue_attractors
    >>> found = continue_attractors(omega=np.linspace(1.6, 1.8, 3), zeta=0.07, delta0=0.0,
    ...                             x=(-15, 15), y=(-15, 15), starts=50)
    >>> plot_attractors(found).get_ylabel()
    'share of starts'
    """
    check_dataset("dataset", dataset, (*PARAMETERS, "attractor", "fraction", "kind"))
    varying = _varying(dataset)
    if len(varying) != 1:
        raise InputError(f"dataset must be over one parameter to be drawn, got {len(varying)}")
    (name,) = varying
    fixed = {each: 0 for each in _parameters(dataset) if each != name}
    line = dataset.isel(fixed, missing_dims="ignore").transpose(name, ..., "attractor")
    words = {number: word for word, number in flags_of(dataset["kind"]).items()}
    families, named = {kind: cycle(family) for kind, family in KIND_SHADES.items()}, set[str]()
    alone = ax is None
    with style():
        ax = axes_or_new(ax)
        places, base = line[name].values, np.zeros(line.sizes[name])
        for number in range(line.sizes["attractor"]):
            own = line.isel(attractor=number)
            here = np.isfinite(own["fraction"].values)
            if not here.any():
                continue
            kind = words[int(np.bincount(own["kind"].values[here]).argmax())]
            top = base + np.nan_to_num(own["fraction"].values)
            ax.fill_between(
                places, base, top, facecolor=next(families[kind]), edgecolor="white", lw=0.3,
                label="_" if kind in named else KIND_WORDS[kind],
            )  # fmt: skip
            base = top
            named.add(kind)
        if (base < 1.0 - 1e-9).any():
            ax.fill_between(places, base, 1.0, color=UNDECIDED, lw=0.0, label="undecided")
        ax.set_xlim(float(places[0]), float(places[-1]))
        ax.set_ylim(0.0, 1.0)
        label_axis(ax.xaxis, name, dataset[name])
        ax.set_ylabel("share of starts")
        ax.set_title(title_of("dataset", line, tuple(fixed)))
        if alone:
            own_legend(ax)
    return ax


def plot_attractor_map(dataset: xr.Dataset, ax: Axes | None = None, *, by: str = "kind") -> Axes:
    r"""Draw over two parameters the likeliest response, or how hard it presses or how firm it is.

    Parameters
    ----------
    dataset : Dataset
        What `rotor_ida.continue_attractors` returned, over two parameters.
    ax : Axes, optional
        Where to draw, and what is returned; by default the axes of a new figure.
    by : {"kind", "force", "shock"}
        What is coloured: the kind of response that most starts end on, with a legend; or, of the
        attractor that most of them end on, with a colour bar, the largest contact force, or the
        smallest change of velocity that throws the rotor to another one.

    Raises
    ------
    InputError
        If the dataset is no such result, or over other than two parameters.

    Examples
    --------
    >>> from rotor_ida import continue_attractors
    >>> found = continue_attractors(omega=[1.6, 1.8], zeta=0.07, delta0=[0.0, 0.5],
    ...                             x=(-15, 15), y=(-15, 15), starts=20)
    >>> plot_attractor_map(found).get_ylabel()
    'clearance $\\delta_0$'
    """
    check_dataset("dataset", dataset, (*PARAMETERS, "attractor", "fraction", "kind", "radius_max"))
    check_choice("by", by, ("kind", "force", "shock"))
    if by == "shock" and "velocity_shock" not in dataset:
        raise InputError("dataset must have been made with shocks to be mapped by them")
    check_dimensionless("dataset", dataset)
    varying = _varying(dataset)
    if len(varying) != 2:
        raise InputError(f"dataset must be over two parameters to be mapped, got {len(varying)}")
    right, upwards = varying
    fixed = {name: 0 for name in _parameters(dataset) if name not in varying}
    plane = dataset.isel(fixed, missing_dims="ignore").transpose(upwards, right, ..., "attractor")
    places = plane[right].values, plane[upwards].values
    with style():
        ax = axes_or_new(ax, width=5.0, height=4.4)
        ax.grid(visible=False)
        if by == "kind":
            numbers, shades = _likeliest_kinds(plane)
            kinds = [kind for number, kind in enumerate(shades) if (numbers == number).any()]
            ax.pcolormesh(
                *places, numbers, cmap=ListedColormap(list(shades.values())), vmin=-0.5,
                vmax=len(shades) - 0.5, shading="nearest", rasterized=True,
            )  # fmt: skip
            for kind in kinds:
                ax.fill_between([], [], color=shades[kind], lw=0.0, label=KIND_WORDS[kind])
        else:
            _colour_by_number(ax, places, plane, by)
        label_axis(ax.xaxis, right, dataset[right])
        label_axis(ax.yaxis, upwards, dataset[upwards])
        ax.set_title(title_of("dataset", plane, tuple(fixed)))
    return ax


def _parameters(dataset: xr.Dataset) -> list[str]:
    """Return the parameters that an atlas has."""
    return [name for name in ALL_PARAMETERS if name in dataset.variables]


def _varying(dataset: xr.Dataset) -> list[str]:
    """Return those of them that it is over."""
    return [name for name in _parameters(dataset) if dataset[name].size > 1]


def _colour_by_number(ax: Axes, places: tuple[Values, Values], plane: xr.Dataset, by: str) -> None:
    """Colour a plane by the force or the smallest shock of the likeliest attractor."""
    if by == "force":
        values, label = _forces_of_likeliest(plane), "largest contact force"
    else:
        values, label = _shocks_of_likeliest(plane), "smallest change of velocity that ends it"
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
        ax.figure.colorbar(mesh, ax=ax, label=label)


def _likeliest_kinds(plane: xr.Dataset) -> tuple[npt.NDArray[np.int64], dict[str, str]]:
    """Return the number of the likeliest kind at each place, and the colours of all kinds."""
    flags, shades = flags_of(plane["kind"]), {kind: each[0] for kind, each in KIND_SHADES.items()}
    shares = [
        plane["fraction"].where(plane["kind"] == flags[kind], 0.0).sum("attractor").values
        for kind in shades
    ]
    numbers: npt.NDArray[np.int64] = np.argmax(shares, axis=0)
    return numbers, shades


def _shocks_of_likeliest(plane: xr.Dataset) -> Values:
    """Return the smallest shock that ends the likeliest attractor; NaN where none was found."""
    likeliest = plane["fraction"].fillna(-1.0).argmax("attractor")
    least = plane["velocity_shock"].min("target").isel(attractor=likeliest)
    values: Values = least.values
    return values


def _forces_of_likeliest(plane: xr.Dataset) -> Values:
    """Return the largest contact force of the likeliest attractor at each place; 0 without one."""
    likeliest = plane["fraction"].fillna(-1.0).argmax("attractor")
    depth = (plane["radius_max"] - plane["delta0"]).isel(attractor=likeliest)
    force: Values = (depth.fillna(0.0).clip(min=0.0) ** 1.5).transpose(*likeliest.dims).values
    return force


def _directions(label: xr.DataArray) -> tuple[str, str]:
    """Return what is drawn to the right and what upwards."""
    if label.ndim != 2 or min(label.shape) < 2:
        sizes = dict(label.sizes)
        raise InputError(f"dataset must hold at least 2 x 2 starts to be drawn, got {sizes}")
    horizontal, vertical = (str(dim) for dim in label.dims)
    return horizontal, vertical


def _title(dataset: xr.Dataset) -> str:
    """Return the parameters, and what the starts have besides their place in the plane."""
    words = [title_of("dataset", dataset)]
    for name in COMPONENTS:
        if name in dataset.coords and dataset[name].ndim == 0 and float(dataset[name]) != 0.0:
            symbol = LABELS[name].partition(" ")[2]
            value = number_text(float(dataset[name]), "g")
            words.append(f"{symbol} $= {value}$ {unit_of(dataset[name])}".rstrip())
    return ",  ".join(words)


def _shades(kinds: xr.DataArray) -> list[str]:
    """Return a colour for each attractor, from the family of its kind."""
    words = {number: word for word, number in flags_of(kinds).items()}
    families = {kind: cycle(family) for kind, family in KIND_SHADES.items()}
    return [next(families[words[number]]) for number in kinds.values.tolist()]


def _handles(dataset: xr.Dataset, colours: list[str]) -> list[Patch]:
    """Return a patch for each attractor that a start ends on, then for what is not known."""
    shift = -FATE["not_computed"]
    handles = [
        Patch(facecolor=colours[number + shift], label=_name(dataset.isel(attractor=number)))
        for number in range(dataset.sizes["attractor"])
        if dataset["count"].values[number] > 0
    ]
    handles += [
        Patch(facecolor=colours[FATE[fate] + shift], edgecolor=INK, linewidth=0.5, label=words)
        for fate, words in FATE_WORDS.items()
        if (dataset["label"] == FATE[fate]).any()
    ]
    return handles


def _name(attractor: xr.Dataset) -> str:
    """Return the kind of an attractor and its amplitude, or the radii between which it swings."""
    words = {number: word for word, number in flags_of(attractor["kind"]).items()}
    kind = KIND_WORDS[words[int(attractor["kind"])]]
    if words[int(attractor["kind"])] == "touching":  # what it tends to is told by its kind
        return kind
    unit = unit_of(attractor["amplitude"])
    low, high = float(attractor["radius_min"]), float(attractor["radius_max"])
    if math.isnan(high) or high - low <= CONSTANT_RADIUS * high:
        return f"{kind}, $A = {number_text(float(attractor['amplitude']))}$ {unit}".rstrip()
    low_text, high_text = number_text(low), number_text(high)
    return f"{kind}, ${low_text} \\leq |z| \\leq {high_text}$ {unit}".rstrip()
