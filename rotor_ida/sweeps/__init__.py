"""Sweeps of speed, damping and clearance: on which response the rotor settles, and its period."""
