"""What can be simulated at all."""

from __future__ import annotations

from rotor_ida.checks import State
from rotor_ida.errors import InputError
from rotor_ida.parameters import Rotor

# Dimensionless parameters and starts beyond this leave nothing for a tolerance to hold on to.
LARGEST = 1e6
# The final window holds whole revolutions: those of slower rotors take too long, and of faster ones
# it holds too many.
SLOWEST_TO_SETTLE, FASTEST_TO_SETTLE = 1e-3, 1e3


def check_can_be_followed(rotor: Rotor, start: State, *, settling: bool = False) -> None:
    """Raise `InputError` for a rotor or start that cannot be followed, or not until it settles."""
    for name in ("omega", "zeta", "delta0"):
        value = getattr(rotor, name)
        if value > LARGEST:
            raise InputError(f"{name} must be at most {LARGEST:g} to be simulated, got {value!r}")
    if settling and rotor.omega and not SLOWEST_TO_SETTLE <= rotor.omega <= FASTEST_TO_SETTLE:
        raise InputError(
            f"omega must be 0 or from {SLOWEST_TO_SETTLE} to {FASTEST_TO_SETTLE:g} to settle, got "
            f"{rotor.omega!r}"
        )
    for name, value in zip(("x", "y", "vx", "vy"), start, strict=True):
        if abs(value) > LARGEST:
            raise InputError(f"start {name} must lie within {LARGEST:g} of zero, got {value!r}")
