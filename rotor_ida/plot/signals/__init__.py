"""Practitioners' plots of simulated and measured signals.

Each function takes signals of `rotor_ida.signals_of` or `rotor_ida.read_signals`, a run or run-up,
or what `rotor_ida.orders`, `rotor_ida.full_spectrum`, `rotor_ida.spectrogram` or
`rotor_ida.centre_line` made of one. Speeds are in rpm and frequencies in Hz where times have a
unit, dimensionless otherwise. Exact results go `beneath` the picture.
"""
