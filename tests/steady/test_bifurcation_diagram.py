"""Extrema of the radius: exact where motions are known, and the table of a diagram."""

import math

import numpy as np
import pytest

from rotor_ida import Rotor, bifurcation_diagram, simulate
from rotor_ida.closed_forms import planar_period
from rotor_ida.schema import RESPONSE
from rotor_ida.simulation.crossings import MAXIMUM, MINIMUM, radius_extrema
from rotor_ida.simulation.flow import DiscFlow

REST = (0.0, 0.0, 0.0, 0.0)


def test_planar_vibration_turns_back_at_its_amplitude_every_half_period():
    """Minima lie at the centre, where the radius is the root of rounding.

    Without clearance the force lacks a second derivative there; each passage costs up to some
    hundred tolerances.
    """
    free = DiscFlow(Rotor(omega=0.0, zeta=0.0, delta0=0.0), rtol=1e-12)
    found = radius_extrema(free, np.array([2.0, 0.0, 0.0, 0.0]), 20.0)
    half = 0.5 * float(planar_period(2.0))
    highest, lowest = found["kind"] == MAXIMUM, found["kind"] == MINIMUM
    # the start, where the motion turns back too, may count or not
    late = found["time"][highest] > 1.0
    times = half * np.arange(1, late.sum() + 1)
    np.testing.assert_allclose(found["time"][highest][late], times, atol=1e-9)
    np.testing.assert_allclose(found["radius"][highest], 2.0, rtol=1e-9)
    assert found["radius"][lowest].max() < 1e-6
    assert late.sum() == int(20.0 / half)


def test_table_of_a_diagram_belongs_to_its_points():
    found = bifurcation_diagram(omega=[2.0, 3.0], zeta=0.07, delta0=[0.5, 2.0], starts=[REST])
    counts = found.extremum_count.values.ravel()
    assert found.extremum_count.attrs["sample_dimension"] == "extremum"
    assert counts.sum() == found.sizes["extremum"]
    ends = np.cumsum(counts)
    for number, (low, high, kind) in enumerate(
        zip(
            found.radius_min.values.ravel(),
            found.radius_max.values.ravel(),
            found.response.values.ravel(),
            strict=True,
        )
    ):
        radii = found.extremum_radius.values[ends[number] - counts[number] : ends[number]]
        # the sweep has them from cubics between samples
        assert radii.max() == pytest.approx(high, rel=1e-4)
        assert radii.min() == pytest.approx(low, abs=1e-3)
        if kind == RESPONSE["synchronous"]:
            assert radii.size == 1
    assert {RESPONSE["bouncing"], RESPONSE["full_contact"]} <= set(found.response.values.ravel())


def test_random_starts_come_from_the_seed():
    arguments = {"omega": 1.2, "zeta": 1.0, "delta0": 0.0, "starts": 3}
    box = {"x": (-2.0, 2.0), "vy": 1.0}
    one, same, other = (bifurcation_diagram(**arguments, seed=seed, **box) for seed in (1, 1, 2))
    assert one.start_x.identical(same.start_x)
    assert not (one.start_x == other.start_x).any()
    assert (np.abs(one.start_x) <= 2.0).all()
    assert (one.start_vy == 1.0).all()
    assert (one.attrs["range_vx"] == [-5.0, 5.0]).all()
    # without clearance and with so much damping there is one whirl
    assert np.ptp(one.extremum_radius.values) < 1e-8


MACHINE = {"omega": 2.0, "zeta": 0.05, "delta0": 1.0, "starts": [REST], "method": "taylor"}


def test_over_the_load_a_cycle_has_its_extrema_again_and_again():
    """Of two revolutions at 0.6: the extrema of a run through two, and no others."""
    found = bifurcation_diagram(shaft_stiffness=0.25, load=[0.0, 0.6], **MACHINE)
    assert found.extremum_count.dims == ("omega", "zeta", "delta0", "load", "start")
    assert found.shaft_stiffness.item() == 0.25
    counts = found.extremum_count.values.ravel()
    assert found.response.values.ravel()[1] == RESPONSE["bouncing"]
    radii = found.extremum_radius.values[counts[0] :]
    machine = Rotor(omega=2.0, zeta=0.05, delta0=1.0, shaft_stiffness=0.25, load=0.6)
    run = simulate(
        machine, start=REST, duration=600.0, samples=np.linspace(600.0 - 2.0 * math.pi, 600.0, 4001)
    )
    radius = np.hypot(run.x.values, run.y.values)
    turns = np.flatnonzero(np.diff(np.sign(np.diff(radius)))) + 1
    distinct = np.unique(np.round(radii, 6))
    np.testing.assert_allclose(distinct, np.unique(np.round(radius[turns], 6)), atol=1e-4)
    assert distinct.size == turns.size
    assert radii.max() == pytest.approx(found.radius_max.values.ravel()[1], rel=1e-9)


def test_with_friction_the_extrema_of_dry_whip_are_those_of_its_samples():
    """Beside the rub, which has one radius: both from the same rotor."""
    machine = {"omega": [0.6, 1.2], "zeta": 0.1, "delta0": 1.0, "friction": [0.0, 0.2]}
    starts = [(0.0, 0.0, 0.0, 0.0), (5.0, 0.0, 0.0, -6.3)]
    found = bifurcation_diagram(**machine, disc_radius=10.0, starts=starts, extrema_time=60.0)
    assert found.extremum_count.dims == ("omega", "zeta", "delta0", "friction", "start")
    whips = found.response == RESPONSE["rolling"]
    assert whips.values.ravel().tolist() == [False, False, False, True, False, False, False, True]
    ends = np.cumsum(found.extremum_count.values.ravel())
    for place, omega in ((3, 0.6), (7, 1.2)):
        own = slice(ends[place - 1], ends[place])
        kinds, radii = found.extremum_kind.values[own], found.extremum_radius.values[own]
        rotor = Rotor(omega=omega, zeta=0.1, delta0=1.0, friction=0.2, disc_radius=10.0)
        run = simulate(rotor, start=starts[1], duration=1000.0, samples=200_001, method="taylor")
        radius = np.hypot(run.x, run.y).values[-4000:]
        for kind, limit in ((1, radius.max()), (-1, radius.min())):
            np.testing.assert_allclose(radii[kinds == kind], limit, atol=1e-4)
            assert (kinds == kind).sum() > 10
