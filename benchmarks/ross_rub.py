"""Where ROSS's friction of a rub points, over the angle at which the rotor touches.

ROSS 2.3.0 (package ross-rotordynamics) takes ``(-mu |F_x|, mu |F_y|)`` of the normal force F for
friction where the disc slides forwards, and the opposite where it slides backwards; which of both
it is, it reads from ``xdot cos(phi) - ydot sin(phi) + omega R``. Right is: the disc slides with
``-xdot sin(phi) + ydot cos(phi) + omega R`` along the ring, friction is ``mu |F|`` against that,
and has no part along the radius.

At points all round the ring ROSS is asked for its force, with friction and without, on the rotor of
its own example, which whirls forwards, and backwards faster than its rim turns. Beside it stands
what friction does to the velocity of the same rotor here, in the first instant of a simulation.

    pip install 'ross-rotordynamics>=2.3' 'plotly<7'
    python benchmarks/ross_rub.py --points 16

The lines on REFPROP come from a package that ROSS imports, and have nothing to do with rubs.
"""

import argparse
import math
import sys

import numpy as np

from rotor_ida import DimensionalRotor, simulate

SPEED = 1200.0 * 2.0 * math.pi / 60.0  # spin [rad/s]
CLEARANCE, DEPTH = 7.95e-5, 1e-5  # m
STIFFNESS, FRICTION = 1.1e6, 0.3  # N/m, 1: those of ROSS's example
INSTANT = 1e-6  # of the dimensionless time


def friction_of_ross():
    """Return ROSS's friction at a place and a velocity [N], and the shaft's radius there [m]."""
    try:
        import ross  # noqa: PLC0415 - it takes seconds, and is not always there
        from ross.faults import Rubbing  # noqa: PLC0415
    except ImportError:
        sys.exit("ROSS is missing: pip install 'ross-rotordynamics>=2.3' 'plotly<7'")

    rotor = ross.rotor_example_with_damping()
    given = {"distance": CLEARANCE, "contact_stiffness": STIFFNESS, "contact_damping": 0.0}
    with_friction, without = (
        Rubbing(rotor, n=12, friction_coeff=each, **given) for each in (FRICTION, 0.0)
    )

    def friction(place, velocity):
        states = np.zeros((2, len(with_friction.dofs)))
        states[:, :2] = place, velocity
        force, normal = (
            rub.compute_rubbing_force(*states, SPEED)[:2] for rub in (with_friction, without)
        )
        return force - normal

    return friction, with_friction.shaft_elem.odl / 2.0


def friction_here(radius):
    """Return the friction of this package at a place and a velocity [N]."""

    def machine(friction):
        return DimensionalRotor(
            mass=1.0, contact_stiffness=STIFFNESS, contact_exponent=1.0, damping=0.0,
            eccentricity=1e-6, clearance=CLEARANCE, speed=SPEED, friction=friction,
            disc_radius=radius if friction else None,
        )  # fmt: skip

    def later(friction, place, velocity):
        given = machine(friction)
        start = (*(place / given.eccentricity), *(velocity / given.velocity_scale))
        run = simulate(given.rotor(), start=start, duration=INSTANT, samples=2, method="taylor")
        return np.array([run.vx.values[-1], run.vy.values[-1]]) / INSTANT * given.force_scale

    return lambda place, velocity: later(FRICTION, place, velocity) - later(0.0, place, velocity)


def slip_speed_of_ross(angle, velocity, radius):
    """Return what ROSS takes for the slip speed [m/s], by its source."""
    return velocity[0] * math.cos(angle) - velocity[1] * math.sin(angle) + SPEED * radius


def table(friction, radius, whirl_speed, points):
    """Return rows of angle [degrees], slip speed [m/s], what ROSS takes for it, and friction.

    Friction is its angle from the direction of the slip [degrees], and over mu times the normal
    force its part outwards along the radius and its part along the slip.
    """
    rows = []
    for angle in np.arange(points) * 2.0 * math.pi / points:
        outwards = np.array([math.cos(angle), math.sin(angle)])
        along = np.array([-outwards[1], outwards[0]])
        place = (CLEARANCE + DEPTH) * outwards
        velocity = whirl_speed * (CLEARANCE + DEPTH) * along
        slip = velocity @ along + SPEED * radius
        force = friction(place, velocity) / (FRICTION * STIFFNESS * DEPTH)
        radial, sliding = force @ outwards, force @ along * math.copysign(1.0, slip)
        between = math.degrees(math.atan2(abs(radial), sliding))
        taken = slip_speed_of_ross(angle, velocity, radius)
        rows.append((math.degrees(angle), slip, taken, between, radial, sliding))
    return np.array(rows)


def report(ross, here):
    """Print both tables side by side."""
    print("        slip speed [m/s]    friction of ROSS           friction here")
    print("  phi   right   ROSS's    angle  radial   along     angle  radial   along")
    # nothing is shown as -0.000
    theirs, ours = (np.round(rows, 6) + 0.0 for rows in (ross, here))
    for one, other in zip(theirs, ours, strict=True):
        print(
            "{:5.1f} {:7.3f} {:8.3f} {:8.1f} {:7.3f} {:7.3f}".format(*one),
            "{:9.1f} {:7.3f} {:7.3f}".format(*other[3:]),
        )
    print("mean over a turn: {:17.3f} {:7.3f} {:17.3f} {:7.3f}".format(
        *theirs[:, 4:].mean(0).round(6) + 0.0, *ours[:, 4:].mean(0)))  # fmt: skip
    wrong = int((theirs[:, 1] * theirs[:, 2] < 0.0).sum())
    print(f"ROSS takes the slip for one in the other sense at {wrong} of {len(theirs)} points")


def main():
    """Print where both forces point."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--points", type=int, default=16)
    points = parser.parse_args().points
    theirs, radius = friction_of_ross()
    ours = friction_here(radius)
    print("angle from the direction of the slip [degrees], right is 180; part outwards along the")
    print("radius, right is 0; part along the slip, right is -1 (both over mu times normal force)")
    rolling = -SPEED * radius / (CLEARANCE + DEPTH)
    for words, whirl in (
        ("forwards, as fast as the spin", SPEED),
        ("backwards, half as fast again as the rim", 1.5 * rolling),
    ):
        print(f"\nthe rotor whirls {words}")
        report(table(theirs, radius, whirl, points), table(ours, radius, whirl, points))


if __name__ == "__main__":
    main()
