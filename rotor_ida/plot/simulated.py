"""What simulated rotors do over the spin speed, by kind of response and direction of the sweep."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt
import xarray as xr
from matplotlib.axes import Axes

from rotor_ida.checks import COMPONENTS
from rotor_ida.plot.appearance import (
    BLUE,
    FROM_REST,
    FROM_START,
    GOING_DOWN,
    GOING_UP,
    GREY,
    INK,
    ORANGE,
    PURPLE,
)
from rotor_ida.plot.labels import KIND_WORDS
from rotor_ida.schema import flags_of

Values = npt.NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class _Look:
    """How one kind of response is drawn."""

    colour: str
    filled: bool
    is_range: bool
    dotted: bool = False


KINDS = {
    "synchronous": _Look(BLUE, True, False),
    "contact_free": _Look(BLUE, False, False),
    "bouncing": _Look(ORANGE, False, True),
    "full_contact": _Look(PURPLE, True, True),
    "unresolved": _Look(GREY, False, True, dotted=True),
}
DIRECTIONS = {0: ("o", 4.2), 1: ("^", 3.4), -1: ("v", 3.4)}


def draw_simulated(ax: Axes, simulated: xr.Dataset, quantity: str) -> None:
    """Draw the responses of a sweep: marks where a curve can show them, bars where it cannot."""
    names = ("omega", "direction", "response", "radius_min", "radius_max", "amplitude", "phase_lag")
    flat = {
        name: values.values.ravel()
        for name, values in zip(
            names, xr.broadcast(*(simulated[name] for name in names)), strict=True
        )
    }
    flags = flags_of(simulated["response"])
    for kind, look in KINDS.items():
        of_kind = flat["response"] == flags[kind]
        if not of_kind.any():
            continue
        points = {name: values[of_kind] for name, values in flat.items()}
        if look.is_range and quantity == "amplitude":
            _draw_ranges(ax, look, points, f"{KIND_WORDS[kind]}: range of $|z|$")
            continue
        _draw_marks(ax, look, points, points[quantity], 1.0)
        ax.plot([], [], ls="", marker="s", ms=4.5, mec=look.colour, mew=0.9,
                mfc=_face(look), label=KIND_WORDS[kind])  # fmt: skip
    words = {0: _start_words(simulated), 1: GOING_UP, -1: GOING_DOWN}
    for direction in np.unique(flat["direction"]):
        marker, size = DIRECTIONS[int(direction)]
        ax.plot([], [], ls="", marker=marker, ms=size, mec=INK, mfc="none", mew=0.8,
                label=words[int(direction)])  # fmt: skip


def _draw_ranges(ax: Axes, look: _Look, points: dict[str, Values], words: str) -> None:
    ax.vlines(
        points["omega"], points["radius_min"], points["radius_max"], color=look.colour,
        lw=1.8 if look.filled else 0.9,
        ls=(0, (1, 1.6)) if look.dotted else "-", zorder=3.0, label=words,
    )  # fmt: skip
    for end in ("radius_min", "radius_max"):
        _draw_marks(ax, look, points, points[end], 0.75)


def _draw_marks(
    ax: Axes, look: _Look, points: dict[str, Values], heights: Values, scale: float
) -> None:
    """Mark points by the direction of their sweep, triangles over the larger circles."""
    for direction, (marker, size) in DIRECTIONS.items():
        here = points["direction"] == direction
        ax.plot(
            points["omega"][here], heights[here], ls="", marker=marker, ms=scale * size,
            mec=look.colour, mfc=_face(look), mew=0.7, zorder=3.2 if direction else 3.1,
        )  # fmt: skip


def _face(look: _Look) -> str:
    return look.colour if look.filled else "white"


def _start_words(simulated: xr.Dataset) -> str:
    starts = [f"start_{name}" for name in COMPONENTS]
    at_rest = all(name in simulated and not simulated[name].values.any() for name in starts)
    return FROM_REST if at_rest else FROM_START
