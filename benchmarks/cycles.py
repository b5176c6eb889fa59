"""Measure limit cycles: the structure of their monodromy matrices, and what a branch costs.

The multipliers rest on a theorem: the flow is conformally symplectic, so they are 1, q, mu and q/mu
with q = exp(-2 zeta T). Here it is measured on the matrices as they were integrated, over every
stable cycle on the branches of Fig. 11, before anything is taken from it:

- trivial: |M f - f|/|f|, f the rate of change at the start;
- determinant: |det M/q**2 - 1|;
- partner: |lambda/q - 1|, with lambda the eigenvalue of M nearest to q;
- form: the largest element of M^T S M - q S, as a part of that with all signs positive.

Beside the second and the third stands what rounding alone may do there: the condition of the
determinant, and that of the eigenvalue, times the spacing of doubles. Where eigenvalues nearly
coincide, at a fold or where mu nears q, no program can do better.

    python benchmarks/cycles.py
    python benchmarks/cycles.py --speed
"""

from __future__ import annotations

import argparse
import time

import numpy as np
from scipy.linalg import eig

from rotor_ida import Rotor, branches_through, compare, continue_cycle, limit_cycle, sweep
from rotor_ida.cycles.multipliers import is_stable, symplectic_defect, trivial_defect
from rotor_ida.cycles.orbit import followed
from rotor_ida.simulation.flow import DiscFlow

ZETA, CLEARANCES = 0.07, [0.5, 1.0, 2.0]
SPEEDS = np.linspace(0.05, 3.0, 60)
NAMES = ("x", "y", "vx", "vy")
ROUNDING = 2.0**-52
# DESIGN's two cycles: period, largest radius, and the multipliers beside 1 and q.
KNOWN = {
    (2.0, 2.0): (4.563916675380, 4.104416607, complex(-0.51147221, 0.51598781)),
    (3.0, 0.5): (3.115214254929, 3.000222126, complex(0.53147652, 0.60337913)),
}


def main() -> None:
    """Print what was asked for."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--speed", action="store_true", help="only what a point of a branch costs")
    if parser.parse_args().speed:
        speed()
        return
    known()
    structure()
    speed()


def known() -> None:
    """Print how far the known cycles are met."""
    for (omega, delta0), (period, radius, mu) in KNOWN.items():
        cycle = limit_cycle(Rotor(omega=omega, zeta=ZETA, delta0=delta0), start=(3, 1, 0, 0))
        found = cycle.multiplier_real.values + 1j * cycle.multiplier_imag.values
        print(
            f"omega {omega:g}, delta0 {delta0:g}: period off by {abs(cycle.period - period):.1e}, "
            f"largest radius by {abs(cycle.radius_max - radius):.1e}, multipliers by "
            f"{np.abs(found - mu).min():.1e}; stated errors {cycle.period_error:.1e} and "
            f"{cycle.multiplier_error.max():.1e}"
        )


def structure() -> None:
    """Print the largest defects over all stable cycles of the branches of Fig. 11."""
    compared = []
    for ways in ({}, {"direction": "both"}):
        swept = sweep(omega=SPEEDS, zeta=ZETA, delta0=CLEARANCES, **ways)
        compared.append(compare(swept))
    branches = []
    for each in compared:
        branches += branches_through(each, limits=(0.05, 3.0))
    rows, worst = [], 0.0
    for branch in branches:
        for number in np.flatnonzero(branch.stability.values == 1).tolist():
            point = branch.isel(point=number)
            rotor = Rotor(omega=float(point.omega), zeta=ZETA, delta0=float(point.delta0))
            state = np.array([float(point[name]) for name in NAMES])
            orbit = followed(DiscFlow(rotor), state, float(point.period))
            if is_stable(orbit):
                rows.append(defects(orbit))
                worst = max(worst, float(point.period))
    table = np.array(rows)
    names = ("trivial", "determinant", "its rounding", "partner", "its rounding", "form")
    print(f"\n{len(rows)} stable cycles on {len(branches)} branches, periods up to {worst:.1f}")
    for name, column in zip(names, table.T, strict=True):
        print(f"{name:>14}: largest {column.max():.1e}, median {np.median(column):.1e}")
    beyond = (table[:, 3] > 1e-8).sum()
    print(f"partner beyond 1e-8 at {beyond}, of which forbidden by its condition "
          f"{((table[:, 3] > 1e-8) & (table[:, 4] > 1e-10)).sum()}")  # fmt: skip
    digits = np.concatenate([each.digits.values[each.lies_on.values == 2] for each in compared])
    print(f"simulated by CVODE on {digits.size} cycles: {digits.min():.1f} digits or more, "
          f"median {np.median(digits):.1f}")  # fmt: skip


def defects(orbit) -> tuple[float, ...]:
    """Return by how much a matrix breaks its structure, and what rounding may do to it."""
    matrix, q = orbit.monodromy, orbit.pair_product
    trivial, form = trivial_defect(orbit), symplectic_defect(orbit)
    size = np.linalg.norm(matrix) * np.linalg.norm(np.linalg.inv(matrix))
    values, left, right = eig(matrix, left=True)
    place = int(np.argmin(np.abs(values - q)))
    angle = abs(np.vdot(left[:, place], right[:, place]))
    spread = np.linalg.norm(matrix) / (angle * q)
    determinant = abs(np.linalg.det(matrix) / q**2 - 1.0)
    partner = abs(values[place] / q - 1.0)
    return trivial, determinant, ROUNDING * size, partner, ROUNDING * spread, form


def speed() -> None:
    """Print what a point costs on the isola at delta0 = 2, special points and all."""
    rotor = Rotor(omega=2.0, zeta=ZETA, delta0=2.0)
    cycle = limit_cycle(rotor, start=(0, 0, 0, 0))
    taken = []
    for _ in range(5):
        begin = time.process_time()
        branch = continue_cycle(rotor, start=cycle, limits=(0.05, 5.0))
        taken.append((time.process_time() - begin) / branch.sizes["point"])
    print(f"\na point of the isola at delta0 = 2, of {branch.sizes['point']} with "
          f"{branch.sizes['special']} special ones: {1e3 * min(taken):.2f} ms of one core (fastest "
          f"of 5; slowest {1e3 * max(taken):.2f})")  # fmt: skip


if __name__ == "__main__":
    main()
