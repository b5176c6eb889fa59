"""Indentations of contacts in a result, and a warning where they exceed the contact law."""

from __future__ import annotations

import math

import numpy as np
import xarray as xr

from rotor_ida.arrays import Values
from rotor_ida.model.contact import HERTZ_EXPONENT, SMALL_INDENTATION, bounds_exceeded
from rotor_ida.results.archived_system import clearance_of_contacts
from rotor_ida.units import quantity

# Variables of results by which a contact is pressed in.
OF_RUBS = ("rub_force", "passage_rub_force", "whip_force")


def beyond_model(result: xr.Dataset) -> str:
    """Return a warning if contacts are pressed in too far for the contact law, else "".

    Parameters
    ----------
    result : Dataset
        Any result.

    Examples
    --------
    >>> from rotor_ida import Contact, RotorSystem, Unbalance, synchronous_response
    >>> system = RotorSystem(mass=np.eye(2), damping=4 * np.eye(2), stiffness=1e4 * np.eye(2),
    ...                      nodes={"disc": (0, 1)})
    >>> seal = Contact(node="disc", clearance=2e-4, stiffness=1e2, exponent=1.0)
    >>> unbalance = [Unbalance(node="disc", moment=1e-3)]
    >>> whirls = synchronous_response(system, contacts=[seal], unbalance=unbalance, speed=[100.0])
    >>> beyond_model(whirls).partition(";")[0]
    "Beyond the model: contact 0 at 'disc' is indented by up to 24.1 mm, more than the clearance"
    """
    if "delta0" in result.variables and "contact_node" not in result.variables:
        return _of_disc(result)
    if not {"contact_node", "clearance"} <= result.variables.keys():
        return ""
    gaps = clearance_of_contacts(result)
    depths = _depths(result, gaps)
    if depths is None:
        return ""
    radii = result["law_radius"].values if "law_radius" in result else np.full(depths.size, np.nan)
    in_si = gaps.attrs.get("units") == "m"
    largest = gaps.max([dim for dim in gaps.dims if dim != "contact"]).values
    told = []
    for number, depth in enumerate(depths):
        clearance = float(largest[number]) if in_si else None
        radius = float(radii[number])
        bounds = bounds_exceeded(depth, None if math.isnan(radius) else radius, clearance)
        if bounds:
            length = quantity(depth, "m" if in_si else "1", 3)
            node = str(result["contact_node"].values[number])
            told.append(
                f"contact {number} at {node!r} is indented by up to {length}, more than {bounds}"
            )
    return beyond_in_words(", and ".join(told)) if told else ""


def beyond_in_words(what: str) -> str:
    """Return the warning that an indentation is too large for the contact law."""
    return f"Beyond the model: {what}; such a force is too large for the contact law to predict."


def _of_disc(result: xr.Dataset) -> str:
    """Return the warning on a result of one disc, by the deepest indentation that is too large."""
    in_si = "length_scale" in result.attrs
    scale = result.attrs.get("length_scale", 1.0)
    gap = scale * result["delta0"]
    radius = scale * result["disc_radius"] if "disc_radius" in result else gap * math.nan
    if "peak_indentation" in result:
        depth = result["peak_indentation"]
    elif "radius_max" in result:
        depth = result["radius_max"] - gap
        if "rate" in result.dims:  # the radii are those of the last speed, forces of the whole ramp
            force = result["largest_force"] / result.attrs.get("force_scale", 1.0)
            pressed = scale * force ** (1.0 / result.get("contact_exponent", HERTZ_EXPONENT))
            depth = np.fmax(depth, pressed)
    elif "amplitude" in result:
        depth = result["amplitude"] - gap
    elif "rotating_x" in result:
        depth = np.hypot(result["rotating_x"], result["rotating_y"]) - gap
    else:
        return ""
    allowed = SMALL_INDENTATION * radius
    if in_si:
        allowed = np.fmin(allowed, gap.where(gap > 0.0))
    every = xr.broadcast(depth, allowed, radius, gap)
    depths, most, radii, gaps = (each.values.ravel() for each in every)
    if not (depths > most).any():
        return ""
    deepest = int(np.where(depths > most, depths, -np.inf).argmax())
    bounds = bounds_exceeded(
        depths[deepest], None if math.isnan(radii[deepest]) else radii[deepest],
        gaps[deepest] if in_si else None,
    )  # fmt: skip
    length = quantity(depths[deepest], "m" if in_si else "1", 3)
    return beyond_in_words(f"an indentation of {length} is more than {bounds}")


def _depths(result: xr.Dataset, clearance: xr.DataArray) -> Values | None:
    """Return the largest indentation of each contact in a result; None where it has none."""
    if not clearance.size:
        return None
    if "excursion" in result:
        found = (result["excursion"] - 1.0) * clearance * result.get("drop_clearance", 1.0)
    elif "radius_max" in result:
        found = result["radius_max"] - clearance
    elif {"in_contact", "amplitude"} <= result.variables.keys():
        found = result["amplitude"] - clearance
    elif "rub_force" in result:
        forces = xr.concat([result[name] for name in OF_RUBS if name in result], "rub")
        found = (forces / result["law_stiffness"]) ** (1.0 / result["law_exponent"])
    else:
        return None
    depths = found.transpose("contact", ...).values.reshape(result.sizes["contact"], -1)
    return np.asarray(np.fmax.reduce(depths, axis=1, initial=-np.inf))
