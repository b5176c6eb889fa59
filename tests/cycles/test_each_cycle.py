"""Limit cycles at each point of a grid: of one disc, of a machine, and of a rotor system."""

import numpy as np
import pytest
import xarray as xr

from rotor_ida import (
    DimensionalRotor,
    InputError,
    Rotor,
    SimulationError,
    decode_flags,
    limit_cycle,
    resume,
)
from rotor_ida.cycles import each_cycle
from tests.cycles.known import BOUNCING, HIGHEST, PAIRS, multipliers, state_of

ROTOR = BOUNCING.rotor
SYSTEM = ROTOR.system()
OMEGA = [1.9, 2.0, 2.5]
MACHINE = DimensionalRotor(
    mass=4.0, contact_stiffness=1e9, damping=280.0, eccentricity=1e-6, clearance=2e-6, speed=1000.0
)
FRICTIONAL = Rotor(omega=1.0, zeta=0.1, delta0=1.0, friction=0.2, disc_radius=10.0)
WHIP = (6.928, 0.0, 0.0, -10.0)


def check_points(found, alone_at, dim):
    """Check that each point of a result along a dimension is that of a call of its own."""
    numbers = [name for name in found.data_vars if name not in {"status", "message"}]
    for at in found[dim].values.tolist():
        point, alone = found.sel({dim: at}), alone_at(at)
        for name in numbers:
            if "t" in alone[name].dims:  # the state at its start
                expected = alone[name].values[0] if alone.sizes["t"] else np.nan
            else:
                expected = alone[name].values
            np.testing.assert_allclose(point[name], expected, rtol=1e-10, atol=1e-12, err_msg=name)
            assert point[name].dtype == alone[name].dtype
            np.testing.assert_equal(found[name].attrs, alone[name].attrs)


def test_each_point_is_that_of_one_call():
    found = limit_cycle(ROTOR, omega=OMEGA)
    assert found.period.dims == ("omega",)
    assert found.multiplier_error.dims == ("omega", "multiplier")
    assert decode_flags(found.response).values.tolist() == ["bouncing", "bouncing", "contact_free"]
    assert decode_flags(found.status).values.tolist() == ["done"] * 3
    check_points(found, lambda omega: limit_cycle(ROTOR, omega=omega), "omega")
    alone = limit_cycle(ROTOR, omega=2.0)
    assert {*alone.data_vars} - {*found.data_vars} == {"frequency", "whirl_amplitude", "line_kind"}


def test_a_point_is_the_cycle_that_is_known():
    point = limit_cycle(ROTOR, omega=OMEGA, delta0=[1.9, 2.0]).sel(omega=2.0, delta0=2.0)
    assert abs(point.period - BOUNCING.period) < 1e-11
    assert abs(point.radius_max - HIGHEST[BOUNCING]) < 1e-9
    assert np.abs(multipliers(point) - PAIRS[BOUNCING]).min() < 1e-8


def test_the_multipliers_of_each_point_contract_volumes_as_the_damping_does():
    found = limit_cycle(ROTOR, omega=[1.9, 2.0], zeta=[0.068, 0.07])
    product = multipliers(found).prod(axis=-1)
    shrunk = np.exp(-4.0 * (found.zeta * found.period).transpose("omega", "zeta"))
    assert np.isfinite(found.period).all()
    np.testing.assert_allclose(product, shrunk, rtol=1e-9)


def test_a_rotor_system_of_one_disc_has_its_cycles():
    found, disc = limit_cycle(SYSTEM, speed=OMEGA), limit_cycle(ROTOR, omega=OMEGA)
    np.testing.assert_array_equal(found.response, disc.response)
    for name in ("period", "radius_min", "radius_max", "largest_force", "contact_count"):
        np.testing.assert_allclose(found[name].squeeze(), disc[name], rtol=1e-8, err_msg=name)
    np.testing.assert_allclose(multipliers(found), multipliers(disc), atol=1e-6)
    check_points(found, lambda speed: limit_cycle(SYSTEM, speed=speed), "speed")


def test_parameters_of_a_rotor_system_vary_beside_its_speed():
    system = FRICTIONAL.system()
    start = [np.array(WHIP[:2]), np.array(WHIP[2:])]
    found = limit_cycle(system, speed=[1.0], friction=[0.1, 0.2], start=start)
    assert found.radius_max.dims == ("speed", "friction", "contact")
    disc = limit_cycle(FRICTIONAL, friction=[0.1, 0.2], start=WHIP)
    assert decode_flags(disc.response).values.tolist() == ["synchronous", "rolling"]
    np.testing.assert_array_equal(found.response.isel(speed=0), disc.response)
    np.testing.assert_allclose(found.period.isel(speed=0), disc.period, rtol=1e-8)
    assert found.friction.attrs["long_name"] != disc.friction.attrs["long_name"]


def test_a_machine_has_its_own_parameters_and_seconds():
    speeds = [950.0, 1000.0]
    found = limit_cycle(MACHINE, speed=speeds, start="rest")
    rates = np.array(speeds) * MACHINE.time_scale
    plain = limit_cycle(MACHINE.rotor(), omega=rates, start="rest")
    assert np.isfinite(plain.period).all()
    assert found.period.attrs["units"] == "s"
    np.testing.assert_allclose(found.period, plain.period * MACHINE.time_scale, rtol=1e-12)
    np.testing.assert_allclose(found.radius_max, plain.radius_max * MACHINE.length_scale)
    by_name = limit_cycle(MACHINE, speed=speeds[0], start="rest")
    np.testing.assert_allclose(by_name.period, found.period[0], rtol=1e-12)


def test_a_cycle_is_a_guess_at_each_point_and_each_point_is_one():
    one = limit_cycle(ROTOR)
    found = limit_cycle(ROTOR, omega=OMEGA[:2], start=one)
    np.testing.assert_allclose(found.period, limit_cycle(ROTOR, omega=OMEGA[:2]).period, rtol=1e-9)
    again = limit_cycle(ROTOR, start=found.sel(omega=2.0))
    np.testing.assert_allclose(again.period, one.period, rtol=1e-12)
    np.testing.assert_allclose(state_of(again), state_of(one), atol=1e-9)
    of_system = limit_cycle(SYSTEM, speed=2.0)
    others = limit_cycle(SYSTEM, clearance=[1.95, 2.0], start=of_system)
    np.testing.assert_allclose(others.period[1], one.period, rtol=1e-8)
    back = limit_cycle(SYSTEM, start=others.isel(clearance=1))
    np.testing.assert_allclose(back.period, one.period, rtol=1e-8)


@pytest.mark.parametrize("given", [
    {"rotor": ROTOR, "omega": OMEGA}, {"rotor": SYSTEM, "speed": OMEGA, "start": "rest"},
], ids=["disc", "system"])  # fmt: skip
def test_a_study_of_them_is_resumed_to_the_same_bits(given, tmp_path):
    def give_up(done, _):
        if done == 1:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        limit_cycle(**given, study=tmp_path / "s", progress=give_up, executor="serial")
    calls = []
    found = resume(tmp_path / "s", progress=lambda *call: calls.append(call))
    assert calls[0] == (1, 3)
    assert calls[-1] == (3, 3)
    xr.testing.assert_identical(found, limit_cycle(**given, workers=2))


def test_a_point_that_fails_says_why(monkeypatch):
    def found_cycle(guess, stop):
        if guess.rotor.omega == 1.9:
            raise SimulationError("it was told to")
        return search(guess, stop)

    search = each_cycle.found_cycle
    monkeypatch.setattr(each_cycle, "found_cycle", found_cycle)
    found = limit_cycle(ROTOR, omega=OMEGA[:2], executor="serial")
    assert decode_flags(found.status).values.tolist() == ["failed", "done"]
    assert found.message.values.tolist() == ["it was told to", ""]
    assert decode_flags(found.response).values.tolist() == ["failed", "bouncing"]
    assert decode_flags(found.stability).values.tolist() == ["absent", "stable"]
    assert np.isnan(found.period[0])
    assert found.contact_count.values.tolist() == [0, 1]


@pytest.mark.parametrize(("rotor", "given", "words"), [
    (ROTOR, {"omega": [2.0, 2.0]}, "omega must have each value once"),
    (ROTOR, {"omega": [0.0, 1.0]}, "omega must be above 0 for a limit cycle, got 0.0"),
    (ROTOR, {"speed": [1.0, 2.0]}, "speed must be left out with one disc"),
    (ROTOR, {"frictoin": [0.1]}, "limit_cycle has no argument 'frictoin'; did you mean 'friction'"),
    (ROTOR, {"omega": OMEGA, "period": 1e9}, "period must lie from 1e-06 to 10000.0, got"),
    (ROTOR, {"study": "s"}, "study must be left out of one cycle, got 's'"),
    (MACHINE, {"omega": [1.0, 2.0]}, "omega must be left out with a machine: give its speed"),
    (SYSTEM, {"speed": [0.0, 1.0]}, "speed must not be 0 for a limit cycle"),
    (SYSTEM, {"friction": [0.0, 0.1], "speed": 2.0}, "radius of the contact at 'disc' must be"),
    (SYSTEM, {"clearance": [1.0, 2.0]}, "speed must be given for a limit cycle of a system"),
    (SYSTEM, {"damping": [0.0, 1.0], "speed": 2.0}, "damping must be above 0 for a limit cycle"),
    (SYSTEM, {"study": "s", "speed": 2.0}, "study must be left out of one cycle"),
])  # fmt: skip
def test_what_cannot_be_asked_is_refused(rotor, given, words):
    with pytest.raises(InputError, match=words):
        limit_cycle(rotor, **given)
