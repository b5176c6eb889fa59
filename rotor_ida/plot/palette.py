"""Colours and lines that differ in grey and with colour blindness too."""

from __future__ import annotations

# From matplotlib's petroff10, chosen so that the greys differ too.
BLUE, ORANGE, RED, PURPLE, GREY = "#3f90da", "#e76300", "#bd1f01", "#832db6", "#94a4a2"
BROWN, DARK_BROWN = "#a96b59", "#8a4f3d"
GREEN = "#2f8f57"
INK = "#1a1a1a"
DASHES = (0, (4, 2))
SHADE = "#ffe3c4"
PALE_SHADE = "#fff0df"
# Colour and dashes, so that the curves are distinguishable without colour too.
LOOKS: tuple[tuple[str, object], ...] = (
    (INK, "-"),
    (BLUE, (0, (6, 1.8))),
    (ORANGE, (0, (1.2, 1.4))),
    (PURPLE, (0, (6, 1.6, 1.2, 1.6))),
    (RED, (0, (3, 1.2))),
)
# What differs by colour alone has one family of colours for each kind of response.
KIND_SHADES = {
    "synchronous": (BLUE, "#c6dcf5", "#12427a", "#7a6fd0"),
    "contact_free": ("#92dadd", "#4f9b9f", "#d5f2f3", "#1f6f73"),
    "bouncing": (ORANGE, "#ffc48a", "#a96b59", "#ffa90e"),
    "full_contact": (PURPLE, "#d7b3ea", "#4b1a68", "#b9ac70"),
    "rolling": (DARK_BROWN, "#dcc3b9", "#5c3222", "#c48a73"),
    "touching": ("#c08878", "#d8b8ae", "#6b3a2c", "#8a7a75"),
    "quasi_periodic": (GREEN, "#a9d3b4", "#174a2b", "#7da453"),
    "chaotic": (RED, "#f0a898", "#6e1200", "#d97b66"),
    "unresolved": (GREY, "#717581", "#c9d1d0", "#5a5f5e"),
}


def look(number: int) -> tuple[str, object]:
    """Return colour and line style of the curve with this number; they repeat after five."""
    return LOOKS[number % len(LOOKS)]
