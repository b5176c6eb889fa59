"""Basins: which of very many starts of one rotor ends on which attractor.

*Follow each start until a set captures it that no orbit leaves; look at the motion of the others
over two windows; group these into attractors; let CVODE confirm each attractor.*
"""

from rotor_ida.basins.basin import basin
from rotor_ida.basins.fractions import basin_fractions

__all__ = ["basin", "basin_fractions"]
