"""The motion of one node in a run of a rotor system, in space or in a stator that moves."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
import numpy.typing as npt
import xarray as xr

from rotor_ida.arrays import Values
from rotor_ida.checks import COMPONENTS, check_nonnegative, did_you_mean, listed, shown
from rotor_ida.errors import InputError
from rotor_ida.results.checked_run import check_system_run, nodes_in, samples_in
from rotor_ida.schema import MODE, labelled, origin_of, words_of
from rotor_ida.signals.path import AFTER, Path, modes_at
from rotor_ida.texts import in_figure

# What is needed of the contacts, and what signals keep of a node besides its motion.
OF_CONTACTS = ("contact_node", "contact_stator", "clearance", "centre_x", "centre_y")
OF_NODE = ("node", "clearance")


class Ring(NamedTuple):
    """A node in one stator: the name of the stator, empty for the ground, and its contacts."""

    node: str
    stator: str
    contacts: list[int]

    @property
    def title(self) -> str:
        """What it is called in a figure."""
        # a number alone says little
        names = (f"node {each}" if each.isdecimal() else each for each in (self.node, self.stator))
        return " in ".join(map(in_figure, filter(None, names)))


def at_node(run: xr.Dataset, node: object) -> xr.Dataset:
    """Return the motion of a node and the angle of the rotor, with node and clearance.

    Where a part of the run has one node alone, that is the default.
    """
    run = check_system_run(run, OF_CONTACTS)
    alone = "node" in run.coords and not run["node"].ndim
    name = nodes_in(run)[0] if node is None and alone else check_node(run, node)
    missing = [each for each in COMPONENTS if each not in run.variables]
    if missing:
        raise InputError(f"run must be a run of simulate; it lacks {', '.join(missing)}")
    part = run if alone else run.sel(node=name)
    coordinates = {each: part[each].variable for each in ("t", "node")}
    coordinates["clearance"] = _clearance(run, name)
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


def _clearance(run: xr.Dataset, node: str) -> xr.Variable:
    """Return the clearance at a node, if it is a circle about the place of rest; else NaN."""
    here = np.flatnonzero(run["contact_node"].values == node)
    found = run["clearance"].variable
    if here.size == 1:
        contact = run.isel(contact=int(here[0]))
        aside = bool(contact["centre_x"] != 0.0) or bool(contact["centre_y"] != 0.0)
        if not aside and not str(contact["contact_stator"].values):
            return contact["clearance"].variable
    return xr.Variable((), np.nan, found.attrs)


def rings_of(run: xr.Dataset, names: Sequence[str]) -> list[Ring]:
    """Return where some nodes are seen: in space, or in each stator that moves round them."""
    nodes, stators = (run[f"contact_{each}"].values.tolist() for each in ("node", "stator"))
    rings: list[Ring] = []
    for name in names:
        here = [number for number, node in enumerate(nodes) if node == name]
        around = list(dict.fromkeys(stators[number] for number in here)) or [""]
        rings += [Ring(name, each, [k for k in here if stators[k] == each]) for each in around]
    return rings


def path_in(run: xr.Dataset, ring: Ring) -> Path:
    """Return the orbit of a node, in space or in a stator that moves, through its events."""
    x, y = (run[each].sel(node=ring.node).values for each in ("x", "y"))
    centres = np.stack([run["centre_x"].values, run["centre_y"].values])
    if ring.stator:
        first = ring.contacts[0]
        x = run["contact_x"].values[:, first] + centres[0, first]
        y = run["contact_y"].values[:, first] + centres[1, first]
    here = np.isin(run["event_contact"].values, ring.contacts)
    offsets = centres[:, run["event_contact"].values[here]]
    time = np.append(run["t"].values, run["event_time"].values[here])
    x = np.append(x, run["event_contact_x"].values[here] + offsets[0])
    y = np.append(y, run["event_contact_y"].values[here] + offsets[1])
    time, order = np.unique(time, return_index=True)
    flight = np.zeros((1, time.size), np.int8)
    ways = np.concatenate([flight, *(_modes(run, each, time)[None] for each in ring.contacts)])
    mode = ways[(ways != MODE["flight"]).argmax(axis=0), np.arange(time.size)]
    rubs = bool(run["tangential_force"].values.any())
    return Path(time, x[order], y[order], mode != MODE["flight"], mode=mode if rubs else None)


def _modes(run: xr.Dataset, contact: int, time: Values) -> npt.NDArray[np.int8]:
    """Return the mode of a contact from each time on."""
    part = run.isel(event=run["event_contact"].values == contact)
    modes = run["mode"].values[:, contact]
    told = [MODE[AFTER.get(word, "slipping_forward")] for word in words_of(part["event_kind"])]
    return modes_at(time, part, np.array([modes[0], *told], dtype=np.int8), modes)
