"""Runs of one disc or of a rotor system: one name for both."""

from __future__ import annotations

from rotor_ida.results.joined import of_both
from rotor_ida.simulation.run_up import run_up as run_up_disc
from rotor_ida.simulation.simulate import simulate as simulate_disc
from rotor_ida.simulation.systems.simulate import run_up_system, simulate_system

simulate = of_both(simulate_disc, simulate_system, __name__)
run_up = of_both(run_up_disc, run_up_system, __name__)
