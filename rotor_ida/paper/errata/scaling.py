"""Eq. (9): check of the reference frequency that makes the equation dimensionless."""

from __future__ import annotations

import math

import numpy as np
import xarray as xr
from scipy.integrate import solve_ivp

from rotor_ida.arrays import Values
from rotor_ida.checks import check_positive
from rotor_ida.errors import SimulationError
from rotor_ida.model.rotor import DimensionalRotor, Rotor, check_papers
from rotor_ida.paper.printed import reference_frequency
from rotor_ida.simulation.simulate import simulate

RIGHT, PRINTED = "k sqrt(D)/m", "k/m"
_START = 2.5  # eccentricities
_POINTS = 401


def check_scaling(machine: DimensionalRotor, *, duration: float) -> xr.Dataset:
    """Compare eq. (7), integrated in SI units by SciPy, with scaled dimensionless runs.

    Parameters
    ----------
    machine : DimensionalRotor
        The machine; it starts at rest 2.5 eccentricities from the bearing axis.
    duration : float
        Time to simulate, in units of the right time scale [1].

    Returns
    -------
    Dataset
        ``X`` and ``Y`` [m] on ``t`` [s] by eq. (7), and ``scaled_X`` and ``scaled_Y`` [m] on
        ``frequency`` and ``t``, by `rotor_ida.simulate` with omega_0^2 = k sqrt(D)/m and with
        the printed k/m.

    Raises
    ------
    InputError
        If `duration` is not a positive finite number, or the machine is not of the paper's kind.
    SimulationError
        If SciPy gave up.

    References
    ----------
    Eqs (7) and (9) of the paper, Mechanika 25(6), 2019.

    Examples
    --------
    >>> machine = DimensionalRotor(mass=4.0, contact_stiffness=1e9, damping=280.0,
    ...                            eccentricity=1e-6, clearance=2e-6, speed=600.0)
    >>> apart = deviations(check_scaling(machine, duration=10.0))
    >>> apart["k sqrt(D)/m"] < 5e-12, apart["k/m"] > 0.5
    (True, True)
    """
    check_papers(machine.rotor(), "check_scaling")
    frequencies = {RIGHT: machine.reference_frequency, PRINTED: reference_frequency(machine)}
    D = machine.eccentricity
    times = np.linspace(0.0, check_positive("duration", duration) * machine.time_scale, _POINTS)
    orbit = _dimensional_orbit(machine, times)
    table = []
    for frequency in frequencies.values():
        rotor = Rotor(
            omega=machine.speed / frequency,
            zeta=machine.damping / (2.0 * machine.mass * frequency),
            delta0=machine.clearance / D,
        )
        scaled = times * frequency
        run = simulate(
            rotor, start=(_START, 0.0, 0.0, 0.0), duration=float(scaled[-1]), samples=scaled,
            rtol=1e-13, atol=1e-15,
        )  # fmt: skip
        table.append(D * np.stack([run["x"].values, run["y"].values]))
    positions = np.stack(table)
    dims = ("frequency", "t")
    variables = {
        "X": ("t", orbit[0], _metres("horizontal displacement by eq. (7)")),
        "Y": ("t", orbit[1], _metres("vertical displacement by eq. (7)")),
        "scaled_X": (dims, positions[:, 0], _metres("horizontal displacement, scaled")),
        "scaled_Y": (dims, positions[:, 1], _metres("vertical displacement, scaled")),
    }
    seconds = {"long_name": "time", "units": "s"}
    coordinates = {"t": ("t", times, seconds), "frequency": list(frequencies)}
    title = "The dimensional equation beside dimensionless runs, scaled by two rules"
    return xr.Dataset(variables, coordinates, {"title": title})


def deviations(checked: xr.Dataset) -> dict[str, float]:
    """Return the error of each scaled run against eq. (7), over the largest displacement.

    Parameters
    ----------
    checked : Dataset
        Result of `check_scaling`.

    Returns
    -------
    dict of str to float
        One distance [1] for each reference frequency.
    """
    distance = np.hypot(
        checked["scaled_X"].values - checked["X"].values,
        checked["scaled_Y"].values - checked["Y"].values,
    )
    largest = np.hypot(checked["X"].values, checked["Y"].values).max()
    names = checked["frequency"].values.tolist()
    return dict(zip(names, (distance.max(axis=1) / largest).tolist(), strict=True))


def _metres(long_name: str) -> dict[str, str]:
    return {"long_name": long_name, "units": "m"}


def _dimensional_orbit(machine: DimensionalRotor, times: Values) -> Values:
    """Return X and Y of eq. (7), shape (2, n), by SciPy, independent of any scaling."""
    m, k, n = machine.mass, machine.contact_stiffness, machine.damping
    D, d, W = machine.eccentricity, machine.clearance, machine.speed

    def rate(time: float, state: Values) -> list[float]:
        X, Y, VX, VY = state
        R = math.hypot(X, Y)
        stiffness = k * (R - d) ** 1.5 / R if d < R else 0.0
        push = m * D * W * W
        return [
            VX,
            VY,
            (push * math.cos(W * time) - n * VX - stiffness * X) / m,
            (push * math.sin(W * time) - n * VY - stiffness * Y) / m,
        ]

    solved = solve_ivp(
        rate, (0.0, float(times[-1])), (_START * D, 0.0, 0.0, 0.0), "DOP853", times,
        rtol=3e-14, atol=1e-14 * D, max_step=float(times[-1]) / _POINTS,
    )  # fmt: skip
    if not solved.success:
        X, Y, VX, VY = solved.y[:, -1].tolist()
        message = f"eq. (7) could not be integrated: {solved.message}"
        raise SimulationError(message, time=float(solved.t[-1]), state=(X, Y, VX, VY))
    return np.asarray(solved.y[:2])
