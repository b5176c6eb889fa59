"""Exact results of the rotor of an archive, to be drawn beneath a plot of its motion.

At constant speed these are the limit cycle that the motion settles on, or the whirls. Over speeds
it is the response curve with its special points. While the speed changes it is the motion in
flight, up to the first touch.
"""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import xarray as xr

import rotor_ida
from rotor_ida.arrays import Values
from rotor_ida.checks import COMPONENTS
from rotor_ida.closed_forms import ramp_flight, response_curve, rest
from rotor_ida.closed_forms.contact_free import complex_amplitude
from rotor_ida.errors import InputError
from rotor_ida.model.parameters import PARAMETERS
from rotor_ida.model.rotor import Rotor
from rotor_ida.results.checked_run import parameter_coordinates, rotor_of
from rotor_ida.results.si_units import EXACT
from rotor_ida.schema import LINE_KIND, labelled_dataset, words_of
from rotor_ida.signals.record import Record, record_of

OVER_SPEED = ("bode", "polar", "orders")
OVER_FREQUENCY = ("cascade", "spectrogram")
# The curve extends past the speeds of the run by this fraction of their range.
BEYOND_RUN = 0.02
# Responses for which a limit cycle is computed; no other response has separate exact lines.
CYCLES = ("bouncing", "full_contact", "rolling")
STEADY = 1e-3
# Number of speeds of a run-up with backward whirls, and points of one revolution.
WHIP_SPEEDS, POINTS = 24, 361


def exact_beneath(dataset: xr.Dataset, kind: str) -> list[xr.Dataset]:
    """Return the exact results for a kind of plot, for the rotor of the dataset.

    Parameters
    ----------
    dataset : Dataset
        A run, a run-up or signals with the parameters of the rotor.
    kind : str
        Kind of the plot, as in the command ``plot``.

    Raises
    ------
    InputError
        If a parameter is missing, or no exact result exists for the plot.
    """
    record = record_of(dataset)
    rotor = _rotor_of(dataset)
    speeds = _speeds_of(dataset, record)
    last = _at(rotor, float(speeds[-1]))
    changes = bool(np.ptp(speeds) > STEADY * speeds.max())
    if kind in OVER_SPEED:
        found = _over_speed(rotor, speeds)
        return _some(found + ([] if changes else _cycle(last, dataset, record)), rotor, kind)
    if kind == "centreline":
        steady = [] if changes else _steady(last, dataset, record)
        return _some(_rest(rotor) + steady, rotor, kind)
    if kind == "orbit" or not changes:
        backward = [] if kind == "trace" else _backward([last])
        return _some(_steady(last, dataset, record) + backward, rotor, kind)
    if kind == "trace":
        return [_flight(dataset, record, rotor)]
    few = np.linspace(speeds.min(), speeds.max(), WHIP_SPEEDS).tolist()
    whips = _backward([_at(rotor, each) for each in few])
    points = _special_points(rotor, speeds)
    over = points + whips if kind in OVER_FREQUENCY else _backward([last])
    return _some(over, rotor, kind, changes=True)


def _some(
    found: list[xr.Dataset], rotor: Rotor, kind: str, *, changes: bool = False
) -> list[xr.Dataset]:
    """Return the exact results; raise an error if there are none."""
    if found:
        return found
    if changes:
        raise InputError(
            "exact must be left out: while the speed changes only folds, Hopf points and dry whip "
            f"are known exactly, and the {kind} shows none of these"
        )
    under = f" under a load, got load {rotor.load!r}" if rotor.load > 0.0 else ""
    raise InputError(f"exact must be left out: there is no exact result for the {kind}{under}")


def _over_speed(rotor: Rotor, speeds: Values) -> list[xr.Dataset]:
    """Return the response curve over the speeds of a run, with its folds and Hopf points."""
    low, high = (1.0 - BEYOND_RUN) * speeds.min(), (1.0 + BEYOND_RUN) * speeds.max()
    curve = response_curve(rotor, limits=(max(1e-6, float(low)), float(high)))
    if rotor.load > 0.0:
        return [curve] if curve.sizes["point"] else []
    return [curve, *_folds_and_hopf_points(rotor)]


def _folds_and_hopf_points(rotor: Rotor) -> list[xr.Dataset]:
    found = [rotor_ida.folds(rotor, contact_damping=0.0, load=0.0)]
    if rotor.friction > 0.0 or rotor.contact_damping > 0.0:
        found.append(rotor_ida.hopf_points(rotor, load=0.0))
    return found


def _special_points(rotor: Rotor, speeds: Values) -> list[xr.Dataset]:
    """Return folds and Hopf points, if there are any within the speeds of a run."""
    if rotor.load > 0.0:
        return []
    found = []
    for each in _folds_and_hopf_points(rotor):
        omega = each["fold_omega" if "fold_omega" in each.variables else "hopf_omega"].values
        if ((omega >= speeds.min()) & (omega <= speeds.max())).any():
            found.append(each)
    return found


def _backward(rotors: list[Rotor]) -> list[xr.Dataset]:
    """Return the backward whirls of rotors, where they exist."""
    found = [
        rotor_ida.backward_whirl(each)
        for each in rotors
        if each.friction > 0.0 and each.load == 0.0 and each.disc_radius
    ]
    return [each for each in found if np.isfinite(each["amplitude"].values).any()]


def _steady(rotor: Rotor, dataset: xr.Dataset, record: Record) -> list[xr.Dataset]:
    """Return the settled response at one speed: a limit cycle, or else the whirls."""
    cycle = _cycle(rotor, dataset, record)
    if cycle or rotor.load > 0.0:
        return cycle
    return [rotor_ida.synchronous_response(rotor)]


def _cycle(rotor: Rotor, dataset: xr.Dataset, record: Record) -> list[xr.Dataset]:
    """Return the limit cycle reached from the end of a record, if any."""
    if rotor.zeta == 0.0:  # nothing settles
        return []
    cycle = rotor_ida.limit_cycle(rotor, start=_end_of(dataset, record))
    word = words_of(cycle["response"])[0]
    if word in CYCLES:
        return [cycle]
    return [_hanging(rotor)] if word == "contact_free" and rotor.load > 0.0 else []


def _hanging(rotor: Rotor) -> xr.Dataset:
    """Return the motion clear of the stator under a load, in the form of a limit cycle.

    It is ``z = -i gamma/kappa + a exp(i omega t)``, linear and so exact.
    """
    offset = _offset(rotor)
    assert offset is not None  # without a shaft a load presses the rotor on the stator
    whirl = complex(complex_amplitude(rotor.omega, rotor.zeta, rotor.shaft_stiffness))
    period = 2.0 * math.pi / rotor.omega
    times = np.linspace(0.0, period, POINTS)
    z = whirl - 1j * offset * np.exp(-1j * rotor.omega * times)
    kinds = np.array([LINE_KIND["static"], LINE_KIND["spin"]], dtype=np.int8)
    return labelled_dataset(
        "Motion of a rotor under a load, clear of the stator",
        {
            "period": ((), period),
            "x": ("t", z.real),
            "y": ("t", z.imag),
            "whirl_amplitude": ("line", np.array([offset, abs(whirl)])),
            "line_kind": ("line", kinds),
            "frequency": ("line", np.array([0.0, rotor.omega])),
        },
        {"t": ("t", times), **parameter_coordinates(rotor)},
        kind="exact_motion",
    )


def _offset(rotor: Rotor) -> float | None:
    """Return the static sag of the rotor below the axis; None if it lies on the stator."""
    if rotor.load > 0.0 and rotor.shaft_stiffness == 0.0:
        return None
    smooth = replace(rotor, friction=0.0)  # in the clearance there is none
    place = rest(smooth)
    return -float(place["y"]) if float(place["indentation"]) == 0.0 else None


def _rest(rotor: Rotor) -> list[xr.Dataset]:
    """Return the place of rest of a rotor, if it has one."""
    if rotor.load == 0.0 and rotor.shaft_stiffness == 0.0:
        return []
    if rotor.friction > 0.0 and _offset(rotor) is None:
        return []  # friction holds it anywhere near the lowest point of the stator
    return [rest(replace(rotor, friction=0.0))]


def _flight(dataset: xr.Dataset, record: Record, rotor: Rotor) -> xr.Dataset:
    """Return the exact motion of a run-up from its start to its first touch."""
    start, rate = dataset.attrs.get("start"), dataset.attrs.get("rate")
    if start is None or rate is None:
        raise InputError(
            "exact must be left out: the trace of a run-up needs its start and rate, which only "
            "archives of run-up contain"
        )
    if rotor.load > 0.0:
        raise InputError(
            "exact must be left out: there is no exact result for the trace of a run-up under a "
            "load, got {load=}",
            load=rotor.load,
        )
    scale = dataset.attrs.get("time_scale", 1.0)
    times = record.times / scale
    slope = float(dataset.attrs.get(f"{EXACT}_rate", rate))
    # starts before the record, which may be a part of a run
    before = np.arange(0.0, times[0], times[1] - times[0])
    whole = np.concatenate([before, times])
    x, y, *_ = ramp_flight(whole, rotor=rotor, start=tuple(np.asarray(start)), rate=slope)
    touches = np.flatnonzero(np.hypot(x, y) >= rotor.delta0)
    seen = slice(before.size, int(touches[0]) if touches.size else whole.size)
    if seen.stop - seen.start < 2:
        raise InputError(
            "exact must be left out: the exact trace of a run-up ends at the first touch, and "
            f"these times begin after it, at {record.times[0]:g}"
        )
    columns = {"x": ("t", x[seen]), "y": ("t", y[seen])}
    return labelled_dataset(
        "Flight until the first touch",
        columns,
        {"t": ("t", whole[seen]), **parameter_coordinates(rotor)},
        kind="exact_motion",
    )


def _rotor_of(dataset: xr.Dataset) -> Rotor:
    """Return the rotor from the parameters of a dataset."""
    missing = [name for name in PARAMETERS if name not in dataset.variables]
    if missing:
        raise InputError(
            f"exact must be left out: the file lacks the parameters {', '.join(missing)}"
        )
    return rotor_of(dataset)


def _at(rotor: Rotor, omega: float) -> Rotor:
    """Return the rotor at another speed, or unchanged if the speed is equal to rounding."""
    return rotor if abs(omega - rotor.omega) <= STEADY * omega else replace(rotor, omega=omega)


def _speeds_of(dataset: xr.Dataset, record: Record) -> Values:
    """Return speeds along the record [dimensionless]."""
    angles, times = record.known_angles(), record.times / dataset.attrs.get("time_scale", 1.0)
    few = np.unique(np.linspace(0, times.size - 1, 200).astype(int))
    return np.asarray(np.diff(angles[few]) / np.diff(times[few]), dtype=np.float64)


def _end_of(dataset: xr.Dataset, record: Record) -> list[float]:
    """Return the last state of a record on the rotating axes [dimensionless]."""
    length, time = (dataset.attrs.get(f"{kind}_scale", 1.0) for kind in ("length", "time"))
    z = record.z[-9:] / length
    w = np.gradient(z, record.times[-9:] / time, edge_order=2)[-1]
    if set(COMPONENTS) <= set(dataset.variables) and "length_scale" not in dataset.attrs:
        w = complex(dataset["vx"].values[-1], dataset["vy"].values[-1])
    back = np.exp(-1j * float(record.known_angles()[-1]))
    place, speed = complex(z[-1] * back), complex(w * back)
    return [place.real, place.imag, speed.real, speed.imag]
