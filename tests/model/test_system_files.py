"""Files of matrices: read exactly, or refused in one line before anything large exists."""

from __future__ import annotations

import io
import os
import tracemalloc
import warnings
import zipfile
from pathlib import Path

import numpy as np
import pytest
import scipy.io
import scipy.sparse

from rotor_ida import InputError, RotorSystem, load_system
from rotor_ida.model import system_files
from tests.signals.damaged import damaged

MASS = np.diag([10.0, 10.0, 0.12, 0.12])
STIFFNESS = np.array(
    [[7e5, 0, 6e4, 0], [0, 1.5e6, 0, 1e5], [6e4, 0, 2.8e4, 0], [0, 1e5, 0, 6e4]]
)  # fmt: skip
ARRAYS = {
    "M": MASS, "K": STIFFNESS, "C": 1e-3 * STIFFNESS, "node_disc": np.array([[0, 1]]),
    "node_tip": np.eye(4)[2:],
}  # fmt: skip
SPARSE = {name: scipy.sparse.csc_matrix(each) for name, each in ARRAYS.items() if len(each) == 4}


def as_folder(path: Path, make: type, symmetry: str) -> None:
    path.mkdir()
    for name, values in ARRAYS.items():
        of = symmetry if values.shape == (4, 4) else None
        scipy.io.mmwrite(path / f"{name}.mtx", make(values), symmetry=of)


WRITTEN = {
    "a.npz": lambda path: np.savez(path, **ARRAYS),
    "packed.npz": lambda path: np.savez_compressed(path, **ARRAYS),
    "a.mat": lambda path: scipy.io.savemat(path, ARRAYS),
    "packed.mat": lambda path: scipy.io.savemat(path, ARRAYS, do_compression=True),
    "sparse.mat": lambda path: scipy.io.savemat(path, ARRAYS | SPARSE),
    "old.mat": lambda path: scipy.io.savemat(path, ARRAYS, format="4"),
    "old_sparse.mat": lambda path: scipy.io.savemat(path, ARRAYS | SPARSE, format="4"),
    "dense": lambda path: as_folder(path, np.asarray, "general"),
    "lower": lambda path: as_folder(path, np.asarray, "symmetric"),
    "entries": lambda path: as_folder(path, scipy.sparse.coo_matrix, "general"),
    "half": lambda path: as_folder(path, scipy.sparse.coo_matrix, "symmetric"),
}
MTX = "%%MatrixMarket matrix "


def refusal_of(path: Path) -> str:
    """Return why a file is refused, or nothing; any other error is raised."""
    try:
        RotorSystem.from_file(path)
    except InputError as error:
        return str(error)
    return ""


@pytest.mark.parametrize("name", WRITTEN)
def test_a_system_is_read_as_it_was_written_and_no_damaged_copy_is_an_error(
    tmp_path: Path, name: str
):
    path = tmp_path / name
    WRITTEN[name](path)
    system = RotorSystem.from_file(path)
    for matrix, values in (("mass", MASS), ("stiffness", STIFFNESS), ("damping", ARRAYS["C"])):
        np.testing.assert_array_equal(getattr(system, matrix), values)
    assert system.nodes["disc"] == (0, 1)
    file = path / "K.mtx" if path.is_dir() else path
    whole = file.read_bytes()
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        for number in range(36):
            file.write_bytes(damaged(whole, number))
            told = refusal_of(path)
            assert len(told) < 600 + len(str(path))
            assert "\n" not in told


@pytest.mark.parametrize(
    ("name", "content", "told"),
    [
        ("a.npz", b"no", "cannot read the system"),
        ("a.mat", b"no" * 200, "cannot read the system"),
        ("a.txt", b"", r"must be a \.npz or \.mat file"),
        ("gone.npz", None, "cannot read the system"),
        ("whole.npz", {"M": MASS}, "must hold stiffness, got 'M'"),
    ],
)
def test_a_file_of_no_system_is_refused(tmp_path: Path, name: str, content: object, told: str):
    if isinstance(content, bytes):
        (tmp_path / name).write_bytes(content)
    elif isinstance(content, dict):
        np.savez(tmp_path / name, **content)
    with pytest.raises(InputError, match=told):
        RotorSystem.from_file(tmp_path / name)


def test_a_sparse_matrix_with_an_index_beyond_its_shape_is_refused(tmp_path: Path):
    path = tmp_path / "a.mat"
    entry = scipy.sparse.csc_matrix(([3.5], ([2], [1])), shape=(4, 4))
    scipy.io.savemat(path, {"K": entry, "M": MASS})
    held = bytearray(path.read_bytes())
    place = held.find((2).to_bytes(4, "little"), held.find(b"K\0\0\0") + 4)
    held[place : place + 4] = (2**28).to_bytes(4, "little")
    path.write_bytes(held)
    with pytest.raises(InputError, match="cannot read the system"):
        RotorSystem.from_file(path)


@pytest.mark.parametrize(
    ("text", "told"),
    [
        ("array real general\n0 0\n", "square matrix"),
        ("array real general\n-4 4\n", "sizes of the matrix"),
        ("array real general\n20000 20000\n1\n", "more than 2000"),
        ("coordinate real general\n20000 20000 1\n1 1 1\n", "more than 2000"),
        ("coordinate real general\n4 4 9999999999\n1 1 1\n", "1 follow"),
        ("coordinate real general\n4 4 1\n5 1 1\n", "from 1 to 4"),
        ("coordinate real general\n4 4 1\n1.5 1 1\n", "from 1 to 4"),
        ("coordinate real general\n4 4 1\nnan 1 1\n", "from 1 to 4"),
        ("coordinate real symmetric\n4 3 1\n1 1 1\n", "symmetric"),
        ("array complex general\n4 4\n1 2\n", "complex"),
        ("", "first line"),
    ],
)
def test_an_odd_matrix_market_file_is_refused(tmp_path: Path, text: str, told: str):
    as_folder(tmp_path / "rotor", np.asarray, "general")
    (tmp_path / "rotor" / "K.mtx").write_text(MTX + text if text else text)
    with pytest.raises(InputError, match=told):
        RotorSystem.from_file(tmp_path / "rotor")


def declared(shape: tuple[int, ...]) -> bytes:
    """Return a NumPy file that declares a shape, and is short."""
    file = io.BytesIO()
    head = {"descr": "<f8", "fortran_order": False, "shape": shape}
    np.lib.format.write_array_header_1_0(file, head)
    return file.getvalue() + bytes(800)


def as_zip(path: Path, of_stiffness: bytes) -> Path:
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive:
        for name in ("M", "K"):
            archive.writestr(f"{name}.npy", of_stiffness)
    return path


def as_toml(path: Path, mass: str) -> Path:
    path.write_text(f"system = {{ mass = {mass}, stiffness = {mass}, nodes = {{ a = [0, 1] }} }}")
    return path


@pytest.mark.parametrize(
    ("make", "told"),
    [
        (lambda path: as_toml(path, str([1] * 5_000)), "2000 rows"),
        (lambda path: as_zip(path.with_suffix(".npz"), declared((20_000, 20_000))), "shorter"),
        (lambda path: as_zip(path.with_suffix(".npz"), bytes(2**21)), "at most 1000000 bytes"),
    ],
)
def test_a_system_of_any_size_takes_little_memory_to_refuse(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, make, told: str
):
    monkeypatch.setattr(system_files, "MOST_BYTES", 10**6)
    path = make(tmp_path / "a.toml")
    tracemalloc.start()
    try:
        read = load_system if path.suffix == ".toml" else RotorSystem.from_file
        with pytest.raises(InputError, match=told):
            read(path)
        assert tracemalloc.get_traced_memory()[1] < 3e7
    finally:
        tracemalloc.stop()


def test_a_sparse_matrix_of_any_size_is_refused_before_it_is_filled():
    huge = scipy.sparse.eye_array(10**6)
    with pytest.raises(InputError, match="at most 2000 rows and columns"):
        RotorSystem(mass=huge, stiffness=huge, nodes={"disc": (0, 1)})


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="this system has no named pipes")
@pytest.mark.parametrize("name", ["pipe.npz", "pipe.mat", "pipe.toml", "M.mtx"])
def test_a_pipe_is_no_file_and_nobody_waits_for_it(tmp_path: Path, name: str):
    os.mkfifo(tmp_path / name)
    read = load_system if name.endswith(".toml") else RotorSystem.from_file
    with pytest.raises(InputError, match="pipe"):
        read(tmp_path if name.endswith(".mtx") else tmp_path / name)


@pytest.mark.parametrize(
    ("text", "told"),
    [
        (".".join("a" * 100_000) + " = 1", "at most 20 parts"),
        (" . ".join("a" * 100_000) + " = 1", "at most 20 parts"),
        (".".join(['"a"'] * 100_000) + " = 1", "at most 20 parts"),
        ("a = " + "[" * 5000, "nested less deep"),
        ("a = " + "{ a = " * 5000, "nested less deep"),
        ("speed = " + "1" * 5000, "4300 digits"),
        ('speed = "' + "1" * 5000 + 'rpm"\nsystem = { }', "must be given"),
        ('speed = "1 ' + "ms" * 40 + '"\nsystem = { }', "must be given"),
    ],
)
def test_no_toml_file_takes_long_or_ends_in_another_error(tmp_path: Path, text: str, told: str):
    path = tmp_path / "a.toml"
    path.write_text(text)
    with pytest.raises(InputError, match=told):
        load_system(path)
