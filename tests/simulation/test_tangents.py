"""The variational equation through flight, entries and exits, against the simulator."""

import numpy as np
import pytest

from rotor_ida import Rotor
from rotor_ida.core.interface import DONE, STOPPED
from rotor_ida.core.runs import RunRequest, follow_run, stretch

BOUNCING = Rotor(omega=2.0, zeta=0.07, delta0=2.0)
START = np.array([0.3, 0.2, 0.1, -0.4])


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
