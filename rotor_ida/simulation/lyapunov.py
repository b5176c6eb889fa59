"""Lyapunov exponents: the rate at which neighbouring motions diverge or converge."""

from __future__ import annotations

import math
from typing import Literal

import numpy as np
import xarray as xr

from rotor_ida.arrays import Values
from rotor_ida.checks import (
    AT_REST,
    MOST_NUMBERS,
    State,
    check_choice,
    check_count,
    check_duration,
    check_instance,
    check_positive,
)
from rotor_ida.core import sundials
from rotor_ida.core.interface import DONE, NOT_FINITE, message_of
from rotor_ida.core.runs import RunRequest, stretch
from rotor_ida.errors import InputError, SimulationError
from rotor_ida.model.equations import rotated
from rotor_ida.model.rotor import Rotor
from rotor_ida.parallel import Stop, interruptible
from rotor_ida.results.in_si import takes_si
from rotor_ida.results.provenance import provenance
from rotor_ida.results.run import parameter_coordinates
from rotor_ida.schema import Column, labelled_dataset
from rotor_ida.simulation.flow import ATOL
from rotor_ida.simulation.options import check_can_be_followed, check_rtol
from rotor_ida.simulation.starts import Start, state_of

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
# Points of the running mean, for a figure.
POINTS_SHOWN = 400
# Each span keeps four numbers in memory.
LONGEST = SPAN * MOST_NUMBERS


@takes_si
def lyapunov_exponent(
    rotor: Rotor,
    *,
    start: Start = AT_REST,
    transient: float = 500.0,
    duration: float = 5000.0,
    batches: int = BATCHES,
    rtol: float = 1e-10,
    method: MethodOfTangents = "taylor",
) -> xr.Dataset:
    """Compute the four Lyapunov exponents of the motion from a start.

    Parameters
    ----------
    rotor : Rotor or DimensionalRotor
        The rotor. For a `DimensionalRotor` numbers with a unit are in SI units, as for `simulate`.
    start : array_like, shape (4,), "settled", "rest" or Dataset
        ``(x, y, vx, vy)`` at time 0 [1]; default: at rest on the axis. Or a word, or a result that
        ends in a state, as for `rotor_ida.simulate`.
    transient : float
        Time to settle before averaging [1], at most 5 million; the tangent vectors align in it
        too.
    duration : float
        Time over which to average [1], at least 10 for each batch, at most 5 million.
    batches : int
        Number of parts of `duration`, at least 4, whose scatter gives the error.
    rtol : float
        Tolerance of one step, relative to the size of the state and of each tangent vector [1].
    method : {"taylor", "adams", "bdf"}
        Solver for motion and tangent vectors in contact: Taylor series, or CVODE, which is slower
        and an independent check.

    Returns
    -------
    Dataset
        ``lyapunov_exponent`` and ``lyapunov_error`` on ``exponent``, the largest first [1];
        their sum ``exponent_sum`` and its exact value, the ``divergence`` of the flow including
        the volume lost in reversals of sliding;
        ``running_exponent`` on ``t`` and ``exponent``, the plain mean so far.

    Raises
    ------
    InputError
        If an argument cannot be used.
    SimulationError
        If the integration is stuck.

    Notes
    -----
    On the rotating axes the motion is autonomous, with state s = (Z, W). The variational
    equation ``M' = J(s) M`` is integrated along the orbit; no neighbouring orbit is used. J is
    continuous, as the slope of the Hertz force grows from 0 like ``indentation**0.5``: M
    passes entries and exits without a jump (no saltation). Every half unit of time M is made
    orthonormal by Gram-Schmidt; the mean growth rates of its columns are the exponents.

    With friction M jumps, as the tangential force does, where the disc begins to roll or reverses
    its sliding; there M is multiplied by a saltation matrix. Rolling removes a dimension: for a
    motion that rolls repeatedly the last exponent is minus infinity.

    The mean is weighted by ``exp(-1/(u (1 - u)))``, with u from 0 to 1 along `duration`. On a
    periodic or quasi-periodic motion it converges faster than any power of the time, whereas a
    plain mean is off by its last unfinished oscillation. On a chaotic motion it is like any
    other mean. Each batch gives such a mean too. The error is the standard deviation of the batches
    over the square root of their number, enlarged where neighbouring batches are correlated, or
    the difference of their mean from that of `duration`, if that is larger. The difference between
    the sum of the exponents and the divergence is added. The error does not cover a transient that
    was too short.

    Independent checks: the four exponents add up to the divergence of the flow, ``-4 zeta``, and
    the first and the last, like the two between them, to ``-2 zeta``. (This does not hold with
    contact damping, where the divergence varies along the orbit and NaN is reported, nor with
    friction, where each reversal adds ``ln((|F| - mu N)/(|F| + mu N))``.) Without a load, any
    motion but a synchronous whirl has one zero exponent, that of a shift in time. On a
    synchronous whirl the exponents are the real parts of its eigenvalues. A chaotic motion may be
    a long transient: a run that leaves it half way shows a large error.

    References
    ----------
    G. Benettin, L. Galgani, A. Giorgilli, J.-M. Strelcyn, "Lyapunov characteristic exponents
    for smooth dynamical systems", Meccanica 15, 1980.
    S. Das, Y. Saiki, E. Sander, J. A. Yorke, "Quantitative quasiperiodicity", Nonlinearity 30,
    2017: the weights.
    U. Dressler, "Symmetry property of the Lyapunov spectra of a class of dissipative dynamical
    systems with viscous damping", Physical Review A 38, 1988: the pairs.
    P. C. Müller, Chaos, Solitons & Fractals 5, 1995: the jump at discontinuities.

    Examples
    --------
    >>> from rotor_ida import Rotor
    >>> found = lyapunov_exponent(Rotor(omega=1.7, zeta=0.07, delta0=0.0), start=(0, 0, 0, 0),
    ...                           duration=1000.0)
    >>> found.lyapunov_exponent.values.round(5)
    array([-0.07, -0.07, -0.07, -0.07])
    """
    check_instance("rotor", rotor, Rotor)
    first = state_of("start", start, rotor)
    check_can_be_followed(rotor, first)
    lead = check_positive("transient", transient, LONGEST)
    length = check_positive("duration", duration, LONGEST)
    check_duration("transient + duration", lead + length, rotor.omega)
    count = check_count("batches", batches, FEWEST_BATCHES)
    each = int(length / (count * SPAN))
    if each < FEWEST_SPANS:
        raise InputError(
            "{name} must be at least {least:g} for each of {count} batches, got {value}",
            name="duration",
            least=FEWEST_SPANS * SPAN,
            count=count,
            value=length,
        )
    check_choice("method", method, METHODS_OF_TANGENTS)
    if method != "taylor" and (reason := sundials.why_not()):
        raise InputError(f"CVODE with tangents cannot be used: {reason}")
    tolerance = check_rtol(method, rtol)
    span = length / (count * each)
    spans = (math.ceil(lead / span), count * each)
    stretches = interruptible(
        lambda stop: _stretches(rotor, first, *spans, span, tolerance, stop, method)
    )
    exponents, errors, divergence = _means(stretches / span, count, _divergence(rotor))
    order = np.argsort(-exponents, kind="stable")
    shown = np.unique(np.linspace(1, count * each, min(POINTS_SHOWN, count * each)).astype(int))
    running = np.cumsum(stretches[:, :4], axis=0)[shown - 1] / (span * shown[:, None])
    columns: dict[str, Column] = {
        "lyapunov_exponent": ("exponent", exponents[order]),
        "lyapunov_error": ("exponent", errors[order]),
        "exponent_sum": ((), exponents.sum()),
        "divergence": ((), divergence),
        "running_exponent": (("t", "exponent"), running[:, order]),
    }
    coordinates = parameter_coordinates(rotor)
    coordinates |= {"exponent": ("exponent", np.arange(4)), "t": ("t", span * shown)}
    how = {"method": method, "flight": "exact", "rtol": tolerance}
    attributes = provenance(how) | {
        "start": np.array(first), "transient": lead, "duration": length, "batches": count,
    }  # fmt: skip
    return labelled_dataset(
        "Lyapunov exponents of one motion",
        columns,
        coordinates,
        attributes,
        kind="lyapunov_exponent",
    )


def exponents_of(
    rotor: Rotor, start: State, duration: float, stop: Stop, *, rtol: float = 1e-10
) -> tuple[Values, Values]:
    """Return the Lyapunov exponents of a settled motion, largest first, and their errors.

    Means over `duration` from `start`, on the rotating axes. Raise `SimulationError` if the
    integration is stuck, or stopped.
    """
    spans = (math.ceil(TURNING_TIME / SPAN), BATCHES * math.ceil(duration / (BATCHES * SPAN)))
    stretches = _stretches(rotor, start, *spans, SPAN, rtol, stop, "taylor")
    exponents, errors, _ = _means(stretches / SPAN, BATCHES, _divergence(rotor))
    order = np.argsort(-exponents, kind="stable")
    return exponents[order], errors[order]


def _stretches(
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


def _divergence(rotor: Rotor) -> float:
    """Return the divergence of the flow; NaN where it varies along an orbit."""
    return math.nan if rotor.contact_damping > 0.0 else -4.0 * rotor.zeta


def _means(rates: Values, count: int, divergence: float) -> tuple[Values, Values, float]:
    """Return the means of four rates, their standard errors from `count` batches, and their sum.

    The sum is the exact one: the divergence plus the contribution of jumps, the last of the five
    rates. An exponent is minus infinity if any of its rates is, and then has no error.
    """
    exact = divergence + float(_weighted(rates[:, 4:])[0])
    lost = bool((rates[:, 3] == -np.inf).any())
    known = 3 if lost else 4
    exponents, errors = np.full(4, -np.inf), np.zeros(4)
    exponents[:known], errors[:known] = means_of_rates(rates[:, :known], count)
    if lost:
        return exponents, errors, -math.inf
    defect = 0.0 if math.isnan(exact) else abs(float(exponents.sum()) - exact)
    return exponents, errors + defect, exact


def means_of_rates(rates: Values, count: int) -> tuple[Values, Values]:
    """Return the mean of rates, shape (n, m), and its standard error from `count` batches."""
    means = _weighted(rates.reshape(count, -1, rates.shape[1]))
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
