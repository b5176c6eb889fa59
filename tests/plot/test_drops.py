"""Figures and films of drops show what is in the dataset."""

import math

import numpy as np
import pytest
from matplotlib.animation import FFMpegWriter
from PIL import Image

from rotor_ida import Contact, InputError, Race, RotorSystem, drop, drop_ensemble
from rotor_ida.plot import plot_drops, plot_run, plot_run_up, save_orbit_film
from rotor_ida.plot.run_up import _bins

DISC = RotorSystem(mass=20.0 * np.eye(2), stiffness=np.zeros((2, 2)), nodes={"disc": (0, 1)})
GIVEN = {
    "contacts": [Contact(node="disc", clearance=2e-4, stiffness=2e9, damping=1.0, friction=0.1,
                         radius=0.03, race=Race(radius=0.03, inertia=2e-4))],
    "speed": 500.0, "duration": 0.05, "inertia": 0.08,
}  # fmt: skip


@pytest.fixture(scope="module")
def run():
    return drop(DISC, **GIVEN)


def test_a_figure_of_a_drop_has_speeds_radius_force_and_orbits_over_time(run):
    speeds, radius, force, *orbits = plot_run_up(run).axes
    assert force.get_xlabel() == "time $T$ [s]"
    assert orbits
    drawn = radius.lines[0].get_ydata().max() / (1e6 * run.clearance.item())
    np.testing.assert_allclose(drawn, run.excursion[0], rtol=1e-3)
    np.testing.assert_allclose(force.lines[0].get_ydata().max(), 1e-3 * run.largest_force[0])  # kN
    rotor, race = speeds.lines[:2]
    rpm = 60.0 / math.tau
    np.testing.assert_allclose(rotor.get_ydata(), rpm * run.speed)
    fastest = race.get_ydata().argmax()
    np.testing.assert_allclose(race.get_ydata()[fastest], rpm * run.largest_race_speed[0])
    np.testing.assert_allclose(race.get_xdata()[fastest], run.race_speed_time[0])
    assert "[rpm]" in speeds.get_ylabel()


def test_a_contact_has_the_colour_of_its_race_in_all_panels():
    """The races are by number, the bands by largest force, which is in the second contact."""
    wide, near = (
        Contact(node=node, clearance=clearance, stiffness=2e9, damping=1.0, friction=0.1,
                radius=0.03, race=Race(radius=0.03, inertia=2e-4))
        for node, clearance in (("left", 2.2e-4), ("right", 2e-4))
    )  # fmt: skip
    system = RotorSystem(
        mass=np.diag([4.0, 4.0, 20.0, 20.0]), stiffness=np.zeros((4, 4)),
        nodes={"left": (0, 1), "right": (2, 3)}, contacts=[wide, near],
    )  # fmt: skip
    run = drop(system, speed=500.0, duration=0.05, inertia=0.08)
    assert run.largest_force[1] > run.largest_force[0]
    speeds, radius, force = plot_run_up(run).axes[:3]
    for node in ("left", "right"):
        (race,) = (each for each in speeds.lines if node in each.get_label())
        (gap, load) = (
            each for ax in (radius, force) for each in ax.lines if node in str(each.get_label())
        )
        assert race.get_color() == gap.get_color() == load.get_color()


def test_columns_hold_the_fewest_whole_revolutions():
    """Of a motion that repeats after two, with 32 samples in each, the band has no beats."""
    turns = np.linspace(0.0, 1000.0, 32_001)
    values = np.sin(2.0 * np.pi * turns) + 0.5 * np.sin(np.pi * turns)
    starts = _bins(turns, turns)
    assert set(np.diff(starts).tolist()) == {64}  # two revolutions: a dot is 1.4 of them
    highest = np.maximum.reduceat(values, starts)
    np.testing.assert_allclose(highest, highest[0], rtol=1e-9)


def test_distributions_rise_to_1():
    many = drop_ensemble(DISC, **GIVEN, drops=5, workers=1)
    for ax in plot_drops(many).axes:
        assert ax.lines[0].get_ydata()[-1] == 1.0
    with pytest.raises(InputError, match="it lacks largest_force"):
        plot_drops(many.drop_vars("largest_force"))


def test_a_grid_is_drawn_as_ranges_means_and_shares():
    frictions = [0.05, 0.1, 0.3]
    given = {"friction": frictions, "phase": np.arange(4) * np.pi / 2, "workers": 1}
    many = drop_ensemble(DISC, **GIVEN, **given)
    force, _, _, share = plot_drops(many).axes
    values = 1e-3 * many.largest_force.values.reshape(4, 3)  # kN
    np.testing.assert_allclose(force.lines[0].get_ydata(), values.mean(axis=0))
    drawn = force.collections[0].get_paths()[0].vertices[:, 1]
    np.testing.assert_allclose([drawn.min(), drawn.max()], [values.min(), values.max()])
    cells = many.cell_backward_whirl_fraction[:, 0]
    np.testing.assert_allclose(share.lines[0].get_ydata(), cells)
    alone = plot_drops(drop_ensemble(DISC, **GIVEN, friction=[0.1], phase=[0.0, 1.0], workers=1))
    assert alone.axes[0].get_xlabel() == "angle of the rotor [rad]"
    one = plot_drops(drop_ensemble(DISC, **GIVEN, friction=[0.1], workers=1))
    assert one.axes[0].lines[0].get_ydata().size == 1
    both = drop_ensemble(DISC, **GIVEN, **given, unbalance_factor=[1.0, 2.0])
    figure = plot_drops(both)
    shares = figure.axes[3].collections[0].get_array()
    np.testing.assert_allclose(shares.T.ravel(), both.cell_backward_whirl_fraction[:, 0])


def test_orbits_are_drawn_with_other_close_clearances(run):
    beside = drop(DISC, **GIVEN, clearances={"disc": 4e-4})
    for each, is_drawn in ((run, False), (beside, True)):
        labels = plot_run(each).axes[-1].get_legend_handles_labels()[1]
        assert ("close clearance" in labels) == is_drawn


def test_a_film_has_its_frames(run, tmp_path):
    path = save_orbit_film(run, tmp_path / "drop.gif", frames=4)
    with Image.open(path) as film:
        assert film.n_frames == 4
    with pytest.raises(InputError, match="already exists; pass overwrite=True to replace it"):
        save_orbit_film(run, path)
    with pytest.raises(InputError, match="film must end in"):
        save_orbit_film(run, tmp_path / "drop.png")


@pytest.mark.skipif(not FFMpegWriter.isAvailable(), reason="MP4 needs ffmpeg")
def test_a_film_is_an_mp4_where_ffmpeg_is_installed(run, tmp_path):
    path = save_orbit_film(run, tmp_path / "drop.mp4", frames=4)
    assert path.read_bytes()[4:8] == b"ftyp"


@pytest.mark.skipif(FFMpegWriter.isAvailable(), reason="ffmpeg is installed")
def test_without_ffmpeg_an_mp4_is_refused_in_one_line(run, tmp_path):
    with pytest.raises(InputError, match=r"film must end in \.gif, as ffmpeg is not installed"):
        save_orbit_film(run, tmp_path / "drop.mp4")
