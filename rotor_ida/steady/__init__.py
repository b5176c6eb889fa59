"""The steady state reached from a start: when a motion has settled, and on which response."""
