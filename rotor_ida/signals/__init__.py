"""Signals of two probes and a keyphasor, simulated or measured: orders, spectra, whirl, runout.

All functions take datasets: `rotor_ida.signals_of` makes them from runs, and
`rotor_ida.read_signals` from measured files.
"""
