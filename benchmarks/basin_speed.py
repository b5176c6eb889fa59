"""Core time a start: this package's kernel beside heyoka's batch integrator.

heyoka integrates the same starts on the rotating axes for 100 time units, at its default tolerance
and at this package's, with the batch size that it recommends. The kernel does the same work, and
then what it is for: labels every start. The same tolerance does not mean the same error: with its
steps inside one branch of the force, heyoka at 1e-6 is about as exact as the kernel at 1e-8 where
there is no clearance; with clearance its steps do not see the ring and its orbits are wrong.

    python benchmarks/basin_speed.py --delta0 0 --cells 512
"""

import argparse
import time

import heyoka as hy
import numpy as np

from rotor_ida import Rotor
from rotor_ida.basins.disc import RTOL, Disc
from rotor_ida.basins.following import follow_starts
from rotor_ida.basins.kernel import NO_CONTACT_FREE, NOT_COMPUTED, REGION, SECTION, follow
from rotor_ida.parallel import Workers
from rotor_ida.results.studies.results import Results

HALF_WIDTH = 15.0
SPAN = 100.0
GO_ON = np.zeros(1, dtype=np.uint8)


def grid(cells):
    """Return starts at rest on a square, shape (4, cells**2)."""
    axis = np.linspace(-HALF_WIDTH, HALF_WIDTH, cells)
    states = np.zeros((4, cells**2))
    states[0], states[1] = (part.ravel() for part in np.meshgrid(axis, axis, indexing="ij"))
    return states


def heyoka_integrator(rotor, batch, **options):
    """Return heyoka's integrator of so many starts at a time."""
    x, y, u, v = hy.make_vars("x", "y", "u", "v")
    omega, zeta, delta0 = rotor.omega, rotor.zeta, rotor.delta0
    square = x * x + y * y
    if delta0 == 0.0:
        stiffness = hy.sqrt(hy.sqrt(square))
    else:
        radius = hy.sqrt(square)
        # Taylor series of sqrt at 0 are not finite: keep the root away from it
        depth = hy.select(hy.gt(radius, delta0 + 1e-12), radius - delta0, hy.expression(1e-12))
        inside = hy.select(hy.gt(radius, delta0 + 1e-12), hy.expression(1.0), hy.expression(0.0))
        stiffness = inside * depth * hy.sqrt(depth) / radius
    system = [
        (x, u + omega * y),
        (y, v - omega * x),
        (u, omega**2 - 2.0 * zeta * u + omega * v - stiffness * x),
        (v, -2.0 * zeta * v - omega * u - stiffness * y),
    ]
    return hy.taylor_adaptive_batch(system, state=np.ones((4, batch)), **options)


def time_of_heyoka(rotor, states, batch, **options):
    """Return core time a start [s] of heyoka over SPAN."""
    integrator = heyoka_integrator(rotor, batch, **options)
    count = states.shape[1] // batch * batch
    began = time.process_time()
    for first in range(0, count, batch):
        integrator.set_time(0.0)
        integrator.state[:] = states[:, first : first + batch]
        integrator.propagate_until(SPAN)
    return (time.process_time() - began) / count


def time_of_kernel(rotor, states, tolerance):
    """Return core time a start [s] of the kernel over the same span, with nothing to capture."""
    nothing = np.empty(0, REGION), NO_CONTACT_FREE, np.empty(0, SECTION)
    for _ in range(2):  # the first finds the library
        copy = states.copy()
        labels = np.full(states.shape[1], NOT_COMPUTED, dtype=np.int16)
        times = np.zeros(states.shape[1], dtype=np.float32)
        began = time.process_time()
        follow(copy, labels, times, rotor, *nothing, SPAN, tolerance, GO_ON)
        took = time.process_time() - began
    return took / states.shape[1]


def main():
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--omega", type=float, default=1.7)
    parser.add_argument("--zeta", type=float, default=0.07)
    parser.add_argument("--delta0", type=float, default=0.0)
    parser.add_argument("--cells", type=int, default=512)
    parser.add_argument("--heyoka-starts", type=int, default=4096)
    parser.add_argument("--workers", type=int, default=1)
    parser.add_argument("--rtol", type=float, default=RTOL)
    given = parser.parse_args()
    rotor = Rotor(omega=given.omega, zeta=given.zeta, delta0=given.delta0)
    states = grid(given.cells)
    some = states[:, np.random.default_rng(0).permutation(states.shape[1])[: given.heyoka_starts]]
    some = np.ascontiguousarray(some)
    for tolerance in (1e-5, 1e-6, 1e-7, 1e-8, 1e-10):
        took = 1e6 * time_of_kernel(rotor, some, tolerance)
        print(
            f"kernel, {SPAN:g} time units, rtol {tolerance:g}: {took:.2f} us of core time a start"
        )
    best = hy.recommended_simd_size()
    for batch in sorted({1, best, 2 * best}):
        for tolerance in (None, RTOL):
            options = {} if tolerance is None else {"tol": tolerance}
            took = 1e6 * time_of_heyoka(rotor, some, batch, **options)
            name = "default tolerance (2e-16)" if tolerance is None else f"tolerance {tolerance:g}"
            print(f"heyoka, batch {batch}, {name}: {took:.2f} us")
    disc = Disc.of(rotor, given.rtol, GO_ON)
    for _ in range(2):
        wall, core = time.perf_counter(), time.process_time()
        scouted = disc.with_cycles(states[:, :: max(states.shape[1] // 128, 1)], GO_ON)
        found = follow_starts(
            scouted, lambda a, b: states[:, a:b], states.shape[1], Results(),
            workers=Workers("threads", given.workers), progress=None,
        )  # fmt: skip
        wall, core = time.perf_counter() - wall, time.process_time() - core
    numbers, counts = np.unique(found.labels, return_counts=True)
    labels = dict(zip(numbers.tolist(), counts.tolist(), strict=True))
    print(
        f"all {states.shape[1]} labels, rtol {given.rtol:g}: "
        f"{1e6 * core / states.shape[1]:.2f} us of core time a start, {wall:.2f} s; {labels}"
    )


if __name__ == "__main__":
    main()
