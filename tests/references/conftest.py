"""Keep pytest out of this folder: it needs python-flint, which the tests themselves do not."""

collect_ignore_glob = ["*.py"]
