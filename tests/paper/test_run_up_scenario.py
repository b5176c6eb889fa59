"""The scenario run_up: each simulated figure lies on what is known exactly."""

import numpy as np
import pytest

from rotor_ida.closed_forms import sommerfeld_curve
from rotor_ida.paper.scenario import Settings
from rotor_ida.schema import STABILITY
from tests.scenarios import scenario


@pytest.fixture(scope="module")
def module():
    return scenario("run_up")


@pytest.fixture
def quick(tmp_path):
    return Settings(tmp_path, True, 1, False)


def test_flights_lie_on_error_functions_and_tend_to_lewis_limit(module, quick):
    assert float(module.flights(quick).deviation.max()) < 1e-11
    passed = module.through_resonance(quick)
    # what is left falls as the root of the rate, to half from the one to the other
    left = passed.height.values - module.LEWIS["height"]
    assert left[0] / left[1] == pytest.approx(2.0, rel=0.02)
    np.testing.assert_allclose(passed.place, module.LEWIS["place"], atol=1e-3)


def test_jumps_are_as_late_as_the_law_says_but_for_less_than_it(module, quick):
    """What is left over the rate grows with ln(1/rate), ever nearer to the exact slope."""
    late = module.jumps(quick)
    delay, law = (np.abs(late[name] - late.passed_omega) for name in ("found_omega", "law_omega"))
    left = ((delay - law) / late.rate).transpose("case", "rate").values
    slopes = np.diff(left, axis=1) / np.log(10.0)
    off = np.abs(slopes / late.fold_remainder.values[:, None] - 1.0)
    assert (off[:, 1] < 0.65 * off[:, 0]).all()
    assert off[:, 1].max() < 0.35
    shares = np.abs((delay - law) / law).transpose("case", "rate").values
    assert (shares[:, -1] < shares[:, 0]).all()


def test_run_ups_fall_off_beyond_the_upper_fold_and_run_downs_rise_below_the_lower(module, quick):
    courses = module.hysteresis(quick)
    down, up = module.folds(**module.RUB).fold_omega.values.ravel()[2:]
    rate = courses.rate.values[0]
    assert module.jump_of(courses.sel(rate=rate, way=1)) > up
    assert module.jump_of(courses.sel(rate=rate, way=-1)) < down


def test_drives_settle_on_stable_parts_of_sommerfelds_curve_and_jump(module, quick):
    settled = module.settled_speeds(quick)
    assert float(np.abs(settled.missed_torque).max()) < 1e-8
    curve = sommerfeld_curve(**module.DRIVEN, **module.MOTOR, limits=(0.1, 6.0), points=1000)
    speed, radius = curve.omega.values.ravel(), curve.amplitude.values.ravel()
    for each in range(settled.sizes["step"]):
        at = settled.isel(step=each)
        near = np.nanargmin(np.hypot(speed - at.speed.item(), radius - at.radius.item()))
        assert curve.driven_stability.values.ravel()[near] == STABILITY["stable"]
    raised, lowered = module.limits_of(curve.isel(zeta=0, delta0=0))
    fast = settled.speed.values > 1.5
    turn = settled.sizes["step"] // 2
    torque = settled.tau0.values
    assert (fast[: turn + 1] == (torque[: turn + 1] > raised)).all()
    assert (fast[turn:] == (torque[turn:] > lowered)).all()
