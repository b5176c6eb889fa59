"""On what machines settle: whirls of the closed forms, cycles, and touches that fade."""

import numpy as np
import pytest

from rotor_ida import Rotor, limit_cycle, lyapunov_exponent, simulate, sweep, synchronous_response
from rotor_ida.closed_forms import touch_fading
from rotor_ida.closed_forms.contact_free import complex_amplitude
from rotor_ida.schema import RESPONSE, STABILITY

MACHINES = {
    "shaft": {"shaft_stiffness": 0.3},
    "shaft and linear contact": {"shaft_stiffness": 1.0, "contact_exponent": 1.0},
    "linear contact with damping": {"contact_exponent": 1.0, "contact_damping": 0.2},
    "shaft and contact damping": {"shaft_stiffness": 0.5, "contact_damping": 1.0},
}
STEADY = {RESPONSE["contact_free"], RESPONSE["synchronous"]}


@pytest.mark.parametrize("name", MACHINES)
def test_what_whirls_steadily_is_a_stable_whirl_of_the_closed_forms(name):
    ranges = {"omega": np.linspace(0.3, 2.6, 24), "zeta": 0.1, "delta0": [0.5, 2.0]}
    found = sweep(**ranges, method="taylor", **MACHINES[name])
    exact = synchronous_response(**ranges, **MACHINES[name])
    exact = exact.transpose("omega", "delta0", "zeta", "branch")
    found = found.transpose("omega", "delta0", "zeta", "start", "direction", "event")
    seen = 0
    for place in np.ndindex(24, 2):
        amplitude = found.amplitude.values[place].item()
        if found.response.values[place].item() in STEADY:
            apart = np.abs(exact.amplitude.values[place][0] / amplitude - 1.0)
            nearest = int(np.nanargmin(apart))
            assert apart[nearest] < 1e-9
            assert exact.stability.values[place][0][nearest] != STABILITY["unstable"]
            seen += 1
    assert seen > 30


def test_axes_of_a_sweep_are_dimensions_and_numbers_coordinates():
    plain = {"omega": [1.2, 1.7], "zeta": 0.5, "delta0": 0.5, "method": "taylor"}
    found = sweep(**plain, shaft_stiffness=[0.0, 0.3], contact_exponent=1.0, contact_damping=0.0)
    assert found.amplitude.dims == (
        "omega", "zeta", "delta0", "shaft_stiffness", "start", "direction",
    )  # fmt: skip
    assert found.contact_exponent.item() == 1.0
    assert "contact_damping" not in found.coords
    assert "load" not in found.coords
    alone = sweep(**plain, shaft_stiffness=0.3, contact_exponent=1.0)
    assert (found.amplitude.sel(shaft_stiffness=0.3).values == alone.amplitude.values).all()
    assert alone.shaft_stiffness.item() == 0.3


@pytest.mark.parametrize(
    "machine",
    [
        Rotor(omega=2.0, zeta=0.07, delta0=2.0, shaft_stiffness=0.05),
        Rotor(omega=1.6, zeta=0.07, delta0=2.0, shaft_stiffness=0.02, contact_exponent=1.0),
        Rotor(omega=1.8, zeta=0.07, delta0=2.0, contact_damping=0.1),
        Rotor(omega=1.6, zeta=0.07, delta0=2.0, contact_damping=2.0, contact_exponent=1.0),
    ],
    ids=["shaft", "linear contact", "contact damping", "release and press"],
)
def test_a_cycle_closes_and_its_multipliers_are_those_of_differences(machine):
    cycle = limit_cycle(machine, start=(0, 0, 0, 0))
    period = cycle.period.item()
    assert cycle.stability.item() == STABILITY["stable"]
    assert cycle.residual.item() < 1e-13
    assert cycle.trivial_defect.item() < 1e-13
    if machine.contact_damping:
        assert np.isnan(cycle.symplectic_defect.item())
    else:
        assert cycle.symplectic_defect.item() < 1e-13
    state = np.array([cycle[name].values[0] for name in ("x", "y", "vx", "vy")])
    tight = {"duration": period, "samples": [period], "method": "adams", "rtol": 1e-13,
             "atol": 1e-15}  # fmt: skip
    back = np.kron(np.eye(2), np.array([
        [np.cos(machine.omega * period), np.sin(machine.omega * period)],
        [-np.sin(machine.omega * period), np.cos(machine.omega * period)],
    ]))  # fmt: skip

    def once_round(start):
        run = simulate(machine, start=start, **tight)
        return back @ np.array([run[name].values[-1] for name in ("x", "y", "vx", "vy")])

    assert np.abs(once_round(state) - state).max() < 1e-10
    step = 1e-5
    columns = [
        (once_round(state + step * unit) - once_round(state - step * unit)) / (2.0 * step)
        for unit in np.eye(4)
    ]
    expected = np.linalg.eigvals(np.array(columns).T)
    found = cycle.multiplier_real.values + 1j * cycle.multiplier_imag.values
    for multiplier in found:
        assert np.abs(expected - multiplier).min() < 1e-5


def test_touches_of_a_linear_contact_fade_by_their_own_law():
    """1/sqrt(h) grows by sqrt(2/kappa)/(3 zeta) from touch to touch."""
    for omega, damping in ((0.5, 0.0), (2.28, 0.5), (2.94, 0.0)):
        machine = Rotor(
            omega=omega, zeta=0.07, delta0=2.0, contact_exponent=1.0, contact_damping=damping
        )
        whirl = complex(complex_amplitude(omega, 0.07))
        start, velocity = whirl + 2.0 - abs(whirl) + 1e-6, 1j * omega * whirl
        run = simulate(
            machine, start=(start.real, start.imag, velocity.real, velocity.imag),
            duration=2500.0, samples=2, method="taylor",
        )  # fmt: skip
        growth = np.diff(run.peak_indentation.values[-40:] ** -0.5)
        assert growth.mean() == pytest.approx(touch_fading(machine), rel=0.02)


def test_exponents_add_up_to_the_divergence_also_under_a_load():
    machine = Rotor(omega=1.2, zeta=0.07, delta0=0.5, shaft_stiffness=0.3, load=0.3)
    found = lyapunov_exponent(machine, start=(0, 0, 0, 0), duration=500.0)
    assert found.exponent_sum.item() == pytest.approx(-0.28, abs=1e-9)
    assert found.divergence.item() == -0.28
    damped = Rotor(omega=1.2, zeta=0.07, delta0=0.5, contact_damping=0.5)
    found = lyapunov_exponent(damped, start=(0, 0, 0, 0), duration=500.0)
    assert np.isnan(found.divergence.item())
    assert found.exponent_sum.item() < -1.0
    # on a synchronous whirl they are the real parts of its eigenvalues
    exact = synchronous_response(omega=1.2, zeta=0.07, delta0=0.5, contact_damping=0.5)
    slowest = float(exact.growth_rate.max())
    assert found.lyapunov_exponent.values[0] == pytest.approx(slowest, abs=2e-3)
