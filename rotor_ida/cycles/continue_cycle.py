"""Continue a limit cycle over a parameter: the branch as a labelled dataset."""

from __future__ import annotations

from typing import Any, Literal, Unpack, get_args

import xarray as xr

from rotor_ida.checks import AT_REST, MOST_NUMBERS, check_choice, check_count, check_progress
from rotor_ida.cycles.followed_curves import WAYS, check_limits, followed_dataset, guess_for
from rotor_ida.cycles.guess import Guess
from rotor_ida.cycles.limit_cycle import with_period
from rotor_ida.cycles.problems import branch_through
from rotor_ida.model.parameters import OF_ROTOR
from rotor_ida.model.rotor import DimensionalRotor, Rotor
from rotor_ida.model.rotor_system import RotorSystem, SystemParameters
from rotor_ida.model.system_parameters import PARAMETERS_OF_SYSTEM, SPEED
from rotor_ida.parallel import Progress, shows_progress
from rotor_ida.results.in_si import takes_rotors
from rotor_ida.results.studies.results import Folder
from rotor_ida.simulation.flow import DiscFlow, Flow
from rotor_ida.simulation.starts import Start

Parameter = Literal[
    "omega", "zeta", "delta0", "shaft_stiffness", "contact_damping", "load", "friction",
    "disc_radius", "speed", "damping", "clearance", "stiffness", "unbalance",
]  # fmt: skip
Direction = Literal["both", "forward", "backward"]
OF_DISC = tuple(each for each in get_args(Parameter) if each in OF_ROTOR)
OF_SYSTEM = (SPEED, *PARAMETERS_OF_SYSTEM)


def parameters_of(flow: Flow) -> tuple[str, ...]:
    """Return the parameters over which cycles of a flow can be followed."""
    return OF_DISC if isinstance(flow, DiscFlow) else OF_SYSTEM


@shows_progress
@takes_rotors(
    system=("modes",), needed=(),
    defaults={"start": (AT_REST, None), "parameter": ("omega", "speed")},
)  # fmt: skip
def continue_cycle(
    rotor: Rotor | DimensionalRotor | RotorSystem,
    *,
    start: Start = AT_REST,
    parameter: Parameter = "omega",
    limits: tuple[float, float],
    direction: Direction = "both",
    points: int = 2000,
    study: Folder | None = None,
    progress: Progress | bool | None = None,
    speed: float | None = None,
    modes: int | None = None,
    **changed: Unpack[SystemParameters],
) -> xr.Dataset:
    """Follow a limit cycle over a parameter, around folds and through grazes.

    Parameters
    ----------
    rotor : Rotor, DimensionalRotor or RotorSystem
        The rotor. For a `DimensionalRotor` numbers with a unit are in SI units, as for
        `rotor_ida.simulate`; a dataset has its own.
    start : array_like, shape (4,), (q, velocity), "settled", "rest" or Dataset
        A start that leads to the cycle, as in `limit_cycle`; or the result of `limit_cycle`; or one
        point of a branch or curve, ``branch.isel(point=...)``; or one of its special points,
        ``branch.isel(special=...)``. From a period doubling the branch of doubled cycles is
        followed, from a Hopf point that of the cycles born there. Of a `RotorSystem` also one point
        of a `sweep`, or a Hopf point of `special_speeds`.
    parameter : {"omega", "zeta", "delta0", "shaft_stiffness", "contact_damping", "load", \
            "friction", "disc_radius"}
        The parameter to vary; the others are constant. A load cannot reach 0, where cycles have
        other periods. Of a `DimensionalRotor` also by the names ``speed``, ``damping`` and
        ``clearance``. Of a `RotorSystem` ``speed`` (the default) or a parameter of a `sweep`:
        ``clearance``, ``friction``, ``unbalance``, ``damping`` or ``stiffness``.
    limits : tuple of float
        Its smallest and largest value, [1] or in its SI unit; speeds of the same sign.
    direction : {"both", "forward", "backward"}
        Direction from the start. Forward is towards larger values of the parameter, or from a point
        of a branch onwards along that branch, or from a Hopf point towards larger cycles. From a
        period doubling there is only one direction.
    points : int
        The largest number of points each way.
    study : path-like, optional
        Folder in which points are stored as they are found. Points that it contains already are not
        computed again; the result is identical bit for bit. It must be new, empty, or of a study of
        the same branch.
    progress : callable or bool, optional
        Called with the number of points found and the largest possible number; True shows a bar on
        standard error.
    speed : float, optional
        Speed of a `RotorSystem` at the start; by default that of the start.
    modes : int, optional
        Of a `RotorSystem`, as in `simulate`.
    contacts, unbalance, supports, gravity, static_force : optional
        In place of those of a `RotorSystem`, as in `simulate`.

    Returns
    -------
    Dataset
        On ``point`` the continued parameter, ``period``, ``radius_min``, ``radius_max``,
        ``stability``, ``response``, ``contact_count``, ``largest_force``, ``impulse_per_period``,
        ``trace``, the multipliers, ``residual``, and a state ``x y vx vy`` on the rotating axes
        [1]. On ``special``, in order along the branch, ``special_kind`` (fold, period doubling,
        graze, torus, sliding, hopf, discontinuous), ``special_value`` of the parameter,
        ``special_period`` and the state there; ``special_point`` is the point before it. The
        attribute ``closed`` is 1 if the branch returns to its beginning. ``first_end`` and
        ``last_end`` are the kinds of its ends, ``first_reason`` and ``last_reason`` explain why no
        step was possible, or what hides the multipliers. Of a `RotorSystem` the numbers on
        ``point`` are those of `limit_cycle`, on ``special`` there are radii at each contact and
        ``special_state``, and over the clearance ``contact_clearance`` is that of each contact.

    Raises
    ------
    InputError
        If an argument cannot be used, or there is no limit cycle to start from.
    SimulationError
        If Newton's method does not converge to a first point.

    Notes
    -----
    Keller's pseudo-arclength continuation of ``(s, T, p)``, a state, the period and the parameter,
    by single shooting with Taylor series of order 19; see docs/cycles.md. Let M be the monodromy
    matrix and ``q = exp(-2 zeta T)``. A fold is a zero of ``2 (1 + q) - tr M``, a period doubling
    one of ``tr M``. At a graze the number of contacts changes: an extremum of the radius touches
    the stator. At ``sliding`` the number of times changes that the disc begins to roll or slides
    the other way: the slip speed just reaches 0, multipliers jump, and the branch has a corner,
    around which it is followed. At ``discontinuous`` multipliers jump over the unit circle, at such
    a corner or at a graze of a linear or damped contact.

    With contact damping, friction or a load, and of a `RotorSystem`, the multipliers do not form
    such pairs. Then the test functions are the products of ``1 - mu`` and of ``1 + mu`` over the
    nontrivial multipliers, each factor over its size where that is not small. A
    complex pair may cross the unit circle, where the product of ``1 - mu_i mu_j`` is 0: a torus is
    born, on which the motion never repeats. Under a load the period is that of k revolutions,
    ``k 2 pi/omega``, along the whole branch. Special points are located to rounding.

    A branch ends at the limits, closed, at ``halved`` (a doubled cycle has become one of half its
    period), at ``hopf`` (its cycles shrink to the whirl from which they are born, located by the
    closed form), at ``contact_free`` (its last contact vanishes), where no step can be taken, or
    after `points`. With other multipliers than pairs it may end at ``too_unstable``: neighbouring
    orbits separate so far in a period that rounding hides the multipliers, as where the period
    grows without bound.

    References
    ----------
    H. B. Keller, "Numerical solution of bifurcation and nonlinear eigenvalue problems", 1977.

    Examples
    --------
    >>> from rotor_ida import Rotor
    >>> rotor = Rotor(omega=3.0, zeta=0.07, delta0=0.5)
    >>> branch = continue_cycle(rotor, start=(3, 1, 0, 0), limits=(2.5, 3.2))
    >>> branch.special_value.values.round(6), branch.attrs["first_end"]
    (array([2.530419, 2.681874]), 'limits')

    The same disc as a system, over its friction:

    >>> system = Rotor(omega=1.2, zeta=0.07, delta0=0.5, friction=0.1, disc_radius=10.0).system()
    >>> branch = continue_cycle(system, speed=1.2, start=([3, 1], [0, 0]), parameter="friction",
    ...                         limits=(0.099, 0.101))
    >>> branch.friction.values[[0, -1]], branch.speed.item()
    (array([0.099, 0.101]), 1.2)
    """
    check_choice("direction", direction, tuple(WAYS))
    count = check_count("points", points, minimum=2, maximum=MOST_NUMBERS)
    reports = check_progress(progress)
    guess, given = guess_for(continue_cycle, rotor, start, speed, modes, changed)
    check_choice("parameter", parameter, parameters_of(guess.flow))
    bounds = check_limits(parameter, limits, guess.flow)
    return branch_from(
        with_period(guess), parameter, bounds, count, given, direction, study, reports
    )


def branch_from(
    guess: Guess,
    parameter: str,
    limits: tuple[float, float],
    points: int,
    system: dict[str, Any],
    direction: str = "both",
    study: Folder | None = None,
    progress: Progress | None = None,
) -> xr.Dataset:
    """Return the branch through a guess of a cycle with its period, as `continue_cycle` does."""
    told: dict[str, Any] = {"limits": limits, "direction": direction, "points": points}
    return followed_dataset(
        guess, branch_through(guess, parameter, limits, points), "continue_cycle", system, told,
        (parameter,), WAYS[direction], study, progress,
    )  # fmt: skip
