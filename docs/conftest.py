"""Examples in the pages are tests; scripts of the site, and what its build writes, are not."""

collect_ignore_glob = [
    "*.py", "_*", "api", "command_line.md", "gallery", "results", "scenario_scripts",
    "tutorial_scripts", "tutorials",
]  # fmt: skip
