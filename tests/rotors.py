"""Rotors and motions for every area's tests: the paper's rotor, and each parameter beyond it."""

from __future__ import annotations

from dataclasses import dataclass, replace

from rotor_ida import Rotor

PAPER = Rotor(omega=2.0, zeta=0.07, delta0=2.0)
WHIP = Rotor(omega=0.62962981, zeta=0.1, delta0=1.0, friction=0.2, disc_radius=10.0)
# A start from which the disc of `WHIP` rolls backwards round the stator, and slips.
KNOCKED = (5.0, 0.0, 0.0, -6.3)

ROTORS: dict[str, Rotor] = {
    "paper": PAPER,
    "shaft": replace(PAPER, shaft_stiffness=0.3),
    "linear contact": replace(PAPER, contact_exponent=1.0),
    "contact damping": replace(PAPER, contact_damping=3.0),
    "load": replace(PAPER, load=0.5),
    "everything but friction": replace(
        PAPER, shaft_stiffness=0.2, contact_exponent=1.0, contact_damping=2.0, load=1.5
    ),
    "friction": replace(PAPER, friction=0.1, disc_radius=10.0),
    "contact damping and friction": replace(
        PAPER, contact_damping=3.0, friction=0.3, disc_radius=1.0
    ),
    "everything": replace(
        PAPER, shaft_stiffness=0.2, contact_exponent=1.0, contact_damping=2.0, load=1.5,
        friction=0.4, disc_radius=0.5,
    ),
}  # fmt: skip


@dataclass(frozen=True)
class Motion:
    """A rotor, where it starts, how long it is followed, and the kinds of event that it shows."""

    rotor: Rotor
    start: tuple[float, float, float, float]
    duration: float
    kinds: frozenset[int]


def motion(rotor, kinds, start=(0.3, 0.1, 0.2, 0.1), duration=20.0):
    """Return a motion, as a rule from a start inside the clearance."""
    return Motion(rotor, start, duration, frozenset(kinds))


SMOOTH: dict[str, Motion] = {
    "paper": motion(ROTORS["paper"], {1, -1}),
    "shaft": motion(ROTORS["shaft"], {1, -1}, duration=30.0),
    "linear contact": motion(ROTORS["linear contact"], {1, -1}, duration=30.0),
    "contact damping": motion(ROTORS["contact damping"], {1, 4, -4}, duration=30.0),
    "load": motion(ROTORS["load"], {1, -1}, duration=30.0),
    "everything but friction": motion(
        ROTORS["everything but friction"], {1, -1, 4, -4}, duration=30.0
    ),
    "resonance without damping": motion(
        Rotor(omega=0.8, zeta=0.0, delta0=3.0, load=0.1, shaft_stiffness=0.64), {1, -1},
        duration=30.0,
    ),
}  # fmt: skip
RUBBING: dict[str, Motion] = {
    "rub that slides forwards": motion(ROTORS["friction"], {1, -1}, duration=30.0),
    "dry whip": motion(WHIP, {2, -2}, KNOCKED, 40.0),
    "small disc, that chatters": motion(
        Rotor(omega=1.2, zeta=0.07, delta0=0.5, friction=0.3, disc_radius=0.6),
        {1, -1, 2, -2, 3}, duration=30.0,
    ),
    "disc of no radius": motion(
        Rotor(omega=1.2, zeta=0.02, delta0=0.5, friction=0.2, disc_radius=0.0),
        {1, -1, 2, -2, 3}, (0.8, 0.1, 0.2, -0.5), 30.0,
    ),
    "free vibration under a load": motion(
        Rotor(omega=0.0, zeta=0.05, delta0=1.0, load=0.5, friction=0.3, disc_radius=5.0),
        {1, -1, 2, -2}, (-1.2, -0.4, 0.3, -0.8), 30.0,
    ),
    "slow, under a load": motion(
        Rotor(omega=0.2, zeta=0.02, delta0=1.0, load=0.5, friction=0.2, disc_radius=3.0),
        {1, -1, 2, -2}, (-0.2, -0.4, 0.3, -0.8), 60.0,
    ),
    "shaft and linear contact": motion(
        Rotor(omega=0.9, zeta=0.05, delta0=1.0, shaft_stiffness=0.3, contact_exponent=1.0,
              friction=0.4, disc_radius=1.5),
        {1, -1, 2, -2, 3}, (0.3, 0.1, 1.2, -0.8), 30.0,
    ),
    "contact damping and friction": motion(ROTORS["contact damping and friction"], {1, -1, -4}),
    "everything": motion(ROTORS["everything"], {1, -1, 3, 4, -4}),
    "rough stator": motion(
        Rotor(omega=0.5, zeta=0.1, delta0=1.0, friction=2.0, disc_radius=4.0), {1, 2}
    ),
    "start that rolls": motion(
        Rotor(omega=0.5, zeta=0.05, delta0=1.0, friction=0.5, disc_radius=4.0),
        {2, -2}, (1.8, 0.0, 0.1, -2.0),
    ),
    "start that is loose": motion(
        Rotor(omega=0.5, zeta=0.05, delta0=1.0, contact_damping=2.0, load=0.4, friction=0.5,
              disc_radius=2.0),
        {1, -1, 2, -2, 4, -4}, (0.0, -1.4, 0.2, 0.8),
    ),
}  # fmt: skip
MOTIONS: dict[str, Motion] = {**SMOOTH, **RUBBING}
# The methods that all follow the same motion, each as exactly as it can.
WAYS = {
    "taylor": {"method": "taylor", "rtol": 1e-13, "atol": 1e-15},
    "adams": {"method": "adams", "rtol": 1e-13, "atol": 1e-15},
    "bdf, flight integrated": {"method": "bdf", "rtol": 1e-12, "flight": "cvode"},
    "reference": {"backend": "python", "rtol": 1e-12, "atol": 1e-14},
}
