"""Lyapunov exponents of one disc: how fast neighbouring motions diverge or converge."""

from __future__ import annotations

import math
from typing import Literal

import numpy as np

from rotor_ida.arrays import Values
from rotor_ida.checks import MOST_NUMBERS, State
from rotor_ida.core.interface import DONE, NOT_FINITE, message_of
from rotor_ida.core.runs import RunRequest, stretch
from rotor_ida.errors import SimulationError
from rotor_ida.model.equations import rotated
from rotor_ida.model.rotor import Rotor
from rotor_ida.parallel import Stop
from rotor_ida.simulation.flow import ATOL

MethodOfTangents = Literal["taylor", "adams", "bdf"]
METHODS_OF_TANGENTS: tuple[MethodOfTangents, ...] = ("taylor", "adams", "bdf")

# Time after which tangent vectors are made orthonormal again, before they align.
SPAN = 0.5
# Smallest number of these spans in a batch, as weights depend on the position in it.
FEWEST_SPANS = 20
# With fewer batches their scatter gives no error,
FEWEST_BATCHES = 4
# and this many give one to a sixth.
BATCHES = 20
# Time in which the tangent vectors of a settled motion align with their directions.
TURNING_TIME = 100.0
# Each span keeps four numbers in memory.
LONGEST = SPAN * MOST_NUMBERS


def exponents_of(
    rotor: Rotor, start: State, duration: float, stop: Stop, *, rtol: float = 1e-10
) -> tuple[Values, Values]:
    """Return the Lyapunov exponents of a settled motion, largest first, and their errors.

    Means over `duration` from `start`, on the rotating axes. Raise `SimulationError` if the
    integration is stuck, or stopped.
    """
    spans = (math.ceil(TURNING_TIME / SPAN), BATCHES * math.ceil(duration / (BATCHES * SPAN)))
    stretches = stretches_of(rotor, start, *spans, SPAN, rtol, stop, "taylor")
    exponents, errors, _ = means_of(stretches / SPAN, BATCHES, divergence_of(rotor))
    order = np.argsort(-exponents, kind="stable")
    return exponents[order], errors[order]


def stretches_of(
    rotor: Rotor, start: State, lead: int, count: int, span: float, rtol: float, stop: Stop,
    method: MethodOfTangents,
) -> Values:  # fmt: skip
    """Return the logarithms of stretching over each span after the transient, shape (n, 5)."""
    # Not along the axes: these are special directions of a rotor that starts at rest.
    bundle = np.ascontiguousarray(np.linalg.qr(np.vander([1.0, 0.7, -0.4, -0.9]))[0])
    request = RunRequest(
        rotor=rotor, start=start, duration=span, rtol=rtol, atol=ATOL * rtol, method=method,
        bundle=bundle, stop=stop,
    )  # fmt: skip
    stretches, result = stretch(request, lead + count)
    whole = np.isfinite(stretches[:, :3]).all(axis=1) & (stretches[:, 3] < np.inf)
    if result.status != DONE or not whole.all():
        time = span * int(whole.sum()) + (result.time if result.status != DONE else 0.0)
        x, y, vx, vy = rotated(result.state, rotor.omega * time).tolist()
        reason = message_of(result.status) if result.status != DONE else message_of(NOT_FINITE)
        raise SimulationError(
            f"the tangent vectors could not be followed: {reason}", time=time, state=(x, y, vx, vy)
        )
    return stretches[lead:]


def divergence_of(rotor: Rotor) -> float:
    """Return the divergence of the flow; NaN where it varies along an orbit."""
    return math.nan if rotor.contact_damping > 0.0 else -4.0 * rotor.zeta


def means_of(rates: Values, count: int, divergence: float) -> tuple[Values, Values, float]:
    """Return the means of four rates, their standard errors from `count` batches, and their sum.

    The sum is the exact one: the divergence plus the contribution of jumps, the last of the five
    rates.
    """
    exact = divergence + float(_weighted(rates[:, 4:])[0])
    exponents, errors = means_of_rates(rates[:, :4], count)
    if exponents[3] == -np.inf:
        return exponents, errors, -math.inf
    defect = 0.0 if math.isnan(exact) else abs(float(exponents.sum()) - exact)
    return exponents, errors + defect, exact


def means_of_rates(rates: Values, count: int) -> tuple[Values, Values]:
    """Return the means of rates, shape (n, m), and their standard errors from `count` batches.

    A mean is minus infinity if any of its rates is, and then has no error.
    """
    known = np.isfinite(rates).all(axis=0)
    if not known.all():
        found = np.full((2, known.size), [[-np.inf], [0.0]])
        found[:, known] = means_of_rates(rates[:, known], count)
        return found[0], found[1]
    means = _weighted(rates.reshape(count, len(rates) // count, rates.shape[1]))
    centred = means - means.mean(axis=0)
    variance = (centred**2).sum(axis=0)
    following = (centred[1:] * centred[:-1]).sum(axis=0)
    # rounding alone may make all batches alike
    correlation = np.divide(following, variance, out=np.zeros_like(variance), where=variance > 0.0)
    widening = np.sqrt(np.maximum((1.0 + correlation) / (1.0 - correlation), 1.0))
    scatter = widening * np.sqrt(variance / (count - 1) / count)
    exponents = _weighted(rates)
    return exponents, np.maximum(scatter, np.abs(exponents - means.mean(axis=0)))


def _weighted(rates: Values) -> Values:
    """Return the means of rates, shape (..., n, 4), over n, with weights 0 at its ends."""
    place = (np.arange(rates.shape[-2]) + 0.5) / rates.shape[-2]
    weights = np.exp(-1.0 / (place * (1.0 - place)))
    mean: Values = np.einsum("n,...ne->...e", weights / weights.sum(), rates)
    return mean
