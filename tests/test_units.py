"""Units: what people write is read as what they mean, to the last bit, or not at all."""

from __future__ import annotations

import math
import re

import pytest
from hypothesis import given
from hypothesis import strategies as st

from rotor_ida.model.data_sheet import KEYS
from rotor_ida.model.parameters import TABLE
from rotor_ida.results import system_file
from rotor_ida.schema import quantities
from rotor_ida.units import (
    NAMES,
    READ_IN,
    SPEED_UNITS,
    UNITS,
    USUAL,
    dimension_of,
    quantity,
    read_in,
    symbol_of,
    unit_of,
)


@pytest.mark.parametrize(
    ("text", "in_si"),
    [
        ("kg", 1.0), ("g", 1e-3), ("um", 1e-6), ("\N{MICRO SIGN}m", 1e-6),
        ("\N{GREEK SMALL LETTER MU}m", 1e-6), ("mm", 1e-3), ("cm", 1e-2), ("in", 0.0254),
        ("mil", 2.54e-5), ("ms", 1e-3), ("min", 60.0), ("kN", 1e3), ("N/mm", 1e3), ("kN/mm", 1e6),
        ("N/mm^1.5", 10.0**4.5), ("g mm", 1e-6), ("kg m2", 1.0),
        ("kg\N{DOT OPERATOR}m\N{SUPERSCRIPT TWO}", 1.0),
        ("rpm", math.pi / 30.0), ("Hz", 2.0 * math.pi), ("rpm/s", math.pi / 30.0),
        ("rpm/min", math.pi / 1800.0), ("min-1", math.pi / 30.0), ("deg", math.pi / 180.0),
    ],
)  # fmt: skip
def test_a_unit_is_so_many_si_units(text: str, in_si: float):
    unit = unit_of(text)
    assert unit is not None
    assert unit.in_si("1") == pytest.approx(in_si, rel=4e-16)


@pytest.mark.parametrize("number", ["60", "0.1", "1.7", "3e-2", "123456789.123"])
def test_a_prefix_moves_the_point_and_rounds_once(number: str):
    unit = unit_of("um")
    assert unit is not None
    assert unit.in_si(number) == float(f"{float(number)!r}e-6" if "e" not in number else "3e-8")


@pytest.mark.parametrize(
    "texts",
    [
        ("N s/m", "Ns/m", "N s m-1", "N*s/m", "N.s/m", "N\N{MIDDLE DOT}s/m", "kg/s"),
        ("N/m^1.5", "N m-1.5", "N/m1.5"),
        ("N m", "Nm", "N-m", "kg m2 s-2"),
        ("g mm", "g-mm", "g\N{MIDDLE DOT}mm", "g.mm", "kg m", "kg-m", "kgm", "gcm"),
        ("rad/s2", "rad/s^2", "rad/s\N{SUPERSCRIPT TWO}", "rad/s/s", "rad s-2"),
        ("rpm", "RPM", "rev/min", "r/min"),
    ],
)
def test_a_unit_may_be_written_in_any_usual_way(texts: tuple[str, ...]):
    dimensions = {dimension_of(text) for text in texts}
    assert len(dimensions) == 1
    assert None not in dimensions


@pytest.mark.parametrize(
    "text",
    ["", " ", "/", "N/", "/s", "furlong", "Nmm", "mNm", "gm", "gm/s", "kg-", "-m", "N m 2", "5",
     "m^", "m^x", "m,s"],
)  # fmt: skip
def test_what_is_no_unit_or_has_two_readings_is_none(text: str):
    assert unit_of(text) is None


@pytest.mark.parametrize("times", [14, 24, 400])
def test_a_long_text_is_read_in_no_time(times: int):
    # every way to split these letters into units: 2**27 and more
    assert unit_of("ms" * times) is None


def test_a_number_of_any_length_is_read():
    unit = unit_of("um")
    assert unit is not None
    assert unit.in_si("1e" + "9" * 5000) == math.inf
    assert unit.in_si("1e" + "0" * 5000 + "3") == pytest.approx(1e-3)


@pytest.mark.parametrize("text", ["m" * 61, "in^9999", "m^21", "m-300", "m^" + "9" * 400])
def test_what_is_too_long_or_too_large_is_none(text: str):
    assert unit_of(text) is None


def test_a_speed_is_no_rate_and_no_frequency_of_an_angle_free_kind():
    assert len({dimension_of(text) for text in ("rad/s", "rad/s2", "1/s", "rad")}) == 4


def test_every_name_and_every_unit_offered_is_known():
    assert all(symbol_of(name) in UNITS for name in (*UNITS, *NAMES))
    assert None not in {dimension_of(text) for text in USUAL}


def test_the_units_of_parameters_are_read_and_offered():
    offered = {dimension_of(text) for text in USUAL}
    for each in TABLE:
        assert each.unit == "1" or dimension_of(each.unit) in offered, each.name


def test_speeds_are_those_of_the_table():
    for name, factor in SPEED_UNITS.items():
        unit = unit_of(name)
        assert unit is not None
        assert unit.in_si("1") == factor


@given(
    st.sampled_from(["m", "s", "m/s", "N", "N s", "rad/s", "rad/s2", "kg m"]),
    st.floats(1e-9, 1e9), st.booleans(),
)  # fmt: skip
def test_what_is_written_for_people_is_read_back(unit: str, size: float, below: bool):
    """By the table that reads options: to the digits, or for rpm to whole ones from 1000 on."""
    value = -size if below else size
    said, _, word = quantity(value, unit, 12).partition(" ")
    read = unit_of(word)
    assert read is not None
    assert read.dimension == dimension_of(unit)
    assert read.in_si(said.replace(",", "")) == pytest.approx(
        value, rel=6e-4 if "," in said else 1e-10
    )


def test_units_of_the_field_have_the_values_of_the_table_of_units():
    """A pound-force is 0.45359237 kg times 9.80665 m/s2, an ounce a sixteenth of a pound."""
    pound, inch = 0.45359237, 0.0254
    force = pound * 9.80665
    by_hand = {
        "lbf": force, "lbf s": force, "in/s": inch, "lbf/in": force / inch, "lb": pound,
        "oz in": pound / 16.0 * inch, "lbf s/in": force / inch, "lbf in": force * inch,
        "lbf in s": force * inch, "lb in2": pound * inch**2, "in/s2": inch, "s/in": 1.0 / inch,
        "lbf/in^1.5": force / inch**1.5,
    }  # fmt: skip
    joules = {f"{prefix}J": 10.0**power for prefix, power in
              {"": 0, "n": -9, "u": -6, "m": -3, "k": 3, "M": 6}.items()}  # fmt: skip
    for units in READ_IN.values():
        for word, parts in (each for known in units.values() for each in known):
            read = unit_of(word)
            exact = {**by_hand, **joules}.get(word) or (read.in_si("1") if read else math.nan)
            assert parts == pytest.approx(exact, rel=1e-14), word


def test_every_quantity_of_a_machine_and_of_a_system_has_its_unit_in_inches():
    """None keeps a metre, a newton or a kilogram, and each is read as an input too."""
    of_files = [*(getattr(system_file, f"OF_{each}") for each in ("RUN_UP", "DROP", "DROPS")),
                system_file.COEFFICIENTS, *system_file.UNITS_OF.values()]  # fmt: skip
    tables = [KEYS, quantities.UNITS, quantities.OTHER_UNITS, *of_files]
    of_data = {unit for table in tables for unit in table.values()}
    for unit in of_data | {"N m-1.5", "m s-2", "N m"}:
        word, parts = read_in(unit, system="inch")
        assert not re.search(r"\b[un]?m\b|N|J|g", word.replace("deg", "")), word
        if word:
            read = unit_of(word)
            assert read is not None, word
            assert read.in_si("1") == pytest.approx(parts, rel=1e-14), word
            joule = "N m" if unit == "J" else unit
            # a rate 1/s of an angle has no angle in UDUNITS
            assert read.dimension[:3] == (dimension_of(joule) or ())[:3], word
