"""The contact force along a run, and how its peaks are distributed."""

from __future__ import annotations

import numpy as np
import xarray as xr
from scipy.stats import rankdata

from rotor_ida.arrays import Values
from rotor_ida.equations.contact import contact_force, damping_factor, secant_stiffness
from rotor_ida.parameters import Rotor, check_no_friction
from rotor_ida.schema import Column, labelled_dataset, origin_of
from rotor_ida.simulation.dataset import check_run, parameter_coordinates, rotor_of

NEEDED = (*("t", "x", "y", "vx", "vy", "entry_time", "exit_time"), "peak_time", "peak_force")


def contact_forces(run: xr.Dataset) -> xr.Dataset:
    """Return the force of the ring on the rotor along a run, and its peaks.

    Parameters
    ----------
    run : Dataset
        A run of `rotor_ida.simulate`.

    Returns
    -------
    Dataset
        ``force force_x force_y`` on ``t``: the magnitude and the components in the fixed
        frame [1]. On ``contact``: ``peak_time`` and ``peak_force``, the largest force of each
        contact, found between the samples too, and ``peak_fraction``, the part of the whole
        contacts whose peak is no larger: over ``peak_force`` it is the distribution of the
        peaks. It is NaN for a contact that the run begins or ends inside.

    Raises
    ------
    InputError
        If the dataset is no run.

    Notes
    -----
    ``F = -N z/|z|`` with ``N = max(0, d**n (1 + c d'))`` in contact, where ``d = |z| - delta0``:
    ``max(|z| - delta0, 0)**1.5`` for the paper's rotor. With contact damping N is 0 from a release
    on until the contact presses again, and largest before the indentation is. The shaft and the
    load push too: neither is a force of the ring.

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
    rotor, x, y = rotor_of(run), run["x"].values, run["y"].values
    check_no_friction(rotor, "contact_forces")
    radius = np.hypot(x, y)
    held = _held(run, radius, rotor) if rotor.contact_damping > 0.0 else 1.0
    stiffness = held * secant_stiffness(radius, rotor.delta0, rotor.contact_exponent)
    peaks = run["peak_force"].values
    whole = np.isfinite(run["entry_time"].values) & np.isfinite(run["exit_time"].values)
    fraction = np.full(peaks.shape, np.nan)
    fraction[whole] = rankdata(peaks[whole], method="max") / max(int(whole.sum()), 1)
    columns: dict[str, Column] = {
        "force": ("t", held * contact_force(radius, rotor.delta0, rotor.contact_exponent)),
        "force_x": ("t", -stiffness * x),
        "force_y": ("t", -stiffness * y),
        "peak_time": ("contact", run["peak_time"].values),
        "peak_force": ("contact", peaks),
        "peak_fraction": ("contact", fraction),
    }
    coordinates = parameter_coordinates(rotor) | {"t": ("t", run["t"].values)}
    return labelled_dataset("Contact forces of one run", columns, coordinates, origin_of(run))


def _held(run: xr.Dataset, radius: Values, rotor: Rotor) -> Values:
    """Return what contact damping multiplies the force by; of no matter at the axis."""
    outwards = run["x"].values * run["vx"].values + run["y"].values * run["vy"].values
    speed = np.divide(outwards, radius, out=np.zeros_like(radius), where=radius > 0.0)
    return damping_factor(speed, rotor.contact_damping)
