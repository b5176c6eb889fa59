"""Bearings and seals by their linear coefficients, constant or in a table over the speed."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import Any

import numpy as np
import numpy.typing as npt

from rotor_ida.arrays import Values
from rotor_ida.checks import (
    check_array,
    check_axis,
    check_increasing,
    check_name,
    check_real,
    shown,
    with_hints,
)
from rotor_ida.errors import InputError
from rotor_ida.model.system_parts import LARGEST, named_node

# A speed beyond the end of a table by less than this part of it is the end.
ROUNDED = 1e-12
MOST_SPEEDS = 10_000


@with_hints
@dataclass(frozen=True, kw_only=True, slots=True, eq=False, repr=False)
class Bearing:
    """A bearing or seal: the force on its node is ``-(K u + C u')``, u the node's displacement.

    Parameters
    ----------
    node : str
        Name of the node.
    stiffness, damping : array_like, shape (), (2, 2), (n,) or (n, 2, 2)
        Coefficients K and C, along x and y, which need not be symmetric. A number is the
        coefficient along both, without cross-coupling. With a row for each speed the
        coefficients depend on the speed.
    speed : array_like, shape (n,), optional
        Speeds of the rows, increasing. A single speed only records where constant coefficients
        were taken.
    stator : str, optional
        The node that holds the bearing, such as one of a casing; then u is the displacement
        relative to it. Default: the ground.
    name : str, optional
        Its name in messages and tables, of at most 80 characters, such as its tag in ROSS.

    Attributes
    ----------
    stiffness, damping : ndarray, shape (2, 2) or (n, 2, 2)
        The coefficients at each speed.
    knots : ndarray, shape (n,)
        The speeds between which coefficients that depend on the speed are cubics, else empty.
    stiffness_cubics, damping_cubics : ndarray, shape (4, n - 1, 2, 2)
        Coefficients of the cubics, of the highest power first, by the speed from the knot below.

    Raises
    ------
    InputError
        If an argument cannot be used.

    Notes
    -----
    Between the rows the coefficients are monotone cubics [1]_ with one continuous derivative, which
    do not overshoot the rows. There is no extrapolation.

    References
    ----------
    .. [1] F. N. Fritsch and J. Butland, "A method for constructing local monotone piecewise cubic
       interpolants", SIAM Journal on Scientific and Statistical Computing 5 (1984) 300-304.

    Examples
    --------
    >>> film = Bearing(node="journal", speed=[100.0, 200.0, 400.0], damping=[3e3, 2e3, 1e3],
    ...                stiffness=[[[2e6, 1e6], [-1e6, 2e6]]] * 3)
    >>> film
    Bearing(node='journal', 3 speeds from 100 to 400)
    >>> stiffness, damping = film.at(200.0)
    >>> stiffness.tolist(), damping.tolist()
    ([[2000000.0, 1000000.0], [-1000000.0, 2000000.0]], [[2000.0, 0.0], [0.0, 2000.0]])
    """

    node: str
    stiffness: npt.ArrayLike
    damping: npt.ArrayLike = 0.0
    speed: npt.ArrayLike | None = None
    stator: str | None = None
    name: str | None = None
    knots: Values = field(init=False)
    stiffness_cubics: Values = field(init=False)
    damping_cubics: Values = field(init=False)

    def __post_init__(self) -> None:
        named_node(self.node)
        if self.name is not None:
            check_name("name of a bearing", self.name)
        where = f"of {self.words}"
        if self.stator is not None and not isinstance(self.stator, str):
            raise InputError(f"stator {where} must be the name of a node, got {shown(self.stator)}")
        from scipy.interpolate import PchipInterpolator  # noqa: PLC0415 - takes long to import

        speeds = np.zeros(0)
        if self.speed is not None:
            name = f"speed {where}"
            speeds = check_increasing(name, check_axis(name, self.speed, largest=LARGEST))
            if speeds.size > MOST_SPEEDS:
                raise InputError(f"{name} must be at most {MOST_SPEEDS} numbers, got {speeds.size}")
        keep = {"knots": speeds if speeds.size > 1 else np.zeros(0)}
        if speeds.size:
            keep["speed"] = speeds
        for name in ("stiffness", "damping"):
            keep[name] = _matrices(f"{name} {where}", getattr(self, name), speeds.size)
        varies = speeds.size > 1 and any(keep[each].ndim == 3 for each in ("stiffness", "damping"))
        for name in ("stiffness", "damping"):
            rows = keep[name]
            if not varies:
                keep["knots"] = np.zeros(0)
                keep[name] = rows[0] if rows.ndim == 3 else rows
                keep[f"{name}_cubics"] = np.zeros((4, 0, 2, 2))
                continue
            keep[name] = np.broadcast_to(rows, (speeds.size, 2, 2)).copy()
            keep[f"{name}_cubics"] = PchipInterpolator(speeds, keep[name]).c
        for name, values in keep.items():
            values.setflags(write=False)
            object.__setattr__(self, name, values)

    @property
    def words(self) -> str:
        """The bearing in a message, as in "the bearing 'film' at 'journal'"."""
        name = "" if self.name is None else f" {shown(self.name)}"
        return f"the bearing{name} at {shown(self.node)}"

    @property
    def varies(self) -> bool:
        """Whether the coefficients depend on the speed."""
        return self.knots.size > 0

    def at(self, speed: float) -> tuple[Values, Values]:
        """Return stiffness and damping at a speed, each of shape (2, 2).

        Raises
        ------
        InputError
            If the speed is outside the table.
        """
        given = np.asarray(check_real("speed", speed))
        self.check(given)
        return self.coefficients("stiffness", given), self.coefficients("damping", given)

    def check(self, speeds: Values) -> None:
        """Refuse speeds outside the table."""
        if not self.varies:
            return
        least, most = self.knots[[0, -1]].tolist()
        outside = np.abs(np.clip(speeds, least, most) - speeds)
        if outside.max(initial=0.0) > ROUNDED * most:
            raise InputError(
                "{name} must lie within the table of {bearing}, from {least:.6g} to {most:.6g}, "
                "got {value}",
                name="speed", bearing=self.words, least=least, most=most,
                value=float(speeds.flat[outside.argmax()]),
            )  # fmt: skip

    def coefficients(self, name: str, speeds: Values, derivative: int = 0) -> Values:
        """Return stiffness or damping at speeds, shape (..., 2, 2), or a derivative by the speed.

        Beyond the table they are those at its end.
        """
        if not self.varies:
            rows = np.asarray(getattr(self, name)) if derivative == 0 else np.zeros((2, 2))
            return np.broadcast_to(rows, (*speeds.shape, 2, 2))
        from scipy.interpolate import PPoly  # noqa: PLC0415 - takes long to import

        cubics = PPoly.construct_fast(getattr(self, f"{name}_cubics"), self.knots)
        held = np.clip(speeds, self.knots[0], self.knots[-1])
        return np.asarray(cubics(held, derivative))

    @property
    def is_isotropic(self) -> bool:
        """Whether the bearing is the same in all directions at every speed."""
        return all(
            (each[..., 0, 0] == each[..., 1, 1]).all()
            and (each[..., 0, 1] == -each[..., 1, 0]).all()
            for each in (np.asarray(self.stiffness), np.asarray(self.damping))
        )

    def __repr__(self) -> str:
        speeds = np.zeros(0) if self.speed is None else np.asarray(self.speed)
        given = {"stator": self.stator, "name": self.name}
        told = "".join(f", {key}={each!r}" for key, each in given.items() if each is not None)
        if self.varies:
            told += f", {speeds.size} speeds from {speeds[0]:.6g} to {speeds[-1]:.6g}"
        elif speeds.size:
            told += f", speed={speeds[0]:.6g}"
        return f"Bearing(node={self.node!r}{told})"


@dataclass(frozen=True, slots=True)
class Films:
    """The bearings of a system whose coefficients depend on the speed, in some coordinates.

    Parameters
    ----------
    bearings : tuple of Bearing
        The bearings.
    rows : ndarray, shape (bearing, 2, n)
        Their displacements along x and y by the coordinates, which may be complex.
    """

    bearings: tuple[Bearing, ...]
    rows: npt.NDArray[Any]

    def __bool__(self) -> bool:
        return bool(self.bearings)

    @property
    def knots(self) -> Values:
        """The speeds between which all coefficients are cubics, in ascending order."""
        return np.unique(np.concatenate([np.zeros(0), *(each.knots for each in self.bearings)]))

    @property
    def reach(self) -> tuple[float, float]:
        """The lowest and the highest speed that are within all tables; from 0 without any."""
        ends = [each.knots[[0, -1]].tolist() for each in self.bearings]
        return (max((first for first, _ in ends), default=0.0),
                min((last for _, last in ends), default=math.inf))  # fmt: skip

    def matrix(self, name: str, speeds: Values | float, derivative: int = 0) -> npt.NDArray[Any]:
        """Return the stiffness or damping matrix of all at speeds, shape (..., n, n)."""
        at = np.asarray(speeds, float)
        found = np.zeros((*at.shape, *self.rows.shape[-1:] * 2), self.rows.dtype)
        for each, rows in zip(self.bearings, self.rows, strict=True):
            found += rows.conj().T @ each.coefficients(name, at, derivative) @ rows
        return found

    def product(self, name: str, speeds: Values, columns: npt.NDArray[Any]) -> npt.NDArray[Any]:
        """Return the stiffness or damping at each speed times a column each, shape (n, k)."""
        found = np.zeros_like(columns)
        for each, rows in zip(self.bearings, self.rows, strict=True):
            forces = np.einsum("kij,jk->ik", each.coefficients(name, speeds), rows @ columns)
            found += rows.conj().T @ forces
        return found

    def joined(
        self, matrix: npt.NDArray[Any], name: str, speeds: Values | float
    ) -> npt.NDArray[Any]:
        """Return a stiffness or damping matrix with that of the bearings at speeds.

        The shape is (..., n, n); without bearings the matrix itself, at all speeds.
        """
        return matrix + self.matrix(name, speeds) if self else matrix


def _matrices(name: str, given: object, speeds: int) -> Values:
    """Return coefficients as matrices, shape (2, 2), or (n, 2, 2) with a row for each speed."""
    values = check_array(name, given, largest=LARGEST)
    rows = max(speeds, 1)
    if values.shape not in {(), (2, 2), (rows,), (rows, 2, 2)}:
        allowed = "a number or an array of shape (2, 2)"
        if speeds:
            allowed = f"a number, or an array of shape (2, 2), ({rows},) or ({rows}, 2, 2)"
        raise InputError(f"{name} must be {allowed}, got shape {values.shape}")
    isotropic = values.ndim < 2
    return values[..., np.newaxis, np.newaxis] * np.eye(2) if isotropic else values.copy()
