"""What `tests/platforms.py` compares on other systems, on this one."""

from __future__ import annotations

import os
import struct
from pathlib import Path
from runpy import run_path

import pytest

from rotor_ida.core.identity import MODELS
from rotor_ida.core.library import offered

ROOT = Path(__file__).parents[2]


@pytest.fixture(scope="module")
def platforms():
    if not (ROOT / "hatch_build.py").is_file() or os.name == "nt":
        pytest.skip(
            "there are no sources to compile, or programs find no library in their own folder"
        )
    found = run_path(str(ROOT / "tests" / "platforms.py"))
    if found["hatch_build"]["find_compiler"]() is None:
        pytest.skip("no C compiler is installed")
    return found


@pytest.mark.parametrize("model", MODELS)
def test_all_levels_say_the_same_of_orbits_of_every_kind(platforms, tmp_path, model):
    said = [
        platforms["said_by"]([], platforms["made_here"](platforms["BITS"], model, level, tmp_path))
        for level in offered()
    ]
    assert all(lines == said[0] for lines in said)
    assert len({line.split()[-1] for line in said[0]}) > 50  # of which few are alike
    statuses = [line.split()[-1] for line in said[0] if " status " in line]
    assert len(set(statuses)) == 1, "a run did not reach its end"


@pytest.mark.parametrize("model", MODELS)
def test_every_function_of_the_interface_is_in_the_library(platforms, tmp_path, model):
    source = tmp_path / "interface.c"
    source.write_text(platforms["interface"](model), encoding="utf-8")
    program = platforms["made_here"](source, model, offered()[0], tmp_path)
    assert platforms["said_by"]([], program) == []


@pytest.mark.parametrize(
    ("text", "tag", "message"),
    [
        (b"GLIBC_2.2.5 GLIBC_2.17", "manylinux_2_17_x86_64", ""),
        (b"GLIBC_2.2.5 GLIBC_2.29", "manylinux_2_17_x86_64",
         "it asks for glibc 2.29, not manylinux_2_17_x86_64"),
        (b"", "musllinux_1_2_x86_64", ""),
        (b"GLIBC_2.2.5", "musllinux_1_2_x86_64", "it asks for glibc 2.2, not musllinux_1_2_x86_64"),
    ],
)  # fmt: skip
def test_a_library_for_linux_asks_for_the_glibc_of_its_tag(platforms, tmp_path, text, tag, message):
    (tmp_path / "library").write_bytes(text)
    assert platforms["read_elf"](tmp_path / "library", tag) == message


@pytest.mark.parametrize(
    ("processor", "commands", "message"),
    [
        (0x0100000C, [(0x32, 11 << 16), (0x1D, 0)], ""),
        (0x01000007, [(0x32, 11 << 16), (0x1D, 0)], "it is no library for that processor"),
        (0x0100000C, [(0x32, 11 << 16)], "it is not signed, and macOS on ARM ends what loads it"),
        (0x0100000C, [(0x32, 15 << 16), (0x1D, 0)],
         "it asks for macosx_15_0_, and the wheel says macosx_11_0_arm64"),
    ],
)  # fmt: skip
def test_a_library_for_macos_is_read(platforms, tmp_path, processor, commands, message):
    """Of a header made here: magic, processor, kind 6, then commands of 24 bytes."""
    head = struct.pack("<8I", 0xFEEDFACF, processor, 0, 6, len(commands), 0, 0, 0)
    body = b"".join(struct.pack("<6I", kind, 24, 1, least, 0, 0) for kind, least in commands)
    (tmp_path / "library").write_bytes(head + body)
    said = platforms["read_macho"](tmp_path / "library", "aarch64", "macosx_11_0_arm64")
    assert said == message
