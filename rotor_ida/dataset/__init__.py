"""Labelled results: what every variable is called, what it means, and how results are built."""
