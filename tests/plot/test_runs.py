import re
from dataclasses import replace

import numpy as np
import pytest
import xarray as xr

from rotor_ida import (
    Contact,
    DimensionalRotor,
    InputError,
    Rotor,
    RotorSystem,
    Unbalance,
    contact_forces,
    dimensional,
    run_up,
    simulate,
)
from rotor_ida.plot import (
    panels,
    plot_forces,
    plot_orbit,
    plot_run,
    plot_run_up,
    plot_trace,
)
from rotor_ida.plot.figures import figure_of
from rotor_ida.plot.motion import shade_contacts
from rotor_ida.results.si_units import dimensionless
from rotor_ida.signals.path import path_of
from rotor_ida.units import SPEED_UNITS
from tests.plot.pictures import line_of, lines_of

MACHINE = DimensionalRotor(mass=4.0, contact_stiffness=1e9, damping=280.0, eccentricity=1e-6,
                           clearance=2e-6, speed=1000.0)  # fmt: skip
REST = (0.0, 0.0, 0.0, 0.0)
RISING = Rotor(omega=0.3, zeta=0.1, delta0=1.5, shaft_stiffness=1.0)
IN_BEARING = DimensionalRotor(mass=4.0, contact_stiffness=3.2e7, damping=89.1, eccentricity=1e-5,
                           clearance=2.5e-5, speed=31.416, shaft_stiffness=5e4)  # fmt: skip
BOUNCING = Rotor(omega=2.0, zeta=0.07, delta0=2.0)


@pytest.fixture(scope="module")
def machine():
    run = simulate(MACHINE.rotor(), start=(0, 0, 0, 0), duration=40.0, samples=2001)
    return dimensional(run, MACHINE, units={"length": "µm", "time": "ms"})


def labels(ax):
    return ax.get_legend_handles_labels()[1]


def test_peak_forces_are_those_of_the_run(run):
    curve, peaks = plot_run(run).axes[2].lines
    np.testing.assert_array_equal(peaks.get_ydata(), run["peak_force"].values)
    assert np.isin(peaks.get_xydata(), curve.get_xydata()).all()


def test_orbit_shows_flight_and_contact_apart(run):
    ax = plot_orbit(run)
    assert labels(ax) == ["clearance", "flight", "contact", "entry", "exit", "start"]
    lines = lines_of(ax)
    flight = np.hypot(*lines["flight"].get_data())
    contact = np.hypot(*lines["contact"].get_data())
    # the cubic between two events strays by less than its fourth-order error
    assert np.nanmax(flight) < 0.5 + 1e-4
    assert np.nanmin(contact) > 0.5 - 1e-4
    assert ax.get_aspect() == 1.0


def test_points_between_outputs_lie_on_the_motion(run):
    """A cubic with the right velocities errs by less than (step)**4/384 times the snap."""
    fine = simulate(
        Rotor(omega=1.7, zeta=0.07, delta0=0.5),
        start=(0.0, 0.0, 0.0, 0.0), duration=20.0, samples=2001,
    )  # fmt: skip
    path = path_of(run)
    error = np.interp(fine["t"].values, path.time, path.x) - fine["x"].values
    assert np.abs(error).max() < 2e-3


@pytest.mark.parametrize("draw", [plot_run, plot_orbit, plot_trace])
def test_a_run_of_too_few_samples_is_refused_with_the_number_that_would_do(run, draw):
    sparse = run.isel(t=slice(None, None, 13), event=slice(0, 0))
    with pytest.raises(InputError, match="more than 4 samples in each revolution, got 2") as no:
        draw(sparse)
    rotor, start = Rotor(omega=1.7, zeta=0.07, delta0=0.5), (0.0, 0.0, 0.0, 0.0)
    enough = int(re.search(r"(\d+) samples in all are enough", str(no.value))[1])
    draw(simulate(rotor, start=start, duration=20.0, samples=enough))


def test_run_without_contact_says_so():
    rotor = Rotor(omega=1.0, zeta=0.5, delta0=5.0)
    free = simulate(rotor, start=(0.0, 0.0, 0.0, 0.0), duration=5.0, samples=51)
    figure = plot_run(free)
    assert [text.get_text() for text in figure.axes[2].texts] == ["no contact"]
    assert not figure.axes[2].lines
    assert "contact" not in labels(figure.axes[3])


def test_run_without_clearance_is_one_contact():
    rotor = Rotor(omega=1.0, zeta=0.5, delta0=0.0)
    run = simulate(rotor, start=(1.0, 0.0, 0.0, 0.0), duration=5.0, samples=51)
    assert labels(plot_orbit(run)) == ["contact", "start"]


def test_marks_that_would_hide_the_motion_are_left_out(run):
    many = run.isel(event=np.repeat([0, 1], 100))
    assert "entry" not in labels(plot_orbit(many))


def test_displacements_are_those_of_the_run(run):
    ax = plot_run(run).axes[0]
    assert ax.get_xlim() == (0.0, 20.0)
    for line, name in zip(ax.lines, "xy", strict=True):
        assert np.isin(run[name].values, line.get_ydata()).all()
    with pytest.raises(InputError, match="node must be left out for a run of one disc, got 'disc'"):
        plot_run(run, node="disc")


def test_force_is_k_times_the_indentation_to_the_three_halves(machine):
    line, peaks = plot_run(machine).axes[2].lines
    radius = np.hypot(machine.x.values, machine.y.values)
    depth = np.maximum(1e-6 * radius - MACHINE.clearance, 0.0)
    at = np.searchsorted(line.get_xdata(), machine.t.values)
    newtons = MACHINE.contact_stiffness * depth**1.5
    np.testing.assert_allclose(line.get_ydata()[at], newtons, rtol=1e-7, atol=1e-9)
    # peaks are found between the samples and so never lie below them
    assert peaks.get_ydata().max() >= newtons.max() * (1.0 - 1e-12)
    assert peaks.get_ydata().max() == pytest.approx(newtons.max(), rel=1e-3)


def test_short_contact_parts_the_flight(run):
    """A contact without a point between its ends is not drawn over in the colour of flight."""
    path = path_of(run)
    in_contact = np.zeros(path.time.shape, dtype=bool)
    in_contact[3] = True
    x, time = path.stretches(~in_contact, path.x, path.time)
    np.testing.assert_array_equal(time[:6], [*path.time[:4], np.nan, path.time[4]])
    np.testing.assert_array_equal(np.isnan(x), np.isnan(time))


def test_the_rotor_is_in_contact_until_it_leaves_the_ring():
    """A force that ends inside the ring, and begins again there, does not end the contact."""
    rotor = Rotor(omega=1.7, zeta=0.07, delta0=0.5, contact_damping=0.5)
    run = simulate(rotor, start=(0, 0, 0, 0), duration=10.0)
    kinds, times = np.array([1, -4, 4, -1], dtype=np.int8), np.array([1.0, 2.0, 3.0, 4.0])
    inside = {f"event_{name}": ("event", np.zeros(4)) for name in ("x", "y", "vx", "vy")}
    run = run.drop_dims("event").assign(
        event_time=("event", times),
        event_kind=("event", kinds, dict(run["event_kind"].attrs)),
        **inside,
    )
    path = path_of(run)
    assert (path.in_contact == ((path.time >= 1.0) & (path.time < 4.0))).all()
    assert "exit" in labels(plot_orbit(run))


CHATTER = Rotor(omega=1.2, zeta=0.07, delta0=0.5, friction=0.3, disc_radius=0.6)
RUBBED = ("slips forwards", "slips backwards", "rolls")


@pytest.fixture(scope="module")
def rubbing():
    return simulate(CHATTER, start=(0.3, 0.1, 0.2, 0.1), duration=30.0, samples=901)


@pytest.mark.parametrize("samples", [901, 31])
def test_each_way_of_moving_has_its_line_from_event_to_event(rubbing, samples):
    """Also where no sample tells of it: then the events on both sides do."""
    run = simulate(CHATTER, start=(0.3, 0.1, 0.2, 0.1), duration=30.0, samples=samples)
    path = path_of(run)
    events = rubbing["event_time"].values
    middles = 0.5 * (events[1:] + events[:-1])
    told = np.searchsorted(rubbing["t"].values, middles)
    known = rubbing["mode"].values[told]
    # a sample that lies behind the next event tells of another way
    sure = rubbing["t"].values[told] < events[1:]
    here = path.mode[np.searchsorted(path.time, events[:-1] + 1e-9) - 1]
    assert sure.sum() > 0.8 * sure.size
    np.testing.assert_array_equal(here[sure], known[sure])
    assert {-1, 0, 1, 2} == set(path.mode.tolist())


def test_orbit_and_radius_show_slip_and_rolling_apart(rubbing):
    _, radius, force, slip, orbit = plot_run(rubbing).axes
    for ax in (radius, orbit):
        lines = lines_of(ax)
        assert {"flight", *RUBBED} <= lines.keys()
        looks = {(lines[name].get_color(), str(lines[name].get_linestyle())) for name in RUBBED}
        assert len(looks) == 3
        assert len(lines["rolls"].get_path_effects()) == 2  # a double line, told without colour too
    assert "contact" not in labels(orbit)
    assert (force.get_ylabel(), slip.get_ylabel()) == ("normal force $N$", "slip speed $v_s$")
    rolling = next(line for line in orbit.lines if line.get_label() == "rolls")
    drawn = np.hypot(*rolling.get_data())
    assert np.nanmin(drawn) > CHATTER.delta0
    line = force.lines[0]
    at = np.searchsorted(line.get_xdata(), rubbing["t"].values)
    np.testing.assert_allclose(line.get_ydata()[at], rubbing["normal_force"], atol=1e-9)


def test_events_of_friction_are_marked_where_they_happen(rubbing):
    radius = plot_run(rubbing).axes[1]
    kinds = rubbing["event_kind"].values
    for name, kind in {"roll": 2, "slip": -2, "reverse": 3}.items():
        (line,) = (each for each in radius.lines if each.get_label() == name)
        met = kinds == kind
        np.testing.assert_array_equal(line.get_xdata(), rubbing["event_time"].values[met])
        height = np.hypot(rubbing["event_x"], rubbing["event_y"]).values[met]
        np.testing.assert_allclose(line.get_ydata(), height, rtol=1e-14)


def test_a_run_that_never_leaves_the_ring_has_a_normal_force_and_no_note():
    rotor = Rotor(omega=0.62962981, zeta=0.1, delta0=1.0, friction=0.2, disc_radius=10.0)
    figure = plot_run(simulate(rotor, start=(5.0, 0.0, 0.0, -6.3), duration=10.0, samples=301))
    force = figure.axes[2]
    assert not force.texts
    assert force.get_ylim()[1] > 8.0
    assert r"$\mu = 0.2$" in figure.get_suptitle()


def test_many_parameters_stand_in_two_lines():
    rotor = Rotor(
        omega=1.1, zeta=0.05, delta0=0.5, shaft_stiffness=0.3, contact_exponent=1.0,
        contact_damping=0.4, load=0.2, friction=0.6, disc_radius=0.3,
    )  # fmt: skip
    run = simulate(rotor, start=(2.0, 0.0, 0.0, -4.0), duration=20.0, samples=601)
    title = plot_run(run).get_suptitle()
    assert len(title.splitlines()) == 2
    assert title.count("$") == 2 * 9
    shown = labels(plot_run(run).axes[1])
    assert {"press", "release", "roll", "slip"} <= set(shown)


@pytest.mark.parametrize("unit", ["rad/s", "rpm"])
def test_a_run_up_in_si_units_is_drawn_alike_whatever_its_unit_of_speed(unit):
    """The title tells first and last speed in rpm; the line between the samples stays the same."""
    rpm = SPEED_UNITS["rpm"]
    in_si = run_up(MACHINE, to=12_000.0 * rpm, rate=60_000.0 * rpm, samples=401, rtol=1e-6)
    plain, shown = dimensionless(in_si), dimensional(in_si, units={"speed": unit})
    title = plot_run(shown).get_suptitle()
    assert title == "9,549 to 12,000 rpm,  damping $280$ N s/m,  clearance $2$ µm"
    drawn, without = path_of(shown), path_of(plain)
    assert drawn.time == pytest.approx(without.time * MACHINE.time_scale, rel=1e-12)
    assert drawn.radius == pytest.approx(without.radius * MACHINE.length_scale, rel=1e-9)


@pytest.fixture(scope="module")
def up():
    return run_up(RISING, start=REST, to=2.0, rate=0.01)


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
        ring = line_of(ax, "clearance")
        np.testing.assert_allclose(np.hypot(*ring.get_data()), 1.5)
    assert turns_of(plot_run_up(up).axes[3]) == pytest.approx(3.0, abs=0.15)


def test_a_run_down_has_its_first_time_at_the_right():
    down = run_up(replace(RISING, omega=2.0), start=REST, to=0.3, rate=-0.1)
    figure = plot_run_up(down)
    figure.draw_without_rendering()
    radius = figure.axes[0]
    np.testing.assert_allclose(radius.get_xlim(), (0.3, 2.0))
    early, late = radius.child_axes[0].transData.transform([(0.0, 0.0), (17.0, 0.0)])[:, 0]
    assert late < early


def test_where_the_speed_rests_or_reverses_the_time_is_the_axis():
    there = run_up(RISING, start=REST, speeds=[(0, 0.3), (60, 0.9), (90, 0.9), (120, 0.6)])
    speed, radius, force, *_ = plot_run_up(there).axes
    assert speed.get_ylabel() == r"spin speed $\omega$"
    np.testing.assert_allclose(speed.lines[0].get_ydata(), there.speed)
    assert force.get_xlabel() == "time $t$"
    assert not radius.child_axes


def test_a_short_run_up_is_a_line_and_its_orbit_says_which_times_it_shows():
    short = run_up(RISING, start=REST, to=2.0, rate=0.2)
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
    assert not force.lines
    assert [ax.get_title().split("\n")[0] for ax in orbits] == ["largest radius", "end"]


def test_of_a_system_the_contacts_that_are_touched_are_drawn_by_name():
    system = RotorSystem(mass=np.eye(6), stiffness=np.eye(6), damping=0.2 * np.eye(6),
                         nodes={"near": (0, 1), "far": (2, 3), "free": (4, 5)})  # fmt: skip
    contacts = [Contact(node=node, clearance=gap, stiffness=5.0)
                for node, gap in (("near", 1.0), ("far", 2.0), ("free", 90.0))]  # fmt: skip
    unbalance = [Unbalance(node=node, moment=1.0) for node in ("near", "far")]
    up = run_up(system, contacts=contacts, unbalance=unbalance, speed=0.3, to=2.0, rate=0.01)
    radius, force, *orbits = figure_of(up).axes
    assert radius.get_ylabel() == "radius over clearance"
    colours, in_radius = (
        {each.get_label(): tuple(each.get_facecolor()[0]) for each in ax.collections
         if each.get_alpha()}
        for ax in (force, radius)
    )  # fmt: skip
    assert set(colours) == {"contact 0 at near", "contact 1 at far"}
    assert colours == in_radius  # one legend serves both
    assert len(set(colours.values())) == 2
    first = up.episode_contact.values[up.entry_time.values.argmin()]
    assert orbits[0].get_title().split("\n")[:2] == [
        "first touch",
        f"contact {first} at {up.contact_node.values[first]}",
    ]


def test_forces_of_a_rub_are_seen_beside_those_of_dry_whip():
    """On a linear scale up to the force of whip those of the rub before it would be a line at 0."""
    run = simulate(Rotor(omega=2.0, zeta=0.07, delta0=2.0), start=REST, duration=200.0)
    assert figure_of(run).axes[1].get_yscale() == "linear"
    short = figure_of(run.sel(t=slice(0.0, 20.0)))  # drawn as it is, not in bands
    assert short.axes[0].get_ylabel() == "displacement $z$"
    late = run["t"] > 190.0
    whip = run.assign({name: run[name].where(~late, 400.0 * run[name]) for name in ("x", "y")})
    force = figure_of(whip).axes[1]
    assert force.get_yscale() == "log"
    low, high = force.get_ylim()
    rub = float(run.peak_force.max())
    assert low < 0.1 * rub  # a tenth of the force of the rub lies in the picture
    assert high > 1e3 * rub


def test_largest_force_at_the_end_of_a_run_is_no_peak():
    """A run that ends inside a contact while the force grows has not seen its peak."""
    run = simulate(BOUNCING, start=REST, duration=6.0, samples=601)
    rising = contact_forces(run.sel(t=slice(0.0, 2.0)))
    assert rising.peak_time.size
    cut = rising.assign(peak_time=("contact", np.full(rising.sizes["contact"], 2.0)))
    assert "peak of a contact" in lines_of(plot_forces(contact_forces(run)))
    assert "peak of a contact" not in lines_of(plot_forces(cut))


@pytest.mark.parametrize(
    ("entries", "exits", "pale", "full"),
    [  # in a run of 30 s, of which about 0.08 s can be seen
        (np.arange(23.0, 30.0, 0.018), np.arange(23.0, 30.0, 0.018) + 0.003, [(23, 30)], []),
        ([5.0, 9.0], [5.001, 12.0], [], [(5, 5.001), (9, 12)]),
        ([5.0, 6.01, 6.03], [6.0, 6.02, 8.0], [(5, 8)], [(5, 6), (6.03, 8)]),
    ],
)  # fmt: skip
def test_contacts_that_cannot_be_told_apart_are_shaded_as_in_and_out(entries, exits, pale, full):
    run = xr.Dataset(
        {"entry_time": ("contact", entries), "exit_time": ("contact", exits)},
        {"t": np.linspace(0.0, 30.0, 9)},
    )
    ax = panels(1, 1)[1][0]
    shade_contacts(ax, run)
    spans = {
        each.get_label(): [path.get_extents().intervalx for path in each.get_paths()]
        for each in ax.collections
    }
    for words, wanted in (("in and out of contact", pale), ("in contact", full)):
        assert len(spans.get(words, [])) == len(wanted)
        for span, (begin, end) in zip(spans.get(words, []), wanted, strict=True):
            np.testing.assert_allclose(span, (begin, end), atol=0.02 if end == 30 else 1e-9)
