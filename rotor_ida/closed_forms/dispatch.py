"""Synchronous whirls of one disc or of a rotor system: one name for both."""

from __future__ import annotations

from rotor_ida.closed_forms.synchronous import synchronous_response as synchronous_response_disc
from rotor_ida.closed_forms.whirls.synchronous import synchronous_response_system
from rotor_ida.results.joined import of_both

synchronous_response = of_both(synchronous_response_disc, synchronous_response_system, __name__)
