"""The page itself: markup, style, scripts, and uPlot, which has a licence of its own beside it."""

from __future__ import annotations

import json
from importlib.resources import files

from rotor_ida.explorer.questions import LARGEST_FILE

TYPES = {
    "html": "text/html; charset=utf-8",
    "css": "text/css; charset=utf-8",
    "js": "text/javascript; charset=utf-8",
    "svg": "image/svg+xml",
}


# Where the page has what the program says once for both.
TABLES = '<script type="application/json" id="tables">{}</script>'


def page_files() -> dict[str, bytes]:
    """Return the files of the page, by the path under which it asks for them.

    Examples
    --------
    >>> sorted(name for name in page_files() if name.endswith(".css"))
    ['style.css', 'uplot/uPlot.min.css']
    """
    folder = files(__name__)
    found = {}
    for place in (folder, folder / "uplot"):
        prefix = "" if place is folder else "uplot/"
        for each in place.iterdir():
            if each.name.rpartition(".")[2] in TYPES:
                found[prefix + each.name] = each.read_bytes()
    index = found["index.html"].decode()
    found["index.html"] = index.replace(TABLES.format("{}"), TABLES.format(_tables())).encode()
    return found


def _tables() -> str:
    """Return as JSON what the page needs to know and the program states."""
    return json.dumps({"largest_file": LARGEST_FILE})
