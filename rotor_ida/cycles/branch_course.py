"""Stability of a branch of limit cycles between its special points."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
import xarray as xr

from rotor_ida.arrays import Values
from rotor_ida.checks import shown
from rotor_ida.errors import InputError
from rotor_ida.model.parameters import ALL_PARAMETERS
from rotor_ida.model.system_parameters import PARAMETERS_OF_SYSTEM, SPEED
from rotor_ida.schema import words_of

# What may vary along a branch or curve.
VARIED = (*ALL_PARAMETERS, SPEED, *PARAMETERS_OF_SYSTEM)
# Special points at which a cycle may gain or lose stability.
CHANGES = ("fold", "period_doubling", "torus", "discontinuous")
# Ends that are points of a branch, and at which its stability changes.
BORDERS = ("halved", "hopf")


@dataclass(frozen=True, slots=True)
class Course:
    """The n points of a branch with its special points in their places."""

    value: Values  # the continued parameter [1]
    low: Values  # smallest radius, in the units of the branch
    high: Values  # largest radius
    stability: list[str]  # n - 1 words: stability of the cycles between each two points
    response: list[str]


def parameters_of(name: str, dataset: xr.Dataset, attribute: str, number: int) -> list[str]:
    """Return the parameters that vary along a branch or curve, from one of its attributes."""
    varied = dataset.attrs.get(attribute, "")
    words = str(varied).split()
    if len(words) != number or not set(words) <= set(VARIED):
        raise InputError(
            f"{name} must name what was varied in its attribute {attribute!r}, got {shown(varied)}"
        )
    return words


def course_of(branch: xr.Dataset, contact: int = 0) -> Course:
    """Return the course of a branch as of `rotor_ida.continue_cycle`, with the radii at a contact.

    One disc has one.
    """
    (parameter,) = parameters_of("branch", branch, "parameter", 1)
    if is_system := "contact" in branch.dims:
        branch = branch.isel(contact=contact)
    inside, stability = _beside_halves(branch), words_of(branch["stability"])
    response, kinds = words_of(branch["response"]), words_of(inside["special_kind"])
    points, specials = branch.sizes["point"], inside.sizes["special"]
    places = np.concatenate([np.arange(points), inside["special_point"].values])
    order = np.argsort(places, kind="stable")  # a point comes before the special ones behind it
    value, low, high = (
        np.concatenate([branch[name].values, inside[special].values])[order]
        for name, special in (
            (parameter, "special_value"),
            ("radius_min", "special_radius_min"),
            ("radius_max", "special_radius_max"),
        )
    )
    if specials < branch.sizes["special"]:
        stability = _of_neighbours(branch, stability)
    several = is_system or bool({"contact_damping", "friction", "load"} & set(branch.coords))
    stable, touching = [], []
    for number in order.tolist():
        if number < points:
            here, kind = stability[number], response[number]
        elif kinds[number - points] in CHANGES:
            here = "unstable" if here == "stable" else "stable"
            # where tori are born, a cycle may be unstable in two ways: the next point decides
            if several and np.sum(inside["special_point"].values == places[number]) == 1:
                here = stability[min(int(places[number]) + 1, points - 1)]
        else:  # a graze, behind which the cycles are as at the next point
            kind = response[min(int(places[number]) + 1, points - 1)]
        stable.append(here)
        touching.append(kind)
    return Course(value, low, high, stable[:-1], touching[:-1])


def runs_of(words: Sequence[object]) -> list[tuple[int, int]]:
    """Return the first and the last point of each run of intervals with the same word.

    Examples
    --------
    >>> runs_of(["stable", "stable", "unstable"])
    [(0, 2), (2, 3)]
    """
    turns = [place for place in range(1, len(words)) if words[place] != words[place - 1]]
    return list(pairwise([0, *turns, len(words)])) if words else []


def stable_ranges(branch: xr.Dataset) -> list[tuple[float, float]]:
    """Return the ranges of the continued parameter [1] in which a branch is stable, along it.

    Examples
    --------
    >>> from rotor_ida import Rotor, continue_cycle, limit_cycle
    >>> rotor = Rotor(omega=2.0, zeta=0.07, delta0=2.0)
    >>> cycle = limit_cycle(rotor, start=(2.6, 0.75, 0.66, -1.65), period=4.5)
    >>> [(low, high)] = stable_ranges(continue_cycle(rotor, start=cycle, limits=(1.5, 2.5)))
    >>> round(low, 9), high
    (1.80339247, 2.5)
    """
    course = course_of(branch)
    return [
        (float(course.value[first : last + 1].min()), float(course.value[first : last + 1].max()))
        for first, last in runs_of(course.stability)
        if course.stability[first] == "stable"
    ]


def _beside_halves(branch: xr.Dataset) -> xr.Dataset:
    """Return a branch without special points that are also points: halved or Hopf ends."""
    ends = {0: "first_end", branch.sizes["special"] - 1: "last_end"}
    left_out = [place for place, end in ends.items() if branch.attrs.get(end) in BORDERS]
    return branch.drop_isel(special=left_out)


def _of_neighbours(branch: xr.Dataset, stability: list[str]) -> list[str]:
    """Return stability in which ends where it changes take that of their neighbours."""
    inner = stability[1:-1]
    first = inner[:1] if branch.attrs.get("first_end") in BORDERS else stability[:1]
    last = inner[-1:] if branch.attrs.get("last_end") in BORDERS else stability[-1:]
    return [*(first or stability[:1]), *inner, *(last or stability[-1:])]
