"""System files: a rotor system with its contacts and forces, and how it is to move, as TOML.

    speed = "4300 rpm"
    gravity = ["0", "-9.81 m/s2"]

    [system]                          # or file = "rotor.npz", from the folder of this file
    mass = [12, 12, 8, 8]             # a list of numbers is a diagonal
    damping = [[1600, 0, -800, 0], [0, 1600, 0, -800], [-800, 0, 1200, 0], [0, -800, 0, 1200]]
    stiffness = [[8e6, 0, -4e6, 0], [0, 8e6, 0, -4e6], [-4e6, 0, 6e6, 0], [0, -4e6, 0, 6e6]]

    [system.nodes]
    disc = [0, 1]                     # the indices of x and y, from 0
    seal = [2, 3]

    [[contacts]]
    node = "seal"
    clearance = "150 um"
    stiffness = "5e7 N/m"             # in N/m a linear contact, in N/m^1.5 one by Hertz
    friction = 0.1
    radius = "50 mm"
    stator = { mass = "20 kg", stiffness = "1e7 N/m", damping = "2000 N s/m" }

    [[unbalance]]
    node = "disc"
    moment = "1200 g mm"
    phase = "90 deg"

    [run_up]                          # for run_up alone
    from = "600 rpm"
    to = "6000 rpm"
    ramp_time = "5 s"

A quantity is a number in its SI unit, or a text with a unit. Matrices are numbers. With
``units = "1"`` all is dimensionless, and no unit is allowed.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator, Mapping
from dataclasses import MISSING, dataclass, fields, replace
from functools import partial
from pathlib import Path
from typing import Any, TypeVar

import numpy as np

from rotor_ida.arrays import Values
from rotor_ida.checks import STARTS, check_array, check_choice, check_count, did_you_mean, shown
from rotor_ida.errors import InputError
from rotor_ida.model.bearing import Bearing
from rotor_ida.model.data_sheet import KEYS, OF_LINEAR, exponent_of, units_of
from rotor_ida.model.rotor_system import UNITS, RotorSystem, check_dimensions
from rotor_ida.model.scales import errors_in_units
from rotor_ida.model.system_files import read_system, read_table
from rotor_ida.model.system_parts import Contact, Race, Stator, Support, Unbalance
from rotor_ida.results.toml_files import Table, naming, read_toml
from rotor_ida.texts import brief

Part = TypeVar("Part", Contact, Race, Stator, Support, Unbalance)
MATRICES = ("mass", "stiffness", "damping", "gyroscopic", "stiffness_rate")
# What may stand in each table of a file; with units where it is a number.
TOP = ("units", "speed", "gravity", "static_force", "start", "modes", "more_modes", "system",
       "stators", "contacts", "unbalance", "run_up", "supports", "bearings", "drop")  # fmt: skip
OF_SYSTEM = (*MATRICES, "translations", "nodes", "positions")
# The units of the numbers of each part; of those with a direction two, along x and y.
UNITS_OF: dict[type, dict[str, str]] = {
    Contact: {"clearance": "m", "damping": "s m-1", "friction": "1", "radius": "m"},
    Support: {"stiffness": OF_LINEAR, "damping": "N s m-1"},
    Stator: {"mass": "kg", "stiffness": OF_LINEAR, "damping": "N s m-1"},
    Race: {"radius": "m", "inertia": "kg m2", "drag": "N m s", "speed": "rad s-1"},
    Unbalance: {"moment": "kg m", "phase": "rad"},
}
# The coefficients of bearings: a number, a matrix, or a row for each speed.
COEFFICIENTS = {"stiffness": OF_LINEAR, "damping": "N s m-1"}
OF_RUN_UP = {
    "from": "rad s-1", "to": "rad s-1", "rate": "rad s-2", "ramp_time": "s", "inertia": "kg m2",
    "duration": "s",
}  # fmt: skip
OF_DROP = {"duration": "s", "inertia": "kg m2", "drag": "N m s", "phase": "rad"}
# What varies over many drops: each a range of two numbers, or its values on a grid.
OF_DROPS = {
    "phase": "rad", "friction": "1", "contact_damping": "s m-1", "unbalance_factor": "1",
    "clearance_factor": "1",
}  # fmt: skip


MOST_VALUES = 100_000


@dataclass(frozen=True, slots=True, kw_only=True)
class Course:
    """How the rotor of a system file is to move: its speed, start and modes, run-up and drops.

    Parameters
    ----------
    speed : float, optional
        Running speed.
    start : (q, velocity), "settled" or "rest", optional
        State at time 0. Default: as for `rotor_ida.simulate`.
    modes : int, optional
        Number of modes to which the system is reduced.
    more_modes : int, optional
        That of a second run, which shows how far events move.
    run_up : dict
        The arguments of `run_up` for the change of speed.
    fall : dict
        The arguments of `drop` alone.
    vary : dict
        The arguments of `drop_ensemble` alone: number of drops, seed, and what varies.
    grid : dict
        Those of a grid of drops instead: the values of what varies.
    """

    speed: float | None = None
    start: Any = None
    modes: int | None = None
    more_modes: int | None = None
    run_up: Mapping[str, Any]
    fall: Mapping[str, Any]
    vary: Mapping[str, Any]
    grid: Mapping[str, Any]

    @property
    def motion(self) -> dict[str, Any]:
        """Start and modes, arguments of both `simulate` and `run_up`."""
        return {"start": self.start, "modes": self.modes, "more_modes": self.more_modes}

    @property
    def drop(self) -> dict[str, Any]:
        """All arguments of `drop`; without a state in the file it starts levitated."""
        given = {"speed": self.speed, **self.fall, **self.motion}
        if isinstance(self.start, str | None):
            del given["start"]
        return given


def load_system(path: str | os.PathLike[str]) -> RotorSystem:
    """Read a rotor system with its contacts, supports and forces from a TOML file.

    Parameters
    ----------
    path : path-like
        The file. Matrices in other files are sought from its folder.

    Returns
    -------
    RotorSystem
        The system. `load_course` returns the speed, start, run-up and drop of the file.

    Raises
    ------
    InputError
        If the file cannot be read, has an unknown key, or does not describe a system.

    Examples
    --------
    >>> import tempfile
    >>> from rotor_ida import simulate
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     path = Path(folder, "disc.toml")
    ...     _ = path.write_text('''
    ...         speed = "2000 rpm"
    ...         system = { mass = [4, 4], stiffness = [1e5, 1e5], nodes = { disc = [0, 1] } }
    ...         contacts = [ { node = "disc", clearance = "60 um", stiffness = "1e7 N/m" } ]
    ...         unbalance = [ { node = "disc", moment = "100 g mm" } ]
    ...     ''')
    ...     system = load_system(path)
    >>> system, system.contacts[0].clearance, system.contacts[0].exponent
    (RotorSystem(2 degrees of freedom, node disc), 6e-05, 1.0)
    >>> run = simulate(system, speed=200.0, duration=0.1)
    >>> float(run.event_time[0].round(6))
    0.023806
    """
    return read_system_file(path)[0]


def load_course(path: str | os.PathLike[str]) -> Course:
    """Read from a system file how its rotor is to move.

    Parameters
    ----------
    path : path-like
        The file, as for `load_system`.

    Returns
    -------
    Course
        ``speed``, ``start``, ``modes``, ``more_modes``; ``run_up``, the arguments of `run_up` for
        the change of speed; and ``drop``, those of `drop`.

    Raises
    ------
    InputError
        As for `load_system`.

    Examples
    --------
    >>> import tempfile
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     path = Path(folder, "disc.toml")
    ...     _ = path.write_text('''
    ...         speed = "300 rad/s"
    ...         system = { mass = [4, 4], stiffness = [1e5, 1e5], nodes = { disc = [0, 1] } }
    ...         run_up = { to = "400 rad/s", ramp_time = "5 s" }
    ...     ''')
    ...     course = load_course(path)
    >>> course.speed, course.run_up
    (300.0, {'to': 400.0, 'ramp_time': 5.0, 'speed': 0.0})
    """
    return read_system_file(path)[1]


def read_system_file(path: str | os.PathLike[str]) -> tuple[RotorSystem, Course]:
    """Return the system of a file, and its course."""
    table = read_toml("system", path)
    try:
        with errors_in_units(str(table.get("units", UNITS[0]))):
            return _system_file(table, Path(path).parent)
    except InputError as error:
        raise error.within(f"{path}: ") from error


def _system_file(entries: Mapping[str, object], folder: Path) -> tuple[RotorSystem, Course]:
    units = entries.get("units", UNITS[0])
    check_choice("units", units, UNITS)
    file = Table("", entries, units == UNITS[0])
    if "system" not in entries and entries and entries.keys() <= KEYS.keys():
        raise InputError("system must be given, got the file of a machine: give it with --machine")
    file.check(TOP, needed=("system",))
    system = _loaded(_system(file, folder), file)
    system = replace(
        system, contacts=list(_contacts(file, system)),
        supports=_at_nodes(Support, file, "supports", system),
        bearings=[_bearing(table, system, folder) for table in file.tables("bearings")],
        unbalance=_at_nodes(Unbalance, file, "unbalance", system),
        gravity=file.pair("gravity", "m s-2") if "gravity" in entries else None,
    )  # fmt: skip
    return system, Course(
        start=_start(file),
        modes=check_count("modes", entries["modes"], minimum=0) if "modes" in entries else None,
        more_modes=check_count("more_modes", entries["more_modes"])
        if "more_modes" in entries
        else None,
        speed=file.number("speed", "rad s-1") if "speed" in entries else None,
        run_up=_change(file.table("run_up")),
        fall=_fall(file.table("drop")),
        vary=_vary(file.table("drop").table("vary")),
        grid=_grid(file.table("drop")),
    )


def _system(file: Table, folder: Path) -> RotorSystem:
    """Return the rotor: from another file, or from matrices."""
    given = file.table("system")
    nodes = given.table("nodes").entries
    if "file" in given.entries:
        given.check(("file", "nodes", "positions"))
        place = given.entries["file"]
        if not isinstance(place, str) or not place:
            raise InputError(f"system.file must be the path of a file, got {shown(place)}")
        with naming("system.file"):
            found = read_system(folder / place)
        twice = sorted(set(nodes) & set(found["nodes"]))
        if twice:
            raise InputError(
                f"system.nodes.{brief(twice[0])} must be left out: the file has this node"
            )
        arguments = {**found, "nodes": {**found["nodes"], **nodes}}
    else:
        given.check(("file", *OF_SYSTEM), needed=("mass", "stiffness", "nodes"))
        names = [name for name in MATRICES if name in given.entries]
        arguments = {name: _matrix(given.name(name), given.entries[name]) for name in names}
        arguments["nodes"] = nodes
        if "translations" in given.entries:
            arguments["translations"] = given.entries["translations"]
    if "positions" in given.entries:
        places = given.table("positions")
        arguments["positions"] = {node: places.number(node, "m") for node in places.entries}
    with naming("system"):
        return RotorSystem(**arguments, units="SI" if file.si else "1")


def _matrix(name: str, given: object) -> Values:
    """Return a matrix by its rows, or by the numbers of its diagonal."""
    values = check_array(name, given)
    check_dimensions(name, values.shape)
    return np.diag(values) if values.ndim == 1 else values


def _loaded(system: RotorSystem, file: Table) -> RotorSystem:
    """Return the system with the static force of a file, given by coordinates or by nodes."""
    given = file.entries.get("static_force")
    if given is None:
        return system
    force = np.zeros(system.size) if system.static_force is None else system.static_force.copy()
    if isinstance(given, Mapping):
        table = file.table("static_force")
        for node in given:
            with naming("static_force"):
                rows = system.rows(node)
            force += np.array(table.pair(node, "N")) @ rows
    else:
        values = check_array("static_force", given)
        if values.shape != force.shape:
            raise InputError(f"static_force must have the shape {force.shape}, got {values.shape}")
        force += values
    return replace(system, static_force=force)


def _part(kind: type[Part], table: Table, read: Mapping[str, Callable[[], Any]] = {}) -> Part:
    """Return a part of a rotor by its fields, of which some are `read` in their own way."""
    needed = {each.name: each.default is MISSING for each in fields(kind)}
    table.check(tuple(needed), tuple(name for name in needed if needed[name]))
    units, found = UNITS_OF[kind], {}
    for key, value in table.entries.items():
        has_sides = kind in {Stator, Support} and key != "mass"
        if key in read:
            found[key] = read[key]()
        elif key in units:
            found[key] = (table.one_or_pair if has_sides else table.number)(key, units[key])
        else:
            found[key] = value
    with naming(table.place):
        return kind(**found)


def _stator(table: Table) -> Stator:
    return _part(Stator, table, {"race": partial(_race, table)})


def _race(table: Table) -> Race:
    return _part(Race, table.table("race"))


def _contacts(file: Table, system: RotorSystem) -> Iterator[Contact]:
    """Yield the contacts, whose nodes and stators must be known."""
    given = file.table("stators")
    stators = {name: _stator(given.table(name)) for name in given.entries}
    used: set[str] = set()
    for table in file.tables("contacts"):
        stiffness, stator = table.entries.get("stiffness"), table.entries.get("stator")
        names = (table.name("stiffness"), table.name("exponent"))
        contact = _part(Contact, table, {
            "node": partial(_node, table, system), "race": partial(_race, table),
            "centre": partial(table.pair, "centre", "m"),
            "stiffness": partial(table.number, "stiffness", *units_of("contact_stiffness")),
            "exponent": partial(table.number, "exponent", "1"),
            "stator": partial(_stator_of, table, stators, system),
        })  # fmt: skip
        exponent = exponent_of(stiffness, table.entries.get("exponent"), names)
        yield replace(contact, exponent=exponent)
        used.add(str(stator))
    unused = [name for name in stators if name not in used]
    if unused:
        raise InputError(f"stators.{brief(unused[0])} must be the stator of a contact, got none")


def _node(table: Table, system: RotorSystem) -> str:
    """Return the name of a node of the system."""
    node = table.entries["node"]
    with naming(table.place):
        if not isinstance(node, str):
            raise InputError(f"node must be the name of a node, got {shown(node)}")
        system.rows(node)  # raises if it is unknown
    return node


def _stator_of(
    table: Table, stators: Mapping[str, Stator], system: RotorSystem
) -> Stator | str | None:
    """Return the stator of a contact: a table, or a word for one of the file or for a node."""
    name, given, known = table.name("stator"), table.entries["stator"], [*stators, *system.nodes]
    if isinstance(given, Mapping):
        return _stator(table.table("stator"))
    if not isinstance(given, str) or given not in known:
        allowed = ", ".join(map(repr, known))
        raise InputError(
            f"{name} must be a table or one of {allowed}, got {shown(given)}"
            f"{did_you_mean(given, known)}"
        )
    if given in stators and given in system.nodes:
        raise InputError(f"{name} must name one thing, got {given!r}, a node and a stator")
    return stators.get(given, given)


def _at_nodes(kind: type[Part], file: Table, key: str, system: RotorSystem) -> list[Part]:
    """Return parts that are at a node of the system alone."""
    return [
        _part(kind, table, {"node": partial(_node, table, system)}) for table in file.tables(key)
    ]


def _bearing(table: Table, system: RotorSystem, folder: Path) -> Bearing:
    """Return a bearing, whose coefficients are in the file or in a table of another one."""
    own = ("speed", *COEFFICIENTS)
    table.check(("node", "name", "stator", "table", *own), needed=("node",))
    found: dict[str, Any] = {"node": _node(table, system)}
    found |= {key: table.entries[key] for key in ("name", "stator") if key in table.entries}
    place = table.entries.get("table")
    with naming(table.place):
        if place is None:
            for key, unit in {"speed": "rad s-1", **COEFFICIENTS}.items():
                if key in table.entries:
                    found[key] = _nested(table, table.name(key), table.entries[key], unit)
            if "stiffness" not in found:
                raise InputError("stiffness or table must be given")
        else:
            given = [key for key in own if key in table.entries]
            if given or not isinstance(place, str):
                raise InputError(
                    "table must be the path of a file, without speed, stiffness and damping, got "
                    f"{shown(given[0] if given else place)}"
                )
            found |= read_table(folder / place)
        return Bearing(**found)


def _nested(table: Table, name: str, given: object, unit: str) -> Any:
    """Return a number, or rows of numbers, in SI units."""
    if isinstance(given, list):
        return [_nested(table, name, each, unit) for each in given]
    return table.one(name, given, unit)


def _start(file: Table) -> Any:
    """Return the start: settled, at rest, or displacement and velocity of all coordinates."""
    given = file.entries.get("start")
    if isinstance(given, Mapping):
        table = file.table("start")
        table.check(("q", "velocity"), needed=("q", "velocity"))
        return tuple(check_array(table.name(key), given[key]) for key in ("q", "velocity"))
    if given is not None and given not in STARTS:
        raise InputError(
            f"start must be 'settled', 'rest' or a table of q and velocity, got {shown(given)}"
        )
    return given


def _change(table: Table) -> dict[str, Any]:
    """Return the arguments of `run_up` for a change of speed; it begins at 0 unless stated."""
    table.check((*OF_RUN_UP, "speeds", "torque"))
    found: dict[str, Any] = dict(table.numbers(OF_RUN_UP))
    if "speeds" in table.entries:
        given = table.entries["speeds"]
        if not isinstance(given, list):
            raise InputError(f"run_up.speeds must be pairs of time and speed, got {shown(given)}")
        found["speeds"] = [table.two("run_up.speeds", each, "s", "rad s-1") for each in given]
    if "torque" in table.entries:
        found["torque"] = table.pair("torque", "N m", "N m s")
    begin = found.pop("from", None)
    if "speeds" not in found:
        found["speed"] = begin or 0.0
    elif begin is not None:
        raise InputError("run_up.from must be left out with speeds, which begin at time 0")
    return found


def _fall(table: Table) -> dict[str, Any]:
    """Return the arguments of `drop` alone."""
    table.check((*OF_DROP, "failing", "clearances", "capacities", "vary", "grid"))
    found: dict[str, Any] = dict(table.numbers(OF_DROP))
    if "failing" in table.entries:
        found["failing"] = table.entries["failing"]
    for key, unit in (("clearances", "m"), ("capacities", "N")):
        if key in table.entries:
            by_node = table.table(key)
            found[key] = by_node.numbers(dict.fromkeys(by_node.entries, unit))
    return found


def _vary(table: Table) -> dict[str, Any]:
    """Return the arguments of `drop_ensemble` alone."""
    table.check((*OF_DROPS, "drops", "seed"))
    found: dict[str, Any] = {
        key: table.pair(key, unit) for key, unit in OF_DROPS.items() if key in table.entries
    }
    for key, least in (("drops", 2), ("seed", 0)):
        if key in table.entries:
            found[key] = check_count(table.name(key), table.entries[key], minimum=least)
    return found


def _grid(drop: Table) -> dict[str, Any]:
    """Return the values of what varies on a grid of drops."""
    table = drop.table("grid")
    table.check(tuple(OF_DROPS))
    if table.entries and "vary" in drop.entries:
        raise InputError(f"{table.place} must be left out with {drop.name('vary')}")
    return {key: _values(table, key, unit) for key, unit in OF_DROPS.items()
            if key in table.entries}  # fmt: skip


def _values(table: Table, key: str, unit: str) -> list[float]:
    """Return a list of numbers, or the numbers of an even division: from, to, count."""
    name, given = table.name(key), table.entries[key]
    if isinstance(given, Mapping):
        ends = table.table(key)
        ends.check(("from", "to", "count"), needed=("from", "to", "count"))
        count = check_count(f"{name}.count", given["count"], minimum=2, maximum=MOST_VALUES)
        first, last = (ends.number(end, unit) for end in ("from", "to"))
        return [float(each) for each in np.linspace(first, last, count)]
    if not isinstance(given, list) or not given:
        raise InputError(
            f"{name} must be numbers or a table of from, to, count, got {shown(given)}"
        )
    return [table.one(f"{name}[{place}]", each, unit) for place, each in enumerate(given)]
