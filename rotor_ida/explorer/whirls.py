"""The exact response of a rotor system over the speed, and the Campbell diagram of any rotor.

Without contact the motion is linear: the static deflection and an ellipse at each contact. Where it
would exceed a clearance, no motion without contact exists.
"""

from __future__ import annotations

from collections.abc import Iterator
from functools import lru_cache
from typing import Any

import numpy as np
import numpy.typing as npt
import xarray as xr

from rotor_ida.arrays import Arrays, Values
from rotor_ida.closed_forms.campbell import campbell
from rotor_ida.closed_forms.unbalance_response import linear_response
from rotor_ida.closed_forms.whirls.special_speeds import special_speeds
from rotor_ida.closed_forms.whirls.synchronous import whirls_of_system
from rotor_ida.errors import InputError
from rotor_ida.explorer.archives import sheets_of
from rotor_ida.explorer.cases import Case, Node, case_of, of_any_node
from rotor_ida.explorer.messages import Answer, Question
from rotor_ida.model.assembly import assemble
from rotor_ida.model.reduction import in_modes
from rotor_ida.schema import SPECIAL, STABILITY

# A step of a branch of whirls by this part of the height of the diagram may be to another whirl.
JUMP = 0.05
# Eigenvalues of a Campbell diagram.
MOST_EIGENVALUES = 16
# Speeds of the exact response and of the Campbell diagram.
SPEEDS, FEW_SPEEDS = 160, 60

FOLD, HOPF = ("fold_omega", "fold_amplitude"), ("hopf_omega", "hopf_amplitude")
# An empty curve.
NO_WHIRLS: Arrays = {
    **dict.fromkeys(("omega", "amplitude", "phase_lag", *FOLD, *HOPF), np.empty(0)),
    **dict.fromkeys(("stability", "in_contact", "piece"), np.empty(0, np.int8)),
}


def show_whirls(question: Question) -> Iterator[Answer]:
    """Yield the exact whirls over the speed."""
    node = Node(question)
    notes, sheets = node.case.left_out, list[dict[str, Any]]()
    try:
        whirls, points = _whirls(*of_any_node(question))
        arrays = _curve(whirls, points, node)
        if points is not None and points.sizes["special"]:
            sheets = [_without_empty_columns(each) for each in sheets_of(points)[:1]]
    except InputError as error:
        more, arrays = _without_contact(node, error)
        notes += more
    why = "; ".join(notes)
    told = {"why": why[:1].upper() + why[1:]} if why else {}
    yield Answer("curve", node.facts | told | {"sheets": sheets}, NO_WHIRLS | arrays)


def show_campbell(question: Question) -> Iterator[Answer]:
    """Yield the Campbell diagram of any rotor."""
    case = case_of(question)
    system, notes, speeds = case.levitated, case.notes, np.linspace(*case.speeds, FEW_SPEEDS)
    modes = min(MOST_EIGENVALUES, system.size)
    try:
        found = campbell(system, speed=speeds, modes=modes).isel(contact_stiffness=0)
    except InputError as error:
        yield Answer("campbell", {"notes": [str(error)]})
        return
    rates = found["whirl_speed"].transpose("eigenvalue", "speed").values
    damping = found["damping_ratio"].transpose("eigenvalue", "speed").values
    yield Answer("campbell", {"notes": notes}, {
        "speed": found["speed"].values, "whirl_speed": rates.ravel(), "damping": damping.ravel(),
    })  # fmt: skip


def _without_empty_columns(sheet: dict[str, Any]) -> dict[str, Any]:
    """Return a table without the columns that have no value: it stands beside the panels."""
    kept = [column for column in zip(*sheet["rows"], strict=True) if set(column[1:]) != {"-"}]
    return sheet | {"rows": [list(row) for row in zip(*kept, strict=True)]}


def _curve(whirls: xr.Dataset, points: xr.Dataset | None, node: Node) -> Arrays:
    """Return the whirls at a node, or in its contact, branch by branch, and their folds."""
    along = {"node": whirls.get_index("node").get_loc(node.name)}
    prefix = "node_"
    if node.contact is not None:
        along, prefix = {"contact": node.contact}, ""
    amplitude, lag = (
        whirls[prefix + name].isel(along).transpose("branch", "speed").values
        for name in ("amplitude", "phase_lag")
    )
    stability = whirls["stability"].transpose("branch", "speed").values
    touches = whirls["in_contact"].any("contact").transpose("branch", "speed").values
    arrays = _in_pieces(whirls["speed"].values, amplitude, lag, stability, touches)
    if points is None or node.contact is None:
        return arrays
    radii = points["amplitude"].isel(contact=node.contact).values
    for word in ("fold", "hopf", "graze"):
        here = points["special_kind"].values == SPECIAL[word]
        arrays |= {f"{word}_omega": points["special_speed"].values[here],
                   f"{word}_amplitude": radii[here]}  # fmt: skip
    return arrays


def _in_pieces(
    speeds: Values, amplitude: Values, lag: Values, stability: npt.NDArray[Any],
    touches: npt.NDArray[Any],
) -> Arrays:  # fmt: skip
    """Return whirls of shape (branch, speed) as one line, with the number of its piece.

    Whirls are in the order of their amplitudes: where some end, another one may take their place.
    """
    is_there = np.isfinite(amplitude)
    count, high = is_there.sum(axis=0), float(np.nanmax(amplitude, initial=0.0))
    step = np.abs(np.diff(np.nan_to_num(amplitude), axis=1, prepend=0.0))
    begins = (np.diff(count, prepend=-1) != 0) & (step > JUMP * high)
    begins[:, 1:] |= ~is_there[:, :-1]
    begins[:, 0] = True
    piece = np.where(is_there, np.cumsum(begins).reshape(begins.shape), -1)
    return {
        "omega": np.tile(speeds, len(amplitude)), "amplitude": amplitude.ravel(),
        "phase_lag": lag.ravel(), "stability": stability.astype(np.int8).ravel(),
        "in_contact": touches.astype(np.int8).ravel(),
        "piece": piece.astype(np.float64).ravel(),
    }  # fmt: skip


def _without_contact(node: Node, error: InputError) -> tuple[list[str], Arrays]:
    """Return the whirl without contact at a node, and why the exact whirls are not drawn."""
    case, speeds = node.case, np.linspace(*node.case.speeds, SPEEDS)
    why = str(error).partition(": use ")[0]  # it names verbs, not what the page has
    place = list(case.system.nodes).index(node.name)
    try:
        amplitude = _clear_whirl(case, place, speeds)[np.newaxis]
    except InputError:
        return [f"no exact curve: {why}"], {}
    stability = np.where(np.isnan(amplitude), STABILITY["absent"], STABILITY["stable"])
    nothing = np.zeros_like(stability)
    return [f"without whirls in contact: {why}; the largest radius about the mean place"], (
        _in_pieces(speeds, amplitude, np.full_like(amplitude, np.nan), stability, nothing)
    )


@lru_cache(maxsize=2)
def _whirls(question: Question, _changed: int) -> tuple[xr.Dataset, xr.Dataset | None]:
    """Return the exact whirls at all nodes over the speed, and their special speeds."""
    case = case_of(question)
    system = case.levitated
    whirls = whirls_of_system(system, np.linspace(*case.speeds, SPEEDS))
    points = None
    if system.contacts:
        points = special_speeds(system, limits=case.speeds)
    return whirls, points


def _clear_whirl(case: Case, place: int, speeds: Values) -> Values:
    """Return the largest radius of a node about its mean place; NaN where a contact is reached."""
    modes = None if case.course is None else case.course.modes
    assembly = assemble(in_modes(case.system, modes, None)[0])
    found = linear_response(assembly, speeds)
    radii, axes = (np.asarray(found[name][1]) for name in ("unbalance_radius", "node_major_axis"))
    touches = (radii > [each.clearance for each in assembly.contacts]).any(axis=1)
    return np.where(touches, np.nan, 0.5 * axes[:, place])
