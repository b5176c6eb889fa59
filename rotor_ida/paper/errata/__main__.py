"""Write the page of errata to a file."""

import sys
from pathlib import Path

from rotor_ida.paper.errata.page import errata_page

if __name__ == "__main__":
    if len(sys.argv) != 2:
        sys.exit("usage: python -m rotor_ida.paper.errata FILE")
    Path(sys.argv[1]).write_text(errata_page(), encoding="utf-8")
