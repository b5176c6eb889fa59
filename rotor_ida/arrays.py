"""What nearly every module says of numbers: arrays of them, and how finely they are spaced."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

Values = npt.NDArray[np.float64]
# The spacing of doubles at 1.
ROUNDING = 2.0**-52
