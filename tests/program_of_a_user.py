"""A program of a user, which the types of the package let pass but for what is wrong in it.

mypy reads it with the package, strictly: what is ignored here must be an error.
"""

import xarray as xr

from rotor_ida import Rotor, load, poincare_section, simulate, special_speeds
from rotor_ida.closed_forms import cusp_zeta
from rotor_ida.testing import assert_events_close


def program() -> None:
    rotor = Rotor(omega=2.0, zeta=0.07, delta0=2.0)
    run: xr.Dataset = simulate(rotor, start=(0, 0, 0, 0), duration=20.0)
    assert_events_close(run, load("run.nc"), atol=cusp_zeta(0.0))
    system = rotor.system()
    simulate(system, speed=2.0, duration=20.0, contacts=[], gravity=(0.0, -1.0))
    simulate(system, speed=2.0, duration=20.0, contcts=[])  # type: ignore[call-overload]
    poincare_section(system, speed=2.0, revolutions=20, at="entry", contact="disc", contacts=[])
    poincare_section(rotor, revolutions=20, at="apex")  # type: ignore[arg-type]
    special_speeds(system, limits=(1.0, 2.0), unbalance=3)  # type: ignore[arg-type]
    simulate(rotor, start=(0, 0, 0, 0), duration="long")  # type: ignore[call-overload]
    simulate(rotor, start=(0, 0, 0, 0), duration=1.0, method="euler")  # type: ignore[call-overload]
