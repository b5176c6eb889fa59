"""Rest under a load, against mpmath and a numerically differentiated motion."""

from __future__ import annotations

import itertools
from dataclasses import replace

import mpmath
import numpy as np
import pytest

from rotor_ida import Rotor, rest, simulate
from rotor_ida.closed_forms import synchronous_response
from rotor_ida.errors import InputError
from rotor_ida.model.disc_starts import hanging
from rotor_ida.schema import STABILITY
from tests.witness import FLIES, FORWARDS, Disc


def motion(state, rotor: Rotor) -> np.ndarray:
    mode = FORWARDS if np.hypot(*state[:2]) > rotor.delta0 else FLIES
    return Disc(rotor).turning([*state, 0.0], mode)[:4]


def rotors() -> list[Rotor]:
    grid = itertools.product([0.05, 0.8], [0.5, 2.0], [0.0, 0.1, 1.0], [1.5, 1.0], [0.0, 0.7])
    return [
        Rotor(
            omega=0.0,
            zeta=zeta,
            delta0=delta0,
            shaft_stiffness=kappa,
            contact_exponent=exponent,
            contact_damping=damping,
            load=1.3,
        )
        for zeta, delta0, kappa, exponent, damping in grid
    ]


def test_depth_holds_to_rounding():
    deep = 0
    for rotor in rotors():
        kappa, d = mpmath.mpf(rotor.shaft_stiffness), mpmath.mpf(rotor.delta0)
        n, load = mpmath.mpf(rotor.contact_exponent), mpmath.mpf(rotor.load)
        found = rest(rotor)
        if kappa * d >= load:
            assert found.indentation.item() == 0.0
            assert found.y.item() == -rotor.load / rotor.shaft_stiffness
            continue
        with mpmath.workdps(40):
            balance = load - kappa * d
            depth = mpmath.findroot(lambda h: kappa * h + h**n - balance, (0, 2), solver="anderson")  # noqa: B023
        assert abs(found.indentation.item() / depth - 1) < 1e-14, rotor
        assert abs(found.y.item() / -(d + depth) - 1) < 1e-14, rotor
        deep += 1
    assert 0 < deep < len(rotors())


def test_a_load_that_just_reaches_the_ring_loses_no_digits():
    load = np.nextafter(0.3 * 0.7, 1.0)
    found = rest(Rotor(omega=0.0, zeta=0.1, delta0=0.7, shaft_stiffness=0.3, load=load))
    with mpmath.workdps(40):
        excess = mpmath.mpf(load) - mpmath.mpf(0.3) * mpmath.mpf(0.7)
        assert 0 < excess < 1e-15
        u = mpmath.findroot(lambda u: u**3 + mpmath.mpf(0.3) * u**2 - excess, 1e-8)
        assert abs(found.indentation.item() / u**2 - 1) < 1e-14


def test_growth_and_frequencies_are_those_of_the_differentiated_motion():
    for rotor in rotors():
        found = rest(rotor)
        place = np.array([0.0, found.y.item(), 0.0, 0.0])
        assert np.abs(motion(place, rotor)).max() < 1e-14
        steps = 1e-6 * np.eye(4)
        matrix = np.stack(
            [(motion(place + h, rotor) - motion(place - h, rotor)) / 2e-6 for h in steps], axis=1
        )
        rates = np.linalg.eigvals(matrix)
        assert found.growth_rate.item() == pytest.approx(rates.real.max(), abs=2e-7), rotor
        assert found.stability.item() == STABILITY["stable"]
        # x is across the radius here, y along it
        assert found.tangential_frequency.item() ** 2 == pytest.approx(-matrix[2, 0], abs=1e-7)
        assert found.radial_frequency.item() ** 2 == pytest.approx(-matrix[3, 1], abs=1e-7)


@pytest.mark.parametrize("kappa", [0.0, 0.3])
@pytest.mark.parametrize("delta0", [0.0, 1.0])
@pytest.mark.parametrize("exponent", [1.5, 1.0])
def test_without_a_load_it_rests_like_a_whirl_at_no_speed(kappa, delta0, exponent):
    given = {"zeta": 0.2, "delta0": delta0, "shaft_stiffness": kappa, "contact_exponent": exponent}
    found, whirl = rest(Rotor(omega=0.0, **given)), synchronous_response(omega=0.0, **given)
    assert found.y.item() == 0.0
    assert found.stability.item() == whirl.stability.item()
    assert found.growth_rate.item() == whirl.growth_rate.item()


def test_without_damping_rest_is_neutral():
    found = rest(Rotor(omega=0.0, zeta=0.0, delta0=0.5, load=1.0))
    assert found.stability.item() == STABILITY["neutral"]
    # contact damping slows what moves along the radius alone
    found = rest(Rotor(omega=0.0, zeta=0.0, delta0=0.5, load=1.0, contact_damping=1.0))
    assert found.stability.item() == STABILITY["neutral"]


def test_what_is_no_rotor_or_too_large_is_refused():
    with pytest.raises(InputError, match="rest takes a Rotor or DimensionalRotor first"):
        rest(1.0)
    with pytest.raises(InputError, match="load must be at most 1e\\+15, got 1e\\+16"):
        rest(Rotor(omega=0.0, zeta=0.0, delta0=0.5, load=1e16))


@pytest.mark.parametrize("exponent", [1.5, 1.0])
@pytest.mark.parametrize("kappa", [0.0, 0.1, 5.0])
def test_a_rotor_that_spins_in_friction_hangs_where_it_stays(exponent: float, kappa: float):
    """Forces balance; a run from there stays, but for the unbalance of order omega**2."""
    rotor = Rotor(
        omega=1e-4, zeta=0.3, delta0=0.5, shaft_stiffness=kappa, contact_exponent=exponent,
        friction=0.3, disc_radius=10.0, load=1.3,
    )  # fmt: skip
    start = hanging(rotor)
    z = complex(*start[:2])
    normal = max(abs(z) - 0.5, 0.0) ** exponent
    left = kappa * z + normal * (1 + 0.3j) * z / abs(z) + 1.3j
    assert abs(left) < 1e-14
    assert (z.real < 0.0) == (normal > 0.0)  # climbs against the spin
    run = simulate(rotor, start=start, duration=20.0, method="taylor")
    assert np.abs(run.x + 1j * run.y - z).max() < 1e-6
    assert hanging(replace(rotor, omega=0.0)) == (
        0.0, rest(replace(rotor, friction=0.0, disc_radius=None)).y.item(), 0.0, 0.0
    )  # fmt: skip
