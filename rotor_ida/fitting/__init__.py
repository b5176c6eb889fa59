"""Fit parameters of a machine to measured signals."""
