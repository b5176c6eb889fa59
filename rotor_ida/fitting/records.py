"""Measured data as compared: order tracks, weighed by their errors, and contact times."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
import xarray as xr

from rotor_ida.arrays import ComplexValues, Values
from rotor_ida.checks import check_increasing, check_nonnegative, check_vector, shown
from rotor_ida.errors import InputError
from rotor_ida.fitting.measured_angle import angle_at_samples, angle_by_pulses
from rotor_ida.fitting.motion import Body, Turning
from rotor_ida.results.checked_run import samples_in
from rotor_ida.schema.quantities import UNITS
from rotor_ida.signals.keyphasor import check_per_revolution
from rotor_ida.signals.orders import revolutions_for
from rotor_ida.signals.record import Record, record_of
from rotor_ida.signals.windows import Windows, windows_of
from rotor_ida.units import PREFIXES

# Integer orders up to this are fitted beside those that are asked for.
BESIDE = 3
MOST_SAMPLES = 1_000_000
# A cubic in the first part of a revolution [rad] gives a guess of the start, not a measurement: its
# spread is this many of its errors, and at least a tenth of the motion.
FIRST_PART, FEWEST = 1.5, 8
SPREAD, LEAST_SPREAD = 10.0, 0.1


@dataclass(frozen=True)
class Tracks:
    """Projection of the windows of a record on order tracks with independent errors.

    Parameters
    ----------
    windows : Windows
        The windows.
    orders : ndarray, shape (k,)
        Signed orders that are compared: negative for backward whirl, 0 for the mean position.
    basis : ndarray of complex, shape (m, n)
        ``exp(i n angle)`` of these and of the additional orders, at the samples.
    inverse : ndarray of complex, shape (windows, m, m)
        Inverse of the matrix of the normal equations.
    root : ndarray of complex, shape (windows, k, k)
        Cholesky factor of its block for the compared orders: their covariance over the variance of
        the noise.
    """

    windows: Windows
    orders: Values
    basis: ComplexValues
    inverse: ComplexValues
    root: ComplexValues

    @property
    def samples(self) -> int:
        """Number of samples in windows."""
        return int(self.windows.edges[-1])

    def amplitudes(self, values: ComplexValues) -> ComplexValues:
        """Return the amplitudes of orders by window, shape (windows, m, c), from (n, c) values."""
        starts = self.windows.edges[:-1]
        inside = values[: self.samples]
        sums = [np.add.reduceat(each.conj()[:, None] * inside, starts) for each in self.basis]
        found: ComplexValues = np.einsum("wjk,kwc->wjc", self.inverse, np.stack(sums))
        return found

    def weighed(self, values: ComplexValues) -> Values:
        """Return amplitudes of unit noise, real parts then imaginary ones, shape (2 w k, c)."""
        kept = self.amplitudes(values)[:, : self.orders.size]
        independent = np.linalg.solve(self.root, kept).reshape(-1, values.shape[1])
        return np.concatenate([independent.real, independent.imag])

    def first(self, part: float) -> Values:
        """Return 1 for each number of `weighed` in the first part of the windows, else 0."""
        count = self.windows.times.size
        inside = np.arange(count) < max(part * count, 1.0)
        return np.tile(np.repeat(inside.astype(float), self.orders.size), 2)

    def left(self, z: ComplexValues) -> tuple[float, int]:
        """Return the residual sum of squares after all orders, and its degrees of freedom.

        The residuals are those of the nodes, shape (n, node).

        The first of several windows is left out: a start that is forgotten within it is poorly
        constrained by its orders, and the error of that start is not noise.
        """
        inside = z[: self.samples].copy()
        amplitudes = self.amplitudes(z)
        counts = np.diff(self.windows.edges)
        for each, amplitude in zip(self.basis, np.moveaxis(amplitudes, 1, 0), strict=True):
            inside -= np.repeat(amplitude, counts, axis=0) * each[:, None]
        skipped = min(counts.size - 1, 1)
        later = inside[counts[:skipped].sum() :]
        free = 2 * (later.size - amplitudes[skipped:].size)
        return float((np.abs(later) ** 2).sum()), max(free, 1)


class SlowRoll(NamedTuple):
    """A slow roll that was subtracted at a node: its speeds [rad/s], and its error [m]."""

    speeds: Values
    error: float


@dataclass(frozen=True)
class Measured:
    """One record of signals as it is compared; in SI units if the machine is.

    Parameters
    ----------
    record : Record
        The signals of the first node.
    nodes : tuple of str
        The nodes at which probes look.
    z : ndarray of complex, shape (n, node)
        Their displacements ``x + i y`` [m].
    times : ndarray, shape (n,)
        Times from the beginning of the signals [s].
    turning : Turning
        The measured angle.
    other_turnings : list of Turning
        The same with each of its independent errors, one standard deviation; none without pulses.
    tracks : Tracks
        The projection on order tracks.
    start, spread : ndarray, shape (4, node)
        A guess of the first state ``(x, y, vx, vy)`` of each, and its spread [m, m/s].
    touches : mapping of int to ndarray
        Measured times at which contacts began (1) and ended (-1), from the beginning [s].
    begin : float
        Time at which the signals begin, in their own unit and origin.
    metre, second : float
        The units of the signals in metres and seconds.
    slow_rolls : tuple
        The slow roll that was subtracted at each node, or None.
    """

    record: Record
    nodes: tuple[str, ...]
    z: ComplexValues
    times: Values
    turning: Turning
    other_turnings: list[Turning]
    tracks: Tracks
    start: Values
    spread: Values
    touches: Mapping[int, Values]
    begin: float
    metre: float
    second: float
    slow_rolls: tuple[SlowRoll | None, ...]

    @property
    def tracked(self) -> int:
        """How many numbers of tracks are compared."""
        return 2 * self.tracks.orders.size * self.tracks.windows.times.size * len(self.nodes)

    def first(self, part: float) -> Values:
        """Return 1 for each of these numbers in the first part of the windows, else 0."""
        return np.repeat(self.tracks.first(part), len(self.nodes))

    def slow_whirl(self, body: Body) -> ComplexValues:
        """Return the whirl without contact that a slow roll of a body has, at all samples.

        Signals from which a slow roll was subtracted lack it; it is 0 at the other nodes.
        """
        if not any(self.slow_rolls):
            return np.zeros(1, dtype=np.complex128)
        found = np.zeros(self.z.shape, dtype=np.complex128)
        turned = self._turned()
        for place, (node, slow) in enumerate(zip(self.nodes, self.slow_rolls, strict=True)):
            if slow is not None:
                whirls = body.free_whirls([node], slow.speeds)[..., 0] * slow.speeds**2
                ahead, back = whirls.mean(axis=1)
                found[:, place] = ahead * turned + back * turned.conj()
        return found

    def slow_roll_errors(self) -> Iterator[ComplexValues]:
        """Yield what each independent error of the subtracted slow rolls adds to displacements."""
        turned = self._turned()
        for place, slow in enumerate(self.slow_rolls):
            if slow is None:
                continue
            for whirl in (turned, 1j * turned, turned.conj(), 1j * turned.conj()):
                found = np.zeros(self.z.shape, dtype=np.complex128)
                found[:, place] = slow.error * whirl
                yield found

    def _turned(self) -> ComplexValues:
        return np.asarray(np.exp(1j * self.record.known_angles()), dtype=np.complex128)

    @property
    def largest(self) -> float:
        """The largest displacement [m]."""
        return float(np.abs(self.z).max())


def noise_of(records: Sequence[Measured], motions: Sequence[ComplexValues] | None = None) -> float:
    """Return the standard deviation of x and y about motions, or about 0, after all orders."""
    about = [np.zeros(1, complex)] * len(records) if motions is None else motions
    sums = [each.tracks.left(each.z - z) for each, z in zip(records, about, strict=True)]
    squares, free = (sum(each) for each in zip(*sums, strict=True))
    # signals without noise are still rounded, and computed to a tolerance
    return max(math.sqrt(squares / free), 1e-9 * max(each.largest for each in records))


def measured(
    signals: Mapping[str, xr.Dataset],
    orders: Values,
    revolutions: int | None,
    touches: Mapping[int, object],
    *,
    in_si: bool,
    with_mean: bool,
) -> Measured:
    """Return the signals at nodes as they are compared; raise `InputError` if they cannot be."""
    nodes, given = tuple(signals), [record_of(each) for each in signals.values()]
    first = given[0]
    for node, each in zip(nodes, given, strict=True):
        if (each.length, each.time) != (first.length, first.time) or not (
            np.array_equal(each.times, first.times)
            and np.array_equal(each.known_angles(), first.known_angles())
        ):
            raise InputError(
                "signals of the nodes of a record must have the same times, angles and units, got "
                f"others at {shown(node)}"
            )
    length, time = _scale(first.length, "length", in_si), _scale(first.time, "time", in_si)
    if first.times.size > MOST_SAMPLES:
        raise InputError(
            f"signals must have at most {MOST_SAMPLES} samples for a fit, got {first.times.size}: "
            "give a part, or resample them"
        )
    begin = float(first.times[0])
    z = length * np.stack([each.z + each.mean if with_mean else each.z for each in given], axis=1)
    record = replace(first, times=(first.times - begin) * time, z=z[:, 0])
    tracks = _tracks_of(record, orders, revolutions)
    turning, other_turnings = _turnings(signals[nodes[0]], record, begin, time)
    times = np.minimum(record.times, turning.ends[-1])
    start, spread = _first_states(record, z, turning)
    return Measured(
        record, nodes, z, times, turning, other_turnings, tracks, start, spread,
        {
            kind: (_times_within(kind, each, first) - begin) * time
            for kind, each in touches.items() if each is not None
        },
        begin, length, time,
        tuple(_slow_roll_of(each.attributes, length, time) for each in given),
    )  # fmt: skip


def _slow_roll_of(attributes: Mapping[str, object], length: float, time: float) -> SlowRoll | None:
    """Return the slow roll that `rotor_ida.subtract_runout` has subtracted, None without."""
    if "slow_roll_speeds" not in attributes:
        return None
    speeds = check_vector("slow_roll_speeds", attributes["slow_roll_speeds"])
    error = check_nonnegative("slow_roll_error", attributes.get("slow_roll_error"))
    return SlowRoll(speeds / time, error * length)


def _scale(unit: str, kind: str, in_si: bool) -> float:
    """Return a unit in SI units; 1 for dimensionless signals."""
    wanted = (
        "DimensionalRotor, or a system in SI units,"
        if unit != "1" else "Rotor, or a system without units,"
    )  # fmt: skip
    if (unit != "1") != in_si:
        raise InputError(f"machine must be a {wanted} for signals with {kind} in {unit!r}")
    if not in_si:
        return 1.0
    prefix = unit.removesuffix(UNITS[kind])
    if not unit.endswith(UNITS[kind]) or prefix not in PREFIXES:
        raise InputError(f"signals must have a {kind} in {UNITS[kind]}, got {unit!r}")
    return 1.0 / PREFIXES[prefix]


def _times_within(kind: int, values: object, record: Record) -> Values:
    """Return measured contact times, checked."""
    name = "entries" if kind > 0 else "exits"
    times = check_increasing(name, check_vector(name, values))
    low, high = record.times[[0, -1]].tolist()
    wrong = times[(times < low) | (times > high)]
    if wrong.size:
        raise InputError(
            f"{name} must lie within the signals, from t {low:.6g} to {high:.6g}, got "
            f"{wrong[0]:.6g}"
        )
    return times


def _tracks_of(record: Record, orders: Values, revolutions: int | None) -> Tracks:
    """Return the projection of a record on order tracks."""
    windows = windows_of(record, revolutions_for(orders[orders > 0.0], revolutions))
    highest = max(BESIDE, int(np.abs(orders).max()))
    kept = np.unique(np.concatenate([orders, -orders]))
    whole = np.arange(-highest, highest + 1.0)
    every = np.concatenate([kept, whole[~np.isin(whole, kept)]])
    counts = np.diff(windows.edges)
    fewest = int(counts.argmin())
    rate = counts[fewest] / windows.revolutions
    if rate <= 2.0 * np.abs(every).max() or counts[fewest] <= every.size:
        raise InputError(
            f"signals must have more than {max(2 * highest, every.size)} samples per revolution "
            f"for a fit, got {rate:.3g} at t {windows.times[fewest]:.6g}"
        )
    angles = record.known_angles()[: windows.edges[-1]]
    basis = np.exp(1j * every[:, None] * angles)
    starts = windows.edges[:-1]
    gram = np.empty((counts.size, every.size, every.size), dtype=np.complex128)
    for row, each in enumerate(basis):
        gram[:, row] = np.add.reduceat(each.conj() * basis, starts, axis=1).T
    inverse: ComplexValues = np.asarray(np.linalg.inv(gram), dtype=np.complex128)
    root = np.linalg.cholesky(inverse[:, : kept.size, : kept.size])
    return Tracks(windows, kept, basis, inverse, np.asarray(root, dtype=np.complex128))


def _turnings(
    signals: xr.Dataset, record: Record, begin: float, time: float
) -> tuple[Turning, list[Turning]]:
    """Return the measured angle, and with its errors."""
    if "keyphasor" not in signals.variables:
        return angle_at_samples(record.times, record.known_angles()), []
    pulses = (samples_in("signals", signals, "keyphasor", ("pulse",)) - begin) * time
    step = 2.0 * math.pi / check_per_revolution(signals.attrs.get("pulses_per_revolution", 1))
    return angle_by_pulses(pulses, step * np.arange(float(pulses.size)), record.times)


def _first_states(record: Record, z: ComplexValues, turning: Turning) -> tuple[Values, Values]:
    """Return guesses of the first states, and their spread, shape (4, node)."""
    speed = float(turning.speeds[0])
    within = record.times <= FIRST_PART / speed
    count = max(int(within.sum()), FEWEST)
    times, z_first = record.times[:count], z[:count]
    basis = np.vander(times * speed, 4, increasing=True)
    found, *_ = np.linalg.lstsq(basis, z_first)
    squares = (np.abs(z_first - basis @ found) ** 2).sum(axis=0)
    noise = np.sqrt(squares / (2.0 * max(count - 4, 1)))
    errors = np.sqrt(np.diag(np.linalg.inv(basis.T @ basis))[:2])[:, None] * noise
    turned = record.known_angles() - record.known_angles()[0]
    size = LEAST_SPREAD * np.sqrt(np.mean(np.abs(z[turned <= 2.0 * np.pi]) ** 2, axis=0))
    spread = np.maximum(SPREAD * errors, size) * np.array([[1.0], [speed]])
    place, velocity = found[0], found[1] * speed
    start = np.stack([place.real, place.imag, velocity.real, velocity.imag])
    return start, np.repeat(np.maximum(spread, np.finfo(float).tiny), 2, axis=0)
