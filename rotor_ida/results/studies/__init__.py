"""Studies: the finished pieces of a long computation, in a folder, so that it can go on.

A study knows nothing of rotors. It has a *design*, which says what is computed, and *pieces*,
numbered from 0, each the bytes that one job has returned.
"""

from rotor_ida.results.studies.database import design_of, program_of
from rotor_ida.results.studies.store import Piece, Study, opened, status

__all__ = ["Piece", "Study", "design_of", "opened", "program_of", "status"]
