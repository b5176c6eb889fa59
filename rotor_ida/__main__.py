"""The command line: ``python -m rotor_ida`` is ``rotor-ida``."""

import sys

from rotor_ida.cli import main

if __name__ == "__main__":
    sys.exit(main())
