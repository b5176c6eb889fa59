"""Bearings by their coefficients: what is taken, interpolated and put into a system's matrices."""

from dataclasses import replace
from typing import Any, cast

import numpy as np
import pytest

from rotor_ida import Bearing, Contact, InputError, RotorSystem
from rotor_ida.arrays import Values
from rotor_ida.results.question import Question, arguments_from

SPEEDS = np.array([100.0, 200.0, 250.0, 400.0, 700.0])
RANDOM = np.random.default_rng(7)
TABLE: dict[str, Any] = {"speed": SPEEDS, "stiffness": RANDOM.normal(size=(5, 2, 2)),
         "damping": RANDOM.uniform(size=(5, 2, 2))}  # fmt: skip
SYSTEM = RotorSystem(
    mass=np.eye(4), stiffness=np.diag([3.0, 3.0, 1.0, 1.0]),
    nodes={"disc": (0, 1), "casing": np.eye(4)[2:]},
)  # fmt: skip


def monotone_cubic(x: Values, y: Values, at: float) -> float:
    """Fritsch and Butland's interpolant of numbers, written anew."""
    h, slope = np.diff(x), np.diff(y) / np.diff(x)
    d = np.zeros_like(x)
    for i in range(1, len(x) - 1):
        if slope[i - 1] * slope[i] > 0.0:
            first, second = 2.0 * h[i] + h[i - 1], h[i] + 2.0 * h[i - 1]
            d[i] = (first + second) / (first / slope[i - 1] + second / slope[i])
    for end, (one, two) in {0: (0, 1), -1: (-1, -2)}.items():
        own = ((2.0 * h[one] + h[two]) * slope[one] - h[one] * slope[two]) / (h[one] + h[two])
        if own * slope[one] <= 0.0:
            own = 0.0
        elif slope[one] * slope[two] < 0.0 and abs(own) > 3.0 * abs(slope[one]):
            own = 3.0 * slope[one]
        d[end] = own
    i = int(np.searchsorted(x, at)) - 1
    t = (at - x[i]) / h[i]
    return float(
        y[i] * (1.0 + 2.0 * t) * (1.0 - t) ** 2 + y[i + 1] * t * t * (3.0 - 2.0 * t)
        + h[i] * (d[i] * t * (1.0 - t) ** 2 - d[i + 1] * t * t * (1.0 - t))
    )  # fmt: skip


@pytest.mark.parametrize("speed", [101.0, 222.0, 333.0, 699.9])
def test_coefficients_between_the_rows_are_monotone_cubics(speed: float) -> None:
    film = Bearing(node="disc", **TABLE)
    place = int(np.searchsorted(film.knots, speed)) - 1
    powers = (speed - film.knots[place]) ** np.arange(3, -1, -1)
    for name, found in zip(("stiffness", "damping"), film.at(speed), strict=True):
        for i, j in np.ndindex(2, 2):
            expected = monotone_cubic(SPEEDS, TABLE[name][:, i, j], speed)
            np.testing.assert_allclose(found[i, j], expected, rtol=1e-13)
        cubics = getattr(film, f"{name}_cubics")
        np.testing.assert_allclose(np.tensordot(powers, cubics[:, place], 1), found, rtol=1e-13)


def test_the_rows_themselves_come_back() -> None:
    film = Bearing(node="disc", **TABLE)
    for row, speed in enumerate(SPEEDS):
        np.testing.assert_allclose(film.at(speed)[0], TABLE["stiffness"][row], rtol=1e-14)
    np.testing.assert_array_equal(film.at(700.0 * (1.0 + 1e-14))[1], film.at(700.0)[1])


@pytest.mark.parametrize("speed", [None, 300.0])
def test_one_row_is_the_same_at_every_speed(speed: float | None) -> None:
    matrix = [[2.0, 1.0], [-1.0, 2.0]]
    film = Bearing(node="disc", stiffness=matrix, damping=0.5, speed=speed)
    assert not film.varies
    for at in (0.0, 1e4):
        assert film.at(at)[0].tolist() == matrix
        assert film.at(at)[1].tolist() == [[0.5, 0.0], [0.0, 0.5]]


def test_a_bearing_joins_the_matrices_at_a_speed() -> None:
    film = Bearing(node="disc", stator="casing", **TABLE)
    held = replace(SYSTEM, bearings=[film]).at(222.0)
    assert held.bearings == ()
    stiffness, damping = film.at(222.0)
    joint = np.array([[1.0, 0.0, -1.0, 0.0], [0.0, 1.0, 0.0, -1.0]])
    np.testing.assert_allclose(held.stiffness - SYSTEM.stiffness, joint.T @ stiffness @ joint)
    assert held.damping is not None
    np.testing.assert_allclose(held.damping, joint.T @ damping @ joint)
    assert SYSTEM.at(222.0) is SYSTEM


@pytest.mark.parametrize(
    ("given", "words"),
    [
        ({"node": 3}, "node must be the name of a node, got 3"),
        ({"stator": 7}, "stator of the bearing at 'disc' must be the name of a node, got 7"),
        ({"stiffness": np.nan}, "stiffness of the bearing at 'disc' must be a finite real number"),
        ({"stiffness": np.ones(3)}, "stiffness of the bearing at 'disc' must be a number, or an "
         r"array of shape \(2, 2\), \(5,\) or \(5, 2, 2\), got shape \(3,\)"),
        ({"speed": None}, r"must be a number or an array of shape \(2, 2\), got shape \(5, 2, 2\)"),
        ({"speed": SPEEDS[::-1]}, "speed of the bearing at 'disc' must increase, got 400"),
        ({"speed": [-1.0, 2.0]}, "speed of the bearing at 'disc' must be zero or positive, got -1"),
        ({"name": "film\n"}, "name of a bearing must have no control characters"),
        ({"name": "free end", "damping": 1e31},
         "damping of the bearing 'free end' at 'disc' must lie within 1e"),
        ({"damping": 1e31}, "damping of the bearing at 'disc' must lie within 1e"),
    ],
)  # fmt: skip
def test_a_bad_bearing_is_refused_in_one_line(given: dict[str, Any], words: str) -> None:
    with pytest.raises(InputError, match=words) as refused:
        Bearing(**{"node": "disc", **TABLE} | given)
    assert "\n" not in str(refused.value)


def test_a_speed_outside_the_table_is_refused_with_its_unit() -> None:
    held = replace(SYSTEM, bearings=[Bearing(node="disc", **TABLE)])
    words = "within the table of the bearing at 'disc', from 100 rad/s to 700 rad/s, got "
    named = replace(SYSTEM, bearings=[Bearing(node="disc", name="free end", **TABLE)])
    with pytest.raises(InputError, match="table of the bearing 'free end' at 'disc', from 100"):
        named.at(99.0)
    for speed, told in ((99.0, "99 rad/s"), (701.0, "701 rad/s"), (-200.0, "-200 rad/s")):
        with pytest.raises(InputError, match=words + told):
            held.at(speed)
    with pytest.raises(InputError, match="speed must be a finite real number, got nan"):
        held.at(np.nan)


def test_a_bearing_belongs_to_nodes_of_the_system() -> None:
    with pytest.raises(InputError, match="node must be one of 'disc', 'casing', got 'dsic'"):
        replace(SYSTEM, bearings=[Bearing(node="dsic", stiffness=1.0)])
    same = Bearing(node="disc", stator="disc", stiffness=1.0)
    with pytest.raises(InputError, match="stator of the bearing at 'disc' must be another node"):
        replace(SYSTEM, bearings=[same])
    with pytest.raises(InputError, match="bearings must be a Bearing, got Contact"):
        replace(SYSTEM, bearings=cast("Any", [Contact(node="disc", clearance=1.0, stiffness=1.0)]))


@pytest.mark.parametrize("given", [TABLE, {"stiffness": 2.0}, {"stiffness": 2.0, "speed": 5.0}])
def test_replace_and_a_question_keep_a_bearing(given: dict[str, Any]) -> None:
    film = Bearing(node="disc", stator="casing", name="free end", **given)
    asked = Question("campbell", {"rotor": replace(SYSTEM, bearings=[film])})
    (again,) = arguments_from(asked.plain())["rotor"].bearings
    for other in (again, replace(film, node="disc")):
        assert repr(other) == repr(film)
        assert other.name == "free end"
        for name in ("stiffness", "damping", "knots", "stiffness_cubics", "damping_cubics"):
            np.testing.assert_array_equal(getattr(other, name), getattr(film, name))
