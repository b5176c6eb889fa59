"""Figures of many run-ups show the forces and fractions of the dataset."""

import numpy as np
import pytest

from rotor_ida import (
    Contact,
    DimensionalRotor,
    InputError,
    Rotor,
    RotorSystem,
    Unbalance,
    run_ups,
)
from rotor_ida.plot import plot_endings, plot_largest_force, plot_run_ups
from rotor_ida.plot.run_ups import ENDING_WORDS
from rotor_ida.units import SPEED_UNITS, quantity
from tests.plot.pictures import words_of


@pytest.fixture(scope="module")
def found():
    return run_ups(
        omega=0.3, to=1.6, rate=[0.2, 0.01, 0.05], zeta=0.1, delta0=[1.0, 2.0],
        shaft_stiffness=1.0, phase=[0.0, 2.0], starts=[(0.5, 0.0, 0.0, 0.0)], method="taylor",
    )  # fmt: skip


def test_forces_are_the_largest_of_all_phases_by_rising_rate(found):
    ax = plot_largest_force(found)
    force = found.largest_force.max(["phase", "start"]).sortby("rate")
    for (line, *_), clearance in zip(ax.containers, found.delta0.values, strict=True):
        np.testing.assert_array_equal(line.get_xdata(), [0.01, 0.05, 0.2])
        np.testing.assert_array_equal(line.get_ydata(), force.sel(delta0=clearance).squeeze())
    labels = words_of(ax)
    assert labels == [r"$\delta_0 = 1$", r"$\delta_0 = 2$"]


def test_bars_are_the_fractions_and_fill_the_panel(found):
    one = found.sel(delta0=[2.0])
    ax = plot_endings(one)
    by_rate = one.sortby("rate")
    height = np.zeros(3)
    for bars in ax.containers:
        word = next(word for word, said in ENDING_WORDS.items() if said == bars.get_label())
        drawn = [bar.get_height() for bar in bars]
        np.testing.assert_array_equal(drawn, by_rate[f"{word}_fraction"].values.ravel())
        height += drawn
    np.testing.assert_array_equal(height, 1.0)
    assert [text.get_text() for text in ax.get_xticklabels()] == ["0.01", "0.05", "0.2"]


def test_a_run_down_says_so():
    down = run_ups(omega=1.6, to=0.4, rate=[-0.3, -0.2], zeta=0.1, delta0=3.0, method="taylor")
    assert plot_largest_force(down).get_xlabel() == "rate of the run-down $|a|$"
    ticks = [text.get_text() for text in plot_endings(down).get_xticklabels()]
    assert ticks == ["-0.2", "-0.3"]


def test_of_a_rotor_system_there_is_a_curve_for_each_contact_and_a_panel_for_each_speed():
    system = RotorSystem(
        mass=20.0 * np.eye(4), damping=300.0 * np.eye(4), stiffness=2e6 * np.eye(4),
        nodes={"disc": (0, 1), "seal": (2, 3)},
        unbalance=[Unbalance(node=node, moment=1e-3) for node in ("disc", "seal")],
        contacts=[Contact(node="disc", clearance=2e-4, stiffness=1e8, exponent=1.0),
                  Contact(node="seal", clearance=9e-4, stiffness=1e8, exponent=1.0)],
    )  # fmt: skip
    rpm = SPEED_UNITS["rpm"]
    found = run_ups(system, speed=[50 * rpm, 100 * rpm], to=4000 * rpm, rate=[9e3 * rpm, 9e4 * rpm],
                    workers=1)  # fmt: skip
    forces, *endings = plot_run_ups(found).axes
    assert (found.largest_force.isel(contact=0, rate=0) > 0.0).all()
    assert [line.get_ydata().tolist() for line, *_ in forces.containers] == [
        found.largest_force[speed, :, 0, 0, contact].values.tolist()
        for speed in range(2) for contact in range(2)
    ]  # fmt: skip
    assert forces.get_xlabel() == "rate $a$ [rpm/s]"
    assert forces.get_ylabel() == "largest normal force [N]"
    labels = forces.get_legend_handles_labels()[1]
    assert labels[1] == "from 50 rpm, contact 1 at seal"
    assert [ax.get_title() for ax in endings] == ["from 50 rpm", "from 100 rpm"]
    with pytest.raises(InputError, match="must have a contact, got run-ups of a rotor system"):
        plot_largest_force(found.isel(contact=[]))


def test_with_one_rate_forces_and_outcomes_are_over_the_parameter_that_varies():
    rotor = Rotor(omega=0.3, zeta=0.1, delta0=1.0, shaft_stiffness=1.0, friction=0.1,
                  disc_radius=10.0)  # fmt: skip
    frictions = [0.2, 0.0, 0.1]
    found = run_ups(rotor, to=1.6, rate=0.05, friction=frictions)
    forces, endings = plot_run_ups(found).axes
    order = np.argsort(frictions)
    (line, *_) = forces.containers[0]
    np.testing.assert_array_equal(line.get_xdata(), np.sort(frictions))
    np.testing.assert_array_equal(line.get_ydata(), found.largest_force.values.ravel()[order])
    assert (forces.get_xscale(), forces.get_xlabel()) == ("linear", r"friction $\mu$")
    assert endings.get_xlabel() == r"friction $\mu$"
    assert [text.get_text() for text in endings.get_xticklabels()] == ["0", "0.1", "0.2"]
    heights = sum(np.array([bar.get_height() for bar in bars]) for bars in endings.containers)
    np.testing.assert_allclose(heights, 1.0)


def test_forces_are_in_the_unit_in_which_the_table_of_the_command_reads_them():
    machine = DimensionalRotor(mass=400.0, contact_stiffness=1e10, damping=4000.0,
                               eccentricity=5e-5, clearance=1e-4, speed=300.0)  # fmt: skip
    found = run_ups(machine, to=600.0, rate=2000.0)
    ax = plot_largest_force(found)
    largest = float(found.largest_force.max())
    said, unit = quantity(largest, "N").split()
    assert unit == "kN"
    assert ax.get_ylabel().endswith(f"[{unit}]")
    assert f"{ax.containers[0][0].get_ydata().max():.4g}" == said
