"""The figure of each kind of result: sweeps and whirls include the exact curve.

`figure_of` draws any result by the function that its row in `rotor_ida.results.dataset_kinds` names
as `drawn`: a public plot, or one of the ``draw_...`` below, which choose or join plots by what a
dataset has. Some functions also compute exact results for the same rotor and draw them.
"""

from __future__ import annotations

import inspect
import math
from collections.abc import Callable, Iterator, Sequence
from itertools import product
from typing import Any, cast

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from rotor_ida.checks import check_one_varies, check_panels
from rotor_ida.closed_forms import (
    clearance_curve,
    folds,
    hopf_points,
    response_curve,
    synchronous_response,
)
from rotor_ida.closed_forms.unbalance_response import response_of_system
from rotor_ida.closed_forms.whirls.synchronous import whirls_of_system
from rotor_ida.errors import InputError
from rotor_ida.model.parameters import FRICTIONLESS
from rotor_ida.model.scales import IS_OF_MACHINE
from rotor_ida.model.system_parameters import SPEED, with_parameters
from rotor_ida.plot.appearance import mixed_panels, panels, style
from rotor_ida.plot.basins import (
    plot_attractor_fractions,
    plot_attractor_map,
    plot_attractors,
    plot_basin_fractions,
)
from rotor_ida.plot.branches import plot_curves
from rotor_ida.plot.datasets import axis_of, is_of_disc, parameters_in, touching_nodes, varied_in
from rotor_ida.plot.diagrams import plot_extrema
from rotor_ida.plot.labels import SEPARATOR, wrapped
from rotor_ida.plot.legends import shared_legend
from rotor_ida.plot.responses import plot_amplitude, plot_unbalance_response
from rotor_ida.plot.run_up import has_many_turns, plot_run_up
from rotor_ida.plot.runs import plot_run
from rotor_ida.plot.signals.orbits import plot_orbit
from rotor_ida.plot.signals.orders import plot_bode
from rotor_ida.results.archived_system import system_of
from rotor_ida.results.concat import concat
from rotor_ida.results.dataset_kinds import KINDS, kind_of, loaded, why_not
from rotor_ida.results.growth_words import grows_at
from rotor_ida.results.si_units import dimensionless, in_units_of
from rotor_ida.schema import STABILITY, labelled
from rotor_ida.signals.record import Record, record_of

# Largest number of speeds of a table of whirls that are marked.
FEW_SPEEDS = 30
# Number of clearances at which folds of the whirl are shown beside those of cycles.
CLEARANCES = 41
# Number of values of a parameter at which whirls are shown: of a disc, and of a system over its
# speed at least, and over another one.
ALONG, FEWEST_SPEEDS, VALUES = 401, 500, 80
# Folds and Hopf points are shown over these speeds, or to a margin past the last of them.
MARKED, USUAL, MARGIN = ("fold_omega", "hopf_omega"), (0.05, 3.0), 1.2
# Fewest revolutions of a Bode plot, samples between which speeds are compared, and the part by
# which the speed of a machine may change that does not run up.
FEW_TURNS, SPEEDS, WANDERS = 16, 17, 0.1
# Margin beside the speeds of a bifurcation diagram, by their range.
BESIDE = 0.03
# What exact whirls over another parameter than the speed keep.
WHIRLS_ALONG = ("amplitude", "stability", "in_contact")


def figure_of(dataset: xr.Dataset, *, node: str | None = None) -> Figure:
    """Draw the figure of any result, measured signals included.

    A result of a rotor system has a panel for each contact, or each node with one, where its
    picture shows one of them.

    Parameters
    ----------
    dataset : Dataset
        A result; its kind decides on the figure. Sweeps and whirls are drawn with the exact curve.
    node : str, optional
        The node of a rotor system that is drawn alone.

    Returns
    -------
    Figure
        The figure.

    Raises
    ------
    InputError
        If results of this kind have no figure, or none of a node.

    Examples
    --------
    >>> from rotor_ida import Rotor, sweep
    >>> system = Rotor(omega=1.0, zeta=0.07, delta0=0.5).system()
    >>> [ax.get_title() for ax in figure_of(sweep(system, speed=[0.5, 1.0])).axes]
    ['contact 0 at disc']
    """
    kind = kind_of(dataset)
    drawn = KINDS[kind].drawn
    if not drawn:
        able = ", ".join(name for name, each in KINDS.items() if each.drawn)
        got = f"{kind!r}{why_not(dataset)}"
        raise InputError(f"figure must be of one of the kinds {able}, got {got}")
    draw = loaded(drawn)
    # A function with `ax` and `contact` or `node` draws one contact or node: it gets a panel each.
    takes = inspect.signature(draw).parameters
    of_system = not is_of_disc(dataset)
    if node is not None and "node" not in takes:
        raise InputError(f"node must be left out for results of the kind {kind!r}")
    if of_system and "contact" in takes and dataset.sizes.get("contact", 0) > 1:
        return in_panels(dataset.sizes["contact"], lambda at, ax: draw(dataset, contact=at, ax=ax))
    if of_system and node is None and {"node", "ax"} <= takes.keys():
        nodes = touching_nodes(dataset)
        return in_panels(len(nodes), lambda at, ax: draw(dataset, node=nodes[at], ax=ax))
    made: Axes | Figure = draw(dataset) if node is None else draw(dataset, node=node)
    return made if isinstance(made, Figure) else cast(Figure, made.figure)


def draw_run(run: xr.Dataset, *, node: str | None = None) -> Figure:
    """Return the figure of a run: over the speed if that changes, in bands if it is long."""
    as_bands = node is None and has_many_turns(run)
    return plot_run_up(run) if as_bands else plot_run(run, node=node)


def draw_responses(dataset: xr.Dataset) -> Figure:
    """Return the figure of whirls and settled responses over the exact whirls.

    There is a panel for each rotor and contact, over the speed or another parameter that varies.
    """
    if "special_speed" in dataset and "not_exact" in dataset.attrs:  # there are no branches
        low, high = dataset.attrs["limits"].tolist()
        speeds = np.linspace(low, high, FEWEST_SPEEDS)
        response = response_of_system(system_of(dataset), speeds)
        return cast(Figure, plot_unbalance_response(response, special=dataset).figure)
    if "node_major_axis" in dataset and not (dataset.sizes["contact"] and "branch" in dataset.dims):
        return cast(Figure, plot_unbalance_response(dataset).figure)
    over = axis_of(dataset)
    beside = [(part, _exact_beside(part, over)) for part in _parts(dataset, over)]
    contacts = dataset.sizes.get("contact", 1)

    def draw(number: int, ax: Axes | None) -> Axes:
        place, contact = divmod(number, contacts)
        part, exact = beside[place]
        return plot_amplitude(**exact, **_shown(part, over), contact=contact, ax=ax)

    return in_panels(contacts * len(beside), draw, shared=is_of_disc(dataset))


def _parts(dataset: xr.Dataset, over: str) -> Iterator[xr.Dataset]:
    """Yield the parts of a result with one value of each parameter but one."""
    names = [name for name in parameters_in(dataset) if name != over and dataset[name].ndim == 1]
    names = [name for name in names if name in dataset.dims]
    for places in product(*(range(dataset.sizes[name]) for name in names)):
        yield dataset.isel({name: [at] for name, at in zip(names, places, strict=True)})


def _shown(part: xr.Dataset, over: str) -> dict[str, xr.Dataset]:
    """Return what a part of a result is drawn as."""
    if "response" in part:
        return {"simulated": part}
    few = "branch" in part.dims and part.sizes.get(over, 0) <= FEW_SPEEDS
    return {"whirls": part} if few and is_of_disc(part) else {}


def _exact_beside(part: xr.Dataset, over: str) -> dict[str, xr.Dataset | None]:
    """Return the exact whirls for a part of a result, with the points that mark them."""
    if not is_of_disc(part):
        return {"exact": _whirls_of_system(part, over) if "response" in part else part}
    given = {name: part[name].item() for name in parameters_in(part) if name != over}
    under_load = over == "load" or given.get("load", 0.0) > 0.0
    if over != "omega":
        if over in {"contact_exponent", "disc_radius"}:
            return {"exact": None}
        ends = float(part[over].min()), float(part[over].max())
        if over == "delta0" and not under_load:
            return {"exact": in_units_of(clearance_curve(**given, limits=ends), part)}
        asked: dict[str, Any] = {**given, over: np.linspace(*ends, ALONG)}
        return {"exact": in_units_of(synchronous_response(**asked), part)}
    curve = response_curve(**given, limits=_limits_of(part))
    if under_load:
        return {"exact": in_units_of(curve, part) if curve.sizes["point"] else None}
    given.pop("load", None)
    found = {"exact": curve, "fold_points": folds(**given)}
    if given.get("friction") or given.get("contact_damping"):
        found["hopf_points"] = hopf_points(**given)
    return {name: in_units_of(each, part) for name, each in found.items()}


def _whirls_of_system(part: xr.Dataset, over: str) -> xr.Dataset | None:
    """Return the exact whirls of the system of a sweep; None where there are none."""
    names = [name for name in parameters_in(part) if name not in {SPEED, over}]
    try:
        system = system_of(part)
        system = with_parameters(system, {name: part[name].item() for name in names})
        values = part[over].values
        if over == SPEED:
            if values.size > 1:
                count = max(FEWEST_SPEEDS, values.size)
                values = np.linspace(values.min(), values.max(), count)
            response = response_of_system(system, values)
            return response if "amplitude" in response else _clear_whirl(response)
        found = []
        for value in np.linspace(values.min(), values.max(), VALUES).tolist():
            own = with_parameters(system, {over: value})
            whirls = whirls_of_system(own, part[SPEED].item())
            found.append(whirls[[*WHIRLS_ALONG]].isel(speed=0, drop=True).reset_coords(drop=True))
            found[-1] = found[-1].assign_coords({over: ((), value, part[over].attrs)})
        speed, nodes = part[SPEED].squeeze(drop=True), part["contact_node"]
        return concat(found, over).assign_coords({SPEED: speed, "contact_node": nodes})
    except InputError:  # no whirls over another parameter, or a part of a sweep
        return None


def _clear_whirl(response: xr.Dataset) -> xr.Dataset:
    """Return the response to unbalance up to the touch, as the only branch of whirls."""
    radius = response["unbalance_radius"]
    is_free = (radius <= response["clearance"]).all("contact")
    grows = grows_at(response.attrs, response["speed"].values)
    stability = np.where(grows, STABILITY["unstable"], STABILITY["stable"])
    stability = np.where(is_free, stability, STABILITY["absent"]).astype(np.int8)
    return response.assign({
        "amplitude": radius.where(is_free).expand_dims(branch=1).assign_attrs(radius.attrs),
        "stability": labelled("stability", ("speed",), stability),
    })  # fmt: skip


def draw_diagram(dataset: xr.Dataset) -> Axes:
    """Draw a bifurcation diagram of one disc over one parameter; over speeds on the exact curve."""
    varied = varied_in(dataset)
    check_one_varies([IS_OF_MACHINE.get(each, each) if "length_scale" in dataset.attrs else each
                      for each in varied])  # fmt: skip
    exact: dict[str, Any] = {}
    if varied in ([], ["omega"]):
        exact = _exact_beside(dataset, "omega")
    exact.pop("hopf_points", None)
    ax = plot_extrema(dataset, **exact)
    if varied == ["omega"]:
        lowest, highest = float(dataset["omega"].min()), float(dataset["omega"].max())
        room = BESIDE * (highest - lowest)
        ax.set_xlim(lowest - room, highest + room)
    return ax


def draw_signals(dataset: xr.Dataset) -> Figure:
    """Return the figure of signals: a Bode plot while the speed changes, else the orbit."""
    of_run_up = plot_suiting(dataset) == "bode"
    return plot_bode(dataset) if of_run_up else cast(Figure, plot_orbit(dataset).figure)


def plot_suiting(dataset: xr.Dataset) -> str:
    """Return which plot suits signals: ``bode`` while the speed changes, else ``orbit``."""
    return "bode" if _is_run_up(record_of(dataset)) else "orbit"


def _is_run_up(record: Record) -> bool:
    """Return whether the speed of signals changes over revolutions enough for a curve."""
    angles = record.angles
    if angles is None or angles[-1] - angles[0] < FEW_TURNS * 2.0 * math.pi:
        return False
    parts = np.linspace(0, angles.size - 1, min(SPEEDS, angles.size)).astype(int)
    speeds = np.diff(angles[parts]) / np.diff(record.times[parts])
    return bool(np.ptp(speeds) > WANDERS * speeds.max())


def draw_atlas(dataset: xr.Dataset) -> Axes:
    """Draw an atlas: fractions over one parameter, or a map over two."""
    one = len(varied_in(dataset)) == 1
    return plot_attractors(dataset) if one else plot_attractor_map(dataset)


def draw_fractions(dataset: xr.Dataset) -> Axes:
    """Draw basin fractions: by attractor, or over the speed by kind."""
    several = "omega" in dataset.variables and dataset["omega"].size > 1
    return plot_basin_fractions(dataset) if several else plot_attractor_fractions(dataset)


def draw_curve(dataset: xr.Dataset) -> Axes:
    """Draw a bifurcation curve, beside the folds of the whirl."""
    return plot_curves(dataset, fold_points=_whirls_beside(dataset))


def _whirls_beside(curve: xr.Dataset) -> xr.Dataset | None:
    """Return the folds of the whirl within the limits of a curve over speed and clearance."""
    limits = np.reshape(dimensionless(curve).attrs["limits"], (2, 2))
    of = dict(zip(str(curve.attrs["parameters"]).split(), limits.tolist(), strict=True))
    beyond = any(name in curve.variables for name in FRICTIONLESS)
    if beyond or set(of) != {"omega", "delta0"}:
        return None
    delta0, (low, high) = curve["delta0"].values, of["omega"]
    clearances = np.unique(np.linspace(delta0.min(), delta0.max(), CLEARANCES))
    whirls = folds(zeta=curve["zeta"].item(), delta0=clearances)
    within = (whirls["fold_omega"] >= low) & (whirls["fold_omega"] <= high)
    return whirls.where(within) if within.any() else None


def _limits_of(part: xr.Dataset) -> tuple[float, float]:
    """Return the range of speeds to draw, widened round one or two speeds or marked points."""
    if "omega" not in part.variables:
        marks = np.concatenate([part[name].values.ravel() for name in MARKED if name in part])
        return USUAL[0], max(USUAL[1], MARGIN * float(np.nan_to_num(marks).max(initial=0.0)))
    lowest, highest = float(part["omega"].min()), float(part["omega"].max())
    if part["omega"].size < 3:
        lowest, highest = 0.5 * lowest, 1.2 * highest
    return lowest, highest or 1.0


def in_panels(
    count: int, draw: Callable[[int, Axes | None], Axes], *, shared: bool = False
) -> Figure:
    """Draw panels with one legend, perhaps of the same axes; a single one has its own figure."""
    if check_panels(count) < 2:
        return cast(Figure, draw(0, None).figure)
    columns = math.ceil(math.sqrt(count))
    rows = math.ceil(count / columns)
    arrange = panels if shared else mixed_panels
    figure, axes = arrange(rows, columns, width=2.0 + 2.8 * columns, height=1.6 + 2.2 * rows)
    for number, ax in enumerate(axes[:count]):
        draw(number, ax)
    for ax in axes[count:]:
        ax.remove()
    words = axes[0].get_xlabel()
    _share_title(figure, axes[:count])
    shared_legend(figure, axes[:count], outer=shared)
    for ax in axes[max(0, count - columns) : count] if shared else ():
        ax.tick_params(labelbottom=True)
        ax.set_xlabel(words)
    return figure


def _share_title(figure: Figure, axes: Sequence[Axes]) -> None:
    """Put what the titles of all panels say above the figure, and leave the rest to each."""
    titles = [ax.get_title().replace("\n", SEPARATOR).split(SEPARATOR) for ax in axes]
    common = [part for part in titles[0] if part and all(part in other for other in titles)]
    if common:
        with style():
            figure.suptitle(wrapped(common), fontsize=10.0)
            for ax, parts in zip(axes, titles, strict=True):
                ax.set_title(SEPARATOR.join(part for part in parts if part not in common))
