"""Method and tolerances of a simulation, and the limits on rotors and starts."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Any, Literal

from rotor_ida.checks import COMPONENTS, State, check_between, check_choice
from rotor_ida.core import library, sundials
from rotor_ida.errors import InputError, warn
from rotor_ida.model.parameters import OF_ROTOR, PARAMETERS
from rotor_ida.model.rotor import Rotor

Method = Literal["adams", "bdf", "ida", "taylor"]
Flight = Literal["exact", "cvode"]
Backend = Literal["auto", "python", "compiled"]

METHODS: tuple[Method, ...] = ("adams", "bdf", "ida", "taylor")
FLIGHTS: tuple[Flight, ...] = ("exact", "cvode")
BACKENDS: tuple[Backend, ...] = ("auto", "python", "compiled")

TIGHTEST_RTOL = 1e-13
LOOSEST_RTOL = 1e-3
TIGHTEST_ATOL = 1e-30
LOOSEST_ATOL = 1e-2
TIGHTEST_RTOL_OF_IDA = 1e-12
TIGHTEST_RTOL_OF_TAYLOR, LOOSEST_RTOL_OF_TAYLOR = 1e-15, 1e-4
# The solver controls the error of a step, and a contact takes about a hundred steps. Among 0.1,
# 0.05 and 0.03, the last gives most accuracy for its time.
STEP_SAFETY = 0.03

# Runs with contacts took 15 to 53 times as long as by the core.
SLOW_INSTEAD = (
    "This needs a C compiler or the package ziglang. Until then the plain-Python reference "
    "computes runs by CVODE, 10 to 100 times more slowly"
)

# Radians of spin, decay, shaft and contact that Taylor series cover in 5 to 25 ms. CVODE takes some
# ten times as long, and a sample less than a radian.
SOON_PASSED, OF_CVODE = 2e4, 10.0
# A contact with damping needs short steps: one unit of it costs as much as this spin speed.
STIFFENS = 10.0

# For larger starts the tolerances lose their meaning.
LARGEST = 1e6
# The final window contains whole revolutions: for slower rotors they take too long, and for faster
# ones there are too many.
SLOWEST_TO_SETTLE, FASTEST_TO_SETTLE = 1e-3, 1e3


@dataclass(frozen=True, kw_only=True, slots=True)
class Options:
    """Method and tolerances of a simulation; a bad value raises `InputError`.

    Parameters
    ----------
    rtol, atol : float
        Relative and absolute tolerance of a contact [dimensionless]. The solver uses a thirtieth of
        them.
    method : {"adams", "bdf", "ida", "taylor"}
        CVODE with Adams or BDF, or IDA, or Taylor series.
    flight : {"exact", "cvode"}
        Motion inside the clearance in closed form, or integrated by the same solver as the
        contact; ``backend="python"`` always integrates.
    backend : {"auto", "python", "compiled"}
        The plain-Python reference over scikit-sundae, or the compiled core, which is many times
        faster. ``"auto"`` becomes ``"compiled"`` where available.
    """

    rtol: float = 1e-10
    atol: float = 1e-12
    method: Method = "adams"
    flight: Flight = "exact"
    backend: Backend = "auto"

    def __post_init__(self) -> None:
        check_choice("method", self.method, METHODS)
        rtol = check_rtol(self.method, self.rtol)
        atol = check_between("atol", self.atol, TIGHTEST_ATOL, LOOSEST_ATOL)
        object.__setattr__(self, "rtol", rtol)
        object.__setattr__(self, "atol", atol)
        check_choice("flight", self.flight, FLIGHTS)
        if self.method == "taylor" and self.flight != "exact":
            raise InputError(f"flight must be 'exact' with taylor, got {self.flight!r}")
        object.__setattr__(self, "backend", backend_of(self.method, self.backend))
        if self.backend == "python":  # the reference has no closed form
            object.__setattr__(self, "flight", "cvode")

    def attributes(self) -> dict[str, object]:
        """Return method and tolerances as attributes of a result."""
        names = ("method", "flight", "backend", "rtol", "atol")
        return {name: getattr(self, name) for name in names}

    @property
    def step_rtol(self) -> float:
        """Relative tolerance of one step of the solver."""
        return STEP_SAFETY * self.rtol

    @property
    def step_atol(self) -> float:
        """Absolute tolerance of one step of the solver."""
        return STEP_SAFETY * self.atol


def backend_of(method: Method, backend: Backend) -> Backend:
    """Return the backend of a method, or raise `InputError` if it cannot be used.

    Examples
    --------
    >>> backend_of("ida", "auto"), backend_of("taylor", "auto")
    ('python', 'compiled')
    """
    check_choice("backend", backend, BACKENDS)
    if method == "taylor" and backend == "python":
        raise InputError("backend must be 'auto' or 'compiled' with taylor, got 'python'")
    if backend == "python" or method == "taylor":
        return "python" if backend == "python" else "compiled"
    of_ida = "it knows the methods adams and bdf, got 'ida'"
    reason = of_ida if method == "ida" else sundials.why_not()
    if backend == "compiled" and reason:
        raise InputError(f"backend 'compiled' cannot be used: {reason}")
    return "python" if reason else "compiled"


def with_fallback(method: Method, backend: Backend) -> tuple[Method, Backend]:
    """Return method and backend of a run, which are the reference's where there is no core.

    The change is the only one in the package, and gives a warning. A run whose backend is given
    as ``"compiled"`` keeps it, and is refused when it calls the core.

    Examples
    --------
    >>> with_fallback("taylor", "auto")
    ('taylor', 'auto')
    """
    missing = library.why_missing()
    if not missing or backend != "auto":
        return method, backend
    warn(f"{missing}. {SLOW_INSTEAD}")
    return "adams" if method == "taylor" else method, "python"


def adams_or_taylor(options: Mapping[str, Any]) -> Method:
    """Return the method of a run of one disc by these arguments, which name none.

    That is Adams, or Taylor series where SUNDIALS is missing and they are able to.

    Examples
    --------
    >>> adams_or_taylor({"backend": "python"})
    'adams'
    """
    told = {each: options[each] for each in ("rtol", "flight", "backend") if each in options}
    return "taylor" if sundials.why_not() and _taylor_is_able(**told) else "adams"


def _taylor_is_able(
    *, rtol: object = 1e-10, flight: object = "exact", backend: object = "auto"
) -> bool:
    """Return whether Taylor series go with these arguments, or these are refused anyway."""
    loose = isinstance(rtol, float) and rtol > LOOSEST_RTOL_OF_TAYLOR
    return flight == "exact" and backend != "python" and not loose


def options_of_study(
    *,
    rtol: float,
    atol: float,
    method: Method | None,
    flight: Flight = "exact",
    backend: Backend = "auto",
) -> Options:
    """Return the options of a study, by Taylor series if no method is given and they are able to.

    They need flight in closed form, the compiled core, and an `rtol` of at most 1e-4.

    Examples
    --------
    >>> given = {"rtol": 1e-10, "atol": 1e-12, "method": None}
    >>> options_of_study(**given).method, options_of_study(**given, backend="python").method
    ('taylor', 'adams')
    """
    if method is None:
        check_choice("flight", flight, FLIGHTS)
        check_choice("backend", backend, BACKENDS)
        able = _taylor_is_able(rtol=rtol, flight=flight, backend=backend)
        method = "taylor" if able else "adams"
    return Options(rtol=rtol, atol=atol, method=method, flight=flight, backend=backend)


def check_rtol(method: Method, rtol: float) -> float:
    """Return the relative tolerance, or raise `InputError` if the method does not allow it."""
    if method == "taylor":
        return check_between("rtol", rtol, TIGHTEST_RTOL_OF_TAYLOR, LOOSEST_RTOL_OF_TAYLOR)
    given = check_between("rtol", rtol, TIGHTEST_RTOL, LOOSEST_RTOL)
    if method == "ida" and given < TIGHTEST_RTOL_OF_IDA:
        raise InputError(f"rtol must be at least {TIGHTEST_RTOL_OF_IDA} with ida, got {given!r}")
    return given


def passes_soon(
    rotor: Rotor, start: Iterable[float], duration: float, method: Method, samples: int = 0
) -> bool:
    """Return whether compiled code follows a rotor for so short a time that nobody stops it.

    Examples
    --------
    >>> disc, rest = Rotor(omega=2.0, zeta=0.07, delta0=0.5), (0.0, 0.0, 0.0, 0.0)
    >>> [passes_soon(disc, rest, 5e3, each) for each in ("taylor", "adams")]
    [True, False]
    >>> stiff = Rotor(omega=2.0, zeta=0.07, delta0=0.5, contact_damping=100.0)
    >>> passes_soon(stiff, rest, 5e3, "taylor")
    False
    """
    pulled = rotor.load + math.sqrt(rotor.shaft_stiffness) + STIFFENS * rotor.contact_damping
    radians = (1.0 + rotor.omega + rotor.zeta + pulled + max(map(abs, start))) * duration
    return (radians if method == "taylor" else OF_CVODE * radians) + samples <= SOON_PASSED


def check_can_be_followed(rotor: Rotor, start: State, *, settling: bool = False) -> None:
    """Raise `InputError` for a rotor or start that cannot be simulated (until it settles)."""
    for name in PARAMETERS:
        value, least, most = getattr(rotor, name), OF_ROTOR[name].smallest, OF_ROTOR[name].largest
        if value > most:
            raise InputError(
                "{name} must be at most {most:g} to be simulated, got {value}",
                name=name, most=most, value=value,
            )  # fmt: skip
        if 0.0 < value < least:
            raise InputError(
                "{name} must be 0 or at least {least:g} to be simulated, got {value}",
                name=name, least=least, value=value,
            )  # fmt: skip
    for name, value in rotor.beyond.items():
        least, most = OF_ROTOR[name].smallest, OF_ROTOR[name].largest
        if value != 0.0 and not least <= value <= most:
            raise InputError(
                "{name} must be 0, or from {least:g} to {most:g}, to be simulated, got {value}",
                name=name, least=least, most=most, value=value,
            )  # fmt: skip
    if settling and rotor.omega and not SLOWEST_TO_SETTLE <= rotor.omega <= FASTEST_TO_SETTLE:
        raise InputError(
            "{name} must be 0 or from {least} to {most:g} to settle, got {value}",
            name="omega", least=SLOWEST_TO_SETTLE, most=FASTEST_TO_SETTLE, value=rotor.omega,
        )  # fmt: skip
    for name, value in zip(COMPONENTS, start, strict=True):
        if abs(value) > LARGEST:
            raise InputError(
                "{name} must lie within {most:g} of zero, got {value}",
                name=f"start {name}", most=LARGEST, value=value,
            )  # fmt: skip
