"""Plots of bifurcation diagrams, Poincaré sections and Lyapunov exponents."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Literal, NamedTuple

import numpy as np
import numpy.typing as npt
import xarray as xr
from matplotlib.axes import Axes

from rotor_ida.arrays import ComplexValues, Values
from rotor_ida.checks import check_choice
from rotor_ida.errors import InputError
from rotor_ida.model.contact import SMALL_INDENTATION
from rotor_ida.model.parameters import OPTIONAL
from rotor_ida.plot import palette
from rotor_ida.plot.appearance import (
    LEAST_SPAN,
    draw_marks,
    draw_ring,
    drawing,
    say_in_middle,
    widen,
)
from rotor_ida.plot.datasets import (
    along_one,
    at_node,
    check_dataset,
    check_same_parameters,
    check_same_units,
    clearances_in,
    drawn_over,
    is_centred,
    is_of_disc,
    is_of_kind,
    one_value,
    rings_about,
    units_in,
)
from rotor_ida.plot.labels import (
    KIND_WORDS,
    SEPARATOR,
    label_axis,
    label_of,
    label_parameter,
    text_of,
    title_of,
)
from rotor_ida.plot.legends import legend_below, own_legend
from rotor_ida.plot.responses import below_outliers, mark_beyond, plot_amplitude
from rotor_ida.results.rows import own_rows
from rotor_ida.results.si_units import scale_of
from rotor_ida.schema import words_of
from rotor_ida.texts import in_figure
from rotor_ida.units import with_error

# Parts of a bifurcation diagram.
FREE = "extremum, free or unresolved"
FREE_KINDS = ("contact_free", "touching", "unresolved")
EXTREMA = {
    "constant": ("constant radius", palette.BLUE),
    "maximum": ("local maximum of $|z|$", palette.ORANGE),
    "minimum": ("local minimum of $|z|$", palette.PURPLE),
}
FEW_EXTREMA = 3000
# Top of the axes over the largest extremum.
HEADROOM = 1.06
WITH_EXTREMA = ("response", "extremum_count", "extremum_radius", "extremum_kind")
OF_SYSTEM = ("speed", "node", "contact_node")
# States once a revolution, by the direction of a sweep.
WAYS = {1: ("going up", palette.BLUE), -1: ("going down", palette.ORANGE)}
UNRESOLVED = "unresolved"
# Size of the points going up over that of those going down, which may lie on them.
BENEATH = 1.5
STATES = ("rotating_x", "rotating_y", "rotating_vx", "rotating_vy")
OF_SECTION = ("node", "contact_node", "contact_stator", "clearance", "centre_x", "centre_y")
OF_EXPONENTS = ("lyapunov_exponent", "lyapunov_error")
# Styles of the points of a section.
FEW = 20
WORDS = {
    "revolution": "once a revolution",
    "entry": "at each entry",
    "exit": "at each exit",
    "peak": "at each largest radius",
    "roll": "where it begins to roll",
    "slip": "where it begins to slip",
    "reverse": "where its sliding reverses",
}
# Styles of the exponents.
LINES = ((palette.BLUE, "-"), (palette.ORANGE, "--"), (palette.PURPLE, "-."), (palette.INK, ":"))


def plot_extrema(
    found: xr.Dataset, *, node: str | None = None, exact: xr.Dataset | None = None,
    fold_points: xr.Dataset | None = None, ax: Axes | None = None,
) -> Axes:  # fmt: skip
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
    found = at_node(check_dataset("found", found, WITH_EXTREMA, OF_SYSTEM), node)
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
            steady = words.startswith(EXTREMA["constant"][0])
            face = "none" if steady else colour
            ax.plot(
                extrema.across[chosen], extrema.radius[chosen], ls="", marker="o",
                ms=3.4 if steady else size, mec=colour if steady else "none", mfc=face, mew=0.7,
                rasterized=True, zorder=2.4 if words == FREE else 3.0,
            )  # fmt: skip
            draw_marks(ax, [], [], "o", colour, size=3.4, face=face, edge=0.7, label=words)
        for gap in gaps if exact is None else ():  # plot_amplitude has drawn it
            ax.plot(places, np.broadcast_to(gap, places.shape), color=palette.INK, lw=0.9,
                    ls=palette.DASHES, marker="" if places.size > 1 else "_", label="clearance",
                    zorder=2.3)  # fmt: skip
        highest = [extrema.radius[within].max(initial=0.0), *(gap.max() for gap in gaps)]
        highest += [] if exact is None else [min(float(exact["amplitude"].max()), limit)]
        ax.set_ylim(bottom=min(0.0, ax.get_ylim()[0]), top=HEADROOM * max(highest))
        mark_beyond(ax, extrema.across[~within], extrema.radius[~within],
                    found["extremum_radius"], "beyond the model", palette.INK)  # fmt: skip
        ax.set_title(_title(found, held))
        own_legend(ax)
    return ax


class _Extrema(NamedTuple):
    """The extrema of a diagram as flat arrays, and which are of each kind."""

    across: Values
    radius: Values
    groups: dict[str, tuple[str, npt.NDArray[np.bool_]]]


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
    gaps = clearances_in(found)
    if is_of_disc(found):
        return [np.asarray(gaps.values, float)]
    here = np.flatnonzero(found["contact_node"].values == str(found["node"].values)).tolist()
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


def _title(found: xr.Dataset, held: Mapping[str, float], words: str = "") -> str:
    """Return the node of a system, and the parameters that do not vary."""
    node = [] if is_of_disc(found) else [f"node {in_figure(str(found['node'].values))}"]
    told = SEPARATOR.join([*node, *([text_of(found, held)] if held else [])])
    return f"{told}\n{words}".strip()


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
    own = found["extremum_kind"].copy(data=response).assign_attrs(found["response"].attrs)
    of_kind = {kind: is_of_kind(found["extremum_kind"], [kind]).values for kind in EXTREMA}
    # the extrema of an unresolved motion may not last
    swinging = is_of_kind(own, FREE_KINDS).values & ~of_kind["constant"]
    groups = {}
    for kind, (words, colour) in EXTREMA.items():
        chosen = of_kind[kind] & ~swinging
        seen = ", ".join(KIND_WORDS[each] for each in dict.fromkeys(words_of(own[chosen])))
        groups[f"{words}: {seen}"] = colour, chosen
    groups[FREE] = (palette.GREY, swinging)
    return _Extrema(across, found["extremum_radius"].values, groups)


def plot_strobes(
    found: xr.Dataset, *, axis: Literal["x", "y"] = "x", node: str | None = None,
    ax: Axes | None = None,
) -> Axes:  # fmt: skip
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
    found = at_node(check_dataset("found", found, ("response", *STATES[:2]), OF_SYSTEM), node)
    over, held = drawn_over("found", found)
    ways = found["direction"].values.ravel().tolist() if "direction" in found.variables else []
    with drawing(ax) as ax:
        places = found[over].copy(data=label_parameter(ax.xaxis, over, found))
        places, values, response = xr.broadcast(places, found[name], found["response"])
        size = 2.6 if values.size < FEW_EXTREMA else 1.2
        unresolved = is_of_kind(response, [UNRESOLVED])
        groups = [(UNRESOLVED, palette.GREY, unresolved, size)]
        for way in ways if len(ways) > 1 else ():
            # what goes down lies on what goes up, and would hide it
            wide = BENEATH * size if way > 0 else size
            groups.append((*WAYS[way], (found["direction"] == way) & ~unresolved, wide))
        for kind, (shade, *_) in palette.KIND_SHADES.items() if len(ways) < 2 else ():
            groups.append((KIND_WORDS[kind], shade, is_of_kind(response, [kind]), size))
        for words, colour, of_group, width in groups:
            chosen = of_group.broadcast_like(response).transpose(*response.dims).values
            if chosen.any():
                ax.plot(places.values[chosen], values.values[chosen], ls="", marker="o",
                        ms=width, mec="none", mfc=colour, rasterized=True)  # fmt: skip
                draw_marks(ax, [], [], "o", colour, size=3.4, label=words)
        label_axis(ax.yaxis, name, found[name])
        x, y = (found[each].transpose(*values.dims, missing_dims="ignore") for each in STATES[:2])
        radius = np.hypot(x.values, y.values)
        reach = max((float(gap.max()) for gap in _clearances(found)), default=0.0)
        highest = below_outliers(reach, radius)
        beyond = radius > highest
        if beyond.any():
            ax.set_ylim(-HEADROOM * highest, HEADROOM * highest)
            mark_beyond(ax, places.values[beyond], radius[beyond], found[name], "radius",
                        palette.INK)  # fmt: skip
        phase = float(found.attrs.get("phase", 0.0))
        words = f"unbalance at {math.degrees(phase):.4g}°" if phase else "once a revolution"
        ax.set_title(_title(found, held, words))
        if ax.get_legend_handles_labels()[1]:
            legend_below(ax)  # points fill the axes
    return ax


def plot_section(section: xr.Dataset, *, node: str | None = None, ax: Axes | None = None) -> Axes:
    r"""Draw the points of a section.

    Parameters
    ----------
    section : Dataset
        Result of `rotor_ida.poincare_section`. Entries and exits all lie on the
        stator and are drawn as radial velocity over the angle from the unbalance. Other sections
        are drawn as displacements, with the stator.
    node : str, optional
        Name of a node of a rotor system; by default that of the contact whose events are shown, or
        of the first contact. Entries and exits of another node, or in a stator that is not centred
        and at rest, are drawn as displacements too.
    ax : Axes, optional
        Axes to draw on and return; default: those of a new figure.

    Examples
    --------
    >>> from rotor_ida import Rotor, poincare_section
    >>> rotor = Rotor(omega=1.7, zeta=0.07, delta0=0.5)
    >>> ax = plot_section(poincare_section(rotor, start=(0, 0, 0, 0), revolutions=9))
    >>> ax.get_title()
    '$\\omega = 1.7$,  $\\zeta = 0.07$,  $\\delta_0 = 0.5$\nonce a revolution'
    """
    section = check_dataset("section", section, (*STATES, "crossing_time"), OF_SECTION)
    section = at_node(section, node)
    at = str(section.attrs.get("section", ""))
    z = section["rotating_x"].values + 1j * section["rotating_y"].values
    with drawing(ax, width=4.0, height=4.0) as ax:
        if at in ("entry", "exit") and _is_on_ring(section):
            w = section["rotating_vx"].values + 1j * section["rotating_vy"].values
            across, up = _together(np.angle(z)), (w * z.conj()).real / np.abs(z)
            scales = (1.0, _order(section, "velocity", w))
            ax.set_xlabel(label_of("angle", section["rotating_x"].drop_attrs()))
            label_axis(ax.yaxis, "radial_velocity", section["rotating_vx"])
        else:
            across, up, scales = z.real, z.imag, (_order(section, "length", z),) * 2
            label_axis(ax.xaxis, "rotating_x", section["rotating_x"])
            label_axis(ax.yaxis, "rotating_y", section["rotating_y"])
            for clearance in rings_about("section", section):
                draw_ring(ax, clearance)
            ax.set_aspect("equal", adjustable="datalim")
        ax.plot(across, up, ls="", marker="o", ms=_mark_size(z), mec="none", mfc=palette.BLUE,
                zorder=3.0)  # fmt: skip
        limits = zip((ax.get_xlim(), ax.get_ylim()), scales, strict=True)
        widen(ax, *(LEAST_SPAN * max(order, *map(abs, ends)) for ends, order in limits))
        if not z.size:
            say_in_middle(ax, "no crossing")
        words = WORDS.get(at, "")
        if phase := float(section.attrs.get("phase", 0.0)):
            words = f"unbalance at {math.degrees(phase):.4g}°"
        ax.set_title(f"{title_of('section', section)}\n{words}{_counted(z)}".removesuffix("\n"))
    return ax


def _order(section: xr.Dataset, kind: str, values: ComplexValues) -> float:
    """Return what the points of a section are measured by: of a rotor system their own size."""
    if "node" in section.variables:
        return float(np.abs(values).max(initial=0.0))
    return scale_of(section, kind)


def _is_on_ring(section: xr.Dataset) -> bool:
    """Return whether the crossings of a section at entries lie on a ring about the axis."""
    if "node" not in section.variables:
        return True
    number = int(section.attrs.get("contact", 0))
    contact = section.isel(contact=number)
    is_own = str(contact["contact_node"].values) == str(section["node"].values)
    return is_own and bool(is_centred(section)[number])


def plot_exponents(found: xr.Dataset, *, ax: Axes | None = None) -> Axes:
    r"""Draw the convergence of the Lyapunov exponents over the averaging time, or their course.

    Of one motion the legend shows each exponent with the standard error of its last digits in
    brackets. Of several the exponents are drawn over the one parameter that varies, with errors.

    Parameters
    ----------
    found : Dataset
        Result of `rotor_ida.lyapunov_exponent`.
    ax : Axes, optional
        Axes to draw on and return; default: those of a new figure.

    Examples
    --------
    >>> from rotor_ida import Rotor, lyapunov_exponent
    >>> found = lyapunov_exponent(Rotor(omega=1.7, zeta=0.07, delta0=0.0), start=(0, 0, 0, 0),
    ...                           batches=4)
    >>> plot_exponents(found).get_legend_handles_labels()[1][0]
    '$\\lambda_1 = -0.07000$'
    """
    if isinstance(found, xr.Dataset) and "status" in found and "running_exponent" not in found:
        return _plot_exponents_over(check_dataset("found", found, ("exponent", *OF_EXPONENTS)), ax)
    found = check_dataset("found", found, ("t", "running_exponent", *OF_EXPONENTS))
    with drawing(ax) as ax:
        label_axis(ax.xaxis, "t", found["t"])
        label_axis(ax.yaxis, "running_exponent", found["running_exponent"])
        ax.axhline(0.0, color=palette.GREY, lw=0.7, zorder=1.5)
        for number, (colour, dashes) in enumerate(LINES[: found.sizes["exponent"]]):
            part = found.isel(exponent=number)
            value, error = part["lyapunov_exponent"].item(), part["lyapunov_error"].item()
            words = f"$\\lambda_{number + 1} = {with_error(value, error, most=5)}$"
            ax.plot(part["t"], part["running_exponent"], color=colour, ls=dashes, lw=1.1,
                    label=words)  # fmt: skip
        ax.set_xlim(0.0, float(found["t"].values[-1]))
        low, high = float(found["lyapunov_exponent"].min()), float(found["lyapunov_exponent"].max())
        room = max(high - low, abs(high), abs(low)) or 1.0
        # the first means have not converged and may lie outside
        ax.set_ylim(low - 0.3 * room, high + 0.3 * room)
        legend_below(ax, columns=2)
    return ax


def _plot_exponents_over(found: xr.Dataset, ax: Axes | None) -> Axes:
    """Draw exponents over the parameter that varies."""
    part, over = along_one("found", found)
    with drawing(ax) as ax:
        label_axis(ax.yaxis, "running_exponent", found["lyapunov_exponent"])
        places = label_parameter(ax.xaxis, over, part)
        ax.axhline(0.0, color=palette.GREY, lw=0.7, zorder=1.5)
        for number, (colour, dashes) in enumerate(LINES[: found.sizes["exponent"]]):
            own = part.isel(exponent=number)
            ax.errorbar(places, own["lyapunov_exponent"], own["lyapunov_error"],
                        color=colour, ls=dashes, lw=1.1, marker="o", ms=2.5, capsize=2.0,
                        label=f"$\\lambda_{number + 1}$")  # fmt: skip
        legend_below(ax, columns=4)
    return ax


def _together(angle: Values) -> Values:
    """Return angles within half a turn of their mean direction, so that no cluster is split."""
    mean = np.angle(np.exp(1j * angle).sum())
    return np.asarray(mean + np.angle(np.exp(1j * (angle - mean))))


def _distinct(z: npt.NDArray[np.complex128]) -> int:
    """Return the number of distinguishable points."""
    return int(np.unique(np.round(z / (np.abs(z).max(initial=0.0) or 1.0), 3)).size)


def _counted(z: npt.NDArray[np.complex128]) -> str:
    """Return the count of crossings and of distinct points, if these are few."""
    distinct = _distinct(z)
    if not 0 < distinct <= FEW or z.size <= 2 * distinct:
        return ""
    return f": {z.size} crossings, {distinct} point{'s' if distinct > 1 else ''}"


def _mark_size(z: npt.NDArray[np.complex128]) -> float:
    """Return the marker size for a number of distinguishable points."""
    distinct = _distinct(z)
    return 4.5 if distinct <= FEW else 3.0 if distinct <= 200 else 1.6
