"""Limit cycles on the rotating axes: exact periodic motions, their multipliers and branches."""
