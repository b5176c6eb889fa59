"""Exact results under a picture of signals: curves, whirls, special points, lines of cycles."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import xarray as xr
from matplotlib.axes import Axes

from rotor_ida.arrays import Values
from rotor_ida.errors import InputError
from rotor_ida.plot.appearance import DARK_BROWN, FOLD, GREY, HOPF, INK, PURPLE
from rotor_ida.plot.responses import CURVE, draw_curve
from rotor_ida.plot.signals.units import Scales, Units, check_parameters, list_of, scales_of
from rotor_ida.schema import flags_of

CYCLE = "exact cycle"
# Of the strongest: lines of a cycle that are weaker are left out.
WEAKEST = 1e-4
WHIRLS = {"slipping": "slipping whirl", "rolling": "dry whip"}


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
        What the points look like, and are called.
    filled : ndarray of bool
        Which of them are filled: the stable ones.
    """

    curve: xr.Dataset | None
    speeds: Values
    amplitudes: Values
    lags: Values
    marker: str = ""
    words: str = ""
    filled: Values | None = None

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
        words = self.words
        for filled in (True, False):
            chosen = np.isfinite(across + up)
            if self.filled is not None:
                chosen &= self.filled == filled
            elif filled:
                continue
            if chosen.any():
                ax.plot(across[chosen], up[chosen], ls="", marker=self.marker, ms=4.4, mew=1.0,
                        mec=INK, mfc=INK if filled else "white", label=words,
                        zorder=3.7)  # fmt: skip
                words = "_"


def responses_of(
    beneath: xr.Dataset | Sequence[xr.Dataset], shown: xr.Dataset, units: Units
) -> list[Response]:
    """Return what can lie under an order over the speed; refuse what cannot."""
    datasets = list_of(beneath)
    curves = [each for each in datasets if set(CURVE) <= set(each.variables)]
    found = [_curve(each, shown, units) for each in curves]
    drawn = [each.curve for each in found if each.curve is not None]
    for dataset in datasets:
        if any(dataset is curve for curve in curves):
            continue
        names = set(dataset.variables)
        if "fold_omega" in names:
            found.append(_special(dataset, "fold", FOLD, "D", drawn, shown, units))
        elif "hopf_omega" in names:
            found.append(_special(dataset, "hopf", HOPF, "o", drawn, shown, units))
        elif {"amplitude", "branch", "phase_lag"} <= names:
            found.append(_whirls(dataset, shown, units))
        elif "line_kind" in names:
            found.append(_cycle(dataset, shown, units))
        else:
            raise InputError(
                "beneath must be a response curve, whirls, folds, Hopf points or a limit cycle, "
                f"got {dataset.attrs.get('title', 'another dataset')!r}"
            )
    return found


def _curve(curve: xr.Dataset, shown: xr.Dataset, units: Units) -> Response:
    """Return a response curve within the speeds that are shown."""
    scales = _scales(curve, shown, units)
    speeds = units.speeds(curve["omega"].values * scales.omega).values
    turned = curve.assign(
        omega=(curve["omega"].dims, speeds),
        amplitude=curve["amplitude"] * scales.length,
        phase_lag=np.degrees(curve["phase_lag"]),
    )
    nothing = np.empty(0)
    return Response(turned, nothing, nothing, nothing)


def _special(
    dataset: xr.Dataset, name: str, words: str, marker: str, curves: Sequence[xr.Dataset],
    shown: xr.Dataset, units: Units,
) -> Response:  # fmt: skip
    """Return folds or Hopf points, with the lags that a curve has there."""
    scales = _scales(dataset, shown, units)
    speeds = units.speeds(dataset[f"{name}_omega"].values.ravel() * scales.omega).values
    amplitudes = dataset[f"{name}_amplitude"].values.ravel() * scales.length
    if "speed" in shown.variables:  # what lies beyond the picture is not in its legend either
        seen = units.speeds(shown["speed"].values).values
        within = (speeds >= 0.98 * seen.min()) & (speeds <= 1.02 * seen.max())
        speeds, amplitudes = speeds[within], amplitudes[within]
    lags = np.array([_lag_on(curves, *each) for each in zip(speeds, amplitudes, strict=True)])
    return Response(None, speeds, amplitudes, lags, marker, words)


def _lag_on(curves: Sequence[xr.Dataset], speed: float, amplitude: float) -> float:
    """Return the lag of the point of the curves next to one of them; NaN where none is near."""
    best, lag = 0.02, math.nan
    for curve in curves:
        across, up = curve["omega"].values.ravel(), curve["amplitude"].values.ravel()
        apart = np.hypot(across / speed - 1.0, up / amplitude - 1.0)
        place = int(np.nanargmin(apart))
        if apart[place] < best:
            best, lag = float(apart[place]), float(curve["phase_lag"].values.ravel()[place])
    return lag


def _whirls(dataset: xr.Dataset, shown: xr.Dataset, units: Units) -> Response:
    """Return the whirls at given speeds."""
    scales = _scales(dataset, shown, units)
    omega, amplitude, lag, stability = (
        each.values.ravel()
        for each in xr.broadcast(
            dataset["omega"], dataset["amplitude"], dataset["phase_lag"], dataset["stability"]
        )
    )
    stable = stability != flags_of(dataset["stability"])["unstable"]
    speeds = units.speeds(omega * scales.omega).values
    return Response(
        None, speeds, amplitude * scales.length, np.degrees(lag), "s", "exact whirl", stable
    )


def _cycle(cycle: xr.Dataset, shown: xr.Dataset, units: Units) -> Response:
    """Return the part of a limit cycle at the spin speed, with its lag: its mean as it turns."""
    scales = _scales(cycle, shown, units)
    spin = cycle["line_kind"].values == flags_of(cycle["line_kind"])["spin"]
    amplitude = np.atleast_1d(cycle["whirl_amplitude"].values[spin]) * scales.length
    speeds = units.speeds(np.full(amplitude.size, float(cycle["omega"])) * scales.omega).values
    z = cycle["x"].values[:-1] + 1j * cycle["y"].values[:-1]
    lag = math.degrees(-np.angle(z.mean())) if z.size else math.nan
    return Response(None, speeds, amplitude, np.full(amplitude.size, lag), "s", f"1X of {CYCLE}")


def _scales(exact: xr.Dataset, shown: xr.Dataset, units: Units) -> Scales:
    check_parameters(exact, shown, skipped=("omega",))
    return scales_of(exact, shown, units)


def _near(lags: Any, around: float) -> Any:
    """Return lags in degrees, all moved by the whole turns that bring them nearest to others."""
    middle = float(np.nanmedian(lags)) if np.isfinite(lags).any() else around
    return lags + 360.0 * round((around - middle) / 360.0)


@dataclass(frozen=True, slots=True)
class Line:
    """An exact line of a spectrum: its frequency and amplitude in the units of a picture."""

    frequency: float
    amplitude: float
    words: str
    colour: str
    marker: str
    # at which speed it is; NaN where it is told by none
    speed: float


def lines_of(
    beneath: xr.Dataset | Sequence[xr.Dataset],
    shown: xr.Dataset,
    units: Units,
    *,
    over_speed: bool = False,
) -> list[Line]:
    """Return the exact lines of cycles and whirls; refuse what has none.

    In a picture over the speed also folds and Hopf points, on the line of order 1.
    """
    found: list[Line] = []
    for dataset in list_of(beneath):
        check_parameters(dataset, shown, skipped=("omega",))
        scales, names = scales_of(dataset, shown, units), set(dataset.variables)
        if "line_kind" in names:
            found += _lines_of_cycle(dataset, scales, units)
        elif "whirl_speed" in names and "kind" in names:
            found += _lines_of_backward(dataset, scales, units)
        elif {"amplitude", "branch"} <= names:
            found += _lines_of_whirls(dataset, scales, units)
        elif {"fold_omega", "hopf_omega"} & names:
            found += _special_lines(dataset, scales, units) if over_speed else []
        elif not set(CURVE) <= names:
            raise InputError(
                "beneath must be a limit cycle, backward whirls or synchronous whirls, got "
                f"{dataset.attrs.get('title', 'another dataset')!r}"
            )
    return found


def _lines_of_cycle(cycle: xr.Dataset, scales: Scales, units: Units) -> list[Line]:
    heights = np.atleast_1d(cycle["whirl_amplitude"].values) * scales.length
    places = units.frequencies(np.atleast_1d(cycle["frequency"].values) * scales.rate).values
    speed = float(units.speeds(float(cycle["omega"]) * scales.omega))
    return [
        Line(float(place), float(height), f"line of {CYCLE}", PURPLE, "D", speed)
        for place, height in zip(places, heights, strict=True)
        if height > WEAKEST * heights.max()
    ]


def _special_lines(dataset: xr.Dataset, scales: Scales, units: Units) -> list[Line]:
    """Return folds, or Hopf points with the two lines that a cycle has beside 1X as it is born."""
    fold = "fold_omega" in dataset.variables
    name, words, marker = ("fold", FOLD, "D") if fold else ("hopf", HOPF, "o")
    found = []
    for place, omega in np.ndenumerate(dataset[f"{name}_omega"].values):
        if not math.isfinite(omega):
            continue
        height = float(dataset[f"{name}_amplitude"].values[place]) * scales.length
        beside = 0.0 if fold else float(dataset["hopf_frequency"].values[place])
        speed = float(units.speeds(omega * scales.omega))
        for rate in [omega] if fold else [omega, omega - beside, omega + beside]:
            at = float(units.frequencies(rate * scales.rate))
            found.append(Line(at, height, words, INK, marker, speed))
    return found


def _lines_of_backward(whirls: xr.Dataset, scales: Scales, units: Units) -> list[Line]:
    kinds = {number: word for word, number in flags_of(whirls["kind"]).items()}
    speed = float(units.speeds(float(whirls["omega"]) * scales.omega))
    found = []
    for number in range(whirls.sizes["whirl"]):
        whirl = whirls.isel(whirl=number)
        if not math.isfinite(float(whirl["amplitude"])):
            continue
        kind = kinds[int(whirl["kind"])]
        place = float(units.frequencies(float(whirl["whirl_speed"]) * scales.rate))
        height = float(whirl["amplitude"]) * scales.length
        colour = DARK_BROWN if kind == "rolling" else GREY
        found.append(Line(place, height, f"exact {WHIRLS[kind]}", colour, "v", speed))
    return found


def _lines_of_whirls(whirls: xr.Dataset, scales: Scales, units: Units) -> list[Line]:
    omega, amplitude, stability = (
        each.values.ravel()
        for each in xr.broadcast(whirls["omega"], whirls["amplitude"], whirls["stability"])
    )
    flags = flags_of(whirls["stability"])
    rates = omega * scales.omega
    return [
        Line(float(units.frequencies(rate)), float(height) * scales.length, "line of exact whirl",
             INK, "s", float(units.speeds(rate)))
        for rate, height, kind in zip(rates, amplitude, stability, strict=True)
        if math.isfinite(height) and kind != flags["unstable"]
    ]  # fmt: skip
