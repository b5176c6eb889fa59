"""The commands; each returns a report."""
