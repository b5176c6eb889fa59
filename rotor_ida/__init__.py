"""Rotors in clearances: Hertz contact simulated event by event, held against closed forms.

>>> from rotor_ida import Rotor, simulate, synchronous_response
"""

from __future__ import annotations

import importlib
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from rotor_ida.analysis.axes import rotating
    from rotor_ida.analysis.bifurcations import bifurcation
    from rotor_ida.analysis.forces import contact_forces
    from rotor_ida.analysis.lyapunov import lyapunov_exponent
    from rotor_ida.analysis.sections import poincare_section
    from rotor_ida.analysis.spectra import spectrum
    from rotor_ida.archive import load, open_archive, save
    from rotor_ida.basins import basin, shares
    from rotor_ida.closed_forms import folds, synchronous_response
    from rotor_ida.comparison import compare
    from rotor_ida.dataset.contacts import contact_summary
    from rotor_ida.dataset.dimensional import dimensional
    from rotor_ida.errors import (
        ArchiveError,
        InputError,
        InvariantError,
        RotorError,
        SimulationError,
    )
    from rotor_ida.parameters import DimensionalRotor, Rotor
    from rotor_ida.resuming import resume
    from rotor_ida.simulation import simulate
    from rotor_ida.studies import status
    from rotor_ida.sweeps import sweep

# Each name is imported when it is first asked for: the command line answers --help, and an
# archive can be read and drawn, without loading a solver.
_HOMES = {
    "ArchiveError": "errors",
    "DimensionalRotor": "parameters",
    "InputError": "errors",
    "InvariantError": "errors",
    "Rotor": "parameters",
    "RotorError": "errors",
    "SimulationError": "errors",
    "basin": "basins",
    "bifurcation": "analysis.bifurcations",
    "compare": "comparison",
    "contact_forces": "analysis.forces",
    "contact_summary": "dataset.contacts",
    "dimensional": "dataset.dimensional",
    "folds": "closed_forms",
    "load": "archive",
    "lyapunov_exponent": "analysis.lyapunov",
    "open_archive": "archive",
    "poincare_section": "analysis.sections",
    "resume": "resuming",
    "rotating": "analysis.axes",
    "save": "archive",
    "shares": "basins",
    "simulate": "simulation",
    "spectrum": "analysis.spectra",
    "status": "studies",
    "sweep": "sweeps",
    "synchronous_response": "closed_forms",
}

__all__ = [
    "ArchiveError",
    "DimensionalRotor",
    "InputError",
    "InvariantError",
    "Rotor",
    "RotorError",
    "SimulationError",
    "basin",
    "bifurcation",
    "compare",
    "contact_forces",
    "contact_summary",
    "dimensional",
    "folds",
    "load",
    "lyapunov_exponent",
    "open_archive",
    "poincare_section",
    "resume",
    "rotating",
    "save",
    "shares",
    "simulate",
    "spectrum",
    "status",
    "sweep",
    "synchronous_response",
]


def __getattr__(name: str) -> object:
    if name not in _HOMES:
        raise AttributeError(f"module 'rotor_ida' has no attribute {name!r}")
    return getattr(importlib.import_module(f"rotor_ida.{_HOMES[name]}"), name)


def __dir__() -> list[str]:
    return sorted(__all__)
