"""Datasets of basins: the attractors of the starts of a rotor, on a grid or as fractions."""

from __future__ import annotations

import math
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import numpy.typing as npt
import xarray as xr

from rotor_ida.arrays import Column, Values
from rotor_ida.basins.attractors import NUMBERS, Attractor, family_of
from rotor_ida.basins.fates import ALONE
from rotor_ida.basins.following import Ended, FollowedStarts, tighter_than
from rotor_ida.basins.kernel import NOT_COMPUTED, Labels, Times
from rotor_ida.basins.known import followed_alone, may_roll
from rotor_ida.basins.starts import Box, Plane, stretches
from rotor_ida.model.rotor import Rotor
from rotor_ida.results.provenance import provenance
from rotor_ida.results.question import Question
from rotor_ida.results.run import parameter_coordinates
from rotor_ida.results.studies.arrays import scratch
from rotor_ida.schema import FATE, RESPONSE, TRAPPING, labelled, labelled_dataset
from rotor_ida.simulation.options import Options

LABELLING = (
    "all starts followed side by side by DOP853 on the rotating axes, with the error "
    "labelling_rtol per step, until they enter a trapping region; for those that enter none, "
    "limit cycles found by Newton's method, and some orbits followed one by one by Taylor series, "
    "as in a sweep with left_over_rtol; motions that do not settle identified as chaotic by their "
    "Lyapunov exponent, or followed further; some starts labelled again with the error "
    "agreement_rtol"
)
LABELLING_RUBS = (
    "all starts followed side by side by DOP853 on the rotating axes, with the error "
    "labelling_rtol per step, while the disc slides forwards, until they enter a trapping region; "
    "the others followed from their starts one by one by Taylor series, as in a sweep with "
    "left_over_rtol, limit cycles found by Newton's method; some starts labelled again with the "
    "error agreement_rtol"
)
# The method that follows starts side by side, in the core.
LABELLING_METHOD = "dop853"
# Under a load.
ONE_BY_ONE = "every start followed separately by Taylor series, as in a sweep with labelling_rtol"
ENTROPIES = ("basin_entropy", "boundary_entropy")
# Width of a box of a grid, in starts.
WIDTH = 5
# A box of a random sample contains about as many starts.
IN_BOX = WIDTH * WIDTH
# Entropies are computed from at most this many starts, the first of a larger sample.
MOST_IN_ENTROPY = 1_000_000


@dataclass(frozen=True, slots=True, kw_only=True)
class Labelled:
    """Starts of a rotor with their labels, and the attractors that these refer to.

    Parameters
    ----------
    subject : str
        The rotor, in the titles of results.
    labels, times : ndarray, shape (n,)
        Number of the attractor of each start, or a fate; and the time at which it was decided.
    kinds : sequence of str
        The kind of each attractor.
    columns : mapping
        What else is known of the attractors: variables along the dimension ``attractor``.
    rechecked : ndarray of int64, shape (2,)
        Number of starts labelled again, and of those with the same label.
    ended : Ended
        How the computation ended.
    impossible : collection of str
        Kinds of response that no motion of this rotor has.
    how, given : mapping
        Attributes that tell how starts were labelled, and of what rotor.
    coordinates : mapping
        Coordinates of the result besides the starts.
    folder : Path or None
        Where large arrays can be stored.
    question : Question
        The question asked.
    """

    subject: str
    labels: Labels
    times: Times
    kinds: Sequence[str]
    columns: Mapping[str, Column]
    rechecked: npt.NDArray[np.int64]
    ended: Ended
    impossible: Collection[str]
    how: Mapping[str, object]
    given: Mapping[str, object]
    coordinates: Mapping[str, Column]
    folder: Path | None
    question: Question

    @property
    def family(self) -> tuple[int, ...]:
        """The numbers of the attractors in the contact-free family."""
        return family_of(self.kinds)


def labelled_starts(
    followed: FollowedStarts, attractors: Sequence[Attractor], options: Options,
    folder: Path | None, question: Question,
) -> Labelled:  # fmt: skip
    """Return followed starts of one disc; unless interrupted, CVODE confirmed its attractors."""
    rotor, impossible = followed.known.rotor, {"failed", "not_found"}
    if rotor.friction == 0.0:
        impossible.add("rolling")
        if rotor.load == 0.0:
            impossible.add("quasi_periodic")
    how = labelled_how(followed.tolerance, rotor)
    if not followed.ended.interrupted:
        how |= followed_by("confirmation", options)
    columns: dict[str, Column] = {
        name: ("attractor", np.array([getattr(each, name) for each in attractors], float))
        for name in NUMBERS
    }
    trapping = np.array([TRAPPING[each.trapping] for each in attractors], dtype=np.int8)
    confirmed = np.array([each.confirmed for each in attractors], dtype=np.int8)
    columns |= {"trapping": ("attractor", trapping), "confirmed": ("attractor", confirmed)}
    return Labelled(
        subject="Rotor in a clearance", labels=followed.labels, times=followed.times,
        kinds=[each.kind for each in attractors], columns=columns, rechecked=followed.rechecked,
        ended=followed.ended, impossible=impossible, how=how, given=rotor.given,
        coordinates=parameter_coordinates(rotor), folder=folder, question=question,
    )  # fmt: skip


def basin_dataset(plane: Plane, result: Labelled) -> xr.Dataset:
    """Return the attractor of each start of a plane, over the two components that vary.

    Start numbers run along the last component first. That component is the first dimension of the
    dataset, as xarray draws the first dimension upwards.
    """
    count = len(result.kinds)
    labels, times = result.labels.reshape(plane.shape), result.times.reshape(plane.shape)
    dims = tuple(plane.axes)
    upright = dims[::-1]
    variables = {
        "label": _labels(labels, dims, count).transpose(*upright),
        "response": _responses(labels, dims, result.kinds, result.folder).transpose(*upright),
        "settling_time": labelled("settling_time", dims, times).transpose(*upright),
        **_attractor_table(result),
        **_entropies(grid_entropy(labels, result.family)),
        **_agreement(result),
    }
    coordinates = dict(result.coordinates)
    coordinates |= {name: (name, values) for name, values in plane.axes.items()}
    coordinates |= {name: ((), value) for name, value in plane.fixed.items()}
    coordinates["attractor"] = ("attractor", np.arange(count))
    title = f"{result.subject}: attractor of each start"
    return labelled_dataset(title, variables, coordinates, _attributes(result), kind="basin")


def fractions_dataset(box: Box, result: Labelled) -> xr.Dataset:
    """Return the fractions of the drawn starts that end on each attractor and response."""
    labels, count = result.labels, len(result.kinds)
    missing, undecided, *ends = _counts(labels, count).tolist()
    of_kind = {number: 0 for word, number in RESPONSE.items() if word not in result.impossible}
    of_kind[RESPONSE["unresolved"]] = undecided
    for kind, own in zip(result.kinds, ends, strict=True):
        number = RESPONSE[kind]
        of_kind[number] = of_kind.get(number, 0) + own
    kinds, counts = list(of_kind), np.array(list(of_kind.values()))
    first = min(labels.size, MOST_IN_ENTROPY)
    fraction, error = _fractions(counts, labels.size - missing)
    variables: dict[str, Column | xr.Variable] = {
        **_attractor_table(result),
        **_entropies(sample_entropy(box.starts(0, first), labels[:first], result.family)),
        **_agreement(result),
        "response_count": ("response", counts),
        "response_fraction": ("response", fraction),
        "response_fraction_error": ("response", error),
    }
    coordinates = dict(result.coordinates)
    coordinates["attractor"] = ("attractor", np.arange(count))
    coordinates["response"] = ("response", np.array(kinds, dtype=np.int8))
    title = f"{result.subject}: fractions of starts"
    attributes = _attributes(result, box.attributes)
    return labelled_dataset(title, variables, coordinates, attributes, kind="basin_fractions")


def _agreement(result: Labelled) -> dict[str, xr.Variable]:
    attributes = agreement_of(result.rechecked)
    return {name: labelled(name, (), value) for name, value in attributes.items()}


def _entropies(values: tuple[float, float]) -> dict[str, xr.Variable]:
    return {name: labelled(name, (), one) for name, one in zip(ENTROPIES, values, strict=True)}


def labelled_how(tolerance: float, rotor: Rotor | None = None) -> dict[str, object]:
    """Return, as attributes, the method that labelled starts with a given error per step [1]."""
    if rotor is not None and followed_alone(rotor):
        return {
            "labelling": ONE_BY_ONE,
            "labelling_method": ALONE.method,
            "labelling_rtol": tolerance,
        }
    rubs = rotor is not None and may_roll(rotor)
    return {
        "labelling": LABELLING_RUBS if rubs else LABELLING,
        "labelling_method": LABELLING_METHOD,
        "labelling_rtol": tolerance,
        "left_over_method": ALONE.method,
        "left_over_rtol": ALONE.rtol,
        "agreement_rtol": tighter_than(tolerance),
    }


def followed_by(purpose: str, options: Options) -> dict[str, object]:
    """Return, as attributes, the method and tolerances with which orbits were followed."""
    return {f"{purpose}_{name}": value for name, value in options.attributes().items()}


def agreement_of(rechecked: npt.NDArray[np.int64]) -> dict[str, float]:
    """Return the number of recomputed labels, and the fraction of them that are unchanged."""
    count, alike = rechecked.tolist()
    return {"agreement": alike / count if count else math.nan, "agreement_count": count}


def _attributes(result: Labelled, drawn: Mapping[str, object] = {}) -> dict[str, object]:
    attributes = {
        **provenance(dict(result.how)),
        **result.given,
        **drawn,
        "interrupted": int(result.ended.interrupted),
        **result.question.attribute(),
    }
    if result.ended.reason:
        attributes["not_computed_reason"] = result.ended.reason
    return attributes


def _labels(labels: Labels, dims: tuple[str, ...], count: int) -> xr.Variable:
    variable = labelled("label", dims, labels)
    variable.attrs["flag_values"] = np.array([*FATE.values(), *range(count)], dtype=np.int16)
    numbered = [f"attractor_{number}" for number in range(count)]
    variable.attrs["flag_meanings"] = " ".join([*FATE, *numbered])
    return variable


def _responses(
    labels: Labels,
    dims: tuple[str, ...],
    attractors: Sequence[str],
    folder: Path | None,
) -> xr.Variable:
    """Return the kind of response of each start; those not computed have a separate number."""
    kinds = [RESPONSE[each] for each in attractors]
    # the two fates are at the end of the table, where negative indices find them
    table = np.array([*kinds, FATE["not_computed"], RESPONSE["unresolved"]], dtype=np.int8)
    responses = scratch(labels.shape, np.int8, folder)
    flat, result = labels.reshape(-1), responses.reshape(-1)
    for stretch in stretches(flat.size):
        result[stretch] = table[flat[stretch]]
    variable = labelled("response", dims, responses)
    words = {**RESPONSE, "not_computed": FATE["not_computed"]}
    variable.attrs["flag_values"] = np.array(list(words.values()), dtype=np.int8)
    variable.attrs["flag_meanings"] = " ".join(words)
    return variable


def _attractor_table(result: Labelled) -> dict[str, xr.Variable]:
    labels, kinds = result.labels, result.kinds
    missing, undecided, *ends = _counts(labels, len(kinds)).tolist()
    counts = np.array(ends, dtype=np.int64)
    fraction, error = _fractions(np.array([*counts, undecided]), labels.size - missing)
    columns: dict[str, Column] = {
        "kind": ("attractor", np.array([RESPONSE[each] for each in kinds], dtype=np.int8)),
        **result.columns,
        "count": ("attractor", counts),
        "fraction": ("attractor", fraction[:-1]),
        "fraction_error": ("attractor", error[:-1]),
        "undecided_count": ((), undecided),
        "undecided_fraction": ((), fraction[-1]),
        "not_computed_count": ((), missing),
    }
    return {name: labelled(name, *column) for name, column in columns.items()}


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
