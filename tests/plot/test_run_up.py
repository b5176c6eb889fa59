"""What the figure of a run-up shows: speed and time, bands, and orbits of a few revolutions."""

from dataclasses import replace

import numpy as np
import pytest

from rotor_ida import (
    Contact,
    DimensionalRotor,
    InputError,
    Rotor,
    RotorSystem,
    Unbalance,
    run_up,
    simulate,
)
from rotor_ida.plot import plot_run_up
from rotor_ida.plot.figures import figure_of
from rotor_ida.units import SPEED_UNITS

REST = (0.0, 0.0, 0.0, 0.0)
ROTOR = Rotor(omega=0.3, zeta=0.1, delta0=1.5, shaft_stiffness=1.0)
MACHINE = DimensionalRotor(mass=4.0, contact_stiffness=3.2e7, damping=89.1, eccentricity=1e-5,
                           clearance=2.5e-5, speed=31.416, shaft_stiffness=5e4)  # fmt: skip


@pytest.fixture(scope="module")
def up():
    return run_up(ROTOR, start=REST, to=2.0, rate=0.01)


def band_of(ax):
    """Return the points of the edge of the band on some axes."""
    (band,) = (each for each in ax.collections if each.get_alpha())
    return band.get_paths()[0].vertices


def turns_of(ax):
    """Return the angles that a line without marks turns through about the origin, in turns."""
    return sum(
        abs(np.nansum(np.diff(np.unwrap(np.arctan2(*line.get_data()[::-1])))))
        for line in ax.lines
        if line.get_label() in ("flight", "contact")
    ) / (2.0 * np.pi)


def test_radius_and_force_are_over_the_speed_within_their_extremes(up):
    figure = plot_run_up(up)
    radius, force, *orbits = figure.axes
    assert force.get_xlabel() == r"spin speed $\omega$"
    np.testing.assert_allclose(force.get_xlim(), (0.3, 2.0))
    figure.draw_without_rendering()
    (above,) = radius.child_axes
    assert above.get_xlabel() == "time $t$"
    np.testing.assert_allclose(above.get_xlim(), (0.0, 170.0))
    assert above.get_xticks().max() <= 170.0
    # between samples the cubic through them may reach a little farther
    assert band_of(radius)[:, 1].max() == pytest.approx(float(np.hypot(up.x, up.y).max()), rel=1e-3)
    assert band_of(force)[:, 1].max() == pytest.approx(float(up.peak_force.max()), rel=1e-9)
    titles = [ax.get_title().split("\n")[0] for ax in orbits]
    assert titles == ["first touch", "largest force", "end"]
    first = float(np.interp(up.entry_time[0], up.t, up.speed))
    assert f"{first:.4g}" in orbits[0].get_title()


def test_an_orbit_has_three_revolutions_and_the_clearance(up):
    for ax in plot_run_up(up).axes[2:]:
        (ring,) = (line for line in ax.lines if line.get_label() == "clearance")
        np.testing.assert_allclose(np.hypot(*ring.get_data()), 1.5)
    assert turns_of(plot_run_up(up).axes[3]) == pytest.approx(3.0, abs=0.15)


def test_a_run_down_has_its_first_time_at_the_right():
    down = run_up(replace(ROTOR, omega=2.0), start=REST, to=0.3, rate=-0.01)
    figure = plot_run_up(down)
    figure.draw_without_rendering()
    radius = figure.axes[0]
    np.testing.assert_allclose(radius.get_xlim(), (0.3, 2.0))
    early, late = radius.child_axes[0].transData.transform([(0.0, 0.0), (170.0, 0.0)])[:, 0]
    assert late < early


def test_where_the_speed_rests_or_reverses_the_time_is_the_axis():
    there = run_up(ROTOR, start=REST, speeds=[(0, 0.3), (60, 0.9), (90, 0.9), (120, 0.6)])
    speed, radius, force, *_ = plot_run_up(there).axes
    assert speed.get_ylabel() == r"spin speed $\omega$"
    np.testing.assert_allclose(speed.lines[0].get_ydata(), there.speed)
    assert force.get_xlabel() == "time $t$"
    assert not radius.child_axes


def test_a_short_run_up_is_a_line_and_its_orbit_says_which_times_it_shows():
    short = run_up(ROTOR, start=REST, to=2.0, rate=0.2)
    radius, _, *orbits = plot_run_up(short).axes
    assert not [each for each in radius.collections if each.get_alpha()]
    (ax,) = orbits
    words, span = ax.get_title().split("\n")
    assert words == "first touch, largest force, end"
    assert span.endswith(f"{float(short.entry_time[0]):.4g} to 8.5")


def test_a_run_up_without_contact_shows_the_largest_radius():
    free = run_up(Rotor(omega=0.3, zeta=0.3, delta0=5.0, shaft_stiffness=1.0), start=REST, to=2.0,
                  rate=0.02)  # fmt: skip
    _, force, *orbits = plot_run_up(free).axes
    assert [text.get_text() for text in force.texts] == ["no contact"]
    assert [ax.get_title().split("\n")[0] for ax in orbits] == ["largest radius", "end"]


def test_a_machine_is_drawn_over_revolutions_per_minute():
    rpm = SPEED_UNITS["rpm"]
    up = run_up(MACHINE, to=2500.0 * rpm, rate=2000.0 * rpm)
    force, first = figure_of(up).axes[1:3]
    assert force.get_xlabel() == "spin speed [rpm]"
    np.testing.assert_allclose(force.get_xlim(), (300.0, 2500.0), rtol=1e-4)
    assert " rpm,  $T$ " in first.get_title()


def test_of_a_system_the_contacts_that_are_touched_are_drawn_by_name():
    system = RotorSystem(mass=np.eye(6), stiffness=np.eye(6), damping=0.2 * np.eye(6),
                         nodes={"near": (0, 1), "far": (2, 3), "free": (4, 5)})  # fmt: skip
    contacts = [Contact(node=node, clearance=gap, stiffness=5.0)
                for node, gap in (("near", 1.0), ("far", 2.0), ("free", 90.0))]  # fmt: skip
    unbalance = [Unbalance(node=node, moment=1.0) for node in ("near", "far")]
    up = run_up(system, contacts=contacts, unbalance=unbalance, speed=0.3, to=2.0, rate=0.01)
    radius, force, *orbits = figure_of(up).axes
    assert radius.get_ylabel() == "radius over clearance"
    drawn = {each.get_label() for each in force.collections if each.get_alpha()}
    assert drawn == {"contact 0 at near", "contact 1 at far"}
    first = up.episode_contact.values[up.entry_time.values.argmin()]
    assert orbits[0].get_title().split("\n")[:2] == [
        "first touch",
        f"contact {first} at {up.contact_node.values[first]}",
    ]


def test_a_long_run_at_one_speed_is_drawn_in_bands_and_a_short_one_as_it_is():
    bouncing = Rotor(omega=2.0, zeta=0.07, delta0=2.0)
    long = figure_of(simulate(bouncing, start=REST, duration=200.0))
    assert long.axes[0].get_ylabel() == "radius $|z|$"
    assert figure_of(simulate(bouncing, start=REST, duration=20.0)).axes[0].get_ylabel() == (
        "displacement $z$"
    )
    with pytest.raises(InputError, match="run must be a Dataset, got int"):
        plot_run_up(3)
