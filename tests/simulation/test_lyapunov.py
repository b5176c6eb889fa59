"""Lyapunov exponents against closed forms, conserved sums and each other."""

from dataclasses import replace

import numpy as np
import pytest

from rotor_ida import InputError, Rotor, SimulationError, lyapunov_exponent, synchronous_response
from rotor_ida.closed_forms import eigenvalues
from rotor_ida.core import sundials
from rotor_ida.core.interface import STUCK
from rotor_ida.core.runs import stretch
from rotor_ida.simulation import lyapunov

REST = (0.0, 0.0, 0.0, 0.0)
BOUNCING = Rotor(omega=2.0, zeta=0.07, delta0=2.0)
FULL_CONTACT = Rotor(omega=3.0, zeta=0.07, delta0=0.5)
# Chaos that lasts: the same for 200,000 units of time, from starts that differ by 1e-3, and its
# largest exponent by two programs that share nothing.
CHAOTIC = Rotor(omega=1.38, zeta=0.07, delta0=1.0)
EXPONENT = 0.0362


def starts_in_chaos(count):
    """Starts beside each other, whose motions differ soon: a mean over them is no accident."""
    shifts = np.random.default_rng(1).uniform(-1e-3, 1e-3, (count, 2))
    return [(1.5 + x, -0.25 + y, 0.0, 0.0) for x, y in shifts.tolist()]


@pytest.mark.parametrize(
    ("rotor", "digits"),
    [
        (Rotor(omega=1.7, zeta=0.07, delta0=0.0), 7),
        (Rotor(omega=1.2, zeta=0.07, delta0=0.5), 7),
        (Rotor(omega=0.3, zeta=2.0, delta0=0.0), 6),
    ],
)
def test_of_a_synchronous_whirl_are_the_real_parts_of_its_eigenvalues(rotor, digits):
    """Two spirals, and an overdamped node whose four rates differ."""
    found = lyapunov_exponent(rotor, start=REST)
    parameters = {"omega": rotor.omega, "zeta": rotor.zeta, "delta0": rotor.delta0}
    amplitude = synchronous_response(**parameters).amplitude.values.ravel()
    # the stable whirls that rest leads to are the smallest here, where there are several
    rates = eigenvalues(np.nanmin(amplitude), **parameters).real
    expected = np.sort(rates)[::-1]
    np.testing.assert_allclose(found.lyapunov_exponent, expected, rtol=0.0, atol=10.0**-digits)


def test_contact_free_whirl_is_neutral():
    """Its centre may be anywhere: 0 twice, and -2 zeta twice."""
    found = lyapunov_exponent(Rotor(omega=1.0, zeta=0.1, delta0=3.0), start=REST)
    np.testing.assert_allclose(found.lyapunov_exponent, [0.0, 0.0, -0.2, -0.2], atol=1e-9)


@pytest.mark.parametrize("rotor", [BOUNCING, FULL_CONTACT])
def test_limit_cycles_on_rotating_axes_have_one_exponent_of_zero(rotor):
    found = lyapunov_exponent(rotor, start=REST)
    value, error = found.lyapunov_exponent.values, found.lyapunov_error.values
    assert abs(value[0]) <= 3.0 * error[0]
    assert error[0] < 1e-6
    assert (value[1:] < -0.05).all()


@pytest.mark.parametrize(
    ("rotor", "start"), [(BOUNCING, REST), (FULL_CONTACT, REST), (CHAOTIC, starts_in_chaos(1)[0])]
)
def test_sums_are_those_of_the_damping(rotor, start):
    """Liouville for all four, and the pairs of a system with uniform damping (Dressler 1988)."""
    found = lyapunov_exponent(rotor, start=start, duration=2000.0)
    assert found.divergence.item() == -4.0 * rotor.zeta
    assert found.exponent_sum.item() == pytest.approx(-4.0 * rotor.zeta, abs=1e-9)
    first, second, third, last = found.lyapunov_exponent.values
    assert first + last == pytest.approx(-2.0 * rotor.zeta, abs=1e-6)
    assert second + third == pytest.approx(-2.0 * rotor.zeta, abs=1e-6)


def test_in_chaos_the_exponent_is_the_known_one_and_its_error_falls_with_the_time():
    """Nine means over 8,000 scatter by 0.0011 and state 0.002 each.

    One stated error scatters by a third, the mean of nine by a tenth. From 1,000 to 8,000 it should
    fall to a third, like the root of the time.
    """
    short, long = (
        [lyapunov_exponent(CHAOTIC, start=start, duration=time) for start in starts_in_chaos(9)]
        for time in (1000.0, 8000.0)
    )
    values = np.array([found.lyapunov_exponent.values for found in long])
    errors = np.array([found.lyapunov_error.values for found in long])
    assert (values[:, 0] > 5.0 * errors[:, 0]).all()
    assert (np.abs(values[:, 1]) < 4.0 * errors[:, 1] + 1e-3).all()
    assert values[:, 0].mean() == pytest.approx(EXPONENT, abs=0.003)
    scatter = np.sqrt(np.mean((values[:, 0] - EXPONENT) ** 2))
    assert 0.2 < scatter / errors[:, 0].mean() < 1.5
    before = np.mean([found.lyapunov_error.values[0] for found in short])
    assert errors[:, 0].mean() / before < 0.5


def test_running_mean_ends_near_the_exponent():
    found = lyapunov_exponent(FULL_CONTACT, start=REST, duration=1000.0)
    assert found.running_exponent.dims == ("t", "exponent")
    assert found.t.values[-1] == pytest.approx(1000.0)
    # a plain mean is off by an unfinished oscillation over the time
    difference = found.running_exponent.values[-1] - found.lyapunov_exponent.values
    assert np.abs(difference).max() < 5.0 / 1000.0


@pytest.mark.parametrize(
    ("wrong", "message"),
    [
        ({"duration": 10.0}, "duration must be at least 10 for each of 20 batches, got 10.0"),
        ({"batches": 3}, "batches must be at least 4, got 3"),
        ({"rtol": 1.0}, "rtol must lie from 1e-15 to 0.0001, got 1.0"),
        ({"rtol": 1e-14, "method": "adams"}, "rtol must lie from 1e-13 to 0.001, got 1e-14"),
        ({"method": "ida"}, "method must be one of 'taylor', 'adams', 'bdf', got 'ida'"),
        ({"transient": -1.0}, "transient must be positive, got -1.0"),
        ({"start": (0, 0, 0)}, "start must be four numbers"),
    ],
)
def test_bad_input_is_refused(wrong, message):
    with pytest.raises(InputError, match=message):
        lyapunov_exponent(BOUNCING, **{"start": REST, **wrong})
    with pytest.raises(InputError, match=r"as in lyapunov_exponent\(rotor\), got 2"):
        lyapunov_exponent(2, start=REST)


def test_where_cvode_cannot_be_called_taylor_series_can(monkeypatch):
    monkeypatch.setattr(sundials, "why_not", lambda: "the libraries were not found")
    with pytest.raises(InputError, match="CVODE with tangents cannot be used: the libraries were"):
        lyapunov_exponent(BOUNCING, start=REST, duration=200.0, method="adams")
    by_taylor = lyapunov_exponent(BOUNCING, start=REST, duration=200.0)
    assert np.isfinite(by_taylor.lyapunov_exponent).all()


def test_failure_says_where(monkeypatch):
    """A motion that cannot be followed raises; no number is made of what there is."""

    def stuck(asked, spans):
        stretches, seen = stretch(asked, 3)
        return stretches, replace(seen, status=STUCK, time=0.25)  # within the span after these

    monkeypatch.setattr(lyapunov, "stretch", stuck)
    message = r"could not be followed: time no longer advances \(at t = 1.75, state"
    with pytest.raises(SimulationError, match=message):
        lyapunov_exponent(BOUNCING, start=REST)


def test_stretching_that_is_no_number_is_no_result(monkeypatch):
    def spoilt(asked, spans):
        stretches, seen = stretch(asked, spans)
        stretches[7, 2] = np.nan
        return stretches, seen

    monkeypatch.setattr(lyapunov, "stretch", spoilt)
    with pytest.raises(SimulationError, match="the state is no longer finite"):
        lyapunov_exponent(BOUNCING, start=REST, transient=10.0, duration=200.0)
