"""A run read on axes that turn with the unbalance."""

from __future__ import annotations

import numpy as np
import xarray as xr

from rotor_ida.checks import COMPONENTS
from rotor_ida.model.equations import rotated
from rotor_ida.results.run import check_run
from rotor_ida.schema import labelled

EVENT_NAMES = tuple(f"event_{name}" for name in COMPONENTS)


def rotating(run: xr.Dataset) -> xr.Dataset:
    """Read the motion of a run on axes that turn with the unbalance.

    Parameters
    ----------
    run : Dataset
        A run of `rotor_ida.simulate` or `rotor_ida.run_up`, or part of one.

    Returns
    -------
    Dataset
        The run, with ``rotating_x rotating_y rotating_vx rotating_vy`` on ``t`` and
        ``event_rotating_x event_rotating_y event_rotating_vx event_rotating_vy`` on ``event``
        added [1].

    Raises
    ------
    InputError
        If the dataset is no run.

    Notes
    -----
    ``Z = z exp(-i omega t)``, ``W = z' exp(-i omega t)``: the same two vectors, read on axes of
    which the first points along the unbalance. W is the velocity that a bystander sees, not the
    rate of change of Z, which is ``W - i omega Z``. A synchronous whirl of amplitude A and phase
    lag theta is the point ``Z = A exp(-i theta)``. Where the speed changes the axes turn with the
    ``angle`` of the run.

    References
    ----------
    Eq. (10) of the paper, Mechanika 25(6), 2019, multiplied by ``exp(-i omega t)``.

    Examples
    --------
    >>> from rotor_ida import Rotor, simulate
    >>> run = simulate(Rotor(omega=1.2, zeta=0.5, delta0=0.5), start=(0, 0, 0, 0), duration=60.0)
    >>> seen = rotating(run)
    >>> seen.rotating_x[-1].item(), seen.rotating_y[-1].item()
    (-0.59999..., -0.60170...)
    """
    run = check_run(run, ("t", "event_time", *COMPONENTS, *EVENT_NAMES))
    return run.assign(
        {
            **_read("t", "rotating", run, COMPONENTS),
            **_read("event", "event_rotating", run, EVENT_NAMES),
        }
    )


def _read(dim: str, prefix: str, run: xr.Dataset, names: tuple[str, ...]) -> dict[str, xr.Variable]:
    times = run["t" if dim == "t" else "event_time"].values
    angles = float(run["omega"]) * times
    if "event_angle" in run:  # the speed changed
        angles = run["angle" if dim == "t" else "event_angle"].values
    states = np.stack([run[name].values for name in names], axis=-1)
    table = rotated(states, -angles)
    return {
        f"{prefix}_{name}": labelled(f"{prefix}_{name}", dim, np.ascontiguousarray(column))
        for name, column in zip(COMPONENTS, table.T, strict=True)
    }
