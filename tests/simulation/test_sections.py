import math

import numpy as np
import pytest

from rotor_ida import InputError, Rotor, poincare_section, simulate
from rotor_ida.model.equations import rotated
from tests.rotors import WHIP

REST = (0.0, 0.0, 0.0, 0.0)
BOUNCING = Rotor(omega=2.0, zeta=0.07, delta0=2.0)


def states(section):
    return np.stack([section[f"rotating_{name}"] for name in ("x", "y", "vx", "vy")], axis=-1)


def test_skipping_changes_neither_times_nor_states():
    """Up to the error of the motion itself, which here neither grows nor dies."""
    for at in ("revolution", "entry", "peak"):
        long = poincare_section(BOUNCING, start=REST, revolutions=30, at=at)
        late = poincare_section(BOUNCING, start=REST, revolutions=20, skip=10, at=at)
        last = late.sizes["crossing"]
        np.testing.assert_allclose(late.crossing_time, long.crossing_time[-last:], atol=1e-7)
        np.testing.assert_allclose(states(late), states(long)[-last:], atol=1e-7)


LOADED = Rotor(omega=2.0, zeta=0.05, delta0=1.0, shaft_stiffness=0.25, load=0.6)


@pytest.mark.parametrize("phase", [0.0, 0.5 * math.pi, 4.0])
def test_under_a_load_the_stroboscopic_section_is_at_the_angle_that_is_named(phase):
    """A cycle of two revolutions is two points; they are samples of a run at those times."""
    section = poincare_section(
        LOADED, start=REST, revolutions=6, skip=200, phase=phase, method="taylor"
    )
    assert section.attrs["phase"] == phase
    points = states(section)
    assert np.abs(points[2:] - points[:-2]).max() < 1e-9
    assert np.abs(points[1:] - points[:-1]).max(axis=1).min() > 0.1
    np.testing.assert_allclose(
        section.crossing_time.values[:6], (phase + 2.0 * math.pi * np.arange(200, 206)) / 2.0
    )
    # on from the first crossing at angle 0, by another solver
    start = states(poincare_section(LOADED, start=REST, revolutions=1, skip=200, method="taylor"))
    times = (phase + 2.0 * math.pi * np.arange(4)) / 2.0
    run = simulate(
        LOADED, start=start[0], duration=20.0, samples=np.unique([0.0, *times, 20.0]), rtol=1e-11
    )
    fixed = np.stack([run[name].values for name in ("x", "y", "vx", "vy")], axis=-1)
    there = fixed[np.searchsorted(run.t.values, times)]
    np.testing.assert_allclose(points[:4], rotated(there, np.full(4, -phase)), atol=1e-8)


@pytest.mark.parametrize(
    ("rotor", "wrong", "message"),
    [
        (Rotor(omega=0.0, zeta=0.1, delta0=1.0), {}, "omega must be positive for a section"),
        (Rotor(omega=1.0, zeta=0.1, delta0=0.0), {"at": "entry"}, "delta0 must be positive"),
        (BOUNCING, {"at": "apex"}, "at must be one of 'revolution', 'entry', 'exit', 'peak'"),
        (BOUNCING, {"revolutions": 0}, "revolutions must be at least 1, got 0"),
        (BOUNCING, {"skip": -1}, "skip must be at least 0, got -1"),
        (BOUNCING, {"phase": -1.0}, "phase must be zero or positive, got -1.0"),
        (BOUNCING, {"phase": 7.0}, "phase must be below 2 pi, got 7.0"),
        (
            BOUNCING,
            {"phase": 1.0, "at": "peak"},
            "phase must be 0 for a section at each peak, got 1.0",
        ),
    ],
)
def test_bad_input_is_refused(rotor, wrong, message):
    with pytest.raises(InputError, match=message):
        poincare_section(rotor, **{"start": REST, "revolutions": 2, **wrong})


KNOCKED = (5.0, 0.0, 0.0, -6.3)


def test_dry_whip_is_one_point_by_peaks_and_skipping_in_it_changes_nothing():
    """Also where what is skipped ends while the disc rolls, as it does here."""
    late = poincare_section(WHIP, start=KNOCKED, revolutions=20, skip=50, at="peak")
    long = poincare_section(WHIP, start=KNOCKED, revolutions=70, at="peak")
    assert simulate(WHIP, start=KNOCKED, duration=100.0 * math.pi / WHIP.omega)["mode"][-1] == 2
    last = late.sizes["crossing"]
    np.testing.assert_allclose(states(late), states(long)[-last:], atol=1e-8)
    assert np.ptp(states(late), axis=0).max() < 1e-7
