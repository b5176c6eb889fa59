"""Files that look like archives and are made to harm a reader.

Each function gives an archive a part that no archive has. It is written with h5py, whose HDF5 asks
no questions, and the seal of the archive is lost by it. Those of `SEALED_AGAIN` are refused even
if the forger seals them.
"""

import os
from pathlib import Path

import h5py
import netCDF4
import numpy as np


def external_link(path):
    """Add a link to another file."""
    with h5py.File(path, "r+") as file:
        file["outside"] = h5py.ExternalLink("/etc/hostname", "/x")


def external_storage(path):
    """Add a variable whose values are in another file."""
    with h5py.File(path, "r+") as file:
        file.create_dataset("outside", (4,), "f8", external=[("/etc/hostname", 0, 32)])


def soft_link(path):
    """Add a link to itself."""
    with h5py.File(path, "r+") as file:
        file["turned"] = h5py.SoftLink("/turned")


def virtual_dataset(path):
    """Add a variable put together from another file."""
    with h5py.File(path, "r+") as file:
        layout = h5py.VirtualLayout((4,), "f8")
        layout[:] = h5py.VirtualSource("/etc/hostname", "x", (4,))
        file.create_virtual_dataset("outside", layout)


def vast_variable(path):
    """Add a variable of 73 TiB, none of it written."""
    with netCDF4.Dataset(path, "a") as file:
        file.createDimension("vast", 10**13)
        file.createVariable("extra", "f8", ("vast",), zlib=True, chunksizes=(4096,))


def compression_bomb(path):
    """Add a gibibyte of zeros in a mebibyte."""
    with h5py.File(path, "r+") as file:
        options = {"compression": "gzip", "compression_opts": 9, "chunks": (2**24,)}
        file.create_dataset("bomb", data=np.zeros(2**27), **options)


def bomb_in_one_chunk(path):
    """Add the same in one piece, which HDF5 must take into memory whole."""
    with h5py.File(path, "r+") as file:
        options = {"compression": "gzip", "compression_opts": 9, "chunks": (2**27,)}
        file.create_dataset("bomb", data=np.zeros(2**27), **options)


def huge_attribute(path):
    """Add an attribute of 128 MiB."""
    with h5py.File(path, "r+", libver="latest") as file:
        file.attrs["huge"] = np.zeros(2**24)


def huge_string(path):
    """Add a text of 256 MiB."""
    with h5py.File(path, "r+") as file:
        file.create_dataset("text", data=["x" * 2**28], dtype=h5py.string_dtype())


def deep_groups(path):
    """Add groups within groups, 2,000 deep."""
    with h5py.File(path, "r+") as file:
        group = file
        for _ in range(2000):
            group = group.create_group("g")


def cyclic_links(path):
    """Add groups that hold the group that they are in."""
    with h5py.File(path, "r+") as file:
        group = file.create_group("round")
        group["again"] = file["/"]
        file["self"] = file["/"]


def user_types(path):
    """Types that netCDF knows or not, and a variable of each."""
    with h5py.File(path, "r+") as file:
        file["pair"] = np.dtype([("real", "f8"), ("imaginary", "f8")])
        file.create_dataset("pairs", (3,), file["pair"])
        file.create_dataset("opaque", (3,), "V8")
        file.create_dataset("days", (3,), h5py.enum_dtype({"one": 1, "two": 2}))
        file.create_dataset("references", (3,), h5py.ref_dtype)


def missing_filter(path):
    """Add a variable written through a filter that nobody has."""
    with h5py.File(path, "r+") as file:
        creation = h5py.h5p.create(h5py.h5p.DATASET_CREATE)
        creation.set_chunk((4,))
        creation.set_filter(31999, h5py.h5z.FLAG_OPTIONAL, (1, 2))
        space = h5py.h5s.create_simple((8,))
        made = h5py.h5d.create(file.id, b"strange", h5py.h5t.NATIVE_DOUBLE, space, creation)
        made.write(h5py.h5s.ALL, h5py.h5s.ALL, np.zeros(8))


def many_variables(path):
    """Add three thousand variables."""
    with h5py.File(path, "r+", libver="latest") as file:
        for number in range(3000):
            file.create_dataset(f"v{number}", data=np.zeros(1))


def other_content(path):
    """Write a file that has nothing of an archive but its attributes."""
    with netCDF4.Dataset(path, "w") as file:
        file.rotor_ida_format = 3
        file.content_sha256 = "0" * 64


def sparse_giant(path):
    """Let the file be a tebibyte long, most of it nowhere."""
    os.truncate(path, 2**40)


FORGERIES = {
    name: made
    for name, made in list(globals().items())
    if callable(made) and getattr(made, "__module__", "") == __name__ and made is not Path
}
# Not those that only take as much time and memory as they declare, nor the one that is too long.
SEALED_AGAIN = {
    "external_link": "is not a sound archive: it contains 'outside', which is a link",
    "external_storage": "contains 'outside', whose data are in another file",
    "soft_link": "contains 'turned', which is a link",
    "virtual_dataset": "contains 'outside', which is composed of other variables",
    "vast_variable": r"declares 8e\+13 bytes",
    "deep_groups": "contains 'g', which is not a variable",
    "cyclic_links": "contains '(round|self)', which is not a variable",
    "user_types": "is not a sound archive",
    "missing_filter": "cannot read .*, which may be damaged",
    "many_variables": "does not have the checksum",
    "other_content": "does not have the checksum",
}
