"""Ask the question of an archived result again, and compare the answer with the archive."""

from __future__ import annotations

from typing import Any

import numpy as np
import xarray as xr

from rotor_ida.errors import InputError
from rotor_ida.model.system_parameters import SPEED
from rotor_ida.parallel import Progress, shows_progress
from rotor_ida.results.archived_system import system_of
from rotor_ida.results.dataset_kinds import kind_of, why_not
from rotor_ida.results.question import MATRIX, SAMPLED, Question
from rotor_ida.results.rows import own_rows
from rotor_ida.results.si_units import dimensionless, in_units_of
from rotor_ida.schema import QUANTITIES
from rotor_ida.signals.path import rotating
from rotor_ida.simulation.options import Method
from rotor_ida.texts import printable
from rotor_ida.verification.comparison_rules import VERIFIED, Verification
from rotor_ida.verification.variables import (
    NOT_BY_METHOD,
    OF_METHOD,
    compare_attributes,
    compare_variables,
    missing_in,
)

# Relative differences allowed for another method, whose extrema may be those of its samples.
TOLERANCE_OF_OTHERS = 1e-4
# Functions whose answer at a point depends on the other points.
OF_A_WHOLE = ("basin", "continue_attractors")
OF_RANGE = "depends on the whole range of speeds"


@shows_progress
def rerun(
    dataset: xr.Dataset,
    *,
    method: Method | None = None,
    workers: int | None = None,
    progress: Progress | bool | None = None,
) -> xr.Dataset:
    """Compute a result again from the question that it keeps, or by another method.

    Parameters
    ----------
    dataset : Dataset
        A result, for example one loaded from an archive: a run, sweep, run-ups, a basin, a cycle,
        its branch or bifurcation curve, also of rotor systems, or an exact result of a rotor
        system. `rotor_ida.results.dataset_kinds` lists the kinds that can be verified.
    method : {"adams", "bdf", "ida", "taylor"}, optional
        Another solver for the contacts of a run, sweep or run-up: an independent check that shares
        no step with the first.
    workers, progress
        As for the function that computed it; not used for a single run or cycle.

    Returns
    -------
    Dataset
        The same result, computed again and dimensionless; an atlas without its shocks.

    Raises
    ------
    InputError
        If the dataset is not such a result, or does not keep a valid question.

    Examples
    --------
    >>> from rotor_ida import Rotor, simulate
    >>> from rotor_ida.testing import assert_events_close
    >>> rotor = Rotor(omega=2.0, zeta=0.07, delta0=2.0)
    >>> run = simulate(rotor, start=(0, 0, 0, 0), duration=20.0)
    >>> assert_events_close(rerun(run, method="taylor"), run)
    """
    question = question_of(dataset)
    if method is not None:
        if "method" not in question.arguments:
            kind = kind_of(dataset)
            raise InputError(f"method must be left out for the kind {kind}, got {method!r}")
        flight = {"flight": "exact"} if "flight" in question.arguments else {}
        changed = {"method": method} | (flight if method == "taylor" else {})
        question = Question(question.verb, {**question.arguments, **changed})
    found = question.ask(workers=workers, progress=progress)
    return rotating(found) if "rotating_x" in dataset and "event_time" in dataset else found


def question_of(dataset: xr.Dataset) -> Question:
    """Return the question that a result answers; refuse one that cannot be asked again.

    Of a part of a result, it is the question with the values that are left of each axis.
    """
    _verification_of(dataset)
    plain = dimensionless(dataset)
    kept = Question.of_result(plain)
    if kept is None:
        raise InputError(f"this {kind_of(dataset)} cannot be verified: it lacks its question")
    left = _left(plain)
    if kept.arguments.get("direction") and kept.arguments.get("along", SPEED) in left:
        raise InputError(
            "a part of a sweep up or down cannot be verified: each point begins where the one "
            "before it ended"
        )
    if left and kept.verb in OF_A_WHOLE:
        raise InputError(f"a part of this {kind_of(dataset)} cannot be verified: verify the whole")
    if kept.verb in SAMPLED:
        if "t" not in plain.variables:
            raise InputError(f"this {kind_of(dataset)} cannot be verified: it lacks t")
        left["samples"] = plain["t"].values
    if MATRIX in plain.variables and "rotor" not in kept.arguments:  # of a large system
        left["rotor"] = system_of(plain)
    return Question(kept.verb, {**kept.arguments, **left})


def _left(plain: xr.Dataset) -> dict[str, Any]:
    """Return the values that are left of each axis of a part of a result, by its argument."""
    question = Question.of_result(plain)
    return {
        name: plain[name].values for name, each in (question.arguments if question else {}).items()
        if name in plain.coords and isinstance(each, tuple) and plain[name].size <= len(each)
        and not np.array_equal(plain[name], each) and np.isin(plain[name], each).all()
    }  # fmt: skip


def _as_part(again: xr.Dataset, archived: xr.Dataset) -> xr.Dataset:
    """Return a result without the axes of which the archive has a point; refuse other parts."""
    again = again.squeeze([
        dim for dim, size in again.sizes.items()
        if size == 1 and dim in archived.coords and not archived[dim].ndim
    ])  # fmt: skip
    for name in [each for each in (*again.indexes, "event_time") if each in archived.variables]:
        whole, part = (each[name].values for each in (again, archived))
        is_other = part.size <= whole.size and not np.array_equal(part, whole)
        if is_other and np.isin(part, whole).all():
            dim = str(name).removesuffix("_time")
            raise InputError(f"a part of a result along {dim} cannot be verified: verify the whole")
    return again


def _without_empty(part: xr.Dataset, again: xr.Dataset) -> xr.Dataset:
    """Return a part of a result without places that only others fill, as that of a third whirl."""
    for dim, size in again.sizes.items():
        if size < part.sizes.get(dim, 0):
            rest = part.isel({dim: slice(size, None)}).data_vars.values()
            if all(
                each.isnull().all() for each in rest if dim in each.dims and each.dtype.kind == "f"
            ):
                part = part.isel({dim: slice(size)})
    return part


def differences(again: xr.Dataset, archived: xr.Dataset) -> dict[str, object]:
    """Compare a result computed again with that of the archive.

    Parameters
    ----------
    again, archived : Dataset
        Two results of the same kind; those in SI units are compared as dimensionless.

    Returns
    -------
    dict
        ``agrees``, and ``trouble``, the first difference in words. ``variables``, the number of
        variables that were compared, and ``not_compared``, the others with the reason.
        ``attributes``, the names of those that were compared, and ``attributes_not_compared``. The
        numbers
        of values ``compared`` and ``differing``, and the ``largest_difference``, relative to the
        largest number of its variable. For runs instead the numbers of events, the largest
        difference between event times and the largest error stated for one [dimensionless].
        ``core``: whether the compiled core is the same; another one gives different last bits.

    Examples
    --------
    >>> from rotor_ida import Rotor, simulate
    >>> run = simulate(Rotor(omega=2.0, zeta=0.07, delta0=2.0), start=(0, 0, 0, 0), duration=20.0)
    >>> differences(rerun(run), run)["agrees"]
    True
    """
    verification = _verification_of(archived)
    again, in_units, archived = dimensionless(again), archived, dimensionless(archived)
    by_other = _method(again) != _method(archived)
    _refuse_lacking(again, archived)
    is_part = bool(_left(archived))
    archived = _without_empty(own_rows(archived), again) if is_part else archived
    again = _as_part(again, archived)
    left_out = {**verification.left_out(again, archived)}
    left_out |= {"critical": OF_RANGE} if is_part else {}
    tolerance = verification.tolerance(archived.assign_attrs(rtol=again.attrs.get("rtol")))
    if by_other:
        left_out |= dict.fromkeys(missing_in(again, archived), NOT_BY_METHOD)
        tolerance = max(tolerance, TOLERANCE_OF_OTHERS)
    more, others = verification.also(again), verification.also(archived)
    both = (again.assign(more), archived.assign(others)) if more or others else (again, archived)
    found = compare_variables(
        *both, left_out=left_out, tolerance=tolerance, told=verification.told(archived)
    )
    compare_attributes(found, in_units_of(again, in_units), in_units, tolerance, by_other=by_other)
    is_result = any(name in archived.data_vars for name in found.compared)
    trouble = found.trouble or ("" if is_result else "no variable was compared")
    counts = _of_events(again, archived) if "event_time_error" in archived else {
        "compared": found.values, "differing": found.differing, "largest_difference": found.largest
    }  # fmt: skip
    # the last bits depend on the core
    same = again.attrs.get("core_sources") == archived.attrs.get("core_sources")
    return {
        "agrees": not trouble, **counts, "variables": len(set(found.compared) - more.keys()),
        "attributes": ", ".join(found.attributes),
        "attributes_not_compared": found.attributes_left_out,
        "not_compared": found.left_out, "trouble": trouble,
        "core": "the same" if same else "different from that of the archive",
    }  # fmt: skip


def _refuse_lacking(again: xr.Dataset, archived: xr.Dataset) -> None:
    """Refuse an archive without a variable of its result, or an attribute of its question."""
    question = Question.of_result(again)
    asked = question.arguments.keys() - OF_METHOD if question else set()
    missing = again.variables.keys() - archived.variables.keys()
    missing |= (again.attrs.keys() & asked) - archived.attrs.keys()
    if missing:
        names = ", ".join(sorted(map(str, missing)))
        raise InputError(f"this {kind_of(archived)} cannot be verified: it lacks {names}")


def _method(result: xr.Dataset) -> object:
    """Return the method by which a result was asked for."""
    question = Question.of_result(result)
    return question and question.arguments.get("method")


def _of_events(again: xr.Dataset, archived: xr.Dataset) -> dict[str, object]:
    """Return the numbers of events of two runs, and by how much their times differ."""
    common = min(again.sizes["event"], archived.sizes["event"])
    apart = again["event_time"].values[:common] - archived["event_time"].values[:common]
    return {
        "events": again.sizes["event"],
        "archived_events": archived.sizes["event"],
        "largest_difference": float(np.abs(apart).max(initial=0.0)),
        "largest_stated_error": float(archived["event_time_error"].values.max(initial=0.0)),
    }


def _verification_of(dataset: xr.Dataset) -> Verification:
    """Return how a result is verified; refuse one that cannot be."""
    kind = kind_of(dataset)
    verification = VERIFIED.get(kind)
    if verification is None:
        command = str(dataset.attrs.get("command", ""))
        way = f": {printable(command)}" if command.startswith("rotor-ida ") else ""
        raise InputError(
            f"a result of the kind {kind!r}{why_not(dataset)} cannot be verified: compute it "
            f"again, and compare{way}"
        )
    for name, each in dataset.variables.items():
        known = QUANTITIES.get(str(name))
        if known is not None and not known.is_text and each.dtype.kind == "O":
            raise InputError(f"{name} must be numbers, got {each.dtype}")
    return verification
