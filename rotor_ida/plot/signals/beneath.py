"""Exact results beneath a plot of signals: curves, whirls, special points, lines of cycles."""

from __future__ import annotations

import math
from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple, TypeVar

import numpy as np
import numpy.typing as npt
import xarray as xr
from matplotlib.axes import Axes

from rotor_ida.arrays import Values
from rotor_ida.errors import InputError
from rotor_ida.plot import legends, palette
from rotor_ida.plot.appearance import draw_marks
from rotor_ida.plot.datasets import check_dataset, parameters_in
from rotor_ida.plot.responses import CURVE, draw_curve
from rotor_ida.plot.signals.units import Scales, Units, scales_of
from rotor_ida.schema import flags_of, words_of

Beneath = xr.Dataset | Sequence[xr.Dataset]
T = TypeVar("T")
# Results that can lie beneath a plot, and the variables that identify them; the first match counts.
KINDS = {
    "curve": CURVE,
    "folds": ("fold_omega", "fold_amplitude"),
    "hopf_points": ("hopf_omega", "hopf_amplitude"),
    "cycle": ("line_kind", "whirl_amplitude"),
    "backward_whirl": ("amplitude", "whirl_speed", "kind"),
    "whirls": ("amplitude", "branch", "phase_lag"),
    "rest": ("radial_frequency", "x", "y"),
    "motion": ("t", "x", "y"),
}
CYCLE = "exact cycle"
# Lines of a cycle weaker than this fraction of the strongest are left out.
WEAKEST = 1e-4
BACKWARD = {
    "slipping": ("exact slipping whirl", palette.GREY),
    "rolling": ("exact dry whip", palette.DARK_BROWN),
}
# Words and marks of special points.
SPECIAL = {"fold": (legends.FOLD, "D"), "hopf": (legends.HOPF, "o")}


def made_beneath(
    beneath: Beneath, shown: xr.Dataset, units: Units,
    makers: Mapping[str, Callable[[xr.Dataset, Scales], list[T]]], allowed: str, *,
    of_any_speed: Collection[str] = tuple(KINDS),
) -> list[T]:  # fmt: skip
    """Convert exact results to the units of a plot; refuse other kinds.

    Parameters
    ----------
    beneath : Dataset or sequence of Dataset
        The exact results.
    shown : Dataset
        Signals shown above them.
    units : Units
        The units of the picture.
    makers : mapping of str to callable
        Converter for each kind of result.
    allowed : str
        The kinds in words, for the message.
    of_any_speed : collection of str
        Kinds that may have another speed than the signals.
    """
    made: list[T] = []
    # curves first: other points take their lags from them
    for dataset in sorted(list_of(beneath), key=lambda each: _kind_of(each) != "curve"):
        kind = _kind_of(dataset)
        if kind not in makers:
            title = dataset.attrs.get("title", "another dataset")
            raise InputError(f"beneath must be {allowed}, got {title!r}")
        _check_parameters(dataset, shown, () if kind not in of_any_speed else ("omega",))
        made += makers[kind](dataset, scales_of(dataset, shown, units))
    return made


def _kind_of(dataset: xr.Dataset) -> str:
    names = set(dataset.variables)
    return next((kind for kind, needed in KINDS.items() if names.issuperset(needed)), "other")


def list_of(beneath: Beneath) -> list[xr.Dataset]:
    """Return one dataset or several as a list."""
    if not isinstance(beneath, xr.Dataset | Sequence):
        raise InputError(
            f"beneath must be a Dataset or several in a list, got {type(beneath).__name__}"
        )
    listed = [beneath] if isinstance(beneath, xr.Dataset) else list(beneath)
    return [check_dataset("beneath", each, ()) for each in listed]


def _check_parameters(exact: xr.Dataset, shown: xr.Dataset, skipped: Sequence[str]) -> None:
    """Refuse exact results of another rotor than the signals, if both contain parameters."""
    for name in parameters_in(exact):
        if name in shown.variables and name not in skipped:
            here, there = np.atleast_1d(exact[name].values), float(shown[name])
            if there not in here:
                raise InputError(
                    f"beneath must have the {name} of the signals, {there!r}, got "
                    f"{float(here[0])!r}"
                )


@dataclass(frozen=True, slots=True)
class Response:
    """An exact response at the spin speed, in the units of a picture.

    Parameters
    ----------
    curve : Dataset or None
        A response curve.
    speeds, amplitudes, lags : ndarray
        Points beside: whirls at given speeds, folds, Hopf points. Lags [degree] may be NaN.
    marker, words : str
        Style and name of the points.
    filled : ndarray of bool
        Which points are filled (stable).
    """

    curve: xr.Dataset | None
    speeds: Values
    amplitudes: Values
    lags: Values
    marker: str = ""
    words: str = ""
    filled: npt.NDArray[np.bool_] | None = None

    def draw_amplitude(self, ax: Axes) -> None:
        """Draw amplitudes over the speed."""
        if self.curve is not None:
            draw_curve(ax, self.curve, over="omega", quantity="amplitude")
        self._points(ax, self.speeds, self.amplitudes)

    def draw_phase(self, ax: Axes, *, around: float) -> None:
        """Draw lags over the speed, within half a turn of what is shown."""
        if self.curve is not None:
            turned = self.curve.assign(phase_lag=_near(self.curve["phase_lag"], around))
            draw_curve(ax, turned, over="omega", quantity="phase_lag")
        self._points(ax, self.speeds, _near(self.lags, around))

    def draw_polar(self, ax: Any) -> None:
        """Draw amplitudes over lags."""
        if self.curve is not None:
            turned = self.curve.assign(phase_lag=np.radians(self.curve["phase_lag"]))
            draw_curve(ax, turned, over="phase_lag", quantity="amplitude")
        self._points(ax, np.radians(self.lags), self.amplitudes)

    def _points(self, ax: Any, across: Values, up: Values) -> None:
        shown = np.isfinite(across + up)
        filled = np.zeros(shown.shape, dtype=bool) if self.filled is None else self.filled
        for chosen, face in ((shown & filled, palette.INK), (shown & ~filled, "white")):
            if chosen.any():
                draw_marks(ax, across[chosen], up[chosen], self.marker, palette.INK, size=4.4,
                           face=face, label=self.words, level=3.7)  # fmt: skip


def responses_of(beneath: Beneath, shown: xr.Dataset, units: Units) -> list[Response]:
    """Return exact results for an order over the speed; refuse other kinds."""
    curves: list[xr.Dataset] = []

    def curve(dataset: xr.Dataset, scales: Scales) -> list[Response]:
        drawn = _curve(dataset, scales, units)
        curves.append(drawn)
        nothing = np.empty(0)
        return [Response(drawn, nothing, nothing, nothing)]

    makers = {
        "curve": curve,
        "folds": lambda each, scales: [_special("fold", each, scales, units, curves, shown)],
        "hopf_points": lambda each, scales: [_special("hopf", each, scales, units, curves, shown)],
        "whirls": lambda each, scales: [_whirls(each, scales, units)],
        "cycle": lambda each, scales: [_cycle(each, scales, units)],
    }
    allowed = "a response curve, whirls, folds, Hopf points or a limit cycle"
    return made_beneath(beneath, shown, units, makers, allowed)


def _curve(curve: xr.Dataset, scales: Scales, units: Units) -> xr.Dataset:
    """Return a response curve in the units of a picture, with lags in degrees."""
    speeds = units.speeds(curve["omega"].values * scales.omega).values
    return curve.assign(
        omega=(curve["omega"].dims, speeds),
        amplitude=curve["amplitude"] * scales.length,
        phase_lag=np.degrees(curve["phase_lag"]),
    )


def _special(
    name: str, dataset: xr.Dataset, scales: Scales, units: Units, curves: Sequence[xr.Dataset],
    shown: xr.Dataset,
) -> Response:  # fmt: skip
    """Return folds or Hopf points, with lags from a curve."""
    words, marker = SPECIAL[name]
    speeds = units.speeds(dataset[f"{name}_omega"].values.ravel() * scales.omega).values
    amplitudes = dataset[f"{name}_amplitude"].values.ravel() * scales.length
    if "speed" in shown.variables:  # points outside the plot are not in its legend either
        drawn = units.speeds(shown["speed"].values).values
        within = (speeds >= 0.98 * drawn.min()) & (speeds <= 1.02 * drawn.max())
        speeds, amplitudes = speeds[within], amplitudes[within]
    lags = np.array([_lag_on(curves, *each) for each in zip(speeds, amplitudes, strict=True)])
    return Response(None, speeds, amplitudes, lags, marker, words)


def _lag_on(curves: Sequence[xr.Dataset], speed: float, amplitude: float) -> float:
    """Return the lag of the nearest point on the curves; NaN if none is near."""
    best, lag = 0.02, math.nan
    for curve in curves:
        across, up = curve["omega"].values.ravel(), curve["amplitude"].values.ravel()
        apart = np.hypot(across / speed - 1.0, up / amplitude - 1.0)
        place = int(np.nanargmin(apart))
        if apart[place] < best:
            best, lag = float(apart[place]), float(curve["phase_lag"].values.ravel()[place])
    return lag


def _flat_whirls(
    whirls: xr.Dataset,
) -> tuple[Values, Values, Values, npt.NDArray[np.bool_]]:
    """Return speeds, amplitudes, lags and stability of whirls as flat arrays."""
    names = ("omega", "amplitude", "phase_lag", "stability")
    omega, amplitude, lag, stability = (
        each.values.ravel() for each in xr.broadcast(*(whirls[name] for name in names))
    )
    return omega, amplitude, lag, stability != flags_of(whirls["stability"])["unstable"]


def _whirls(whirls: xr.Dataset, scales: Scales, units: Units) -> Response:
    """Return the whirls at given speeds."""
    omega, amplitude, lag, stable = _flat_whirls(whirls)
    speeds = units.speeds(omega * scales.omega).values
    amplitude, lag = amplitude * scales.length, np.degrees(lag)
    return Response(None, speeds, amplitude, lag, "s", "exact whirl", stable)


def _cycle(cycle: xr.Dataset, scales: Scales, units: Units) -> Response:
    """Return amplitude and lag of a limit cycle at the spin speed: its mean on rotating axes."""
    spin = cycle["line_kind"].values == flags_of(cycle["line_kind"])["spin"]
    amplitude = np.atleast_1d(cycle["whirl_amplitude"].values[spin]) * scales.length
    speeds = units.speeds(np.full(amplitude.size, float(cycle["omega"])) * scales.omega).values
    z = cycle["x"].values[:-1] + 1j * cycle["y"].values[:-1]
    lag = math.degrees(-np.angle(z.mean())) if z.size else math.nan
    return Response(None, speeds, amplitude, np.full(amplitude.size, lag), "s", f"1X of {CYCLE}")


def _near(lags: Any, around: float) -> Any:
    """Return lags in degrees, shifted by whole turns to lie nearest to others."""
    middle = float(np.nanmedian(lags)) if np.isfinite(lags).any() else around
    return lags + 360.0 * round((around - middle) / 360.0)


class Line(NamedTuple):
    """An exact line of a spectrum: its frequency and amplitude in the units of a picture."""

    frequency: float
    amplitude: float
    words: str
    colour: str
    marker: str
    # speed at which it occurs; NaN if it belongs to none
    speed: float


def lines_of(
    beneath: Beneath, shown: xr.Dataset, units: Units, *, over_speed: bool = False
) -> list[Line]:
    """Return the exact lines of cycles and whirls; refuse results without lines.

    In a plot over the speed, also return folds and Hopf points, on the line of order 1.
    """

    def special(name: str, dataset: xr.Dataset, scales: Scales) -> list[Line]:
        return _special_lines(name, dataset, scales, units) if over_speed else []

    makers: dict[str, Callable[[xr.Dataset, Scales], list[Line]]] = {
        "curve": lambda _each, _scales: [],
        "folds": lambda each, scales: special("fold", each, scales),
        "hopf_points": lambda each, scales: special("hopf", each, scales),
        "cycle": lambda each, scales: _lines_of_cycle(each, scales, units),
        "backward_whirl": lambda each, scales: _lines_of_backward(each, scales, units),
        "whirls": lambda each, scales: _lines_of_whirls(each, scales, units),
    }
    allowed = "a limit cycle, backward whirls or synchronous whirls"
    return made_beneath(beneath, shown, units, makers, allowed)


def _lines_of_cycle(cycle: xr.Dataset, scales: Scales, units: Units) -> list[Line]:
    heights = np.atleast_1d(cycle["whirl_amplitude"].values) * scales.length
    places = units.frequencies(np.atleast_1d(cycle["frequency"].values) * scales.rate).values
    speed = float(units.speeds(float(cycle["omega"]) * scales.omega))
    return [
        Line(float(place), float(height), f"line of {CYCLE}", palette.PURPLE, "D", speed)
        for place, height in zip(places, heights, strict=True)
        if height > WEAKEST * heights.max() and place  # no mean is drawn as vibration
    ]


def _special_lines(name: str, dataset: xr.Dataset, scales: Scales, units: Units) -> list[Line]:
    """Return folds, or Hopf points with the two lines beside 1X of the cycle born there."""
    words, marker = SPECIAL[name]
    lines = []
    for place, omega in np.ndenumerate(dataset[f"{name}_omega"].values):
        if not math.isfinite(omega):
            continue
        height = float(dataset[f"{name}_amplitude"].values[place]) * scales.length
        rates = [omega]
        if name == "hopf":
            beside = float(dataset["hopf_frequency"].values[place])
            rates += [omega - beside, omega + beside]
        speed = float(units.speeds(omega * scales.omega))
        for rate in rates:
            frequency = float(units.frequencies(rate * scales.rate))
            lines.append(Line(frequency, height, words, palette.INK, marker, speed))
    return lines


def _lines_of_backward(whirls: xr.Dataset, scales: Scales, units: Units) -> list[Line]:
    speed = float(units.speeds(float(whirls["omega"]) * scales.omega))
    heights = whirls["amplitude"].values * scales.length
    frequencies = units.frequencies(whirls["whirl_speed"].values * scales.rate).values
    return [
        Line(float(frequency), float(height), *BACKWARD[kind], "v", speed)
        for frequency, height, kind in zip(
            frequencies, heights, words_of(whirls["kind"]), strict=True
        )
        if math.isfinite(height)
    ]


def _lines_of_whirls(whirls: xr.Dataset, scales: Scales, units: Units) -> list[Line]:
    omega, amplitude, _, stable = _flat_whirls(whirls)
    rates = omega * scales.omega
    return [
        Line(float(units.frequencies(rate)), float(height) * scales.length, "line of exact whirl",
             palette.INK, "s", float(units.speeds(rate)))
        for rate, height, kept in zip(rates, amplitude, stable, strict=True)
        if math.isfinite(height) and kept
    ]  # fmt: skip
