"""Systems written to files and read again, and bearings in system files."""

import errno
import os
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from rotor_ida import (
    Bearing,
    Contact,
    InputError,
    Race,
    Stator,
    Support,
    campbell,
    load_system,
    simulate,
)
from tests.films import SPEEDS, on_films

MATRICES = "[system]\nmass = [2, 2]\nstiffness = [1e6, 1e6]\nnodes = { disc = [0, 1] }\n"


def everything():
    """Return a system with all that a file may have."""
    system = on_films(unequal=0.3)
    shared = Stator(
        mass=3.0, stiffness=(1e7, 2e7), damping=500.0, race=Race(radius=0.1, inertia=0.2)
    )
    near = replace(system.contacts[0], clearance=2e-5, stator=shared, centre=(1e-6, 0.0))
    other = Contact(node="3", clearance=5e-5, stiffness=1e9, damping=0.1, stator=shared)
    return replace(
        system, contacts=[near, other], supports=[Support(node="2", stiffness=(1e4, 2e4))],
        bearings=[*system.bearings, Bearing(node="2", name="seal", stator="1", stiffness=1e5)],
        positions={name: 0.05 * int(name) for name in system.nodes}, note="A machine.",
        translations=system.unit_translations(), gravity=(0.0, -9.81),
    )  # fmt: skip


def test_a_system_comes_back_from_its_file(tmp_path: Path):
    system = everything()
    again = load_system(system.to_file(tmp_path / "rotor.toml"))
    assert again.positions == system.positions
    assert again.note == system.note
    assert again.contacts[0].stator is again.contacts[1].stator
    assert [each.name for each in again.bearings] == [each.name for each in system.bearings]
    assert again.bearings[-1].name == "seal"
    assert [each.exponent for each in again.contacts] == [1.0, 1.5]
    given = {"speed": 1700.0, "duration": 0.01, "samples": 3, "start": None}
    one, other = (simulate(each, **given) for each in (system, again))
    np.testing.assert_array_equal(one.final_state, other.final_state)
    np.testing.assert_array_equal(one.event_time, other.event_time)
    with pytest.raises(InputError, match="already exists; pass overwrite=True to replace it"):
        system.to_file(tmp_path / "rotor.toml")
    assert system.to_file(tmp_path / "rotor.toml", overwrite=True).exists()


@pytest.mark.parametrize(
    ("changed", "name", "words"),
    [
        ({}, "rotor.npz", r"path must end in \.toml"),
        ({"gravity_in_static_force": (0.0, -1.0)}, "rotor.toml", "gravity_in_static_force must be"),
    ],
)
def test_what_a_file_cannot_have_is_refused(tmp_path: Path, changed, name, words):
    with pytest.raises(InputError, match=words):
        replace(on_films(), **changed).to_file(tmp_path / name)
    assert not list(tmp_path.iterdir())


def test_tables_are_read_from_the_file_or_from_beside_it(tmp_path: Path):
    """In a .csv with units, in a .npz, and within the system file."""
    film = on_films(unequal=0.3).bearings[0]
    rpm = SPEEDS * 30.0 / np.pi
    rows = [
        [n, *(1e-6 * k).ravel(), *c.ravel()[[0, 3]]]
        for n, k, c in zip(rpm, film.stiffness, film.damping, strict=True)
    ]
    head = ["speed [rpm]", *(f"k{pair} [N/mm]" for pair in ("xx", "xy", "yx", "yy")), "cxx", "cyy"]
    for row in rows:
        row[1:5] = [1e3 * value for value in row[1:5]]  # N/mm
    text = "\n".join(",".join(map(repr, map(float, row))) for row in rows)
    (tmp_path / "film.csv").write_text(f"{','.join(head)}\n{text}\n")
    table = {"speed": film.speed, "stiffness": film.stiffness, "damping": film.damping}
    np.savez(tmp_path / "film.npz", **table)
    speeds = ", ".join(f'"{n!r} rpm"' for n in rpm.tolist())
    coefficients = (f"{name} = {table[name].tolist()}" for name in ("stiffness", "damping"))
    inline = "\n".join([f"speed = [{speeds}]", *coefficients])
    for own in ('table = "film.csv"', 'table = "film.npz"', inline):
        path = tmp_path / "rotor.toml"
        path.write_text(f'{MATRICES}[[bearings]]\nnode = "disc"\n{own}\n')
        (read,) = load_system(path).bearings
        for name in ("knots", "stiffness", "damping"):
            np.testing.assert_allclose(getattr(read, name), getattr(film, name), rtol=1e-13)
    assert campbell(load_system(path), speed=[500.0]).sizes["eigenvalue"] > 0


@pytest.mark.parametrize(
    ("own", "words"),
    [
        ("", r"bearings\[0\]: stiffness or table must be given"),
        ('table = "film.csv"\nspeed = [1, 2]', "table must be the path of a file, without speed"),
        ('table = "none.csv"', "cannot read the table"),
        ('table = "film.txt"', r"a table must be a \.npz or \.csv file"),
        ('table = "odd.csv"', "columns of .* must be speed, .*, got 'kzz'"),
        ('table = "half.csv"', "must hold speed and stiffness or kxx"),
        ('stiffness = "3 kg"', "the unit of .*stiffness must be"),
        ("stiffness = 1e6\nstator = 'casing'", "node must be one of 'disc', got 'casing'"),
        (
            "stiffness = [1e6, 2e6]\nspeed = ['2 rpm', '1 rpm']",
            "speed of the bearing at 'disc' must",
        ),
    ],
)
def test_bearings_in_a_file_are_refused_with_their_place(tmp_path: Path, own, words):
    (tmp_path / "odd.csv").write_text("speed,kxx,kzz\n1,2,3\n")
    (tmp_path / "half.csv").write_text("speed,cxx\n1,2\n")
    (tmp_path / "film.txt").write_text("")
    path = tmp_path / "rotor.toml"
    path.write_text(f'{MATRICES}[[bearings]]\nnode = "disc"\n{own}\n')
    with pytest.raises(InputError, match=words) as refused:
        load_system(path)
    assert "\n" not in str(refused.value)


def test_without_room_on_the_disk_the_old_files_stay(tmp_path, monkeypatch):
    path = on_films().to_file(tmp_path / "rotor.toml")
    before = {each.name: each.read_bytes() for each in tmp_path.iterdir()}

    def full(*_: object, **__: object) -> None:
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    monkeypatch.setattr(np, "savez", full)
    with pytest.raises(InputError, match=r"cannot write '.*rotor\.toml': No space left on device"):
        on_films().to_file(path, overwrite=True)
    assert {each.name: each.read_bytes() for each in tmp_path.iterdir()} == before
