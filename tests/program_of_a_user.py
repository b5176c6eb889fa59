"""A program of a user, which the types of the package let pass but for what is wrong in it.

mypy reads it with the package, strictly: what is ignored here must be an error.
"""

import xarray as xr

from rotor_ida import (
    Rotor,
    load,
    lyapunov_exponent,
    poincare_section,
    run_ups,
    simulate,
    special_speeds,
    sweep,
    synchronous_response,
)
from rotor_ida.closed_forms import cusp_zeta
from rotor_ida.testing import assert_events_close


def program() -> None:
    rotor = Rotor(omega=2.0, zeta=0.07, delta0=2.0)
    run: xr.Dataset = simulate(rotor, start=(0, 0, 0, 0), duration=20.0)
    assert_events_close(run, load("run.nc"), atol=cusp_zeta(0.0))
    system = rotor.system()
    simulate(system, speed=2.0, duration=20.0, contacts=[], gravity=(0.0, -1.0))
    simulate(system, speed=2.0, duration=20.0, contcts=[])  # type: ignore[call-arg]
    poincare_section(system, speed=2.0, revolutions=20, at="entry", contact="disc", contacts=[])
    poincare_section(rotor, revolutions=20, at="apex")  # type: ignore[arg-type]
    special_speeds(system, limits=(1.0, 2.0), unbalance=3)  # type: ignore[arg-type]
    simulate(rotor, start=(0, 0, 0, 0), duration="long")  # type: ignore[arg-type]
    simulate(rotor, start=(0, 0, 0, 0), duration=1.0, method="euler")  # type: ignore[arg-type]
    found: xr.Dataset = sweep(system, speed=[1.0, 2.0], friction=[0.0, 0.1], unbalance=[0.5, 1.0])
    sweep(rotor, omega=[1.5, 2.0], starts=found, direction="both")
    sweep(omega=2.0, zeta=0.07, delta0=2.0, direction="round")  # type: ignore[arg-type]
    sweep(system, speed=[1.0, 2.0], frictn=[0.0, 0.1])  # type: ignore[call-arg]
    run_ups(system, speed=1.0, to=2.0, rate=[0.1, 0.2], stiffness=[1.0, 1.1], contacts=[])
    run_ups(rotor, to=2.0)  # type: ignore[call-arg]
    lyapunov_exponent(system, speed=2.0, start="rest", exponents="all")  # type: ignore[arg-type]
    synchronous_response(rotor, zeta=[0.07, 0.1], friction="low", unbalance=[])
    synchronous_response("pump.toml", speed=2.0)  # type: ignore[arg-type]
