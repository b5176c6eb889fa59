"""Sweeps of rotor systems over friction, damping, stiffness, clearance and unbalance."""

from dataclasses import replace

import numpy as np
import pytest

from rotor_ida import (
    Contact,
    InputError,
    Rotor,
    RotorSystem,
    Stator,
    Support,
    Unbalance,
    decode_flags,
    plot,
    sweep,
)
from rotor_ida.plot.figures import figure_of
from rotor_ida.verification.verify import differences, rerun

BOTH, CHAIN = np.eye(2), np.array([[2.0, -1.0], [-1.0, 2.0]])
STATOR = Stator(mass=0.5, stiffness=8.0, damping=0.4)
TOUCH = {"stiffness": 3.0, "exponent": 1.0, "radius": 1.0}
RUB = RotorSystem(
    mass=np.eye(4), stiffness=np.kron(CHAIN, BOTH), damping=0.1 * np.kron(CHAIN, BOTH),
    nodes={"one": (0, 1), "two": (2, 3)}, units="1",
    contacts=[Contact(node="one", clearance=3.0, friction=0.05, **TOUCH),
              Contact(node="two", clearance=0.75, friction=0.1, stator=STATOR, **TOUCH)],
    unbalance=[Unbalance(node="one", moment=0.4), Unbalance(node="two", moment=0.1, phase=1.0)],
)  # fmt: skip
SPEED = 1.1


def by_hand(name, value):
    """Return the system with another value of a parameter, and what its study is of."""
    one, two = RUB.contacts
    heavy, light = RUB.unbalance
    changed = {
        "damping": lambda: {"damping": value * RUB.damping},
        "stiffness": lambda: {"stiffness": value * RUB.stiffness},
        "clearance": lambda: {"contacts": [
            replace(one, clearance=value), replace(two, clearance=value / 4.0)]},
        "friction": lambda: {"contacts": [
            replace(one, friction=value / 2.0), replace(two, friction=value)]},
        "unbalance": lambda: {"unbalance": [
            replace(heavy, moment=value), replace(light, moment=value / 4.0)]},
    }  # fmt: skip
    return replace(RUB, **changed[name]())


# Values whose ratios are exact.
VALUES = {
    "damping": [0.5, 2.0], "stiffness": [0.5, 2.0], "clearance": [2.0, 4.0],
    "friction": [0.0, 0.25], "unbalance": [0.25, 0.5],
}  # fmt: skip


@pytest.mark.parametrize("name", VALUES)
def test_each_point_is_that_of_a_system_changed_by_hand(name):
    found = sweep(RUB, speed=SPEED, **{name: VALUES[name]})
    assert found.response.dims == ("speed", name, "start", "direction")
    for value in VALUES[name]:
        point = found.sel({name: value})
        alone = sweep(by_hand(name, value), speed=SPEED)
        for each in alone.data_vars:
            np.testing.assert_array_equal(point[each], alone[each])
        gaps = "contact_clearance" if name == "clearance" else "clearance"
        np.testing.assert_array_equal(point[gaps], alone.clearance)
    assert len(set(found.node_amplitude.isel(node=0).values.ravel().tolist())) == 2


def test_one_disc_as_a_system_has_the_labels_of_one_disc_over_friction_and_clearance():
    rotor = Rotor(omega=2.0, zeta=0.07, delta0=2.0, disc_radius=10.0)
    over = [0.0, 0.1]
    one = sweep(rotor, friction=over, delta0=[1.0, 2.0]).squeeze(["omega", "zeta"])
    system = sweep(rotor.system(), speed=2.0, friction=over, clearance=[1.0, 2.0]).isel(speed=0)
    words = decode_flags(one.response).transpose("friction", "delta0", ...).values
    assert {"bouncing", "full_contact"} & set(words.ravel().tolist())
    assert decode_flags(system.response).transpose("friction", "clearance", ...).values.tolist() \
        == words.tolist()  # fmt: skip


@pytest.fixture(scope="module")
def grid():
    return sweep(
        RUB, speed=[1.0, 1.1], friction=[0.0, 0.1], clearance=2.0, direction="up",
        along="friction", modes=2,
    )  # fmt: skip


def test_it_is_computed_again_and_drawn(grid):
    check = differences(rerun(grid, workers=1), grid)
    assert check["agrees"], check["trouble"]
    figure = figure_of(grid)
    assert len(figure.axes) == 2 * grid.sizes["contact"]
    assert figure.axes[0].get_xlabel() == "largest friction"
    assert figure.axes[0].get_title() == "contact 0 at one,  speed 1"
    assert figure.get_suptitle() == "largest clearance 2"


def test_the_clearance_of_each_contact_is_drawn_over_that_which_varies():
    found = sweep(RUB, speed=SPEED, clearance=[2.0, 4.0])
    ax = plot.plot_amplitude(None, simulated=found, contact=1)
    (line,) = [each for each in ax.lines if each.get_label() == "clearance"]
    assert line.get_xydata().tolist() == [[2.0, 0.5], [4.0, 1.0]]
    several = sweep(RUB, speed=SPEED, clearance=[2.0, 4.0], friction=[0.0, 0.1])
    with pytest.raises(InputError, match="simulated must contain one friction, got 2"):
        plot.plot_amplitude(None, simulated=several)


def test_a_factor_of_the_stiffness_is_of_the_supports_too():
    supports = [Support(node="one", stiffness=2.0, damping=0.5)]
    held = replace(RUB, supports=supports)
    twice = replace(by_hand("stiffness", 2.0), supports=[replace(supports[0], stiffness=4.0)])
    start = {"speed": SPEED, "starts": ["rest"]}
    one, other = sweep(held, stiffness=2.0, **start), sweep(twice, **start)
    np.testing.assert_array_equal(one.final_state, other.final_state)


BARE = replace(RUB, contacts=(), unbalance=(), damping=None)


@pytest.mark.parametrize(
    ("system", "changes", "message"),
    [
        (RUB, {"friction": [0.1, 0.2, 0.1]}, "friction must have each value once, got 0.1 twice"),
        (RUB, {"speed": [1.0, 1.0]}, "speed must have each value once, got 1.0 twice"),
        (RUB, {"unbalance": 1e20}, "unbalance must be at most 400000, got 1e\\+20"),
        (RUB, {"damping": -1.0}, "damping must be zero or positive, got -1.0"),
        (RUB, {"unbalance": "much"}, "unbalance must be a finite real number, got 'much'"),
        (RUB, {"clearance": [-1.0, 1.0]}, "clearance must be zero or positive, got -1.0"),
        (RUB, {"friction": [0.2, 0.1], "speed": 1.0, "direction": "up"}, "friction must increase"),
        (RUB, {"friction": [0.1, 0.2], "damping": [1.0, 2.0], "direction": "up"},
         "along must be given with a direction, as damping and friction vary"),
        (RUB, {"friction": [0.1, 0.2], "direction": "up", "along": "clearance"},
         "along must be one of 'speed', 'friction', got 'clearance'"),
        (RUB, {"along": "speed"}, "along must be left out without a direction, got 'speed'"),
        (BARE, {"friction": 0.1}, "friction must be left out, as the system has no contacts"),
        (BARE, {"unbalance": 0.1}, "unbalance must be left out, as the system has no unbalance"),
        (BARE, {"damping": 2.0}, "damping must be left out, as the system has no damping matrix"),
    ],
)  # fmt: skip
def test_bad_axes_are_refused_in_one_line(system, changes, message):
    with pytest.raises(InputError, match=message) as caught:
        sweep(system, **{"speed": SPEED, **changes})
    assert "\n" not in str(caught.value)


def test_an_unknown_axis_is_refused_with_the_name_that_was_meant():
    with pytest.raises(TypeError, match=r"argument 'frictionn'; did you mean 'friction'\?"):
        sweep(RUB, speed=SPEED, frictionn=[0.0, 0.1])
