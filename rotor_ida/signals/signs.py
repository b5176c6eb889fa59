"""Signs of a rub: what a record at one speed shows beside the synchronous whirl."""

from __future__ import annotations

import math

import numpy as np
import xarray as xr

from rotor_ida.arrays import Values
from rotor_ida.errors import InputError
from rotor_ida.schema import Column
from rotor_ida.signals.orders import whirl_ratio
from rotor_ida.signals.record import record_of
from rotor_ida.signals.spectra import full_spectrum, one_speed

# Revolutions in a record whose lines are apart, and in a segment for the floor between lines.
FEWEST, SEGMENT = 24, 32
# A line within this many grid steps of another is part of it, by the flat-top window.
BESIDE = 6
# A line is above this multiple of the noise floor, and above this part of the highest line.
CLEAR, ROUNDING = 4.0, 1e-6
# Orders between which the floor is measured.
BELOW = (0.1, 0.9)
# An order is a simple fraction if it is within this part of a grid step of it.
NEAR = 0.1
# Parts of 1X from which lines and floor are told, and part of a line that makes another alike.
SEEN, BROAD, ALIKE = 0.02, 0.03, 0.5


def rub_signs(signals: xr.Dataset) -> xr.Dataset:
    """Find the signs by which kinds of rub are told apart, in a record at one speed.

    Parameters
    ----------
    signals : Dataset
        Signals of `signals_of` or `read_signals`, or a run, with equally spaced samples over at
        least 24 revolutions at one speed.

    Returns
    -------
    Dataset
        ``forward_whirl_amplitude`` and ``backward_whirl_amplitude`` at the speed (1X and -1X);
        ``twice_amplitude``, the sum of both at twice the speed; ``line_order`` of the strongest
        other line, negative for backward whirl, NaN where none is above the noise, its
        ``line_amplitude``, and ``line_opposite_amplitude`` at the same order in the other
        direction; ``whirl_over_spin``; ``least_crest``, the smallest crest of x and y, up and down,
        over that of a sine; ``floor_over_synchronous``, the lower quartile of the spectrum between
        0.1X and 0.9X over 1X; ``noise_floor``. The attribute ``sentence`` says what they mean.

    Raises
    ------
    InputError
        If the speed is unknown or changes, the record is too short, or its samples are not equally
        spaced.

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
    spectrum, whirl = full_spectrum(signals), whirl_ratio(signals, revolutions=int(turns) - 1)
    order = spectrum["frequency_over_omega"].values
    height, noise = spectrum["whirl_amplitude"].values, float(spectrum["noise_floor"])

    def at(place: float) -> float:
        return float(height[np.abs(order - place).argmin()])

    line, amplitude = _strongest(order, height, noise)
    found = {
        "forward_whirl_amplitude": at(1.0), "backward_whirl_amplitude": at(-1.0),
        "twice_amplitude": at(2.0) + at(-2.0), "line_order": line, "line_amplitude": amplitude,
        "line_opposite_amplitude": 0.0 if math.isnan(line) else at(-line),
        "whirl_over_spin": float(whirl["whirl_over_spin"][0]),
        "least_crest": _least_crest(record.z), "noise_floor": noise,
        "floor_over_synchronous": _floor(signals, min(round(SEGMENT * turn), record.z.size)),
    }  # fmt: skip
    columns: dict[str, Column] = {name: ((), value) for name, value in found.items()}
    told = {"sentence": " ".join(_sentences(found, order[1] - order[0]))}
    return record.dataset("Signs of rub", columns, {}, told, kind="rub_signs")


def signs_in(signals: xr.Dataset) -> xr.Dataset | None:
    """Return the signs of rub in a record; None where that has none to show, as in a run-up."""
    try:
        return rub_signs(signals)
    except InputError:
        return None


def _strongest(order: Values, height: Values, noise: float) -> tuple[float, float]:
    """Return order and amplitude of the strongest line beside 1X; NaN and 0 where none is clear.

    Its order is the centre of power over its width.
    """
    width = BESIDE * (order[1] - order[0])
    beside = (np.abs(order - 1.0) > width) & (np.abs(order) > width)
    place = int(np.where(beside, height, 0.0).argmax())
    if height[place] < max(ROUNDING * height.max(), CLEAR * noise):
        return math.nan, 0.0
    near = np.abs(order - order[place]) <= width
    centre = float((order * height**2)[near].sum() / (height**2)[near].sum())
    return centre, float(height[place])


def _least_crest(z: np.ndarray) -> float:
    """Return the least crest of x and y, up and down, over that of a sine."""
    sides = np.array([z.real, -z.real, z.imag, -z.imag])
    sides -= sides.mean(axis=1, keepdims=True)
    return float((sides.max(axis=1) / np.sqrt(2.0 * (sides**2).mean(axis=1))).min())


def _floor(signals: xr.Dataset, segment: int) -> float:
    """Return the floor between the lines below 1X, over 1X: the lower quartile there."""
    spectrum = full_spectrum(signals, segment=segment)
    order, height = spectrum["frequency_over_omega"].values, spectrum["whirl_amplitude"].values
    size = np.abs(order)
    between = height[(size > BELOW[0]) & (size < BELOW[1])]
    return float(np.quantile(between, 0.25) / height[np.abs(order - 1.0).argmin()])


def _sentences(found: dict[str, float], step: float) -> list[str]:
    """Return what the signs mean; `step` is that of the orders of the spectrum."""
    whole, ratio = found["forward_whirl_amplitude"], found["whirl_over_spin"]
    twice, floor = found["twice_amplitude"] / whole, found["floor_over_synchronous"]
    said = []
    if ratio < 0.0:
        said.append(
            f"The rotor whirls backwards, at {-ratio:.2f} times its speed, as in dry whirl and dry "
            "whip."
        )
    elif found["line_amplitude"] > SEEN * whole and floor <= BROAD:
        said += _of_line(found, whole, NEAR * step)
    if twice > SEEN:
        said.append(
            f"Twice the speed has {twice:.2f} of 1X. A rub once a revolution under a load has it, "
            "and so have misaligned and oval shafts."
        )
    if floor > BROAD:
        said.append(
            f"Three quarters of the spectrum below the speed lie above {floor:.2g} of 1X: chaos "
            "has such a floor, and so has noise."
        )
    return said or [
        "Nothing stands out beside 1X. No contact and contact all round look alike at one speed: "
        "compare amplitude and phase of 1X over the speed with those without contact."
    ]


def _of_line(found: dict[str, float], whole: float, near: float) -> list[str]:
    """Return what the strongest line beside 1X means, if it is not at a multiple of the speed."""
    order, amplitude = found["line_order"], found["line_amplitude"]
    is_alone = found["line_opposite_amplitude"] < ALIKE * amplitude
    parts = next((n for n in (1, 2, 3, 4) if abs(order * n - round(order * n)) < n * near), 0)
    if parts == 1:
        return []
    size, at = f"has {amplitude / whole:.2f} of 1X", f"at {order:.3f}X"
    if parts and not is_alone:
        return [f"A line {at}, forwards and backwards alike, {size}, as in a rub under a load that "
                f"repeats after {parts} revolutions."]  # fmt: skip
    if order < 0.0 and is_alone and not parts:
        return [f"A backward line {at}, at no simple fraction of the speed and without a forward "
                f"one at this order, {size}. An annular or partial rub has such a line, about at "
                "the frequency of the dry whip that may follow."]  # fmt: skip
    if 0.0 < order < 1.0 and is_alone:
        return [f"A forward line {at} without a backward one {size}, as in oil whirl; a rub under "
                "a load has both."]  # fmt: skip
    return [f"A line {at} {size}."]
