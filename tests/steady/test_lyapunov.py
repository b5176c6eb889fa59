"""Lyapunov exponents at each point of a grid: of one disc, of a machine, and of a rotor system."""

import numpy as np
import pytest

from rotor_ida import InputError, Rotor, lyapunov_exponent

RUB = Rotor(omega=1.2, zeta=0.07, delta0=0.5, disc_radius=5.0)
SHORT = {"transient": 50.0, "duration": 200.0, "batches": 4}
FEW = {"transient": 10, "revolutions": 80, "batches": 4}


def test_each_point_is_that_of_one_motion():
    found = lyapunov_exponent(RUB, friction=[0.0, 0.1], delta0=[0.5, 1.0], **SHORT)
    assert found.lyapunov_exponent.dims == ("delta0", "friction", "exponent")
    for friction in (0.0, 0.1):
        alone = lyapunov_exponent(RUB, friction=friction, delta0=1.0, **SHORT)
        point = found.sel(friction=friction, delta0=1.0)
        for name in ("lyapunov_exponent", "lyapunov_error", "exponent_sum", "divergence"):
            np.testing.assert_array_equal(point[name], alone[name])
    assert "running_exponent" in alone
    assert "running_exponent" not in found


def test_each_point_of_a_system_is_that_of_one_motion():
    system = RUB.system()
    found = lyapunov_exponent(system, speed=[1.2, 1.5], friction=[0.0, 0.1], exponents=2, **FEW)
    assert found.lyapunov_exponent.dims == ("speed", "friction", "exponent")
    alone = lyapunov_exponent(system, speed=1.5, friction=0.1, exponents=2, **FEW)
    assert alone.lyapunov_exponent.dims == ("exponent",)
    point = found.sel(speed=1.5, friction=0.1)
    for name in ("lyapunov_exponent", "lyapunov_error"):
        np.testing.assert_array_equal(point[name], alone[name])
    assert found.friction.attrs["long_name"] == "largest friction coefficient of the contacts"


def test_a_resonance_has_no_settled_start_and_says_so():
    free = {"contacts": [], "start": "settled", **FEW}
    system = Rotor(omega=1.0, zeta=0.0, delta0=0.5, shaft_stiffness=1.0).system()
    found = lyapunov_exponent(system, speed=[0.5, 1.0], **free)
    assert found.status.values.tolist() == [0, 1]
    assert "start cannot be settled" in found.message.values[1]


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"zeta": [0.1, 0.1]}, "zeta must have each value once, got 0.1 twice"),
        ({"omega": -1.0}, "omega must be zero or positive, got -1.0"),
        ({"study": "s"}, "study must be left out of one motion, got 's'"),
        ({"duration": [1.0, 2.0]}, "duration must be a finite real number"),
    ],
)
def test_bad_input_is_refused_in_one_line(changes, message):
    with pytest.raises(InputError, match=message) as caught:
        lyapunov_exponent(RUB, **SHORT | changes)
    assert "\n" not in str(caught.value)
