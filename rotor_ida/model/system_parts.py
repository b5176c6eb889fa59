"""The parts of a rotor system: contacts, stators, races, unbalance and supports."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import combinations
from typing import TypeVar

import numpy as np

from rotor_ida.checks import (
    check_array,
    check_between,
    check_flag,
    check_instance,
    check_nonnegative,
    check_real,
    shown,
    with_hints,
)
from rotor_ida.errors import InputError
from rotor_ida.model.contact import HERTZ_EXPONENT

MOST_CONTACTS = 16
# Squares of smaller lengths are lost beside other numbers, and powers of larger numbers overflow.
SMALLEST_LENGTH, LARGEST_LENGTH, LARGEST = 1e-20, 1e15, 1e30


@with_hints
@dataclass(frozen=True, kw_only=True, slots=True)
class Race:
    """The inner race of a bearing, which friction spins up.

    Parameters
    ----------
    radius : float
        Radius of its surface.
    inertia : float
        Moment of inertia about its axis.
    drag : float
        Drag torque over speed.
    speed : float
        Speed at time 0.
    """

    radius: float
    inertia: float
    drag: float = 0.0
    speed: float = 0.0

    def __post_init__(self) -> None:
        for name, check in (
            ("radius", _length), ("inertia", _positive), ("drag", _nonnegative),
            ("speed", check_real),
        ):  # fmt: skip
            object.__setattr__(self, name, check(f"{name} of a race", getattr(self, name)))


@with_hints
@dataclass(frozen=True, kw_only=True, slots=True, eq=False)
class Stator:
    """A stator that moves: a mass on springs and dampers, with two degrees of freedom of its own.

    Contacts that are given the same stator share it, and its race, which the friction of all turns.

    Parameters
    ----------
    mass : float
        Its mass. With 0 its mount must be damped; its velocity follows the force of its contact.
        Derivatives, as for multipliers, exponents and fits, are then differences of runs, known to
        about 1e-7, and curves of bifurcations are refused.
    stiffness, damping : float or (float, float)
        Stiffness and damping of its mount, along x and y; without mass the damping is the same
        along both.
    weight : bool
        Whether gravity acts on it.
    race : Race, optional
        Its inner race.
    """

    mass: float
    stiffness: float | tuple[float, float]
    damping: float | tuple[float, float] = 0.0
    weight: bool = True
    race: Race | None = None

    def __post_init__(self) -> None:
        object.__setattr__(self, "mass", _nonnegative("mass of a stator", self.mass))
        for name in ("stiffness", "damping"):
            object.__setattr__(self, name, _along_both(f"{name} of a stator", getattr(self, name)))
        pair = np.broadcast_to(self.damping, 2)
        if self.mass == 0.0 and not pair[0] == pair[1] > 0.0:
            raise InputError(
                "{name} must be positive, and the same along x and y, got {value}",
                name="damping of a stator without mass",
                value=self.damping,
            )
        check_flag("weight", self.weight)
        if self.race is not None:
            check_instance("race", self.race, Race)


@with_hints
@dataclass(frozen=True, kw_only=True, slots=True)
class Contact:
    """A contact between a node of the rotor and a stator around it.

    Parameters
    ----------
    node : str
        Name of the node.
    clearance : float
        Radial clearance; 0 for a contact that never opens, without friction and damping.
    stiffness : float
        Stiffness k of the normal force ``N = k d**n (1 + lambda d')``, d the indentation.
    exponent : {1.5, 1.0}
        Exponent n.
    damping : float
        Contact damping lambda: relative increase of the force per unit approach speed.
    friction : float
        Coefficient of Coulomb friction.
    radius : float, optional
        Radius of the rotor's surface; required with friction.
    centre : (float, float)
        Offset of the stator's centre from the node's position at rest.
    stator : str or Stator, optional
        Another node of the system, or a stator with degrees of freedom of its own. Default: the
        ground.
    race : Race, optional
        The inner race of a bearing on the ground.

    Examples
    --------
    >>> Contact(node="disc", clearance=1e-4, stiffness=5e6, exponent=1.0).friction
    0.0
    """

    node: str
    clearance: float
    stiffness: float
    exponent: float = HERTZ_EXPONENT
    damping: float = 0.0
    friction: float = 0.0
    radius: float | None = None
    centre: tuple[float, float] = (0.0, 0.0)
    stator: str | Stator | None = None
    race: Race | None = None

    def __post_init__(self) -> None:
        named_node(self.node)
        where = f"of {self.words}"
        for name, check in (
            ("clearance", _clearance), ("stiffness", _positive), ("damping", _nonnegative),
            ("friction", _nonnegative),
        ):  # fmt: skip
            object.__setattr__(self, name, check(f"{name} {where}", getattr(self, name)))
        if self.clearance == 0.0:
            self._check_without_clearance(where)
        exponent = check_real(f"exponent {where}", self.exponent)
        if exponent not in {1.0, HERTZ_EXPONENT}:
            raise InputError(f"exponent {where} must be 1.5 or 1.0, got {exponent!r}")
        object.__setattr__(self, "exponent", exponent)
        if self.radius is not None:
            object.__setattr__(self, "radius", _length(f"radius {where}", self.radius))
        elif self.friction > 0.0:
            raise InputError(f"radius {where} must be given with friction, got None")
        centre = check_array(f"centre {where}", self.centre, largest=LARGEST_LENGTH)
        if centre.shape != (2,):
            raise InputError(f"centre {where} must be two numbers, got {shown(self.centre)}")
        object.__setattr__(self, "centre", (float(centre[0]), float(centre[1])))
        if self.stator is not None and not isinstance(self.stator, str | Stator):
            raise InputError(
                f"stator {where} must be the name of a node or a Stator, got {shown(self.stator)}"
            )
        if self.race is not None:
            check_instance("race", self.race, Race)
            if isinstance(self.stator, Stator) and self.stator.race is not None:
                raise InputError(f"race {where} must be given once, got one of its stator as well")

    def _check_without_clearance(self, where: str) -> None:
        """Refuse what needs a direction of the displacement, which has none at the centre."""
        for name in ("friction", "damping"):
            if value := getattr(self, name):
                raise InputError(
                    "{name} must be 0 without clearance, where the radius may vanish in contact, "
                    "got {value}",
                    name=f"{name} {where}", value=value,
                )  # fmt: skip
        if isinstance(self.stator, Stator) and self.stator.mass == 0.0:
            raise InputError(f"clearance {where} must be positive with a stator without mass")

    @property
    def words(self) -> str:
        """The contact in a message."""
        return f"the contact at {shown(self.node)}"

    @property
    def spinning_race(self) -> Race | None:
        """The race that friction spins up, of the contact or of its stator."""
        if self.race is None and isinstance(self.stator, Stator):
            return self.stator.race
        return self.race


@with_hints
@dataclass(frozen=True, kw_only=True, slots=True)
class Unbalance:
    """An unbalance at a node.

    Parameters
    ----------
    node : str
        Name of the node.
    moment : float
        Mass times eccentricity.
    phase : float
        Its angle from the direction that points along x at time 0 [rad].

    Examples
    --------
    >>> Unbalance(node="disc", moment=2e-4)
    Unbalance(node='disc', moment=0.0002, phase=0.0)
    """

    node: str
    moment: float
    phase: float = 0.0

    def __post_init__(self) -> None:
        where = f"of the unbalance at {named_node(self.node)}"
        object.__setattr__(self, "moment", _nonnegative(f"moment {where}", self.moment))
        object.__setattr__(self, "phase", check_real(f"phase {where}", self.phase))
        if not math.isfinite(self.phase):
            raise InputError(f"phase {where} must be finite, got {self.phase!r}")


@with_hints
@dataclass(frozen=True, kw_only=True, slots=True)
class Support:
    """A magnetic bearing, linear about the centre in which it levitates a node.

    It carries the static load of its node without a deflection, as the integral part of its
    controller does.

    Parameters
    ----------
    node : str
        Name of the node.
    stiffness, damping : float or (float, float)
        Stiffness and damping, along x and y.

    Examples
    --------
    >>> Support(node="disc", stiffness=2e6, damping=1e3)
    Support(node='disc', stiffness=(2000000.0, 2000000.0), damping=(1000.0, 1000.0))
    """

    node: str
    stiffness: float | tuple[float, float]
    damping: float | tuple[float, float] = 0.0

    def __post_init__(self) -> None:
        where = f"of the support at {named_node(self.node)}"
        for name in ("stiffness", "damping"):
            object.__setattr__(self, name, _along_both(f"{name} {where}", getattr(self, name)))


Part = TypeVar("Part")


def check_list(name: str, given: object, kind: type[Part]) -> tuple[Part, ...]:
    """Return a list of parts, such as contacts, as a tuple."""
    if isinstance(given, kind) or not isinstance(given, Sequence):
        raise InputError(f"{name} must be a list of {kind.__name__}, got {shown(given)}")
    return tuple(check_instance(name, each, kind) for each in given)


def stators_of(contacts: Sequence[Contact]) -> tuple[Stator, ...]:
    """Return the stators of contacts, those without mass behind; refuse one that two push."""
    given = [each.stator for each in contacts if isinstance(each.stator, Stator)]
    for number, contact in enumerate(contacts):
        stator = contact.stator
        if isinstance(stator, Stator) and stator.mass == 0.0:
            shared = sum(each is stator for each in given)
            if shared > 1:
                raise InputError(
                    f"a stator without mass must have one contact, got {shared} of that of contact "
                    f"{number} at {shown(contact.node)}"
                )
    return tuple(sorted({id(each): each for each in given}.values(), key=lambda s: s.mass == 0.0))


def check_contacts(contacts: Sequence[Contact]) -> None:
    """Refuse too many contacts, or two between the same bodies that are one or leave no room."""
    if len(contacts) > MOST_CONTACTS:
        raise InputError(f"contacts must be at most {MOST_CONTACTS}, got {len(contacts)}")
    seen: dict[tuple[object, ...], int] = {}
    for number, each in enumerate(contacts):
        place = (each.node, each.centre, each.clearance,
                 each.stator if isinstance(each.stator, str) else id(each.stator))  # fmt: skip
        if place in seen:
            raise InputError(
                "contacts must not overlap, got contacts {first} and {number} at node {node!r} "
                "with the same stator, centre and {clearance=}",
                first=seen[place],
                number=number,
                node=each.node,
                clearance=each.clearance,
            )
        seen[place] = number
    for (first, one), (second, other) in combinations(enumerate(contacts), 2):
        stators = {each.stator if isinstance(each.stator, str) else id(each.stator)
                   for each in (one, other)}  # fmt: skip
        apart = math.dist(one.centre, other.centre)
        has_room = apart < one.clearance + other.clearance
        if one.node == other.node and len(stators) == 1 and not has_room:
            raise InputError(
                "contacts {first} and {second} at node {node!r} must leave it room, got centres "
                "{reach:.6g} apart with clearances {clearance} and {radius}",
                first=first, second=second, node=one.node, reach=apart,
                clearance=one.clearance, radius=other.clearance,
            )  # fmt: skip


def check_clearances(contacts: Sequence[Contact]) -> None:
    """Refuse contacts without clearance, by which the closed forms of whirls measure amplitudes."""
    for each in contacts:
        if each.clearance == 0.0:
            raise InputError(
                "{name} must be above 0 for synchronous_response, special_speeds and "
                "clearance_report, got {value}; sweep and limit_cycle take it",
                name=f"clearance of {each.words}", value=each.clearance,
            )  # fmt: skip


def _along_both(name: str, value: float | Sequence[float]) -> tuple[float, float]:
    """Return a number along x and y, given once or for each."""
    numbers = check_array(name, value, largest=LARGEST)
    if numbers.shape not in {(), (2,)} or (numbers < 0.0).any():
        raise InputError(
            "{name} must be one or two numbers of at least 0, got {value}", name=name,
            value=numbers.item() if numbers.shape == () else shown(value),
        )  # fmt: skip
    pair = numbers if numbers.shape else (numbers, numbers)
    return float(pair[0]), float(pair[1])


def _length(name: str, value: object) -> float:
    return check_between(name, value, SMALLEST_LENGTH, LARGEST_LENGTH)


def _clearance(name: str, value: object) -> float:
    given = check_nonnegative(name, value)
    return given if given == 0.0 else _length(name, given)


def _positive(name: str, value: object) -> float:
    return check_between(name, value, 1.0 / LARGEST, LARGEST)


def _nonnegative(name: str, value: object) -> float:
    return check_nonnegative(name, value, LARGEST)


def named_node(name: object) -> str:
    """Return the name of a node as messages show it."""
    if not isinstance(name, str):
        raise InputError(f"node must be the name of a node, got {shown(name)}")
    return shown(name)
