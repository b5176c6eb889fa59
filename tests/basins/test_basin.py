"""Basins over a plane: the right labels in the right place, and honest about the rest."""

import numpy as np
import pytest

from rotor_ida import InputError, Rotor, basin
from rotor_ida.basins import attractors, disc
from rotor_ida.basins.disc import Disc
from rotor_ida.basins.following import follow_here
from rotor_ida.core.runs import NO_STOP
from rotor_ida.parallel import FailedJob
from rotor_ida.schema import FATE, RESPONSE, flags_of
from rotor_ida.simulation.options import Options
from rotor_ida.steady import grid
from rotor_ida.steady.follow import settle_disc

FIGURE_7 = Rotor(omega=1.7, zeta=0.07, delta0=0.0)
AXIS = np.linspace(-15.0, 15.0, 24)


@pytest.fixture(scope="module")
def figure_7():
    return basin(FIGURE_7, x=AXIS, y=AXIS)


def test_zero_velocity_starts_form_one_egg_round_the_small_whirl(figure_7):
    """The paper's Fig. 7 shows a spider; starts at rest show one convex piece with the origin."""
    fine = np.linspace(-15.0, 15.0, 64)
    small = basin(FIGURE_7, x=fine, y=fine).label == 0
    assert bool(small.sel(x=0.0, y=0.0, method="nearest"))
    assert not bool(small.sel(x=10.0, y=0.0, method="nearest"))
    for row in (small.values, small.values.T):
        changes = np.abs(np.diff(row.astype(int), axis=1)).sum(axis=1)
        assert (changes <= 2).all()
    assert figure_7.amplitude.values == pytest.approx([1.8796312367, 9.4872069457], abs=1e-8)
    assert figure_7.confirmed.values.tolist() == [1, 1]


@pytest.mark.parametrize(
    ("omega", "delta0", "kinds"),
    [
        (1.7, 0.0, {"synchronous"}),
        (2.0, 2.0, {"contact_free", "bouncing"}),
        (3.0, 0.5, {"synchronous", "full_contact"}),
    ],
)
def test_labels_are_those_of_cvode(omega, delta0, kinds):
    """On random starts; the script benchmarks/basin_labels.py asks about thousands."""
    rotor = Rotor(omega=omega, zeta=0.07, delta0=delta0)
    states = np.zeros((4, 12))
    states[:2] = np.random.default_rng(3).uniform(-15.0, 15.0, (2, 12))
    found = follow_here(Disc.of(rotor, 1e-6, NO_STOP), states, NO_STOP)
    seen = set()
    for number, state in enumerate(states.T.tolist()):
        settled = settle_disc(rotor, tuple(state), Options(rtol=1e-10))
        kind = found.kinds[found.labels[number]]
        seen.add(kind)
        assert settled.kind == kind
        if kind != "contact_free":
            radius = found.rows["radius_max"][found.labels[number]]
            assert settled.features.radius_max == pytest.approx(radius, rel=1e-8)
    assert seen == kinds


def test_a_start_lands_where_its_coordinates_say():
    """A component of each pair varies; the labels are those of the starts one by one."""
    rows, columns = np.array([-3.0, 0.5, 9.0]), np.array([-4.0, 6.0])
    found = basin(FIGURE_7, x=1.0, y=rows, vx=columns, vy=-2.0)
    assert found.label.dims == found.response.dims == found.settling_time.dims == ("vx", "y")
    assert (float(found.x), float(found.vy)) == (1.0, -2.0)
    for y in rows:
        for vx in columns:
            settled = settle_disc(FIGURE_7, (1.0, y, vx, -2.0), Options())
            number = int(found.label.sel(y=y, vx=vx))
            assert settled.features.amplitude == pytest.approx(float(found.amplitude[number]))


def test_numbers_add_up(figure_7):
    assert int(figure_7["count"].sum()) == AXIS.size**2
    np.testing.assert_allclose(figure_7.fraction, figure_7["count"] / AXIS.size**2)
    p = figure_7.fraction.values
    np.testing.assert_allclose(figure_7.fraction_error, np.sqrt(p * (1 - p) / AXIS.size**2))
    assert (figure_7.response == RESPONSE["synchronous"]).all()
    assert (figure_7.settling_time > 0.0).all()
    assert figure_7.label.dtype == np.int16
    assert figure_7.settling_time.dtype == np.float32
    assert set(np.unique(figure_7.label)) <= set(flags_of(figure_7.label).values())


def test_starts_lost_with_their_worker_are_not_computed(monkeypatch, figure_7):
    true_run_all = grid.run_all

    def loses_the_second(*arguments, **options):
        for number, result in true_run_all(*arguments, **options):
            yield number, FailedJob("its worker died") if number == 1 else result

    monkeypatch.setattr(disc, "SMALLEST_BATCH", 64)
    monkeypatch.setattr(grid, "run_all", loses_the_second)
    found = basin(FIGURE_7, x=AXIS, y=AXIS)
    missing = (found.label.transpose("x", "y") == FATE["not_computed"]).values.ravel()
    assert np.flatnonzero(missing).tolist() == list(range(64, 128))
    assert found.attrs["not_computed_reason"] == "its worker died"
    assert found.label.where(found.label != FATE["not_computed"], figure_7.label).equals(
        figure_7.label.astype(float)
    )


def test_xarray_draws_it_with_y_upwards(figure_7):
    mesh = figure_7.label.plot()
    assert mesh.axes.get_xlabel().startswith("horizontal displacement")
    assert mesh.axes.get_ylabel().startswith("vertical displacement")


def test_a_rotor_that_does_not_turn_comes_to_rest():
    for delta0 in (0.0, 0.5):
        found = basin(Rotor(omega=0.0, zeta=0.3, delta0=delta0), x=AXIS[::6], y=AXIS[::6])
        assert (found.response == RESPONSE["contact_free"]).all()
        assert found.amplitude.values.tolist() == [0.0]


def test_an_interrupt_keeps_what_is_done(monkeypatch):
    monkeypatch.setattr(disc, "SMALLEST_BATCH", 64)

    def interrupt(done, _total):
        if done >= 200:
            raise KeyboardInterrupt

    found = basin(FIGURE_7, x=AXIS, y=AXIS, progress=interrupt, workers=1)
    assert found.attrs["interrupted"] == 1
    missing = found.label == FATE["not_computed"]
    assert 0 < int(missing.sum()) == int(found.not_computed_count) <= 376
    assert np.isnan(found.settling_time.where(missing, 0.0)).sum() == missing.sum()
    assert (found.response.values[missing.values] == FATE["not_computed"]).all()
    whole = basin(FIGURE_7, x=AXIS, y=AXIS)
    assert (found.label == whole.label).where(~missing, True).all()
    assert float(found.fraction.sum()) == pytest.approx(1.0)


def test_an_interrupt_of_the_confirmation_keeps_the_labels(monkeypatch, figure_7):
    def interrupt(*_, **__):
        raise KeyboardInterrupt

    monkeypatch.setattr(attractors, "settle_disc", interrupt)
    found = basin(FIGURE_7, x=AXIS, y=AXIS)
    assert found.attrs["interrupted"] == 1
    assert found.label.equals(figure_7.label)
    assert not any(name.startswith("confirmation_") for name in found.attrs)
    assert found.confirmed.values.tolist() == [0, 0]
    assert not [name for name in found.attrs if name.startswith("confirmation_")]
    assert found.amplitude.values == pytest.approx([1.8796312367, 9.4872069457])


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"y": 0.0}, "exactly two of x, y, vx, vy must be arrays and two numbers, got 1 array: x"),
        ({"vx": AXIS}, "exactly two of .* got 3 arrays: x, y, vx"),
        ({"x": [0.0, 0.0]}, "x must increase, got 0.0 after 0.0"),
        ({"x": []}, "x must contain at least one number, got none"),
        ({"x": [[0.0]]}, r"x must be .* got an array of shape \(1, 1\)"),
        ({"x": [0.0, np.nan]}, "x must be a finite real number, got nan"),
        ({"x": [0.0, 1e7]}, r"x must lie within 1e\+06 of zero, got 10000000.0"),
        ({"vx": "fast"}, "vx must be a finite real number, got 'fast'"),
        ({"rtol": 0.1}, "rtol must lie from 1e-12 to 0.0001, got 0.1"),
        ({"workers": 0}, "workers must be at least 1, got 0"),
        ({"executor": "gpu"}, "executor must be one of 'auto', 'serial', .*, got 'gpu'"),
        (
            {"rotor": "mine"},
            "takes a Rotor, DimensionalRotor or RotorSystem .* basin\\(rotor.*, got 'mine'",
        ),
        ({"rotor": Rotor(omega=1.0, zeta=0.0, delta0=1.0)}, "zeta must be above 0 .* got 0.0"),
        ({"rotor": Rotor(omega=1.0, zeta=50.0, delta0=1.0)}, "zeta must be .* got 50.0"),
        (
            {"rotor": Rotor(omega=1e-5, zeta=0.1, delta0=1.0)},
            "omega must be 0 or from 0.001",
        ),
    ],
)
def test_bad_input_gets_one_clear_line(changes, message):
    arguments = {"rotor": FIGURE_7, "x": AXIS, "y": AXIS, **changes}
    with pytest.raises(InputError, match=message) as caught:
        basin(arguments.pop("rotor"), **arguments)
    assert "\n" not in str(caught.value)


def test_finely_folded_basins_are_followed_more_closely():
    """At omega 1.7, delta0 2 one start in fourteen ends elsewhere with an error of 1e-6."""
    folded, smooth = (Rotor(omega=1.7, zeta=0.07, delta0=delta0) for delta0 in (2.0, 0.0))
    axis = np.linspace(-15.0, 15.0, 14)
    chosen = basin(folded, x=axis, y=axis)
    assert chosen.attrs["labelling_rtol"] == disc.SMALL_RTOL
    closely = basin(folded, x=axis, y=axis, rtol=disc.SMALL_RTOL)
    np.testing.assert_array_equal(chosen.label, closely.label)
    coarsely = basin(folded, x=axis, y=axis, rtol=disc.RTOL)
    assert coarsely.attrs["labelling_rtol"] == disc.RTOL
    assert (coarsely.label != chosen.label).sum() > 5
    assert basin(smooth, x=axis, y=axis).attrs["labelling_rtol"] == disc.RTOL
