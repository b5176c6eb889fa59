"""How fast the shaft whirls against its spin, and which way."""

from __future__ import annotations

import numpy as np
import xarray as xr

from rotor_ida.checks import check_count, check_nonnegative
from rotor_ida.schema import Column
from rotor_ida.signals.orders import MOST_OVERLAP, fit, window_coordinates
from rotor_ida.signals.record import record_of
from rotor_ida.signals.windows import windows_of

# Below this part of the spin speed a vibration along a line is no whirl.
NO_WHIRL = 0.01


def whirl_ratio(signals: xr.Dataset, *, revolutions: int = 1, overlap: float = 0.0) -> xr.Dataset:
    """Return the whirl speed over the spin speed, and the sense of the whirl, over time.

    Parameters
    ----------
    signals : Dataset
        Signals of `signals_of` or `read_signals`, or a run, with more than two samples in each
        turn of the whirl.
    revolutions : int
        Length of the windows over which the whirl is counted [1].
    overlap : float
        By which part windows overlap [1], from 0 to 0.95.

    Returns
    -------
    Dataset
        On ``window``: ``whirl_over_spin``, negative for backward whirl, ``whirl_speed`` and
        ``whirl_sense``; coordinates ``t`` and ``speed``.

    Raises
    ------
    InputError
        If the angle is not known, or there is no whole window.

    Notes
    -----
    The angle by which z turns about its mean position in a window, over that by which the rotor
    does: 1 for a synchronous whirl, a half for oil whirl, negative for dry whip. Of several whirls
    the widest counts. A vibration along a line, which turns by less than a hundredth of the rotor's
    angle, has the sense ``none``.

    Examples
    --------
    >>> from rotor_ida import Rotor, simulate
    >>> run = simulate(Rotor(omega=1.2, zeta=0.5, delta0=0.5), start=(0, 0, 0, 0),
    ...                duration=200.0, samples=2001)
    >>> whirl_ratio(run).whirl_over_spin[-1].round(6).item()
    1.0
    """
    length = check_count("revolutions", revolutions)
    part = check_nonnegative("overlap", overlap, MOST_OVERLAP)
    record = record_of(signals)
    windows = windows_of(record, length, part)
    offset = fit(record, windows, np.array([1.0])).amplitudes[:, -1]
    about = record.z[windows.samples] - windows.spread(offset)
    angles = record.known_angles()[windows.samples]
    # from one sample to the next, but not across the edge, where the mean jumps
    starts, ends = windows.edges[:-1], windows.edges[1:] - 1
    turned = np.angle(about[1:] * about[:-1].conj())
    turned[ends[:-1]] = 0.0
    ratio = np.add.reduceat(np.append(turned, 0.0), starts) / (angles[ends] - angles[starts])
    sense = np.where(np.abs(ratio) < NO_WHIRL, 0, np.sign(ratio)).astype(np.int8)
    columns: dict[str, Column] = {
        "whirl_over_spin": ("window", ratio),
        "whirl_speed": ("window", ratio * windows.speeds),
        "whirl_sense": ("window", sense),
    }
    told = {"window_revolutions": length, "window_overlap": part}
    return record.dataset(
        "Whirl against spin", columns, window_coordinates(windows), told, kind="whirl_over_spin"
    )
