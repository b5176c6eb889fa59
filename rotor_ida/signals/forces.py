"""The contact force along a run, and the distribution of its peaks."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
import xarray as xr

from rotor_ida.arrays import Values
from rotor_ida.model.contact import clipped_factor, contact_force
from rotor_ida.model.forces import Moment, hold_of_rolling, with_values
from rotor_ida.model.rotor import Rotor
from rotor_ida.results.checked_run import (
    check_one_speed,
    check_run,
    parameter_coordinates,
    rotor_of,
)
from rotor_ida.results.in_si import keeps_si
from rotor_ida.schema import MODE, Column, labelled_dataset, origin_of

NEEDED = (*("t", "x", "y", "vx", "vy", "entry_time", "exit_time"), "peak_time", "peak_force")


@keeps_si
def contact_forces(run: xr.Dataset) -> xr.Dataset:
    """Return the contact force on the rotor along a run, and its peaks.

    Parameters
    ----------
    run : Dataset
        A run of `rotor_ida.simulate`.

    Returns
    -------
    Dataset
        ``force force_x force_y`` on ``t``: the magnitude and the components in the fixed
        frame [dimensionless]; with friction also ``normal_force`` and ``tangential_force``, which
        is positive where it pulls the disc backward. On ``contact``: ``peak_time`` and
        ``peak_force``, the largest normal force of each contact, found between the samples too;
        ``peak_fraction``, the fraction of complete contacts with no larger peak, which is the
        distribution of ``peak_force``. It is NaN for a contact during which the run begins or ends.

    Raises
    ------
    InputError
        If the dataset is not a run.

    Notes
    -----
    The force is ``-(N + i T) z/|z|`` with ``N = max(0, d**n (1 + c d'))`` in contact, where
    ``d = |z| - delta0``: ``max(|z| - delta0, 0)**1.5`` for the paper's rotor. With contact damping
    N is 0 from a release until the contact presses again, and is largest before the indentation
    is. The forces of the shaft and the load are not included.

    References
    ----------
    Eq. (10) of the paper, Mechanika 25(6), 2019.

    Examples
    --------
    >>> from rotor_ida import Rotor, simulate
    >>> run = simulate(Rotor(omega=2.0, zeta=0.07, delta0=2.0), start=(0, 0, 0, 0), duration=20.0)
    >>> forces = contact_forces(run)
    >>> forces.peak_force.values.round(6)
    array([3.338337, 3.263644, 3.889012, 4.715582])
    """
    run = check_run(run, NEEDED)
    rotor, z = rotor_of(run), run["x"].values + 1j * run["y"].values
    radius = np.hypot(z.real, z.imag)
    if rotor.friction > 0.0:
        check_one_speed(run, "contact forces with friction")
        check_run(run, (*NEEDED, "mode", "normal_force"))
        normal, along = run["normal_force"].values, _tangential(run, radius, rotor)
        told = {"normal_force": normal, "tangential_force": along}
    else:
        normal, along = normal_force(rotor, radius, _outwards(run)), np.zeros_like(radius)
        told = {}
    force = -(normal + 1j * along) * z / np.where(radius > 0.0, radius, 1.0)
    told |= {"force": np.hypot(normal, along), "force_x": force.real, "force_y": force.imag}
    peaks = run["peak_force"].values
    whole = np.isfinite(run["entry_time"].values) & np.isfinite(run["exit_time"].values)
    fraction = np.full(peaks.shape, np.nan)
    complete = np.sort(peaks[whole])
    fraction[whole] = np.searchsorted(complete, peaks[whole], "right") / max(complete.size, 1)
    columns: dict[str, Column] = {
        **{name: ("t", column) for name, column in told.items()},
        "peak_time": ("contact", run["peak_time"].values),
        "peak_force": ("contact", peaks),
        "peak_fraction": ("contact", fraction),
    }
    coordinates = parameter_coordinates(rotor) | {"t": ("t", run["t"].values)}
    return labelled_dataset(
        "Contact forces of one run", columns, coordinates, origin_of(run), kind="contact_forces"
    )


def normal_force(rotor: Rotor, radius: Values, outwards: Values | float) -> Values:
    """Return ``N = max(0, d**n (1 + c d'))`` [dimensionless]."""
    spring = contact_force(radius, rotor.delta0, rotor.contact_exponent)
    return np.asarray(clipped_factor(outwards, rotor.contact_damping) * spring)


def _tangential(run: xr.Dataset, radius: Values, rotor: Rotor) -> Values:
    """Return the tangential force; both forces are 0 wherever the radius may vanish."""
    mode = run["mode"].values
    slides = 1.0 * (mode == MODE["slipping_forward"]) - (mode == MODE["slipping_backward"])
    grip = rotor.friction * run["normal_force"].values * slides
    return np.where(mode == MODE["rolling"], _hold(run, radius, rotor), grip)


def _hold(run: xr.Dataset, radius: Values, rotor: Rotor) -> Values:
    """Return the tangential force required for rolling."""
    size = np.where(radius > 0.0, radius, 1.0)
    c, s = run["x"].values / size, run["y"].values / size
    angle, rim = rotor.omega * run["t"].values, (rotor.disc_radius or 0.0) * rotor.omega
    at = Moment(
        (radius, 0.0), (_outwards(run), -rim), (1.0, 0.0),
        (np.cos(angle) * c + np.sin(angle) * s, np.sin(angle) * c - np.cos(angle) * s), (-s, -c),
    )  # fmt: skip
    return np.asarray(hold_of_rolling(at, size, with_values(rotor, rim=rim)))


@dataclass(frozen=True, slots=True)
class PowerInContact:
    """The normal force along a run, and the power that a contact dissipates.

    Parameters
    ----------
    normal_force : ndarray, shape (n,)
        ``N = max(0, d**n (1 + c d'))`` [dimensionless].
    damping : ndarray, shape (n,)
        ``(N - d**n) d'``, the power of contact damping [dimensionless].
    friction : ndarray, shape (n,)
        ``mu N |v_s|``, the heat of sliding [dimensionless].
    """

    normal_force: Values
    damping: Values
    friction: Values


def power_in_contact(run: Mapping[str, Values], rotor: Rotor) -> PowerInContact:
    """Return normal force and lost power of samples ``x y vx vy``, with friction ``slip_speed``."""
    radius = np.hypot(run["x"], run["y"])
    spring: Values = contact_force(radius, rotor.delta0, rotor.contact_exponent)
    outwards = radial_speed(run["x"], run["y"], run["vx"], run["vy"])
    normal = clipped_factor(outwards, rotor.contact_damping) * spring
    slip = np.abs(run["slip_speed"]) if rotor.friction > 0.0 else 0.0
    return PowerInContact(normal, (normal - spring) * outwards, rotor.friction * normal * slip)


def radial_speed(x: Values, y: Values, vx: Values, vy: Values) -> Values:
    """Return the radial velocity ``d'`` [dimensionless]; not used at the axis."""
    radius = np.hypot(x, y)
    speed: Values = np.divide(
        x * vx + y * vy, radius, out=np.zeros_like(radius), where=radius > 0.0
    )
    return speed


def _outwards(run: xr.Dataset) -> Values:
    return radial_speed(*(run[name].values for name in ("x", "y", "vx", "vy")))
