"""A cascade of period doublings into chaos, at delta0 = 2.

At zeta = 0.07 the stable cycle on which the rotor bounces at omega = 2 doubles its period near
omega = 1.803 when the speed falls; the doubled cycle doubles again, and so on, ever faster: the
distances shrink in the end by Feigenbaum's factor 4.669. Each doubling is located on its exact
branch, and the next branch entered there. A simulated rotor that is led down slowly shows the
same: the largest radii split, and where the cascade ends their number is without bound and the
largest Lyapunov exponent is positive.

Writes the branches (branch_1.nc and so on), the table of doublings (cascade.nc), the sweep
(down.nc), its largest radii and exponents (radii.nc), and the figure as PNG and SVG.
"""

import sys

import numpy as np
import xarray as xr
from rich.box import SIMPLE_HEAD
from rich.console import Console
from rich.table import Table

from rotor_ida import (
    Rotor,
    continue_cycle,
    limit_cycle,
    lyapunov_exponent,
    poincare_section,
    sweep,
)
from rotor_ida.paper.scenario import Settings, progress_bar, run_script
from rotor_ida.plot import mixed_panels
from rotor_ida.plot.appearance import BLUE, GREY, INK, ORANGE, own_legend, style
from rotor_ida.schema import SPECIAL, labelled, labelled_dataset

ROTOR = Rotor(omega=2.0, zeta=0.07, delta0=2.0)
NAMES = ("x", "y", "vx", "vy")
# Speeds of the simulated rotor: down to where it falls off the ring.
HIGHEST, LOWEST = 1.82, 1.685
DOUBLINGS = 5
PEAKS = 120  # largest radii shown at each speed
