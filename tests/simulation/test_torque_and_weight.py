"""The weight of unbalance under a torque, by Lagrange's equations and the energy that is kept."""

from dataclasses import replace

import numpy as np
from scipy.integrate import solve_ivp

from rotor_ida import Rotor, RotorSystem, Unbalance, run_up

GRAVITY = np.array([0.05, -0.3])
UNBALANCE = [("a", 0.5, 0.3), ("b", 0.7, -1.0), ("c", 0.4, 2.0)]
PLACES = {"a": (0, 1), "b": (2, 3), "c": (4, 5)}
TIMES = np.linspace(0.0, 30.0, 16)
RUN = {
    "unbalance": [Unbalance(node=node, moment=u, phase=p) for node, u, p in UNBALANCE],
    "gravity": tuple(GRAVITY), "speed": 0.8, "inertia": 1.5, "duration": 30.0, "samples": TIMES,
}  # fmt: skip


def rotor(damped):
    """Return a random system of three nodes, and a start."""
    rng = np.random.default_rng(5)
    bent, more = rng.normal(size=(6, 6)), rng.normal(size=(3, 3))
    stiffness = bent @ bent.T + 0.5 * np.eye(6)
    system = RotorSystem(
        mass=np.kron(2.0 * np.eye(3) + 0.3 * more @ more.T, np.eye(2)), stiffness=stiffness,
        gyroscopic=np.kron(np.diag([0.2, 0.1, 0.3]), [[0.0, 1.0], [-1.0, 0.0]]),
        damping=0.1 * np.eye(6) + 0.05 * stiffness if damped else None, nodes=PLACES, units="1",
    )  # fmt: skip
    return system, (0.3 * rng.normal(size=6), 0.3 * rng.normal(size=6))


def inertia_of(system):
    """Return the moment of inertia about the axis: at the centres of mass, and the unbalance's."""
    rows = np.zeros((6, 2))
    for node, u, p in UNBALANCE:
        for column, turned in enumerate((p, p + 0.5 * np.pi)):
            rows[list(PLACES[node]), column] += u * np.array([np.cos(turned), np.sin(turned)])
    return RUN["inertia"] + 0.5 * np.trace(rows.T @ np.linalg.solve(system.mass, rows))


def lagrange(system, start, torque, force):
    """Return speeds by Lagrange's equations: a particle of mass m at q + e exp(i a), u = m e."""
    damping = np.zeros((6, 6)) if system.damping is None else system.damping
    both = np.tile(np.eye(2), (3, 1))
    inertia = inertia_of(system)

    def rates(_, state):
        q, v, angle, speed = state[:6], state[6:12], state[12], state[13]
        matrix, right = np.zeros((7, 7)), np.zeros(7)
        matrix[:6, :6], matrix[6, 6] = system.mass, inertia
        right[:6] = force + system.mass @ both @ GRAVITY - system.stiffness @ q
        right[:6] -= (damping + speed * system.gyroscopic) @ v
        right[6] = torque[0] - torque[1] * speed
        for node, u, p in UNBALANCE:
            c, s = u * np.cos(angle + p), u * np.sin(angle + p)
            for row, pull, out in zip(PLACES[node], (-s, c), (c, s), strict=True):
                matrix[row, 6] += pull
                matrix[6, row] += pull
                right[row] += speed**2 * out
            right[6] += c * GRAVITY[1] - s * GRAVITY[0]
        return np.concatenate([v, (found := np.linalg.solve(matrix, right))[:6],
                               [speed, found[6]]])  # fmt: skip

    begun = np.concatenate([*start, [0.0, RUN["speed"]]])
    return solve_ivp(rates, (0.0, 30.0), begun, method="DOP853", rtol=1e-11, atol=1e-12,
                     t_eval=TIMES).y[13]  # fmt: skip


def test_the_load_of_a_disc_has_the_moment_of_its_weight():
    disc = Rotor(omega=0.7, zeta=0.05, delta0=50.0, shaft_stiffness=0.3, load=0.2)
    system = disc.system()
    case = {"torque": (0.0, 0.0), "inertia": 4.0, "duration": 30.0, "samples": [10.0, 20.0, 30.0]}
    exact = [0.19118822, 0.31982468, 0.30327549]  # Lagrange's equations
    assert system.gravity == (0.0, -0.2)
    told = replace(system, gravity=None, static_force=[0.0, -0.2],
                   gravity_in_static_force=(0.0, -0.2))  # fmt: skip
    on_axis = np.zeros(2), np.zeros(2)
    for run in (run_up(disc, start=(0.0, 0.0, 0.0, 0.0), **case),
                run_up(system, speed=0.7, start=on_axis, **case),
                run_up(told, speed=0.7, start=on_axis, **case)):  # fmt: skip
        np.testing.assert_allclose(run.speed, exact, rtol=0.0, atol=6e-9)


def test_several_unbalances_have_the_moment_of_their_weight_and_other_forces_none():
    system, start = rotor(damped=True)
    force = np.array([0.1, -0.2, 0.0, 0.3, -0.1, 0.0])
    torque = (0.05, 0.1)
    run = run_up(system, **RUN, torque=torque, start=start, static_force=force)
    exact = lagrange(system, start, torque, force)
    np.testing.assert_allclose(run.speed, exact, rtol=0.0, atol=1e-9)
    weightless = run_up(system, **RUN | {"gravity": None}, torque=torque, start=start,
                        static_force=force + system.mass @ np.tile(GRAVITY, 3))  # fmt: skip
    assert np.abs(weightless.speed - exact).max() > 0.1
