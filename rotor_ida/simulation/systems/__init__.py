"""Rotor systems: any linear rotor with contacts at its nodes, simulated event by event."""
