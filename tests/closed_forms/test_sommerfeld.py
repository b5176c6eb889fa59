"""Sommerfeld's curve: the torque that a whirl takes, and which speeds a drive holds."""

import numpy as np
import pytest

from rotor_ida import InputError, Rotor, run_up, synchronous_response
from rotor_ida.closed_forms import (
    eigenvalues,
    sommerfeld_curve,
    stability_determinant,
    whirl_torque,
)
from rotor_ida.closed_forms.rotor_columns import RotorColumns
from rotor_ida.closed_forms.sommerfeld import _Drive, _jacobian
from rotor_ida.schema import STABILITY
from tests.witness import FLIES, FORWARDS, Disc

RHO, SLOPE, INERTIA = 10.0, 0.3, 7.0
GIVEN = {
    "zeta": 0.07, "delta0": 0.5, "shaft_stiffness": 0.2, "contact_damping": 0.3, "friction": 0.1,
}  # fmt: skip
LINEAR = {"zeta": 0.1, "delta0": 0.5, "contact_exponent": 1.0}


def points_of(curve, every=7):
    """Amplitude, speed, lag, contact, torque and flag of some points of a curve."""
    names = ("amplitude", "omega", "phase_lag", "in_contact", "torque", "driven_stability")
    rows = np.stack([curve[name].values.ravel() for name in names], axis=1)
    return rows[np.isfinite(rows[:, 0])][1::every]


def field(state, torque, machine, mode):
    """The rates on axes that turn with the unbalance, and that of the spin, of a rigid body."""
    radius = {"disc_radius": RHO} if "friction" in machine else {}
    rotor = Rotor(omega=state[4], **machine, **radius)
    return Disc(rotor, torque=torque, inertia=INERTIA).turning(state, mode)


@pytest.mark.parametrize("machine", [GIVEN, LINEAR])
def test_whirls_are_equilibria_of_a_rigid_body_with_a_drive_and_as_stable(machine):
    """Newton's and Euler's equations: torque by the balance, eigenvalues by differences."""
    radius = RHO if "friction" in machine else None
    curve = sommerfeld_curve(
        **machine, limits=(0.3, 3.0), inertia=INERTIA, slope=SLOPE, points=25, disc_radius=radius
    )
    seen = set()
    for A, omega, lag, touches, torque, flag in points_of(curve):
        z = A * np.exp(-1j * lag)
        v = 1j * omega * z
        state, drive = np.array([z.real, z.imag, v.real, v.imag, omega]), torque + SLOPE * omega
        mode = FORWARDS if touches else FLIES

        def at(off, drive=drive, mode=mode, state=state):
            return field(state + off, (drive, SLOPE), machine, mode)

        assert np.abs(at(np.zeros(5))).max() < 1e-10 * max(1.0, omega**2 * A)
        step = 1e-5 * min(A, A - machine["delta0"] if touches else A)
        jacobian = np.array(
            [(at(step * each) - at(-step * each)) / (2.0 * step) for each in np.eye(5)]
        )
        growth = np.linalg.eigvals(jacobian).real.max()
        if abs(growth) > 1e-5:
            assert int(flag) == STABILITY["unstable" if growth > 0.0 else "stable"]
            seen.add(int(flag))
    assert seen == {STABILITY["stable"], STABILITY["unstable"]}


def test_the_last_eigenvalue_passes_zero_where_the_curve_falls_as_the_drive_does():
    """``det J j = -D (dtau/domega + slope)``, with the slope of the curve by its own equation."""
    curve = sommerfeld_curve(
        **GIVEN, limits=(0.3, 3.0), inertia=INERTIA, slope=SLOPE, disc_radius=RHO
    )
    A, omega, lag, touches, torque, _ = points_of(curve).T
    touching = touches == 1
    A, omega, lag, torque = (each[touching] for each in (A, omega, lag, torque))
    rotors = RotorColumns.of({"omega": omega, **GIVEN})
    drive = _Drive(RHO, SLOPE, INERTIA)
    determinant = np.linalg.det(_jacobian(A, lag, np.zeros(A.size, bool), rotors, drive))
    zeta, mu, depth = GIVEN["zeta"], GIVEN["friction"], A - GIVEN["delta0"]
    f, steep = depth**1.5, 1.5 * depth**0.5
    D = stability_determinant(A, omega=omega, **GIVEN)
    pulled = 2.0 * zeta * omega * A + mu * f
    P_w = 4.0 * zeta * A * pulled - 4.0 * omega**3
    P_w -= 4.0 * omega * A * ((GIVEN["shaft_stiffness"] - omega**2) * A + f)
    torque_A = 4.0 * zeta * omega * A + mu * (steep * (A + RHO) + f)
    rise = 2.0 * zeta * A**2 - torque_A * P_w / (2.0 * A * D)
    np.testing.assert_allclose(
        determinant * INERTIA, -D * (rise + SLOPE), rtol=1e-8, atol=1e-9 * np.abs(D).max()
    )


def test_a_heavy_rotor_is_as_stable_as_at_a_fixed_speed():
    curve = sommerfeld_curve(**GIVEN, limits=(0.3, 3.0), inertia=1e15, disc_radius=RHO, points=20)
    A, omega, lag, touches, *_ = points_of(curve, 1).T
    here = touches == 1
    A, omega, lag = A[here], omega[here], lag[here]
    rotors = RotorColumns.of({"omega": omega, **GIVEN})
    drive = _Drive(RHO, 0.0, 1e15)
    found = np.linalg.eigvals(_jacobian(A, lag, np.zeros(A.size, bool), rotors, drive))
    known = eigenvalues(A, omega=omega, **GIVEN)
    off = np.abs(found[:, :, None] - known[:, None, :]).min(axis=1)
    # the root of rounding where two nearly coincide
    assert off.max() < 1e-6


def test_a_whirl_whose_centre_may_lie_anywhere_is_neutral_where_the_speed_is_held():
    """Without a shaft; and in contact without damping, where nothing decays."""
    free = sommerfeld_curve(zeta=0.07, delta0=2.0, limits=(0.5, 3.0), inertia=2.0, slope=0.1)
    flags = free.driven_stability.values
    assert (flags[(free.in_contact.values == 0) & (free.piece.values >= 0)] == 2).all()
    undamped = sommerfeld_curve(zeta=0.0, delta0=0.5, limits=(0.5, 3.0), inertia=1e6)
    at_fixed_speed = undamped.stability.values == STABILITY["neutral"]
    assert at_fixed_speed.any()
    assert not (undamped.driven_stability.values == STABILITY["stable"]).any()


def test_torque_is_what_damping_and_friction_take_of_the_power():
    """Power 2 zeta (omega A)**2 of damping, and mu f of slipping at the speed (A + rho) omega."""
    whirls = synchronous_response(omega=1.2, **GIVEN).squeeze()
    A = whirls.amplitude.values
    radius = {"friction": GIVEN["friction"], "disc_radius": RHO}
    found = whirl_torque(A, omega=1.2, zeta=0.07, delta0=0.5, **radius)
    power = 2.0 * 0.07 * (1.2 * A) ** 2 + 0.1 * (A - 0.5) ** 1.5 * (A + RHO) * 1.2
    np.testing.assert_allclose(found * 1.2, power, rtol=1e-13)


def test_limited_power_settles_on_the_curve_and_jumps_beyond_its_stable_part():
    """From one whirl, with 1% less torque than the curve holds there at most, and with 1% more."""
    machine, slope, inertia = {"zeta": 0.2, "delta0": 0.5}, 0.2, 10.0
    curve = sommerfeld_curve(**machine, limits=(0.1, 9.0), inertia=inertia, slope=slope)
    A, omega, lag, touches, torque, flag = points_of(curve, 1).T
    drive = torque + slope * omega
    held = np.flatnonzero((flag == STABILITY["stable"]) & (touches == 1) & (A > 1.5))
    highest = drive[held].max()
    begin = held[np.abs(drive[held] - 0.98 * highest).argmin()]
    z = A[begin] * np.exp(-1j * lag[begin])
    v = 1j * omega[begin] * z
    speeds = []
    for share in (0.99, 1.01):
        found = run_up(
            Rotor(omega=omega[begin], **machine), start=(z.real, z.imag, v.real, v.imag),
            inertia=inertia, torque=(share * highest, slope), duration=600.0, samples=2,
            method="taylor",
        )  # fmt: skip
        speed = found.speed.values[-1]
        radius = np.hypot(found.x.values[-1], found.y.values[-1])
        near = np.hypot(A - radius, omega - speed).argmin()
        assert flag[near] == STABILITY["stable"]
        speeds.append(speed)
        if share < 1.0:
            taken = whirl_torque(radius, omega=speed, zeta=0.2, delta0=0.5)
            assert share * highest - slope * speed == pytest.approx(taken, abs=1e-8)
    assert speeds[0] < 1.2
    assert speeds[1] > 5.0


@pytest.mark.parametrize(
    "odd",
    [{"zeta": -0.1}, {"friction": 0.1}, {"contact_exponent": 2.0}, {"omega": [1.0, 2.0, 3.0]}],
)
def test_bad_whirls_are_refused(odd):
    given = {"omega": 1.0, "zeta": 0.1, "delta0": 1.0} | odd
    with pytest.raises(InputError):
        whirl_torque([2.0, 3.0], **given)
