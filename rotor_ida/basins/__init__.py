"""Basins: which of very many starts of one rotor ends on which attractor.

*Follow each start until a trapping region holds it; follow one that none holds to its attractor,
which then is known, with a region of its own; try the others again; count.*
"""

from rotor_ida.basins.basin import basin, basin_fractions

__all__ = ["basin", "basin_fractions"]
