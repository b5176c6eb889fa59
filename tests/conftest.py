"""Settings for all tests: no timed ones, and the same examples on every run."""

from hypothesis import settings

settings.register_profile("rotor_ida", deadline=None, derandomize=True)
settings.load_profile("rotor_ida")
