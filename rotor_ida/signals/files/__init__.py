"""Readers of measured files: each returns the columns of a file by name, with their units."""
