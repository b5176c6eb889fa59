"""The "general solution" meets the start and nothing after it."""

import numpy as np
import pytest

from rotor_ida import InputError, Rotor, simulate, synchronous_response
from rotor_ida.paper.printed import general_solution

START = (10.0, 1.0, 0.5, -0.3)
LARGE = 9.487206945659
GIVEN = {"omega": 1.7, "zeta": 0.07, "amplitude": LARGE}
CHOICES = [
    {}, {"mended": True}, {"rates": "24"}, {"mended": True, "rates": "stiffness"},
]  # fmt: skip


@pytest.mark.parametrize("choice", CHOICES)
def test_it_has_the_place_and_speed_of_the_start(choice):
    step = 1e-6
    before, at, after = general_solution([-step, 0.0, step], start=START, **GIVEN, **choice)
    assert at == pytest.approx(complex(10.0, 1.0))
    assert (after - before) / (2.0 * step) == pytest.approx(complex(0.5, -0.3), abs=1e-6)


def test_it_is_no_solution_of_the_equation():
    run = simulate(
        Rotor(omega=1.7, zeta=0.07, delta0=0.0), start=(10, 0, 0, 0), duration=5.0, samples=501
    )
    z = run.x.values + 1j * run.y.values
    errors = {}
    for mended in (False, True):
        solution = general_solution(run.t.values, start=(10, 0, 0, 0), mended=mended, **GIVEN)
        errors[mended] = abs(solution - z)[-1]
    assert errors[False] == pytest.approx(17.995, abs=1e-3)
    assert errors[True] == pytest.approx(18.384, abs=1e-3)


def test_mended_signs_bring_it_to_the_whirl_and_printed_ones_do_not():
    whirl = synchronous_response(omega=1.7, zeta=0.07, delta0=0.0).isel(branch=2)
    time = 200.0
    lag = whirl.phase_lag.item()
    right = whirl.amplitude.item() * np.exp(1j * (1.7 * time - lag))
    mended, printed = (
        general_solution(time, start=START, mended=mended, **GIVEN) for mended in (True, False)
    )
    assert abs(mended - right) < 1e-4
    assert abs(printed - right) > 10.0


def test_exponents_under_eq_24_blow_up():
    late = general_solution(30.0, start=START, rates="24", **GIVEN)
    assert abs(late) > 1e10


def test_bad_values_are_refused():
    with pytest.raises(InputError, match="zeta must not make the two exponents one"):
        general_solution(0.0, start=START, omega=1.7, zeta=1.0, amplitude=2.0)
    with pytest.raises(InputError, match="rates must be one of '28', '24', 'stiffness'"):
        general_solution(0.0, start=START, rates="23", **GIVEN)
