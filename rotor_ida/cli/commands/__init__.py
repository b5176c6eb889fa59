"""The commands; each answers with a report."""
