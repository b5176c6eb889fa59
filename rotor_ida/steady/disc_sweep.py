"""What one disc settles on, at each point of a study over its parameters."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, fields
from functools import partial
from typing import Any, ClassVar

import numpy as np
import xarray as xr

from rotor_ida.arrays import Column, Stop, Values
from rotor_ida.checks import AT_REST, COMPONENTS, State
from rotor_ida.model.rotor import Rotor
from rotor_ida.model.varied import Varied
from rotor_ida.results.provenance import provenance
from rotor_ida.schema import RESPONSE
from rotor_ida.simulation.flow import DiscFlow, Flow
from rotor_ida.simulation.options import Options, check_can_be_followed, options_of_study
from rotor_ida.simulation.starts import GivenStart, start_of, states_of
from rotor_ida.steady.follow import FAILED, follow_to_steady_state
from rotor_ida.steady.grid import Answer, Answers, Ramps
from rotor_ida.steady.response import Features

FEATURES = tuple(each.name for each in fields(Features))
# The columns of a sweep with a number for each point, and those with one for each event.
POINT = np.dtype(
    [
        ("response", np.int8),
        *((name, np.float64) for name in (*FEATURES, "window_start", "window_end")),
        ("status", np.int8),
        ("event_count", np.int64),
        *((name, np.float64) for name in ("end_x", "end_y", "end_vx", "end_vy")),
    ]
)
EVENT_STATES = ("event_x", "event_y", "event_vx", "event_vy")
EVENT = np.dtype(
    [
        ("event_time", np.float64),
        ("event_kind", np.int8),
        *((name, np.float64) for name in EVENT_STATES),
    ]
)


@dataclass(frozen=True, slots=True)
class VariedDisc:
    """One disc whose parameters vary, and its starts; `VariedSystem` is that of a rotor system.

    Parameters
    ----------
    varied : Varied
        The points.
    starts : list
        Starts, as a question keeps them too.
    options : Options
        How to simulate.
    """

    speed: ClassVar[str] = "omega"
    title: ClassVar[str] = "Rotor in a clearance"
    # the dimensions of columns of several numbers, and the columns that a diagram keeps
    behind: ClassVar[dict[str, tuple[str, ...]]] = {}
    kept_columns: ClassVar[tuple[str, ...]] = ("response", "radius_min", "radius_max", "status")

    varied: Varied
    starts: list[GivenStart]
    options: Options

    @classmethod
    def of(cls, asked: Varied, starts: object, **options: Any) -> VariedDisc:
        """Return the points with checked starts and options."""
        checked = options_of_study(**options)
        loaded = bool(asked.values("load").any())
        return cls(asked, states_of("starts", starts, loaded=loaded), checked)

    @property
    def kept(self) -> list[GivenStart]:
        """The starts, as a question keeps them."""
        return self.starts

    @property
    def is_compiled(self) -> bool:
        """Whether the work is compiled, and so done in threads."""
        return self.options.backend != "python"

    @property
    def arguments(self) -> dict[str, Any]:
        """The arguments of a question besides points and starts."""
        return {name: getattr(self.options, name) for name in ("rtol", "atol", "method")}

    @property
    def attributes(self) -> dict[str, Any]:
        """The attributes of a result that say how it was computed."""
        return provenance(self.options.attributes()) | start_words(self.starts)

    def coordinates(self, _points: Varied) -> dict[str, Column]:
        """Return the coordinates of a result besides its axes."""
        return start_coordinates(self.starts)

    def ramps(self, points: Varied, along: str) -> Ramps[Rotor, GivenStart]:
        """Return the ramps of all points, checked."""
        check_varied_can_be_followed(points, self.starts)
        answers: Answers[Rotor, GivenStart] = Answers(partial(answer_of_disc, self.options), POINT)
        axis = points.dims.index(along or self.speed)
        return Ramps(points, self.starts, answers, points.rotor, axis)

    @property
    def motion(self) -> Callable[..., tuple[Flow, Values]]:
        """How the rotor at a point goes on from where a sweep has left it; for workers."""
        return partial(motion_of_disc, self.options)

    def labelled(self, dataset: xr.Dataset) -> xr.Dataset:
        """Return a result as it is: its units are those of the schema."""
        return dataset


def motion_of_disc(options: Options, rotor: Rotor, end: State, stop: Stop) -> tuple[Flow, Values]:
    """Return the motion of one disc, and its state at the end of a settled one."""
    return DiscFlow(rotor, stop, options=options), np.array(end)


def answer_of_disc(
    options: Options, rotor: Rotor, start: GivenStart, stop: Stop, *, events: bool = False
) -> Answer:
    """Return what one disc settles on, from a start, with the events on the way if wanted."""
    settled = follow_to_steady_state(rotor, start_of(rotor, start), options, stop=stop)
    failed = settled.response == FAILED
    features, table = settled.features, None
    if events:
        table = np.empty(settled.event_times.size, EVENT)
        table["event_time"], table["event_kind"] = settled.event_times, settled.event_kinds
        for name, column in zip(EVENT_STATES, settled.event_states.T, strict=True):
            table[name] = column
    figures = {
        "response": RESPONSE[settled.response],
        **{name: getattr(features, name) for name in FEATURES},
        "window_start": settled.window_start, "window_end": settled.window_end,
        "event_count": settled.event_times.size,
        **{f"end_{name}": each for name, each in zip(COMPONENTS, settled.end, strict=True)},
    }  # fmt: skip
    return Answer(figures, settled.message, failed, None if failed else settled.end, table)


def start_coordinates(starts: Sequence[GivenStart]) -> dict[str, Column]:
    """Return the starts ``(x, y, vx, vy)`` as coordinates of a result; NaN where it is a word."""
    states = [(math.nan,) * len(COMPONENTS) if isinstance(each, str) else each for each in starts]
    columns = zip(COMPONENTS, np.array(states).T, strict=True)
    return {f"start_{name}": ("start", column.copy()) for name, column in columns}


def start_words(starts: Sequence[GivenStart]) -> dict[str, str]:
    """Return the attribute with the word of each start, if there is any; "state" where it is one.

    Examples
    --------
    >>> start_words(["settled", (1.0, 0.0, 0.0, 0.0)]), start_words([(1.0, 0.0, 0.0, 0.0)])
    ({'start_words': 'settled state'}, {})
    """
    if not any(isinstance(each, str) for each in starts):
        return {}
    words = [each if isinstance(each, str) else "state" for each in starts]
    return {"start_words": " ".join(words)}


def check_varied_can_be_followed(
    varied: Varied, starts: Sequence[GivenStart], *, settling: bool = True
) -> None:
    """Check each speed, each clearance and each start once, and the largest damping."""
    rotors = varied.extremes()
    # rest on the axis stands for words
    first, *others = [AT_REST if isinstance(each, str) else each for each in starts]
    for rotor in rotors:
        check_can_be_followed(rotor, first, settling=settling)
    for start in others:
        check_can_be_followed(rotors[0], start, settling=settling)
