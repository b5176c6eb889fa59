"""Simulate a rotor of one disc, or a rotor system: one name for both."""

from __future__ import annotations

from functools import wraps
from typing import Any

import xarray as xr

from rotor_ida.model.rotor import Rotor
from rotor_ida.model.rotor_system import RotorSystem
from rotor_ida.simulation.run_up import run_up as run_up_disc
from rotor_ida.simulation.simulate import simulate as simulate_disc
from rotor_ida.systems.simulate import run_up_system, simulate_system


# Signature and help are those of one disc, which refer to the others.
@wraps(simulate_disc)
def simulate(rotor: Rotor | RotorSystem, **options: Any) -> xr.Dataset:  # noqa: D103
    if isinstance(rotor, RotorSystem):
        return simulate_system(rotor, **options)
    return simulate_disc(rotor, **options)


@wraps(run_up_disc)
def run_up(rotor: Rotor | RotorSystem, **options: Any) -> xr.Dataset:  # noqa: D103
    if isinstance(rotor, RotorSystem):
        return run_up_system(rotor, **options)
    return run_up_disc(rotor, **options)
