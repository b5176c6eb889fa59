"""The motion itself: orbits with the pulses of the keyphasor, the centre line, traces over time."""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt
import xarray as xr
from matplotlib.axes import Axes

from rotor_ida.arrays import Values
from rotor_ida.checks import check_nonnegative
from rotor_ida.errors import InputError
from rotor_ida.plot.appearance import (
    BLUE,
    DARK_BROWN,
    DASHES,
    GREY,
    INK,
    ORANGE,
    PURPLE,
    SHADE,
    axes_or_new,
    check_dataset,
    draw_ring,
    legend_below,
    style,
)
from rotor_ida.plot.decimation import COLUMNS, draw_path, kept_in_columns, thinned
from rotor_ida.plot.labels import label_axis, scale_of
from rotor_ida.plot.runs import NEEDED, path_of
from rotor_ida.plot.runs import plot_orbit as plot_orbit_of_run
from rotor_ida.plot.signals.beneath import CYCLE
from rotor_ida.plot.signals.over_time import Path, paths_over_time
from rotor_ida.plot.signals.tracks import MOST_MARKS, Beneath
from rotor_ida.plot.signals.units import (
    Units,
    check_parameters,
    is_one_speed,
    list_of,
    scales_of,
    title_of,
    units_of,
)
from rotor_ida.schema import flags_of
from rotor_ida.signals.orders import centre_line
from rotor_ida.signals.record import Record, record_of

# Speeds by which a run is told to be one at a constant speed.
FEW_SPEEDS = 200
# The orbit is left blank for this part of a revolution before each pulse.
BLANK = 0.03
# More pulses have smaller dots.
FEW_PULSES, MANY_PULSES = 40, 400
# A cycle that is periodic at rest axes closes after some periods; others are shown for that many.
MOST_PERIODS, CLOSED = 40, 1e-6
# An exact orbit of more points fills its ring, and is a thin line.
MANY_POINTS = 20_000
TRACES = {"x": (BLUE, "x"), "y": (ORANGE, "y"), "radius": (INK, "radius")}


def plot_orbit(
    run: xr.Dataset,
    *,
    keyphasor: bool | None = None,
    clearance: float | None = None,
    beneath: Beneath = (),
    ax: Axes | None = None,
) -> Axes:
    """Draw the orbit in the plane, with the ring of the clearance and dots of the keyphasor.

    Parameters
    ----------
    run : Dataset
        What `rotor_ida.simulate` or `rotor_ida.run_up` returned, or signals.
    keyphasor : bool, optional
        Whether each pulse of the keyphasor is a dot, and the orbit blank just before it, so that
        blank and dot tell the way round. By default of signals whose angle is known, and not of
        runs, whose contacts and events are drawn. A pulse of a run is where the unbalance points
        along x.
    clearance : float, optional
        Clearance of signals that do not tell it, in their unit.
    beneath : Dataset or sequence of Dataset
        Exact orbits under this one: of `rotor_ida.synchronous_response`, `rotor_ida.limit_cycle`
        and `rotor_ida.backward_whirl`. Of whirls at several speeds those at that of the run. Under
        a run-up they may be of any speed, such as its last.
    ax : Axes, optional
        Where to draw, and what is returned; by default the axes of a new figure.

    Notes
    -----
    An orbit of more than 20000 samples passes through the same cells of a grid finer than the dots
    of a figure, each step drawn once. If more than 60000 are left even so, every dot that the
    orbit passes through is inked: an excursion of one sample stays in the picture.

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
    given = _within(check_dataset("run", run, ("t", "x", "y")))
    is_run = set(NEEDED) <= set(given.variables)
    record = record_of(given, "run") if keyphasor or not is_run else None
    units = units_of(given, "x", "t")
    exact = _orbits_of(beneath, given, units)
    with style():
        ax = axes_or_new(ax, width=4.0, height=4.9)
        for x, y, words, colour, dashes in exact:
            width = 2.6 if x.size < MANY_POINTS else 0.6
            ax.plot(x, y, color=colour, ls=dashes, lw=width, alpha=0.5, label=words, zorder=1.9)
        if is_run:
            plot_orbit_of_run(given, ax=ax)
            if keyphasor and record is not None:
                path = path_of(given)
                _draw_pulses(ax, record, path.time, path.x, path.y)
        elif record is not None:
            _draw_orbit(ax, given, record, keyphasor, _ring_of(given, clearance))
        ax.set_aspect("equal", adjustable="datalim")
        legend_below(ax)
    return ax


def plot_centre_line(
    signals: xr.Dataset,
    *,
    clearance: float | None = None,
    revolutions: int = 1,
    beneath: Beneath = (),
    ax: Axes | None = None,
) -> Axes:
    """Draw the mean position of the shaft as the speed changes, in the circle of the clearance.

    Parameters
    ----------
    signals : Dataset
        Signals, a run or run-up, or what `rotor_ida.centre_line` made of one.
    clearance : float, optional
        Clearance of signals that do not tell it, in their unit.
    revolutions : int
        As of `rotor_ida.centre_line`, where that is still to be computed.
    beneath : Dataset or sequence of Dataset
        Exact places under the line: of `rotor_ida.closed_forms.rest`, the mean of a
        `rotor_ida.limit_cycle`, and the centre of `rotor_ida.synchronous_response`.
    ax : Axes, optional
        Where to draw, and what is returned; by default the axes of a new figure.

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
    held = given if ready else centre_line(given, revolutions=revolutions)
    units = units_of(held, "offset_x", "speed")
    speeds = units.speeds(held["speed"].values)
    x, y = held["offset_x"].values, held["offset_y"].values
    exact = _centres_of(beneath, held, units)
    with style():
        ax = axes_or_new(ax, width=4.2, height=4.9)
        label_axis(ax.xaxis, "x", units.lengths(x), words="mean displacement $x$")
        label_axis(ax.yaxis, "y", units.lengths(y), words="mean displacement $y$")
        ring = _ring_of(held, clearance)
        draw_ring(ax, ring or 0.0)
        ax.plot(*thinned(x, y), color=BLUE, lw=1.1, label="centre line", zorder=3.0)
        for place, words, marker in exact:
            ax.plot(place.real, place.imag, ls="", marker=marker, ms=8.0, mfc="none", mec=PURPLE,
                    mew=1.3, label=words, zorder=3.3)  # fmt: skip
        _mark_speeds(ax, x, y, speeds, ring)
        ax.set_aspect("equal", adjustable="datalim")
        ax.set_title(title_of(held, one_speed=is_one_speed(speeds.values)))
        legend_below(ax)
    return ax


def plot_trace(
    signals: xr.Dataset,
    *,
    names: tuple[str, ...] = ("x", "y"),
    clearance: float | None = None,
    beneath: Beneath = (),
    ax: Axes | None = None,
) -> Axes:
    """Draw displacements over time, with contacts shaded and the pulses of the keyphasor.

    Parameters
    ----------
    signals : Dataset
        Signals, or a run or run-up: the contacts of these are known.
    names : tuple of {"x", "y", "radius"}
        What is drawn.
    clearance : float, optional
        Clearance of signals that do not tell it, in their unit.
    beneath : Dataset or sequence of Dataset
        Exact motion under the trace: of `rotor_ida.limit_cycle`, shifted along time to where the
        end of the trace lies on it, of `rotor_ida.synchronous_response` the whirl nearest to that
        end, or any other motion ``x y`` on ``t``, such as a flight.
    ax : Axes, optional
        Where to draw, and what is returned; by default the axes of a new figure.

    Notes
    -----
    Of more than 20000 samples the first, last, smallest and largest in each column of dots are
    drawn, which gives the same picture: no spike is lost. Contacts closer to each other than a
    dot are shaded as one.

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
    times, units = given["t"].values, units_of(given, "x", "t")
    columns = {"x": given["x"].values, "y": given["y"].values}
    columns["radius"] = np.hypot(columns["x"], columns["y"])
    exact = paths_over_time(beneath, given, units)
    with style():
        ax = axes_or_new(ax, width=7.0, height=2.9)
        _shade_contacts(ax, given)
        for path in exact:
            _draw_exact_trace(ax, path, names)
        label_axis(ax.xaxis, "t", given["t"])
        words = "displacement" if names != ("radius",) else "radius $|z|$"
        label_axis(ax.yaxis, "x", units.lengths(times), words=words)
        for name in names:
            kept = kept_in_columns(times, columns[name])
            colour, label = TRACES[name]
            ax.plot(times[kept], columns[name][kept], color=colour, lw=0.8,
                    label=label if name == "radius" else f"${label}$")  # fmt: skip
        ring = _ring_of(given, clearance)
        if ring:
            for side in (ring, -ring) if names != ("radius",) else (ring,):
                ax.axhline(side, color=INK, lw=0.7, ls=DASHES, zorder=2.6,
                           label="clearance" if side > 0.0 else "_")  # fmt: skip
        ax.set_xlim(float(times[0]), float(times[-1]))
        legend_below(ax, columns=5)
    return ax


def _draw_exact_trace(ax: Axes, path: Path, names: tuple[str, ...]) -> None:
    words = path.words
    for name in names:
        values = {"x": path.z.real, "y": path.z.imag, "radius": np.abs(path.z)}[name]
        kept = kept_in_columns(path.times, values)
        ax.plot(path.times[kept], values[kept], color=PURPLE, lw=2.6, alpha=0.4, label=words,
                zorder=1.9)  # fmt: skip
        words = "_"


def pulses_of(record: Record) -> Values:
    """Return when the mark of the shaft passes the keyphasor: once a revolution."""
    angles = record.angles
    if angles is None:
        return np.empty(0)
    turns = angles / (2.0 * math.pi)
    whole = np.arange(math.ceil(turns[0] - 1e-9), math.floor(turns[-1] + 1e-9) + 1)
    return np.interp(whole, turns, record.times)


def _draw_orbit(
    ax: Axes, given: xr.Dataset, record: Record, keyphasor: bool | None, ring: float | None
) -> None:
    """Draw the orbit of signals."""
    label_axis(ax.xaxis, "x", given["x"])
    label_axis(ax.yaxis, "y", given["y"])
    draw_ring(ax, ring or 0.0)
    marked = record.angles is not None if keyphasor is None else keyphasor
    if marked:
        record.known_angles()
    times, x, y = record.times, record.z.real, record.z.imag
    if marked:
        x, y = (np.where(_blank(record, times), np.nan, each) for each in (x, y))
    draw_path(ax, x, y, colour=BLUE, width=0.8, words="orbit", level=2.5)
    if marked:
        _draw_pulses(ax, record, record.times, record.z.real, record.z.imag)
    ax.set_title(title_of(given, one_speed="speed" not in given.variables))


def _blank(record: Record, times: Values) -> npt.NDArray[np.bool_]:
    """Return at which samples the orbit is blank: just before a pulse."""
    turns = np.interp(times, record.times, record.known_angles()) / (2.0 * math.pi)
    return np.asarray((turns % 1.0) > 1.0 - BLANK, dtype=bool)


def _draw_pulses(ax: Axes, record: Record, times: Values, x: Values, y: Values) -> None:
    """Draw a dot on the path at each pulse."""
    pulses = pulses_of(record)
    size = 4.0 if pulses.size <= FEW_PULSES else 2.4 if pulses.size <= MANY_PULSES else 1.4
    ax.plot(np.interp(pulses, times, x), np.interp(pulses, times, y), ls="", marker="o", ms=size,
            mfc=INK, mec="white", mew=0.3, label="pulse of the keyphasor", zorder=3.4,
            rasterized=pulses.size > 10_000)  # fmt: skip


def _within(run: xr.Dataset) -> xr.Dataset:
    """Return a part of a run with the events of that part alone."""
    if not {"event_time", "event_kind", "starts_in_contact"} <= set(run.variables):
        return run
    met, (first, last) = run["event_time"].values, run["t"].values[[0, -1]]
    before = run["event_kind"].values[met < first]
    part = run.isel(event=(met >= first) & (met <= last))
    if not before.size:
        return part
    touches = before[-1] != flags_of(run["event_kind"])["exit"]
    return part.assign(starts_in_contact=run["starts_in_contact"].copy(data=np.int8(touches)))


def _ring_of(given: xr.Dataset, clearance: float | None) -> float | None:
    """Return the clearance in the unit of the signals, if it is known."""
    if clearance is not None:
        return check_nonnegative("clearance", clearance)
    if "delta0" in given.variables and not given["delta0"].ndim:
        return float(given["delta0"]) * scale_of(given, "length")
    return None


def _mark_speeds(ax: Axes, x: Values, y: Values, speeds: xr.DataArray, ring: float | None) -> None:
    """Mark first and last speed and round ones between along the line."""
    unit = " rpm" if speeds.attrs["units"] == "rpm" else ""
    size = ring or float(max(np.ptp(x), np.ptp(y))) or 1.0
    places = np.unique(np.linspace(0, x.size - 1, MOST_MARKS).astype(int))
    ax.plot(x[places], y[places], ls="", marker="o", ms=3.2, mfc=BLUE, mec=INK, mew=0.5, zorder=3.2,
            label="speed")  # fmt: skip
    told: list[tuple[float, float]] = []
    for place in places:
        here = (float(x[place]), float(y[place]))
        if all(math.dist(here, other) > 0.08 * size for other in told):
            told.append(here)
            ax.annotate(f"{float(speeds[place]):.3g}{unit}", here, xytext=(5, 2), fontsize=7.5,
                        textcoords="offset points", zorder=3.5)  # fmt: skip


def _shade_contacts(ax: Axes, given: xr.Dataset) -> None:
    """Shade the contacts of a run; those that no dot parts are shaded as one."""
    if not {"entry_time", "exit_time"} <= set(given.variables):
        return
    first, last = (float(each) for each in given["t"].values[[0, -1]])
    entries = np.nan_to_num(given["entry_time"].values, nan=first)
    exits = np.nan_to_num(given["exit_time"].values, nan=last)
    shown = (exits >= first) & (entries <= last)
    entries, exits = np.clip(entries[shown], first, last), np.clip(exits[shown], first, last)
    if not entries.size:
        return
    apart = np.flatnonzero(entries[1:] - exits[:-1] > (last - first) / COLUMNS)
    begins, ends = np.append(0, apart + 1), np.append(apart, entries.size - 1)
    bars = list(zip(entries[begins], exits[ends] - entries[begins], strict=True))
    ax.broken_barh(bars, (0.0, 1.0), label="in contact", transform=ax.get_xaxis_transform(),
                   facecolor=SHADE, linewidth=0.0, zorder=0.5)  # fmt: skip


def _orbits_of(
    beneath: Beneath, given: xr.Dataset, units: Units
) -> list[tuple[Values, Values, str, str, object]]:
    """Return exact orbits in the unit of the signals, with their words and looks."""
    found: list[tuple[Values, Values, str, str, object]] = []
    turn = np.exp(1j * np.linspace(0.0, 2.0 * math.pi, 361))
    skipped = () if _is_of_one_speed(given) else ("omega",)
    for dataset in list_of(beneath):
        check_parameters(dataset, given, skipped=skipped)
        length, names = scales_of(dataset, given, units).length, set(dataset.variables)
        if "line_kind" in names:
            z = _cycle_in_plane(dataset) * length
            found.append((z.real, z.imag, CYCLE, PURPLE, "-"))
        elif {"amplitude", "whirl"} <= names:
            kinds = flags_of(dataset["kind"])
            for number, word, colour in (
                (kinds["rolling"], "exact dry whip", DARK_BROWN),
                (kinds["slipping"], "exact slipping whirl", GREY),
            ):
                for radius in dataset["amplitude"].values[dataset["kind"].values == number]:
                    z = float(radius) * length * turn
                    found.append((z.real, z.imag, word, colour, "-"))
        elif {"amplitude", "branch"} <= names:
            found += _whirls_at(dataset, given, length, turn)
        else:
            raise InputError(
                "beneath must be a limit cycle, backward whirls or synchronous whirls, got "
                f"{dataset.attrs.get('title', 'another dataset')!r}"
            )
    return [each for each in found if np.isfinite(each[0]).all()]


def _whirls_at(
    whirls: xr.Dataset, given: xr.Dataset, length: float, turn: npt.NDArray[np.complex128]
) -> list[tuple[Values, Values, str, str, object]]:
    """Return the circles of synchronous whirls, those at the speed of the run if that is known."""
    several = whirls.sizes.get("omega", 0) > 1
    if several and "omega" in given.variables and not given["omega"].ndim:
        whirls = whirls.sel(omega=float(given["omega"]))
    unstable = flags_of(whirls["stability"])["unstable"]
    radii = whirls["amplitude"].values.ravel() * length
    looks = [
        ("unstable whirl", GREY, DASHES) if kind == unstable else ("exact whirl", PURPLE, "-")
        for kind in whirls["stability"].values.ravel()
    ]
    # without a shaft the centre of a whirl that never touches may be anywhere
    free = (whirls["in_contact"].values.ravel() == 0) & ("shaft_stiffness" not in whirls.variables)
    middle = centre_line(given).isel(window=-1) if free.any() else None
    centre = 0j if middle is None else complex(middle["offset_x"], middle["offset_y"])
    circles = (centre * loose + radius * turn for radius, loose in zip(radii, free, strict=True))
    return [(z.real, z.imag, *each) for z, each in zip(circles, looks, strict=True)]


def _is_of_one_speed(given: xr.Dataset) -> bool:
    """Return whether the speed of a run or of signals stays the same, or is not known."""
    record = record_of(given)
    if record.angles is None:
        return True
    places = np.unique(np.linspace(0, record.times.size - 1, FEW_SPEEDS).astype(int))
    return is_one_speed(np.diff(record.angles[places]) / np.diff(record.times[places]))


def _centres_of(beneath: Beneath, held: xr.Dataset, units: Units) -> list[tuple[complex, str, str]]:
    """Return exact mean positions in the unit of the signals, with their words and markers."""
    found = []
    for dataset in list_of(beneath):
        check_parameters(dataset, held, skipped=("omega",))
        length, names = scales_of(dataset, held, units).length, set(dataset.variables)
        if "radial_frequency" in names:
            place = complex(dataset["x"], dataset["y"])
            found.append((place * length, "place of rest", "s"))
        elif "line_kind" in names:
            found.append((_mean_of(dataset) * length, f"mean of {CYCLE}", "D"))
        elif {"amplitude", "branch"} <= names:
            found.append((0j, "centre of whirls in contact", "o"))
        else:
            raise InputError(
                "beneath must be a place of rest, a limit cycle or synchronous whirls, got "
                f"{dataset.attrs.get('title', 'another dataset')!r}"
            )
    return found


def _mean_of(cycle: xr.Dataset) -> complex:
    """Return where a limit cycle is in the mean, at axes at rest: at its static line, or nowhere.

    Under a load, which alone makes that line, a cycle begins where the unbalance points along x.
    """
    if flags_of(cycle["line_kind"])["static"] not in cycle["line_kind"].values:
        return 0j
    omega = float(cycle["omega"]) / scale_of(cycle, "time")
    z = (cycle["x"].values + 1j * cycle["y"].values) * np.exp(1j * omega * cycle["t"].values)
    return complex(z[:-1].mean())


def _cycle_in_plane(cycle: xr.Dataset) -> npt.NDArray[np.complex128]:
    """Return the orbit of a limit cycle on axes at rest, until it closes or has filled its ring."""
    omega = float(cycle["omega"]) / scale_of(cycle, "time")
    times = cycle["t"].values
    once = (cycle["x"].values + 1j * cycle["y"].values) * np.exp(1j * omega * times)
    turns = omega * float(times[-1]) / (2.0 * math.pi) * np.arange(1, MOST_PERIODS + 1)
    closed = np.flatnonzero(np.abs(turns - np.round(turns)) < CLOSED)
    count = int(closed[0]) + 1 if closed.size else MOST_PERIODS
    return np.concatenate([once * np.exp(1j * omega * times[-1] * each) for each in range(count)])
