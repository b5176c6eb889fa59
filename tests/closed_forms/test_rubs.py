"""Synchronous rubs with friction, held by 50 digits and by the stated equation of motion."""

from __future__ import annotations

import mpmath
import numpy as np
import pytest
from scipy.optimize import brentq

from rotor_ida.closed_forms import eigenvalues, stability_determinant, synchronous_response
from rotor_ida.errors import InputError
from rotor_ida.schema import STABILITY

ROUNDING = 3e-15
NAMES = ("amplitude", "phase_lag", "stability", "in_contact", "growth_rate")


def random_rotors(count, seed, *, with_damping=False):
    """Parameters over many orders of magnitude; a tenth without damping, half with a shaft."""
    draw = np.random.default_rng(seed)
    for _ in range(count):
        yield {
            "omega": 10 ** draw.uniform(-1.0, 1.0),
            "zeta": 10 ** draw.uniform(-3.0, 0.0) * (draw.random() > 0.1),
            "delta0": 10 ** draw.uniform(-2.0, 1.0),
            "shaft_stiffness": float(draw.choice([0.0, 10 ** draw.uniform(-2.0, 1.0)])),
            "contact_exponent": float(draw.choice([1.5, 1.0])),
            "friction": 10 ** draw.uniform(-3.0, 0.5),
            "contact_damping": 10 ** draw.uniform(-2.0, 0.5) * with_damping,
        }


def rubs_of(rotor):
    """The whirls in contact, one row each: amplitude, lag, stability, growth rate."""
    found = synchronous_response(**rotor)
    columns = [found[name].values.ravel() for name in NAMES]
    return [row for row in zip(*columns, strict=True) if row[3] == 1]


def polynomial_roots(rotor):
    """Amplitudes and lags of all rubs, by 50 digits, from the polynomial in u."""
    mpmath.mp.dps = 50
    w, z, d, k, mu = (
        mpmath.mpf(rotor[name])
        for name in ("omega", "zeta", "delta0", "shaft_stiffness", "friction")
    )
    p, h = w**2 - k, 2 * z * w
    # (f - p A)**2 + (h A + mu f)**2 = w**4 with A = d + u**2
    ff, fa, aa = 1 + mu**2, 2 * (mu * h - p), p**2 + h**2
    if rotor["contact_exponent"] == 1.5:
        powers = [aa * d**2 - w**4, 0, 2 * d * aa, fa * d, aa, fa, ff]
    else:
        powers = [aa * d**2 - w**4, 0, fa * d + 2 * d * aa, 0, ff + fa + aa]
    found = []
    for root in mpmath.polyroots(powers, maxsteps=800, extraprec=600, asc=True):
        u = mpmath.re(root)
        if abs(mpmath.im(root)) < mpmath.mpf(10) ** -22 and u > mpmath.mpf(10) ** -22:
            f = u ** (2 * mpmath.mpf(rotor["contact_exponent"]))
            A = d + u**2
            found.append((A, mpmath.atan2(h * A + mu * f, f - p * A)))
    return sorted(found)


def field(state, rotor):
    """The equation of motion on the rotating axes; takes complex states.

    The state is the displacement and the velocity on the fixed axes, both on the rotating ones.
    """
    x, y, vx, vy = state
    omega, zeta, kappa = (rotor[name] for name in ("omega", "zeta", "shaft_stiffness"))
    r = np.sqrt(x * x + y * y)
    depth = r - rotor["delta0"]
    rate = (x * vx + y * vy) / r
    normal = depth ** rotor["contact_exponent"] * (1.0 + rotor["contact_damping"] * rate)
    across = rotor["friction"] * normal
    ax = omega**2 - 2.0 * zeta * vx - kappa * x - (normal * x - across * y) / r
    ay = -2.0 * zeta * vy - kappa * y - (normal * y + across * x) / r
    return np.array([vx + omega * y, vy - omega * x, ax + omega * vy, ay - omega * vx])


def test_no_rub_is_lost_and_none_invented():
    """Hundreds of random rotors, each against all roots of the polynomial to 50 digits."""
    count = 0
    for rotor in random_rotors(120, seed=1):
        found, expected = rubs_of(rotor), polynomial_roots(rotor)
        assert len(found) == len(expected), rotor
        for (amplitude, lag, *_), (exact, exact_lag) in zip(found, expected, strict=True):
            assert abs(amplitude / exact - 1) < ROUNDING, rotor
            assert abs(lag / exact_lag - 1) < ROUNDING, rotor
            count += 1
    assert count > 70


def test_amplitudes_are_those_of_a_scan_over_the_amplitude():
    """The equation as it is stated, bracketed on a fine grid and solved by Brent's method."""
    for rotor in random_rotors(60, seed=2):
        w, z, d, k, n, mu, _ = rotor.values()

        def excess(A, w=w, z=z, d=d, k=k, n=n, mu=mu):
            f = np.maximum(A - d, 0.0) ** n
            return np.hypot((k - w**2) * A + f, 2.0 * z * w * A + mu * f) - w**2

        grid = d + np.geomspace(1e-9, 1e3, 20_001)
        signs = np.sign(excess(grid))
        scanned = [
            brentq(excess, grid[i], grid[i + 1], xtol=1e-300, rtol=1e-14)
            for i in np.nonzero(signs[1:] != signs[:-1])[0]
        ]
        found = [row[0] for row in rubs_of(rotor)]
        # the rounded residual loses a digit or more near a fold
        np.testing.assert_allclose(found, scanned, rtol=1e-10, err_msg=str(rotor))


def test_known_rub_is_unstable_by_a_pair_that_oscillates():
    """A whirl with D > 0 that friction takes its stability nonetheless."""
    known = {"omega": 1.2, "zeta": 0.07, "delta0": 0.5, "friction": 0.1}
    ((amplitude, _, stability, _, growth),) = rubs_of(known)
    assert amplitude == pytest.approx(3.9010286365, abs=1e-10)
    assert growth == pytest.approx(0.0029651, abs=1e-7)
    assert stability == STABILITY["unstable"]
    assert stability_determinant(amplitude, **known) > 0.0
    leading = eigenvalues(amplitude, **known)
    assert abs(leading[leading.real.argmax()].imag) > 1.0


@pytest.mark.parametrize("with_damping", [False, True])
def test_eigenvalues_are_those_of_the_stated_motion(with_damping):
    """Its field vanishes at each rub; its Jacobian, by complex steps, has the eigenvalues."""
    count = 0
    for rotor in random_rotors(100, seed=3, with_damping=with_damping):
        for amplitude, lag, stability, _, growth in rubs_of(rotor):
            if amplitude - rotor["delta0"] < 1e-6:
                continue
            z = amplitude * np.exp(-1j * lag)
            v = 1j * rotor["omega"] * z
            state = np.array([z.real, z.imag, v.real, v.imag])
            size = max(1.0, rotor["omega"] ** 2 * amplitude)
            assert np.abs(field(state, rotor)).max() < 1e-12 * size
            steps = [field(state + 1e-30j * unit, rotor).imag / 1e-30 for unit in np.eye(4)]
            jacobian = np.stack(steps, axis=1)
            expected = np.linalg.eigvals(jacobian)
            scale = max(1.0, np.abs(expected).max())
            found = eigenvalues(amplitude, **rotor)
            assert max(np.abs(expected - each).min() for each in found) < 1e-11 * scale
            determinant = stability_determinant(amplitude, **rotor)
            assert determinant == pytest.approx(np.linalg.det(jacobian), abs=1e-11 * scale**4)
            assert growth == pytest.approx(expected.real.max(), abs=1e-11 * scale)
            if abs(expected.real.max()) > 1e-11 * scale:
                lasts = stability == STABILITY["stable"]
                assert lasts == (expected.real.max() < 0.0)
                count += 1
    assert count > 50


def test_without_damping_friction_drives_every_whirl_in_contact():
    """The eigenvalues add up to 0 and are not all imaginary, so one has a positive real part."""
    found = synchronous_response(
        omega=[0.5, 1.2, 3.0], zeta=0.0, delta0=[0.5, 2.0], friction=[0.0, 1e-12, 0.3]
    )
    touching = found.where(found.in_contact == 1)
    rubbing, smooth = touching.sel(friction=[1e-12, 0.3]), touching.sel(friction=0.0)
    assert set(np.unique(rubbing.stability)) - {np.nan} >= {STABILITY["unstable"]}
    assert not (rubbing.stability == STABILITY["stable"]).any()
    assert not (rubbing.stability == STABILITY["neutral"]).any()
    assert (smooth.stability == STABILITY["neutral"]).any()


def test_without_friction_nothing_changes_to_the_last_bit():
    """On an axis of frictions, where the rows of 0 are beside others, as without the argument."""
    given = {
        "omega": np.geomspace(0.1, 5.0, 40),
        "zeta": [0.0, 0.07],
        "delta0": [0.5, 2.0],
        "shaft_stiffness": [0.0, 0.3],
        "contact_exponent": [1.0, 1.5],
    }
    plain = synchronous_response(**given)
    beside = synchronous_response(**given, friction=[0.0, 0.2]).sel(friction=0.0, drop=True)
    present = plain.sizes["branch"]
    for name in NAMES:
        np.testing.assert_array_equal(beside[name].values[..., :present], plain[name].values)
    assert synchronous_response(**given, friction=0.0).identical(plain)


def test_friction_is_a_dimension_or_a_coordinate():
    axis = synchronous_response(omega=1.2, zeta=0.07, delta0=0.5, friction=[0.0, 0.1])
    assert axis.amplitude.dims == ("omega", "zeta", "delta0", "friction", "branch")
    number = synchronous_response(omega=1.2, zeta=0.07, delta0=0.5, friction=0.1)
    assert number.friction.item() == 0.1
    assert number.amplitude.dims == ("omega", "zeta", "delta0", "branch")
    assert "friction" not in synchronous_response(omega=1.2, zeta=0.07, delta0=0.5).coords


@pytest.mark.parametrize(
    ("given", "says"),
    [
        ({"friction": -0.1}, "friction must be zero or positive, got -0.1"),
        ({"friction": np.nan}, "friction must be"),
        ({"delta0": 0.0}, "friction must be 0 without clearance.*got 0.1 with delta0 0.0"),
    ],
)
def test_odd_values_are_refused(given, says):
    with pytest.raises(InputError, match=says):
        synchronous_response(
            **({"omega": 1.2, "zeta": 0.07, "delta0": 0.5, "friction": 0.1} | given)
        )
