"""The derivatives of the residuals, against those that the kernel of one disc carries along."""

from __future__ import annotations

import numpy as np

from rotor_ida import Rotor, signals_of, simulate
from rotor_ida.core.runs import COLUMNS
from rotor_ida.fitting.arguments import problem_of
from rotor_ida.schema.flags import ENTRY
from rotor_ida.simulation.flow import DiscFlow

ROTOR = Rotor(omega=1.7, zeta=0.07, delta0=2.5, shaft_stiffness=0.25, contact_damping=0.1,
              load=0.2)  # fmt: skip
START = np.array([0.2, -0.1, 0.3, 2.9])
UNKNOWN = ("zeta", "delta0", "shaft_stiffness", "contact_damping", "load")


def problem(**given):
    run = simulate(ROTOR, start=START, duration=20.0, samples=201)
    asked = dict.fromkeys(("revolutions", "entries", "exits", "time_error"))
    return problem_of(
        signals_of(run), ROTOR, UNKNOWN, **{**asked, "orders": (0, 1), "noise": 1.0, "start": START,
                                            **given},
    )  # fmt: skip


def test_derivatives_are_those_of_the_core_at_one_speed():
    """The kernel of one disc has differences in its Taylor series, on axes that turn."""
    sought = problem(start=None)
    (record,) = sought.records
    flow, turns = DiscFlow(ROTOR), np.exp(1.7j * record.times)
    by = np.zeros((record.times.size, 4 + len(UNKNOWN)), complex)
    by[0, :2] = 1.0, 1.0j
    start = sought.starts[0].mean
    for row, time in enumerate(record.times[1:], 1):
        piece = flow.run(start, float(time), by=COLUMNS)
        columns = [*piece.tangents.T, *(piece.by[COLUMNS.index(name)] for name in UNKNOWN)]
        by[row] = [complex(x, y) * turns[row] for x, y, *_ in columns]
    expected = record.tracks.weighed(by)
    slopes = sought.slopes(sought.first())
    tracks = slopes[: len(expected)]
    for column, name in enumerate(UNKNOWN):
        size = np.linalg.norm(expected[:, 4 + column])
        assert np.linalg.norm(tracks[:, column] - expected[:, 4 + column]) < 1e-5 * size, name
    by_start = expected[:, :4] @ sought.starts[0].root
    for column, exact in enumerate(by_start.T, len(UNKNOWN)):
        assert np.linalg.norm(tracks[:, column] - exact) < 1e-4 * np.linalg.norm(exact)
    np.testing.assert_allclose(slopes[len(expected) :, len(UNKNOWN) :], np.eye(4), atol=1e-9)


def test_derivatives_of_contact_times_follow_from_the_motion():
    """From ``|z| = delta0``, ``dt = (d delta0 - z/|z| . dz)/r'`` with dz of the core."""
    run = simulate(ROTOR, start=START, duration=20.0, samples=201)
    enters = run.event_kind.values == ENTRY
    times = run.event_time.values[enters]
    sought = problem(entries=times, time_error=1e-3)
    slopes = sought.slopes(sought.first())[-times.size :] * 1e-3
    assert times.size > 2
    for row, time in enumerate(times):
        piece = DiscFlow(ROTOR).run(START, float(time), by=COLUMNS)
        x, y, vx, vy = piece.end
        # on turning axes velocities are those of the fixed ones, read along the turning
        radius = np.hypot(x, y)
        rise = (x * vx + y * vy) / radius
        for column, name in enumerate(UNKNOWN):
            moved = piece.by[COLUMNS.index(name)]
            exact = ((name == "delta0") - (x * moved[0] + y * moved[1]) / radius) / rise
            assert abs(slopes[row, column] - exact) < 1e-4 * max(abs(exact), 1.0), name
