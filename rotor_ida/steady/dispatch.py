"""Responses over speeds, and exponents, of one disc or of a rotor system: one name for both."""

from __future__ import annotations

from rotor_ida.results.joined import of_both
from rotor_ida.steady.lyapunov import lyapunov_exponent as lyapunov_exponent_disc
from rotor_ida.steady.lyapunov import lyapunov_exponent_system
from rotor_ida.steady.run_ups import run_ups as run_ups_disc
from rotor_ida.steady.sweep import sweep as sweep_disc
from rotor_ida.steady.system_run_ups import run_ups_system
from rotor_ida.steady.system_sweep import sweep_system

run_ups = of_both(run_ups_disc, run_ups_system, __name__)
sweep = of_both(sweep_disc, sweep_system, __name__)
lyapunov_exponent = of_both(lyapunov_exponent_disc, lyapunov_exponent_system, __name__)
