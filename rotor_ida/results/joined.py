"""One public function of two: that of one disc, and that of rotor systems."""

from __future__ import annotations

import inspect
import re
from collections.abc import Callable
from functools import wraps
from typing import Any, NamedTuple, ParamSpec, Protocol, cast, overload

import xarray as xr

from rotor_ida.checks import listed
from rotor_ida.model.rotor import DimensionalRotor, Rotor
from rotor_ida.model.rotor_system import RotorSystem, name_of, refuse_first
from rotor_ida.results.in_si import KINDS, takes_system

OfDisc = ParamSpec("OfDisc")
OfSystem = ParamSpec("OfSystem")
# What stands before the part of a docstring that is about rotor systems.
SAYS_SYSTEM = "Of a `RotorSystem`: "
SECTION = re.compile(r"^(\w[\w ]*)\n-{3,}\n", re.MULTILINE)
ENTRY = re.compile(r"^(?=\S)", re.MULTILINE)
SECTIONS = ("Parameters", "Returns", "Raises", "Warns", "Notes", "References", "Examples")


class OfBoth(Protocol[OfDisc, OfSystem]):
    """A function that takes the arguments of either of two."""

    @overload
    def __call__(self, *given: OfDisc.args, **options: OfDisc.kwargs) -> xr.Dataset: ...
    @overload
    def __call__(self, *given: OfSystem.args, **options: OfSystem.kwargs) -> xr.Dataset: ...


class Differing(NamedTuple):
    """The defaults of an argument for one disc and for a rotor system, as a signature shows them.

    Examples
    --------
    >>> Differing("adams", "taylor")
    'adams' (of a RotorSystem 'taylor')
    """

    disc: object
    system: object

    def __repr__(self) -> str:
        return f"{self.disc!r} (of a RotorSystem {self.system!r})"


def of_both(
    disc: Callable[OfDisc, xr.Dataset], system: Callable[OfSystem, xr.Dataset], module: str
) -> OfBoth[OfDisc, OfSystem]:
    """Return the function that hands one disc to the first, and a rotor system to the second."""
    first = next(iter(inspect.signature(disc).parameters.values()))
    needed = [name for name, each in inspect.signature(system).parameters.items()
              if each.kind is each.KEYWORD_ONLY and each.default is each.empty]  # fmt: skip
    is_optional = first.default is None  # its parameters may be given by name

    @wraps(disc)
    def either(*given: object, **options: Any) -> xr.Dataset:
        named = next((name for name in ("rotor", "system") if name in options), None)
        if not given and named is not None:
            given = (options.pop(named),)
        if not given:  # parameters by name, or Python's own error
            return disc(**options)  # type: ignore[call-arg]
        rotor = given[0]
        if isinstance(rotor, RotorSystem):
            if missing := [name for name in needed if name not in options]:
                raise TypeError(f"{name_of(system)}() of a RotorSystem needs {listed(missing)}")
            whole: Callable[..., xr.Dataset] = takes_system(system)
            return whole(*given, **options)
        is_disc = isinstance(rotor, Rotor | DimensionalRotor)
        if not is_disc and not (rotor is None and is_optional):
            refuse_first(either, KINDS, rotor)
        return cast("Callable[..., xr.Dataset]", disc)(*given, **options)

    either.__module__ = module  # where it can be found, by pickle too
    either.__doc__ = joined_docstring(disc, system)
    either.__signature__ = joined_signature(disc, system)  # type: ignore[attr-defined]
    return cast("OfBoth[OfDisc, OfSystem]", either)


def joined_signature(disc: Callable[..., Any], system: Callable[..., Any]) -> inspect.Signature:
    """Return the rotor and the keywords of two functions; those of one alone may be left out."""
    own, other = (inspect.signature(each).parameters for each in (disc, system))
    first = next(iter(own.values()))
    rotor = inspect.Parameter(
        "rotor", inspect.Parameter.POSITIONAL_OR_KEYWORD,
        default=first.default, annotation="Rotor | DimensionalRotor | RotorSystem",
    )  # fmt: skip
    found: dict[str, inspect.Parameter] = {}
    for name, each in (other | own).items():
        if each.kind is not each.KEYWORD_ONLY:
            continue
        is_needed = all(name in of and of[name].default is each.empty for of in (own, other))
        default = None if each.default is each.empty and not is_needed else each.default
        if name in own and name in other and other[name].default not in (default, None):
            default = Differing(default, other[name].default)
        found[name] = each.replace(default=default)
    names = [*(name for name in own if name in found), *(name for name in found if name not in own)]
    others = [each for each in (*own.values(), *other.values()) if each.kind is each.VAR_KEYWORD]
    return inspect.Signature([rotor, *(found[name] for name in names), *others[:1]],
                             return_annotation="xr.Dataset")  # fmt: skip


def joined_docstring(disc: Callable[..., Any], system: Callable[..., Any]) -> str:
    """Return the docstrings of two functions as one, section by section."""
    (head, own), (_, other) = (_sections(each) for each in (disc, system))
    other = {title: text.replace(f"{system.__name__}(", f"{name_of(system)}(")
             for title, text in other.items()}  # fmt: skip
    parts = [head]
    for title in SECTIONS:
        texts = [each[title] for each in (own, other) if title in each]
        if not texts:
            continue
        if title == "Parameters":
            text = _parameters(*texts)
        elif title in ("Raises", "Warns"):
            text = "".join(dict.fromkeys(each for text in texts for each in _entries(text)))
        elif title in ("Returns", "Notes") and len(texts) == 2:
            indent = "    " if title == "Returns" else ""
            told = texts[1].split("\n", 1)[1].strip() if title == "Returns" else texts[1]
            text = f"{texts[0]}\n\n{indent}{SAYS_SYSTEM}{told}"
        else:
            text = "\n\n".join(texts)
        parts.append(f"{title}\n{'-' * len(title)}\n{text.strip()}")
    return "\n\n".join(parts)


def _sections(function: Callable[..., Any]) -> tuple[str, dict[str, str]]:
    """Return the head of a docstring, and its sections by title."""
    head, *rest = SECTION.split(inspect.getdoc(function) or "")
    texts = (each.rstrip() for each in rest[1::2])
    return head.strip(), dict(zip(rest[::2], texts, strict=True))


def _entries(text: str) -> list[str]:
    """Return the entries of a section, each with its indented description."""
    return [f"{each.rstrip()}\n" for each in ENTRY.split(text) if each]


def _parameters(of_disc: str, of_system: str) -> str:
    """Return the parameters of two functions, after the one rotor."""
    own = [each for each in _entries(of_disc) if not each.startswith("rotor ")]
    rotor = next((each for each in _entries(of_disc) if each.startswith("rotor ")), "")
    told = rotor.split("\n", 1)[1] if rotor else "    The rotor.\n"
    behind = [each.replace("\n    ", f"\n    {SAYS_SYSTEM}", 1) for each in _entries(of_system)[1:]]
    return "".join([f"rotor : Rotor, DimensionalRotor or RotorSystem\n{told}", *own, *behind])
