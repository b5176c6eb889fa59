"""What is known exactly of the rotor of an archive, to lie beneath a picture of its motion."""

from __future__ import annotations

import numpy as np
import xarray as xr

import rotor_ida
from rotor_ida.arrays import Values
from rotor_ida.checks import COMPONENTS
from rotor_ida.closed_forms import response_curve
from rotor_ida.errors import InputError
from rotor_ida.parameters import ALL_PARAMETERS, PARAMETERS, Rotor
from rotor_ida.schema import words_of
from rotor_ida.signals.record import Record, record_of

OVER_SPEED = ("bode", "polar", "orders")
AT_SPEED = ("orbit", "full-spectrum", "cascade", "spectrogram")
# The curve reaches beyond the speeds of the run by this part of them.
BEYOND_RUN = 0.02
# Limit cycles are followed to; what else a rotor settles on has no lines of its own.
CYCLES = ("bouncing", "full_contact", "rolling")
STEADY = 1e-3


def exact_beneath(dataset: xr.Dataset, kind: str) -> list[xr.Dataset]:
    """Return the exact results for a kind of picture, of the rotor that the labels tell."""
    if kind not in (*OVER_SPEED, *AT_SPEED):
        raise InputError(f"exact must be of {', '.join((*OVER_SPEED, *AT_SPEED))}, got {kind!r}")
    record = record_of(dataset)
    rotor = _rotor_of(dataset)
    speeds = _speeds_of(dataset, record)
    if kind in OVER_SPEED:
        return _over_speed(rotor, speeds)
    changes = np.ptp(speeds) > STEADY * speeds.max()
    last = _at(rotor, float(speeds[-1]))
    backward = [rotor_ida.backward_whirl(last)] if rotor.friction > 0.0 else []
    if changes:
        if not backward:
            raise InputError(
                "exact lines are not known while the speed changes, but for dry whip: "
                "the order 1 is that of every whirl"
            )
        return backward
    cycle = rotor_ida.limit_cycle(last, start=_end_of(dataset, record))
    if words_of(cycle["response"])[0] in CYCLES:
        return [cycle, *backward]
    if rotor.load > 0.0:
        return backward
    given = {name: getattr(rotor, name) for name in ALL_PARAMETERS[1:]}
    for name in ("load", "disc_radius"):  # no load, and the radius moves none of these whirls
        given.pop(name)
    return [rotor_ida.synchronous_response(omega=rotor.omega, **given), *backward]


def _over_speed(rotor: Rotor, speeds: Values) -> list[xr.Dataset]:
    """Return the response curve over the speeds of a run, with its folds and Hopf points."""
    if rotor.load > 0.0:
        raise InputError(f"exact must be of a rotor without load, got load {rotor.load!r}")
    given = {name: getattr(rotor, name) for name in ALL_PARAMETERS[1:]}
    for name in ("load", "disc_radius"):
        given.pop(name)
    low, high = (1.0 - BEYOND_RUN) * speeds.min(), (1.0 + BEYOND_RUN) * speeds.max()
    found = [response_curve(**given, limits=(max(1e-6, float(low)), float(high)))]
    of_folds = {name: value for name, value in given.items() if name != "contact_damping"}
    found.append(rotor_ida.folds(**of_folds))
    if rotor.friction > 0.0 or rotor.contact_damping > 0.0:
        found.append(rotor_ida.hopf_points(**given))
    return found


def _rotor_of(dataset: xr.Dataset) -> Rotor:
    """Return the rotor that the labels of a dataset tell."""
    missing = [name for name in PARAMETERS if name not in dataset.variables]
    if missing:
        raise InputError(
            "exact needs the parameters of the rotor in the file, as archives of runs have them; "
            f"it lacks {', '.join(missing)}"
        )
    names = (name for name in ALL_PARAMETERS if name in dataset.variables)
    return Rotor(**{name: float(dataset[name]) for name in names})


def _at(rotor: Rotor, omega: float) -> Rotor:
    """Return the rotor at another speed, or at its own where that is the same but for rounding."""
    if abs(omega - rotor.omega) <= STEADY * omega:
        return rotor
    return Rotor(**{name: getattr(rotor, name) for name in ALL_PARAMETERS} | {"omega": omega})


def _speeds_of(dataset: xr.Dataset, record: Record) -> Values:
    """Return speeds along the record [1]."""
    angles, times = record.known_angles(), record.times / dataset.attrs.get("time_scale", 1.0)
    few = np.unique(np.linspace(0, times.size - 1, 200).astype(int))
    return np.asarray(np.diff(angles[few]) / np.diff(times[few]), dtype=np.float64)


def _end_of(dataset: xr.Dataset, record: Record) -> list[float]:
    """Return the last state of a record on the rotating axes [1]."""
    length, time = (dataset.attrs.get(f"{kind}_scale", 1.0) for kind in ("length", "time"))
    z = record.z[-9:] / length
    w = np.gradient(z, record.times[-9:] / time, edge_order=2)[-1]
    if set(COMPONENTS) <= set(dataset.variables) and "length_scale" not in dataset.attrs:
        w = complex(dataset["vx"].values[-1], dataset["vy"].values[-1])
    back = np.exp(-1j * float(record.known_angles()[-1]))
    place, speed = complex(z[-1] * back), complex(w * back)
    return [place.real, place.imag, speed.real, speed.imag]
