"""The modes of motion of a rotor, in contact and without clearance, and the models made of them.

A mode is a state, its rate of change, and guards: components of the state that pass through 0 where
the mode ends, or at another event. All are plain Python with only sums, products, quotients and
constant powers. Run over numbers they are the model itself. Run once over symbols they give what
the compiled core needs (`rotor_ida.model.writing`): fields and Jacobians, Taylor series, the growth
of small differences, and the derivatives by the parameters.

`rotor_ida.model.rates` has the equations of motion of each mode, `rotor_ida.model.neighbours` what
small differences do, and `rotor_ida.model.drawn_rates` what an integrator needs besides: the energy
that is spent, and the return to constraints.

The core is derived for three models. In the paper's rotor shaft, contact damping and load are the
number 0 and vanish. In the whole model (`whole`) the states include the direction of the load and
the work of a contact. The third is the whole model at a changing speed
(`rotor_ida.model.spinning`).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from typing import Any

from rotor_ida.model.drawn_rates import (
    drawn_contact_rates,
    drawn_rolling_rates,
    drawn_rub_rates,
)
from rotor_ida.model.forces import Number, Numbers
from rotor_ida.model.neighbours import (
    Neighbour,
    cartesian_neighbour,
    contact_neighbour,
    rolling_neighbour,
    rub_neighbour,
)
from rotor_ida.model.parameters import ALL_PARAMETERS, FRICTIONLESS, PARAMETERS
from rotor_ida.model.rates import (
    CARTESIAN_STATE,
    CONTACT_STATE,
    cartesian_rates,
    contact_rates,
    grip_and_hold,
    rolling_rates,
    rub_rates,
)


@dataclass(frozen=True, slots=True)
class Guard:
    """A component of the state that passes through 0 at an event.

    Parameters
    ----------
    event : str
        The event where it passes through 0.
    of : str
        Name of the component.
    """

    event: str
    of: str


@dataclass(frozen=True, slots=True)
class Mode:
    """A mode of motion.

    Parameters
    ----------
    name : str
        Its name in derived code.
    state : tuple of str
        Names of the components of its state.
    rates : callable
        ``rates(state, rotor)`` returns the rate of change of each component. A rotor is any object
        with the parameters as attributes.
    neighbour : callable
        ``neighbour(state, apart, deeper, rotor)`` returns to first order the position, velocity and
        acceleration of a rotor at the distance `apart`, with an indentation `deeper` by that
        amount, and the rate of rotation of their basis. None where nothing is differentiated.
    pace : callable
        ``pace(state)``: derivative of time by the variable of integration.
    guards : tuple of Guard
        Its guards.
    drawn_rates : callable
        As `rates`, with terms that return the state to its constraints, for an integrator that
        cannot project it after a step; and the rates of components without a series.
    watched : callable, optional
        ``watched(state, rotor)`` returns quantities that are not components of the state but decide
        the end of the mode; the core computes their series, values and rates of change.
    """

    name: str
    state: tuple[str, ...]
    rates: Callable[[Numbers, Any], list[Number]]
    neighbour: Callable[[Numbers, Numbers, Number, Any], Neighbour] | None
    pace: Callable[[Numbers], Number]
    guards: tuple[Guard, ...]
    drawn_rates: Callable[[Numbers, Any], list[Number]]
    watched: Callable[[Numbers, Any], list[Number]] | None = None


CONTACT = Mode(
    name="contact",
    state=CONTACT_STATE,
    rates=contact_rates,
    neighbour=contact_neighbour,
    pace=lambda state: state[0],
    guards=(
        Guard(event="exit", of="q"),
        Guard(event="extremum", of="p"),
    ),
    drawn_rates=drawn_contact_rates,
)
CARTESIAN = Mode(
    name="cartesian",
    state=CARTESIAN_STATE,
    rates=cartesian_rates,
    neighbour=cartesian_neighbour,
    pace=lambda _state: 1.0,
    guards=(),
    drawn_rates=cartesian_rates,
)
WHOLE_CONTACT = replace(
    CONTACT, state=(*CONTACT_STATE[:5], "down_r", "down_t", "t", "j", "work", "spent")
)
# Arranged like a contact without friction, except for the moment of the slip, and the heat.
RUB_STATE = (*WHOLE_CONTACT.state[:2], "slip", *WHOLE_CONTACT.state[3:], "heat")
RUB = Mode(
    name="rub",
    state=RUB_STATE,
    rates=rub_rates,
    neighbour=rub_neighbour,
    pace=lambda state: state[0],
    guards=(*CONTACT.guards, Guard(event="roll", of="slip")),
    drawn_rates=drawn_rub_rates,
)
ROLLING = Mode(
    name="rolling",
    state=RUB_STATE,
    rates=rolling_rates,
    neighbour=rolling_neighbour,
    pace=lambda state: state[0],
    guards=CONTACT.guards,
    drawn_rates=drawn_rolling_rates,
    watched=grip_and_hold,
)
WHOLE_CARTESIAN = replace(CARTESIAN, state=(*CARTESIAN_STATE, "down_x", "down_y"))


@dataclass(frozen=True, slots=True)
class Model:
    """A model for which a core is derived.

    Parameters
    ----------
    name : str
        Its name in file names.
    modes : tuple of Mode
        The modes of motion.
    parameters : tuple of str
        Parameters of a rotor, and of a mode, that are not constant.
    constants : dict
        Parameters that are fixed numbers.
    columns : tuple of str
        The parameters by which the core differentiates.
    lighter : dict
        Additional series of each mode that need fewer products, by name, with the parameters that
        are fixed numbers in them. Named components of a state are 0.
    """

    name: str
    modes: tuple[Mode, ...]
    parameters: tuple[str, ...]
    constants: dict[str, float]
    columns: tuple[str, ...]
    lighter: dict[str, dict[str, float]] = field(default_factory=dict)


# Parameters of forces that the paper's rotor lacks, except friction.
OF_FORCES = tuple(name for name in FRICTIONLESS if name != "contact_exponent")
PAPER = Model(
    name="paper",
    modes=(CONTACT, CARTESIAN),
    parameters=(*PARAMETERS, "felt"),
    constants={
        **dict.fromkeys((*OF_FORCES, "linear", "loose"), 0.0),
        "hertz": 1.0,
    },
    columns=PARAMETERS,
)
WHOLE = Model(
    name="whole",
    modes=(WHOLE_CONTACT, WHOLE_CARTESIAN, RUB, ROLLING),
    # friction has the speed of the rim, rho omega, and the sense in which surfaces slide
    parameters=(
        *PARAMETERS, *OF_FORCES, "hertz", "linear", "felt", "loose",
        "friction", "disc_radius", "rim", "sigma",
    ),
    constants={},
    columns=tuple(name for name in ALL_PARAMETERS if name != "contact_exponent"),
)  # fmt: skip
