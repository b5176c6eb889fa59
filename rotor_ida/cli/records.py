"""From labelled datasets to plain records: what JSON holds and the tables show."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
import xarray as xr

from rotor_ida.schema import NO_YES, flags_of

Record = dict[str, object]

METHOD = ("method", "flight", "backend", "rtol", "atol")
VERSION = "_version"
# What an archive adds for its own use.
HOUSEKEEPING = ("Conventions", "content_sha256", "rotor_ida_format")


def names_on(dataset: xr.Dataset, *dims: str) -> list[str]:
    """Return the variables that stand on just these dimensions."""
    return [str(name) for name, variable in dataset.data_vars.items() if variable.dims == dims]


def rows_of(dataset: xr.Dataset, names: Sequence[str]) -> list[Record]:
    """Return one record for each element of the first variable named, the others spread on it.

    Flags become their words, or true and false where the words are yes and no.

    Examples
    --------
    >>> from rotor_ida import synchronous_response
    >>> whirls = synchronous_response(omega=[0.5, 1.0], zeta=0.5, delta0=2.0)
    >>> rows_of(whirls, ["stability", "omega"])
    [{'stability': 'neutral', 'omega': 0.5}, {'stability': 'neutral', 'omega': 1.0}]
    """
    first = dataset[names[0]]
    columns = []
    for name in names:
        spread = dataset[name].broadcast_like(first).transpose(*first.dims)
        columns.append(_in_words(spread.values.ravel().tolist(), dataset[name]))
    return [dict(zip(names, row, strict=True)) for row in zip(*columns, strict=True)]


def value_of(dataset: xr.Dataset, name: str) -> object:
    """Return a scalar variable, in words if it is a flag."""
    return _in_words([dataset[name].values.item()], dataset[name])[0]


def attributes_of(dataset: xr.Dataset) -> Record:
    """Return where a dataset came from: method, versions, and what else its attributes say."""
    plain = {str(name): _plain(value) for name, value in dataset.attrs.items()}
    plain = {name: value for name, value in plain.items() if name not in HOUSEKEEPING}
    record: Record = {}
    method = {name: plain.pop(name) for name in METHOD if name in plain}
    versions = {
        name.removesuffix(VERSION): plain.pop(name)
        for name in list(plain)
        if name.endswith(VERSION)
    }
    if method:
        record["method"] = method
    if versions:
        record["versions"] = versions
    return {**plain, **record}


def _in_words(values: list[Any], variable: xr.DataArray) -> list[Any]:
    if "flag_meanings" not in variable.attrs:
        return values
    flags = flags_of(variable)
    words: dict[int, object] = {number: word for word, number in flags.items()}
    if flags == NO_YES:
        words = {0: False, 1: True}
    return [words[value] for value in values]


def _plain(value: object) -> object:
    return value.tolist() if isinstance(value, (np.ndarray, np.generic)) else value
