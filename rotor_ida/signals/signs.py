"""Signs of a rub: what a record at one speed shows beside the synchronous whirl."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
import xarray as xr

from rotor_ida.arrays import Flags, Values
from rotor_ida.errors import InputError
from rotor_ida.schema import Column
from rotor_ida.signals.orders import whirl_ratio
from rotor_ida.signals.record import record_of
from rotor_ida.signals.spectra import STEADY, full_spectrum, one_speed
from rotor_ida.signals.windows import Complex

# Revolutions in a record whose lines are apart, and in a segment for the floor between lines.
FEWEST, SEGMENT = 48, 32
# A line within this many grid steps of another is part of it, by the flat-top window.
BESIDE = 6
# A line is above this multiple of the noise and of the floor, and above this part of the highest,
# which is more than a side lobe of the window.
CLEAR, FAINT = 4.0, 1e-4
# A record, or a probe, that moves by no more than this part of the largest displacement is still.
STILL = 1e-12
# Orders between which the floor is measured, and between which oil whirl is.
BELOW, OF_OIL = (0.1, 0.9), (0.3, 0.6)
# An order is a simple fraction if it is within this part of a grid step of it.
NEAR = 0.1
# Lines, and a floor, are mentioned if they exceed these parts of the highest line. Two lines are
# alike if the smaller exceeds this part of the larger.
SEEN, BROAD, ALIKE = 0.02, 0.03, 0.5
# The highest multiple of the speed that is mentioned.
LAST = 5


class Lines(NamedTuple):
    """The full spectrum of a record by orders of its speed.

    Parameters
    ----------
    order, height : ndarray, shape (n,)
        Orders, increasing, and amplitudes.
    least : float
        Amplitude above which a line is clear of noise and rounding.
    width : float
        Distance in order within which lines are not apart.
    """

    order: Values
    height: Values
    least: float
    width: float

    @property
    def step(self) -> float:
        """Distance of the orders."""
        return float(self.order[1] - self.order[0])

    @property
    def highest(self) -> float:
        """The largest amplitude."""
        return float(self.height.max())

    def at(self, order: float) -> float:
        """Return the amplitude at an order; 0 beyond the last."""
        inside = self.order[0] <= order <= self.order[-1]
        return float(self.height[np.abs(self.order - order).argmin()]) if inside else 0.0

    def clear(self, order: float) -> float:
        """Return the largest amplitude about an order; 0 if it is not clear of the noise.

        Where that is the flank of a line further away, it is the amplitude at the order itself.
        """
        near = np.flatnonzero(np.abs(self.order - order) <= self.width)
        if not near.size:
            return 0.0
        place = near[self.height[near].argmax()]
        is_flank = self.height[place] < self.height[self._around(place)].max()
        amplitude = self.at(order) if is_flank else float(self.height[place])
        return amplitude if amplitude > self.least else 0.0

    def _around(self, place: int) -> slice:
        """Return the places over which a line at a place may spread."""
        return slice(max(place - BESIDE, 0), place + BESIDE + 1)

    def strongest(self, far: Flags) -> tuple[float, float]:
        """Return order and amplitude of the strongest line at chosen orders; NaN and 0 if none.

        Its order is the centre of power over its width.
        """
        for place in np.argsort(np.where(far, -self.height, 0.0)):
            near = self._around(place)
            height, order = self.height[near], self.order[near]
            if not far[place] or self.height[place] <= self.least:
                break
            if self.height[place] == height.max():  # no flank of another
                centre = float((order * height**2).sum() / (height**2).sum())
                return centre, float(self.height[place])
        return math.nan, 0.0

    def beside(self) -> tuple[float, float]:
        """Return order and amplitude of the strongest line beside 1X and the mean."""
        size = np.abs(self.order - 0.5)
        return self.strongest(np.abs(size - 0.5) > self.width)

    def between(self) -> tuple[float, float]:
        """Return order and amplitude of the strongest line at no multiple of the speed."""
        return self.strongest(np.abs(self.order - np.round(self.order)) > self.width)


def rub_signs(signals: xr.Dataset) -> xr.Dataset:
    """Find the signs of a rub in a record at one speed.

    Parameters
    ----------
    signals : Dataset
        Signals of `signals_of` or `read_signals`, or a run, with equally spaced samples over at
        least 48 revolutions at one speed.

    Returns
    -------
    Dataset
        ``forward_whirl_amplitude`` and ``backward_whirl_amplitude`` at the speed (1X and -1X);
        ``twice_amplitude``, the sum of both at twice the speed; ``line_order`` of the strongest
        other line, negative for backward whirl, NaN where none is above the noise, its
        ``line_amplitude``, and ``line_opposite_amplitude`` at the same order in the other
        direction; ``whirl_over_spin``; ``least_crest``, the smallest crest of x and y, up and down,
        over that of a sine; ``floor_ratio``, the lower quartile of the spectrum between 0.1X and
        0.9X over the highest line; ``noise_floor``. The attribute ``sentence`` says what they mean.

    Raises
    ------
    InputError
        If the speed is unknown or changes, the record is too short or does not move, or its samples
        are not equally spaced.

    Notes
    -----
    The page on signatures of rubs shows what each sign proves, and which published ones mislead.
    A contact all round at one speed has none of them.

    Examples
    --------
    >>> angle = 2 * np.pi * np.arange(4096) / 64
    >>> z = np.exp(1j * angle) + 0.4 * np.exp(-1.3j * angle)
    >>> record = xr.Dataset({"x": ("t", z.real), "y": ("t", z.imag), "angle": ("t", angle)},
    ...                     {"t": angle / 100})
    >>> signs = rub_signs(record)
    >>> signs.line_order.round(4).item(), signs.line_amplitude.round(3).item()
    (-1.3, 0.4)
    >>> print(signs.sentence)
    A backward line at -1.300X, at no simple fraction of the speed and without a forward one at this
    order, has 0.40 of 1X. An annular or partial rub has such a line, about at the frequency of the
    dry whip that may follow.
    """
    record = record_of(signals)
    speed = one_speed(record)
    if speed is None:
        raise InputError("signals must be at one known speed")
    turn = 2.0 * math.pi / (speed * record.equal_step())
    turns = record.z.size / turn
    if turns < FEWEST:
        raise InputError(f"signals must last at least {FEWEST} revolutions, got {turns:.3g}")
    if np.abs(record.z - record.z.mean()).max() <= STILL * np.abs(record.z).max():
        raise InputError("signals must move, got x and y that stay at one place")
    whirl = whirl_ratio(signals, revolutions=int(turns) - 1)
    lines, noise = _lines_of(signals)
    order, amplitude = lines.beside()
    found = {
        "forward_whirl_amplitude": lines.at(1.0), "backward_whirl_amplitude": lines.at(-1.0),
        "twice_amplitude": lines.at(2.0) + lines.at(-2.0), "line_order": order,
        "line_amplitude": amplitude, "line_opposite_amplitude": lines.at(-order),
        "whirl_over_spin": float(whirl["whirl_over_spin"][0]),
        "least_crest": _least_crest(record.z), "noise_floor": noise,
        "floor_ratio": _floor(signals, min(round(SEGMENT * turn), record.z.size)),
    }  # fmt: skip
    columns: dict[str, Column] = {name: ((), value) for name, value in found.items()}
    told = {"sentence": " ".join(_sentences(lines, found))}
    return record.dataset("Signs of rub", columns, {}, told, kind="rub_signs")


def signs_in(signals: xr.Dataset) -> xr.Dataset | None:
    """Return the signs of rub in a record; None where that has none to show, as in a run-up."""
    try:
        return rub_signs(signals)
    except InputError:
        return None


def _lines_of(signals: xr.Dataset) -> tuple[Lines, float]:
    """Return the lines of a record, and its noise floor."""
    spectrum = full_spectrum(signals)
    order, height = spectrum["frequency_over_omega"].values, spectrum["whirl_amplitude"].values
    noise = float(spectrum["noise_floor"])
    least = max(FAINT * float(height.max()), CLEAR * noise)
    # a speed that drifts makes lines wider
    return Lines(order, height, least, BESIDE * (order[1] - order[0]) + 2.0 * STEADY), noise


def _least_crest(z: Complex) -> float:
    """Return the least crest of x and y, up and down, over that of a sine; still ones have none."""
    sides = np.array([z.real, -z.real, z.imag, -z.imag])
    sides -= sides.mean(axis=1, keepdims=True)
    sizes = np.sqrt(2.0 * (sides**2).mean(axis=1))
    moves = sizes > STILL * sizes.max()
    return float((sides[moves].max(axis=1) / sizes[moves]).min())


def _floor(signals: xr.Dataset, segment: int) -> float:
    """Return the floor between the lines below 1X, over the highest: the lower quartile there."""
    spectrum = full_spectrum(signals, segment=segment)
    size, height = np.abs(spectrum["frequency_over_omega"].values), spectrum["whirl_amplitude"]
    between = height.values[(size > BELOW[0]) & (size < BELOW[1])]
    return float(np.quantile(between, 0.25) / height.values.max())


# ---- Words ----


def _sentences(lines: Lines, found: dict[str, float]) -> list[str]:
    """Return what the signs mean."""
    floor = found["floor_ratio"]
    said = [*_of_line(lines, floor), *_of_multiples(lines)]
    if floor > BROAD:
        said.append(
            f"Three quarters of the spectrum below the speed lie above {floor:.2g} of the highest "
            "line: chaos has such a floor, and so has noise."
        )
    return said or [
        f"Nothing stands out beside 1X, as far as lines more than {lines.width:.1g}X from it show. "
        "No contact and contact all round look alike at one speed: compare amplitude and phase of "
        "1X over the speed with those without contact."
    ]


def _size(lines: Lines, amplitude: float) -> str:
    """Return an amplitude in words, over that of 1X if there is a clear one."""
    whole = lines.clear(1.0)
    return f"has {amplitude / whole:.2f} of 1X" if whole else "is there without 1X"


def _of_line(lines: Lines, floor: float) -> list[str]:
    """Return what the strongest line at no multiple of the speed means."""
    order, amplitude = lines.between()
    least = max(SEEN, CLEAR * floor if floor > BROAD else 0.0)
    if amplitude <= least * lines.highest:
        return []
    is_alone = lines.at(-order) < ALIKE * amplitude
    if order < 0.0 and is_alone and amplitude > lines.at(1.0):
        return [_whips(f"{-order:.2f}")]
    near = NEAR * lines.step
    parts = next((n for n in (2, 3, 4) if abs(order * n - round(order * n)) < n * near), 0)
    size, at = _size(lines, amplitude), f"at {order:.3f}X"
    if parts and not is_alone:
        return [f"A line {at}, forwards and backwards alike, {size}, as in a rub under a load that "
                f"repeats after {parts} revolutions."]  # fmt: skip
    if order < 0.0 and is_alone and not parts:
        return [f"A backward line {at}, at no simple fraction of the speed and without a forward "
                f"one at this order, {size}. An annular or partial rub has such a line, about at "
                "the frequency of the dry whip that may follow."]  # fmt: skip
    if OF_OIL[0] < order < OF_OIL[1] and is_alone:
        return [f"A forward line {at} without a backward one {size}, as in oil whirl; a rub under "
                "a load has both."]  # fmt: skip
    return [f"A line {at} {size}."]


def _whips(order: str) -> str:
    return f"The rotor whirls backwards, at {order} times its speed, as in dry whirl and dry whip."


def _of_multiples(lines: Lines) -> list[str]:
    """Return what lines at multiples of the speed mean, and that at -1X."""
    ahead, back = lines.clear(1.0), lines.clear(-1.0)
    seen = max(SEEN * lines.highest, lines.least)
    said = []
    if back > max(ahead, seen):
        said.append(
            "The orbit turns backwards once a revolution, as between two critical speeds of "
            "bearings that differ in their directions; dry whip may pass through -1X too."
        )
    elif back > seen:
        said.append(
            f"The orbit is an ellipse, with {back / ahead:.2f} of 1X backwards, as from bearings "
            "that differ in their directions, or from a rub under a load."
        )
    multiples = range(2, LAST + 1)
    behind = {n: lines.clear(-n) for n in multiples}
    whips = {n for n, each in behind.items()
             if each > max(ahead, seen) and lines.clear(n) < ALIKE * each}  # fmt: skip
    said += [_whips(f"about {n}") for n in sorted(whips)]
    sums = {n: lines.clear(n) + each for n, each in behind.items() if n not in whips}
    told = [f"{n}X {_size(lines, each)}" for n, each in sums.items() if each > seen]
    if told:
        said.append(
            f"{', '.join(told)}. A rub once a revolution under a load has multiples of the speed, "
            "and so have misaligned and oval shafts."
        )
    return said
