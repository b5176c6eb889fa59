"""Axisymmetric rotor systems: random ones, and a beam of finite elements."""

import numpy as np
from scipy.linalg import block_diag

from rotor_ida import Contact, RotorSystem, Stator, Unbalance

QUARTER = np.array([[0.0, -1.0], [1.0, 0.0]])


def real(matrix):
    """Return a complex matrix as a real one of pairs x, y."""
    return np.kron(matrix.real, np.eye(2)) + np.kron(matrix.imag, QUARTER)


def random_axisymmetric(seed, *, turned=False, contacts=2, stiffest=30.0):
    """Return a random system, and its contacts and unbalance.

    `turned` gives it in coordinates in which no displacement of a node is one.
    """
    rng = np.random.default_rng(seed)
    count = int(rng.integers(2, 6))
    bent, more, turning = rng.normal(size=(3, count, count))
    stiffness = bent @ bent.T / count + 0.2 * np.eye(count)
    matrices = {
        "mass": real(np.eye(count) + 0.2 * more @ more.T / count),
        "stiffness": real(stiffness),
        "damping": real(rng.uniform(0.02, 0.2) * np.eye(count) + 0.03 * stiffness),
        "gyroscopic": real(-0.1j * (turning + turning.T)),
    }
    basis = np.eye(2 * count)
    if turned:
        basis = np.random.default_rng(seed).normal(size=basis.shape)
    system = RotorSystem(
        **{name: basis.T @ each @ basis for name, each in matrices.items()},
        nodes={f"n{i}": basis[2 * i : 2 * i + 2] for i in range(count)}, units="1",
    )  # fmt: skip
    stators = (None, Stator(mass=0.7, stiffness=3.0, damping=0.2), f"n{count - 1}")
    around = [
        Contact(
            node=f"n{i}", clearance=rng.uniform(0.3, 1.5), stiffness=rng.uniform(1.0, stiffest),
            exponent=float(rng.choice([1.0, 1.5])), damping=float(rng.choice([0.0, 0.4])),
            friction=float(rng.choice([0.0, 0.2])), radius=4.0,
            stator=stators[int(rng.integers(3 if count > 2 and i < count - 1 else 2))],
        )
        for i in range(min(contacts, count))
    ]  # fmt: skip
    unbalance = [Unbalance(node=f"n{i}", moment=rng.uniform(0.2, 1.0), phase=2.0 * i)
                 for i in range(2)]  # fmt: skip
    return system, around, unbalance


def beam(count=10, *, soft=5e6):
    """Return a shaft of steel with two discs on two bearings, four degrees of freedom a node.

    Euler and Bernoulli's elements of 50 mm, 20 mm thick; a node has x, y and the tilts about x, y.
    """
    L, area, second, modulus, density = 0.05, np.pi * 1e-4, np.pi * 1e-8 / 4.0, 211e9, 7810.0
    bend = np.array([[12, 6 * L, -12, 6 * L], [6 * L, 4 * L**2, -6 * L, 2 * L**2],
                     [-12, -6 * L, 12, -6 * L], [6 * L, 2 * L**2, -6 * L, 4 * L**2]])  # fmt: skip
    inert = np.array([[156, 22 * L, 54, -13 * L], [22 * L, 4 * L**2, 13 * L, -3 * L**2],
                      [54, 13 * L, 156, -22 * L],
                      [-13 * L, -3 * L**2, -22 * L, 4 * L**2]])  # fmt: skip
    size = 4 * (count + 1)
    mass, stiffness, damping, gyroscopic = np.zeros((4, size, size))
    flipped = np.diag([1.0, -1.0, 1.0, -1.0])  # a tilt about x moves y backwards
    for first in range(0, 4 * count, 4):
        along = np.ix_(*[[first + i for i in (0, 3, 4, 7)]] * 2)
        across = np.ix_(*[[first + i for i in (1, 2, 5, 6)]] * 2)
        stiffness[along] += modulus * second / L**3 * bend
        stiffness[across] += modulus * second / L**3 * flipped @ bend @ flipped
        mass[along] += density * area * L / 420 * inert
        mass[across] += density * area * L / 420 * flipped @ inert @ flipped
    for node in (4 * (count // 3), 4 * (2 * count // 3 + 1)):
        mass[node : node + 4, node : node + 4] += block_diag(1.72 * np.eye(2), 1.6e-3 * np.eye(2))
        gyroscopic[node + 2, node + 3] += 3.1e-3
        gyroscopic[node + 3, node + 2] -= 3.1e-3
    for node in (0, 4 * count):
        stiffness[node : node + 2, node : node + 2] += soft * np.eye(2)
        damping[node : node + 2, node : node + 2] += 200.0 * np.eye(2)
    return RotorSystem(
        mass=mass, stiffness=stiffness, damping=damping, gyroscopic=gyroscopic,
        nodes={str(i): (4 * i, 4 * i + 1) for i in range(count + 1)},
    )  # fmt: skip
