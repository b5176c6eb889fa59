"""Boxes of starts, and one attractor of a report."""

import numpy as np

from rotor_ida.schema import RESPONSE

BOX = {"x": (-15, 15), "y": (-15, 15)}
WIDE = dict.fromkeys(("x", "y", "vx", "vy"), (-6.0, 6.0))


def of_kind(report, kind):
    """Return the first attractor of a kind."""
    return report.isel(attractor=int(np.flatnonzero(report.kind == RESPONSE[kind])[0]))
