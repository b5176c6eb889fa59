"""Basins over a plane of starts."""

from __future__ import annotations

import os

import numpy as np
import numpy.typing as npt
import xarray as xr

from rotor_ida.arrays import Values
from rotor_ida.basins.dataset import basin_dataset
from rotor_ida.basins.labelling import label
from rotor_ida.checks import COMPONENTS, check_increasing, check_vector, is_scalar
from rotor_ida.errors import InputError
from rotor_ida.model.parameters import Rotor
from rotor_ida.parallel import Progress
from rotor_ida.simulation.options import LARGEST


def basin(
    rotor: Rotor,
    *,
    x: npt.ArrayLike,
    y: npt.ArrayLike,
    vx: npt.ArrayLike = 0.0,
    vy: npt.ArrayLike = 0.0,
    rtol: float | None = None,
    workers: int | None = None,
    executor: str = "auto",
    study: str | os.PathLike[str] | None = None,
    progress: Progress | None = None,
) -> xr.Dataset:
    """Return the attractor on which the rotor ends, for every start of a plane.

    Parameters
    ----------
    rotor : Rotor
        The rotor; damped, since without damping nothing settles.
    x, y, vx, vy : float or array_like, shape (n,)
        Components of the start [1]: exactly two are increasing arrays, two are numbers.
    rtol : float, optional
        Error allowed in a step, relative to the size of the state and of the eccentricity [1]; by
        default 1e-6, or 1e-11 where one of 512 starts ends elsewhere with that, for then the
        basins are finely folded. The attribute ``labelling_rtol`` says which.
    workers : int, optional
        How many batches of starts to follow at a time; by default one for each core that may be
        used.
    executor : {"auto", "serial", "threads", "processes", "dask"} or str
        What follows them, as for `rotor_ida.sweep`; ``"auto"`` means threads. The result is the
        same, bit for bit, on processors of one kind.
    study : path-like, optional
        Folder in which batches of starts are kept as they are done, as for `sweep`. With it, an
        interrupted basin can go on, and one with more starts than memory holds can be computed.
    progress : callable, optional
        Called with the number of starts done and their total.

    Returns
    -------
    Dataset
        On the two components that vary: ``label``, the number of the attractor, -1 where the end
        is not known, -2 where it was not computed; ``response``, its kind as a flag;
        ``settling_time`` [1]. On ``attractor``: ``kind``, ``amplitude``, ``phase_lag``,
        ``radius_min``, ``radius_max`` (NaN where they depend on the start); ``trapping``, whether
        the region that holds starts is proven or estimated; ``confirmed``, whether CVODE has
        followed one of its starts to it; ``count``, ``fraction`` and ``fraction_error``. Scalars:
        ``undecided_count``, ``undecided_fraction``, ``not_computed_count``; ``agreement``, the part
        of the labels that come out the same with the error ``agreement_rtol`` in a step, of
        ``agreement_count`` that were found again; ``basin_entropy``, how uncertain the end of
        a start is within a small box, and ``boundary_entropy``, the same over the boxes in which
        starts end differently: on a fine grid more than log 2 says that the boundary is fractal.

    Raises
    ------
    InputError
        If an argument cannot be used.
    SimulationError
        If one of ``"processes"`` died, or the scheduler.

    Notes
    -----
    An interrupt from the keyboard ends it early: the starts that are not done are labelled as not
    computed, and the attribute ``interrupted`` is 1. So are starts whose workers of dask keep
    dying, with the attribute ``not_computed_reason``. Stable whirls in contact are listed even
    where no start ends on them. ``fraction_error`` is ``sqrt(p (1 - p)/n)``, the standard error
    that n random starts would have; the error of a grid, whose cells are wrong only along the
    borders of the basins, is smaller. ``settling_time`` is the time at which a region
    held the orbit, or else that at which the final window of an orbit followed alone ends.

    A label is proven only where the start itself lies in a region that is. Any other rests on the
    integration up to there, of which `agreement` is a sample. The attributes say what did what:
    ``labelling_method`` and ``labelling_rtol`` the labels, ``left_over_method`` and
    ``left_over_rtol`` the orbits that no region held, ``confirmation_method`` and so on what
    `confirmed` tells, if an interrupt did not prevent it.

    With friction starts are followed as for `rotor_ida.basin_fractions`.

    Examples
    --------
    >>> import numpy as np
    >>> axis = np.linspace(-15.0, 15.0, 24)
    >>> found = basin(Rotor(omega=1.7, zeta=0.07, delta0=0.0), x=axis, y=axis)
    >>> found.label.dims, found.amplitude.values.round(4)
    (('x', 'y'), array([1.8796, 9.4872]))
    >>> int(found["count"].sum()), int(found.undecided_count)
    (576, 0)
    """
    axes, fixed = _axes_of({"x": x, "y": y, "vx": vx, "vy": vy})
    (first, rows), (second, columns) = axes.items()
    places = [COMPONENTS.index(first), COMPONENTS.index(second)]

    def starts(begin: int, end: int) -> Values:
        """Return the starts with these numbers, row by row."""
        row, column = np.divmod(np.arange(begin, end), columns.size)
        states = np.empty((4, end - begin))
        for name, value in fixed.items():
            states[COMPONENTS.index(name)] = value
        states[places[0]], states[places[1]] = rows[row], columns[column]
        return states

    design = {"kind": "basin", **{name: values.tolist() for name, values in axes.items()}, **fixed}
    found = label(
        rotor, starts, rows.size * columns.size, design,
        rtol=rtol, workers=workers, executor=executor, study=study, progress=progress,
    )  # fmt: skip
    return basin_dataset(axes, fixed, found)


def _axes_of(given: dict[str, npt.ArrayLike]) -> tuple[dict[str, Values], dict[str, float]]:
    """Return the components that vary, and those that do not."""
    varying = [name for name, value in given.items() if not is_scalar(name, value)]
    if len(varying) != 2:
        raise InputError(
            "exactly two of x, y, vx, vy must be arrays and two numbers, got "
            f"{len(varying)} arrays{': ' if varying else ''}{', '.join(varying)}"
        )
    checked = {name: check_vector(name, value, largest=LARGEST) for name, value in given.items()}
    axes = {name: check_increasing(name, checked[name]) for name in varying}
    fixed = {name: values.item() for name, values in checked.items() if name not in axes}
    return axes, fixed
