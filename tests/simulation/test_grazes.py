"""Grazes of the guards inside a contact: release, slip speed and grip, just reached or not."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from rotor_ida import Rotor
from rotor_ida.simulation.options import Options
from rotor_ida.simulation.run import run


def kinds_of(rotor, start, duration, rtol, method="taylor"):
    how = Options(method=method, rtol=rtol, atol=1e-2 * rtol)
    return run(rotor, start, duration, np.array([0.0, duration]), how).event_kinds.tolist()


def border(family, low, high, start, duration):
    """Two parameters a rounding apart between which the events change, and those of each."""
    few = kinds_of(family(low), start, duration, 1e-14)
    more = kinds_of(family(high), start, duration, 1e-14)
    while more != few and high - low > 1e-13 * high:
        middle = 0.5 * (low + high)
        found = kinds_of(family(middle), start, duration, 1e-14)
        low, high, more = (middle, high, more) if found == few else (low, middle, found)
    return low, high, few, more


def graze_of_release(draw):
    """A family of rotors by their contact damping, and the two ends of a border across which one
    more release and press comes."""
    while True:
        rotor = Rotor(
            omega=draw.uniform(0.5, 3.0), zeta=draw.choice([0.0, 0.07]),
            delta0=draw.uniform(0.5, 2.0), shaft_stiffness=draw.choice([0.0, draw.uniform(0, 2)]),
            load=draw.choice([0.0, draw.uniform(0.0, 1.0)]), contact_damping=0.3,
            contact_exponent=draw.choice([1.0, 1.5]),
        )  # fmt: skip
        start = tuple((draw.uniform(-1.5, 1.5, 4) * rotor.delta0).tolist())

        def family(value, rotor=rotor):
            return replace(rotor, contact_damping=value)

        low, high, few, more = border(family, 0.3, 4.0, start, 6.0)
        if sorted(more) == sorted([*few, -4, 4]):
            return family, start, low, high


def start_that_rolls(rotor, draw):
    """A random start on which the disc rolls, if its grip is enough."""
    outwards = np.exp(1j * draw.uniform(0.0, 2.0 * np.pi))
    z = draw.uniform(1.2, 2.5) * outwards
    v = complex(draw.uniform(-1.0, 1.0), -rotor.disc_radius * rotor.omega) * outwards
    return z.real, z.imag, v.real, v.imag


def graze_of_friction(draw, kind):
    """A family of random rotors, by their friction, and the two ends of a border across which a
    pair of events comes: from sliding a roll and a slip, from rolling a slip and a roll."""
    while True:
        rotor = Rotor(
            omega=draw.uniform(0.3, 2.0), zeta=0.07, delta0=1.0, friction=0.1,
            disc_radius=draw.uniform(0.0, 4.0), load=draw.choice([0.0, draw.uniform(0.0, 1.0)]),
        )  # fmt: skip
        start, (sign, offset) = start_that_rolls(rotor, draw), (-1.0, 1.5)
        if kind == 2:
            start, (sign, offset) = tuple(draw.uniform(-1.5, 1.5, 4).tolist()), (1.0, 0.0)

        def family(value, rotor=rotor, sign=sign, offset=offset):
            return replace(rotor, friction=offset + sign * value)

        low, high = draw.uniform(0.05, 0.5), draw.uniform(0.5, 1.4)
        low, high, few, more = border(family, low, high, start, 5.0)
        if sorted(more) == sorted([*few, -2, 2]):
            place = next(i for i, (a, b) in enumerate(zip([*few, 0], more, strict=False)) if a != b)
            if more[place] == kind:
                return family, start, low, high


def graze(draw, kind):
    """A family of rotors, a start, and the two ends of a border across which two events come."""
    return graze_of_release(draw) if kind == -4 else graze_of_friction(draw, kind)


@cache
def grazes(kind, count):
    """Return grazes of a kind; they are searched for once, for all methods."""
    draw = np.random.default_rng(11)
    return [graze(draw, kind) for _ in range(count)]


# How many tolerances from a border the events are decided: docs/events.md.
FLOORS = [
    *((-4, method, floor, 6) for method, floor in (("taylor", 1e2), ("adams", 1e2), ("bdf", 1e3))),
    *(
        (kind, method, floor, 4)
        for kind in (2, -2)
        for method, floor in (("taylor", 10.0), ("adams", 1e2), ("bdf", 1e3))
    ),
]


@pytest.mark.parametrize(("kind", "method", "floor", "count"), FLOORS)
def test_grazes_are_decided_above_the_floor_that_is_stated(kind, method, floor, count):
    """Where contact damping is by so many rtol more or less than just releases (-4); and friction
    than has the slip speed just reach 0 (2), or the force of rolling just reach mu N (-2)."""
    rtol, duration = 1e-9, 6.0 if kind == -4 else 5.0
    for family, start, low, high in grazes(kind, count):
        for value in (low * (1.0 - floor * rtol), high * (1.0 + floor * rtol)):
            exact = kinds_of(family(value), start, duration, 1e-14)
            assert kinds_of(family(value), start, duration, rtol, method) == exact, family(value)


@pytest.mark.parametrize("kind", [2, -2])
def test_a_pair_of_events_comes_with_the_root_of_the_distance_from_its_border(kind):
    """A guard that is touched is a parabola there: so its two zeros part. A million times nearer
    to the border they lie a thousand times closer together, and neither is missed."""
    draw = np.random.default_rng(3)
    distances = 10.0 ** np.arange(-11.0, -4.0)
    for _ in range(4):
        family, start, low, high = graze(draw, kind)
        few, apart = kinds_of(family(low * (1.0 - 1e-6)), start, 5.0, 1e-15), []
        for distance in distances:
            assert kinds_of(family(low * (1.0 - distance)), start, 5.0, 1e-15) == few
            how = Options(method="taylor", rtol=1e-15, atol=1e-17)
            found = run(family(high * (1.0 + distance)), start, 5.0, np.array([0.0, 5.0]), how)
            assert found.event_times.size == len(few) + 2
            apart.append(np.diff(found.event_times).min())
        slope = np.polyfit(np.log(distances[:5]), np.log(apart[:5]), 1)[0]
        assert slope == pytest.approx(0.5, abs=0.01)
