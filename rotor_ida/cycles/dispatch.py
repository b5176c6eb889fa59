"""Limit cycles and their branches, of one disc or of a rotor system: one name for both."""

from __future__ import annotations

from rotor_ida.cycles.continue_cycle import continue_cycle as continue_cycle_disc
from rotor_ida.cycles.limit_cycle import limit_cycle as limit_cycle_disc
from rotor_ida.cycles.system_branch import continue_cycle_system
from rotor_ida.cycles.system_cycle import limit_cycle_system
from rotor_ida.systems.joined import of_both

limit_cycle = of_both(limit_cycle_disc, limit_cycle_system, __name__)
continue_cycle = of_both(continue_cycle_disc, continue_cycle_system, __name__)
