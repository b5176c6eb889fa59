"""A machine in a file is the same machine, to the last bit."""

import os
import tomllib

import pytest
from hypothesis import given
from hypothesis import strategies as st

from rotor_ida import DimensionalRotor, InputError, load_machine, save_machine
from rotor_ida.results.machine_file import __doc__ as documented
from rotor_ida.results.machine_file import machine_text

SIZE = st.floats(1e-9, 1e12)


@given(st.lists(SIZE, min_size=6, max_size=6), st.lists(st.floats(0.0, 1e9), min_size=5,
       max_size=5), st.sampled_from([1.0, 1.5]))  # fmt: skip
def test_what_is_written_is_read_to_the_last_bit(needed, more, exponent):
    names = ("mass", "contact_stiffness", "damping", "eccentricity", "clearance", "speed")
    optional = ("shaft_stiffness", "contact_damping", "load", "friction", "disc_radius")
    machine = DimensionalRotor(
        **dict(zip(names, needed, strict=True)), **dict(zip(optional, more, strict=True)),
        contact_exponent=exponent,
    )  # fmt: skip
    assert tomllib.loads(machine_text(machine)) == machine.given


def test_the_documented_file_is_the_machine_it_says(tmp_path):
    """The example of the module's text, with critical speed 5513 rpm by hand."""
    lines = [line[4:] for line in documented.splitlines() if line.startswith("    ")]
    place = tmp_path / "pump.toml"
    place.write_text("\n".join(lines))
    machine = load_machine(place)
    assert machine.damping_ratio == pytest.approx(0.03)
    assert machine.eccentricity == pytest.approx(16.711e-6, rel=1e-4)
    assert (machine.contact_exponent, machine.disc_radius) == (1.0, 0.06)
    save_machine(machine, place, overwrite=True)
    assert load_machine(place) == machine
    with pytest.raises(InputError, match="already exists; pass overwrite=True to replace it"):
        save_machine(machine, place)


def test_a_file_that_cannot_be_read_gets_one_line(tmp_path):
    with pytest.raises(InputError, match=r"cannot read .*gone\.toml.: No such file"):
        load_machine(tmp_path / "gone.toml")
    with pytest.raises(InputError, match=r"cannot read .*: Is a directory"):
        load_machine(tmp_path)
    (tmp_path / "bytes.toml").write_bytes(b"\xff\xfe")
    with pytest.raises(InputError, match=r"machine must be a TOML file, got .*: "):
        load_machine(tmp_path / "bytes.toml")
    (tmp_path / "large.toml").write_bytes(b"#" * 1_000_001)
    with pytest.raises(InputError, match="machine must be a small TOML file"):
        load_machine(os.fspath(tmp_path / "large.toml"))
