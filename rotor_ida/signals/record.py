"""Datasets of signals: make one from a run, check it, and read it as arrays."""

from __future__ import annotations

import math
from collections.abc import Hashable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt
import xarray as xr

from rotor_ida.arrays import Values
from rotor_ida.checks import check_increasing, check_instance, shown
from rotor_ida.errors import InputError
from rotor_ida.model.parameters import ALL_PARAMETERS
from rotor_ida.results.checked_run import is_of_system, refuse_system, samples_in
from rotor_ida.schema import QUANTITIES, Column, labelled, labelled_dataset, origin_of
from rotor_ida.signals.keyphasor import angles_by_pulses, check_per_revolution
from rotor_ida.signals.nodes import OF_NODE, at_node
from rotor_ida.signals.sampling import check_sampling, run_angles, velocities_of

FEWEST_SAMPLES = 16
# Times that were written with few digits are still equally spaced: of a step.
UNEQUAL = 0.01
# Origins of an angle that no mark tells: that of a speed, and one of several pulses a revolution.
UNKNOWN, ONE_OF_SEVERAL = "unknown", "one of several pulses"
# Mean position from which displacements of measured signals are counted.
MEAN = ("mean_x", "mean_y")


@dataclass(frozen=True)
class Record:
    """Signals as arrays.

    Parameters
    ----------
    times : ndarray, shape (n,)
        Times of the samples.
    z : ndarray of complex, shape (n,)
        Displacements ``x + i y``.
    angles : ndarray, shape (n,), or None
        Angle of the rotor [rad], if it is known.
    length, time : str
        Units of displacements and times.
    coordinates : mapping
        The given parameters of the rotor; of a rotor system the node and its clearance; of measured
        signals the mean position that was subtracted.
    attributes : mapping
        Attributes that results inherit.
    """

    times: Values
    z: npt.NDArray[np.complex128]
    angles: Values | None
    length: str
    time: str
    coordinates: Mapping[str, xr.Variable]
    attributes: Mapping[str, object]

    @property
    def has_mark(self) -> bool:
        """Whether angles are known and counted from a mark on the shaft."""
        return self.angles is not None and not lacks_mark(self.attributes)

    @property
    def mean(self) -> complex:
        """Position from which displacements are counted."""
        return mean_of(self.coordinates)

    def known_angles(self) -> Values:
        """Return the angles of the rotor; raise `InputError` if they are not known."""
        if self.angles is None:
            raise InputError("signals must contain angle, keyphasor or omega, got none of them")
        return self.angles

    def pulses(self) -> Values:
        """Return the times at which the shaft's mark passes the keyphasor, once per revolution."""
        if self.angles is None:
            return np.empty(0)
        turns = self.angles / (2.0 * math.pi)
        whole = np.arange(math.ceil(turns[0] - 1e-9), math.floor(turns[-1] + 1e-9) + 1)
        return np.interp(whole, turns, self.times)

    def equal_step(self) -> float:
        """Return the step of equally spaced times."""
        steps, count = np.diff(self.times), self.times.size
        mean = float(self.times[-1] - self.times[0]) / (count - 1)
        off = np.abs(self.times - (self.times[0] + mean * np.arange(count))).max()
        if off > UNEQUAL * mean:
            raise InputError(
                "signals must have equally spaced samples, got steps from "
                f"{steps.min():.6g} to {steps.max():.6g}"
            )
        return mean

    def variable(
        self, name: str, dims: Hashable | Sequence[Hashable], values: npt.ArrayLike
    ) -> xr.Variable:
        """Return values labelled by name, in the units of the signals."""
        variable = labelled(name, dims, values)
        scale = QUANTITIES[name].scale
        inverse = "1" if self.time == "1" else f"{self.time}-1"
        units = {"length": self.length, "time": self.time, "rate": inverse, "speed": inverse}
        if scale in units:
            variable.attrs["units"] = units[scale]
        return variable

    def dataset(
        self,
        title: str,
        variables: Mapping[str, Column],
        coordinates: Mapping[str, Column],
        attributes: Mapping[str, object] | None = None,
        *,
        kind: str,
    ) -> xr.Dataset:
        """Return a result with the units, parameters and origin of the signals."""
        return labelled_dataset(
            title,
            {name: self.variable(name, *column) for name, column in variables.items()},
            {
                **self.coordinates,
                **{name: self.variable(name, *column) for name, column in coordinates.items()},
            },
            {**self.attributes, **(attributes or {})},
            kind=kind,
        )


def lacks_mark(attributes: Mapping[str, object]) -> bool:
    """Return whether no mark is the origin of the angle: that of a speed, or one of many pulses."""
    return attributes.get("angle_origin") in (UNKNOWN, ONE_OF_SEVERAL)


def mean_of(coordinates: Mapping[Any, xr.Variable | xr.DataArray]) -> complex:
    """Return the position from which displacements of signals are counted: 0 by default."""
    x, y = (float(coordinates[name]) if name in coordinates else 0.0 for name in MEAN)
    return complex(x, y)


def position_text(mean: complex, length: str) -> str:
    """Return a position in words.

    Examples
    --------
    >>> position_text(1275.36 - 8.0j, "um")
    'x 1275 um, y -8 um'
    """
    unit = "" if length == "1" else f" {length}"
    x, y = (0.0 if abs(each) < 1e-9 * abs(mean) else each for each in (mean.real, mean.imag))
    return f"x {x:.4g}{unit}, y {y:.4g}{unit}"


def signals_of(run: xr.Dataset, *, node: str | None = None) -> xr.Dataset:
    """Return the signals that two probes and a keyphasor would measure in a run.

    Parameters
    ----------
    run : Dataset
        A run of `rotor_ida.simulate` or `rotor_ida.run_up`, or part of one, also in SI units.
    node : str, optional
        Node at which the probes look at the shaft of a rotor system; required there.

    Returns
    -------
    Dataset
        Displacements ``x y`` and ``angle``, that of the unbalance [rad], on ``t``; the parameters
        of the rotor as scalars. `rotor_ida.read_signals` returns the same, possibly with pulse
        times, ``keyphasor`` on ``pulse``, instead of ``angle``. Of a rotor system the scalars are
        the name of the ``node`` and its ``clearance``: NaN unless it has just one contact on
        the ground, centred on it.

    Raises
    ------
    InputError
        If the dataset has no displacements over time, or no angle; or if the node is missing or
        unknown.

    Notes
    -----
    At a constant speed the angle is ``omega t``; otherwise it is the ``angle`` of the run. The
    functions that take signals take runs of one disc as they are, too. In a rotor system an
    unbalance of phase 0 is at that angle, and displacements are those in space, also inside a
    stator that moves.

    Examples
    --------
    >>> from rotor_ida import Rotor, simulate
    >>> run = simulate(Rotor(omega=1.2, zeta=0.5, delta0=0.5), start=(0, 0, 0, 0), duration=60.0)
    >>> seen = signals_of(run)
    >>> sorted(seen.data_vars), seen.angle[-1].item()
    (['angle', 'x', 'y'], 72.0)
    """
    check_instance("run", run, xr.Dataset)
    if is_of_system(run):
        run = at_node(run, node)
    elif node is not None:
        raise InputError(
            f"node must be left out but for a run of a rotor system, got {shown(node)}"
        )
    record = record_of(run, "run")
    columns: dict[str, Column] = {
        "x": ("t", record.z.real),
        "y": ("t", record.z.imag),
        "angle": ("t", record.known_angles()),
    }
    return record.dataset(
        "Signals of two probes", columns, {"t": ("t", record.times)}, kind="signals"
    )


def record_of(signals: object, name: str = "signals") -> Record:
    """Return signals, or a run, as arrays; with a keyphasor, the part between its pulses."""
    given = check_instance(name, signals, xr.Dataset)
    refuse_system(name, given)
    missing = [each for each in ("t", "x", "y") if each not in given.variables]
    if missing:
        raise InputError(f"{name} must contain t, x and y; it lacks {', '.join(missing)}")
    times = samples_in(name, given, "t")
    if times.size < FEWEST_SAMPLES:
        raise InputError(f"{name} must have at least {FEWEST_SAMPLES} samples, got {times.size}")
    check_increasing("t", times)
    z = samples_in(name, given, "x") + 1j * samples_in(name, given, "y")
    within, angles = _angles(given, times, name)
    velocities = velocities_of(given)
    if within.sum() < FEWEST_SAMPLES:
        raise InputError(
            f"{name} must have at least {FEWEST_SAMPLES} samples between the pulses of the "
            f"keyphasor, got {within.sum()}"
        )
    seen = None if velocities is None else velocities[within]
    check_sampling(name, times[within], z[within], seen, angles)
    return Record(
        times[within],
        z[within],
        angles,
        _unit_of(name, given["x"]),
        _unit_of(name, given["t"]),
        {
            each: given[each].variable.to_base_variable()
            for each in (*ALL_PARAMETERS, *OF_NODE, *MEAN)
            if each in given.variables and not given[each].ndim
        },
        origin_of(given),
    )


def _angles(
    given: xr.Dataset, times: Values, name: str
) -> tuple[npt.NDArray[np.bool_], Values | None]:
    """Return the samples at which the angle is known, and the angles there."""
    everywhere = np.ones(times.size, dtype=bool)
    if "keyphasor" in given.variables:
        pulses = samples_in(name, given, "keyphasor", ("pulse",))
        per_revolution = check_per_revolution(given.attrs.get("pulses_per_revolution", 1))
        return angles_by_pulses(pulses, times, per_revolution)
    angles = run_angles(given, times)
    if "angle" in given.variables and angles is not None:
        falls = np.flatnonzero(np.diff(angles) < 0.0)
        if falls.size:
            raise InputError(
                f"angle of {name} must never fall, but does at t {times[falls[0]]:.6g}"
            )
    return everywhere, angles


def _unit_of(name: str, variable: xr.DataArray) -> str:
    """Return the unit of a variable."""
    unit = variable.attrs.get("units", "1")
    if not isinstance(unit, str) or not unit.isprintable():
        raise InputError(f"the unit of {variable.name} of {name} must be text, got {shown(unit)}")
    return unit
