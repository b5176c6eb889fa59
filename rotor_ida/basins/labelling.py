"""From starts to labels and attractors, for grids and random samples alike."""

from __future__ import annotations

import os
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

from rotor_ida.basins.attractors import Attractor, attractors_of, confirmed
from rotor_ida.basins.batches import FORM
from rotor_ida.basins.following import FollowedStarts, Starts, follow_starts
from rotor_ida.basins.kernel import Labels
from rotor_ida.basins.known import known_from_closed_forms
from rotor_ida.checks import MOST_POINTS_OF_STUDY, check_between, check_instance, check_progress
from rotor_ida.errors import InputError
from rotor_ida.model.parameters import Rotor, check_no_load
from rotor_ida.parallel import Progress, choose, interruptible
from rotor_ida.results.provenance import computing
from rotor_ida.results.studies.results import open_results
from rotor_ida.simulation.options import Options, check_can_be_followed

# The errors of a step that may be asked for [1].
TIGHTEST, LOOSEST = 1e-12, 1e-4
# Stiffer rotors take the explicit method too many steps.
MOST_DAMPING = 20.0
MOST_CONTACT_DAMPING = 50.0
# Without a study all labels are in memory.
MOST_STARTS = 100_000_000


@dataclass(frozen=True, slots=True)
class Labelled:
    """Starts as they were followed, and the attractors that their labels number.

    If nothing was interrupted, starts were followed to the attractors by CVODE with `options`; what
    is large can go to `folder`.
    """

    followed: FollowedStarts
    attractors: list[Attractor]
    options: Options
    folder: Path | None

    @property
    def rotor(self) -> Rotor:
        """The rotor."""
        return self.followed.known.rotor

    @property
    def labels(self) -> Labels:
        """Number of the attractor of each start, or a fate."""
        return self.followed.labels


def check_rotor(rotor: object, what: str = "a basin", *, one_by_one: bool = False) -> Rotor:
    """Return a rotor whose starts can be labelled: under a load only where that is `one_by_one`."""
    rotor = check_instance("rotor", rotor, Rotor)
    if not one_by_one:
        check_no_load(rotor, what)
    if rotor.omega == 0.0 < min(rotor.load, rotor.friction):
        raise InputError(
            f"omega must be above 0 for {what} under a load with friction, which holds the rotor "
            "at many places, got 0.0"
        )
    check_can_be_followed(rotor, (0.0, 0.0, 0.0, 0.0), settling=True)
    if not 0.0 < rotor.zeta <= MOST_DAMPING:
        raise InputError(
            f"zeta must be above 0, where nothing settles, and at most {MOST_DAMPING:g} for "
            f"{what}, got {rotor.zeta!r}"
        )
    if rotor.contact_damping > MOST_CONTACT_DAMPING:
        raise InputError(
            f"contact_damping must be at most {MOST_CONTACT_DAMPING:g} for {what}, got "
            f"{rotor.contact_damping!r}"
        )
    return rotor


def label(
    rotor: Rotor,
    starts: Starts,
    count: int,
    design: Mapping[str, object],
    *,
    rtol: object,
    workers: int | None,
    executor: str,
    study: str | os.PathLike[str] | None,
    progress: Progress | None,
    drawn: bool = False,
) -> Labelled:
    """Follow so many starts of a rotor, each to its attractor.

    `starts` gives those from one number up to another, as (4, n), of `drawn` ones the same however
    many there are; `design` says for a study what they are.
    """
    check_rotor(rotor, "fractions" if drawn else "a basin", one_by_one=drawn)
    most = MOST_STARTS if study is None else MOST_POINTS_OF_STUDY
    if count > most:
        raise InputError(f"starts must be at most {most}, got {count}: a study keeps more on disk")
    check_progress(progress)
    tolerance = None if rtol is None else check_between("rtol", rtol, TIGHTEST, LOOSEST)
    place, several = choose(executor, workers, compiled=True)
    options = Options()
    with open_results(study, {**design, **_design(rotor, tolerance, options)}, count, FORM) as kept:
        known = interruptible(lambda stop: known_from_closed_forms(rotor, stop))
        found = follow_starts(
            known, starts, count, kept,
            tolerance=tolerance, workers=several, executor=place, progress=progress, drawn=drawn,
        )  # fmt: skip
        attractors = attractors_of(found)
        if not found.interrupted:
            try:
                attractors = confirmed(found, attractors, starts, options)
            except KeyboardInterrupt:  # labels without confirmation are better than none
                if study is not None:
                    raise
                found.interrupted = True
        return Labelled(found, attractors, options, kept.folder)


def _design(rotor: Rotor, rtol: float | None, options: Options) -> dict[str, object]:
    """Return what decides on the bits of the labels beside the starts."""
    return {**rotor.given, "rtol": rtol, "confirmed_with_rtol": options.rtol, **computing()}
