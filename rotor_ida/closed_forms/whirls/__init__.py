"""Exact synchronous whirls of rotor systems, their stability and special speeds, and dry whip."""
