"""The contact of a rotor system: one element between a rotor's node and its stator.

The rotor system itself is linear; all that is not linear happens in its contacts. Each sees the
displacement u of its node from its centre, the velocity u', and the speeds of the rotor and of the
race, and answers with the force on the rotor. The law is that of one disc
(`rotor_ida.model.contact`) in dimensional form:

``d = |u| - delta``, ``N = k d**n max(0, 1 + lambda d')``, ``T = mu N sigma``,
``v_s = u'.t + R Omega - R_b Omega_b``, and the force on the rotor is ``-(N + i T) u/|u|``.

A stator without mass but with damping C moves as the contact pushes it, at once. It is given the
velocities that all else leaves, w, and its own follows from the force: with ``a = k d**n``,

``d' = w.e - N/C``, ``N = a max(0, 1 + lambda w.e)/(1 + a lambda/C)``, ``v_s = w.t + ... - T/C``;

and while the surfaces roll, ``v_s = 0`` gives T.

By Hertz the root ``s = sqrt(d)`` is a component of the state: in a fictitious time that runs by it
the motion is analytic through entry and exit. With a linear spring it is so in time itself, and d
stands in the place of s. While the surfaces roll on a stator with mass, T is not
known from the law; the core finds it from ``v_s' = 0`` for all contacts together.

A small change of the motion, e.c and t.c along e and t of the displacement, e.w and t.w of the
velocity, changes the force by

``-(dN - (T/r) t.c) e - ((N/r) t.c + dT) t``, ``dN = N_d e.c + N_t t.c + N_v e.w``, ``r = |u|``,

with ``dT = mu sigma dN`` while the surfaces slide; while they roll it follows from the change of
``v_s' = t.u'' - d' u'.t/r + ...``.

Without clearance a contact never opens, and e has no limit at u = 0. There the law is another one,
without friction and contact damping: the force is ``-s u`` with the secant ``s = k |u|**(n - 1)``,
a function of ``|u|**2`` that is analytic except, by Hertz, at the centre.
"""

from __future__ import annotations

from typing import Any

from rotor_ida.model.contact import (
    damped,
    damping_factor,
    drag_of,
    slope_of_root,
    spring_of_root,
)
from rotor_ida.model.forces import Number, Numbers, secant
from rotor_ida.model.symbols import variables

# What an element is given: the root of its indentation (or this itself), displacement and velocity,
# and the speeds of rotor and race.
GIVEN = ("root", "x", "y", "vx", "vy", "spin", "race")
PARAMETERS = (
    "clearance", "hertz", "linear", "contact_damping", "loose",
    "friction", "sigma", "radius", "race_radius", "mobility", "holding", "squared",
)  # fmt: skip
# What it answers, in this order; while surfaces roll, and with a stator without mass, one more.
ANSWERS = ("normal_x", "normal_y", "approach", "slip", "push", "force_x", "force_y")
ROLLING_ANSWERS = (*ANSWERS, "turning")
MASSLESS_ANSWERS = (*ANSWERS, "drag")
# What one without clearance answers, and the derivatives of this by the displacement.
CENTRED_ANSWERS = ("force_x", "force_y")
CENTRED_SLOPES = ("x_by_x", "x_by_y", "y_by_y")
# What its slopes follow from: the speed across is u'.t, and `pull` the acceleration along e.
SLOPE_GIVEN = ("root", "approach", "across", "push", "drag", "pull")
SLOPES = (
    "along", "aside", "rate", "push_share", "drag_share",
    "approach_share", "across_share", "difference", "product", "pull_share", "contact_damping",
)  # fmt: skip


def answers_of(given: Numbers, contact: Any) -> list[Number]:
    """Return what a contact answers: see `ANSWERS`.

    They are the direction e of the displacement, the radial velocity ``d'``, the speed of slip
    ``v_s``, the normal force N, and the force of a sliding contact on the rotor.
    """
    normal_x, normal_y, approach, across = _motion_of(given, contact)
    root, *_, spin, race = given
    slip = across + contact.radius * spin - contact.race_radius * race
    push = damped(_spring_of(root, contact), approach, contact)
    push_x, push_y = push * normal_x, push * normal_y
    force_x = drag_of(push_y, contact) - push_x
    force_y = -drag_of(push_x, contact) - push_y
    return [normal_x, normal_y, approach, slip, push, force_x, force_y]


def rolling_answers_of(given: Numbers, contact: Any) -> list[Number]:
    """Return what a contact answers while the surfaces roll: see `ROLLING_ANSWERS`.

    It is ``d' u'.t/|u|``, by which the rotation of the direction e changes the slip.
    """
    root, *_ = given
    _, _, approach, across = _motion_of(given, contact)
    turning = approach * across / (contact.clearance + _depth_of(root, contact))
    return [*answers_of(given, contact), turning]


def massless_answers_of(given: Numbers, contact: Any) -> list[Number]:
    """Return what a contact with a stator without mass answers: see `MASSLESS_ANSWERS`.

    `mobility` is 1/C, and `holding` C while the surfaces roll, else 0. The force holds T.
    """
    normal_x, normal_y, towards, aside = _motion_of(given, contact)
    root, *_, spin, race = given
    rim = contact.radius * spin - contact.race_radius * race
    spring = _spring_of(root, contact)
    softened = 1.0 + contact.mobility * contact.contact_damping * spring
    push = damped(spring, towards, contact) / softened
    drag = drag_of(push, contact) + contact.holding * (aside + rim)
    approach, across = towards - contact.mobility * push, aside - contact.mobility * drag
    slip = across + rim
    force_x = drag * normal_y - push * normal_x
    force_y = -(drag * normal_x) - push * normal_y
    return [normal_x, normal_y, approach, slip, push, force_x, force_y, drag]


def centred_answers_of(given: Numbers, contact: Any) -> list[Number]:
    """Return the force on the rotor of a contact without clearance: see `CENTRED_ANSWERS`."""
    _, x, y, *_ = given
    push = secant(x * x + y * y, contact)
    return [-(push * x), -(push * y)]


def centred_slopes_of(given: Numbers, contact: Any) -> list[Number]:
    """Return the derivatives of this force by the displacement: see `CENTRED_SLOPES`."""
    root, *place = given
    force_x, force_y = centred_answers_of([root, *variables(list(place[:2]))], contact)
    return [*force_x.parts, force_y.parts[1]]


def slopes_of(given: Numbers, contact: Any) -> list[Number]:
    """Return what a small change of the motion is multiplied by: see `SLOPES`.

    They are N_d, N_t, N_v, and N, T, d', u'.t and e.u'' over r; with the last, of the squares of
    ``u'.t/r`` and ``d'/r`` the difference, and of them the product; and the derivative of N by the
    contact damping. That by the clearance is -N_d.
    """
    root, approach, across, push, drag, pull = given
    radius = contact.clearance + _depth_of(root, contact)
    spring = _spring_of(root, contact)
    resisted = contact.contact_damping * spring
    along = slope_of_root(root, contact) * damping_factor(approach, contact.contact_damping)
    approach_share, across_share = approach / radius, across / radius
    return [
        along, resisted * across_share, resisted, push / radius, drag / radius,
        approach_share, across_share,
        across_share * across_share - approach_share * approach_share,
        approach_share * across_share, pull / radius, spring * approach,
    ]  # fmt: skip


def _depth_of(root: Number, contact: Any) -> Number:
    """Return the indentation: the square of what is followed, or this itself."""
    return contact.squared * (root * root) + (1.0 - contact.squared) * root


def _spring_of(root: Number, contact: Any) -> Number:
    """Return the elastic force."""
    return spring_of_root(root, contact, _depth_of(root, contact))


def _motion_of(given: Numbers, contact: Any) -> tuple[Number, Number, Number, Number]:
    """Return the direction e of the displacement, and the velocities along and across it."""
    root, x, y, vx, vy, _, _ = given
    radius = contact.clearance + _depth_of(root, contact)
    normal_x, normal_y = x / radius, y / radius
    approach = vx * normal_x + vy * normal_y
    across = vy * normal_x - vx * normal_y
    return normal_x, normal_y, approach, across
