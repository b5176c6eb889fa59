"""Sweeps of speed, damping and clearance: the settled response at each point."""
