"""Basins of attraction on a plane of starts: a quick preview, then coarse and fine results."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from functools import lru_cache

import numpy as np
import numpy.typing as npt
import xarray as xr

from rotor_ida.basins.basin import basin
from rotor_ida.basins.disc import first_look
from rotor_ida.basins.subjects import check_rotor
from rotor_ida.explorer.cases import Node
from rotor_ida.explorer.messages import Answer, Question
from rotor_ida.model.rotor import Rotor
from rotor_ida.parallel import interruptible
from rotor_ida.schema import RESPONSE, by_number

# Starts along each side of the plane: of the preview, which only decides starts that reach a whirl
# within a short time; of a coarse picture with a larger step error; and of the final one.
FIRST, COARSE, FINE = 32, 48, 144
LOOKED = 150.0
RTOL = 1e-6
RADII = ("amplitude", "radius_min", "radius_max")
# Pictures that are kept: who goes back to a rotor, or reloads the page, need not wait again.
KEPT = 32


def show_starts(question: Question) -> Iterator[Answer]:
    """Yield the basins over starts in x and y with the velocity of the start."""
    rotor = question.rotor
    check_rotor(rotor, loaded=True)
    pictures = ((COARSE, RTOL), (FINE, None))
    if max(rotor.friction, rotor.load) > 0.0:  # the preview decides nothing, and starts take long
        pictures = ((COARSE // 2, RTOL), (COARSE, None))
    else:
        yield _first_look(question)
    for count, rtol in pictures:
        labels, attractors = _basins(rotor, question.reach, *question.start[2:], count, rtol)
        yield _picture(question, labels, attractors, finest=rtol is None)


@lru_cache(KEPT)
def _basins(
    rotor: Rotor, reach: float, vx: float, vy: float, count: int, rtol: float | None
) -> tuple[npt.NDArray[np.integer], Sequence[dict[str, object]]]:
    """Return the labels of the starts by (x, y), and the attractors."""
    axis = _middles(reach, count)
    basins = basin(
        rotor, x=axis, y=axis, vx=vx, vy=vy, rtol=rtol, workers=1, executor="serial"
    )  # fmt: skip
    if basins.attrs["interrupted"]:
        raise KeyboardInterrupt  # labels that are not complete are neither shown nor kept
    return basins["label"].transpose("x", "y").values, _attractors(basins)


def _first_look(question: Question) -> Answer:
    """Return the starts that reach a whirl soon; the others stay undecided."""
    axis = _middles(question.reach, FIRST)
    states = np.empty((4, FIRST, FIRST))
    states[0], states[1] = axis[:, None], axis
    states[2], states[3] = question.start[2], question.start[3]
    basins = interruptible(
        lambda stop: first_look(question.rotor, states.reshape(4, -1), LOOKED, stop)
    )
    attractors: list[dict[str, object]] = [
        {"kind": kind, **{name: float(row[name]) for name in RADII}}
        for kind, row in zip(basins.kinds, basins.rows, strict=True)
    ]
    return _picture(question, basins.labels, attractors, finest=False)


def _picture(
    question: Question, labels: npt.NDArray[np.integer], attractors: Sequence[dict[str, object]],
    *, finest: bool,
) -> Answer:  # fmt: skip
    """Return the labels of the starts by (x, y), and their meanings; negative is undecided."""
    facts: dict[str, object] = {
        **Node(question).facts,
        "reach": question.reach,
        "count": round(labels.size**0.5),
        "finest": finest,
        "attractors": [
            {**each, "fraction": float((labels == number).mean())}
            for number, each in enumerate(attractors)
        ],
        "undecided": float((labels < 0).mean()),
    }
    return Answer("basin", facts, {"label": labels.astype(np.int8).ravel()})


def _middles(reach: float, count: int) -> npt.NDArray[np.float64]:
    """Return the middles of equal parts of the plane's side."""
    return reach * ((2.0 * np.arange(count) + 1.0) / count - 1.0)


def _attractors(basins: xr.Dataset) -> list[dict[str, object]]:
    kinds = basins["kind"].values.tolist()
    columns = {name: basins[name].values.tolist() for name in RADII}
    kind_of = by_number(RESPONSE)
    return [
        {"kind": kind_of[kind], **{name: columns[name][number] for name in RADII}}
        for number, kind in enumerate(kinds)
    ]
