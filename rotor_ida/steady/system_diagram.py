"""Bifurcation diagrams of rotor systems: settled motions by their extrema or once a revolution."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt
import xarray as xr

from rotor_ida.arrays import Column, Stop, Values
from rotor_ida.checks import check_count, check_points, check_progress
from rotor_ida.errors import InputError
from rotor_ida.model.system_parameters import SPEED
from rotor_ida.model.varied import Varied
from rotor_ida.parallel import Progress, choose
from rotor_ida.results.provenance import provenance
from rotor_ida.results.question import Question
from rotor_ida.results.rows import counted
from rotor_ida.results.studies.results import Folder
from rotor_ida.results.system_units import with_system_units
from rotor_ida.schema import STATUS, labelled, labelled_dataset
from rotor_ida.simulation.crossings import distance_extrema
from rotor_ida.simulation.sections import NAMES, checked_angle, crossings_of_system
from rotor_ida.simulation.starts import Start
from rotor_ida.simulation.systems.flow import SystemFlow
from rotor_ida.steady.grid import (
    EXPECTED,
    NO_COLUMNS,
    Columns,
    Rows,
    Task,
    check_size,
    form_of,
    labelled_points,
    reason_of,
    run_study,
)
from rotor_ida.steady.ramps import Answers, Direction, RampJob, Ramps, Row, in_order, settle_along
from rotor_ida.steady.system_sweep import (
    Turning,
    Turnings,
    VariedSystem,
    answer_at,
    checked_starts,
    places_of,
    point_of,
    warn_if_long,
    with_meanings,
)

USUAL_REVOLUTIONS = 64
# Error of the times of extrema, in revolutions: a distance is stationary there.
WITHIN = 1e-8
# What a point keeps of a sweep, and of that what lies on contacts.
OF_POINT = ("response", "period", "status")
OF_CONTACT = ("radius_min", "radius_max", "largest_force", "touched")
EXTREMUM = np.dtype([("extremum_radius", np.float64), ("extremum_kind", np.int8)])


def window_of_section(revolutions: object, phase: object) -> dict[str, Any]:
    """Return the revolutions of a stroboscopic section, as arguments."""
    count = check_count("revolutions", USUAL_REVOLUTIONS if revolutions is None else revolutions)
    return {"at": "revolution", "revolutions": count, "phase": checked_angle(phase)}


def diagram_of_system(
    asked: Varied, *, at: str, revolutions: int | None, phase: float,
    starts: Sequence[Start | xr.Dataset] | xr.Dataset, direction: Direction | None,
    along: str | None, modes: int | None, rtol: float, workers: int | None, executor: str,
    study: Folder | None, progress: Progress | bool | None,
) -> xr.Dataset:  # fmt: skip
    """Compute the diagram of a rotor system: see `bifurcation_diagram`."""
    progress = check_progress(progress)
    window = _Window(**{**window_of_section(revolutions, phase), "at": at})
    if at == "extrema" and window.phase:
        raise InputError(f"phase must be left out with at='extrema', got {window.phase!r}")
    taken = VariedSystem.of(asked, checked_starts(starts), modes, rtol)
    varied, way = in_order(taken.varied, len(taken.starts), direction, along, SPEED)
    turnings = Turnings(varied, taken.rtol)
    stiffest = turnings.checked()
    check_size(varied, study)
    window.check_size(varied)
    warn_if_long(stiffest, varied.axes[SPEED], varied.points // varied.axes[SPEED].size)
    told = {"along": way} if way not in {"", SPEED} else {}
    question = Question("bifurcation_diagram", {
        "rotor": asked.base, "starts": taken.kept, "modes": modes, **varied.design,
        "direction": direction, **told, **window.asked, "rtol": taken.rtol,
    })  # fmt: skip
    swept, axis = point_of(stiffest), varied.dims.index(way or SPEED)
    ramps: Ramps[Turning, Start | Values, Row] = Ramps(
        varied, taken.starts, Answers(answer_at, swept), turnings.at, axis
    )
    point, event = window.columns(swept, len(varied.base.nodes))
    form = form_of("points of a bifurcation diagram", "points", point, event)
    task: Task[_Ramp, list[_Point]] = Task(
        partial(_watched, window=window, kind=point), partial(_lost, window=window, kind=point),
        _rows_of, form, point, event,
    )  # fmt: skip
    columns = run_study(
        ramps, task, question, study=study, workers=choose(executor, workers, compiled=True),
        progress=progress,
    )  # fmt: skip
    attributes = provenance({"method": "taylor", "rtol": taken.rtol}) | told | window.attributes
    attributes |= question.attribute()
    found = with_meanings(_dataset(varied, columns, attributes), varied, attributes)
    return found if direction else found.isel(direction=0, drop=True)


_Ramp = RampJob[Turning, Start | Values, Row]


class _Point(NamedTuple):
    """A point as a row, with the extrema of its nodes, if these are shown."""

    row: npt.NDArray[np.void]
    message: str
    extrema: npt.NDArray[np.void]


@dataclass(frozen=True, slots=True)
class _Window:
    """What of a settled motion is shown: its extrema, or its states once a revolution."""

    at: str
    revolutions: int
    phase: float

    @property
    def is_strobed(self) -> bool:
        """Whether states once a revolution are shown."""
        return self.at == "revolution"

    @property
    def asked(self) -> dict[str, Any]:
        """The arguments of a question."""
        more = {"phase": self.phase} if self.is_strobed else {}
        return {"at": self.at, "revolutions": self.revolutions, **more}

    @property
    def attributes(self) -> dict[str, Any]:
        """The attributes of a result, which name the section as others do."""
        asked = self.asked
        at = asked.pop("at")
        return asked | ({"section": at} if self.is_strobed else {})

    @property
    def crossings(self) -> int:
        """How many states once a revolution there are."""
        return self.revolutions + (0 if self.phase else 1)

    def check_size(self, varied: Varied) -> None:
        """Refuse more states than fit into memory."""
        if self.is_strobed:
            sizes = len(NAMES), self.crossings, len(varied.base.nodes)
            check_points(*varied.axes.values(), *map(np.arange, sizes))

    def columns(
        self, swept: np.dtype[np.void], nodes: int
    ) -> tuple[np.dtype[np.void], np.dtype[np.void]]:
        """Return the columns of a point, and of an extremum, by those of a point of a sweep."""
        kept = [(name, swept[name]) for name in (*OF_POINT, *OF_CONTACT)]
        if self.is_strobed:
            crossed = [(name, np.float64, (self.crossings, nodes)) for name in NAMES]
            return np.dtype([*kept, *crossed]), NO_COLUMNS
        counts = [("event_count", np.int64), ("extremum_count", np.int64, (nodes,))]
        return np.dtype([*kept, *counts]), EXTREMUM

    def watch(self, row: np.void, point: Turning, end: Values, stop: Stop) -> npt.NDArray[np.void]:
        """Watch the motion after the end of one that has settled; return extrema of its nodes."""
        flow = SystemFlow.at(*point, stop)
        state = end / flow.scales
        if self.is_strobed:
            _, states = crossings_of_system(
                flow, state, self.revolutions, self.at, self.phase, None
            )
            for name, each in zip(NAMES, states, strict=True):
                row[name] = each
            return np.empty(0, EXTREMUM)
        rows = flow.problem.found.rows_in_y(flow.problem.assembly.node_rows())
        found = distance_extrema(
            flow, state, self.revolutions * flow.revolution, rows[:, 0] + 1j * rows[:, 1],
            np.zeros(len(rows), complex), WITHIN,
        )  # fmt: skip
        row["extremum_count"], row["event_count"] = found.counts, found.times.size
        extrema = np.empty(found.times.size, EXTREMUM)
        extrema["extremum_radius"], extrema["extremum_kind"] = found.distances, found.kinds
        return extrema


def _watched(ramp: _Ramp, stop: Stop, *, window: _Window, kind: np.dtype[np.void]) -> list[_Point]:
    """Follow one ramp, and watch a motion after the end of each of its points."""
    points = []
    for turning, settled in zip(ramp.points, settle_along(ramp, stop), strict=False):
        point = _begun(settled, window, kind)
        if settled.end is not None:
            try:
                extrema = window.watch(point.row[0], turning, settled.end, stop)
                point = point._replace(extrema=extrema)
            except EXPECTED as error:
                point.row["status"] = STATUS["failed"]
                point = point._replace(message=reason_of(error))
        points.append(point)
    return points


def _begun(settled: Row, window: _Window, kind: np.dtype[np.void]) -> _Point:
    """Return a point of a sweep as one of a diagram of which nothing is shown yet."""
    row = np.zeros(1, kind)
    for name in (*OF_POINT, *OF_CONTACT):
        row[name] = settled.values[name]
    if window.is_strobed:
        for name in NAMES:
            row[name] = math.nan
    return _Point(row, settled.message, np.empty(0, EXTREMUM))


def _lost(ramp: _Ramp, reason: str, *, window: _Window, kind: np.dtype[np.void]) -> list[_Point]:
    """Return the points of a ramp whose workers died."""
    return [
        _begun(ramp.settling.failed(point, ramp.start, reason), window, kind)
        for point in ramp.points
    ]


def _rows_of(points: Sequence[_Point]) -> Rows:
    """Return points as rows, and the extrema of all."""
    return Rows(
        np.concatenate([point.row for point in points]), [point.message for point in points],
        np.concatenate([point.extrema for point in points]),
    )  # fmt: skip


def _dataset(varied: Varied, columns: Columns, attributes: Mapping[str, Any]) -> xr.Dataset:
    """Return the points of a diagram as a labelled dataset."""
    system = varied.base
    behind: dict[str, tuple[str, ...]] = {
        **dict.fromkeys(OF_CONTACT, ("contact",)), "extremum_count": ("node",),
        **dict.fromkeys(NAMES, ("crossing", "node")),
    }  # fmt: skip
    variables = labelled_points(varied, columns.points, behind)
    coordinates: dict[str, Column] = varied.coordinates | places_of(varied)
    if "extremum_count" not in variables:
        coordinates["crossing"] = ("crossing", np.arange(variables[NAMES[0]].sizes["crossing"]))
        title = "Rotor system: states once a revolution over a range of speeds"
        found = labelled_dataset(
            title, variables, coordinates, attributes, kind="system_stroboscopic_diagram"
        )
        return with_system_units(found, system)
    del variables["event_count"]
    variables |= counted("extremum_count", variables["extremum_count"], "extremum")
    variables |= {name: labelled(name, "extremum", each) for name, each in columns.events.items()}
    title = "Rotor system: extrema of the distances of nodes over a range of speeds"
    found = labelled_dataset(title, variables, coordinates, attributes, kind="system_diagram")
    return with_system_units(found, system)
