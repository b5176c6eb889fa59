"""The commands, one a module: each reads its words, asks the library and answers a report."""
