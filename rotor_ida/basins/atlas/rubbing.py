"""Effects of friction on a whirl and on a limit cycle, and numbers of motions without a period.

An attractor without a period is given by a state on it; its numbers come from following that state.
"""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt

from rotor_ida.arrays import Values
from rotor_ida.basins.attractors import Attractor
from rotor_ida.basins.fates import ALONE
from rotor_ida.checks import State
from rotor_ida.cycles.orbit import Orbit
from rotor_ida.model.equations import rotated
from rotor_ida.model.rotor import Rotor
from rotor_ida.model.whirl import forward_and_backward, steps_of_turning, whirl_over_spin
from rotor_ida.schema.flags import ENTRY
from rotor_ida.signals.forces import contact_forces
from rotor_ida.simulation.contact_table import contact_summary
from rotor_ida.simulation.simulate import simulate
from rotor_ida.steady import response
from rotor_ida.steady.follow import follow_to_steady_state

# Length of a run in revolutions,
REVOLUTIONS = 64
# with this number of samples in each.
SAMPLES = 256
# Samples of one period of a limit cycle, for the slip distance.
SAMPLES_OF_CYCLE = 2048


def needs_run(attractor: Attractor) -> bool:
    """Return whether the numbers of an attractor need a run: if it rolls or is a torus.

    That is with friction, contact damping or a load, and without a period. Chaos is excluded, as
    the run may leave it.
    """
    lasting = attractor.kind in (response.ROLLING, response.QUASI_PERIODIC)
    return lasting and math.isnan(attractor.period)


def settled_state(rotor: Rotor, start: Values) -> Values:
    """Return a state of the motion that a start ends on, shape (4,), on the rotating axes [1]."""
    return np.array(follow_to_steady_state(rotor, _state(start), ALONE).end)


def states_of_rub(rotor: Rotor, start: Values, count: int) -> Values:
    """Return `count` states of the motion that a start ends on, shape (4, count)."""
    duration = REVOLUTIONS * 2.0 * math.pi / rotor.omega
    run = simulate(
        rotor, start=settled_state(rotor, start), duration=duration, samples=count, method="taylor"
    )
    states = np.stack([run[name].values for name in ("x", "y", "vx", "vy")], axis=-1)
    return rotated(states, -rotor.omega * run["t"].values).T


def numbers_of_rub(rotor: Rotor, start: Values) -> dict[str, float]:
    """Return the dimensionless numbers of the motion without a period that a start ends on."""
    revolution, turns = 2.0 * math.pi / rotor.omega, REVOLUTIONS
    state, samples = settled_state(rotor, start), SAMPLES * turns + 1
    run = simulate(
        rotor, start=state, duration=turns * revolution, samples=samples, method="taylor"
    )
    told, forces = contact_summary(run), contact_forces(run)
    normal = forces["normal_force" if rotor.friction > 0.0 else "force"]
    viscous = 2.0 * rotor.zeta * float((run["vx"] ** 2 + run["vy"] ** 2)[:-1].mean())
    numbers = {
        "largest_force": float(told["largest_force"]),
        "mean_force": float(normal[:-1].mean()),
        "contacts_per_revolution": float((run["event_kind"] == ENTRY).sum()) / turns,
        "contact_fraction": float(told["contact_fraction"]),
        "dissipation_per_revolution": viscous * revolution,
    }
    if rotor.friction > 0.0:
        numbers |= {
            "heat_per_revolution": float(told["total_heat"]) / turns,
            "slip_distance_per_revolution": float(told["total_slip_distance"]) / turns,
            "rolling_fraction": float(told["rolling_fraction"]),
        }
        numbers["dissipation_per_revolution"] += numbers["heat_per_revolution"]
    if rotor.contact_damping > 0.0:
        loss = float(told["total_contact_loss"]) / turns
        numbers["contact_loss_per_revolution"] = loss
        numbers["dissipation_per_revolution"] += loss
    fixed = run["x"].values + 1j * run["y"].values
    turning = fixed * np.exp(-1j * rotor.omega * run["t"].values)
    numbers["side_line_over_spin"] = _strongest_beside_spin(turning[:-1], turns, rotor.load > 0.0)
    turned = float(steps_of_turning(fixed - fixed[:-1].mean()).sum())
    forward, backward = (float(np.linalg.norm(part)) for part in forward_and_backward(fixed[:-1]))
    ratio, sense = whirl_over_spin(turned, 2.0 * math.pi * turns, forward, backward)
    numbers |= {"whirl_over_spin": float(ratio), "whirl_sense": int(sense)}
    return numbers


def numbers_of_cycle(cycle: Orbit) -> dict[str, float]:
    """Return the losses by friction on a limit cycle, from one period of it."""
    run = simulate(
        cycle.rotor, start=cycle.start, duration=cycle.duration, samples=SAMPLES_OF_CYCLE,
        method="taylor",
    )  # fmt: skip
    told, turns = contact_summary(run), cycle.duration * cycle.rotor.omega / (2.0 * math.pi)
    return {
        "heat_per_revolution": float(told["total_heat"]) / turns,
        "slip_distance_per_revolution": float(told["total_slip_distance"]) / turns,
        "rolling_fraction": float(told["rolling_fraction"]),
    }


def numbers_of_whirl(rotor: Rotor, amplitude: float, force: float) -> dict[str, float]:
    """Return the losses by friction on a whirl in contact, which slides forwards throughout."""
    distance = 2.0 * math.pi * (amplitude + (rotor.disc_radius or 0.0))
    return {
        "heat_per_revolution": rotor.friction * force * distance,
        "slip_distance_per_revolution": distance,
        "rolling_fraction": 0.0,
    }


def _strongest_beside_spin(
    position: npt.NDArray[np.complex128], turns: float, loaded: bool
) -> float:
    """Return the frequency, over the spin speed, of the strongest line other than 1X.

    The position, complex, covers a number of revolutions on the rotating axes. The deflection by a
    load, which stands still on the fixed axes, is no line.
    """
    sizes = np.abs(np.fft.fft(position))
    orders = np.fft.fftfreq(position.size, 1.0 / position.size)
    sizes[orders == 0.0] = 0.0
    if loaded:
        sizes[orders == -turns] = 0.0
    return 1.0 + float(orders[np.argmax(sizes)]) / turns


def _state(values: Values) -> State:
    x, y, vx, vy = np.asarray(values).tolist()
    return (x, y, vx, vy)
