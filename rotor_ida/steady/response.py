"""Kinds of response, and the questions about a motion that one window of it answers.

`rotor_ida.steady.decision` asks them, in its order, and those that need further runs.

========================= ==========================================================
``contact_free``          whirls inside the clearance and will not touch the stator again
``synchronous``           whirls in contact with the unbalance, at constant radius
``bouncing``              is periodic, and enters and leaves contact (intermittent rub)
``full_contact``          is periodic, always in contact, radius not constant (full annular rub)
``rolling``               whirls backwards, always in contact, and rolls on the stator in every
                          period (dry whip)
``touching``              is contact-free in the limit, through ever slighter touches, or where
                          the contact-free whirl just reaches the stator
``quasi_periodic``        never repeats, and neighbouring motions keep their distance
``chaotic``               is not periodic, and neighbouring motions diverge
``unresolved``            none of these within the simulated time
``failed``                unknown, as a run failed
========================= ==========================================================

Periods are those on the rotating axes, where a synchronous whirl is stationary. Under a load they
are whole revolutions, and the same on fixed axes. A cycle on the rotating axes whose period is not
a whole number of revolutions is quasi-periodic on fixed axes, and a slight load makes it a torus.
A rotor at speed 0 comes to rest under its load: on the stator, which counts as synchronous, or
inside the clearance, contact-free. With friction it may rest at other places.
"""

from __future__ import annotations

import math

import numpy as np

from rotor_ida.arrays import Values
from rotor_ida.closed_forms.contact_free import complex_amplitude, touch_fading
from rotor_ida.closed_forms.rest import rest
from rotor_ida.model.contact import contact_force, secant_stiffness
from rotor_ida.model.rotor import Rotor
from rotor_ida.schema.flags import ENTRY
from rotor_ida.simulation.flow import DiscFlow, Window
from rotor_ida.simulation.system_flow import SystemFlow

CONTACT_FREE = "contact_free"
SYNCHRONOUS = "synchronous"
BOUNCING = "bouncing"
FULL_CONTACT = "full_contact"
ROLLING = "rolling"
TOUCHING = "touching"
QUASI_PERIODIC = "quasi_periodic"
CHAOTIC = "chaotic"
UNRESOLVED = "unresolved"

# A whirl satisfies the equation of motion when the residual is less than this fraction of the
# largest term; close to a fold the rotor creeps at nearly constant radius where there is no whirl.
RESIDUAL = 1e-6
# A period fits into a window, up to rounding, if it does to within this fraction of the period.
SAME_LENGTH = 1e-6
# Fewer touches in a window do not establish the law.
FEWEST_TOUCHES = 3
# Near the limit the whirl is stationary: touches are one revolution apart, to this fraction.
ONCE_A_REVOLUTION = 0.01
# A contact-free whirl just reaches the stator if its largest radius is the clearance to within this
# part of it, and the motion is there when it is off the whirl by less than `Flow.steady`.
GRAZES = 1e-9
# Nearer to it than this part contacts get so shallow that CVODE takes millions of steps, and
# touches without a shaft fade too slowly to show their law.
NEARLY_GRAZES = 1e-6
# A contact is soft if its stiffness is below this part of another.
SOFT = 0.1
# And 1/h grows by the law to within this fraction. The law is of leading order in h: after 24/zeta,
# over speeds from 0.15 to 3 and dampings from 0.07 to 0.5, no touch missed it by over 8 %.
LIKE_THE_LAW = 0.1


def kind_by_closed_forms(window: Window) -> str | None:
    """Return the kind of a motion of one disc where closed forms show that it stays; else None."""
    if not isinstance(window.flow, DiscFlow):
        return None
    if window.flow.rotor.omega == 0.0 < window.flow.rotor.load:
        return kind_at_rest(window)
    if grazes(window):
        return TOUCHING
    if whirls_steadily(window):
        return SYNCHRONOUS
    return CONTACT_FREE if stays_free(window) else None


def whirls_steadily(window: Window) -> bool:
    """Return whether it is a synchronous whirl in contact."""
    rotor, places = _rotor_of(window), window.places[0, :, 0]
    if window.touches or not window.closed_last[0] or rotor.omega == 0.0:
        return False
    whirl, steady = complex(places[:-1].mean()), window.flow.steady
    stray = float(np.abs(places - whirl).max())
    return stray <= steady * abs(whirl) and _obeys_the_equation(rotor, whirl, steady)


def _obeys_the_equation(rotor: Rotor, whirl: complex, steady: float) -> bool:
    """Return whether ``(s (1 + i mu) + kappa - omega**2 + 2 i zeta omega) Z = omega**2``.

    The disc slides forwards, so friction pulls it back.
    """
    omega = rotor.omega
    secant = float(secant_stiffness(abs(whirl), rotor.delta0, rotor.contact_exponent))
    stiffness = complex(secant + rotor.shaft_stiffness, rotor.friction * secant)
    terms = (stiffness * whirl, -(omega**2) * whirl, 2j * rotor.zeta * omega * whirl, -(omega**2))
    return abs(sum(terms)) <= max(RESIDUAL, steady) * max(map(abs, terms))


def stays_free(window: Window) -> bool:
    """Return whether it has left the stator for good, or has come to rest at the centre."""
    rotor, steady = _rotor_of(window), window.flow.steady
    if rotor.omega == 0.0 and float(np.abs(window.places[0]).max()) <= steady:
        return True
    if window.touches or window.closed_last[0]:
        return False
    drift, reach = _future_if_free(rotor, *window.places[:, -1, 0].tolist())
    return drift <= steady * rotor.delta0 and reach <= rotor.delta0


def rolls_backwards(window: Window, period: float | None = None) -> bool:
    """Return whether it is a dry whip.

    A contact whirls backwards, stays closed, and rolls at some time in every period, or in every
    revolution if it has no period.
    """
    each = window.flow.revolution if period is None else period
    return any(
        len(rolling)
        and math.isfinite(each)
        and stays_backward(window, number)
        and _rolls_in_each(rolling, float(window.times[-1]), each)
        for number, rolling in enumerate(window.rolling)
    )


def stays_backward(window: Window, number: int) -> bool:
    """Return whether a contact stays closed and whirls backwards."""
    own = window.event_kinds[window.event_contacts == number]
    if not window.closed_first[number] or (np.abs(own) == ENTRY).any():
        return False
    place, velocity = window.places[:, :, number]
    backward = (place.conj() * velocity).imag * math.copysign(1.0, window.flow.speed)
    return bool(backward.max() < 0.0)


def _rolls_in_each(rolling: Values, length: float, period: float) -> bool:
    """Return whether stretches of rolling, shape (m, 2), overlap every period of a window."""
    starts = length - period * np.arange(1, int(length / period + SAME_LENGTH) + 1)
    begins, ends = rolling.T[:, :, None]
    overlap = np.minimum(ends, starts + period) - np.maximum(begins, starts)
    return bool((overlap.max(axis=0) > 0.0).all())


def grazing_distance(rotor: Rotor) -> float:
    """Return how far the contact-free whirl reaches beyond the clearance, over that; NaN for none.

    Its centre is the bearing axis, or with a shaft where that holds the load.
    """
    kappa, load = rotor.shaft_stiffness, rotor.load
    if rotor.delta0 == 0.0 or rotor.omega == 0.0 or (kappa == 0.0 and load > 0.0):
        return math.nan
    sag = load / kappa if load > 0.0 else 0.0
    reach = abs(complex(complex_amplitude(rotor.omega, rotor.zeta, kappa))) + sag
    return reach / rotor.delta0 - 1.0


def grazes(window: Window) -> bool:
    """Return whether it is on the contact-free whirl that just reaches the stator.

    On which side of the clearance rounding has put that makes no difference.
    """
    rotor, (place, velocity) = _rotor_of(window), window.places[:, -1, 0].tolist()
    allowed = 2.0 * window.flow.steady * rotor.delta0
    if rotor.load == 0.0 and abs(abs(place) - rotor.delta0) > 4.0 * allowed:
        return False  # on that whirl it would be at the clearance
    if rotor.zeta == 0.0 or not abs(grazing_distance(rotor)) <= GRAZES:
        return False
    drift, reach = _future_if_free(rotor, place, velocity)
    return max(drift, abs(reach - rotor.delta0)) <= allowed


def _future_if_free(rotor: Rotor, position: complex, velocity: complex) -> tuple[float, float]:
    """Return how far a free whirl's centre would still drift, and its largest radius.

    With a shaft the energy of the transient only decreases, which bounds both. Under a
    load the axes must point along the fixed ones; without a shaft the rotor falls.
    """
    omega, zeta = rotor.omega, rotor.zeta
    if rotor.shaft_stiffness > 0.0:
        resistance = complex(rotor.shaft_stiffness - omega**2, 2.0 * zeta * omega)
        if resistance == 0.0:
            return math.inf, math.inf
        whirl, sag = omega**2 / resistance, rotor.load / rotor.shaft_stiffness
        off, surplus = position - whirl + 1j * sag, velocity - 1j * omega * whirl
        unsettled = math.hypot(abs(off), abs(surplus) / math.sqrt(rotor.shaft_stiffness))
        return unsettled, abs(whirl) + sag + unsettled
    if rotor.load > 0.0:
        return math.inf, math.inf
    whirl = complex(complex_amplitude(omega, zeta))
    surplus = velocity - 1j * omega * whirl
    if surplus != 0.0 and zeta == 0.0:
        return math.inf, math.inf
    drift = surplus / (2.0 * zeta) if surplus != 0.0 else 0j
    centre = position - whirl
    return abs(drift), max(abs(centre), abs(centre + drift)) + abs(whirl)


def touches_fade(window: Window) -> bool:
    """Return whether ever slighter touches follow the law of `touch_fading`.

    Near its limit the whirl is so nearly stationary that it touches exactly once a revolution. A
    motion that touches more or less often is not near it, and is not decided here. Where the whirl
    just reaches the stator without a shaft, all soft ones that grow slighter fade: its centre comes
    back to the axis, by another law.
    """
    growth = _growth_from_touch_to_touch(window)
    if growth is None:
        return False
    if isinstance(window.flow, SystemFlow):
        number = int(window.contacts["contact"][0])
        law = window.flow.touch_fading(number, abs(complex(window.places[0, :-1, number].mean())))
        return bool((np.abs(growth / law - 1.0) <= LIKE_THE_LAW).all())
    rotor = _rotor_of(window)
    if rotor.shaft_stiffness > 0.0 or rotor.load > 0.0:
        return False
    if -NEARLY_GRAZES <= grazing_distance(rotor) <= GRAZES:
        return bool((growth > 0.0).all()) and _touches_softly(window)
    return bool((np.abs(growth / touch_fading(rotor) - 1.0) <= LIKE_THE_LAW).all())


def _touches_softly(window: Window) -> bool:
    """Return whether contacts are soft beside what resists the contact-free whirl without a shaft.

    Then they hardly change that whirl, and on the whole they push its centre inwards.
    """
    rotor = _rotor_of(window)
    deepest = float(np.nanmax(window.contacts["peak_root"]) ** 2)
    stiffness = rotor.contact_exponent * deepest ** (rotor.contact_exponent - 1.0)
    return bool(stiffness <= SOFT * rotor.omega * math.hypot(rotor.omega, 2.0 * rotor.zeta))


def touches_grow_slighter(window: Window) -> bool:
    """Return whether each touch is slighter than the last, a revolution later, by any law.

    Such a motion over a whole window approaches fading touches, and is not chaotic.
    """
    growth = _growth_from_touch_to_touch(window)
    return growth is not None and bool((growth > 0.0).all())


def _growth_from_touch_to_touch(window: Window) -> Values | None:
    """Return the growth of 1/h, h the indentation; None unless it touches once a revolution.

    With a linear contact it is the growth of ``1/sqrt(h)``. None for a rotor system that touches
    in several contacts.
    """
    contacts = window.contacts
    if isinstance(window.flow, SystemFlow):
        numbers = np.unique(contacts["contact"]).astype(int)
        if numbers.size != 1:
            return None
        exponent = window.flow.problem.assembly.contacts[numbers[0]].exponent
    else:
        exponent = _rotor_of(window).contact_exponent
    depth = contacts["peak_root"] ** 2
    whole = np.isfinite(contacts["entry"]) & np.isfinite(contacts["exit"]) & (depth > 0.0)
    if whole.sum() < FEWEST_TOUCHES:
        return None
    revolutions = np.diff(contacts["peak_time"][whole]) / window.flow.revolution
    if (np.abs(revolutions - 1.0) > ONCE_A_REVOLUTION).any():
        return None
    growth: Values = np.diff(depth[whole] ** (0.5 - exponent))
    return growth


def kind_at_rest(window: Window) -> str:
    """Return the kind of a rotor at speed 0 under a load: at rest, or unresolved."""
    rotor = _rotor_of(window)
    if rotor.friction > 0.0:
        return _kind_held_by_friction(window)
    place = rest(rotor)
    y = place["y"].item()
    off = np.abs(window.states - np.array([0.0, y, 0.0, 0.0])).max()
    if off > window.flow.steady * abs(y):
        return UNRESOLVED
    return SYNCHRONOUS if place["indentation"] > 0.0 else CONTACT_FREE


def _kind_held_by_friction(window: Window) -> str:
    """Return the kind of a rotor that friction may keep at rest away from the bottom."""
    rotor, place = _rotor_of(window), complex(window.places[0, -1, 0])
    off = np.abs(window.states - np.array([place.real, place.imag, 0.0, 0.0])).max()
    if off > window.flow.steady * abs(place):
        return UNRESOLVED
    radius = abs(place)
    normal = float(contact_force(radius, rotor.delta0, rotor.contact_exponent))
    # the force of load and shaft on the contact, along the radius and across it
    pull = (-1j * rotor.load - rotor.shaft_stiffness * place) * place.conjugate() / radius
    allowed = RESIDUAL * rotor.load
    balanced = abs(pull.real - normal) <= allowed
    kept = abs(pull.imag) <= rotor.friction * normal + allowed
    if not (balanced and kept):
        return UNRESOLVED
    return SYNCHRONOUS if normal > 0.0 else CONTACT_FREE


def phase_lag_of(whirl: complex) -> float:
    """Return the angle by which a whirl lags the unbalance [rad]."""
    return math.atan2(-whirl.imag, whirl.real) if whirl else 0.0


def _rotor_of(window: Window) -> Rotor:
    """Return the rotor of one disc."""
    assert isinstance(window.flow, DiscFlow)
    return window.flow.rotor
