"""Whether rubs of random rotor systems are lost, and how long a range of speeds takes.

Systems of 2 to 8 complex degrees of freedom, with a contact or two, at random speeds. Rubs at one
contact are counted once more in exact arithmetic, by Descartes' rule of signs. Rubs at two are
counted along one of the unknowns: where it is given, the other is a root of a polynomial of one
variable, and the balance that is left changes its sign along each such root. Residuals are those of
the balance of forces. Growth rates are those of a beam without contact, whose decisive eigenvalue
turns 10 million times faster than it decays, against inverse iterations with 40 digits.

    python benchmarks/exact_rubs.py --systems 1000 --steps 2000
"""

import argparse
import time
from collections import Counter

import mpmath
import numpy as np

from rotor_ida import Contact, Unbalance, synchronous_response
from rotor_ida.closed_forms.exact_polynomials import Polynomial, constant, isolated_roots
from rotor_ida.closed_forms.whirls.double_rubs import Pairs, balance, double_rubs
from rotor_ida.closed_forms.whirls.single_rubs import single_rubs
from rotor_ida.closed_forms.whirls.turning_axes import eigenvalues_without_contact
from rotor_ida.model.assembly import assemble
from rotor_ida.model.axisymmetric import forward_motions
from tests.axisymmetric_systems import beam


def random_numbers(rng):
    """Return displacements by unbalance and by contact forces, over clearances."""
    size = int(rng.integers(2, 9))
    bent = rng.normal(size=(size, size))
    stiffness = bent @ bent.T / size + 0.1 * np.eye(size)
    omega = rng.uniform(0.2, 2.5)
    damping = np.exp(rng.uniform(np.log(0.003), np.log(0.3)))
    flexible = np.linalg.inv(stiffness + (1j * omega * damping - omega**2) * np.eye(size))
    force = omega**2 * rng.normal(size=size) * np.exp(2j * np.pi * rng.uniform(size=size))
    clearance, k = rng.uniform(0.2, 2.0, 2), np.exp(rng.uniform(-1.0, 5.0, 2))
    turned = k * (1.0 + 1j * rng.choice([0.0, 0.1, 0.3], 2))
    effect = flexible[:2, :2] * turned * clearance / clearance[:, np.newaxis]
    return (flexible @ force)[:2] / clearance, effect


def exact_count(free, effect, hertz):
    """Return the number of rubs at one contact, in exact arithmetic."""
    x = Polynomial((0, 1))
    depth, force = (x * x, x * x * x) if hertz else (x, x)
    real = constant(1) + depth + constant(float(effect.real)) * force
    across, beyond = constant(float(effect.imag)) * force, constant(float(free))
    return len(isolated_roots((real * real + across * across - beyond * beyond).whole))


def scanned(free, effect, hertz, steps):
    """Return pairs of unknowns around each rub at two contacts that a scan along v_2 finds."""
    v = np.geomspace(1e-4, 1e4, steps)
    b, a = (v**3, v**2) if hertz[1] else (v, v)
    right = np.abs((1 + a + effect[1, 1] * b) * free[0] - effect[0, 1] * b * free[1]) ** 2
    lead, shift = effect[0, 0] * free[1] - effect[1, 0] * free[0], free[1]
    # |shift (1 + a(v_1)) + lead b(v_1)|**2 = right
    if hertz[0]:
        terms = [abs(lead) ** 2, 2 * (lead * shift.conjugate()).real, abs(shift) ** 2,
                 2 * (lead * shift.conjugate()).real, 2 * abs(shift) ** 2, 0.0]  # fmt: skip
    else:
        terms = [abs(lead + shift) ** 2, 2 * ((lead + shift) * shift.conjugate()).real]
    companion = np.zeros((steps, len(terms), len(terms)))
    companion[:, np.arange(1, len(terms)), np.arange(len(terms) - 1)] = 1.0
    companion[:, 0] = -np.array([*terms[1:], 0.0]) / terms[0]
    companion[:, 0, -1] = -(abs(shift) ** 2 - right) / terms[0]
    roots = np.linalg.eigvals(companion)
    found, before = [], None
    for place, here in zip(v, roots, strict=True):
        real = np.sort(here.real[(np.abs(here.imag) < 1e-9 * np.abs(here)) & (here.real > 0)])
        both = np.column_stack([real, np.full(real.size, place)])
        left = balance(np.tile(free, (real.size, 1)), np.tile(effect, (real.size, 1, 1)),
                       hertz, both)[0][:, 0]  # fmt: skip
        if before is not None and len(before[0]) == real.size:
            for old, new, was, now in zip(before[0], both, before[1], left, strict=True):
                if was * now < 0.0:
                    found.append((old, new))
        before = both, left
    return found


def compare(systems, steps):
    """Compare numbers of rubs of random systems, and print them."""
    rng = np.random.default_rng(1)
    numbers = [random_numbers(rng) for _ in range(systems)]
    free, effect = (np.array(each) for each in zip(*numbers, strict=True))
    for hertz in (True, False):
        rows, _ = single_rubs(np.abs(free[:, 0]), effect[:, 0, 0], hertz=hertz)
        ours = np.bincount(rows, minlength=systems)
        exact = [exact_count(float(np.abs(free[i, 0])), complex(effect[i, 0, 0]), hertz)
                 for i in range(systems)]  # fmt: skip
        print(
            f"one contact, exponent {1.5 if hertz else 1}: {(ours != exact).sum()} of {systems} "
            f"systems with other numbers; systems by number {sorted(Counter(exact).items())}"
        )
    for hertz in ((True, True), (False, False), (True, False)):
        began = time.perf_counter()
        rows, depths, boxes = double_rubs(Pairs(free, effect, hertz))
        took = time.perf_counter() - began
        v = np.where(hertz, np.sqrt(depths), depths)
        worst = np.abs(balance(free[rows], effect[rows], hertz, v)[0]).max()
        lost = seen = 0
        for i in range(systems):
            for one, other in scanned(free[i], effect[i], hertz, steps):
                low, high = np.minimum(one, other), np.maximum(one, other)
                inside = (v[rows == i] >= 0.99 * low) & (v[rows == i] <= 1.01 * high)
                seen += 1
                lost += not inside.all(axis=1).any()
        print(
            f"two contacts, Hertz {hertz}: {rows.size} rubs, {lost} lost of {seen} that the scan "
            f"found; {boxes / systems:.1f} boxes and {1e6 * took / systems:.0f} us a system; "
            f"residual {worst:.1e}"
        )


def time_speeds():
    """Print how long 200 speeds of a beam take."""
    contacts = [Contact(node="3", clearance=1e-4, stiffness=5e6, exponent=1.0),
                Contact(node="6", clearance=1.5e-4, stiffness=2e10)]  # fmt: skip
    unbalance = [Unbalance(node=node, moment=2e-4) for node in "37"]
    for count in (1, 2):
        took = []
        for _ in range(5):
            began = time.perf_counter()
            found = synchronous_response(
                beam(), contacts=contacts[:count], unbalance=unbalance,
                speed=np.linspace(200.0, 900.0, 200),
            )  # fmt: skip
            took.append(time.perf_counter() - began)
        rubs = int((found.in_contact == 1).any("contact").sum())
        print(
            f"200 speeds, {count} contact(s), 44 degrees of freedom, {rubs} rubs: "
            f"{min(took):.2f} to {max(took):.2f} s"
        )


def compare_growth(speeds=(200.0, 426.0, 900.0)):
    """Print errors of growth rates."""
    system = beam()
    found = synchronous_response(
        system, unbalance=[Unbalance(node="3", moment=1e-4)], speed=list(speeds)
    ).growth_rate.values[:, 0]
    motions = forward_motions(assemble(system))
    mpmath.mp.dps = 40
    mass, stiffness, damping, gyroscopic = (
        mpmath.matrix(getattr(system, name).tolist())
        for name in ("mass", "stiffness", "damping", "gyroscopic")
    )
    for omega, growth in zip(speeds, found, strict=True):
        values = eigenvalues_without_contact(motions, np.array([omega]))[0]
        exact = mpmath.mpc(complex(values[np.argmax(values.real)]))
        drag = damping + omega * gyroscopic
        x = mpmath.matrix([1.0 + i % 7 for i in range(system.size)])
        y = x.copy()
        for _ in range(3):
            dynamic = stiffness + exact * drag + exact**2 * mass
            for _ in range(2):
                x, y = mpmath.lu_solve(dynamic, x), mpmath.lu_solve(dynamic.H, y)
                x, y = x / mpmath.norm(x), y / mpmath.norm(y)
            slope = (y.H * ((drag + 2 * exact * mass) * x))[0]
            exact -= (y.H * (dynamic * x))[0] / slope
        print(
            f"speed {omega:g}: eigenvalue {complex(exact):.6g}, relative error of its real part "
            f"{abs(float(growth / exact.real - 1)):.1e}"
        )


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--systems", type=int, default=1000)
    parser.add_argument("--steps", type=int, default=2000)
    asked = parser.parse_args()
    compare(asked.systems, asked.steps)
    compare_growth()
    time_speeds()
