"""Signals of two probes and a keyphasor, simulated or measured: orders, spectra, whirl, runout.

All of it works from datasets alone: `rotor_ida.signals_of` makes them of runs, and
`rotor_ida.read_signals` of measured files.
"""
