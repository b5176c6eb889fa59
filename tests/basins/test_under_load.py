"""Fractions of starts under a load: each is followed by itself."""

import math

import numpy as np
import pytest
import xarray as xr

from rotor_ida import InputError, Rotor, basin, basin_fractions, limit_cycle, sweep
from rotor_ida.basins.basin import drawn_from
from rotor_ida.closed_forms.contact_free import complex_amplitude
from rotor_ida.closed_forms.rest import rest
from rotor_ida.schema import RESPONSE
from rotor_ida.verification.verify import rerun

BOX = {"x": (-4, 4), "y": (-4, 4)}
HELD = Rotor(omega=1.7, zeta=0.1, delta0=1.0, shaft_stiffness=0.25, load=0.3)


def test_starts_end_where_a_sweep_from_each_of_them_ends():
    """By CVODE; on a cycle of whole revolutions, which is the one that Newton's method finds."""
    rotor = Rotor(omega=2.0, zeta=0.2, delta0=1.0, load=0.4)
    found = basin_fractions(rotor, **BOX, starts=12, seed=3)
    starts = drawn_from(np.array([[-4, 4], [-4, 4], [0, 0], [0, 0]], float), 3, 0, 12).T
    alone = sweep(omega=2.0, zeta=0.2, delta0=1.0, load=0.4, starts=starts)
    kinds, counts = np.unique(alone.response, return_counts=True)
    told = {
        kind: int(found["count"].values[found.kind.values == kind].sum())
        for kind in np.unique(found.kind).tolist()
    }
    assert told == dict(zip(kinds.tolist(), counts.tolist(), strict=True))
    assert int(found.undecided_count) == 0
    assert (found.confirmed == 1).all()
    for name in ("radius_max", "period"):
        seen = np.unique(alone[name].values[np.isfinite(alone[name])].round(6))
        np.testing.assert_allclose(np.sort(found[name].values), seen, atol=2e-6)
    number = int(np.argmax(found["count"].values))
    revolutions = float(found.period[number]) * rotor.omega / (2.0 * math.pi)
    assert revolutions == pytest.approx(round(revolutions), rel=1e-12)
    on_it = np.flatnonzero(
        np.abs(alone.radius_max.values.ravel() - float(found.radius_max[number])) < 1e-6
    )[0]
    cycle = limit_cycle(rotor, start=tuple(starts[on_it]))
    assert float(found.radius_max[number]) == pytest.approx(float(cycle.radius_max), rel=1e-12)


def test_where_the_shaft_holds_the_load_the_whirl_is_moved_by_it():
    rotor = Rotor(omega=1.0, zeta=0.1, delta0=3.0, shaft_stiffness=4.0, load=0.3)
    found = basin_fractions(rotor, **BOX, starts=8)
    size = abs(complex_amplitude(1.0, 0.1, 4.0))
    assert found.kind.values.tolist() == [RESPONSE["contact_free"]]
    assert found["count"].values.tolist() == [8]
    assert float(found.amplitude[0]) == pytest.approx(size, rel=1e-14)
    assert float(found.radius_min[0]) == pytest.approx(size - 0.075, rel=1e-13)
    assert float(found.radius_max[0]) == pytest.approx(size + 0.075, rel=1e-13)


@pytest.mark.parametrize(("kappa", "kind"), [(0.0, "synchronous"), (1.0, "contact_free")])
def test_a_rotor_that_does_not_turn_comes_to_rest(kappa, kind):
    rotor = Rotor(omega=0.0, zeta=0.2, delta0=1.0, shaft_stiffness=kappa, load=0.3)
    found = basin_fractions(rotor, **BOX, starts=8)
    assert found.kind.values.tolist() == [RESPONSE[kind]]
    assert found["count"].values.tolist() == [8]
    low = abs(rest(rotor)["y"].item())
    for name in ("amplitude", "radius_min", "radius_max"):
        assert float(found[name][0]) == pytest.approx(low, rel=1e-12)


def test_tori_are_one_kind_together():
    """A slight load makes one of the cycle at (2, 0.07, 2), whose period is no whole revolution."""
    rotor = Rotor(omega=2.0, zeta=0.07, delta0=2.0, load=0.05)
    found = basin_fractions(rotor, x=3.0, y=0.0, vx=(-0.1, 0.1), starts=2)
    assert found.kind.values.tolist() == [RESPONSE["quasi_periodic"]]
    assert 1.5 < float(found.radius_min[0]) < 2.0 < float(found.radius_max[0]) < 4.5
    told = found.response_fraction.sel(response=RESPONSE["quasi_periodic"])
    assert float(told) == 1.0


def test_what_followed_them_is_told_and_they_are_followed_again():
    found = basin_fractions(HELD, **BOX, starts=9)
    assert found.attrs["labelling_method"] == "taylor"
    assert found.attrs["labelling_rtol"] == 1e-10
    assert found.attrs["load"] == found["load"].item() == 0.3
    assert math.isnan(found.agreement)
    assert found.trapping.values.tolist() == [0]
    again = rerun(found)
    xr.testing.assert_identical(again.drop_attrs(), found.drop_attrs())
    serial = basin_fractions(HELD, **BOX, starts=9, executor="serial")
    np.testing.assert_array_equal(serial.radius_max, found.radius_max)


def test_a_study_of_them_goes_on(tmp_path):
    asked = {**BOX, "starts": 9, "study": tmp_path / "study"}
    first, again = basin_fractions(HELD, **asked), basin_fractions(HELD, **asked)
    np.testing.assert_array_equal(first["count"], again["count"])
    np.testing.assert_array_equal(first.radius_max, again.radius_max)


def test_a_plane_of_starts_is_refused():
    with pytest.raises(InputError, match=r"^load must be 0 for a basin"):
        basin(HELD, x=[0.0, 1.0], y=[0.0, 1.0])
