"""Friction where two events meet, where rounding decides, and on discs of any size."""

from dataclasses import replace

import numpy as np
import pytest

from rotor_ida import Rotor, simulate
from rotor_ida.simulation.options import Options
from rotor_ida.simulation.run import run

WAYS = {
    "taylor": {"method": "taylor", "rtol": 1e-12},
    "adams": {"method": "adams", "rtol": 1e-12},
    "bdf": {"method": "bdf", "rtol": 1e-10, "flight": "cvode"},
    "reference": {"backend": "python", "rtol": 1e-9},
}


def end_and_kinds(rotor, start, rtol=1e-15, method="taylor"):
    how = Options(method=method, rtol=rtol, atol=1e-2 * rtol)
    found = run(rotor, start, 5.0, np.array([0.0, 5.0]), how)
    return found.states[-1], found.event_kinds.tolist()


# Families of machines across a border of two events, and where about it is: a part of the start at
# which the disc only just reverses before it rolls; a damping at which it starts without slip and
# only just rolls; a clearance at which a contact is only just pressed again before its exit. And
# other values that rounding does not tell from the border.
BORDERS = {
    "reverse or roll": (
        lambda part: (
            Rotor(omega=0.2957112503146906, zeta=0.07, delta0=2.1940159615298582, load=0.825354974,
                  shaft_stiffness=0.9048056920846299, contact_exponent=1.0,
                  friction=4.211957042629932, disc_radius=0.0),
            tuple(part * np.array([-2.47490070887, -2.00472906825, 2.36577633762, 3.14895799593])),
        ),
        1.03, 1.05, (),
    ),
    "start that slips or rolls": (
        lambda zeta: (
            Rotor(omega=1.190265091761566, zeta=zeta, delta0=2.362741581081208,
                  shaft_stiffness=0.10058207563494703, contact_damping=1.3218190378527565,
                  friction=0.5965854046461473, disc_radius=2.6002234965453614),
            (3.4514071887420066, 0.486370175554444, 0.12002036421905898, -3.108621229803047),
        ),
        0.0101, 0.0102, (),
    ),
    "pressed before the exit or not": (
        lambda delta0: (
            Rotor(omega=2.0602868608662064, zeta=0.07, delta0=delta0, contact_exponent=1.0,
                  contact_damping=1.0845155992301603, friction=0.5090684402874239,
                  disc_radius=0.0),
            (2.2457944856791667, -1.8844906034284274, -0.6617516627823992, 0.5552889181395576),
        ),
        2.02, 2.03, (2.025507825367227,),
    ),
}  # fmt: skip


@pytest.mark.parametrize("name", BORDERS)
def test_a_border_of_two_events_is_crossed_without_a_jump(name):
    """Every machine on the way to the border is followed, to the last bit of its parameter; and
    those on either side of it end at the same place, whatever their events are called."""
    family, low, high, others = BORDERS[name]
    few, many = end_and_kinds(*family(low)), end_and_kinds(*family(high))
    assert few[1] != many[1]
    while high - low > np.spacing(high):
        middle = 0.5 * (low + high)
        here = end_and_kinds(*family(middle))
        if here[1] == few[1]:
            low, few = middle, here
        else:
            high, many = middle, here
    np.testing.assert_allclose(few[0], many[0], rtol=0, atol=1e-11)
    for value in others:
        np.testing.assert_allclose(end_and_kinds(*family(value))[0], few[0], rtol=0, atol=1e-11)
    for value in (low, high):
        for method in ("adams", "bdf"):
            for rtol in (1e-7, 1e-9, 1e-11):
                end, _ = end_and_kinds(*family(value), rtol, method)
                np.testing.assert_allclose(end, few[0], rtol=0, atol=1e4 * rtol)


@pytest.mark.parametrize(
    ("rotor", "start"),
    [
        (
            Rotor(omega=0.0, zeta=0.01, delta0=2.996766716607485, load=0.714439425559054,
                  shaft_stiffness=0.4320460728901121, contact_exponent=1.0,
                  friction=0.6971417162686429, disc_radius=0.0),
            (4.249863784133986, 2.2903363592801256, -0.472435113507312, -0.25460470566280075),
        ),
        (
            Rotor(omega=0.598572317655957, zeta=0.0, delta0=1.8478159109306003,
                  shaft_stiffness=2.682653654578926, contact_exponent=1.0,
                  friction=0.2758768731509731, disc_radius=0.5),
            (-2.8885052632007686, 1.380360304981205, -0.022298783016615836, 0.34236052149621543),
        ),
    ],
)  # fmt: skip
@pytest.mark.parametrize("way", [("adams", 1e-9), ("bdf", 1e-9), ("python", 1e-10)])
def test_a_slip_speed_smaller_than_the_error_of_a_step_does_not_stop_a_run(rotor, start, way):
    """After a slip it grows like the square of time: its sign may be wrong at first."""
    name, rtol = way
    how = {"backend": name} if name == "python" else {"method": name}
    found = simulate(
        rotor, start=start, duration=4.0, samples=2, rtol=rtol, atol=1e-2 * rtol, **how
    )
    exact = simulate(rotor, start=start, duration=4.0, samples=2, method="taylor", rtol=1e-13)
    assert found.event_kind.values[0] == -2
    assert abs(found.event_time.values[0] - exact.event_time.values[0]) < 1e-8
    assert np.hypot(*(found[each].values[-1] - exact[each].values[-1] for each in "xy")) < 1e-6


@pytest.mark.parametrize("way", WAYS)
@pytest.mark.parametrize("friction", [0.25, 0.5, 1.0])
@pytest.mark.parametrize("side", [-1.0, 1.0])
def test_a_disc_rests_where_friction_can_just_hold_it(way, friction, side):
    """DESIGN section 3: at omega = 0 tilted by tan beta = mu, with N = gamma/sqrt(1 + mu**2)."""
    tilt = side * np.arctan(friction)
    radius = 1.0 + (0.5 / np.hypot(1.0, friction)) ** (2.0 / 3.0)
    rotor = Rotor(omega=0.0, zeta=0.05, delta0=1.0, load=0.5, friction=friction, disc_radius=1.0)
    start = (radius * np.sin(tilt), -radius * np.cos(tilt), 0.0, 0.0)
    found = simulate(rotor, start=start, duration=20.0, samples=21, **WAYS[way])
    assert found.sizes["event"] == 0
    assert (found.mode.values == 2).all()
    assert np.abs(found.x - start[0]).max() < 1e-9
    assert np.abs(found.y - start[1]).max() < 1e-9


@pytest.mark.parametrize(
    ("way", "radius", "error"),
    [("taylor", 1e3, 2e-10), ("taylor", 1e5, 2e-9), ("adams", 1e3, 4e-9), ("adams", 1e5, 2e-7)],
)
def test_a_disc_that_slides_forwards_moves_the_same_whatever_its_radius(way, radius, error):
    """Its radius is in no equation then. Nor may it be in the error: as moment of the slip, of
    which the angular momentum is the small rest."""
    rotor = Rotor(omega=1.3, zeta=0.05, delta0=1.0, friction=0.2, disc_radius=10.0, load=0.2)
    start = (0.3, -0.9, 0.4, 0.3)
    exact = simulate(rotor, start=start, duration=20.0, samples=2, method="taylor", rtol=1e-14)
    assert exact.sizes["event"] == 9
    large = replace(rotor, disc_radius=radius)
    found = simulate(large, start=start, duration=20.0, samples=101, method=way, rtol=1e-10)
    assert (found.slip_speed.where(found.mode != 0, 1.0) > 0.0).all()
    assert np.abs(found.event_time.values - exact.event_time.values).max() < error
