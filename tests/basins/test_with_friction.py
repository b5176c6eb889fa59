"""Fractions of starts with friction: each is followed by itself, to rubs or into dry whip."""

import math

import numpy as np
import pytest
import xarray as xr

from rotor_ida import InputError, Rotor, basin, basin_fractions, sweep, touchdown_report
from rotor_ida.analysis.verification import rerun
from rotor_ida.basins.fractions import drawn_from
from rotor_ida.schema import RESPONSE

WHIP = Rotor(omega=0.62962981, zeta=0.1, delta0=1.0, friction=0.2, disc_radius=10.0)
BOX = {"x": (-6, 6), "y": (-6, 6), "vx": (-6, 6), "vy": (-6, 6)}


def test_starts_end_in_dry_whip_or_on_the_rub_as_a_sweep_from_each_does():
    """By CVODE; rub and contact-free whirl come from closed forms, and whip is one attractor."""
    found = basin_fractions(WHIP, **BOX, starts=24, seed=1)
    starts = drawn_from(np.array(list(BOX.values()), float), 1, 0, 24).T
    alone = sweep(**WHIP.given, starts=starts).squeeze()
    assert {RESPONSE["synchronous"], RESPONSE["rolling"]} == set(alone.response.values.tolist())
    for kind in ("synchronous", "rolling", "contact_free"):
        here = found["count"].values[found.kind.values == RESPONSE[kind]].sum()
        assert here == (alone.response == RESPONSE[kind]).sum()
        told = found.response_count.sel(response=RESPONSE[kind])
        assert int(told) == here
    assert int(found.undecided_count) == 0
    assert (found.trapping == 0).all()
    assert (found.confirmed.values == (found["count"].values > 0)).all()
    rolls = found.isel(attractor=int(np.argmax(found.kind.values == RESPONSE["rolling"])))
    whips = alone.where(alone.response == RESPONSE["rolling"])
    assert float(rolls.radius_min) == pytest.approx(float(whips.radius_min.min()), abs=1e-6)
    assert float(rolls.radius_max) == pytest.approx(float(whips.radius_max.max()), abs=1e-6)
    assert math.isnan(rolls.period)


def test_motions_that_bounce_are_one_attractor_together():
    rotor = Rotor(omega=2.0, zeta=0.07, delta0=2.0, friction=0.1, disc_radius=10.0)
    found = basin_fractions(rotor, x=(-4, 4), y=(-4, 4), starts=9)
    bounces = found.isel(attractor=int(np.argmax(found.kind.values == RESPONSE["bouncing"])))
    assert int(bounces["count"]) > 0
    assert bool(bounces.confirmed)
    assert float(bounces.radius_min) < 2.0 < float(bounces.radius_max)


def test_they_are_followed_again_and_a_study_goes_on(tmp_path):
    asked = {**BOX, "starts": 9, "study": tmp_path / "study"}
    found, again = basin_fractions(WHIP, **asked), basin_fractions(WHIP, **asked)
    assert found.attrs["labelling_method"] == "taylor"
    assert found.attrs["friction"] == found.friction.item() == 0.2
    for name in ("count", "radius_max"):
        np.testing.assert_array_equal(found[name], again[name])
    xr.testing.assert_identical(rerun(found).drop_attrs(), found.drop_attrs())


def test_without_friction_no_kind_is_told_that_cannot_be():
    found = basin_fractions(Rotor(omega=1.7, zeta=0.07, delta0=0.0), x=(-9, 9), y=0.0, starts=5)
    assert RESPONSE["rolling"] not in found.response.values


@pytest.mark.parametrize(
    ("ask", "words"),
    [
        (lambda: basin(WHIP, x=[0.0, 1.0], y=[0.0, 1.0]), "friction must be 0 for a basin"),
        (
            lambda: touchdown_report(WHIP, x=(-1, 1), y=(-1, 1)),
            "friction must be 0 for a touchdown",
        ),
        (
            lambda: basin_fractions(
                Rotor(omega=0.0, zeta=0.1, delta0=1.0, load=0.3, friction=0.2, disc_radius=1.0),
                **BOX,
            ),
            "omega must be above 0",
        ),
    ],
)
def test_what_is_not_known_with_friction_is_refused_in_one_line(ask, words):
    with pytest.raises(InputError, match=words) as refused:
        ask()
    assert "\n" not in str(refused.value)
