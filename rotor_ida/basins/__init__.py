"""Basins: which of very many starts of one rotor ends on which attractor.

*Follow each start until a trapping region holds it; describe the motion of the others by features
over two windows of time; cluster these into attractors; let CVODE confirm each attractor.*
"""

from rotor_ida.basins.basin import basin
from rotor_ida.basins.fractions import basin_fractions

__all__ = ["basin", "basin_fractions"]
