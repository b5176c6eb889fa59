"""A rotor system: any linear rotor, by its matrices, with all that acts on it.

``M q'' + (C + Omega G) q' + (K + Omega' K_dot) q = unbalance + static force + contacts``
"""

from __future__ import annotations

import inspect
from collections.abc import Callable, Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any, Literal, NoReturn, TypedDict, Unpack, cast

import numpy as np
import numpy.typing as npt

from rotor_ida.arrays import Values
from rotor_ida.checks import (
    check_array,
    check_choice,
    check_name,
    check_note,
    check_real,
    did_you_mean,
    shown,
    with_hints,
)
from rotor_ida.errors import InputError
from rotor_ida.model.bearing import Bearing
from rotor_ida.model.rotor import DimensionalRotor, Rotor
from rotor_ida.model.scales import errors_in_units
from rotor_ida.model.system_parts import (
    Contact,
    Support,
    Unbalance,
    check_contacts,
    check_list,
    stators_of,
)

# Relative size below which a part of a matrix that should vanish is rounding.
ROUNDED = 1e-9
UNITS = ("SI", "1")
KINDS = "a Rotor, DimensionalRotor or RotorSystem"
MOST_NODES_SHOWN = 6
# One matrix of this size takes 32 MB; beam models have a few hundred degrees of freedom.
MOST_COORDINATES = 2000
# Products of larger numbers leave the range of doubles.
LARGEST_IN_MATRIX, LARGEST_IN_ROW = 1e30, 1e15
# Forces that the supports must balance do so to this part of the largest.
BALANCED = 1e-9
Node = tuple[int, int] | npt.ArrayLike


class SystemParameters(TypedDict, total=False):
    """Fields of a `RotorSystem` that the functions of systems take as keywords, in their place."""

    contacts: Sequence[Contact]
    unbalance: Sequence[Unbalance]
    supports: Sequence[Support]
    bearings: Sequence[Bearing]
    gravity: tuple[float, float] | None
    static_force: npt.ArrayLike | None


@with_hints
@dataclass(frozen=True, kw_only=True, slots=True, eq=False, repr=False)
class RotorSystem:
    """A linear rotor of any size, by its matrices, with its contacts and the forces on it.

    Parameters
    ----------
    mass, stiffness : array_like, shape (n, n)
        Mass matrix, symmetric and positive definite, and stiffness matrix.
    damping, gyroscopic, stiffness_rate : array_like, shape (n, n), optional
        Damping matrix; skew-symmetric gyroscopic matrix, which the speed multiplies; and the
        matrix that the rate of the speed multiplies. Default: none.
    nodes : mapping
        Nodes by name, of at most 80 characters without control characters: two indices of
        q, its displacements along x and y; or an array of shape (2, n) by which q gives them, as in
        modal coordinates.
    translations : array_like, shape (n, 2), optional
        The coordinates of unit translations along x and y, by which gravity acts. Default: 1 at
        the displacements of all nodes that are given by indices, so that these must be all that
        have mass; or what the rows of the nodes determine.
    contacts : sequence of Contact
        Its contacts, at most 16.
    unbalance : sequence of Unbalance
        Its unbalance; at time 0 an unbalance of phase 0 points along x.
    supports : sequence of Support
        Its magnetic bearings, at different nodes.
    bearings : sequence of Bearing
        Bearings and seals by their coefficients, in addition to those in the matrices.
    gravity : (float, float), optional
        Acceleration of gravity along x and y. Default: none.
    static_force : array_like, shape (n,), optional
        A constant force, besides the weight; with two more numbers for each `Stator`, also on it.
    gravity_in_static_force : (float, float), optional
        Acceleration, along x and y, of the gravity whose weight is a part of `static_force`. It
        acts on unbalance too: under a torque its moment about the axis counts. Default: none.
    positions : mapping of str to float, optional
        Axial position of each node, for pictures of the deflected shape.
    units : {"SI", "1"}
        Units of results: SI, or none where all numbers are dimensionless.
    added_mass : array_like, shape (n, n), optional
        The part of the mass matrix that gravity does not act on: fluid that moves with the rotor,
        as in seals. Default: none.
    note : str
        A text that every result of the system repeats, such as the limits of its matrices.

    Examples
    --------
    >>> system = RotorSystem(mass=np.eye(2), stiffness=np.eye(2), nodes={"disc": (0, 1)})
    >>> system
    RotorSystem(2 degrees of freedom, node disc)
    >>> system.size, system.rows("disc").tolist()
    (2, [[1.0, 0.0], [0.0, 1.0]])

    ``dataclasses.replace`` returns a system with other fields:

    >>> from dataclasses import replace
    >>> rubbing = replace(system, contacts=[Contact(node="disc", clearance=0.5, stiffness=4.0)])
    >>> rubbing.contacts[0].clearance
    0.5
    """

    mass: Values
    stiffness: Values
    damping: Values | None = None
    gyroscopic: Values | None = None
    stiffness_rate: Values | None = None
    nodes: Mapping[str, Node] = field(default_factory=dict)
    translations: Values | None = None
    contacts: Sequence[Contact] = ()
    unbalance: Sequence[Unbalance] = ()
    supports: Sequence[Support] = ()
    bearings: Sequence[Bearing] = ()
    gravity: tuple[float, float] | None = None
    static_force: Values | None = None
    gravity_in_static_force: tuple[float, float] | None = None
    positions: Mapping[str, float] | None = None
    units: Literal["SI", "1"] = "SI"
    added_mass: Values | None = None
    note: str = ""

    def __post_init__(self) -> None:
        mass = _square("mass", self.mass)
        keep = {"mass": _symmetric("mass", mass)}
        size = len(mass)
        for name in ("stiffness", "damping", "gyroscopic", "stiffness_rate"):
            given = getattr(self, name)
            if given is not None or name == "stiffness":
                keep[name] = _square(name, given, size)
        if "gyroscopic" in keep:
            _symmetric("gyroscopic", keep["gyroscopic"], sign=-1.0)
        try:
            np.linalg.cholesky(keep["mass"])
        except np.linalg.LinAlgError as error:
            least = float(np.linalg.eigvalsh(keep["mass"])[0])
            raise InputError(
                f"mass must be positive definite, got a matrix with the eigenvalue {least:.6g}"
            ) from error
        if self.translations is not None:
            keep["translations"] = _shaped("translations", self.translations, (size, 2))
        if self.added_mass is not None:
            keep["added_mass"] = _symmetric(
                "added_mass", _square("added_mass", self.added_mass, size)
            )
        check_choice("units", self.units, UNITS)
        check_note("note", self.note)
        for name in ("gravity", "gravity_in_static_force"):
            if (given := getattr(self, name)) is not None:
                with errors_in_units(self.units):
                    object.__setattr__(self, name, _pair(name, given))
        object.__setattr__(self, "nodes", _nodes(self.nodes, size))
        self._check_parts()
        if self.static_force is not None:
            force = check_array("static_force", self.static_force, largest=LARGEST_IN_MATRIX)
            if force.shape not in {(size,), (size + 2 * len(stators_of(self.contacts)),)}:
                raise InputError(f"static_force must have the shape {(size,)}, got {force.shape}")
            keep["static_force"] = force.copy()
        for name, values in keep.items():
            values.setflags(write=False)
            object.__setattr__(self, name, values)
        if self.positions is not None:
            with errors_in_units(self.units):
                object.__setattr__(self, "positions", _positions(self.positions, self.nodes))

    def _check_parts(self) -> None:
        """Keep contacts, bearings and the like as tuples; their nodes must be those here."""
        found: dict[str, tuple[Contact | Unbalance | Support | Bearing, ...]] = {
            "contacts": check_list("contacts", self.contacts, Contact),
            "unbalance": check_list("unbalance", self.unbalance, Unbalance),
            "supports": check_list("supports", self.supports, Support),
            "bearings": check_list("bearings", self.bearings, Bearing),
        }
        for name, parts in found.items():
            for each in parts:
                self.rows(each.node)  # raises if it is unknown
            object.__setattr__(self, name, parts)
        with errors_in_units(self.units):
            check_contacts(self.contacts)
        joints: list[Contact | Bearing] = [*self.contacts, *self.bearings]
        for joint in joints:
            if isinstance(joint.stator, str) and not self.rows_between(joint).any():
                raise InputError(
                    f"stator of {joint.words} must be another node, got {shown(joint.stator)}"
                )
        held = [each.node for each in self.supports]
        twice = [node for node in held if held.count(node) > 1]
        if twice:
            raise InputError(f"supports must be at different nodes, got {twice[0]!r} twice")

    def __repr__(self) -> str:
        names = list(self.nodes)
        told = names if len(names) <= MOST_NODES_SHOWN else [*names[:2], "...", names[-1]]
        nodes = f"node{'s' if len(names) > 1 else ''} {', '.join(told)}" if names else "no nodes"
        return f"RotorSystem({self.size} degrees of freedom, {nodes})"

    @property
    def size(self) -> int:
        """The number n of degrees of freedom."""
        return len(self.mass)

    def rows(self, node: str) -> Values:
        """Return the two rows by which q gives the displacement of a node, shape (2, n)."""
        if node not in self.nodes:
            allowed = ", ".join(map(repr, self.nodes)) or "none: the system has no nodes"
            hint = did_you_mean(node, self.nodes)
            raise InputError(f"node must be one of {allowed}, got {shown(node)}{hint}")
        given = self.nodes[node]
        if isinstance(given, tuple):
            return np.eye(self.size)[list(given)]
        return np.asarray(given)

    def rows_between(self, joint: Contact | Bearing) -> Values:
        """Return the rows of a node less those of the node that is its stator, shape (2, n)."""
        rows = self.rows(joint.node)
        return rows - self.rows(joint.stator) if isinstance(joint.stator, str) else rows

    def at(self, speed: float) -> RotorSystem:
        """Return the system at a speed: with its bearings' coefficients there in its matrices.

        Raises
        ------
        InputError
            If the speed is outside the table of a bearing.

        Examples
        --------
        >>> film = Bearing(node="disc", speed=[0.0, 10.0], stiffness=[2.0, 4.0])
        >>> system = RotorSystem(mass=np.eye(2), stiffness=np.zeros((2, 2)),
        ...                      nodes={"disc": (0, 1)}, bearings=[film])
        >>> system.at(5.0).stiffness.tolist(), system.at(5.0).bearings
        ([[3.0, 0.0], [0.0, 3.0]], ())
        """
        if not self.bearings:
            return self
        self.check_speeds(np.array([check_real("speed", speed)]))
        springs = [(self.rows_between(each), *each.at(speed)) for each in self.bearings]
        return with_springs(self, springs, bearings=())

    def check_speeds(self, speeds: Values) -> None:
        """Refuse speeds outside the table of a bearing."""
        with errors_in_units(self.units):
            for each in self.bearings:
                each.check(speeds)

    def unit_translations(self) -> Values:
        """Return the coordinates of unit translations along x and y, shape (n, 2)."""
        if self.translations is not None:
            return self.translations
        both = np.zeros((self.size, 2))
        rows = np.concatenate([np.zeros((0, self.size)), *map(self.rows, self.nodes)])
        wanted = np.tile(np.eye(2), (len(self.nodes), 1))
        indices = [given for given in self.nodes.values() if isinstance(given, tuple)]
        if indices:
            for x, y in indices:
                both[x, 0] = both[y, 1] = 1.0
        elif np.linalg.matrix_rank(rows) == self.size:
            both = np.linalg.lstsq(rows, wanted, rcond=None)[0]
        if not np.allclose(rows @ both, wanted, atol=ROUNDED):
            raise InputError(
                "translations must be given for gravity, as the nodes do not determine them, "
                "got None"
            )
        return both

    def weight(self, gravity: npt.ArrayLike) -> Values:
        """Return the force of gravity, shape (n,), for its acceleration along x and y."""
        heavy = self.mass if self.added_mass is None else self.mass - self.added_mass
        return np.asarray(heavy @ (self.unit_translations() @ np.asarray(gravity)))

    @classmethod
    def from_ross(
        cls, rotor: Any, *, speed: float | None = None, **changed: Unpack[SystemParameters]
    ) -> RotorSystem:
        """Return the system of a rotor of the package ROSS.

        Parameters
        ----------
        rotor : ross.Rotor
            The rotor. Nothing of ROSS is imported: any object with its methods ``M K C G``, or
            with its matrices ``M0 K0 C0`` and its ``bearing_elements``, will do.
        speed : float, optional
            Speed at which coefficients of bearings and seals are frozen [rad/s]. Default: each
            bearing and seal is a `Bearing` with its own table.
        contacts, unbalance, supports, bearings, gravity, static_force : optional
            As for a system by its matrices.

        Returns
        -------
        RotorSystem
            In SI units. Its nodes are ``"0"``, ``"1"``, ... as in ROSS, those of links too. The
            added mass of seals has no weight.

        Raises
        ------
        InputError
            If the object has no such methods, or is a ``MultiRotor``, whose shafts turn at
            different speeds; if `speed` is outside a table; without it, if the added mass of a seal
            depends on the speed.

        Warns
        -----
        UserWarning
            If coefficients depend on the speed and are frozen: they stay those at `speed` at any
            other speed, which the system's `note` says in every result.

        Notes
        -----
        Tables are those that were given to ROSS, with monotone cubics in between, also where they
        are frozen. ROSS 2.3 fits a smoothing spline to a table, which need not pass through its
        rows.
        """
        from rotor_ida.model.ross_rotors import system_of_ross  # noqa: PLC0415

        found = cls(**system_of_ross(rotor, speed=speed))
        return changed_system(cls.from_ross, found, changed)

    @classmethod
    def from_file(cls, path: str | Path, **changed: Unpack[SystemParameters]) -> RotorSystem:
        """Return a system from a file: .npz, .mat, or a folder of Matrix Market files.

        Contacts, unbalance, supports, bearings, gravity and a static force are given as for a
        system by its matrices. See `rotor_ida.model.system_files.read_system`.
        """
        from rotor_ida.model.system_files import read_system  # noqa: PLC0415

        return changed_system(cls.from_file, cls(**read_system(path)), changed)

    def to_file(self, path: str | Path, *, overwrite: bool = False) -> Path:
        """Write the system with all that acts on it to a file that `load_system` reads.

        Parameters
        ----------
        path : path-like
            The file, ending in .toml. Its matrices go into an .npz file of the same name.
        overwrite : bool
            Whether existing files may be replaced.

        Returns
        -------
        Path
            The file.

        Raises
        ------
        InputError
            If a file exists or cannot be written; if a part of the static force is a weight that
            `gravity_in_static_force` describes, or acts on stators.
        """
        from rotor_ida.model.system_writing import write_system  # noqa: PLC0415

        return write_system(self, path, overwrite=overwrite)

    def reduced(self, *, modes: int, keep: Sequence[str] | None = None) -> RotorSystem:
        """Return the system in fewer coordinates, with the same contacts, unbalance and supports.

        See `rotor_ida.model.reduction.reduced_system`.
        """
        from rotor_ida.model.reduction import reduced_system  # noqa: PLC0415

        return reduced_system(self, modes=modes, keep=keep)


def with_springs(
    system: RotorSystem, springs: Iterable[tuple[Values, Values, Values]], **changed: Any
) -> RotorSystem:
    """Return a system with springs and dampers in its matrices, and other fields.

    Each is given by the rows of its displacements, its stiffness and its damping.
    """
    stiffness = system.stiffness.copy()
    damping = np.zeros_like(stiffness) if system.damping is None else system.damping.copy()
    for rows, spring, damper in springs:
        stiffness += rows.T @ spring @ rows
        damping += rows.T @ damper @ rows
    damped = damping if damping.any() else None
    return replace(system, stiffness=stiffness, damping=damped, **changed)


def with_supports(system: RotorSystem, supports: Sequence[Support]) -> RotorSystem:
    """Return a system with the springs and dampers of supports in its matrices, and none left."""
    springs = [(system.rows(each.node), np.diag(np.asarray(each.stiffness)),
                np.diag(np.asarray(each.damping))) for each in supports]  # fmt: skip
    return with_springs(system, springs, supports=())


def levitated_system(system: RotorSystem, speed: float | None = None) -> RotorSystem:
    """Return a system whose supports are in its matrices, with the static loads that they carry.

    A magnetic bearing holds its node at the centre and carries its static load, whatever that is,
    as the integral part of a controller does; about the centre it is a spring and a damper. The
    static force leaves the weight out, which gravity adds in a run. Constant bearings are in
    its matrices too; those that are left depend on the speed, and help the supports to carry the
    loads with their coefficients at a `speed`, if one is given.
    """
    varying = tuple(each for each in system.bearings if each.varies)
    if len(varying) < len(system.bearings):
        constant = [each for each in system.bearings if not each.varies]
        springs = [(system.rows_between(each), *each.at(0.0)) for each in constant]
        system = with_springs(system, springs, bearings=varying)
    if not system.supports:
        return system
    held = with_supports(system, system.supports)
    force = force_of(system)[: system.size]
    if not force.any():
        return held
    rows = np.concatenate([system.rows(each.node) for each in system.supports])
    given = system.static_force
    carried = np.zeros(system.size) if given is None else given.copy()
    stiffness = held.stiffness if speed is None else held.at(speed).stiffness
    carried[: system.size] += rows.T @ held_at_centre(stiffness, force, rows)[1]
    return replace(held, static_force=carried)


def force_of(system: RotorSystem) -> Values:
    """Return the constant force: the static one, which may be on stators too, and the weight."""
    given = system.static_force
    force = np.zeros(system.size) if given is None else given.copy()
    if system.gravity is not None:
        force[: system.size] += system.weight(system.gravity)
    return force


def unbalance_of(system: RotorSystem, size: int) -> Values:
    """Return the force of all unbalance over the square of the speed."""
    both = np.zeros((2, size))
    for each in system.unbalance:
        x, y = system.rows(each.node)
        cosine, sine = np.cos(each.phase), np.sin(each.phase)
        both[0, : system.size] += each.moment * (cosine * x + sine * y)
        both[1, : system.size] += each.moment * (cosine * y - sine * x)
    return both


def held_at_centre(stiffness: Values, force: Values, rows: Values) -> tuple[Values, Values]:
    """Return the displacement at rest with some rows of it held at zero, and their loads.

    Notes
    -----
    ``K q = f + B' p`` and ``B q = 0``, with the rows B and their loads p.
    """
    size = len(stiffness)
    if not len(rows):  # held by nothing but its own stiffness, if it has any
        found = np.linalg.lstsq(stiffness, force)[0]
        left = stiffness @ found - force
        held = np.abs(left).max(initial=0.0) <= BALANCED * np.abs(force).max(initial=0.0)
        return np.asarray(found if held else np.zeros(size)), np.zeros(0)
    scale = float(np.abs(stiffness).max()) or 1.0
    both = np.block([[stiffness, -scale * rows.T], [scale * rows, np.zeros((len(rows),) * 2)]])
    right = np.concatenate([force, np.zeros(len(rows))])
    found = np.linalg.lstsq(both, right)[0]
    if not np.abs(both @ found - right).max() <= BALANCED * np.abs(right).max(initial=0.0):
        raise InputError("supports must hold the rotor against its static forces, got too few")
    return found[:size], scale * found[size:]


def changed_system(
    verb: Callable[..., Any],
    given: object,
    changed: SystemParameters,
    *,
    others: Collection[str] = (),
) -> RotorSystem:
    """Return the system that a function is given first, with the fields that keywords change.

    One disc is taken as a system. `others` are keywords that the function takes as well.

    Examples
    --------
    >>> def touch(system: RotorSystem, *, speed: float, **changed: Unpack[SystemParameters]): ...
    >>> changed_system(touch, Rotor(omega=2.0, zeta=0.07, delta0=0.5), {"contacts": []}).contacts
    ()
    >>> changed_system(touch, "pump.toml", {})
    Traceback (most recent call last):
    ...
    rotor_ida.errors.InputError: touch takes a Rotor, DimensionalRotor or RotorSystem first, as in
    touch(system, speed=...), got 'pump.toml'
    """
    for name in changed:
        if name not in SystemParameters.__annotations__:
            known = [each for each, of in inspect.signature(verb).parameters.items()
                     if of.kind is of.KEYWORD_ONLY]  # fmt: skip
            hint = did_you_mean(name, [*known, *SystemParameters.__annotations__, *others])
            raise TypeError(
                f"{name_of(verb)}() got an unexpected keyword argument {shown(name)}{hint}"
            )
    system = given.system() if isinstance(given, Rotor | DimensionalRotor) else given
    if not isinstance(system, RotorSystem):
        refuse_first(verb, KINDS, given)
    return replace(system, **cast("Any", changed)) if changed else system


def refuse_first(verb: Callable[..., Any], kinds: str, given: object) -> NoReturn:
    """Refuse a first argument that is no rotor of these kinds; the message shows the right call."""
    parameters = inspect.signature(verb).parameters
    needed = [f"{name}=..." for name, each in parameters.items()
              if each.kind is each.KEYWORD_ONLY and each.default is each.empty]  # fmt: skip
    call = ", ".join([next(iter(parameters), "rotor"), *needed])
    name = name_of(verb)
    raise InputError(f"{name} takes {kinds} first, as in {name}({call}), got {shown(given)}")


def name_of(verb: Callable[..., Any]) -> str:
    """Return the public name of a function."""
    return verb.__name__.removesuffix("_system").removesuffix("_disc")


def _pair(name: str, given: object) -> tuple[float, float]:
    """Return two numbers, along x and y."""
    values = check_array(name, given, largest=LARGEST_IN_MATRIX)
    if values.shape != (2,):
        raise InputError(f"{name} must be two numbers, along x and y, got {shown(given)}")
    return float(values[0]), float(values[1])


def _shaped(name: str, given: object, shape: tuple[int, ...]) -> Values:
    values = check_array(name, given, largest=LARGEST_IN_MATRIX)
    if values.shape != shape:
        raise InputError(f"{name} must have the shape {shape}, got {values.shape}")
    return values.copy()


def check_dimensions(name: str, shape: Any) -> None:
    """Refuse a larger array than a system may have, before there is one.

    Examples
    --------
    >>> check_dimensions("mass", (20_000, 20_000))
    Traceback (most recent call last):
    ...
    rotor_ida.errors.InputError: mass must have at most 2000 rows and columns, got the shape
    (20000, 20000): reduce the model first, for example by component modes
    """
    if max(shape, default=0) > MOST_COORDINATES:
        raise InputError(
            f"{name} must have at most {MOST_COORDINATES} rows and columns, got the shape "
            f"{tuple(shape)}: reduce the model first, for example by component modes"
        )


def _square(name: str, given: object, size: int | None = None) -> Values:
    check_dimensions(name, getattr(given, "shape", ()))
    if hasattr(given, "toarray"):
        given = given.toarray()
    values = check_array(name, given, largest=LARGEST_IN_MATRIX)
    check_dimensions(name, values.shape)
    if values.ndim != 2 or values.shape[0] != values.shape[1] or values.size == 0:
        raise InputError(f"{name} must be a square matrix, got an array of shape {values.shape}")
    if size is not None and len(values) != size:
        raise InputError(f"{name} must have the shape of mass, {(size, size)}, got {values.shape}")
    return values.copy()


def _symmetric(name: str, matrix: Values, sign: float = 1.0) -> Values:
    """Return a matrix that is symmetric, or skew-symmetric, but for rounding."""
    apart = float(np.abs(matrix - sign * matrix.T).max())
    if apart > ROUNDED * float(np.abs(matrix).max(initial=0.0)):
        kind = "symmetric" if sign > 0.0 else "skew-symmetric"
        raise InputError(f"{name} must be {kind}, got a matrix that differs by {apart:.3g}")
    return np.asarray(0.5 * (matrix + sign * matrix.T))


def _nodes(given: object, size: int) -> Mapping[str, Node]:
    """Return nodes as pairs of indices, or as arrays of two rows."""
    if not isinstance(given, Mapping):
        raise InputError(f"nodes must map names to pairs of indices, got {shown(given)}")
    nodes: dict[str, Node] = {}
    for name, node in given.items():
        where = f"node {check_name('names of nodes', name)!r}"
        values = check_array(where, node, largest=LARGEST_IN_ROW)
        if values.shape == (2,):
            indices = tuple(int(value) for value in values)
            allowed = range(size)
            if (values != indices).any() or any(i not in allowed for i in indices):
                raise InputError(
                    f"{where} must be two indices from 0 to {size - 1}, got {shown(node)}"
                )
            if indices[0] == indices[1]:
                raise InputError(
                    f"{where} must have different indices along x and y, got {shown(node)}"
                )
            nodes[name] = (indices[0], indices[1])
        elif values.shape == (2, size):
            values.setflags(write=False)
            nodes[name] = values
        else:
            raise InputError(
                f"{where} must be two indices or an array of shape (2, {size}), "
                f"got shape {values.shape}"
            )
    return nodes


def _positions(given: object, nodes: Mapping[str, Node]) -> Mapping[str, float]:
    """Return the axial positions of all nodes."""
    if not isinstance(given, Mapping):
        raise InputError(f"positions must map each name of a node to a number, got {shown(given)}")
    for name in given:
        check_choice("node in positions", name, list(nodes))
    for name in nodes:
        if name not in given:
            raise InputError(f"positions must map each name of a node to a number, got no {name!r}")
    return {name: check_real(f"position of node {name!r}", given[name]) for name in nodes}
