"""Cycles that are known from elsewhere, and those of one rotor of each kind.

Known from DESIGN section 9, and from AUTO-07p (bifpy 0.3.0), polished to about 1e-10 by Newton's
method on (state, period, omega) with SciPy's DOP853 (rtol = atol = 1e-11) restarted at every event.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from rotor_ida import Rotor
from rotor_ida.cycles.orbit import Orbit
from rotor_ida.schema import SPECIAL
from tests.witness import flown


@dataclass(frozen=True)
class Known:
    """A cycle: its rotor, period, a state on the rotating axes, and what is special about it."""

    rotor: Rotor
    period: float
    state: tuple[float, float, float, float]
    kind: str = ""


BOUNCING = Known(
    Rotor(omega=2.0, zeta=0.07, delta0=2.0),
    4.563916675380,
    (-2.481260654089, -3.269487053355, 1.330177208370, -1.001389141291),
)
FULL = Known(
    Rotor(omega=3.0, zeta=0.07, delta0=0.5),
    3.115214254929,
    (-2.610835107660, -1.478128419692, 1.574471072418, -2.770693942960),
)
HIGHEST = {BOUNCING: 4.104416607, FULL: 3.000222126}
PAIRS = {BOUNCING: complex(-0.51147221, 0.51598781), FULL: complex(0.53147652, 0.60337913)}
PARTNERS = {BOUNCING: 0.52784725, FULL: 0.64653367}

# Stable cycles of the sliver, between its fold and its doubling, with the pair beside 1 and q.
SLIVER = {
    Known(
        Rotor(omega=0.4, zeta=0.07, delta0=2.0),
        22.016240259964,
        (-1.309622847051, -2.034127666235, 0.274758564188, -0.181337798334),
    ): (-0.71954820, -0.06372732),
    Known(
        Rotor(omega=0.3995, zeta=0.07, delta0=2.0),
        22.042579472282,
        (-1.309316239916, -2.033672177060, 0.274543776777, -0.180982139350),
    ): (-0.41450025, -0.11021972),
}

_POINTS = """
0.5 2.530418916182  3.720756254450 fold            -1.799780592339 -0.458034135593 0.694760017092 -2.699461844011
0.5 4.133584519047  2.256235596185 fold            -5.508643265481 -3.424139656959 2.704828189258 -4.417159175388
2.0 0.398200108400 22.111844437762 fold            -1.323909324277 -2.021677255157 0.278005941284 -0.178158322030
2.0 0.400606983928 21.984376877060 period_doubling -1.310016301292 -2.034619659394 0.274937679162 -0.181884633804
2.0 1.803392470017  5.054250530560 period_doubling -2.425314661360 -3.005852500038 1.187724699715 -0.972809299419
2.0 3.942820397474  2.346409301270 fold            -6.653512731517 -6.931107980290 3.541012565642 -3.464762984570
"""  # noqa: E501 - a table


def _read(line: str) -> Known:
    delta0, omega, period, kind, *state = line.split()
    rotor = Rotor(omega=float(omega), zeta=0.07, delta0=float(delta0))
    x, y, vx, vy = (float(value) for value in state)
    return Known(rotor, float(period), (x, y, vx, vy), kind)


SPECIAL_POINTS = [_read(line) for line in _POINTS.strip().splitlines()]


REST = (0.0, 0.0, 0.0, 0.0)
# A heavy rotor that stays in contact, one revolution a period; one that bounces, two of them.
LYING = Rotor(omega=1.2, zeta=0.07, delta0=0.5, load=1.0)
LOADED = Rotor(omega=1.6, zeta=0.07, delta0=2.0, load=0.5, contact_damping=0.3, shaft_stiffness=0.2)
# A rotor of each kind but those with friction, and a start that leads to its stable cycle.
CYCLES = {
    "bouncing": (BOUNCING.rotor, REST),
    "full contact": (FULL.rotor, (3.0, 1.0, 0.0, 0.0)),
    "sliver": next((known.rotor, known.state) for known in SLIVER),
    "shaft": (Rotor(omega=2.0, zeta=0.07, delta0=2.0, shaft_stiffness=0.05), REST),
    "linear contact": (
        Rotor(omega=1.6, zeta=0.07, delta0=2.0, shaft_stiffness=0.02, contact_exponent=1.0), REST,
    ),
    "contact damping": (Rotor(omega=1.8, zeta=0.07, delta0=2.0, contact_damping=0.1), REST),
    "release and press": (
        Rotor(omega=1.6, zeta=0.07, delta0=2.0, contact_damping=2.0, contact_exponent=1.0), REST,
    ),
    "load": (LYING, REST),
    "load, shaft and contact damping": (LOADED, REST),
}  # fmt: skip


def state_of(cycle, prefix=""):
    """Return the state of a cycle, at its start, or of one point of a branch."""
    return np.array([cycle[f"{prefix}{name}"].values.flat[0] for name in ("x", "y", "vx", "vy")])


def multipliers(cycle):
    """Return the multipliers of a cycle, or those of all points of a branch."""
    return cycle.multiplier_real.values + 1j * cycle.multiplier_imag.values


def specials(branch, kind):
    """Return the special points of a kind."""
    return branch.isel(special=branch.special_kind.values == SPECIAL[kind])


def revolutions(rotor, period):
    """Return how many revolutions a period takes."""
    return period * rotor.omega / (2.0 * np.pi)


class OnceRound(NamedTuple):
    """Where an orbit ends, the derivative of that by its start, and when it crossed the ring."""

    end: np.ndarray
    monodromy: np.ndarray
    crossings: np.ndarray


def once_round(rotor, state, period) -> OnceRound:
    """Return an orbit by DOP853, with its end and its matrix read on the rotating axes."""
    found = flown(rotor, state, period, tangents=True)
    cos, sin = np.cos(rotor.omega * period), np.sin(rotor.omega * period)
    back = np.kron(np.eye(2), [[cos, sin], [-sin, cos]])
    return OnceRound(back @ found.end[:4], back @ found.tangents, found.crossings)


def signature(cycle) -> np.ndarray:
    """Return numbers of a cycle that do not hang on where it begins."""
    period = cycle.duration if isinstance(cycle, Orbit) else cycle.period
    return np.array([period, cycle.radius_min, cycle.radius_max], dtype=float)
