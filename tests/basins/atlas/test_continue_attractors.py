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
    synchronous_response,
)
from rotor_ida.basins.atlas import resilience
from rotor_ida.basins.atlas.cells import CellJob, fill_cell, form_of
from rotor_ida.basins.atlas.shocks import Effort
from rotor_ida.closed_forms.contact_free import complex_amplitude
from rotor_ida.schema import RESPONSE
from tests.basins.atlas.reports import BOX, WIDE, of_kind
from tests.basins.lanes import WHIP

PLAIN = {"omega": 2.0, "zeta": 0.07, "delta0": 2.0}
ISOLA, STARTS = np.linspace(1.7, 3.0, 6), 60


@pytest.fixture(scope="module")
def isola():
    return continue_attractors(omega=ISOLA, zeta=0.07, delta0=2.0, **BOX, starts=STARTS, seed=2)


def test_fractions_are_those_of_each_rotor_alone(isola):
    for omega in ISOLA[[0, 3]]:
        alone = basin_fractions(
            Rotor(omega=omega, zeta=0.07, delta0=2.0), **BOX, starts=STARTS, seed=2, rtol=1e-6
        )
        here = isola.sel(omega=omega).squeeze()
        present = np.isfinite(here.fraction) & (here["count"] > 0)
        together = here["count"].values[present]
        np.testing.assert_array_equal(
            np.sort(together), np.sort(alone["count"].values[alone["count"].values > 0])
        )


def test_all_starts_are_accounted_for(isola):
    total = isola["count"].sum("attractor") / STARTS + isola.undecided_fraction
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
    """With this fraction an attractor is missed by 60 starts in 5 of 100 samples."""
    assert (1.0 - float(isola.missed_fraction)) ** STARTS == pytest.approx(0.05)


def test_given_starts_are_followed_as_drawn_ones():
    states = np.random.default_rng(0).normal(0.0, 3.0, (40, 4))
    found = continue_attractors(omega=[1.6, 1.7], zeta=0.07, delta0=0.0, starts=states)
    assert int(found["count"].sum()) == 80
    np.testing.assert_array_equal(np.reshape(found.attrs["starts"], (40, 4)), states)


def test_an_atlas_over_the_stiffness_of_the_shaft_begins_with_the_papers_rotor():
    kappas = [0.0, 0.1, 0.25, 0.5]
    atlas = continue_attractors(**PLAIN, shaft_stiffness=kappas, **BOX, starts=128)
    assert atlas.fraction.dims == ("omega", "zeta", "delta0", "shaft_stiffness", "attractor")
    line = atlas.squeeze()
    np.testing.assert_allclose(line.fraction.sum("attractor"), 1.0, rtol=1e-12)
    alone = continue_attractors(**PLAIN, **BOX, starts=128).squeeze()
    found = line.isel(shaft_stiffness=0)
    there = np.isfinite(found.fraction.values)
    for name in ("fraction", "amplitude", "radius_max", "period"):
        kept = alone[name].values
        np.testing.assert_array_equal(found[name].values[there], kept[np.isfinite(alone.fraction)])
    # one number for the contact-free whirls throughout, whose amplitude is exact
    exact = np.abs(complex_amplitude(2.0, 0.07, np.array(kappas)))
    np.testing.assert_allclose(line.amplitude.isel(attractor=0), exact, rtol=1e-14)
    # the bouncing cycle ends at a fold between the last two
    bouncing = of_kind(line.isel(shaft_stiffness=1), "bouncing").attractor.item()
    lasts = np.isfinite(line.radius_max.isel(attractor=bouncing).values)
    assert lasts.tolist() == [True, True, True, False]


def test_from_one_law_of_contact_to_the_other_nothing_is_followed():
    atlas = continue_attractors(**PLAIN, contact_exponent=[1.0, 1.5], **BOX, starts=64)
    line = atlas.squeeze()
    shared = np.isfinite(line.fraction.values).all(axis=0)
    kinds = line.kind.values[:, shared]
    family = [RESPONSE["contact_free"], RESPONSE["touching"]]
    assert shared.any()
    assert np.isin(kinds, family).all()


def test_a_stored_cell_comes_back_whole(monkeypatch):
    few = Effort(rounds=6, leading=2, neighbours=4, turns=2)
    monkeypatch.setattr(resilience.DiscSearch, "effort", few)
    rotor = Rotor(**PLAIN, shaft_stiffness=0.25, contact_exponent=1.0, contact_damping=0.1)
    states = np.array([[0.0, 4.0], [0.0, 0.0], [0.0, 0.0], [0.0, 0.0]])
    cell, form = fill_cell(CellJob(rotor, states, 16, 1e-6), np.zeros(1, np.uint8)), form_of(rotor)
    back = form.unpack(form.pack(cell))
    assert (back.rotor, back.undecided, back.largest_shocks) == (rotor, 0, cell.largest_shocks)
    assert sum(each.count for each in back.members) == 2
    for one, other in zip(back.members, cell.members, strict=True):
        assert (one.kind, one.count) == (other.kind, other.count)
        assert one.row.tobytes() == other.row.tobytes()
        np.testing.assert_array_equal(one.settling, other.settling)
        np.testing.assert_array_equal(one.resilience.extents, other.resilience.extents)
        np.testing.assert_array_equal(one.resilience.before, other.resilience.before)


def test_a_load_is_refused():
    with pytest.raises(InputError, match=r"^load must be 0 for an atlas"):
        continue_attractors(**PLAIN, load=0.125, **BOX, starts=4)


def test_an_atlas_over_friction_has_the_whirl_of_the_closed_form_and_whip_once():
    """Fractions are those of `basin_fractions`; from no friction on the whirl is one attractor."""
    machine = {"omega": WHIP.omega, "zeta": 0.1, "delta0": 1.0}
    friction = [0.0, 0.1, 0.2, 0.22]
    asked = {**machine, "friction": friction, "disc_radius": 10.0, **WIDE, "starts": 30}
    found = continue_attractors(**asked).squeeze()
    whirl, whip = (
        of_kind(found.isel(friction=2), "synchronous"),
        of_kind(found.isel(friction=2), "rolling"),
    )
    exact = synchronous_response(**machine, friction=friction).squeeze()
    stable = (exact.in_contact == 1) & (exact.stability == 1)
    along = found.amplitude.sel(attractor=int(whirl.attractor))
    np.testing.assert_allclose(along, exact.amplitude.where(stable).min("branch"), rtol=1e-9)
    rolls = found.fraction.sel(attractor=int(whip.attractor))
    assert np.isnan(rolls.values).tolist() == [True, True, False, False]
    alone = basin_fractions(WHIP, **WIDE, starts=30)
    assert float(rolls[2]) == float(of_kind(alone, "rolling").fraction)
    assert found.kind.sel(attractor=int(whip.attractor)).values[2:].tolist() == [9, 9]


def test_limit_cycles_keep_their_numbers_over_friction_from_none_on():
    """They are points of the branches that `continue_cycle` follows; one is born in between."""
    machine = {"omega": 2.0, "zeta": 0.07, "delta0": 2.0, "disc_radius": 10.0}
    friction = [0.0, 0.05, 0.1, 0.15]
    found = continue_attractors(**machine, friction=friction, **WIDE, starts=12).squeeze()
    bounces = of_kind(found.isel(friction=0), "bouncing").attractor.item()
    over = found.sel(attractor=bounces)
    assert (over.kind == RESPONSE["bouncing"]).all()
    for each in friction:
        rotor = Rotor(**machine, friction=each)
        cycle = limit_cycle(rotor, start=(3.0, 1.0, 0.0, 0.0))
        for name in ("period", "radius_min", "radius_max"):
            there = over[name].sel(friction=each).item()
            assert there == pytest.approx(cycle[name].item(), rel=1e-9)
    branch = continue_cycle(
        Rotor(**machine), start=(3.0, 1.0, 0.0, 0.0), parameter="friction", limits=(0.0, 0.15)
    )
    assert float(branch.period[-1]) == pytest.approx(float(over.period[-1]), rel=1e-9)
    other = of_kind(found.isel(friction=3), "full_contact").attractor.item()
    periods = found.period.sel(attractor=other).values
    assert np.isnan(periods).tolist() == [True, True, False, False]


def test_a_disc_that_slides_forwards_all_the_time_does_not_know_how_large_it_is():
    given = {"omega": 1.2, "zeta": 0.3, "delta0": 0.5, "disc_radius": [5.0, 10.0], "friction": 0.1}
    atlas = continue_attractors(**given, **WIDE, starts=10)
    assert atlas.fraction.squeeze("attractor").values.ravel().tolist() == [1.0, 1.0]
    assert np.ptp(atlas.amplitude.values) == 0.0
