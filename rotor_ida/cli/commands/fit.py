"""The command fit: from measured signals to the parameters of a machine."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import rotor_ida
from rotor_ida.checks import shown
from rotor_ida.cli.command import Case, command
from rotor_ida.cli.commands.plot import OF_FILE, signals_in
from rotor_ida.cli.output import troubled
from rotor_ida.cli.parsing import in_unit
from rotor_ida.cli.report import FAILED, Report
from rotor_ida.cli.rotor_options import ANY_SPEED
from rotor_ida.errors import InputError

if TYPE_CHECKING:
    import xarray as xr

# Arguments in the unit of the time or of the displacements of the signals.
IN_UNIT_OF = {"entries": "t", "exits": "t", "time_error": "t", "noise": "x"}


@command("one", label="trials", most=None, file="FILE...", reads=True)
def fit(
    case: Case, *, unknown: list[str], node: list[str] | None = None,
    times: tuple[float, float] | None = None,
) -> Report:  # fmt: skip
    r"""Fit rotor parameters to measured signals, with their errors.

    To the archive of the example of run-up; the given values are the initial guess:

        rotor-ida fit run_up.nc --zeta 0.1 --delta0 0.7 --shaft-stiffness 1.1 \
            --unknown zeta delta0 shaft_stiffness --figure fit

    Size and angle of the unbalance of a machine, from a table of probes and a keyphasor:

        rotor-ida fit probes.csv --columns x=A y=B --units x=um y=um \
            --mass 4kg --contact-stiffness 3.2e7 --damping 100 --clearance 25um \
            --shaft-stiffness 500N/mm --eccentricity 1um \
            --unknown eccentricity unbalance_angle

    A rotor system, by probes at one of its nodes; its file is the initial guess:

        rotor-ida fit rotor.toml probes.csv --node disc --columns x=A y=B \
            --units x=um y=um --start settled --unknown unbalance unbalance_angle
    """
    if not case.measured:
        raise InputError("FILE must be given")
    given = case.rotors.given
    if case.is_system:
        case.given.setdefault("start", None)  # that of the file is not the one of the record
    elif node:
        raise InputError("node must be left out without a rotor system")
    else:  # the speed is measured
        case.known = {
            speed: ANY_SPEED
            for speed, other in (("omega", "zeta"), ("speed", "mass"))
            if speed not in given and other in given
        }
    each_node: list[xr.Dataset] = []

    def with_signals(_rotor: Any, asked: dict[str, Any]) -> dict[str, Any]:
        signals = [_signals(each, case.reading, times, node) for each in case.measured]
        for one in signals:
            each_node.extend(one.values() if isinstance(one, dict) else [one])
        for name, of in IN_UNIT_OF.items():
            unit = str(each_node[0][of].attrs.get("units", "1"))
            asked[name] = _in(unit, name, asked.get(name))
        return asked | {"signals": signals, "unknown": unknown}

    case.adapted = with_signals
    found = case.ask()
    found.attrs["file"] = ", ".join(each.name for each in case.measured)
    for name in (*OF_FILE, "caption"):
        if told := dict.fromkeys(str(each.attrs[name]) for each in each_node if name in each.attrs):
            found.attrs[name] = "; ".join(told)
    report = case.report(found, rotor=_found(case.rotor, found))
    if found.attrs["search"] == "converged":
        return report
    return troubled(report, f"search {found.attrs['search']}", FAILED)


def _found(rotor: Any, fitted: xr.Dataset) -> Any:
    """Return a machine with the estimates in place of the first guesses, for a report.

    A rotor system stays as its file describes it: estimates of it are factors.
    """
    if isinstance(rotor, rotor_ida.RotorSystem):
        return rotor
    estimates = zip(fitted["unknown"].values, fitted["estimate"].values.tolist(), strict=True)
    return replace(rotor, **{str(name): each for name, each in estimates if hasattr(rotor, name)})


def _signals(
    file: Path,
    reading: Mapping[str, Any],
    times: tuple[float, float] | None,
    nodes: Sequence[str] | None,
) -> xr.Dataset | dict[str, xr.Dataset]:
    """Return the signals in a file, by node where nodes are chosen."""
    named = dict.fromkeys(filter(None, map(_node_of, reading.get("columns", []))))
    if named and nodes is not None:
        raise InputError("node must be left out with columns of nodes")
    known = named or nodes or ()
    for word in reading.get("units", []):
        if (node := _node_of(word)) and node not in known:
            raise InputError(f"units must be of the given nodes, got {shown(word)}")
    if named or ("units" in reading and nodes):
        return {node: signals_in(file, _at(reading, node), times) for node in known}
    from rotor_ida.results.checked_run import is_of_system  # noqa: PLC0415 - heavy

    signals = signals_in(file, reading, times)
    if is_of_system(signals):
        if nodes is None:
            return rotor_ida.signals_of(signals)  # which may have one node alone
        return {node: rotor_ida.signals_of(signals, node=node) for node in nodes}
    return signals if nodes is None else dict.fromkeys(nodes, signals)


def _node_of(word: str) -> str:
    """Return the node of a column or unit such as disc:x=A, empty if it has none."""
    signal, _, _ = word.partition("=")
    return signal.partition(":")[0] if ":" in signal else ""


def _at(reading: Mapping[str, Any], node: str) -> dict[str, Any]:
    """Return how a file is read at a node: by the columns and units of it, and those of no node.

    Examples
    --------
    >>> _at({"columns": ["disc:x=A", "end:x=C:1", "keyphasor=K"]}, "end")
    {'columns': ['x=C:1', 'keyphasor=K']}
    """
    return {**reading} | {
        name: [each.removeprefix(f"{node}:") for each in reading[name]
               if _node_of(each) in {"", node}]
        for name in ("columns", "units") if name in reading
    }  # fmt: skip


def _in(unit: str, name: str, value: Any) -> Any:
    """Return a number, or numbers, in the unit of the signals; None unchanged."""
    if isinstance(value, list):
        return [in_unit(name, each, unit) for each in value]
    return None if value is None else in_unit(name, value, unit)
