"""Rotor-stator contact with exact event location, validated against closed-form solutions.

>>> from rotor_ida import Rotor, simulate, synchronous_response

The names are listed in ``__init__.pyi``. Each is imported on first use: the command line answers
``--help``, and an archive can be read and plotted, without loading a solver.
"""

import lazy_loader

_on_first_use, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)


def __getattr__(name: str) -> object:
    if name != "__version__":
        return _on_first_use(name)
    from importlib.metadata import version  # noqa: PLC0415 - not needed to import the package

    return version("rotor-ida")
