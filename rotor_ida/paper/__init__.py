"""The paper: its formulas as printed, its errata, its figures made again."""
