"""The atlas: attractors of a rotor and their basin fractions over speed, damping and clearance.

*Label the starts of every rotor of a grid; follow each attractor from one to the next; count.*
"""

from rotor_ida.basins.atlas.continue_attractors import continue_attractors
from rotor_ida.basins.atlas.touchdown import touchdown_report

__all__ = ["continue_attractors", "touchdown_report"]
