"""Files of arrays by others, read with checks: sizes and indices before anything is allocated.

The readers of SciPy and MATLAB's own believe what a damaged file declares, and then end the
process or take all memory. These raise an exception instead.
"""
