"""Moved to rotor_ida.schema; this stays only until every import has followed."""

from rotor_ida.schema import *  # noqa: F403
from rotor_ida.schema import QUANTITIES, labelled, flags_of  # noqa: F401
