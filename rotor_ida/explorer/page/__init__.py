"""The page itself: markup, style, scripts, and uPlot, which has a licence of its own beside it."""

from __future__ import annotations

from importlib.resources import files

TYPES = {
    "html": "text/html; charset=utf-8",
    "css": "text/css; charset=utf-8",
    "js": "text/javascript; charset=utf-8",
    "svg": "image/svg+xml",
}


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
    return found
