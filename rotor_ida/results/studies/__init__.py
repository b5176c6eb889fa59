"""Studies: the finished pieces of a long computation in a folder, so that it can be resumed.

A study knows nothing of rotors. It has a *design*, which states what is computed, and *pieces*,
numbered from 0, each with the bytes that one job returned.
"""

from rotor_ida.results.studies.design import program_of
from rotor_ida.results.studies.store import Piece, Study, design_of, opened, status

__all__ = ["Piece", "Study", "design_of", "opened", "program_of", "status"]
