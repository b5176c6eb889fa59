"""From starts to labels and attractors: what grids and random samples have in common."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from rotor_ida.basins.attractors import WITNESSES, Attractor, attractors_of
from rotor_ida.basins.survey import Survey, survey
from rotor_ida.checks import check_positive
from rotor_ida.ensemble import Progress, choose
from rotor_ida.errors import InputError
from rotor_ida.parameters import Rotor
from rotor_ida.simulator.limits import LARGEST, check_can_be_followed
from rotor_ida.simulator.options import Options

Values = npt.NDArray[np.float64]

COMPONENTS = ("x", "y", "vx", "vy")
RTOL = 1e-6
TIGHTEST, LOOSEST = 1e-12, 1e-4
# Stiffer rotors take the explicit method too many steps.
MOST_DAMPING = 20.0


@dataclass(frozen=True, slots=True)
class Labelled:
    """The starts with their labels, and the attractors that these number."""

    labels: npt.NDArray[np.int16]
    times: npt.NDArray[np.float32]
    attractors: list[Attractor]
    attributes: dict[str, object]
    options: Options


def check_rotor(rotor: object) -> Rotor:
    """Return a rotor whose starts can be labelled."""
    if not isinstance(rotor, Rotor):
        raise InputError(f"rotor must be a Rotor, got {rotor!r}")
    check_can_be_followed(rotor, (0.0, 0.0, 0.0, 0.0), settling=True)
    if not 0.0 < rotor.zeta <= MOST_DAMPING:
        raise InputError(
            f"zeta must be above 0, where nothing settles, and at most {MOST_DAMPING:g} for a "
            f"basin, got {rotor.zeta!r}"
        )
    return rotor


def check_within(name: str, values: Values) -> Values:
    """Return start values that can be followed."""
    if np.abs(values).max() > LARGEST:
        outside = float(values[np.argmax(np.abs(values))])
        raise InputError(f"{name} must lie within {LARGEST:g} of zero, got {outside!r}")
    return values


def check_rtol(rtol: object) -> float:
    """Return a tolerance that the kernel can hold."""
    value = check_positive("rtol", rtol)
    if not TIGHTEST <= value <= LOOSEST:
        raise InputError(f"rtol must lie from {TIGHTEST} to {LOOSEST}, got {value!r}")
    return value


def label(
    rotor: Rotor,
    starts: Callable[[int, int], Values],
    count: int,
    *,
    rtol: float,
    workers: int | None,
    executor: str,
    progress: Progress | None,
) -> Labelled:
    """Follow the starts, given from one number up to another as (4, n), and sort them."""
    place, several = choose(executor, workers, compiled=True)
    found = survey(
        rotor, starts, count,
        tolerance=rtol, workers=several, executor=place, progress=progress,
    )  # fmt: skip
    options = Options()
    captured = _witnesses(found, starts)
    try:
        attractors = attractors_of(found, captured, options)
    except KeyboardInterrupt:  # labels without confirmation are better than none
        found.interrupted = True
        attractors = attractors_of(found, captured, options)
    attributes: dict[str, object] = {"labelling_rtol": rtol, "interrupted": int(found.interrupted)}
    if found.lost:
        attributes["not_computed_reason"] = found.lost
    return Labelled(found.labels, found.times, attractors, attributes, options)


def _witnesses(found: Survey, starts: Callable[[int, int], Values]) -> list[Values]:
    """Return for each attractor known beforehand the starts that it captured first.

    They are the ones least likely to lie so near to the border of the basin that another
    integrator ends elsewhere.
    """
    chosen = []
    for number in range(len(found.ends.sets) + found.ends.has_free):
        members = np.flatnonzero(found.labels == number)
        first = members[np.argsort(found.times[members], kind="stable")[:WITNESSES]].tolist()
        states = [starts(place, place + 1)[:, 0] for place in first]
        chosen.append(np.array(states).reshape(-1, 4))
    return chosen
