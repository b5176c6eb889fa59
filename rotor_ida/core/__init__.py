"""The compiled core: the performance-critical code in C17, called through ctypes.

``core.h`` lists its functions. ``hatch_build.py``, beside ``pyproject.toml``, compiles all sources
of this folder into one library for each level of the processor; `library` loads the one that fits.
"""
