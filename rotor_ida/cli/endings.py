"""How sweeps, basins and samples ended: the answer, and what there is to say of the rest."""

from __future__ import annotations

from dataclasses import replace

import xarray as xr

from rotor_ida.cli.answer import answer
from rotor_ida.cli.report import FAILED, INTERRUPTED, Report
from rotor_ida.cli.studied import going_on
from rotor_ida.cli.targets import Targets


def answered(dataset: xr.Dataset, targets: Targets, *, as_json: bool) -> Report:
    """Return the report on what was computed: a result that is not whole is trouble."""
    if "status" in dataset:
        return answer(dataset, targets, as_json=as_json, trouble=_failures(dataset))
    missing = int(dataset["not_computed_count"])
    if not missing and not dataset.attrs["interrupted"]:
        return answer(dataset, targets, as_json=as_json)
    study = None if targets.study is None else str(targets.study)
    trouble = f"{_reason(dataset, missing)}{going_on(study)}"
    status = INTERRUPTED if dataset.attrs["interrupted"] else FAILED
    if targets.study is not None:  # it goes on, and has a result when it is done
        targets = replace(targets, out=None, study=None, figure=None)
    return answer(dataset, targets, as_json=as_json, trouble=trouble, status=status)


def _failures(dataset: xr.Dataset) -> str:
    failed = dataset["status"].values != 0
    if not failed.any():
        return ""
    first = dataset["message"].values[failed][0]
    return f"{failed.sum()} of {failed.size} points failed; the first: {first}"


def _reason(dataset: xr.Dataset, missing: int) -> str:
    total = dataset["label"].size if "label" in dataset else int(dataset.attrs["starts"])
    done = f"{total - missing} of {total} starts are done"
    if dataset.attrs["interrupted"]:
        return f"interrupted: {done}"
    return f"{done}: {dataset.attrs.get('not_computed_reason', '')}"
