"""Read MATLAB files up to version 7 (MAT 4 and MAT 5); those of version 7.3 are HDF5.

SciPy's reader believes the sizes and types that a damaged file declares, and then ends the process.
This one checks each against the bytes that the file has.
"""

from __future__ import annotations

import math
import struct
import zlib
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt
from scipy.sparse import coo_array

from rotor_ida.errors import InputError

Array = npt.NDArray[Any]

HEAD = 128
# Structures within structures.
DEEPEST = 32
# Parts of one cell or structure.
MOST_PARTS = 100_000
# Types of numbers and other elements of MAT 5.
NUMBERS = {
    1: "i1", 2: "u1", 3: "i2", 4: "u2", 5: "i4", 6: "u4", 7: "f4", 9: "f8", 12: "i8", 13: "u8"
}  # fmt: skip
MATRIX, COMPRESSED = 14, 15
# Classes of arrays of MAT 5.
CELL, STRUCTURE, OBJECT, TEXT, SPARSE = 1, 2, 3, 4, 5
FIRST_OF_NUMBERS, LAST_OF_NUMBERS = 6, 15
OPAQUE = 17
WORDS = {TEXT: "text"}
# Codes of the letters of a text, by the type of its element.
CODES = {4: "utf-16", 16: "utf-8", 17: "utf-16"}
IS_COMPLEX = 0x800
# A class of arrays of MAT 4, and types of numbers.
SPARSE_OF_4 = 2
NUMBERS_OF_4 = {0: "f8", 1: "f4", 2: "i4", 3: "i2", 4: "u2", 5: "u1"}


class Element(NamedTuple):
    """Type of an element, and its bytes."""

    kind: int
    held: memoryview


@dataclass
class Source:
    """Bytes of elements one after another, and how many of them were read."""

    held: memoryview
    order: str
    place: int = 0

    def take(self, size: int) -> memoryview:
        """Return the next bytes; raise `ValueError` if there are not enough."""
        if size > len(self.held) - self.place:
            raise ValueError(
                f"{size} bytes are declared where {len(self.held) - self.place} are left"
            )
        self.place += size
        return self.held[self.place - size : self.place]

    def element(self) -> Element:
        """Return the next element; one of up to four bytes has them in its tag."""
        first, size = struct.unpack(f"{self.order}II", self.take(8))
        if first >> 16:
            size, kind = first >> 16, first & 0xFFFF
            if size > 4:
                raise ValueError(f"a short element of {size} bytes is declared")
            return Element(kind, self.held[self.place - 4 : self.place - 4 + size])
        held = self.take(size)
        if first != COMPRESSED:
            self.place = min(self.place + -size % 8, len(self.held))
        return Element(first, held)

    def numbers(self) -> Array:
        """Return the numbers in the next element."""
        kind, held = self.element()
        if kind not in NUMBERS:
            raise ValueError(f"numbers of the unknown type {kind} are declared")
        return np.frombuffer(held, dtype=self.order + NUMBERS[kind])

    def text(self) -> str:
        """Return the text in the next element."""
        return bytes(self.element().held).decode("latin-1")


def is_hdf5(head: bytes) -> bool:
    """Return whether a file is of version 7.3, by its head."""
    return head[HEAD - 4 : HEAD] in (b"\0\2IM", b"\2\0MI")


def arrays_of(held: bytes, largest: int) -> dict[str, object]:
    """Return the content of a file by name: arrays, sparse matrices, mappings of fields, or a word.

    ValueError or another exception is raised if it is damaged, not of MATLAB, or has more than
    `largest` bytes when decompressed.
    """
    if 0 in held[:4]:
        return dict(_variables_of_4(memoryview(held)))
    order = {b"IM": "<", b"MI": ">"}.get(held[HEAD - 2 : HEAD])
    if order is None:
        raise ValueError("its head is not that of a MATLAB file")
    found: dict[str, object] = {}
    left = largest
    source = Source(memoryview(held)[HEAD:], order)
    while source.place < len(source.held):
        kind, within = source.element()
        if kind == COMPRESSED:
            within = memoryview(_unpacked(within, left))
            left -= len(within)
            kind, within = Source(within, order).element()
        if kind != MATRIX:
            raise ValueError(f"an element of the unknown type {kind} is declared")
        name, value = _matrix(Source(within, order), 0)
        if name:  # MATLAB adds arrays without a name for its objects
            found[name] = value
    return found


def _unpacked(held: memoryview, most: int) -> bytes:
    """Return the bytes of a compressed element, up to a limit."""
    unpacker = zlib.decompressobj()
    found = unpacker.decompress(held, most)
    if not unpacker.eof:
        raise ValueError(f"a compressed element ends early or has more than {most} bytes")
    return found


def _matrix(source: Source, depth: int) -> tuple[str, object]:
    """Return the name of an array and its values; structures become mappings."""
    if depth > DEEPEST:
        raise InputError(f"structures must be nested at most {DEEPEST} deep, got more")
    if not source.held:  # an empty cell
        return "", np.empty(0)
    flags = source.numbers()
    kind = int(flags[0]) & 0xFF if flags.size else 0
    if kind == OPAQUE:
        return source.text(), "an object"
    shape = tuple(source.numbers().astype(int).tolist())
    name = source.text()
    if any(length < 0 for length in shape):
        raise ValueError(f"the shape {shape} is declared")
    is_complex = bool(int(flags[0]) & IS_COMPLEX) if flags.size else False
    return name, _value(source, kind, shape, is_complex=is_complex, depth=depth)


def _value(
    source: Source, kind: int, shape: tuple[int, ...], *, is_complex: bool, depth: int
) -> object:
    """Return the values of an array of a class, or a word."""
    if FIRST_OF_NUMBERS <= kind <= LAST_OF_NUMBERS:
        parts = [_shaped(source.numbers(), shape) for _ in range(1 + is_complex)]
        return parts[0] + 1j * parts[1] if is_complex else parts[0]
    if kind == TEXT:
        return _text(source, shape)
    if kind == SPARSE:
        return _sparse(source, shape, is_complex=is_complex)
    if kind == CELL:
        return _objects(shape, lambda: _matrix_within(source, depth))
    if kind in (STRUCTURE, OBJECT):
        if kind == OBJECT:
            source.text()  # its class
        return _structures(source, shape, depth)
    return WORDS.get(kind, "of another type")


def _structures(source: Source, shape: tuple[int, ...], depth: int) -> object:
    """Return structures as mappings of their fields."""
    fields = _fields(source)
    return _objects(shape, lambda: {each: _matrix_within(source, depth) for each in fields})


def _text(source: Source, shape: tuple[int, ...]) -> object:
    """Return the rows of a text, as an array."""
    kind, held = source.element()
    code = CODES.get(kind, "latin-1")
    if code == "utf-16":
        code += "-le" if source.order == "<" else "-be"
    letters = bytes(held).decode(code, "replace")
    if len(letters) != math.prod(shape) or len(shape) != 2:
        return WORDS[TEXT]
    return np.array([letters[row :: shape[0]] for row in range(shape[0])])


def _sparse(source: Source, shape: tuple[int, ...], *, is_complex: bool) -> object:
    """Return a matrix by the rows of its numbers and where each column begins among them."""
    rows, begins, numbers = source.numbers(), source.numbers(), source.numbers()
    if is_complex:
        numbers = numbers + 1j * source.numbers()
    counts = np.diff(begins.astype(int))
    if len(shape) != 2 or counts.size != shape[1] or begins[0] or counts.min(initial=0) < 0:
        raise ValueError(f"columns that begin at {begins[:3]} ... are declared for {shape}")
    held = counts.sum()
    if held > min(rows.size, numbers.size):
        raise ValueError(f"{held} numbers are declared where {numbers.size} are given")
    places = (rows[:held].astype(int), np.repeat(np.arange(shape[1]), counts))
    return coo_array((numbers[:held].astype(numbers.dtype.newbyteorder("=")), places), shape=shape)


def _sparse_of_4(rows: Array) -> object:
    """Return a matrix by row, column and number of each entry; the last gives its shape."""
    if rows.shape[0] < 1 or rows.shape[1] != 3:
        raise ValueError(f"a sparse matrix of the shape {rows.shape} is declared")
    places = rows[:, :2].astype(int)
    return coo_array((rows[:-1, 2].astype(float), (places[:-1] - 1).T), shape=tuple(places[-1]))


def _matrix_within(source: Source, depth: int) -> object:
    """Return the next array in a cell or a structure."""
    kind, held = source.element()
    if kind != MATRIX:
        raise ValueError(f"an element of type {kind} is declared in place of an array")
    return _matrix(Source(held, source.order), depth + 1)[1]


def _fields(source: Source) -> list[str]:
    """Return the names of the fields of a structure, each in a place of one length."""
    length = source.numbers()
    names = bytes(source.element().held)
    if length.size != 1 or length[0] < 1 or len(names) % length[0]:
        raise ValueError(f"fields of {len(names)} bytes are declared with lengths {length}")
    places = range(0, len(names), int(length[0]))
    cut = [names[place : place + int(length[0])].split(b"\0")[0] for place in places]
    return [each.decode("latin-1") for each in cut]


def _objects(shape: tuple[int, ...], make: Callable[[], object]) -> object:
    """Return the only part of a cell or structure, or all in the order of the file."""
    count = math.prod(shape)
    if count == 1:
        return make()
    if count > MOST_PARTS:
        raise ValueError(f"{count} parts are declared, more than {MOST_PARTS}")
    parts = np.empty(count, dtype=object)
    for place in range(count):
        parts[place] = make()
    return parts


def _shaped(numbers: Array, shape: tuple[int, ...]) -> Array:
    """Return numbers, counted along columns, in their shape."""
    if numbers.size != math.prod(shape):
        raise ValueError(f"the shape {shape} is declared for {numbers.size} numbers")
    return numbers.reshape(shape, order="F")


def _variables_of_4(held: memoryview) -> Iterator[tuple[str, object]]:
    """Yield the arrays of a file of MAT 4, each after a head of five numbers and its name."""
    little = struct.unpack("<i", held[:4])[0] in range(1000) if len(held) > 3 else True
    source = Source(held, "<" if little else ">")
    while source.place < len(held):
        kind, *shape, is_complex, length = struct.unpack(f"{source.order}5i", source.take(20))
        machine, kind = divmod(kind, 1000)
        kind_of_numbers, kind_of_array = divmod(kind, 10)
        if machine != (not little) or kind_of_numbers not in NUMBERS_OF_4 or min(shape) < 0:
            raise ValueError(f"an array of type {kind} and shape {tuple(shape)} is declared")
        if length < 1:
            raise ValueError(f"a name of {length} bytes is declared")
        name = bytes(source.take(length)).split(b"\0")[0].decode("latin-1")
        dtype = np.dtype(source.order + NUMBERS_OF_4[kind_of_numbers])
        size = math.prod(shape) * dtype.itemsize
        parts = [
            _shaped(np.frombuffer(source.take(size), dtype=dtype), tuple(shape))
            for _ in range(2 if is_complex else 1)
        ]
        value: object = parts[0] + 1j * parts[1] if is_complex else parts[0]
        if kind_of_array == SPARSE_OF_4 and not is_complex:
            yield name, _sparse_of_4(parts[0])
        else:
            yield name, value if kind_of_array == 0 else WORDS[TEXT]
