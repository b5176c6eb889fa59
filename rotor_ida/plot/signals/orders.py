"""Orders over the speed: Bode plots, polar plots, order tracks."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any, NamedTuple, cast

import numpy as np
import numpy.typing as npt
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from rotor_ida.arrays import Values
from rotor_ida.errors import InputError
from rotor_ida.plot import palette
from rotor_ida.plot.appearance import drawing, new_figure, style
from rotor_ida.plot.datasets import check_dataset, hold_units, parameters_in
from rotor_ida.plot.labels import LABELS, label_axis, label_of
from rotor_ida.plot.legends import legend_below, own_legend
from rotor_ida.plot.signals.beneath import Beneath, Response, responses_of
from rotor_ida.plot.signals.exact_motion import is_of_one_speed
from rotor_ida.plot.signals.speeds import legs_of, mark_speeds, title_of_signals
from rotor_ida.plot.signals.units import Units, is_one_speed, units_of
from rotor_ida.signals.orders import SEEN, check_orders, one_order, revolutions_for
from rotor_ida.signals.orders import orders as tracked
from rotor_ida.signals.peaks import peaks_of
from rotor_ida.signals.record import lacks_mark, record_of

WHIRLS, PROBES = ("forward", "backward"), ("x", "y")
# Peaks of at least this fraction of the largest amplitude are named.
HIGH = 0.3
# A jump between windows exceeds this fraction of the largest amplitude, and this multiple of the
# median of this number of steps around it. At a sharp resonance several neighbouring steps are
# large, so that their median is large too and none of them is a jump.
JUMP, UNUSUAL, NEIGHBOURS = 0.1, 5.0, 7
# On a linear scale an order below the second fraction of the largest amplitude lies flat on 0; on a
# logarithmic one what is below the first is not shown.
LEAST, FLAT = 1e-4, 0.05
# Fewest windows of a curve and of a record at one speed, and the most revolutions of one. An even
# number of revolutions contains no part of a period of ½X.
WINDOWS, AT_ONE_SPEED, LONGEST = 250, 8, 8
# Errors are drawn if, in more than a tenth of the windows, twice the error is more than this
# fraction of the largest amplitude. A simulated run has no noise: its amplitude does change.
NOTABLE, IN_MOST = 0.03, 0.9


class Track(NamedTuple):
    """One order of a whirl or a probe over the windows, and how it is drawn."""

    title: str
    units: Units
    speeds: xr.DataArray
    amplitude: Values
    lag: Values
    error: Values
    words: str
    exact: list[Response]
    simulated: bool
    # of a probe: its angle [degree], and its whole reading peak to peak
    angle: float = math.nan
    direct: Values = np.empty(0)

    @property
    def marker(self) -> str:
        """Return the marker of a window: the line of one speed would be too short to see."""
        return "o" if is_one_speed(self.speeds.values) else ""

    @property
    def is_noise(self) -> npt.NDArray[np.bool_]:
        """Return the windows of measured signals in which the lag is that of noise."""
        return (self.amplitude < SEEN * self.error) & (not self.simulated)

    @property
    def label(self) -> str:
        """Return the label of the amplitude: of a whirl zero to peak, of a probe peak to peak."""
        words = None if math.isnan(self.angle) else "vibration, peak to peak"
        return label_of("whirl_amplitude", self.units.lengths(self.amplitude), words=words)


def plot_bode(
    signals: xr.Dataset, *, order: float = 1.0, sense: str = "forward", orders: npt.ArrayLike = (),
    revolutions: int | None = None, beneath: Beneath = (), axes: Sequence[Axes] | None = None,
) -> Figure:  # fmt: skip
    r"""Draw amplitude and phase of one order over the speed.

    Parameters
    ----------
    signals : Dataset
        Signals, a run or run-up, or the result of `rotor_ida.orders`.
    order : float
        Multiple of the speed [dimensionless].
    sense : {"forward", "backward", "x", "y"}
        The whirl shown, zero to peak, or the probe whose reading is shown, peak to peak, beside its
        direct amplitude, that of all orders. Probes of a run look along x and y.
    orders : array_like, optional
        Further orders to fit together with this one [dimensionless]. What else turns at a steady
        multiple of the speed, such as ½X, then does not leak into it.
    revolutions : int, optional
        Length of the windows [dimensionless]. Default: up to 8 revolutions that leave at least 250
        windows, or 8 windows at one speed, but as many as separate the orders.
    beneath : Dataset or sequence of Dataset
        Exact results under the order 1 forward: of
        `rotor_ida.closed_forms.response_curve`, `rotor_ida.synchronous_response`,
        `rotor_ida.folds`, `rotor_ida.hopf_points` and `rotor_ida.limit_cycle`, dimensionless
        or converted by `rotor_ida.dimensional`. Dimensionless ones get the units of the signals
        if these contain the scales of the machine.
    axes : sequence of two Axes, optional
        Where to draw amplitude and phase; by default the axes of a new figure.

    Returns
    -------
    Figure
        That of the axes of amplitude and phase.

    Notes
    -----
    The phase is the lag of the whirl behind the mark on the shaft, which for a run is the
    unbalance: 0 below and 180° above a resonance. That of a probe is the angle from the mark to
    the next positive peak of its reading. Peaks of measured signals have their speed and
    amplification factor, as in `rotor_ida.bode_peaks`. The line breaks at a jump of the whirl, and
    a window that spans a jump is left out. So is the lag of a measured amplitude below two standard
    errors, as after a slow roll has been subtracted. A band shows two standard errors of measured
    signals if these are more than 3 % of the largest amplitude in a tenth of the windows.

    Examples
    --------
    >>> from rotor_ida import Rotor, run_up
    >>> from rotor_ida.closed_forms import response_curve
    >>> up = run_up(Rotor(omega=0.3, zeta=0.07, delta0=0.5), start=(0, 0, 0, 0), to=2.5,
    ...             rate=0.005, samples=20_001)
    >>> exact = response_curve(zeta=0.07, delta0=0.5, limits=(0.3, 2.5))
    >>> [ax.get_ylabel() for ax in plot_bode(up, beneath=exact).axes]
    ['whirl amplitude, zero to peak $|c|$', 'phase lag $\\theta$ [°]']
    """
    one = _track(signals, order, sense, beneath, orders, revolutions)
    speeds, amplitude = one.speeds, one.amplitude
    with style():
        upper, lower = _pair_of(axes)
        angles, wraps = unwound(one.lag, amplitude)
        jumps = jumps_of(amplitude, one.lag)
        angles[one.is_noise] = np.nan
        for response in one.exact:
            response.draw_amplitude(upper)
            response.draw_phase(lower, around=float(np.nanmedian(angles)))
        for part, words, colour, dashes in legs_of(speeds.values, one.words):
            for ax, up, breaks in ((upper, amplitude, jumps), (lower, angles, jumps | wraps)):
                ax.plot(*_broken(speeds.values, up, breaks, part), color=colour, ls=dashes, lw=1.1,
                        marker=one.marker, ms=3.0, label=words, zorder=3.2)  # fmt: skip
        _draw_errors(upper, lower, one, angles, jumps | wraps)
        named = _name_peaks(upper, one)
        for part, _, colour, _ in legs_of(speeds.values, "") if one.direct.size else ():
            upper.plot(speeds.values[part], one.direct[part], color=colour, lw=0.7, alpha=0.6,
                       ls=(0, (1, 1)), marker=one.marker, ms=2.0, label="direct (all orders)",
                       zorder=2.9)  # fmt: skip
        hold_units(upper.yaxis, one.units.lengths(amplitude))
        upper.set_ylabel(one.label)
        _label_degrees(lower)
        if lacks_mark(signals.attrs):
            lower.set_ylabel(f"{lower.get_ylabel()}\n(origin unknown)")
        for ax in (upper, lower):
            label_axis(ax.xaxis, "speed", speeds)
            _speed_limits(ax, speeds.values)
        upper.set_ylim(0.0, max(1.06 * _highest(upper), 1.12 * named))
        upper.set_xlabel("")
        upper.tick_params(labelbottom=False)
        upper.set_title(one.title)
        own_legend(upper, inside=True)
    return cast(Figure, upper.figure)


def plot_polar(
    signals: xr.Dataset, *, order: float = 1.0, sense: str = "forward", orders: npt.ArrayLike = (),
    revolutions: int | None = None, beneath: Beneath = (), ax: Axes | None = None,
) -> Axes:  # fmt: skip
    r"""Draw amplitude and phase of one order as a vector, with marks of the speed.

    Parameters
    ----------
    signals, order, sense, orders, revolutions, beneath
        As in `plot_bode`.
    ax : Axes, optional
        Polar axes to draw on and return; default: those of a new figure.

    Notes
    -----
    The lag grows clockwise from the x axis, against the counterclockwise rotation. The vector
    points to the high spot when the mark on the shaft passes the x axis. For a probe the angle 0 is
    where the probe is, and the vector points to the high spot at the pulse of the keyphasor.

    Examples
    --------
    >>> from rotor_ida import Rotor, run_up
    >>> up = run_up(Rotor(omega=0.3, zeta=0.07, delta0=0.5), start=(0, 0, 0, 0), to=2.5,
    ...             rate=0.005, samples=20_001)
    >>> ax = plot_polar(up)
    >>> ax.name, ax.get_theta_direction().item()
    ('polar', -1.0)
    """
    one = _track(signals, order, sense, beneath, orders, revolutions)
    speeds, amplitude, lag = one.speeds, one.amplitude, one.lag
    apart, jumps = 0.1 * float(amplitude.max()), jumps_of(amplitude, lag)
    with style():
        polar = _polar_axes(ax)
        polar.set_theta_direction(-1)
        polar.set_theta_zero_location("E", offset=0.0 if math.isnan(one.angle) else one.angle)
        for response in one.exact:
            response.draw_polar(polar)
        for part, words, colour, dashes in legs_of(speeds.values, one.words):
            polar.plot(*_broken(lag, amplitude, jumps, part), color=colour, ls=dashes, lw=1.1,
                       marker=one.marker, ms=3.0, label=words, zorder=3.2)  # fmt: skip
            z = amplitude[part] * np.exp(1j * lag[part])
            mark_speeds(polar, z, speeds[part], colour, apart=apart)
        polar.set_rlim(0.0, 1.08 * float(amplitude.max()))
        polar.set_rlabel_position(202.5)
        polar.tick_params(axis="y", labelsize=7.5)
        polar.set_xlabel(_words_of_polar(one), labelpad=8.0, fontsize=8.0)
        # above the label of the angle, in whatever order the two are laid out
        polar.set_title(one.title, y=1.0, pad=20.0)
        legend_below(polar, columns=3)
    return cast(Axes, polar)


def plot_orders(
    signals: xr.Dataset, *, orders: npt.ArrayLike = (0.5, 1.0, 2.0),
    revolutions: int | None = None, logarithmic: bool | None = None, beneath: Beneath = (),
    ax: Axes | None = None,
) -> Axes:  # fmt: skip
    r"""Draw the amplitudes of several orders, forward and backward, over the speed.

    Parameters
    ----------
    signals : Dataset
        As in `plot_bode`.
    orders : array_like, shape (k,)
        Multiples of the speed [dimensionless]; for a result of `rotor_ida.orders` all are shown.
    revolutions
        As in `plot_bode`.
    logarithmic : bool
        Whether the amplitude scale is logarithmic; by default if the largest amplitude of an
        order is between 1e-4 and 0.05 of the largest of all.
    beneath
        As in `plot_bode`: under the order 1 forward.
    ax : Axes, optional
        Axes to draw on and return; default: those of a new figure.

    Examples
    --------
    >>> from rotor_ida import Rotor, run_up
    >>> up = run_up(Rotor(omega=0.3, zeta=0.07, delta0=0.5), start=(0, 0, 0, 0), to=2.5,
    ...             rate=0.005, samples=20_001)
    >>> [text.get_text() for text in plot_orders(up, orders=[1]).get_legend().get_texts()]
    ['1X forward', '1X backward']
    """
    tracks = tracks_of(signals, orders, revolutions)
    units = units_of(tracks, "forward_whirl_amplitude", "speed")
    speeds = units.speeds(tracks["speed"].values)
    with drawing(ax) as ax:
        for response in responses_of(beneath, tracks, units):
            response.draw_amplitude(ax)
        largest: list[float] = []
        for number, order in enumerate(tracks["order"].values.tolist()):
            colour, dashes = palette.look(number + 1)
            for sense in WHIRLS:
                amplitude = tracks[f"{sense}_whirl_amplitude"].values[..., number]
                largest.append(float(amplitude.max()))
                ax.plot(speeds, amplitude, color=colour, lw=1.1, zorder=3.2,
                        ls="-" if order == 1.0 else dashes, ms=3.0, mfc="white", mew=0.7,
                        marker="" if sense == "forward" else "v",
                        markevery=(0.02 * (number + 1), 0.08),
                        label=_words(order, sense))  # fmt: skip
        label_axis(ax.xaxis, "speed", speeds)
        label_axis(ax.yaxis, "whirl_amplitude", units.lengths(speeds))
        _speed_limits(ax, speeds.values)
        highest = max(largest)
        if logarithmic is None:
            logarithmic = any(LEAST * highest < each < FLAT * highest for each in largest)
        if logarithmic:
            ax.set_yscale("log")
            ax.set_ylim(LEAST * highest, 2.0 * highest)
        else:
            ax.set_ylim(0.0, 1.06 * _highest(ax))
        ax.set_title(title_of_signals(tracks, speeds))
        legend_below(ax, columns=4)
    return ax


def tracks_of(
    signals: xr.Dataset, orders: npt.ArrayLike, revolutions: int | None = None
) -> xr.Dataset:
    """Return orders, tracked if necessary.

    A long record uses windows of several revolutions, which suppress other frequencies better.
    """
    given = check_dataset("signals", signals, ())
    if "forward_whirl_amplitude" in given.variables:
        return given
    if revolutions is None:
        angles = record_of(given).known_angles()
        turns = float(angles[-1] - angles[0]) / (2.0 * math.pi)
        fewest = AT_ONE_SPEED if is_of_one_speed(given) else WINDOWS
        length = min(int(turns / fewest), LONGEST)
        revolutions = max(length - length % 2, revolutions_for(check_orders(orders), None))
    return tracked(given, orders, revolutions=revolutions)


def order_words(order: float) -> str:
    """Return the usual name of an order.

    Examples
    --------
    >>> order_words(1.0), order_words(0.5), order_words(-1.0), order_words(0.47)
    ('1X', '½X', '−1X', '0.47X')
    """
    fractions = {0.5: "½", 0.25: "¼", 1.5: "1½"}
    size = abs(order)
    number = fractions.get(size, f"{size:g}")
    return f"{'−' if order < 0.0 else ''}{number}X"


def unwound(lag: Values, amplitude: Values) -> tuple[Values, npt.NDArray[np.bool_]]:
    """Return lags in degrees about their mean, and the points before which a line breaks.

    The mean, weighted by amplitude, lies from 0 to 360, and the lags within 180 of it.
    """
    mean = math.degrees(np.angle((amplitude * np.exp(1j * lag)).sum())) % 360.0
    angles = mean + (np.degrees(lag) - mean + 180.0) % 360.0 - 180.0
    return angles, np.append(False, np.abs(np.diff(angles)) > 180.0)


def jumps_of(amplitude: Values, lag: Values) -> npt.NDArray[np.bool_]:
    """Return the windows before which the whirl vector jumps.

    A window that spans a jump lies between two jumps: it averages two motions.

    Examples
    --------
    >>> one = np.array([1.0, 1.1, 1.2, 1.3, 1.4, 0.9, 0.3, 0.3, 0.3, 0.3])
    >>> np.flatnonzero(jumps_of(one, np.zeros(10)))
    array([5, 6])
    """
    from scipy.ndimage import median_filter  # noqa: PLC0415 - takes long to import

    if amplitude.size < 2:
        return np.zeros(amplitude.size, dtype=bool)
    steps = np.abs(np.diff(amplitude * np.exp(-1j * lag)))
    usual = median_filter(steps, size=min(NEIGHBOURS, steps.size), mode="nearest")
    least = np.maximum(JUMP * amplitude.max(initial=0.0), UNUSUAL * usual)
    return np.append(False, steps > least)


def _track(
    signals: xr.Dataset, order: float, sense: str, beneath: Beneath, orders: npt.ArrayLike,
    revolutions: int | None,
) -> Track:  # fmt: skip
    """Return one order of signals, with exact results for the order 1 forward only."""
    beside = np.atleast_1d(orders)
    tracks = tracks_of(signals, np.append(order, beside[beside != order]), revolutions)
    units = units_of(tracks, "forward_whirl_amplitude", "speed")
    one = one_order(tracks, order, sense)
    exact = responses_of(beneath, tracks, units)
    if exact and (order, sense) != (1.0, "forward"):
        raise InputError(f"beneath goes under the order 1 forward, got {order:g} {sense}")
    speeds = units.speeds(tracks["speed"].values)
    track = Track(
        title_of_signals(tracks, speeds), units, speeds, *one, _words(order, sense), exact,
        bool(parameters_in(tracks)),
    )  # fmt: skip
    if sense not in PROBES:
        return track
    seen = tracks.isel(probe_angle=PROBES.index(sense))
    angle = float(seen["probe_angle"])
    words = f"{order_words(order)} of the probe at {angle:g}°"
    return track._replace(words=words, angle=angle, direct=seen["direct_peak_to_peak"].values)


def _draw_errors(
    upper: Axes, lower: Axes, one: Track, angles: Values, breaks: npt.NDArray[np.bool_]
) -> None:
    """Draw bands of two standard errors of amplitude and lag, unless these are small."""
    amplitude, error = one.amplitude, 2.0 * one.error
    if one.simulated or np.quantile(error, IN_MOST) <= NOTABLE * amplitude.max():
        return
    lags = np.degrees(np.arctan2(error, amplitude))
    width = 4.0 if one.marker else 0.0
    for part, _, colour, _ in legs_of(one.speeds.values, one.words):
        for ax, middle, half in ((upper, amplitude, error), (lower, angles, lags)):
            across, low = _broken(one.speeds.values, middle - half, breaks, part)
            _, high = _broken(one.speeds.values, middle + half, breaks, part)
            ax.fill_between(across, low, high, facecolor=colour, edgecolor=colour, alpha=0.25,
                            lw=width, label="two standard errors", zorder=3.0)  # fmt: skip


def _words(order: float, sense: str) -> str:
    return f"{order_words(order)} {sense}"


def _broken(
    across: Values, up: Values, breaks: npt.NDArray[np.bool_], part: slice
) -> tuple[Values, Values]:
    """Return a part of a line with gaps at its breaks.

    A point between two gaps is left out: no line shows it, but it would widen the axis.
    """
    at = np.flatnonzero(breaks[part])
    at = at[at > 0]
    ends = np.concatenate([[0], at, [across[part].size]])
    alone = ends[:-1][np.diff(ends) == 1]
    drawn = up[part].copy()
    drawn[alone] = np.nan
    return np.insert(across[part], at, np.nan), np.insert(drawn, at, np.nan)


def _speed_limits(ax: Axes, speeds: Values) -> None:
    """Set the range of speeds, widened if there is only one speed."""
    low, high = float(speeds.min()), float(speeds.max())
    room = 0.05 * high if is_one_speed(speeds) else 0.02 * (high - low)
    ax.set_xlim(max(0.0, low - room), high + room)


def _highest(ax: Axes) -> float:
    """Return the largest value within the speeds shown; 1 if there is none."""
    low, high = ax.get_xlim()
    heights = [0.0]
    for line in ax.get_lines():
        across, up = (np.asarray(each, dtype=np.float64) for each in line.get_data())
        heights.append(
            float(np.nan_to_num(up[(across >= low) & (across <= high)]).max(initial=0.0))
        )
    return max(heights) or 1.0


def _label_degrees(ax: Axes) -> None:
    ax.set_ylabel(f"{LABELS['phase_lag']} [°]")
    ax.yaxis.set_major_locator(MaxNLocator(steps=[1, 1.5, 3, 4.5, 9, 10], nbins=7))
    low, high = ax.get_ylim()
    ax.set_ylim(min(low, 0.0) if low > -30.0 else low, max(high, 180.0))


def _pair_of(axes: Sequence[Axes] | None) -> tuple[Axes, Axes]:
    if axes is None:
        figure = new_figure(5.4, 5.0)
        upper, lower = figure.subplots(2, 1, sharex=True, height_ratios=(1.6, 1.0))
        return upper, lower
    given = list(axes)
    if len(given) != 2 or not all(isinstance(each, Axes) for each in given):
        raise InputError(f"axes must be two matplotlib Axes, got {len(given)}")
    return given[0], given[1]


def _polar_axes(ax: Axes | None) -> Any:
    if ax is None:
        return new_figure(4.6, 5.6).add_subplot(projection="polar")
    if getattr(ax, "name", "") != "polar":
        raise InputError("ax must be polar: figure.add_subplot(projection='polar') makes it")
    return ax


def _name_peaks(ax: Axes, one: Track) -> float:
    """Write speed and amplification factor above each peak of measured signals.

    Return the height of the highest of them.
    """
    above = 0.0
    rising = np.argsort(one.speeds.values, kind="stable")
    if one.simulated or one.units.rate is None:
        return above
    for peak in peaks_of(one.speeds.values[rising], one.amplitude[rising], one.error[rising]):
        if peak.amplitude > HIGH * one.amplitude.max():
            words = f"{peak.speed:,.0f} rpm, AF {peak.amplification:.1f}"
            near = np.argmin(np.abs(one.speeds.values - peak.speed))
            height = max(peak.amplitude, one.direct[near] if one.direct.size else 0.0)
            ax.annotate(words, (peak.speed, height), xytext=(0, 4), textcoords="offset points",
                        fontsize=7.5, ha="center", va="bottom", zorder=3.6,
                        bbox={"fc": "white", "ec": "none", "alpha": 0.8, "pad": 1.0})  # fmt: skip
            above = max(above, height)
    return above


def _words_of_polar(one: Track) -> str:
    """Return the legend text of circles, angle and dots of a polar plot."""
    unit = "[rpm]" if one.units.rate is not None else r"$\omega$"
    start = "against the rotation" if math.isnan(one.angle) else "from the probe"
    return f"{one.label}; lag clockwise, {start}; dots: speed {unit}"
