"""How exact whirls of one disc, their folds and Hopf points are verified."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial

import xarray as xr

from rotor_ida.closed_forms.folds import folds
from rotor_ida.closed_forms.hopf import hopf_points
from rotor_ida.closed_forms.synchronous import synchronous_response
from rotor_ida.model.parameters import ALL_PARAMETERS
from rotor_ida.parallel import Progress
from rotor_ida.verification.verify import Verdict, Verification
from rotor_ida.verification.verify_motions import axes_in


def _again(
    compute: Callable[..., xr.Dataset],
    dataset: xr.Dataset,
    _workers: int | None,
    _progress: Progress | None,
) -> xr.Dataset:
    return compute(**axes_in(dataset))


def _nothing_else(_again: xr.Dataset, _archived: xr.Dataset) -> Verdict:
    return {}, ""


def _of(compute: Callable[..., xr.Dataset], *needed: str) -> Verification:
    return Verification(needed, (), partial(_again, compute), _nothing_else, tuple(ALL_PARAMETERS))


WHIRLS = _of(synchronous_response, "amplitude", "omega", "zeta", "delta0")
FOLDS = _of(folds, "fold_omega", "zeta", "delta0")
HOPF_POINTS = _of(hopf_points, "hopf_omega", "zeta", "delta0")
