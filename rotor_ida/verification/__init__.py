"""Compare results with exact ones, compute them again, and resume studies."""
