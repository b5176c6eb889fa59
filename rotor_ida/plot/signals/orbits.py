"""Plots of motion: orbits with keyphasor pulses, the centre line, traces over time."""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import product

import numpy as np
import numpy.typing as npt
import xarray as xr
from matplotlib.axes import Axes

from rotor_ida.arrays import Values
from rotor_ida.checks import check_nonnegative
from rotor_ida.errors import InputError
from rotor_ida.plot import palette
from rotor_ida.plot.appearance import draw_level, draw_marks, draw_ring, drawing
from rotor_ida.plot.datasets import check_dataset, clearance_of
from rotor_ida.plot.decimation import draw_over_time, draw_path, thinned
from rotor_ida.plot.labels import label_axis, label_of, lengths_text, title_of
from rotor_ida.plot.legends import legend_below
from rotor_ida.plot.motion import NEEDED, checked_run, draw_orbit, place_of_disc, shade_contacts
from rotor_ida.plot.signals.beneath import Beneath
from rotor_ida.plot.signals.exact_motion import (
    Orbit,
    centres_of,
    orbits_of,
    speeds_along,
    traces_of,
)
from rotor_ida.plot.signals.orders import tracks_of
from rotor_ida.plot.signals.speeds import mark_speeds, title_of_signals
from rotor_ida.plot.signals.units import is_one_speed, units_of
from rotor_ida.results.checked_run import samples_in
from rotor_ida.signals.record import Record, mean_of, record_of
from rotor_ida.signals.sampling import check_run_sampling

# The orbit is blank for this fraction of a revolution before each pulse.
BLANK = 0.03
# More pulses have smaller dots.
FEW_PULSES, MANY_PULSES = 40, 400
# An exact orbit of more points fills its annulus, and is a thin line.
MANY_POINTS = 20_000
# An exact orbit this many times wider than motion and clearance would make them a dot.
FAR = 10.0
TRACES = {
    "x": (palette.BLUE, "$x$"),
    "y": (palette.ORANGE, "$y$"),
    "radius": (palette.INK, "radius"),
}


def plot_orbit(
    run: xr.Dataset, *, keyphasor: bool | None = None, clearance: float | None = None,
    beneath: Beneath = (), ax: Axes | None = None,
) -> Axes:  # fmt: skip
    """Draw the orbit in the plane, with the clearance circle and keyphasor dots.

    Parameters
    ----------
    run : Dataset
        What `rotor_ida.simulate` or `rotor_ida.run_up` returned, or signals.
    keyphasor : bool, optional
        Whether to draw a dot at each keyphasor pulse and leave the orbit blank just before it; the
        order of blank and dot shows the direction of motion. Default: true for signals whose
        angle is known, false for runs, whose contacts and events are drawn. The pulse of a run
        is where the unbalance points along x.
    clearance : float, optional
        Clearance in the unit of the signals, if they do not contain it.
    beneath : Dataset or sequence of Dataset
        Exact orbits under this one: of `rotor_ida.synchronous_response`, `rotor_ida.limit_cycle`
        and `rotor_ida.backward_whirl`. Whirls at several speeds are reduced to the speed of the
        run. Under a run-up they may be at any speed, such as the last. One more than 10 times
        as wide as motion and clearance is only named in the legend.
    ax : Axes, optional
        Axes to draw on and return; default: those of a new figure.

    Notes
    -----
    An orbit of more than 20000 samples is thinned on a grid finer than the dots of a figure, each
    step drawn once. If more than 60000 samples remain, SVG and PDF have it as dots. Even an
    excursion of one sample stays visible.

    Examples
    --------
    >>> from rotor_ida import Rotor, signals_of, simulate
    >>> rotor = Rotor(omega=1.7, zeta=0.07, delta0=0.5)
    >>> run = simulate(rotor, start=(0, 0, 0, 0), duration=20, samples=401)
    >>> plot_orbit(run).get_xlabel()
    'displacement $x$'
    >>> [text.get_text() for text in plot_orbit(signals_of(run)).get_legend().get_texts()]
    ['clearance', 'orbit', 'pulse of the keyphasor']
    """
    given = check_dataset("run", run, ("t", "x", "y"))
    is_run = set(NEEDED) <= set(given.variables)
    given = checked_run(given, NEEDED) if is_run else given
    record = record_of(given, "run") if keyphasor or not is_run else None
    units = units_of(given, "x", "t")
    exact = orbits_of(beneath, given, units)
    with drawing(ax, width=4.0, height=4.9) as ax:
        label_axis(ax.xaxis, "x", given["x"])
        label_axis(ax.yaxis, "y", given["y"])
        _draw_exact_orbits(ax, exact, given, _ring_of(given, clearance))
        if is_run:
            place = place_of_disc(given)
            draw_orbit(ax, place)
            ax.set_title(title_of("run", given))
            if keyphasor and record is not None:
                _draw_pulses(ax, record, place.path.time, place.path.x, place.path.y)
        elif record is not None:
            draw_ring(ax, _ring_of(given, clearance) or 0.0)
            marked = record.has_mark if keyphasor is None else keyphasor
            _draw_orbit(ax, record, marked=marked)
            ax.set_title(title_of_signals(given, units.speeds(speeds_along(given)), zero=True))
        ax.set_aspect("equal", adjustable="datalim")
        legend_below(ax)
    return ax


def plot_centre_line(
    signals: xr.Dataset, *, clearance: float | None = None, orders: npt.ArrayLike = 1.0,
    revolutions: int | None = None, beneath: Beneath = (), ax: Axes | None = None,
) -> Axes:  # fmt: skip
    """Draw the mean position of the shaft as the speed changes, in the circle of the clearance.

    Parameters
    ----------
    signals : Dataset
        Signals, a run or run-up, or the result of `rotor_ida.centre_line` or `rotor_ida.orders`.
    clearance : float, optional
        Clearance in the unit of the signals, if they do not contain it.
    orders : array_like
        Orders to fit together with the mean [dimensionless], such as 0.5 and 1 where there is a
        steady ½X.
    revolutions : int, optional
        Length of the windows [dimensionless]; default as in `plot_bode`.
    beneath : Dataset or sequence of Dataset
        Exact positions under the line: `rotor_ida.closed_forms.rest`, the mean of a
        `rotor_ida.limit_cycle`, and the centre of `rotor_ida.synchronous_response`.
    ax : Axes, optional
        Axes to draw on and return; default: those of a new figure.

    Examples
    --------
    >>> from rotor_ida import Rotor, run_up
    >>> heavy = Rotor(omega=0.3, zeta=0.1, delta0=2.0, shaft_stiffness=0.1, load=0.3)
    >>> up = run_up(heavy, start=(0, -2, 0, 0), to=1.5, rate=0.005, samples=8001)
    >>> plot_centre_line(up).get_ylabel()
    'mean displacement $y$'
    """
    given = check_dataset("signals", signals, ())
    ready = {"offset_x", "offset_y", "window"} <= set(given.variables)
    means = given if ready else tracks_of(given, orders, revolutions)
    units = units_of(means, "offset_x", "speed")
    speeds = units.speeds(means["speed"].values)
    one_speed = is_one_speed(speeds.values)
    x, y = means["offset_x"].values, means["offset_y"].values
    exact = centres_of(beneath, means, units)
    with drawing(ax, width=4.2, height=4.9) as ax:
        label_axis(ax.xaxis, "x", units.lengths(x), words="mean displacement $x$")
        label_axis(ax.yaxis, "y", units.lengths(y), words="mean displacement $y$")
        ring = _ring_of(means, clearance)
        mean = mean_of(means.coords)
        draw_ring(ax, ring or 0.0, mean)
        if one_speed:
            _draw_places(ax, means, x, y)
        else:
            ax.plot(*thinned(x, y), color=palette.BLUE, lw=1.1, label="centre line", zorder=3.0)
        for place, words, marker in exact:
            draw_marks(ax, place.real, place.imag, marker, palette.PURPLE, size=8.0, face="none",
                       edge=1.3, label=words, level=3.3)  # fmt: skip
        size = ring or float(max(np.ptp(x), np.ptp(y))) or 1.0
        mark_speeds(ax, x + 1j * y, speeds, palette.BLUE, apart=0.08 * size,
                    label=label_of("speed", speeds))  # fmt: skip
        ax.set_aspect("equal", adjustable="datalim")
        title = title_of_signals(means, speeds, zero="gap" in means.attrs)
        if ring and mean:  # where probes see the centre of the stator is not known
            title = "\n".join(filter(None, [title, "clearance about the mean of the record"]))
        ax.set_title(title)
        legend_below(ax)
    return ax


def _draw_places(ax: Axes, means: xr.Dataset, x: Values, y: Values) -> None:
    """Draw the mean positions at one speed as dots, on axes as wide as the whirl about them."""
    draw_marks(ax, x, y, "o", palette.BLUE, size=3.0, label="mean of each window", level=3.0)
    if "forward_whirl_amplitude" in means.variables:
        reach = float(means["forward_whirl_amplitude"].max())
        ax.update_datalim([(x.mean() + side * reach, y.mean() + side * reach) for side in (-1, 1)])


def plot_trace(
    signals: xr.Dataset, *, names: tuple[str, ...] = ("x", "y"), clearance: float | None = None,
    beneath: Beneath = (), ax: Axes | None = None,
) -> Axes:  # fmt: skip
    """Draw displacements over time, with contacts shaded and the pulses of the keyphasor.

    Parameters
    ----------
    signals : Dataset
        Signals, or a run or run-up, which includes contacts.
    names : tuple of {"x", "y", "radius"}
        Quantities to draw.
    clearance : float, optional
        Clearance in the unit of the signals, if they do not contain it.
    beneath : Dataset or sequence of Dataset
        Exact motion under the trace: a `rotor_ida.limit_cycle`, shifted in time to match the end of
        the trace, the whirl of `rotor_ida.synchronous_response` nearest to that end, or any other
        motion ``x y`` on ``t``, such as a flight.
    ax : Axes, optional
        Axes to draw on and return; default: those of a new figure.

    Notes
    -----
    If there are more than 20000 samples, the first, last, smallest and largest in each column of
    dots are drawn. The picture is the same, and no spike is lost. Contacts too close to tell apart
    are shaded together, in a paler shade.

    Examples
    --------
    >>> from rotor_ida import Rotor, simulate
    >>> run = simulate(Rotor(omega=1.7, zeta=0.07, delta0=0.5), start=(0, 0, 0, 0), duration=20)
    >>> ax = plot_trace(run)
    >>> [text.get_text() for text in ax.get_legend().get_texts()]
    ['in contact', '$x$', '$y$', 'clearance']
    """
    given = check_dataset("signals", signals, ("t", "x", "y"))
    if not names or any(name not in TRACES for name in names):
        raise InputError(f"names must be of {', '.join(TRACES)}, got {names!r}")
    check_run_sampling(given)
    times = samples_in("signals", given, "t")
    z = samples_in("signals", given, "x") + 1j * samples_in("signals", given, "y")
    units = units_of(given, "x", "t")
    exact = traces_of(beneath, given, units)
    radius_alone = names == ("radius",)
    with drawing(ax, width=7.0, height=2.9) as ax:
        shade_contacts(ax, given)
        for trace, name in product(exact, names):
            draw_over_time(ax, trace.times, _component(name, trace.z), color=palette.PURPLE,
                           lw=2.6, alpha=0.4, label=trace.words, zorder=1.9)  # fmt: skip
        label_axis(ax.xaxis, "t", given["t"])
        words = "radius $|z|$" if radius_alone else "displacement"
        label_axis(ax.yaxis, "x", units.lengths(times), words=words)
        for name in names:
            colour, label = TRACES[name]
            draw_over_time(ax, times, _component(name, z), color=colour, lw=0.8, label=label)
        ring = _ring_of(given, clearance)
        draw_level(ax, ring or 0.0)
        if not radius_alone:
            draw_level(ax, -(ring or 0.0), label="_")
        ax.set_xlim(float(times[0]), float(times[-1]))
        if "file" in given.attrs:
            ax.set_title(title_of_signals(given, units.speeds(speeds_along(given)), zero=True))
        legend_below(ax, columns=5)
    return ax


def _component(name: str, z: npt.NDArray[np.complex128]) -> Values:
    """Return a quantity of complex displacements by its name."""
    return {"x": z.real, "y": z.imag, "radius": np.abs(z)}[name]


def _draw_exact_orbits(
    ax: Axes, exact: Sequence[Orbit], given: xr.Dataset, ring: float | None
) -> None:
    """Draw exact orbits; those far outside the motion and its clearance only in the legend."""
    extent = max(float(np.hypot(given["x"].values, given["y"].values).max()), ring or 0.0)
    for orbit in exact:
        x, y, words = orbit.x, orbit.y, orbit.words
        radius = float(np.hypot(x, y).max())
        if radius > FAR * extent > 0.0:
            x, y = np.empty(0), np.empty(0)
            (size,), unit = lengths_text(str(given["x"].units), radius)
            words = f"{words}, outside:\nradius {size} {unit}".rstrip()
        width = 2.6 if orbit.x.size < MANY_POINTS else 0.6
        ax.plot(x, y, color=orbit.colour, ls=orbit.dashes, lw=width, alpha=0.5, label=words,
                zorder=1.9)  # fmt: skip


def _draw_orbit(ax: Axes, record: Record, *, marked: bool) -> None:
    """Draw the orbit of signals, blank before each pulse of the keyphasor if these are marked."""
    times, x, y = record.times, record.z.real, record.z.imag
    if marked:
        blank = _blank(record)
        x, y = (np.where(blank, np.nan, each) for each in (x, y))
    draw_path(ax, x, y, color=palette.BLUE, lw=0.8, label="orbit", zorder=2.5)
    if marked:
        _draw_pulses(ax, record, times, record.z.real, record.z.imag)


def _blank(record: Record) -> npt.NDArray[np.bool_]:
    """Return a mask of the samples just before a pulse, where the orbit is blank."""
    turns = record.known_angles() / (2.0 * math.pi)
    return np.asarray((turns % 1.0) > 1.0 - BLANK, dtype=bool)


def _draw_pulses(ax: Axes, record: Record, times: Values, x: Values, y: Values) -> None:
    """Draw a dot on the path at each pulse."""
    pulses = record.pulses()
    size = 4.0 if pulses.size <= FEW_PULSES else 2.4 if pulses.size <= MANY_PULSES else 1.4
    ax.plot(np.interp(pulses, times, x), np.interp(pulses, times, y), ls="", marker="o", ms=size,
            mfc=palette.INK, mec="white", mew=0.3, label="pulse of the keyphasor", zorder=3.4,
            rasterized=pulses.size > 10_000)  # fmt: skip


def _ring_of(given: xr.Dataset, clearance: float | None) -> float | None:
    """Return the clearance in the unit of the signals, if it is known."""
    if clearance is not None:
        return check_nonnegative("clearance", clearance)
    if "clearance" in given.variables and not given["clearance"].ndim:  # at a node of a system
        return float(given["clearance"].fillna(0.0))
    if "delta0" in given.variables and not given["delta0"].ndim:
        return clearance_of(given)
    return None
