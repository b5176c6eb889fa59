"""Checks of the parts of an HDF5 file.

netCDF does not report whether a part of a file is a link or has its data in another file. So the
HDF5 library that netCDF4-python has loaded is asked, through ctypes. h5py would load a second HDF5,
and the two conflict: see HDF errors and crashes in h5py's issue 1541 and in netcdf4-python's
issues 653, 1214 and 1343.
"""

from __future__ import annotations

import ctypes
import importlib
import os
from pathlib import Path

_Id = ctypes.c_int64
_Status = ctypes.c_int
# The kind of a link is the first member of HDF5's structure.
_Visitor = ctypes.CFUNCTYPE(
    _Status, _Id, ctypes.c_char_p, ctypes.POINTER(ctypes.c_int), ctypes.c_void_p
)
_SIGNATURES = {
    "H5Fopen": (_Id, ctypes.c_char_p, ctypes.c_uint, _Id),
    "H5Fclose": (_Status, _Id),
    "H5Literate_by_name2": (
        *(_Status, _Id, ctypes.c_char_p, ctypes.c_int, ctypes.c_int),
        *(ctypes.c_void_p, _Visitor, ctypes.c_void_p, _Id),
    ),
    "H5Oexists_by_name": (ctypes.c_int, _Id, ctypes.c_char_p, _Id),
    "H5Dopen2": (_Id, _Id, ctypes.c_char_p, _Id),
    "H5Dget_create_plist": (_Id, _Id),
    "H5Dclose": (_Status, _Id),
    "H5Pget_external_count": (ctypes.c_int, _Id),
    "H5Pget_layout": (ctypes.c_int, _Id),
    "H5Pclose": (_Status, _Id),
}
_HARD_LINK = 0
_BY_NAME, _NATIVE_ORDER = 0, 2
_NO_VARIABLE = "which is not a variable or is damaged"
# Parts of a file of others, and groups within groups.
_MOST_PARTS, _DEEPEST = 20_000, 32
_OWN_LAYOUTS = range(3)  # compact, contiguous, chunked; then comes virtual


def what_is_not_own(path: Path, *, groups: bool = True) -> str:
    """Return the part of the HDF5 file at `path` that is a link or has its data in another file.

    netCDF follows links while it opens a file, so HDF5 is asked before. Groups that contain one
    another would crash netCDF, so those that are nested too deep are refused, or all of them
    without `groups`. netCDF4-python and HDF5 are not thread-safe: call it under the lock of
    `rotor_ida.results.archive.content`. The result is empty if there is no such part, or if the
    HDF5 library of netCDF4-python cannot be called (Windows). OSError is raised if HDF5 cannot
    read the file.
    """
    hdf5 = _hdf5()
    if hdf5 is None:
        return ""
    file = hdf5.H5Fopen(os.fsencode(path), 0, 0)
    try:
        if file < 0:
            raise OSError("HDF5 cannot open it")
        waiting, seen = [b"/"], 0
        while waiting:
            group = waiting.pop()
            for name, kind in _links_in(hdf5, file, group).items():
                whole = group.rstrip(b"/") + b"/" + name
                shown = ascii(whole.decode(errors="replace").lstrip("" if groups else "/"))
                seen += 1
                if seen > _MOST_PARTS or whole.count(b"/") > _DEEPEST:
                    return f"more than {_MOST_PARTS} parts, or one of them nested over {_DEEPEST}"
                if kind != _HARD_LINK:
                    return f"{shown}, which is a link"
                reason = _outside_storage(hdf5, file, whole)
                if reason == _NO_VARIABLE and groups:
                    if hdf5.H5Oexists_by_name(file, whole, 0) <= 0:
                        return f"{shown}, which is damaged"
                    waiting.append(whole)
                elif reason:
                    return f"{shown}, {reason}"
    finally:
        if file >= 0:
            hdf5.H5Fclose(file)
    return ""


def _links_in(hdf5: ctypes.CDLL, file: int, group: bytes) -> dict[bytes, int]:
    """Return the kinds of links in a group by name; empty for anything but a group."""
    kinds: dict[bytes, int] = {}

    def note(_group: int, name: bytes, kind: ctypes._Pointer[ctypes.c_int], _data: object) -> int:
        kinds[name] = kind[0]
        return 0

    of_group = (file, group, _BY_NAME, _NATIVE_ORDER, None, _Visitor(note), None, 0)
    if hdf5.H5Literate_by_name2(*of_group) < 0 and group == b"/":
        raise OSError("HDF5 cannot list its contents")
    return kinds


def _outside_storage(hdf5: ctypes.CDLL, file: int, name: bytes) -> str:
    dataset = hdf5.H5Dopen2(file, name, 0)
    if dataset < 0:
        return _NO_VARIABLE
    creation = hdf5.H5Dget_create_plist(dataset)
    try:
        files, layout = hdf5.H5Pget_external_count(creation), hdf5.H5Pget_layout(creation)
        if files < 0 or layout < 0:
            return "which is damaged"
        if files > 0:
            return "whose data are in another file"
        if layout not in _OWN_LAYOUTS:
            return "which is composed of other variables"
    finally:
        hdf5.H5Pclose(creation)
        hdf5.H5Dclose(dataset)
    return ""


def _hdf5() -> ctypes.CDLL | None:
    """Return the HDF5 library that netCDF4-python has loaded, if it can be called."""
    # A library's handle also finds names in the libraries to which it is linked.
    library = ctypes.CDLL(importlib.import_module("netCDF4._netCDF4").__file__)
    for name, (result, *arguments) in _SIGNATURES.items():
        function = getattr(library, name, None)
        if function is None:
            return None
        function.restype, function.argtypes = result, arguments
    return library
