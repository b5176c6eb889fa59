"""Check arguments: each function returns the clean value or raises `InputError` with one line.

Numbers and vectors may be anything that NumPy accepts: scalars, arrays of NumPy, xarray and
pandas, lists, tuples and ranges. The results are plain floats.
"""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Iterable, Mapping, Sequence, Sized
from dataclasses import dataclass
from difflib import get_close_matches
from functools import wraps
from inspect import signature
from numbers import Integral, Real
from pathlib import PurePath
from reprlib import Repr
from typing import Any, TypeVar

import numpy as np
import numpy.typing as npt

from rotor_ida.arrays import Values
from rotor_ida.errors import InputError
from rotor_ida.texts import LONGEST_NAME, LONGEST_NOTE, unfit

State = tuple[float, float, float, float]
AT_REST: State = (0.0, 0.0, 0.0, 0.0)
Kind = TypeVar("Kind")

# The components of a state, in their order everywhere.
COMPONENTS = ("x", "y", "vx", "vy")
# Words for starts that depend on the rotor: the whirl without contact, and the equilibrium.
STARTS = ("settled", "rest")

LARGEST_SEED = 2**63 - 1
MOST_WORKERS = 512
# What fits into the memory of most computers: numbers of an axis, samples, points of a grid.
MOST_NUMBERS = 10_000_000
MOST_POINTS_OF_STUDY = 10_000_000_000
# Samples in each revolution that is plotted or analysed.
SAMPLES_A_REVOLUTION = 32
# Shocks of one kind to each attractor of a rotor.
MOST_SHOCKS = 10_000_000
# A figure with more panels cannot be read.
MOST_PANELS = 12
# Powers of larger numbers leave the range of doubles.
LARGEST_NUMBER = 1e15
# Squares of larger samples, and products of the squares, do so too.
LARGEST_SAMPLE = 1e60
# Largest spacing of doubles at the end of a motion, in radians of the revolution or in time.
COARSEST_TIME = 1e-6

# Python and NumPy count these as numbers.
_NO_NUMBERS: tuple[type, ...] = (bool, np.bool_, np.timedelta64)
# Each of their bytes would pass for a number.
_BYTES = (bytes, bytearray, memoryview)
# Paths are text, and seldom longer than this.
_LONGEST_SHOWN = 160
_short = Repr()
_short.maxstring = _LONGEST_SHOWN
_short.maxother = _short.maxlong = _LONGEST_SHOWN // 2


def shown(value: object) -> str:
    r"""Return a value as a message shows it: in one short line.

    Examples
    --------
    >>> shown(1.5), shown("a\nb"), len(shown(10**400)) < 100, shown([0] * 1000)
    ('1.5', "'a\\nb'", True, '[0, 0, 0, 0, 0, 0, ...]')
    """
    if isinstance(value, (str, PurePath)):  # keeps its blanks
        return _short.repr(str(value))
    try:
        text = " ".join(_short.repr(value).split())
    except ValueError:  # too many digits for Python to show
        text = f"a number of type {type(value).__name__} too long to show"
    half = _LONGEST_SHOWN // 2
    return text if len(text) <= 2 * half else f"{text[: half - 3]}...{text[-half:]}"


def listed(names: Sequence[str], last: str = "and") -> str:
    """Return names as a sentence lists them.

    Examples
    --------
    >>> listed(["omega", "zeta", "delta0"]), listed(["kg", "g"], "or"), listed(["FILE"])
    ('omega, zeta and delta0', 'kg or g', 'FILE')
    """
    *first, end = names
    return f"{', '.join(first)} {last} {end}" if first else end


def check_name(what: str, value: object) -> str:
    r"""Return the name of something, a short text without control characters.

    Examples
    --------
    >>> check_name("name of a node", "disc"), check_name("name of a node", "Scheibe #2 </>")
    ('disc', 'Scheibe #2 </>')
    >>> check_name("name of a node", "disc\x1b[31m")
    Traceback (most recent call last):
    ...
    rotor_ida.errors.InputError: name of a node must have no control characters, got
    'disc\x1b[31m' with '\x1b'
    """
    if not isinstance(value, str) or not value:
        raise InputError(f"{what} must be text, got {shown(value)}")
    if len(value) > LONGEST_NAME:
        raise InputError(
            f"{what} must have at most {LONGEST_NAME} characters, got {len(value)}: {shown(value)}"
        )
    _check_characters(what, value)
    return value


def check_note(what: str, value: object) -> str:
    """Return a note, a text of some lines without other control characters.

    Examples
    --------
    >>> check_note("note", "Bearings at 300 rad/s.")
    'Bearings at 300 rad/s.'
    """
    if not isinstance(value, str):
        raise InputError(f"{what} must be text, got {shown(value)}")
    if len(value) > LONGEST_NOTE:
        raise InputError(f"{what} must have at most {LONGEST_NOTE} characters, got {len(value)}")
    _check_characters(what, value, kept="\n\t")
    return value


def _check_characters(what: str, text: str, kept: str = "") -> None:
    if found := unfit(text, kept):
        raise InputError(
            f"{what} must have no control characters, got {shown(text)} with {found!a}"
        )


def check_real(name: str, value: object) -> float:
    """Return `value` as a finite float.

    Examples
    --------
    >>> check_real("omega", 2)
    2.0
    >>> check_real("omega", "2")
    Traceback (most recent call last):
    ...
    rotor_ida.errors.InputError: omega must be a finite real number, got '2'
    """
    if type(value) is float and math.isfinite(value):
        return value
    scalar = _scalar(name, value)
    if isinstance(scalar, Real) and not isinstance(scalar, _NO_NUMBERS):
        try:
            number = float(scalar)
        except (OverflowError, ValueError):
            number = math.inf
        if math.isfinite(number):
            return number
    raise InputError(
        "{name} must be a finite real number, got {given}", name=name, given=shown(value)
    )


def check_point(name: str, word: str) -> None:
    """Raise `InputError` for a number with a comma, which may be decimal or between thousands.

    Examples
    --------
    >>> check_point("clearance", "0,4mm")
    Traceback (most recent call last):
    ...
    rotor_ida.errors.InputError: clearance must have no comma, got '0,4mm': write '0.4mm' with a
    point
    """
    if not re.match(r"\s*[-+]?\d[\d.]*,\d", word):
        return
    # quoted: its number is the user's, and already has the user's unit
    plain = shown(word.replace(",", "").strip())
    whole, _, rest = word.strip().rpartition(",")
    decimal = shown(f"{whole.replace('.', '')}.{rest}")
    if "," in whole or "." in rest.split()[0]:  # commas between thousands
        remedy = f"write {plain}"
    elif re.match(r"[-+]?[1-9]\d{0,2},\d{3}(?!\d)", word.strip()):
        remedy = f"write {plain} if it separates thousands, else {decimal}"
    else:
        remedy = f"write {decimal} with a point"
    raise InputError(f"{name} must have no comma, got {shown(word)}: {remedy}")


def check_nonnegative(name: str, value: object, largest: float = math.inf) -> float:
    """Return `value` as a finite float from zero to `largest`."""
    number = check_real(name, value)
    if number < 0.0:
        raise InputError("{name} must be zero or positive, got {value}", name=name, value=number)
    _check_at_most(name, number, largest)
    return number + 0.0


def check_positive(name: str, value: object, largest: float = math.inf) -> float:
    """Return `value` as a finite float above zero and up to `largest`."""
    number = check_real(name, value)
    if number <= 0.0:
        raise InputError("{name} must be positive, got {value}", name=name, value=number)
    _check_at_most(name, number, largest)
    return number


def _check_at_most(name: str, number: float, most: float) -> None:
    if number > most:
        raise InputError(
            "{name} must be at most {most:g}, got {value}", name=name, most=most, value=number
        )


def check_between(name: str, value: object, least: float, most: float) -> float:
    """Return `value` as a positive float from `least` to `most`."""
    number = check_positive(name, value)
    if not least <= number <= most:
        raise InputError(
            "{name} must lie from {least} to {most}, got {value}",
            name=name, least=least, most=most, value=number,
        )  # fmt: skip
    return number


def check_count(name: str, value: object, minimum: int = 1, maximum: int = MOST_NUMBERS) -> int:
    """Return `value` as an int from `minimum` to `maximum`."""
    count = _scalar(name, value)
    if isinstance(count, _NO_NUMBERS) or not isinstance(count, Integral):
        raise InputError(f"{name} must be a whole number, got {shown(value)}")
    whole = int(count)
    if whole < minimum:
        raise InputError(f"{name} must be at least {minimum}, got {shown(whole)}")
    if whole > maximum:
        raise InputError(f"{name} must be at most {maximum}, got {shown(whole)}")
    return whole


def check_seed(value: object) -> int:
    """Return `value` as a seed of random numbers that an archive can store."""
    return check_count("seed", value, minimum=0, maximum=LARGEST_SEED)


def check_choice(name: str, value: object, allowed: Sequence[str]) -> str:
    """Return `value` if it is one of the words in `allowed`."""
    if not isinstance(value, str) or value not in allowed:
        raise InputError(
            "{name} must be one of {allowed}, got {given}{meant}", name=name,
            allowed=Names(tuple(allowed)), given=shown(value), meant=Meant(value, tuple(allowed)),
        )  # fmt: skip
    return value


@dataclass(frozen=True, slots=True)
class Names:
    """Names in a message: quoted, or with a `last` word between as in a sentence.

    Examples
    --------
    >>> str(Names(("omega", "rtol")).in_words({"omega": "speed"})), str(Names(("x", "y"), "and"))
    ("'speed', 'rtol'", 'x and y')
    """

    names: tuple[str, ...]
    last: str = ""

    def in_words(self, words: Mapping[str, str]) -> Names:
        """Return the same with these words for names."""
        return Names(tuple(words.get(each, each) for each in self.names), self.last)

    def __str__(self) -> str:
        return listed(self.names, self.last) if self.last else ", ".join(map(repr, self.names))


@dataclass(frozen=True, slots=True)
class Meant:
    """The end of a message that names the known word nearest to a misspelt one, if any is near."""

    word: object
    known: tuple[str, ...]

    def in_words(self, words: Mapping[str, str]) -> Meant:
        """Return the same with these words for names."""
        return Meant(self.word, tuple(words.get(each, each) for each in self.known))

    def __str__(self) -> str:
        return did_you_mean(self.word, self.known)


def did_you_mean(word: object, known: Iterable[str]) -> str:
    """Return the end of a message that names the known word nearest to a misspelt one.

    Examples
    --------
    >>> did_you_mean("adam", ["adams", "bdf"]), did_you_mean("rk4", ["adams", "bdf"])
    ("; did you mean 'adams'?", '')
    """
    if not isinstance(word, str) or len(word) > _LONGEST_SHOWN:
        return ""
    nearest = get_close_matches(word, list(known), n=1)
    return f"; did you mean {nearest[0]!r}?" if nearest else ""


def with_hints(kind: type[Kind]) -> type[Kind]:
    """Return a class whose constructor names the argument nearest to a misspelt one.

    Examples
    --------
    >>> @with_hints
    ... @dataclass
    ... class Shaft:
    ...     stiffness: float
    >>> Shaft(stiffnss=1.0)
    Traceback (most recent call last):
    TypeError: Shaft() got an unexpected keyword argument 'stiffnss'; did you mean 'stiffness'?
    """
    construct: Callable[..., None] = vars(kind)["__init__"]
    known = tuple(signature(kind).parameters)

    @wraps(construct)
    def hinting(self: Kind, *given: Any, **named: Any) -> None:
        for name in named.keys() - known:
            raise TypeError(
                f"{kind.__name__}() got an unexpected keyword argument {shown(name)}"
                f"{did_you_mean(name, known)}"
            )
        construct(self, *given, **named)

    type.__setattr__(kind, "__init__", hinting)
    return kind


def check_instance(name: str, value: object, kind: type[Kind]) -> Kind:
    """Return `value` if it is of a kind."""
    if not isinstance(value, kind):
        raise InputError(f"{name} must be a {kind.__name__}, got {shown(value)}")
    return value


def check_flag(name: str, value: object) -> bool:
    """Return `value` if it is True or False."""
    if not isinstance(value, bool):
        raise InputError(f"{name} must be true or false, got {shown(value)}")
    return value


def check_progress(
    progress: Callable[[int, int], None] | bool | None,
) -> Callable[[int, int], None] | None:
    """Return the function to call with the progress, or raise `InputError`.

    True is a bar on standard error, which `rotor_ida.parallel.shows_progress` puts in its place.
    """
    if progress is None or progress is False:
        return None
    if not callable(progress):
        raise InputError(f"progress must be a function, True or None, got {shown(progress)}")
    return progress


def check_duration(name: str, value: object, omega: float) -> float:
    """Return a positive time, short enough for doubles to resolve the phase at its end."""
    duration = check_positive(name, value)
    finest = COARSEST_TIME / max(omega, 1.0)
    if np.spacing(duration) > finest:
        bound = math.ldexp(1.0, math.floor(math.log2(finest)) + 53)
        raise InputError(
            "{name} must be below {bound:.6g} at {omega=:g}, so that doubles resolve a revolution, "
            "got {value}",
            name=name, bound=bound, omega=omega, value=duration,
        )  # fmt: skip
    return duration


def check_state(name: str, value: object) -> State:
    """Return `value` as the four finite floats ``(x, y, vx, vy)``."""
    given = _array(name, value)
    if given.shape != (4,):
        raise InputError(f"{name} must be four numbers (x, y, vx, vy), got {shown(value)}")
    x, y, vx, vy = (
        check_real(f"{name} {part}", number) for part, number in zip(COMPONENTS, given, strict=True)
    )
    return (x, y, vx, vy)


def check_states(name: str, values: object) -> list[State]:
    """Return `values`, a sequence of states or an array of shape (n, 4), as states."""
    given = _array(name, values)
    if given.ndim == 0:
        raise InputError(f"{name} must be a sequence of starts, got {shown(values)}")
    if given.size == 0:
        raise InputError(f"{name} must contain at least one start, got none")
    # the rows of a list appear in messages as they were given
    return [check_state("start", row) for row in (values if isinstance(values, list) else given)]


def check_array(name: str, values: object, *, largest: float = math.inf) -> Values:
    """Return `values`, of any shape, as an array of finite floats within `largest` of zero."""
    given = _array(name, values)
    if given.dtype.kind not in "iuf" or not np.isfinite(given).all():
        listed = [check_real(name, number) for number in given.ravel()]
        given = np.array(listed).reshape(given.shape)
    with np.errstate(over="ignore"):  # of longer floats
        numbers = given.astype(np.float64)
    for number in given[~np.isfinite(numbers)]:
        check_real(name, number)
    outside = numbers[np.abs(numbers) > largest]
    if outside.size:
        raise InputError(
            "{name} must lie within {most:g} of zero, got {value}",
            name=name, most=largest, value=float(outside[0]),
        )  # fmt: skip
    return numbers


def check_samples(name: str, values: npt.NDArray[Any]) -> Values:
    """Return samples, however many, as finite floats of moderate size.

    Examples
    --------
    >>> check_samples("x of signals", np.array([1.0, np.nan]))
    Traceback (most recent call last):
    ...
    rotor_ida.errors.InputError: x of signals must be finite, got nan in sample 2
    """
    if values.dtype.kind not in "iuf":
        return check_array(name, values, largest=LARGEST_SAMPLE)
    with np.errstate(over="ignore"):  # of longer floats
        numbers = values.astype(np.float64, copy=False)
    wrong = np.flatnonzero(~(np.abs(numbers) <= LARGEST_SAMPLE))
    if wrong.size:
        number = float(numbers.ravel()[wrong[0]])
        allowed = f"lie within {LARGEST_SAMPLE:g} of zero" if math.isfinite(number) else "be finite"
        raise InputError(f"{name} must {allowed}, got {number!r} in sample {wrong[0] + 1}")
    return numbers


def check_vector(name: str, values: object, *, largest: float = math.inf) -> Values:
    """Return `values`, a number or a vector, as a 1-D array of finite floats."""
    numbers = check_array(name, values, largest=largest)
    if numbers.ndim > 1:
        raise InputError(
            "{name} must be a number or a vector of numbers, got an array of shape {shape}",
            name=name, shape=shown(numbers.shape),
        )  # fmt: skip
    if numbers.size == 0:
        raise InputError("{name} must contain at least one number, got none", name=name)
    return np.atleast_1d(numbers)


def check_axis(
    name: str, values: object, *, smallest: float = 0.0, largest: float = math.inf
) -> Values:
    """Return `values`, a number or a vector, as a 1-D array of finite numbers >= 0.

    Numbers above `largest` are refused, and those below `smallest` that are not zero.
    """
    if type(values) is float and smallest <= values <= largest and 0.0 <= values < math.inf:
        return np.array([values + 0.0])  # what a rotor has, many times as fast
    axis = check_vector(name, values)
    if (axis < 0.0).any():
        below = float(axis[axis < 0.0][0])
        raise InputError("{name} must be zero or positive, got {value}", name=name, value=below)
    outside = axis[(axis > largest) | ((axis > 0.0) & (axis < smallest))]
    if outside.size:
        allowed = "0 or between {least:g} and" if smallest else "at most"
        raise InputError(
            f"{{name}} must be {allowed} {{most:g}}, got {{value}}",
            name=name, least=smallest, most=largest, value=float(outside[0]),
        )  # fmt: skip
    return axis + 0.0


def check_increasing(name: str, axis: Values, where: str = "") -> Values:
    """Return `axis` if its numbers increase; `where` names the case in which they must.

    Examples
    --------
    >>> check_increasing("omega", np.array([1.0, 2.0, 1.5]), "in a sweep up")
    Traceback (most recent call last):
    ...
    rotor_ida.errors.InputError: omega must increase in a sweep up, got 1.5 after 2.0
    """
    falls = np.flatnonzero(np.diff(axis) <= 0.0)
    if falls.size:
        before, after = axis[falls[0] : falls[0] + 2].tolist()
        raise InputError(
            "{name} must {words}, got {value} after {before}",
            name=name, words=f"increase {where}".rstrip(), value=after, before=before,
        )  # fmt: skip
    return axis


def check_distinct(name: str, axis: Values) -> Values:
    """Return `axis` if it has no number twice.

    Examples
    --------
    >>> check_distinct("omega", np.array([1.0, 2.0, 1.0]))
    Traceback (most recent call last):
    ...
    rotor_ida.errors.InputError: omega must have each value once, got 1.0 twice
    """
    if axis.size > 1 and np.unique(axis).size < axis.size:
        ordered = np.sort(axis)
        twice = float(ordered[1:][np.diff(ordered) == 0.0][0])
        raise InputError(
            "{name} must have each value once, got {value} twice", name=name, value=twice
        )
    return axis


def check_direction(
    direction: str | None, along: str | None, axes: Mapping[str, Values], first: str = "omega"
) -> str:
    """Return the name of the axis along which a sweep has a direction; '' without a direction.

    Parameters
    ----------
    direction, along : str, optional
        The direction, and the name of the axis; by default `first` if it varies, else the only one
        that does.
    axes : mapping of str to ndarray
        The values of each parameter that may vary.

    Examples
    --------
    >>> one, two = np.array([1.7]), np.array([0.1, 0.2])
    >>> check_direction("up", None, {"omega": one, "friction": two})
    'friction'
    >>> check_direction("up", None, {"omega": one, "friction": two, "delta0": two})
    Traceback (most recent call last):
    ...
    rotor_ida.errors.InputError: along must be given with a direction, as friction and delta0 vary
    >>> check_direction("up", None, {"omega": one})
    Traceback (most recent call last):
    ...
    rotor_ida.errors.InputError: omega must be two values or more in a sweep up or down, got 1.7
    """
    if direction is None:
        if along is not None:
            raise InputError(f"along must be left out without a direction, got {shown(along)}")
        return ""
    check_choice("direction", direction, ("up", "down", "both"))
    varying = [name for name, axis in axes.items() if axis.size > 1]
    if along is None and first not in varying and len(varying) > 1:
        raise InputError(
            "along must be given with a direction, as {names} vary",
            names=Names(tuple(varying), "and"),
        )
    if along is None:
        along = first if first in varying or not varying else varying[0]
    axis = axes[check_choice("along", along, list(axes))]
    if axis.size < 2:
        raise InputError(
            "{name} must be two values or more in a sweep up or down, got {value}",
            name=along, value=axis.item(),
        )  # fmt: skip
    check_increasing(along, axis, "in a sweep up or down")
    return along


def check_points(*axes: Sized, most: int = MOST_NUMBERS) -> None:
    """Raise `InputError` for a grid of too many points."""
    points = math.prod(len(axis) for axis in axes)
    if points > most:
        raise InputError(f"the grid must have at most {most} points, got {points}")


def is_scalar(name: str, value: object) -> bool:
    """Return whether a value is a scalar."""
    return _array(name, value).ndim == 0


def check_panels(panels: int) -> int:
    """Return the number of panels of a figure, or raise `InputError` if there are too many."""
    if panels > MOST_PANELS:
        raise InputError(
            f"figure can show at most {MOST_PANELS} combinations of zeta, delta0 and other "
            f"parameters, got {panels}"
        )
    return panels


def check_one_varies(varied: Sequence[str]) -> None:
    """Refuse a figure of one panel over several parameters."""
    if len(varied) > 1:
        raise InputError(f"figure needs one parameter that varies, got {listed(varied)}")


def _scalar(name: str, value: object) -> object:
    """Return the number in a zero-dimensional array, and any other value as it is."""
    if hasattr(value, "__array__") and not isinstance(value, np.generic):
        given = _array(name, value)
        return given[()] if given.ndim == 0 else value
    return value


def _array(name: str, values: object) -> npt.NDArray[Any]:
    """Return `values` as an array; lists and other values become an array of objects."""
    if type(values) in {float, int}:  # the usual case, many times as fast
        return np.array(values, dtype=object)
    try:
        length = len(values)  # type: ignore[arg-type]
    except TypeError:
        length = 1
    except OverflowError:
        length = MOST_NUMBERS + 1
    size = getattr(values, "size", length)
    length = max(length, int(size)) if isinstance(size, Integral) else length
    if length > MOST_NUMBERS and not isinstance(values, str):
        raise InputError(f"{name} must contain at most {MOST_NUMBERS} numbers, got {shown(values)}")
    within = values if isinstance(values, (list, tuple)) else ()
    if isinstance(values, _BYTES) or any(isinstance(each, _BYTES) for each in within):
        raise InputError(f"{name} must be numbers, got bytes, {shown(values)}")
    if np.ma.is_masked(values):
        raise InputError(f"{name} must have no masked values, got {shown(values)}")
    try:
        return np.asarray(values, dtype=None if hasattr(values, "__array__") else object)
    except (TypeError, ValueError):
        raise InputError(f"{name} must be numbers, got {shown(values)}") from None
