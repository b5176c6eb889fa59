"""The response curve with a shaft, either contact law and contact damping."""

from __future__ import annotations

import numpy as np
import pytest

from rotor_ida import InputError, folds, synchronous_response
from rotor_ida.closed_forms import response_curve, touch_speeds
from rotor_ida.schema import STABILITY

LIMITS = (0.05, 4.0)
# zeta, delta0, shaft_stiffness, contact_exponent, contact_damping
ROTORS = [
    (0.07, 0.5, 0.25, 1.5, 0.0),
    (0.07, 2.0, 0.25, 1.5, 0.0),
    (0.07, 2.0, 0.25, 1.0, 0.0),
    (0.07, 1.0, 0.25, 1.5, 0.0),
    (0.3, 0.5, 2.0, 1.5, 0.5),
    (0.07, 0.5, 0.1, 1.0, 0.5),
    (0.0, 0.5, 0.25, 1.5, 0.0),
    (0.0, 2.0, 0.25, 1.5, 0.0),
    (0.07, 4.0, 0.01, 1.5, 0.0),
    (0.07, 0.5, 0.0, 1.0, 0.0),
    (0.07, 2.0, 0.0, 1.0, 0.0),
    (1.0, 0.5, 0.3, 1.5, 0.0),
    (0.07, 0.5, 0.0, 1.5, 0.7),
]
NAMES = ("zeta", "delta0", "shaft_stiffness", "contact_exponent", "contact_damping")


def columns(rotor) -> dict[str, np.ndarray]:
    curve = response_curve(**dict(zip(NAMES, rotor, strict=True)), limits=LIMITS)
    chosen = np.flatnonzero(curve.piece.values.ravel() >= 0)
    names = ("omega", "amplitude", "phase_lag", "stability", "in_contact", "piece")
    return {name: curve[name].values.ravel()[chosen] for name in names}


@pytest.mark.parametrize("rotor", ROTORS)
def test_every_point_lies_on_the_whirl_equation(rotor):
    zeta, delta0, kappa, exponent, _ = rotor
    at = columns(rotor)
    A, q = at["amplitude"], at["omega"] ** 2
    force = np.where(at["in_contact"] == 1, np.maximum(A - delta0, 0.0) ** exponent, 0.0)
    impedance = force + (kappa - q) * A + 2j * zeta * at["omega"] * A
    size = force + (kappa + q) * A + q
    assert (np.abs(np.abs(impedance) - q) < 1e-14 * size).all()
    assert (np.abs(impedance * np.exp(-1j * at["phase_lag"]) - q) < 1e-13 * size).all()


@pytest.mark.parametrize("rotor", ROTORS)
def test_the_curve_passes_each_speed_once_for_each_whirl(rotor):
    at = columns(rotor)
    parameters = dict(zip(NAMES, rotor, strict=True))
    for omega in np.random.default_rng(3).uniform(*LIMITS, 40):
        whirls = synchronous_response(omega=omega, **parameters)
        present = np.isfinite(whirls.amplitude.values.ravel())
        w, A = at["omega"], at["amplitude"]
        passes = ((w[:-1] - omega) * (w[1:] - omega) < 0.0) & (np.diff(at["piece"]) == 0)
        k = np.flatnonzero(passes)
        part = (omega - w[k]) / (w[k + 1] - w[k])
        order = np.argsort(A[k] + part * np.diff(A)[k])
        crossed = (A[k] + part * np.diff(A)[k])[order]
        expected = whirls.amplitude.values.ravel()[present]
        assert crossed.size == expected.size, (rotor, omega)
        np.testing.assert_allclose(crossed, expected, rtol=2e-2)
        # both ends of a line that does not pass a change of stability agree with the whirl
        flags = at["stability"]
        same = (flags[k] == flags[k + 1])[order]
        found = whirls.stability.values.ravel()[present]
        assert (flags[k][order] == found)[same].all(), (rotor, omega)


@pytest.mark.parametrize("rotor", ROTORS)
def test_folds_and_touches_are_points_of_the_curve(rotor):
    at = columns(rotor)
    parameters = dict(zip(NAMES, rotor, strict=True))
    turns = folds(**parameters)
    touches = touch_speeds(zeta=rotor[0], delta0=rotor[1], shaft_stiffness=rotor[2])
    marks = [
        *zip(turns.fold_omega.values.ravel(), turns.fold_amplitude.values.ravel(), strict=True)
    ]
    marks += [(omega, rotor[1]) for omega in touches]
    for omega, amplitude in marks:
        if LIMITS[0] < omega < LIMITS[1]:
            distance = np.hypot(at["omega"] / omega - 1.0, at["amplitude"] / amplitude - 1.0)
            assert distance.min() < 1e-12


def test_a_contact_free_whirl_with_a_resonance_inside_the_clearance_is_one_piece():
    at = columns((0.1, 3.0, 0.25, 1.5, 0.0))
    free = at["in_contact"] == 0
    assert set(at["piece"][free]) == {0}
    assert (at["stability"][free] == STABILITY["stable"]).all()
    top = at["amplitude"][free].argmax()
    assert at["omega"][free][top] == pytest.approx(0.25 / np.sqrt(0.25 - 0.02), rel=1e-14)
    expected = 0.25 / (0.2 * np.sqrt(0.25 - 0.01))
    assert at["amplitude"][free][top] == pytest.approx(expected, rel=1e-14)


def test_axes_are_dimensions_and_numbers_coordinates():
    curve = response_curve(
        zeta=0.07, delta0=[0.5, 2.0], limits=LIMITS, points=20,
        shaft_stiffness=[0.0, 0.25], contact_exponent=1.0,
    )  # fmt: skip
    assert curve.amplitude.dims == ("zeta", "delta0", "shaft_stiffness", "point")
    assert curve.contact_exponent.item() == 1.0
    assert "contact_damping" not in curve.coords
    alone = response_curve(
        zeta=0.07, delta0=2.0, limits=LIMITS, points=20,
        shaft_stiffness=0.25, contact_exponent=1.0,
    )  # fmt: skip
    part = curve.sel(delta0=2.0, shaft_stiffness=0.25).isel(point=slice(alone.sizes["point"]))
    for name in curve.data_vars:
        assert part[name].values.ravel().tolist() == alone[name].values.ravel().tolist()


def test_what_has_no_curve_is_refused():
    with pytest.raises(InputError, match="zeta must be positive for the curve of a linear contact"):
        response_curve(zeta=[0.0, 0.1], delta0=0.5, limits=LIMITS, contact_exponent=1.0)
    with pytest.raises(InputError, match="shaft_stiffness must be zero or positive, got -1"):
        response_curve(zeta=0.1, delta0=0.5, limits=LIMITS, shaft_stiffness=-1)
