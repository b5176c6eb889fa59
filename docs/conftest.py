"""Examples in the pages are tests; scripts of the site, and what its build writes, are not."""

collect_ignore_glob = [
    *("*.py", "_*", "tutorial_scripts"),
    *("api", "categories.md", "command_line.md", "gallery", "results", "scenario_scripts"),
    "tutorials",
]
