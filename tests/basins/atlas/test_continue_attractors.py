"""Attractors over a parameter: fractions as of each rotor alone, numbers that last, honest gaps."""

import numpy as np
import pytest

from rotor_ida import (
    InputError,
    Rotor,
    basin_fractions,
    continue_attractors,
    continue_cycle,
    limit_cycle,
    load,
    save,
)
from rotor_ida.schema import RESPONSE
from rotor_ida.verification.resume import resume

BOX = {"x": (-15, 15), "y": (-15, 15)}
ISOLA = np.linspace(1.7, 3.0, 6)


@pytest.fixture(scope="module")
def isola():
    return continue_attractors(omega=ISOLA, zeta=0.07, delta0=2.0, **BOX, starts=150, seed=2)


def test_fractions_are_those_of_each_rotor_alone(isola):
    for omega in ISOLA[[0, 3]]:
        alone = basin_fractions(
            Rotor(omega=omega, zeta=0.07, delta0=2.0), **BOX, starts=150, seed=2, rtol=1e-6
        )
        here = isola.sel(omega=omega).squeeze()
        present = np.isfinite(here.fraction) & (here["count"] > 0)
        together = here["count"].values[present]
        np.testing.assert_array_equal(
            np.sort(together), np.sort(alone["count"].values[alone["count"].values > 0])
        )


def test_all_starts_are_accounted_for(isola):
    total = isola["count"].sum("attractor") / 150 + isola.undecided_fraction
    np.testing.assert_allclose(total, 1.0)
    assert float(isola.undecided_fraction.max()) == 0.0
    present = np.isfinite(isola.fraction)
    assert (isola.kind.values[~present.values] == RESPONSE["not_found"]).all()
    assert (isola["count"].values[~present.values] == 0).all()


def test_one_number_lies_on_one_branch(isola):
    """The cycle of period 4.56 at omega 2 is on the isola: so is whatever has its number."""
    rotor = Rotor(omega=2.0, zeta=0.07, delta0=2.0)
    branch = continue_cycle(rotor, start=limit_cycle(rotor, start=(0, 0, 0, 0)), limits=(0.1, 5.0))
    main = isola.sel(omega=3.0).squeeze()
    number = int(np.flatnonzero(np.isfinite(main.period))[0])
    own = isola.isel(attractor=number).squeeze()
    here = np.isfinite(own.fraction.values)
    assert here.tolist() == [False, True, True, True, True, True]  # its period doubles at 1.803
    order = np.argsort(branch.radius_max.values)
    for row in np.flatnonzero(here).tolist():
        near = np.hypot(
            branch.omega.values[order] - ISOLA[row],
            branch.radius_max.values[order] - float(own.radius_max[row]),
        )
        assert near.min() < 0.05


def test_what_the_sample_could_have_missed(isola):
    """With this fraction an attractor is missed by 150 starts in 5 of 100 samples."""
    assert (1.0 - float(isola.missed_fraction)) ** 150 == pytest.approx(0.05)


def test_given_starts_are_followed_as_drawn_ones():
    states = np.random.default_rng(0).normal(0.0, 3.0, (40, 4))
    found = continue_attractors(omega=[1.6, 1.7], zeta=0.07, delta0=0.0, starts=states)
    assert int(found["count"].sum()) == 80
    np.testing.assert_array_equal(np.reshape(found.attrs["starts"], (40, 4)), states)


def test_whoever_does_the_work_finds_the_same_bits(isola):
    again = continue_attractors(
        omega=ISOLA, zeta=0.07, delta0=2.0, **BOX, starts=150, seed=2, executor="processes",
        workers=2,
    )  # fmt: skip
    assert again.identical(isola)


def test_it_can_be_kept_and_goes_on_from_a_study(isola, tmp_path):
    save(isola, tmp_path / "atlas.nc")
    assert load(tmp_path / "atlas.nc").fraction.equals(isola.fraction)

    def interrupt(done, _total):
        if done >= 3:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        continue_attractors(
            omega=ISOLA, zeta=0.07, delta0=2.0, **BOX, starts=150, seed=2, progress=interrupt,
            study=tmp_path / "study", workers=1,
        )  # fmt: skip
    assert resume(tmp_path / "study").identical(isola)


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"omega": [2.0, 1.0]}, "omega must increase, got 1.0 after 2.0"),
        (
            {"omega": [1.0, 2.0], "zeta": [0.1, 0.2], "delta0": [0.0, 1.0]},
            "two of the parameters at most may be arrays, got 3: omega, zeta, delta0",
        ),
        ({"zeta": 0.0}, "zeta must be above 0, where nothing settles, .* got 0.0"),
        ({"starts": 0}, "starts must be at least 1, got 0"),
        ({"x": 1.0, "y": 0.0}, "x, y, vx or vy must be a range, got numbers for 1000 starts"),
        ({"starts": np.zeros((3, 2))}, r"starts must be a number, or .* got one of shape \(3, 2\)"),
        (
            {"starts": np.zeros((3, 4))},
            "x, y, vx and vy must be left out where starts are given",
        ),
        ({"x": (1, 2, 3)}, r"x must be a number or a range \(low, high\), got \(1, 2, 3\)"),
        ({"rtol": 0.1}, "rtol must lie from 1e-12 to 0.0001, got 0.1"),
    ],
)
def test_bad_input_gets_one_clear_line(changes, message):
    given = {"omega": [1.0, 2.0], "zeta": 0.1, "delta0": 0.5, **BOX, **changes}
    with pytest.raises(InputError, match=message) as caught:
        continue_attractors(**given)
    assert "\n" not in str(caught.value)
