"""The compiled core: what is hot, in C17, called through ctypes.

``core.h`` says what it offers. ``hatch_build.py``, beside ``pyproject.toml``, compiles all sources
of this folder into one library for each level of the processor; `library` loads the one that fits.
"""
