"""Any dataset that `save` accepts comes back from `load` as it was, to the last bit."""

from __future__ import annotations

import tempfile
from pathlib import Path

import hypothesis.extra.numpy as arrays
import numpy as np
import xarray as xr
from hypothesis import given, settings
from hypothesis import strategies as st

from rotor_ida.results.archive import load, save
from rotor_ida.results.archive.checksum import content_sha256

ADDED = (
    *("Conventions", "rotor_ida_format", "rotor_ida_version"),
    *("date_created", "history", "content_sha256"),
)
NAMES = st.from_regex(r"[A-Za-z][A-Za-z0-9_]{0,8}", fullmatch=True)
TEXTS = st.text(st.characters(exclude_characters="\0", codec="utf-8"), max_size=8)
DTYPES = st.sampled_from(["f8", "f4", "i8", "i4", "i1", "u8", "U"])
SIZES = {"t": 3, "start": 2, "event": 0, "single": 1}


def values(dtype: str, shape: tuple[int, ...]) -> st.SearchStrategy[np.ndarray]:
    elements = TEXTS if dtype == "U" else None
    return arrays.arrays(object if dtype == "U" else dtype, shape, elements=elements).map(
        lambda array: array.astype(str) if dtype == "U" else array
    )


def attribute_names(name: str) -> bool:
    return name not in {"NAME", "CLASS", "coordinates", "dtype", *ADDED}


@st.composite
def attributes(draw: st.DrawFn) -> dict[str, object]:
    numbers = st.sampled_from(["f8", "i1", "i8"]).flatmap(
        lambda dtype: arrays.arrays(dtype, st.sampled_from([0, 2, 5]))
    )
    kinds = st.one_of(TEXTS, st.integers(-(2**63), 2**63 - 1), st.floats(), numbers)
    return draw(st.dictionaries(NAMES.filter(attribute_names), kinds, max_size=4))


@st.composite
def datasets(draw: st.DrawFn) -> xr.Dataset:
    variables = {}
    names = NAMES.filter(lambda name: name not in SIZES)
    for name in draw(st.lists(names, max_size=5, unique_by=str.lower)):
        dims = tuple(draw(st.lists(st.sampled_from(sorted(SIZES)), max_size=3, unique=True)))
        shape = tuple(SIZES[dim] for dim in dims)
        held = draw(DTYPES.flatmap(lambda dtype, shape=shape: values(dtype, shape)))
        variables[name] = xr.Variable(dims, held, draw(attributes()))
    for dim in draw(st.lists(st.sampled_from(sorted(SIZES)), unique=True)):
        dtype = draw(st.sampled_from(["f8", "i8", "i1", "U"]))
        variables[dim] = xr.Variable(dim, draw(values(dtype, (SIZES[dim],))), draw(attributes()))
    coordinates = [name for name in variables if name in SIZES or draw(st.booleans())]
    return xr.Dataset(variables, attrs=draw(attributes())).set_coords(coordinates)


@settings(max_examples=40, deadline=None)
@given(datasets())
def test_round_trip_is_identical(dataset: xr.Dataset) -> None:
    before = dataset.copy(deep=True)
    with tempfile.TemporaryDirectory() as folder:
        loaded = load(save(dataset, Path(folder) / "run.nc"))
    xr.testing.assert_identical(dataset, before)
    expected = dataset.assign_attrs({name: loaded.attrs[name] for name in ADDED})
    xr.testing.assert_identical(loaded, expected)
    assert set(loaded.coords) == set(dataset.coords)
    assert loaded.attrs["content_sha256"] == content_sha256(expected)
    for name, variable in dataset.variables.items():
        same = loaded.variables[name]
        if variable.dtype.kind == "U":
            assert same.dtype.kind == "U"
        else:
            assert same.dtype == variable.dtype
            assert same.values.tobytes() == variable.values.tobytes()
