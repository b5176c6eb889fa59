"""The paper: its formulas as printed, its errata, and its figures reproduced."""
