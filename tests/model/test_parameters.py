"""The table of parameters is what the rotors, their docstrings and the pages say."""

from __future__ import annotations

import inspect
import re
from dataclasses import MISSING, fields
from pathlib import Path
from typing import get_type_hints

import numpy.typing as npt
import pytest

from rotor_ida import DimensionalRotor, InputError, Rotor
from rotor_ida.model.parameters import OF_MACHINE, OF_ROTOR, Parameter, Parameters
from rotor_ida.schema import QUANTITIES

DOCS = Path(__file__).resolve().parents[2] / "docs"
TABLES = {Rotor: OF_ROTOR, DimensionalRotor: OF_MACHINE}
ROWS = [(kind, parameter) for kind, table in TABLES.items() for parameter in table.values()]
EACH = pytest.mark.parametrize(
    ("kind", "parameter"), ROWS, ids=[f"{kind.__name__}-{each.name}" for kind, each in ROWS]
)


@pytest.mark.parametrize("kind", TABLES)
def test_a_rotor_takes_the_parameters_of_the_table(kind: type):
    given = {each.name: each.default for each in fields(kind)}
    table = {name: MISSING if each.needed else each.default for name, each in TABLES[kind].items()}
    assert given == table
    assert list(given) == list(table)


def test_keywords_of_studies_are_typed_by_the_table():
    keywords = get_type_hints(Parameters)
    assert list(keywords) == list(OF_ROTOR)
    for name, kind in keywords.items():
        may_be_left_out = not OF_ROTOR[name].needed and OF_ROTOR[name].default is None
        assert (kind == npt.ArrayLike | None) == may_be_left_out
        assert may_be_left_out or kind == npt.ArrayLike


@EACH
def test_docstrings_name_the_unit(kind: type, parameter: Parameter):
    text = " ".join(inspect.getdoc(kind).split())
    entry = re.search(rf"{parameter.name} : (.+?)(?= \w+ : |Raises)", text)
    assert entry is not None
    unit = (
        parameter.shown_unit
        if kind is DimensionalRotor and parameter.unit != "1"
        else ("dimensionless")
    )
    if parameter.name == "contact_stiffness":
        unit = "N/m^n"
    if parameter.name != "contact_exponent":
        assert f"[{unit}]" in entry[1]


@EACH
def test_a_negative_number_is_refused(kind: type, parameter: Parameter):
    right = {each.name: 1.0 for each in TABLES[kind].values()}
    allowed = "positive" if parameter.positive else "zero or positive"
    has_unit = kind is DimensionalRotor and parameter.unit != "1"
    unit = parameter.shown_unit.replace("m^1.5", "m")  # of a linear contact
    given = f"-1 {unit}" if has_unit else "-1.0"
    with pytest.raises(InputError, match=rf"^{parameter.name} must be {allowed}, got {given}$"):
        kind(**right | {parameter.name: -1.0})


@EACH
def test_the_page_on_notation_has_its_symbol(kind: type, parameter: Parameter):
    page = (DOCS / "notation.md").read_text(encoding="utf-8")
    begin, end = (
        ("## In SI", "Elsewhere") if kind is DimensionalRotor else ("## Without", "With all")
    )
    table = page[page.index(begin) : page.index(end)]
    symbol = parameter.si_symbol if kind is DimensionalRotor else parameter.symbol
    assert f"| `{parameter.name}` | ${symbol}$ |" in table


@pytest.mark.parametrize("name", OF_ROTOR)
def test_a_dataset_says_what_the_table_does(name: str):
    assert QUANTITIES[name].long_name == OF_ROTOR[name].meaning
    assert QUANTITIES[name].units == "1"
