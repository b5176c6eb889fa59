"""Files of the page: markup, style, scripts, and uPlot with its separate licence."""

from __future__ import annotations

import re
from importlib.resources import files
from unicodedata import lookup

from rotor_ida.checks import COMPONENTS
from rotor_ida.explorer.messages import LARGEST_FILE, LEAST_SPEED, ROOM
from rotor_ida.model.data_sheet import ALTERNATIVES, GRAVITY
from rotor_ida.model.parameters import DEFAULTS, MACHINE_PARAMETERS, PARAMETERS, TABLE
from rotor_ida.schema import (
    DAMPED_EVENT_KIND,
    MODE,
    OF_FRICTION_EVENT_KIND,
    SPECIAL,
    STABILITY,
)
from rotor_ida.texts import in_page
from rotor_ida.units import SPEED_UNITS

TYPES = {
    "html": "text/html; charset=utf-8",
    "css": "text/css; charset=utf-8",
    "js": "text/javascript; charset=utf-8",
    "svg": "image/svg+xml",
}


# Placeholders of the data-sheet form, in the order of its fields.
EXAMPLE = {
    "mass": "12 kg", "shaft_stiffness": "4 MN/m, 5500 rpm", "damping": "416 N s/m, 3 %",
    "clearance": "150 um", "eccentricity": "16.7 um, 200 g mm, G6.3", "balance_speed": "3600 rpm",
    "speed": "3600 rpm", "contact_stiffness": "1e8 N/m, 1e10 N/m^1.5", "friction": "0.12",
    "disc_radius": "60 mm", "load": "weight",
}  # fmt: skip

# Place in the page for the tables shared with the package.
TABLES = '<script type="application/json" id="tables">{}</script>'


def page_files() -> dict[str, bytes]:
    """Return the files of the page by their request paths.

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
    page = found["index.html"].decode()
    found["index.html"] = page.replace(TABLES.format("{}"), TABLES.format(_tables())).encode()
    return found


def _tables() -> str:
    """Return the shared tables of the package as JSON: see ``tables.js``."""
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
    words = "unbalance, of the file's"
    meaning = "factor of all unbalance in the file"
    parameters["unbalance_factor"] = {
        "words": words, "symbol": "", "meaning": meaning, "si_meaning": meaning, "unit": ""
    }  # fmt: skip
    tables = {
        "largest_file": LARGEST_FILE,
        "parameters": parameters,
        "room": ROOM,
        "least_speed": LEAST_SPEED,
        "sheet": [{"names": names, "example": EXAMPLE[names[0]]} for names in _ways()],
        "speed_units": {name: 1.0 / value for name, value in SPEED_UNITS.items()},
        "gravity": GRAVITY,
        "dimensionless": PARAMETERS,
        "machine": MACHINE_PARAMETERS,
        "optional": DEFAULTS,
        "components": COMPONENTS,
        "events": DAMPED_EVENT_KIND | OF_FRICTION_EVENT_KIND,
        "modes": MODE,
        "stability": STABILITY,
        "special": SPECIAL,
    }
    return in_page(tables)


def _ways() -> list[tuple[str, ...]]:
    """Return the quantities of a data sheet in order, each with the other ways to give it."""
    ways = {names[0]: names for names in ALTERNATIVES}
    others = {name for names in ALTERNATIVES for name in names[1:]}
    return [ways.get(name, (name,)) for name in EXAMPLE if name not in others]


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
