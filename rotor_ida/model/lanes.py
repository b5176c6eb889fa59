"""One disc on the rotating axes, as the lanes of basins follow it.

Many starts are followed side by side (``core/lanes.c``) in Cartesian components. Roots and the
direction of the load are computed apart. The equations are stated here, with the forces of
`rotor_ida.model.forces` and the law of `rotor_ida.model.contact`; `rotor_ida.model.writing` derives
the C from them.
"""

from __future__ import annotations

from typing import Any

from rotor_ida.model.contact import drag_of, normal_force
from rotor_ida.model.forces import Moment, Number, Numbers, accelerations, turned_rates

# The state, and the inverse of the radius.
MOTION_GIVEN = ("x", "y", "u", "v", "inverse")
MOTION = ("approach", "slip")
# And the root of the indentation, the radial velocity, no less than at a release, and the direction
# of the load.
RATES_GIVEN = (*MOTION_GIVEN, "root", "approach", "down_x", "down_y")
RATES = ("x", "y", "u", "v")


def motion_of(given: Numbers, rotor: Any) -> list[Number]:
    """Return the radial velocity, and the slip speed ``v_t + rho omega``."""
    x, y, u, v, inverse = given
    approach = (x * u + y * v) * inverse
    slip = (x * v - y * u) * inverse + rotor.rim
    return [approach, slip]


def rates_of(given: Numbers, rotor: Any) -> list[Number]:
    """Return the rates of the state: the force over the radius is finite at the centre."""
    x, y, u, v, inverse, root, approach, *down = given
    push = normal_force(root, approach, rotor) * inverse
    at = Moment((x, y), (u, v), (x, y), (1.0, 0.0), (down[0], down[1]))
    forces = accelerations(at, push, rotor, drag_of(push, rotor))
    return turned_rates((x, y), (u, v), forces, rotor.omega)
