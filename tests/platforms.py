"""Whether the core of other platforms is whole and gives the same bits as this one's.

    python tests/platforms.py [--wheels FOLDER] [TARGET ...]

The libraries are those of the wheels in a folder, or are compiled by ziglang. With each, a program
is linked that runs orbits of every kind (core/bits.c), one that calls every entry point in every
way that may go wrong (core/exercise.c), and one that names every function of the interface, so that
none may be missing. The first two are run where the system allows it, for ARM under qemu-user and
for Windows under wine; the first must say what the core of this machine says. A library for macOS
is read: its processor, the system that it asks for, its signature. What is not installed here is
named and left out.
"""

from __future__ import annotations

import argparse
import os
import platform
import re
import shutil
import struct
import subprocess
import sys
import tempfile
import zipfile
from itertools import product
from pathlib import Path
from runpy import run_path

ROOT = Path(__file__).resolve().parents[1]
CORE = ROOT / "rotor_ida" / "core"
BITS, EXERCISE = (ROOT / "tests" / "core" / name for name in ("bits.c", "exercise.c"))
hatch_build = run_path(str(ROOT / "hatch_build.py"))
identity = hatch_build["identity"]
# The files of another processor's libraries of C: Debian's libc6-arm64-cross.
ARM_ROOT = "/usr/aarch64-linux-gnu"
MACHO, SEGMENT_OF_SIGNATURE, BUILD_VERSION = 0xFEEDFACF, 0x1D, 0x32
PROCESSORS = {"x86_64": 0x01000007, "aarch64": 0x0100000C}


def runner(name):
    """Return the words that run a program of a target here, or None, and what is missing for it."""
    machine, system = name.split("-")
    if system == "macos":
        return None, "a Mac; its files are read"
    if system == "windows":
        return ["wine"] if shutil.which("wine") else None, "wine"
    if system == "musl" and not Path(f"/lib/ld-musl-{machine}.so.1").exists():
        return None, f"musl for {machine}"
    if machine == hatch_build["SAME"].get(platform.machine(), platform.machine()):
        return [], ""
    found = shutil.which(f"qemu-{machine}") or shutil.which(f"qemu-{machine}-static")
    usable = found and Path(ARM_ROOT).is_dir()
    return [found, "-L", ARM_ROOT] if usable else None, "qemu-user and libc6-arm64-cross"


def libraries(name, wheels, folder):
    """Put the libraries of a target into a folder: those of its wheel, or compiled here."""
    target = hatch_build["TARGETS"][name]
    if wheels is None:
        hatch_build["build"](hatch_build["find_zig"](), out=folder, target=target)
        return
    (wheel,) = wheels.glob(f"*-py3-none-{target.tag}.whl")
    with zipfile.ZipFile(wheel) as held:
        inside = [each for each in held.namelist() if re.search(r"core/librotor_\w+\.so$", each)]
        for each in inside:
            (folder / Path(each).name).write_bytes(held.read(each))
    print(f"  {wheel.name}: {wheel.stat().st_size / 1e6:.2f} MB, {len(inside)} libraries")


def interface(model):
    """Return a program that names every function which a library of a model offers."""
    headers = ["core.h", *(["system.h"] if model == "whole" else [])]
    text = "".join((CORE / header).read_text("utf-8") for header in headers)
    names = re.findall(r"CORE_API [\w ]+\*?\b(core_\w+)\(", text)
    if model == "run_up":  # which has no lanes
        names = [
            each for each in names if each not in ("core_follow_lanes", "core_measure_returns")
        ]
    assert len(names) > 10
    included = "".join(f'#include "{header}"\n' for header in headers)
    listed = ", ".join(f"(void (*)(void)){each}" for each in names)
    table = f"void (*volatile all[])(void) = {{{listed}}};"
    return f"{included}{table}\nint main(void) {{ return !all[0]; }}\n"


def linked(name, library, model, source):
    """Return a program that was compiled for a target and linked with a library beside it."""
    program = library.with_name(f"{source.stem}_{library.stem}.exe")
    target = hatch_build["TARGETS"][name]
    words = [*hatch_build["find_zig"](), "-target", target.triple, "-std=c17", f"-I{CORE}"]
    # what zig adds by itself asks for a newer musl than the library does
    words.append("-fno-sanitize=undefined")
    words += [*hatch_build["FOR_MODEL"][model], str(source), str(library), "-o", str(program)]
    if not name.endswith("windows"):  # where a library is looked for beside the program anyway
        words.append("-Wl,-rpath,$ORIGIN")
    subprocess.run(words, check=True)
    return program


def said_by(words, program):
    """Return what a program says, as lines."""
    quiet = os.environ | {"WINEDEBUG": "-all"}
    ended = subprocess.run(
        [*words, str(program)], check=True, capture_output=True, text=True, env=quiet,
        cwd=program.parent,
    )  # fmt: skip
    return ended.stdout.splitlines()


def read_macho(path, machine, tag):
    """Return what is wrong with a library for macOS; '' where its tag tells the truth."""
    held = path.read_bytes()
    magic, processor, _, kind, count = struct.unpack_from("<5I", held)
    if (magic, processor, kind) != (MACHO, PROCESSORS[machine], 6):
        return "it is no library for that processor"
    commands, place = {}, 32
    for _ in range(count):
        command, size = struct.unpack_from("<2I", held, place)
        commands[command] = place
        place += size
    if machine == "aarch64" and SEGMENT_OF_SIGNATURE not in commands:
        return "it is not signed, and macOS on ARM ends what loads it"
    (least,) = struct.unpack_from("<I", held, commands[BUILD_VERSION] + 12)
    asked = f"macosx_{least >> 16}_{least >> 8 & 0xFF}_"
    return "" if tag.startswith(asked) else f"it asks for {asked}, and the wheel says {tag}"


def read_elf(path, tag):
    """Return what is wrong with a library for Linux; '' where it asks for no newer glibc."""
    asked = [int(number) for number in re.findall(rb"GLIBC_2\.(\d+)", path.read_bytes())]
    allowed = re.match(r"manylinux_2_(\d+)_", tag)
    most = int(allowed[1]) if allowed else -1
    return "" if max(asked, default=-1) <= most else f"it asks for glibc 2.{max(asked)}, not {tag}"


def made_here(source, model, level, folder):
    """Return a program for this machine, linked with its core by the first compiler found."""
    library = identity["library_path"](CORE, level, model)
    program = folder / f"{source.stem}_{level}_{model}"
    words = [*hatch_build["find_compiler"](), "-std=c17", f"-I{CORE}", f"-Wl,-rpath,{CORE}"]
    words += [*hatch_build["FOR_MODEL"][model], str(source), str(library), "-o", str(program)]
    subprocess.run(words, check=True)
    return program


def check(name, wheels, folder, references):
    """Check a target; return how many of its libraries passed, and how many failed."""
    print(f"{name}:")
    target = hatch_build["TARGETS"][name]
    libraries(name, wheels, folder)
    words, why = runner(name)
    if words is None:
        print(f"  not run, for want of {why}")
    results = {"passed": 0, "failed": 0}
    for level, model in product(hatch_build["levels"](target), identity["MODELS"]):
        library = identity["library_path"](folder, level, model)
        source = folder / f"interface_{model}.c"
        source.write_text(interface(model), encoding="utf-8")
        linked(name, library, model, source)
        wrong = read_macho(library, target.machine, target.tag) if "macos" in name else ""
        if name.endswith(("linux", "musl")):
            wrong = read_elf(library, target.tag)
        if words is not None:
            lines = said_by(words, linked(name, library, model, BITS))
            pairs = zip(lines, references[model], strict=True)
            differ = [mine for mine, theirs in pairs if mine != theirs]
            wrong += f"{len(differ)} of {len(lines)} lines differ: {differ[0]}" if differ else ""
            if said_by(words, linked(name, library, model, EXERCISE)) != ["done"]:
                wrong += " an entry point does not end as it should"
            print(f"  {level}, {model}: {wrong or f'{len(lines)} lines, the same bits'}")
        elif wrong:
            print(f"  {level}, {model}: {wrong}")
        results["failed" if wrong else "passed"] += 1
    return results["passed"], results["failed"]


def main():
    """Check the targets that are asked for; return 1 where one is wrong."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    known = hatch_build["TARGETS"]
    parser.add_argument("targets", nargs="*", choices=[[], *known], metavar="TARGET")
    parser.add_argument("--wheels", type=Path, help="a folder with a wheel for each target")
    given = parser.parse_args()
    if hatch_build["find_zig"]() is None:
        print("0 passed, 0 failed: ziglang is not installed")
        return 0
    passed = failed = 0
    with tempfile.TemporaryDirectory() as folder:
        references = {
            model: said_by([], made_here(BITS, model, "baseline", Path(folder)))
            for model in identity["MODELS"]
        }
        for name in given.targets or known:
            place = Path(folder, name)
            place.mkdir()
            right, wrong = check(name, given.wheels, place, references)
            passed, failed = passed + right, failed + wrong
    print(f"{passed} passed, {failed} failed")
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
