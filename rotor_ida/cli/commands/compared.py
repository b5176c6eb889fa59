"""The command compare."""

from __future__ import annotations

import os

import rotor_ida
from rotor_ida.cli import options
from rotor_ida.cli.archives import read
from rotor_ida.cli.report import Report
from rotor_ida.cli.targets import check_targets
from rotor_ida.errors import InputError


def compare(
    file: options.File,
    /,
    *,
    out: options.Out = None,
    as_json: options.AsJson = False,
    force: options.Force = False,
) -> Report:
    """Hold an archived sweep against the exact synchronous whirls.

    Of the sweep that the example of sweep wrote:

        rotor-ida compare sweep.nc --out compared.nc
    """
    targets = check_targets(out=out, force=force)
    if targets.out is not None and os.path.realpath(targets.out) == os.path.realpath(file):
        raise InputError(f"out must not be the file that is compared, got {out!r}")
    from rotor_ida.cli.answer import answer  # noqa: PLC0415 - heavy, and not for --help

    compared = rotor_ida.compare(read(file))
    return answer(compared, targets, as_json=as_json)
