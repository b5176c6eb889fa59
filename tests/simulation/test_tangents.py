"""The variational equation through flight, entries and exits, against the simulator."""

import numpy as np
import pytest
from scipy.linalg import expm

from rotor_ida import Rotor
from rotor_ida.core.interface import DONE, STOPPED
from rotor_ida.core.runs import RunRequest, follow_run, stretch
from rotor_ida.model.equations import rotated, rotating_jacobian
from rotor_ida.simulation.options import Options
from rotor_ida.simulation.run import run

BOUNCING = Rotor(omega=2.0, zeta=0.07, delta0=2.0)
START = np.array([0.3, 0.2, 0.1, -0.4])
TIGHT = Options(rtol=1e-13, atol=1e-15)


def followed(rotor, start, duration, rtol, method="taylor"):
    """State and product of orthonormal vectors and stretching after one span."""
    bundle = np.eye(4)
    asked = RunRequest(
        rotor=rotor, start=start, duration=duration, rtol=rtol, atol=1e-2 * rtol, method=method,
        bundle=bundle,
    )  # fmt: skip
    stretches, seen = stretch(asked, 1)
    assert seen.status == DONE
    assert stretches[0, 4] == 0.0  # no jump has changed a volume
    return np.vstack([seen.state, bundle]), stretches[0, :4]


def simulated(rotor, start, duration):
    """State on the rotating axes, and number of events, by the simulator."""
    orbit = run(rotor, tuple(start), duration, np.empty(0), TIGHT)
    return rotated(orbit.end, -rotor.omega * duration), orbit.event_times.size


def test_largest_stretching_is_that_of_simulated_neighbours_through_contact_events():
    """Central differences over five events: no jump is missing at entry or exit.

    The first tangent vector starts along x; its stretching is the length of the first column.
    """
    duration, step = 20.0, 1e-5
    _, events = simulated(BOUNCING, START, duration)
    assert events >= 5
    moved = [simulated(BOUNCING, START + sign * step * np.eye(4)[0], duration)[0]
             for sign in (1, -1)]  # fmt: skip
    column = (moved[0] - moved[1]) / (2.0 * step)
    bundle, stretch = followed(BOUNCING, START, duration, 1e-12)
    # step**2 for the curvature of the flow map, which is below 1e3
    np.testing.assert_allclose(np.exp(stretch[0]) * bundle[1], column, rtol=0.0, atol=1e-6)


def test_volume_shrinks_by_the_damping_alone():
    """Liouville: the determinant is exp(-4 zeta t), whatever the contacts."""
    _, stretch = followed(BOUNCING, START, 20.0, 1e-12)
    assert stretch.sum() == pytest.approx(-4.0 * 0.07 * 20.0, abs=1e-9)


def test_flight_is_the_linear_map():
    rotor = Rotor(omega=1.3, zeta=0.2, delta0=50.0)
    bundle, stretch = followed(rotor, START, 0.7, 1e-10)
    exact = expm(0.7 * rotating_jacobian(START, rotor))
    expected, triangle = np.linalg.qr(exact)
    np.testing.assert_allclose(stretch, np.log(np.abs(np.diag(triangle))), atol=1e-13)
    np.testing.assert_allclose(np.abs(bundle[1:].T), np.abs(expected), atol=1e-13)


@pytest.mark.parametrize("method", ["adams", "bdf"])
@pytest.mark.parametrize("rotor", [BOUNCING, Rotor(omega=1.7, zeta=0.07, delta0=0.0)])
def test_cvode_leads_tangent_vectors_to_where_taylor_series_do(rotor, method):
    """State, directions and stretching, by two methods, through entries and exits."""
    expected, found = (followed(rotor, START, 20.0, rtol, method)
                       for rtol, method in ((1e-13, "taylor"), (1e-12, method)))  # fmt: skip
    np.testing.assert_allclose(found[0], expected[0], rtol=0.0, atol=1e-8)
    np.testing.assert_allclose(found[1], expected[1], rtol=0.0, atol=1e-8)


@pytest.mark.parametrize("method", ["taylor", "adams"])
def test_many_spans_are_one_flow(method):
    """Stretching over spans, rows made orthonormal between them, adds up to that of one run."""
    rows = np.linalg.qr(np.random.default_rng(0).normal(size=(4, 4)))[0]
    asked = {"rotor": BOUNCING, "start": START, "rtol": 1e-12, "atol": 1e-14, "method": method}
    bundle = rows.copy()
    stretches, seen = stretch(RunRequest(**asked, duration=0.5, bundle=bundle), 40)
    assert stretches.shape == (40, 5)
    np.testing.assert_allclose(bundle @ bundle.T, np.eye(4), rtol=0.0, atol=1e-14)
    whole = rows.copy()
    once = follow_run(RunRequest(**asked, duration=20.0, bundle=whole))
    np.testing.assert_allclose(seen.state, once.state, rtol=0.0, atol=1e-8)
    triangle = np.linalg.qr(whole.T)[1]
    expected = np.log(np.abs(np.diag(triangle)))
    np.testing.assert_allclose(stretches[:, :4].sum(axis=0), expected, rtol=0.0, atol=1e-7)


def test_a_stretching_that_is_stopped_says_how_far_it_came():
    stop = np.ones(1, np.uint8)
    asked = RunRequest(rotor=BOUNCING, start=START, duration=0.5, rtol=1e-9, atol=1e-11,
                  bundle=np.eye(4), stop=stop)  # fmt: skip
    stretches, seen = stretch(asked, 10)
    assert seen.status == STOPPED
    assert stretches.shape == (0, 5)
