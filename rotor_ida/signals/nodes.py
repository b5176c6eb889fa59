"""The motion of one node in a run of a rotor system, as that of one disc."""

from __future__ import annotations

import numpy as np
import xarray as xr

from rotor_ida.arrays import Values
from rotor_ida.checks import COMPONENTS, check_nonnegative, did_you_mean, listed, shown
from rotor_ida.errors import InputError
from rotor_ida.results.run import nodes_in, samples_in
from rotor_ida.schema import labelled, origin_of

# What signals keep of a node, besides its motion.
OF_NODE = ("node", "clearance")


def at_node(run: xr.Dataset, node: object) -> xr.Dataset:
    """Return the motion of a node and the angle of the rotor, with node and clearance.

    Where a part of the run has one node alone, that is the default.
    """
    alone = "node" in run.coords and not run["node"].ndim
    name = nodes_in(run)[0] if node is None and alone else check_node(run, node)
    missing = [each for each in ("t", *COMPONENTS) if each not in run.variables]
    if missing:
        raise InputError(f"run must be a run of simulate; it lacks {', '.join(missing)}")
    part = run if alone else run.sel(node=name)
    coordinates = {each: part[each].variable for each in ("t", "node")}
    clearance = _clearance(run, name)
    if clearance is not None:
        coordinates["clearance"] = clearance
    columns = {each: part[each].variable for each in COMPONENTS}
    columns["angle"] = labelled("angle", "t", angles_of_system(run))
    return xr.Dataset(columns, coordinates, origin_of(run))


def check_node(run: xr.Dataset, node: object) -> str:
    """Return the name of a node of a run; the message of an error lists them."""
    known = nodes_in(run)
    if isinstance(node, str) and node in known:
        return str(node)
    allowed = listed([repr(each) for each in known] or ["those of the system"], "or")
    raise InputError(f"node must be {allowed}, got {shown(node)}{did_you_mean(node, known)}")


def angles_of_system(run: xr.Dataset) -> Values:
    """Return the angle of an unbalance of phase 0 in a run of a rotor system."""
    if "angle" in run.variables:
        return samples_in("run", run, "angle")
    if "speed" not in run.attrs:
        raise InputError("run must contain its speed or angle, got neither")
    # an angle that falls has no revolutions to count; the mirror image of the rotor does
    speed = check_nonnegative("speed of the run", run.attrs["speed"])
    return speed * samples_in("run", run, "t")


def _clearance(run: xr.Dataset, node: str) -> xr.Variable | None:
    """Return the clearance at a node, if it is a circle about the place of rest."""
    here = np.flatnonzero(run["contact_node"].values == node)
    if here.size != 1:
        return None
    contact = run.isel(contact=int(here[0]))
    moves = str(contact["contact_stator"].values) != ""
    aside = bool(contact["centre_x"] != 0.0) or bool(contact["centre_y"] != 0.0)
    return None if moves or aside else contact["clearance"].variable
