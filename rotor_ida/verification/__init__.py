"""Compare results with what is exact, compute them again, and resume a study."""
