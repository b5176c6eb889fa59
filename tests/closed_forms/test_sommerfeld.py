"""Sommerfeld's curve: the torque that a whirl takes, and which speeds a drive holds."""

import numpy as np
import pytest

from rotor_ida import InputError, Rotor, synchronous_response
from rotor_ida.closed_forms import sommerfeld_curve, whirl_torque
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


@pytest.mark.parametrize(
    "odd",
    [{"zeta": -0.1}, {"friction": 0.1}, {"contact_exponent": 2.0}, {"omega": [1.0, 2.0, 3.0]}],
)
def test_bad_whirls_are_refused(odd):
    given = {"omega": 1.0, "zeta": 0.1, "delta0": 1.0} | odd
    with pytest.raises(InputError):
        whirl_torque([2.0, 3.0], **given)
