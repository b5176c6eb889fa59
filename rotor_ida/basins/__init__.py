"""Basins: which of very many starts of one rotor ends on which attractor.

*Follow each start until a set captures it that no orbit leaves; look at the motion of the others
over two windows; group these into attractors; let CVODE confirm each attractor.*
"""

from rotor_ida.basins.grid import basin
from rotor_ida.basins.sample import shares

__all__ = ["basin", "shares"]
