"""Deflected shapes, eigenvalues over the speed, close clearances, and backward whirls."""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from rotor_ida.arrays import Values
from rotor_ida.checks import check_real
from rotor_ida.errors import InputError
from rotor_ida.model.parameters import PARAMETERS
from rotor_ida.model.system_parameters import SPEED
from rotor_ida.plot import palette
from rotor_ida.plot.appearance import (
    LEAST_SPAN,
    circle,
    draw_marks,
    draw_ring,
    drawing,
    new_figure,
    say_in_middle,
    style,
    widen,
)
from rotor_ida.plot.datasets import at_contact, check_dataset, clearance_of, contact_text, units_in
from rotor_ida.plot.labels import (
    SEPARATOR,
    label_axis,
    label_parameter,
    lengths_text,
    number_text,
    speed_text,
    speeds_in,
    title_of,
    unit_of,
)
from rotor_ida.plot.legends import legend_below, shared_legend
from rotor_ida.plot.motion import checked_run
from rotor_ida.plot.responses import LINES
from rotor_ida.results.checked_run import check_system_run, nodes_in
from rotor_ida.results.growth_words import RESONANT
from rotor_ida.schema import MODE, WHIRL_DIRECTION, flags_of, words_of
from rotor_ida.texts import in_figure
from rotor_ida.units import number, quantity

WHIRLS = ("speed", "amplitude", "node_amplitude", "stability", "in_contact", "clearance", "node",
          "node_phase_lag", "contact_stator")  # fmt: skip
# Along an axis: the most names of nodes, and the most characters that are not turned.
MOST_NAMES, MOST_CHARACTERS = 40, 60
# Between two clearances at one node, of the length of the axis.
BESIDE = 0.01
WIDTH = 7.2
Indices = npt.NDArray[np.intp]
SENSES = {
    "forward": (palette.BLUE, "^"),
    "backward": (palette.ORANGE, "v"),
    "none": (palette.GREY, "o"),
}
# Eigenvalues above this many times the largest speed are cut off.
HIGHEST = 3.0
# Upper end of the axis over the largest value that is drawn.
ABOVE = 1.08
NEEDED = (
    "speed", "major_axis", "scale_factor", "clearance", "contact_node", "clearance_verdict",
    "critical_speed",
)  # fmt: skip
ALLOWED, ORBIT = 0.75, "scaled orbit, peak to peak"
# Lowest and highest part of a diametral clearance that is shown, unless the orbits are larger.
LOWEST, HIGHEST_ORBIT, ROOM = 1e-3, 2.0, 1.5
BACKWARD = (*PARAMETERS, "amplitude", "whirl_speed", "kind", "stability", "birth_omega")
# Backward whirls: colour, line, words, and an arrow on each circle, at a separate angle [rad].
LOOKS = {
    "slipping": (palette.GREY, palette.DASHES, "slipping whirl", 0.8),
    "rolling": (palette.DARK_BROWN, "-", "dry whip", 0.5),
}
# Circles that are smaller than the figure by this factor are drawn once more, enlarged.
MAGNIFIED = 20.0


def plot_shape(run: xr.Dataset, *, t: float | None = None) -> Figure:
    """Draw the deflected shape at an instant, with the clearances.

    Parameters
    ----------
    run : Dataset
        Result of `rotor_ida.simulate` or `rotor_ida.run_up` for a `rotor_ida.RotorSystem`.
    t : float, optional
        The instant, in the unit of the run: the sample nearest to it is drawn. Default: where a
        node is farthest from its place of rest.

    Returns
    -------
    Figure
        The figure: x and y over the nodes, in their order or at their axial positions, if the
        system has these. Bars show where each stator leaves room, nodes in contact are marked.

    Examples
    --------
    >>> from rotor_ida import Rotor, simulate
    >>> system = Rotor(omega=1.7, zeta=0.07, delta0=0.5).system()
    >>> run = simulate(system, speed=1.7, duration=20)
    >>> [ax.get_ylabel() for ax in plot_shape(run, t=10.0).axes]
    ['displacement $x$', 'displacement $y$']
    """
    run = checked_run(check_system_run(run))
    sizes = np.hypot(run["x"].values, run["y"].values).max(axis=1, initial=0.0)
    now = run.isel(t=_nearest("t", run["t"].values, t, sizes))
    with style():
        figure = new_figure(WIDTH, 4.4)
        axes = figure.subplots(2, 1, sharex=True)
        across = _label_nodes(axes[1], run)
        for ax, name in zip(axes, ("x", "y"), strict=True):
            _draw_shape(ax, now, name, across)
            widen(ax, 0.0, LEAST_SPAN * float(np.hypot(now["x"], now["y"]).max()))
        figure.align_ylabels(axes)
        shared_legend(figure, axes, outer=False)
        at = f"$t$ {number(float(now['t']), 6)} {unit_of(run['t'])}".rstrip()
        figure.suptitle(SEPARATOR.join([title_of("run", run), at]), fontsize=10.0)
    return figure


def plot_whirl_shapes(
    whirls: xr.Dataset, *, speed: float | None = None, ax: Axes | None = None
) -> Axes:
    """Draw the deflected shape of every synchronous whirl at a speed.

    Parameters
    ----------
    whirls : Dataset
        Result of `rotor_ida.synchronous_response` for a rotor system.
    speed : float, optional
        The speed, in the unit of the dataset; the nearest one is drawn. Default: where a node is
        farthest from its place of rest.
    ax : Axes, optional
        Axes to draw on and return; default: those of a new figure.

    Raises
    ------
    InputError
        If the dataset is of another kind, or the speed is outside its speeds.

    Notes
    -----
    The displacement of each node is that along the direction of the node that moves most. Bars are
    the clearances of stators that stand still.

    Examples
    --------
    >>> from rotor_ida import Rotor, synchronous_response
    >>> system = Rotor(omega=1.0, zeta=0.07, delta0=0.5).system()
    >>> whirls = synchronous_response(system, speed=[0.5, 1.0, 1.5])
    >>> plot_whirl_shapes(whirls, speed=1.5).get_title()
    'speed 1.5'
    """
    whirls = check_dataset("whirls", whirls, WHIRLS)
    sizes = whirls["node_amplitude"].max(["branch", "node"]).values
    here = whirls.isel(speed=_nearest("speed", whirls["speed"].values, speed, sizes))
    flags = flags_of(whirls["stability"])
    with drawing(ax) as ax:
        places = _label_nodes(ax, here)
        order = np.argsort(places, kind="stable")
        label_axis(ax.yaxis, "displacement", here["node_amplitude"])
        ax.axhline(0.0, color=palette.GREY, lw=0.7)
        fixed = here.isel(contact=here["contact_stator"].values == "")
        _draw_rooms(ax, fixed, places, np.zeros(fixed.sizes["contact"]))
        for word, (label, dashes, _, colour) in LINES.items():
            for branch in np.flatnonzero(here["stability"].values == flags[word]):
                own = here.isel(branch=branch)
                moved = own["node_amplitude"].values * np.exp(-1j * own["node_phase_lag"].values)
                turn = moved[np.argmax(np.abs(moved))]
                up = (moved * turn.conjugate()).real / max(abs(turn), 1e-300)
                ax.plot(places[order], up[order], color=colour, ls=dashes, marker="o", ms=2.6,
                        label=label, zorder=3.0)  # fmt: skip
        ax.set_title(speed_text(here["speed"]))
        legend_below(ax, columns=4)
    return ax


def _nearest(name: str, values: Values, wanted: object, sizes: Values) -> int:
    """Return the number of the value nearest to one; default: where sizes are largest."""
    if wanted is None:
        return int(np.argmax(np.nan_to_num(sizes, nan=-1.0)))
    given = check_real(name, wanted)
    if not values.min() <= given <= values.max():
        raise InputError(
            f"{name} must lie from {values.min():g} to {values.max():g}, got {wanted!r}"
        )
    return int(np.argmin(np.abs(values - given)))


def _draw_shape(ax: Axes, now: xr.Dataset, name: str, across: Values) -> None:
    """Draw one displacement of all nodes at an instant, with the room in the stators."""
    up, nodes = now[name].values, nodes_in(now)
    now = now.isel(contact=np.isin(now["contact_node"].values, nodes))
    order = np.argsort(across, kind="stable")
    ax.axhline(0.0, color=palette.GREY, lw=0.7)
    ax.plot(
        across[order], up[order], color=palette.BLUE, marker="o", ms=3.2, label="shaft", zorder=2.8
    )
    places = _places_of_contacts(now)
    if places.size:
        _draw_rooms(ax, now, across, up[places] - now[f"contact_{name}"].values)
    touching = places[now["mode"].values != MODE["flight"]]
    if touching.size:
        draw_marks(ax, across[touching], up[touching], "o", palette.RED, size=5.5,
                   label="in contact", level=3.0)  # fmt: skip
    label_axis(ax.yaxis, name, now[name])


def _draw_rooms(ax: Axes, now: xr.Dataset, across: Values, centres: Values) -> None:
    """Draw the clearances of contacts about their centres, those of one node side by side."""
    places = _places_of_contacts(now)
    if places.size:
        shared = np.array([(places[:k] == place).sum() for k, place in enumerate(places)])
        aside = BESIDE * float(np.ptp(across)) * shared
        ax.errorbar(across[places] + aside, centres, now["clearance"].values, fmt="none",
                    ecolor=palette.INK, elinewidth=0.8, capsize=3.5, label="clearance")  # fmt: skip


def _places_of_contacts(now: xr.Dataset) -> Indices:
    """Return the number of the node of each contact."""
    nodes = nodes_in(now)
    return np.array([nodes.index(str(each)) for each in now["contact_node"].values], dtype=np.intp)


def _label_nodes(ax: Axes, dataset: xr.Dataset) -> Values:
    """Label an axis along the shaft, and return the positions of the nodes on it.

    Without positions these are the numbers of the nodes, whose names are turned or not all written
    if there are many.
    """
    if "axial_position" in dataset.variables:
        label_axis(ax.xaxis, "axial_position", dataset["axial_position"])
        return np.asarray(dataset["axial_position"].values)
    names = nodes_in(dataset)
    step = math.ceil(len(names) / MOST_NAMES)
    drawn = list(map(in_figure, names[::step]))
    turned = sum(map(len, drawn)) + 2 * len(drawn) > MOST_CHARACTERS
    ax.set_xticks(range(0, len(names), step), drawn, rotation=90 if turned else 0)
    ax.set_xlim(-0.5, len(names) - 0.5)
    ax.set_xlabel("node")
    return np.arange(float(len(names)))


def plot_campbell(found: xr.Dataset, *, ax: Axes | None = None) -> Axes:
    """Draw whirl speeds over the spin speed: forward, backward and neither.

    Parameters
    ----------
    found : Dataset
        Result of `rotor_ida.campbell`. Stiffer contacts are drawn fainter, critical speeds as
        rings, or as crosses where the amplification factor is below 2.5. Red rings show whirls that
        grow.
    ax : Axes, optional
        Axes to draw on and return; default: those of a new figure.

    Examples
    --------
    >>> from rotor_ida import Rotor, campbell
    >>> system = Rotor(omega=1.0, zeta=0.07, delta0=0.5, shaft_stiffness=0.25).system()
    >>> plot_campbell(campbell(system, speed=[0.0, 0.5, 1.0])).get_ylabel()
    'size of the whirl speed'
    """
    needed = ("speed", "contact_stiffness", "whirl_speed", "whirl_sense", "critical_speed")
    found = check_dataset("found", found, needed)
    springs, unit = found["contact_stiffness"].values, units_in(found["contact_stiffness"])
    critical, shown = speeds_in(found["critical_speed"]).values, speeds_in(found["whirl_speed"])
    whirl = np.abs(shown.values)
    with drawing(ax) as ax:
        speeds = label_parameter(ax.xaxis, SPEED, found)
        label_axis(ax.yaxis, "whirl_speed", shown, words="size of the whirl speed")
        ax.plot(speeds, np.abs(speeds), color=palette.INK, lw=0.9, ls="--", label="spin speed")
        opacities = np.linspace(1.0, 0.35, springs.size)
        for word, (colour, mark) in SENSES.items():
            for number, opacity in enumerate(opacities):
                chosen = found["whirl_sense"].values[number] == WHIRL_DIRECTION[word]
                chosen &= np.isfinite(whirl[number])
                across = np.broadcast_to(speeds[:, np.newaxis], chosen.shape)
                ax.plot(across[chosen], whirl[number][chosen], ls="", marker=mark, ms=2.8,
                        color=colour, alpha=opacity, mec="none")  # fmt: skip
                if chosen.any():
                    draw_marks(ax, [], [], mark, colour, size=4.5,
                               label="along a line" if word == "none" else word)  # fmt: skip
        for spring, opacity in zip(springs, opacities, strict=True) if springs.size > 1 else ():
            words = quantity(spring, "N/m" if unit == "N m-1" else "1", 3)
            ax.plot([], [], ls="", marker="s", color=palette.INK, alpha=opacity,
                    label=f"contacts {words}")  # fmt: skip
        grows = np.nonzero(found["damping_ratio"].values < 0.0)
        is_damped = found["critical_damping_ratio"].values > RESONANT
        sharp, damped = critical[~is_damped], critical[is_damped]
        for x, y, marker, colour, label in (
            (speeds[grows[1]], whirl[grows], "o", palette.RED, "unstable"),
            (sharp, sharp, "o", palette.INK, "critical speed"),
            (damped, damped, "x", palette.GREY, "amplification below 2.5"),
        ):
            if x.size:
                draw_marks(ax, x, np.abs(y), marker, colour, size=5.0, face="none", label=label,
                           level=3.6)  # fmt: skip
        highest = HIGHEST * float(np.abs(speeds).max(initial=0.0)) or np.inf
        drawn = np.append(whirl[whirl <= highest], np.abs(critical))
        ax.set_ylim(0.0, ABOVE * float(drawn.max(initial=0.0)) or 1.0)
        legend_below(ax, columns=4)
    return ax


def plot_clearance(report: xr.Dataset, *, contact: int | str = 0, ax: Axes | None = None) -> Axes:
    """Draw the scaled orbits at a close clearance over the spin speed, from peak to peak.

    Parameters
    ----------
    report : Dataset
        Result of `rotor_ida.clearance_report`.
    contact : int or str
        The contact, by its number or its node. Its diametral clearance is a line, and 75 per cent
        of it dashed; critical speeds are dotted, and the continuous speeds shaded.
    ax : Axes, optional
        Axes to draw on and return; default: those of a new figure.

    Raises
    ------
    InputError
        If the dataset is of another kind, or has no such contact.

    Examples
    --------
    >>> from rotor_ida import Contact, Rotor, clearance_report
    >>> system = Rotor(omega=1.0, zeta=0.07, delta0=5.0).system()
    >>> report = clearance_report(system, speed=(2.0, 3.0),
    ...                           probes=["disc"], vibration_limit=1.0)
    >>> plot_clearance(report).get_title()
    'contact 0 at disc: passes'
    """
    report = check_dataset("report", report, NEEDED)
    own = at_contact(report, contact)
    diameter = 2.0 * own["clearance"].item()
    scaled = (own["major_axis"] * own["scale_factor"]).transpose("case", "speed").values
    with drawing(ax) as ax:
        speeds = label_parameter(ax.xaxis, SPEED, report)
        factor = float(speeds[-1] / report["speed"].values[-1])
        label_axis(ax.yaxis, "major_axis", report["major_axis"], words=ORBIT)
        running = factor * np.asarray(report.attrs["running_speeds"])
        ax.axvspan(running[0], running[1], color=palette.SHADE, lw=0.0, zorder=0.5,
                   label="continuous speeds")  # fmt: skip
        ax.axhline(diameter, color=palette.INK, lw=1.0, zorder=1.6, label="diametral clearance")
        ax.axhline(ALLOWED * diameter, color=palette.INK, lw=0.9, ls=palette.DASHES, zorder=1.6,
                   label="75 % of it")  # fmt: skip
        for number, each in enumerate(factor * report["critical_speed"].values):
            ax.axvline(each, color=palette.GREY, lw=0.9, ls=":", zorder=1.4,
                       label="_" if number else "critical speed")  # fmt: skip
        for number, axes in enumerate(scaled):
            colour, dashes = palette.look(number + 1)
            ax.plot(speeds, axes, color=colour, ls=dashes, label=f"case {number}", zorder=3.0)
        ax.set_yscale("log")
        ax.set_xlim(0.0, speeds[-1])
        top = max(HIGHEST_ORBIT * diameter, ROOM * float(scaled.max()))
        ax.set_ylim(max(LOWEST * diameter, 0.5 * float(scaled.min())), top)
        verdict = words_of(own["clearance_verdict"])[0]
        ax.set_title(f"{contact_text(own, own['contact'].item())}: {verdict}")
        legend_below(ax, columns=3)
    return ax


def plot_backward_whirl(whirls: xr.Dataset, *, ax: Axes | None = None) -> Axes:
    """Draw the backward whirls that friction drives without unbalance, with the stator.

    Parameters
    ----------
    whirls : Dataset
        Result of `rotor_ida.backward_whirl`.
    ax : Axes, optional
        Axes to draw on and return; default: those of a new figure.

    Examples
    --------
    >>> from rotor_ida import Rotor, backward_whirl
    >>> rotor = Rotor(omega=0.63, zeta=0.1, delta0=1.0, friction=0.2, disc_radius=10.0)
    >>> ax = plot_backward_whirl(backward_whirl(rotor))
    >>> [text.get_text().partition(":")[0] for text in ax.get_legend().get_texts()]
    ['dry whip', 'clearance', 'slipping whirl']
    """
    whirls = check_dataset("whirls", whirls, BACKWARD)
    radii, clearance = whirls["amplitude"].values, clearance_of(whirls, "whirls")
    with drawing(ax, width=4.2, height=5.4) as ax:
        label_axis(ax.xaxis, "x", whirls["amplitude"])
        label_axis(ax.yaxis, "y", whirls["amplitude"])
        _draw_circles(ax, whirls, clearance, max(clearance, float(np.nan_to_num(radii).max())))
        if not np.isfinite(radii).any():
            say_in_middle(ax, _why_there_is_none(whirls))
        inner = max(clearance, float(np.nan_to_num(radii, nan=math.inf).min()))
        if ax.get_xlim()[1] > MAGNIFIED * inner > 0.0:
            inset = ax.inset_axes((0.3, 0.3, 0.4, 0.4))
            _draw_circles(inset, whirls, clearance, inner)
            inset.tick_params(labelsize=7.0)
            inset.locator_params(nbins=3)
            ax.indicate_inset_zoom(inset, edgecolor=palette.INK)
        legend_below(ax, columns=1)
        ax.set_title(title_of("whirls", whirls))
    return ax


def _draw_circles(ax: Axes, whirls: xr.Dataset, clearance: float, largest: float) -> None:
    """Draw the clearance and the circles of the whirls as far as the largest radius."""
    length = units_in(whirls["amplitude"])
    rate = unit_of(whirls["whirl_speed"]).replace("1/s", "rad/s")
    draw_ring(ax, clearance)
    for radius, speed, kind, stability in zip(
        whirls["amplitude"].values.tolist(), whirls["whirl_speed"].values.tolist(),
        words_of(whirls["kind"]), words_of(whirls["stability"]), strict=True,
    ):  # fmt: skip
        if math.isfinite(radius):
            colour, dashes, words, angle = LOOKS[kind]
            (said,), unit = lengths_text(length, radius)
            size = f"{said}$ {unit}".rstrip()
            turns = f"{number_text(speed, '.4g')}$ {rate}".rstrip()
            ax.plot(*circle(radius), color=colour, ls=dashes, lw=1.4,
                    label=rf"{words}: {stability}, $|z| = {size}, $\Omega = {turns}")  # fmt: skip
            if largest / MAGNIFIED < radius <= largest:
                _draw_backward_arrow(ax, radius, angle, colour)
    ax.set_aspect("equal")
    ax.set(xlim=(-1.1 * largest, 1.1 * largest), ylim=(-1.1 * largest, 1.1 * largest))


def _draw_backward_arrow(ax: Axes, radius: float, angle: float, colour: str) -> None:
    """Draw an arrow that shows clockwise motion."""
    tip, tail = (
        (radius * math.cos(each), radius * math.sin(each)) for each in (angle, angle + 0.02)
    )
    arrow = {"arrowstyle": "-|>", "color": colour, "mutation_scale": 13.0}
    ax.annotate("", tip, tail, arrowprops=arrow)


def _why_there_is_none(whirls: xr.Dataset) -> str:
    """Return the reason why no backward whirl exists."""
    birth = float(whirls["birth_omega"])
    if math.isnan(birth):
        return "no dry whip at any speed"
    return rf"no dry whip below $\omega = {number_text(birth, '.4g')}$"
