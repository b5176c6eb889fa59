"""Closed-form eigenvalues against those of the linearised motion, found numerically."""

from __future__ import annotations

import numpy as np
import pytest

from rotor_ida import Rotor
from rotor_ida.closed_forms import eigenvalues, stability_determinant, synchronous_response
from rotor_ida.errors import InputError
from rotor_ida.schema import STABILITY
from tests.witness import Disc

NAMES = ("amplitude", "phase_lag", "stability", "in_contact", "growth_rate")


def random_rotors(count, seed, *, friction, contact_damping):
    """Parameters over many orders of magnitude; a tenth without damping, half with a shaft."""
    draw = np.random.default_rng(seed)
    for _ in range(count):
        yield {
            "omega": 10 ** draw.uniform(-1.0, 1.0),
            "zeta": 10 ** draw.uniform(-3.0, 0.0) * (draw.random() > 0.1),
            "delta0": 10 ** draw.uniform(-2.0, 1.0),
            "shaft_stiffness": float(draw.choice([0.0, 10 ** draw.uniform(-2.0, 1.0)])),
            "contact_exponent": float(draw.choice([1.5, 1.0])),
            "friction": 10 ** draw.uniform(-3.0, 0.5) * friction,
            "contact_damping": 10 ** draw.uniform(-2.0, 0.5) * contact_damping,
        }


def whirls_of(rotor):
    """The whirls in contact, a row each."""
    found = synchronous_response(**rotor)
    columns = [found[name].values.ravel() for name in NAMES]
    return [row for row in zip(*columns, strict=True) if row[3] == 1]


def field(state, rotor):
    """The stated motion on the rotating axes; takes complex states.

    The state is the displacement and the velocity on the fixed axes, both on the rotating ones.
    """
    return disc_of(rotor).turning([*state, rotor["omega"]])[:4]


def disc_of(rotor):
    radius = {"disc_radius": 10.0} if rotor["friction"] else {}
    return Disc(Rotor(**rotor, **radius))


@pytest.mark.parametrize("friction", [False, True])
@pytest.mark.parametrize("contact_damping", [False, True])
def test_eigenvalues_are_those_of_the_stated_motion(friction, contact_damping):
    """Its field vanishes at each whirl; its Jacobian, by complex steps, has the eigenvalues."""
    count = 0
    kinds = {"friction": friction, "contact_damping": contact_damping}
    for rotor in random_rotors(120, seed=3, **kinds):
        for amplitude, lag, stability, _, growth in whirls_of(rotor):
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
                assert (stability == STABILITY["stable"]) == (expected.real.max() < 0.0)
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


def test_contact_free_whirl_has_a_zero_eigenvalue():
    # the centre stays where it is: a zero eigenvalue in the fixed frame is +-i omega here
    found = eigenvalues(0.5, omega=1.7, zeta=0.3, delta0=1.0)
    np.testing.assert_allclose(
        np.sort_complex(found), np.sort_complex([1.7j, -1.7j, -0.6 + 1.7j, -0.6 - 1.7j]), atol=1e-15
    )


@pytest.mark.parametrize("zeta", [0.02, 0.07, 0.9])
@pytest.mark.parametrize("kappa", [1e-4, 0.25, 2.0])
def test_a_shaft_holds_the_contact_free_whirl(zeta, kappa):
    whirls = synchronous_response(omega=5.0, zeta=zeta, delta0=3.0, shaft_stiffness=kappa)
    free = whirls.isel(branch=0)
    assert free.in_contact.item() == 0
    assert free.stability.item() == STABILITY["stable"]
    # z'' + 2 zeta z' + kappa z = 0 about the whirl, in the fixed frame
    expected = np.roots([1.0, 2.0 * zeta, kappa]).real.max()
    assert free.growth_rate.item() == pytest.approx(expected, rel=1e-8)


def test_a_contact_free_whirl_is_neutral_without_damping_or_without_a_shaft():
    whirls = synchronous_response(
        omega=5.0, zeta=[0.0, 0.1], delta0=3.0, shaft_stiffness=[0.0, 0.5]
    ).isel(branch=0)
    expected = [[STABILITY["neutral"]] * 2, [STABILITY["neutral"], STABILITY["stable"]]]
    assert whirls.stability.values.squeeze().tolist() == expected


def test_arrays_give_what_single_numbers_give():
    amplitudes = np.array([[0.4, 1.5], [6.19, 9.48]])
    found = eigenvalues(amplitudes, omega=1.7, zeta=0.07, delta0=0.5)
    assert found.shape == (2, 2, 4)
    for place, amplitude in np.ndenumerate(amplitudes):
        alone = eigenvalues(amplitude, omega=1.7, zeta=0.07, delta0=0.5)
        np.testing.assert_allclose(found[place], alone, rtol=1e-15)


@pytest.mark.parametrize("name", ["amplitude", "omega", "zeta", "delta0", "shaft_stiffness"])
def test_no_parameter_of_a_whirl_is_negative(name):
    given = {"amplitude": 4.0, "omega": 1.0, "zeta": 0.5, "delta0": 0.5} | {name: -0.25}
    with pytest.raises(InputError, match=rf"{name} must be zero or positive, got -0.25"):
        eigenvalues(given.pop("amplitude"), **given)
