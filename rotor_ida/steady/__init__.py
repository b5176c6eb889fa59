"""The steady state that a start leads to: when a motion has settled, and on what response."""
