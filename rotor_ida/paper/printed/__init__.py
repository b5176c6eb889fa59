"""The paper's formulas as printed, where they are wrong: to be shown beside the right ones.

Nothing else in this package computes with them. Each says where it is wrong and what is right.
"""

from rotor_ida.paper.printed.energy import hamiltonian, reference_frequency
from rotor_ida.paper.printed.periods import natural_frequency, period
from rotor_ida.paper.printed.transient import general_solution
from rotor_ida.paper.printed.whirls import (
    amplitudes_18,
    amplitudes_29,
    phase_23,
    phase_31,
    transfer_21,
)

__all__ = [
    "amplitudes_18",
    "amplitudes_29",
    "general_solution",
    "hamiltonian",
    "natural_frequency",
    "period",
    "phase_23",
    "phase_31",
    "reference_frequency",
    "transfer_21",
]
