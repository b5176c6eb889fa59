"""The page itself: markup, style, scripts, and uPlot, which has a licence of its own beside it."""

from __future__ import annotations

import json
import re
from importlib.resources import files
from unicodedata import lookup

from rotor_ida.checks import COMPONENTS
from rotor_ida.explorer.messages import LARGEST_FILE
from rotor_ida.model.parameters import DEFAULTS, MACHINE_PARAMETERS, PARAMETERS, TABLE
from rotor_ida.schema import (
    DAMPED_EVENT_KIND,
    MODE,
    OF_FRICTION_EVENT_KIND,
    SPECIAL,
    STABILITY,
)

TYPES = {
    "html": "text/html; charset=utf-8",
    "css": "text/css; charset=utf-8",
    "js": "text/javascript; charset=utf-8",
    "svg": "image/svg+xml",
}


# Where the page has what the package states once for both.
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
    """Return as JSON what the page needs to know and the package states: see ``tables.js``."""
    parameters = {
        each.name: {
            "words": each.label if each.name in PARAMETERS else each.name.replace("_", " "),
            "symbol": _plain(each.symbol),
            "meaning": each.meaning,
            "si_meaning": each.si_meaning,
            "unit": "" if each.unit == "1" else each.shown_unit.replace("^1.5", "¹·⁵"),
        }
        for each in TABLE
    }
    tables = {
        "largest_file": LARGEST_FILE,
        "parameters": parameters,
        "dimensionless": PARAMETERS,
        "machine": MACHINE_PARAMETERS,
        "optional": DEFAULTS,
        "components": COMPONENTS,
        "events": DAMPED_EVENT_KIND | OF_FRICTION_EVENT_KIND,
        "modes": MODE,
        "stability": STABILITY,
        "special": SPECIAL,
    }
    return json.dumps(tables, ensure_ascii=False)


def _plain(symbol: str) -> str:
    r"""Return a symbol without TeX.

    Examples
    --------
    >>> _plain(r"\omega"), _plain(r"\delta_0"), _plain("n")
    ('ω', 'δ₀', 'n')
    """
    letter = re.sub(
        r"\\([a-z]+)", lambda name: lookup(f"GREEK SMALL LETTER {name[1].upper()}"), symbol
    )
    return letter.replace("_0", "₀")
