"""Ask the question of an archived result again, and compare the answer with the archive."""

from __future__ import annotations

import numpy as np
import xarray as xr

from rotor_ida.errors import InputError
from rotor_ida.model.parameters import ALL_PARAMETERS, PARAMETERS
from rotor_ida.model.rotor_system import RotorSystem
from rotor_ida.parallel import Progress, shows_progress
from rotor_ida.results.archived_system import NAMES, PROBLEM
from rotor_ida.results.dataset_kinds import kind_of, why_not
from rotor_ida.results.question import Question
from rotor_ida.results.si_units import dimensionless, in_units_of
from rotor_ida.signals.path import rotating
from rotor_ida.simulation.options import Method
from rotor_ida.texts import printable
from rotor_ida.verification.comparison_rules import VERIFIED, Verification
from rotor_ida.verification.variables import (
    NOT_BY_METHOD,
    compare_attributes,
    compare_variables,
    missing_in,
)
from rotor_ida.verification.without_question import read_question

# Relative differences allowed for another method, whose extrema may be those of its samples.
TOLERANCE_OF_OTHERS = 1e-4
# Functions whose samples are computed again, those that they chose themselves too.
SAMPLED = ("simulate", "run_up", "drop")


@shows_progress
def rerun(
    dataset: xr.Dataset,
    *,
    method: Method | None = None,
    workers: int | None = None,
    progress: Progress | bool | None = None,
) -> xr.Dataset:
    """Compute a result again from its attributes, or by another method.

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
        If the dataset is not such a result, or its attributes are invalid.

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
    """Return the question that a result answers; refuse one that cannot be asked again."""
    _verification_of(dataset)
    plain = dimensionless(dataset)
    try:
        kept = Question.of_result(plain)
        if kept is not None and _fits(kept, plain):
            sampled = {"samples": plain["t"].values} if kept.verb in SAMPLED else {}
            return Question(kept.verb, {**kept.arguments, **sampled})
        return read_question(plain)
    except (KeyError, IndexError, TypeError, ValueError) as error:
        kind = kind_of(dataset)
        raise InputError(f"this {kind} cannot be verified: {error}") from error


def _fits(question: Question, dataset: xr.Dataset) -> bool:
    """Return whether a question is that of a result: no part was taken, and no parameter added."""
    rotor = question.arguments.get("rotor")
    known = {*question.arguments, *getattr(rotor, "given", ())}
    added = not isinstance(rotor, RotorSystem) and any(
        name in dataset.coords and name not in known for name in ALL_PARAMETERS
    )
    axes = {name: each for name, each in question.arguments.items()
            if name in dataset.indexes and not isinstance(each, str)}  # fmt: skip
    return not added and all(np.size(each) == dataset.sizes[name] for name, each in axes.items())


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
    left_out = {**verification.left_out(again, archived)}
    tolerance = verification.tolerance(archived)
    if by_other := "method" in verification.attributes and len(_methods(again, archived)) > 1:
        left_out |= dict.fromkeys(missing_in(again, archived), NOT_BY_METHOD)
        tolerance = max(tolerance, TOLERANCE_OF_OTHERS)
    more, others = verification.also(again), verification.also(archived)
    found = compare_variables(
        again.assign(more), archived.assign(others), left_out=left_out, tolerance=tolerance,
        told=verification.told(archived),
    )  # fmt: skip
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


def _methods(*results: xr.Dataset) -> set[object]:
    """Return the methods by which results were asked for."""
    kept = [Question.of_result(each) for each in results]
    if None not in kept:
        return {each.arguments.get("method") for each in kept if each is not None}
    return {each.attrs.get("method") for each in results}


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
    """Return how a result is verified; refuse one that cannot be, or that lacks variables."""
    kind = kind_of(dataset)
    verification = VERIFIED.get(kind)
    if verification is None:
        command = str(dataset.attrs.get("command", ""))
        way = f": {printable(command)}" if command.startswith("rotor-ida ") else ""
        raise InputError(
            f"a result of the kind {kind!r}{why_not(dataset)} cannot be verified: compute it "
            f"again, and compare{way}"
        )
    missing = [name for name in verification.variables if name not in dataset.variables]
    of_disc = () if "contact_node" in dataset.variables else PARAMETERS
    needed = [name for name in verification.attributes if name not in PARAMETERS or name in of_disc]
    missing += [name for name in needed if name not in dataset.attrs]
    if set(PROBLEM) <= set(verification.variables):  # of a rotor system
        missing += [name for name in NAMES if name not in dataset.variables]
    if missing:
        raise InputError(f"this {kind} cannot be verified: it lacks {', '.join(missing)}")
    words = [name for name in verification.variables if dataset[name].dtype.kind not in "iuf"]
    if words:
        raise InputError(f"{words[0]} must be numbers, got {dataset[words[0]].dtype}")
    return verification
