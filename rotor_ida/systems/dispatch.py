"""What is computed of a rotor of one disc, or of a rotor system: one name for both."""

from __future__ import annotations

from collections.abc import Callable
from functools import wraps
from typing import Any, ParamSpec, Protocol, cast, overload

import xarray as xr

from rotor_ida.closed_forms.synchronous import synchronous_response as synchronous_response_disc
from rotor_ida.model.rotor import Rotor
from rotor_ida.model.rotor_system import RotorSystem
from rotor_ida.simulation.run_up import run_up as run_up_disc
from rotor_ida.simulation.simulate import simulate as simulate_disc
from rotor_ida.systems.simulate import run_up_system, simulate_system
from rotor_ida.systems.whirls.synchronous import synchronous_response_system

OfDisc = ParamSpec("OfDisc")
OfSystem = ParamSpec("OfSystem")


class OfBoth(Protocol[OfDisc, OfSystem]):
    """A function that takes the arguments of either of two."""

    @overload
    def __call__(self, *given: OfDisc.args, **options: OfDisc.kwargs) -> xr.Dataset: ...
    @overload
    def __call__(self, *given: OfSystem.args, **options: OfSystem.kwargs) -> xr.Dataset: ...


def of_both(
    disc: Callable[OfDisc, xr.Dataset],
    system: Callable[OfSystem, xr.Dataset],
    module: str = __name__,
) -> OfBoth[OfDisc, OfSystem]:
    """Return the function of one disc, which hands a rotor system to the other."""

    @wraps(disc)
    def either(rotor: Rotor | RotorSystem, **options: Any) -> xr.Dataset:
        chosen: Any = system if isinstance(rotor, RotorSystem) else disc
        return cast("xr.Dataset", chosen(rotor, **options))

    either.__module__ = module  # where it can be found, by pickle too
    return cast("OfBoth[OfDisc, OfSystem]", either)


def of_both_by_keyword(
    disc: Callable[OfDisc, xr.Dataset],
    system: Callable[OfSystem, xr.Dataset],
    module: str = __name__,
) -> OfBoth[OfDisc, OfSystem]:
    """Return the function of one disc's parameters, which hands a rotor system to the other."""

    @wraps(disc)
    def either(*rotor: RotorSystem | Rotor, **options: Any) -> xr.Dataset:
        first = options.get("system", *rotor)
        chosen: Any = system if isinstance(first, RotorSystem) else disc
        return cast("xr.Dataset", chosen(*rotor, **options))

    either.__module__ = module  # where it can be found, by pickle too
    return cast("OfBoth[OfDisc, OfSystem]", either)


simulate = of_both(simulate_disc, simulate_system)
run_up = of_both(run_up_disc, run_up_system)
synchronous_response = of_both_by_keyword(synchronous_response_disc, synchronous_response_system)
