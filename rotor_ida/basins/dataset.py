"""Datasets of basins: the attractors of the starts of a rotor, on a grid or as fractions."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import numpy.typing as npt
import xarray as xr

from rotor_ida.arrays import Column, Values
from rotor_ida.basins.attractors import OF_DISC, Followed, family_of, reported
from rotor_ida.basins.following import followed_by, labelled_how
from rotor_ida.basins.kernel import NOT_COMPUTED, Labels
from rotor_ida.basins.starts import Box, Plane, stretches
from rotor_ida.basins.subjects import Subjects
from rotor_ida.model.rotor import Rotor
from rotor_ida.results.provenance import provenance
from rotor_ida.results.question import Question
from rotor_ida.results.si_units import with_system_units
from rotor_ida.results.studies.arrays import scratch
from rotor_ida.schema import FATE, RESPONSE, labelled, labelled_dataset
from rotor_ida.simulation.options import Options
from rotor_ida.steady.points import VariedSystem

# Dimensions of the numbers of an attractor of a rotor system besides the attractor.
BEHIND = VariedSystem.behind
ENTROPIES = ("basin_entropy", "boundary_entropy")
# Width of a box of a grid, in starts.
WIDTH = 5
# A box of a random sample contains about as many starts.
IN_BOX = WIDTH * WIDTH
# Entropies are computed from at most this many starts, the first of a larger sample.
MOST_IN_ENTROPY = 1_000_000


@dataclass(frozen=True, slots=True)
class Labelled:
    """Starts of a rotor with their labels, and what a result says of them.

    Parameters
    ----------
    subjects : Subjects
        The rotor.
    followed : Followed
        The starts, and the attractors on which they end.
    options : Options or None
        How separate runs were to confirm attractors of one disc.
    folder : Path or None
        Where large arrays can be stored.
    question : Question
        The question asked.
    """

    subjects: Subjects
    followed: Followed
    options: Options | None
    folder: Path | None
    question: Question

    @property
    def family(self) -> tuple[int, ...]:
        """The numbers of the attractors in the contact-free family."""
        return family_of(self.followed.kinds)

    @property
    def possible(self) -> list[int]:
        """The numbers of the kinds of response that a motion of this rotor may have."""
        never, (point,) = {"failed", "not_found"}, self.subjects.points
        if isinstance(point, Rotor):
            rubs, tori = point.friction > 0.0, max(point.friction, point.load) > 0.0
        else:
            contacts = point.problem.assembly.contacts
            rubs, tori = any(each.friction > 0.0 for each in contacts), True
        never |= (set() if rubs else {"rolling"}) | (set() if tori else {"quasi_periodic"})
        return [number for word, number in RESPONSE.items() if word not in never]

    def dataset(
        self, title: str, variables: Mapping[str, Column | xr.Variable],
        coordinates: Mapping[str, Column], kind: str, drawn: Mapping[str, object] = {},
    ) -> xr.Dataset:  # fmt: skip
        """Return the result with these variables and what both kinds of result have."""
        followed, subjects = self.followed, self.subjects
        (point,), system = subjects.points, subjects.varied.system
        disc = point if isinstance(point, Rotor) else None
        agreement = agreement_of(followed.rechecked)
        how = labelled_how(followed.rtol, disc) | dict(subjects.told)
        how |= {} if disc is None else disc.given
        if self.options is not None and not followed.ended.interrupted:
            how |= followed_by("confirmation", self.options)
        attributes = {
            **provenance(how), **drawn, "interrupted": int(followed.ended.interrupted),
            **self.question.attribute(),
        }  # fmt: skip
        if followed.ended.reason:
            attributes["not_computed_reason"] = followed.ended.reason
        along = {"attractor": ("attractor", np.arange(len(followed.rows)))}
        found = labelled_dataset(
            f"{'Rotor in a clearance' if system is None else 'Rotor system'}: {title}",
            {**variables, **{name: ((), value) for name, value in agreement.items()}},
            {**subjects.coordinates, **coordinates, **along}, attributes, kind=kind,
        )  # fmt: skip
        return found if system is None else with_system_units(found, system)


def basin_dataset(plane: Plane, result: Labelled) -> xr.Dataset:
    """Return the attractor of each start of a plane, over the two components that vary.

    Start numbers run along the last component first. That component is the first dimension of the
    dataset, as xarray draws the first dimension upwards.
    """
    followed = result.followed
    labels, dims = followed.labels.reshape(plane.shape), tuple(plane.axes)
    times = labelled("settling_time", dims, followed.times.reshape(plane.shape))
    table = _attractor_table(followed) | _entropies(grid_entropy(labels, result.family))
    of_starts = {
        "label": _labels(labels, dims, len(followed.rows)),
        "response": _responses(labels, dims, result),
        "settling_time": times,
    }
    variables: dict[str, Column | xr.Variable] = {
        **{name: each.transpose(*dims[::-1]) for name, each in of_starts.items()}, **table,
    }  # fmt: skip
    coordinates: dict[str, Column] = {name: (name, each) for name, each in plane.axes.items()}
    coordinates |= {name: ((), value) for name, value in plane.fixed.items()}
    return result.dataset("attractor of each start", variables, coordinates, "basin")


def fractions_dataset(box: Box, result: Labelled) -> xr.Dataset:
    """Return the fractions of the drawn starts that end on each attractor and response."""
    followed, labels = result.followed, result.followed.labels
    missing, undecided, *ends = _counts(labels, len(followed.rows)).tolist()
    of_kind = dict.fromkeys(result.possible, 0) | {RESPONSE["unresolved"]: undecided}
    for kind, own in zip(followed.kinds, ends, strict=True):
        of_kind[RESPONSE[kind]] = of_kind.get(RESPONSE[kind], 0) + own
    counts = np.array(list(of_kind.values()))
    first = min(labels.size, MOST_IN_ENTROPY)
    fraction, error = _fractions(counts, labels.size - missing)
    variables: dict[str, Column | xr.Variable] = {
        **_attractor_table(followed),
        **_entropies(sample_entropy(box.starts(0, first), labels[:first], result.family)),
        "response_count": ("response", counts),
        "response_fraction": ("response", fraction),
        "response_fraction_error": ("response", error),
    }
    coordinates = {"response": ("response", np.array(list(of_kind), dtype=np.int8))}
    return result.dataset(
        "fractions of starts", variables, coordinates, "basin_fractions", box.attributes
    )


def _entropies(values: tuple[float, float]) -> dict[str, Column]:
    return {name: ((), one) for name, one in zip(ENTROPIES, values, strict=True)}


def agreement_of(rechecked: npt.NDArray[np.int64]) -> dict[str, float]:
    """Return the number of recomputed labels, and the fraction of them that are unchanged."""
    count, alike = rechecked.tolist()
    return {"agreement": alike / count if count else math.nan, "agreement_count": count}


def _labels(labels: Labels, dims: tuple[str, ...], count: int) -> xr.Variable:
    variable = labelled("label", dims, labels)
    variable.attrs["flag_values"] = np.array([*FATE.values(), *range(count)], dtype=np.int16)
    numbered = [f"attractor_{number}" for number in range(count)]
    variable.attrs["flag_meanings"] = " ".join([*FATE, *numbered])
    return variable


def _responses(labels: Labels, dims: tuple[str, ...], result: Labelled) -> xr.Variable:
    """Return the kind of response of each start; those not computed have a separate number."""
    kinds = result.followed.rows["response"]
    # the two fates are at the end of the table, where negative indices find them
    table = np.array([*kinds, FATE["not_computed"], RESPONSE["unresolved"]], dtype=np.int8)
    responses = scratch(labels.shape, np.int8, result.folder)
    flat, found = labels.reshape(-1), responses.reshape(-1)
    for stretch in stretches(flat.size):
        found[stretch] = table[flat[stretch]]
    variable = labelled("response", dims, responses)
    words = {**RESPONSE, "not_computed": FATE["not_computed"]}
    variable.attrs["flag_values"] = np.array(list(words.values()), dtype=np.int8)
    variable.attrs["flag_meanings"] = " ".join(words)
    return variable


def _attractor_table(followed: Followed) -> dict[str, Column]:
    labels, rows = followed.labels, followed.rows
    missing, undecided, *ends = _counts(labels, len(rows)).tolist()
    counts = np.array(ends, dtype=np.int64)
    fraction, error = _fractions(np.array([*counts, undecided]), labels.size - missing)
    names = (*reported(rows.dtype), *(("confirmed",) if rows.dtype == OF_DISC else ()))
    return {
        "kind": ("attractor", rows["response"]),
        **{name: (("attractor", *(BEHIND[name] if rows[name].ndim > 1 else ())), rows[name])
           for name in names},
        "count": ("attractor", counts),
        "fraction": ("attractor", fraction[:-1]),
        "fraction_error": ("attractor", error[:-1]),
        "undecided_count": ((), undecided),
        "undecided_fraction": ((), fraction[-1]),
        "not_computed_count": ((), missing),
    }  # fmt: skip


def _counts(labels: Labels, attractors: int) -> npt.NDArray[np.int64]:
    """Return how many starts were not computed, are undecided, and end on each attractor."""
    flat, first = labels.reshape(-1), min(FATE.values())
    counts = np.zeros(attractors - first, dtype=np.int64)
    for stretch in stretches(flat.size):
        counts += np.bincount(flat[stretch] - first, minlength=counts.size)
    return counts


def _fractions(counts: npt.NDArray[np.int64], total: int) -> tuple[Values, Values]:
    """Return fractions and the standard error ``sqrt(p (1 - p)/n)`` of a random sample."""
    if total == 0:
        nothing = np.full(counts.size, math.nan)
        return nothing, nothing.copy()
    fraction = counts / total
    return fraction, np.sqrt(fraction * (1.0 - fraction) / total)


def grid_entropy(labels: Labels, alike: Sequence[int] = ()) -> tuple[float, float]:
    """Return basin and boundary entropy of a grid of starts, in complete boxes of 5 by 5.

    The labels `alike` count as one.

    References
    ----------
    A. Daza et al., "Basin entropy: a new tool to analyze uncertainty in dynamical systems",
    Scientific Reports 6, 2016, 31416.

    Examples
    --------
    >>> halves = np.zeros((10, 20), dtype=np.int16)
    >>> halves[:, 8:] = 1
    >>> [round(value, 4) for value in grid_entropy(halves)]
    [0.1683, 0.673]
    """
    rows, columns = (size // WIDTH for size in labels.shape)
    if not rows or not columns:
        return math.nan, math.nan
    # one row of boxes at a time: a grid may be larger than memory
    total, mixed, boxes = 0.0, 0, 0
    for row in range(rows):
        strip = labels[row * WIDTH : (row + 1) * WIDTH, : columns * WIDTH]
        own = np.asarray(strip).reshape(WIDTH, columns, WIDTH).swapaxes(0, 1)
        entropies = _entropy_of_boxes(own.reshape(columns, IN_BOX), alike)
        total += float(np.nansum(entropies))
        mixed += int((entropies > 0.0).sum())
        boxes += int(np.isfinite(entropies).sum())
    return _means(total, mixed, boxes)


def sample_entropy(
    states: Values, labels: Labels, alike: Sequence[int] = ()
) -> tuple[float, float]:
    """Return basin and boundary entropy of random starts, in boxes of about 25 of them.

    The sample is halved repeatedly at the median of one component after the other, so all boxes
    contain the same share of any distribution. States have the shape (4, n). The labels `alike`
    count as one.
    """
    varied = states[np.ptp(states, axis=1) > 0.0]
    if labels.size < IN_BOX or not varied.size:
        return math.nan, math.nan
    boxes = [np.arange(labels.size)]
    for turn in range(round(math.log2(labels.size / IN_BOX))):
        component = varied[turn % len(varied)]
        boxes = [
            half for box in boxes
            for half in np.array_split(box[np.argsort(component[box], kind="stable")], 2)
        ]  # fmt: skip
    widest = max(box.size for box in boxes)
    table = np.full((len(boxes), widest), NOT_COMPUTED, dtype=np.int16)
    for row, box in zip(table, boxes, strict=True):
        row[: box.size] = labels[box]
    entropies = _entropy_of_boxes(table, alike)
    own = entropies[np.isfinite(entropies)]
    return _means(float(own.sum()), int((own > 0.0).sum()), own.size)


def _entropy_of_boxes(boxes: Labels, alike: Sequence[int]) -> Values:
    """Return the entropy of each row of labels; NaN for a row without computed labels."""
    if len(alike) > 1:
        boxes = np.where(np.isin(boxes, alike), alike[0], boxes)
    known = boxes != NOT_COMPUTED
    total = known.sum(axis=1)
    entropies = np.where(total > 0, 0.0, np.nan)
    for label in np.unique(boxes[known]).tolist():
        part = (boxes == label).sum(axis=1) / np.maximum(total, 1)
        entropies -= part * np.log(np.where(part > 0.0, part, 1.0))
    return entropies


def _means(total: float, mixed: int, boxes: int) -> tuple[float, float]:
    """Return the mean over all boxes, and over those with more than one attractor."""
    if not boxes:
        return math.nan, math.nan
    return total / boxes, total / mixed if mixed else 0.0
