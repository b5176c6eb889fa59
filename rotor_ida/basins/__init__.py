"""Basins of attraction: classify many starts of one rotor by the attractor they reach.

*Follow each start until it enters a trapping region; follow one that enters none to its attractor,
which is then known and has a region; try the others again; count.* Starts of a node of a rotor
system are followed one by one, and their attractors matched.
"""

from rotor_ida.basins.basin import basin, basin_fractions

__all__ = ["basin", "basin_fractions"]
