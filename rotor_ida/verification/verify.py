"""Compute an archived result again, from its attributes, and compare it with the archive."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np
import xarray as xr

from rotor_ida.arrays import Values
from rotor_ida.checks import check_progress, shown
from rotor_ida.errors import InputError
from rotor_ida.model.parameters import ALL_PARAMETERS
from rotor_ida.model.rotor import Rotor
from rotor_ida.parallel import Progress, shows_progress
from rotor_ida.results.kinds import KINDS, kind_of, loaded, why_not
from rotor_ida.results.si_units import dimensionless
from rotor_ida.schema.quantities import TOLERANCE
from rotor_ida.simulation.options import Method
from rotor_ida.verification.variables import NOT_BY_METHOD, compare_variables, missing_in

# Relative differences allowed for another method, whose extrema may be those of its samples.
TOLERANCE_OF_OTHERS = 1e-4
# Numbers compared and differences; and the first difference in words.
Verdict = tuple[dict[str, object], str]


@dataclass(frozen=True, slots=True)
class Verification:
    """How results of one kind are computed again and compared."""

    variables: tuple[str, ...]  # numbers that are needed
    attributes: tuple[str, ...]
    again: Callable[[xr.Dataset, int | None, Progress | None], xr.Dataset]
    compared: Callable[[xr.Dataset, xr.Dataset], Verdict]
    # What it is computed from, and why other variables are not compared, by name or dimension.
    given: tuple[str, ...] = ()
    left_out: Callable[[xr.Dataset, xr.Dataset], Mapping[str, str]] = lambda _, __: {}
    tolerance: Callable[[xr.Dataset], float] = lambda _: TOLERANCE
    # Where numbers belong to the motion, on any processor.
    told: Callable[[xr.Dataset], xr.Variable | None] = lambda _: None


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
        system. `rotor_ida.results.kinds` lists the kinds that can be verified.
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
    verification = _verification_of(dataset)
    if method is not None:
        if "method" not in verification.attributes:
            kind = kind_of(dataset)
            raise InputError(f"method must be left out for the kind {kind}, got {method!r}")
        exact = {"flight": "exact"} if method == "taylor" else {}
        dataset = dataset.assign_attrs({"method": method, **exact})
    return verification.again(dimensionless(dataset), workers, check_progress(progress))


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
        variables that were compared, and ``not_compared``, the others with the reason. For runs:
        the numbers of events, the largest difference between event times and the largest error
        stated for one [1]. For other results: the number of points, starts or values of limit
        cycles compared, the number of those that differ, and the largest difference between
        amplitudes, radii, periods or other numbers, relative to the larger one. ``core``: whether
        the compiled core is the same;
        another one gives different last bits.

    Examples
    --------
    >>> from rotor_ida import Rotor, simulate
    >>> run = simulate(Rotor(omega=2.0, zeta=0.07, delta0=2.0), start=(0, 0, 0, 0), duration=20.0)
    >>> differences(rerun(run), run)["agrees"]
    True
    """
    verification = _verification_of(archived)
    again, archived = dimensionless(again), dimensionless(archived)
    counts, trouble = verification.compared(again, archived)
    left_out = {**verification.left_out(again, archived)}
    tolerance = verification.tolerance(archived)
    if again.attrs.get("method") != archived.attrs.get("method"):
        left_out |= dict.fromkeys(missing_in(again, archived), NOT_BY_METHOD)
        tolerance = max(tolerance, TOLERANCE_OF_OTHERS)
    found = compare_variables(
        again, archived, given=verification.given, left_out=left_out,
        tolerance=tolerance, told=verification.told(archived),
    )  # fmt: skip
    is_result = any(name in archived.data_vars for name in found.compared)
    trouble = trouble or found.trouble or ("" if is_result else "no variable was compared")
    counts |= {"variables": len(found.compared), "not_compared": found.left_out}
    # the last bits depend on the core
    same = again.attrs.get("core_sources") == archived.attrs.get("core_sources")
    core = "the same" if same else "different from that of the archive"
    return {"agrees": not trouble, **counts, "trouble": trouble, "core": core}


def _verification_of(dataset: xr.Dataset) -> Verification:
    """Return how a result is verified; refuse one that cannot be, or that lacks variables."""
    kind = kind_of(dataset)
    place = KINDS[kind].verified
    verification: Verification | None = loaded(place) if place else None
    if verification is None:
        command = str(dataset.attrs.get("command", ""))
        way = f" with {shown(command)}" if command.startswith("rotor-ida ") else ""
        raise InputError(
            f"a result of the kind {kind!r}{why_not(dataset)} cannot be verified: compute it "
            f"again{way}, and compare"
        )
    missing = [name for name in verification.variables if name not in dataset.variables]
    missing += [name for name in verification.attributes if name not in dataset.attrs]
    if missing:
        raise InputError(f"this {kind} cannot be verified: it lacks {', '.join(missing)}")
    words = [name for name in verification.variables if dataset[name].dtype.kind not in "iuf"]
    if words:
        raise InputError(f"{words[0]} must be numbers, got {dataset[words[0]].dtype}")
    return verification


def rotor_in(dataset: xr.Dataset, prefix: str = "") -> Rotor:
    """Return the rotor in the attributes; missing parameters have their defaults."""
    attributes = {name: f"{prefix}{name}" for name in ALL_PARAMETERS}
    given = dataset.attrs
    return Rotor(**{name: given[each] for name, each in attributes.items() if each in given})


def counts_of(compared: int, differing: int, largest: float) -> dict[str, object]:
    """Return the counts of a comparison as `differences` names them."""
    return {"compared": compared, "differing": differing, "largest_difference": largest}


def relative_differences(one: Values | float, other: Values | float, least: float = 0.0) -> Values:
    """Return the differences of numbers, relative to the larger one or to `least`.

    Numbers missing in both count as equal.
    """
    one, other = np.asarray(one), np.asarray(other)
    same = (one == other) | (np.isnan(one) & np.isnan(other))
    with np.errstate(invalid="ignore"):
        part = np.abs(one - other) / np.maximum(np.maximum(np.abs(one), np.abs(other)), least)
    return np.where(same, 0.0, np.where(np.isfinite(part), part, np.inf))
