"""Compile the core: all C sources of rotor_ida/core, one shared library for each level.

hatchling calls it when a wheel or an editable installation is built. By hand:

    python hatch_build.py [--compiler CC] [--sanitize] [--warnings] [--target NAME] [--out FOLDER]

The compiler is $CC or the first of cc, gcc and clang. Where there is none, the build asks for the
package ziglang, which holds one. CFLAGS are not read: the flags belong to the arithmetic.

With the packages build, hatchling and ziglang the first of these makes the wheels of all targets,
and the second that of one:

    python hatch_build.py --all [--out FOLDER]
    ROTOR_IDA_TARGET=x86_64-windows python -m build --wheel
"""

from __future__ import annotations

import argparse
import ctypes
import importlib.util
import json
import os
import platform
import re
import shlex
import shutil
import subprocess
import sys
import sysconfig
import tempfile
import tomllib
from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from functools import partial
from itertools import product
from pathlib import Path
from runpy import run_path
from typing import Any, NamedTuple

try:
    from hatchling.builders.hooks.plugin.interface import BuildHookInterface
except ImportError:  # called by hand, where nothing is packed
    BuildHookInterface = object

ROOT = Path(__file__).resolve().parent
CORE = ROOT / "rotor_ida" / "core"
identity = run_path(str(CORE / "identity.py"))

# No compiler may regroup or contract: the sources say what is fused. Nor may it know the functions
# of core/libm.c: it would put others in their place.
FLAGS = (
    *("-std=c17", "-O3", "-g0", "-fPIC", "-fvisibility=hidden"),
    *("-fno-math-errno", "-fno-trapping-math", "-ffp-contract=off"),
    *(f"-fno-builtin-{name}" for name in ("sin", "cos", "exp", "expm1", "log", "log1p")),
)
# Vectors are passed between functions of one file only, so their place in the ABI is no matter.
WARNINGS = ("-Wall", "-Wextra", "-Wconversion", "-Werror", "-Wno-psabi")
# Functions that are always inlined, for speed, would take most of the time to compile.
NO_INLINING = "-Dalways_inline="
SANITIZE = (NO_INLINING, "-g1", "-O0", "-fsanitize=address,undefined", "-fno-sanitize-recover=all")
# By level: what gcc and clang are told, and zig, which compiles for this very machine unless told.
# The baseline is for processors of before 2013. There -O3 gains 3 % and takes twice as long.
FOR_LEVEL = {
    "baseline": (("-march=x86-64", "-O2"), ("-mcpu=x86_64",)),
    "v3": (("-march=x86-64-v3",), ("-mcpu=x86_64_v3",)),
    "v4": (
        ("-march=x86-64-v4", "-mprefer-vector-width=512"),
        ("-mcpu=x86_64_v4", "-mprefer-vector-width=512"),
    ),
}
FOR_MODEL = {"paper": (), "whole": ("-DWHOLE_MODEL",), "run_up": ("-DWHOLE_MODEL", "-DRUN_UP")}
# What $ROTOR_IDA_TARGET may name; or a package of plain Python, for any platform.
TARGET, NO_CORE = "ROTOR_IDA_TARGET", "none"
# The extra is made up: an installer that cannot get the package says by it why it was asked for.
ZIG = "ziglang[no-c-compiler-on-path]>=0.13"
# The second numbers of the versions of glibc for which auditwheel knows a policy.
POLICIES = (17, 24, 26, 27, 28, 31, *range(34, 42))
SHOWN = 6  # lines of a compiler's complaint
# Processors by the names that other systems have for them.
SAME = {"AMD64": "x86_64", "arm64": "aarch64"}


class Target(NamedTuple):
    """A platform for which the core is compiled: its processor, zig's name, and that of wheels."""

    machine: str
    triple: str
    tag: str


TARGETS = {
    "x86_64-linux": Target("x86_64", "x86_64-linux-gnu.2.17", "manylinux_2_17_x86_64"),
    "aarch64-linux": Target("aarch64", "aarch64-linux-gnu.2.17", "manylinux_2_17_aarch64"),
    "x86_64-musl": Target("x86_64", "x86_64-linux-musl", "musllinux_1_2_x86_64"),
    "aarch64-musl": Target("aarch64", "aarch64-linux-musl", "musllinux_1_2_aarch64"),
    "x86_64-windows": Target("x86_64", "x86_64-windows-gnu", "win_amd64"),
    "x86_64-macos": Target("x86_64", "x86_64-macos.11.0", "macosx_11_0_x86_64"),
    "aarch64-macos": Target("aarch64", "aarch64-macos.11.0", "macosx_11_0_arm64"),
}


class BuildError(Exception):
    """The core cannot be compiled; the message says why in a sentence."""


def find_compiler() -> list[str] | None:
    """Return the words that call a C compiler: $CC, one on PATH, ziglang; None where none is."""
    if os.environ.get("CC", "").strip():
        try:
            # Windows has backslashes in its paths
            said = shlex.split(os.environ["CC"], posix=os.name == "posix")
            words = [word.strip('"') for word in said]
        except ValueError as error:
            raise BuildError(f"CC must name a C compiler, got {os.environ['CC']!r}") from error
        found = shutil.which(words[0])
        if found is None:
            raise BuildError(f"CC must name a C compiler, and {words[0]!r} cannot be found")
        if os.sep in words[0]:  # it is called in another folder
            words[0] = str(Path(found).absolute())
        return words
    # gcc on Windows is MinGW's, which misaligns vectors of 32 bytes
    for name in ("cc", "gcc", "clang") if os.name == "posix" else ():
        if found := shutil.which(name):
            return [found]
    return find_zig()


def find_zig() -> list[str] | None:
    """Return the words that call zig's compiler; None where there is none."""
    if importlib.util.find_spec("ziglang"):
        return [sys.executable, "-m", "ziglang", "cc"]
    return None


def is_zig(compiler: Sequence[str]) -> bool:
    """Return whether a compiler is zig's."""
    return any("zig" in Path(word).name for word in compiler)


def described(compiler: Sequence[str]) -> str:
    """Return the name and the version of a compiler in one line."""
    said = (_run(compiler, ["--version"]).splitlines() or ["unknown"])[0]
    return f"zig cc, {said}" if is_zig(compiler) else said


def target_of(name: str | None) -> Target:
    """Return the target of a name; without one it is this machine, with a wheel tagged later."""
    if name:
        if name not in TARGETS:
            raise BuildError(f"the target must be one of {', '.join(TARGETS)}, got {name!r}")
        return TARGETS[name]
    machine = SAME.get(platform.machine(), platform.machine())
    is_glibc = platform.libc_ver()[0] == "glibc"
    return Target(machine, f"{machine}-linux-gnu.2.17" if is_glibc else "", "")


def levels(target: Target | None = None) -> tuple[str, ...]:
    """Return the levels that are compiled for a target, by default this machine."""
    known: tuple[str, ...] = identity["LEVELS"]
    return known if (target or target_of(None)).machine == "x86_64" else known[:1]


def flags(
    compiler: Sequence[str], level: str, *, model: str = "paper", warnings: bool = False,
    sanitize: bool = False, target: Target | None = None,
) -> list[str]:  # fmt: skip
    """Return the flags with which the sources are compiled for a level and a model."""
    zig, target = is_zig(compiler), target or target_of(None)
    found = [*FLAGS, *FOR_MODEL[model]]
    if zig and target.triple:
        found += ["-target", target.triple]
    if target.machine == "x86_64":
        found += FOR_LEVEL[level][zig]
    elif zig:
        found += ["-mcpu=baseline"]
    return [*found, *(WARNINGS if warnings else ()), *(SANITIZE if sanitize else ())]


def build(
    compiler: Sequence[str], *, out: Path = CORE, warnings: bool = False, sanitize: bool = False,
    only: Sequence[str] | None = None, target: Target | None = None,
) -> list[Path]:  # fmt: skip
    """Compile the libraries that `out` lacks or holds in another state; return those made.

    Those of all levels, or of some `only`.
    """
    version = tomllib.loads((ROOT / "pyproject.toml").read_text("utf-8"))["project"]["version"]
    digest, told = identity["sources_digest"](CORE), described(compiler)
    target = target or target_of(None)
    wanted = {}
    for level, model in product(only or levels(target), identity["MODELS"]):
        given = flags(
            compiler, level, model=model, warnings=warnings, sanitize=sanitize, target=target
        )
        shown = {"compiler": told, "flags": " ".join(given), "level": level}
        shown |= {"model": model, "sources": digest, "version": version}
        path = identity["library_path"](out, level, model)
        if sanitize or _stated(path) != shown:
            wanted[path] = (given, shown)
    if not wanted:
        return []
    out.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory(dir=out, prefix=".build-") as name:
        folder = Path(name)
        commands, links = [], []
        for path, (given, shown) in wanted.items():
            sources = identity["model_sources"](CORE, shown["model"])
            macros = [f"-DCORE_{key.upper()}={json.dumps(text)}" for key, text in shown.items()]
            objects = []
            for source in sources:
                objects.append(str(folder / f"{source.stem}_{path.stem}.o"))
                # build.c alone says what is built
                more = macros if source.stem == "build" else []
                commands.append([*given, *more, "-c", source.name, "-o", objects[-1]])
            links.append([*given, "-shared", *objects, "-lm", "-o", str(folder / path.name)])
        with ThreadPoolExecutor(os.cpu_count()) as pool:
            for step in (commands, links):
                list(pool.map(partial(_run, compiler), step))
        for path in wanted:
            _put(folder / path.name, path)
    return list(wanted)


def _put(made: Path, path: Path) -> None:
    """Put a library in its place in one step: a program that has the old one loaded keeps it."""
    try:
        made.replace(path)
    except PermissionError:  # Windows lets a library in use be renamed, not replaced
        aside = Path(tempfile.mkdtemp(prefix="rotor-ida-old-"), path.name)
        shutil.move(path, aside)
        made.replace(path)


def platform_tag(libraries: Sequence[Path]) -> str:
    """Return the platform of a wheel with these libraries: by the newest glibc that they ask for.

    Where that is not glibc, it is this very platform. A Python for both processors of Macs names
    both, and the core is for one.
    """
    if system := platform.mac_ver()[0]:
        return f"macosx_{system.partition('.')[0]}_0_{platform.machine()}"
    if platform.libc_ver()[0] != "glibc":
        return re.sub(r"\W", "_", sysconfig.get_platform())
    asked = {
        int(n) for path in libraries for n in re.findall(rb"GLIBC_2\.(\d+)", path.read_bytes())
    }
    newest = max(asked, default=0)
    least = next((policy for policy in POLICIES if policy >= newest), newest)
    return f"manylinux_2_{least}_{platform.machine()}"


def _stated(path: Path) -> dict[str, str] | None:
    """Return what a library says of itself; None where it is not there or cannot be loaded."""
    try:
        if not identity["is_whole"](path):
            return None
        said: dict[str, str] = identity["stated"](ctypes.CDLL(str(path)))
    except (OSError, AttributeError):
        return None
    return said


def _run(compiler: Sequence[str], arguments: Sequence[str]) -> str:
    """Return what a compiler says, called where the sources are; complain where it fails."""
    named = shlex.join(compiler)
    try:
        ended = subprocess.run(
            [*compiler, *arguments], cwd=CORE, capture_output=True, text=True, check=False
        )
    except OSError as error:
        raise BuildError(f"the compiler {named} cannot be run: {error.strerror}") from error
    if ended.returncode:
        said = (ended.stderr or ended.stdout).strip().splitlines()[:SHOWN]
        raise BuildError("\n".join([f"the core cannot be compiled by {named}:", *said]))
    return ended.stdout


class CustomBuildHook(BuildHookInterface):
    """What hatchling calls: it asks for a compiler, and puts the libraries into the wheel."""

    def dependencies(self) -> list[str]:
        """Return the package of a C compiler where the machine has none for the target."""
        if os.environ.get(TARGET) == NO_CORE:
            return []
        try:
            if not os.environ.get(TARGET) and find_compiler() is not None:
                return []
        except BuildError:
            return []  # said when the core is compiled
        self.app.display_info("rotor-ida: no C compiler for this, so the build asks for ziglang")
        return [ZIG]

    def initialize(self, version: str, build_data: dict[str, Any]) -> None:  # noqa: ARG002
        """Compile the core and say which files and which platform the wheel has."""
        if os.environ.get(TARGET) == NO_CORE:
            return
        try:
            target = target_of(os.environ.get(TARGET))
            compiler = find_zig() if target.tag else find_compiler()
            if compiler is None:
                raise BuildError(
                    "no C compiler was found ($CC, or cc, gcc or clang on PATH): install one, or "
                    "the package ziglang (pip install ziglang), or set "
                    f"{TARGET}={NO_CORE} to do without the core"
                )
            folder = ROOT / "build" / "core" / target.triple if target.tag else CORE
            build(compiler, out=folder, target=target)
        except (BuildError, OSError) as error:
            self.app.abort(f"rotor-ida: {error}")
        made = [
            identity["library_path"](folder, level, model)
            for level, model in product(levels(target), identity["MODELS"])
        ]
        build_data["pure_python"] = False
        build_data["tag"] = f"py3-none-{target.tag or platform_tag(made)}"
        places = {str(path): (CORE / path.name).relative_to(ROOT).as_posix() for path in made}
        if target.tag:
            build_data["force_include"] |= places
        else:
            build_data["artifacts"] += [f"/{place}" for place in places.values()]


def build_wheels(out: Path) -> list[Path]:
    """Build the wheel of each target into a folder, and return them."""
    command = [sys.executable, "-m", "build", "--wheel", "--no-isolation"]
    command += ["--skip-dependency-check", "--outdir", str(out), str(ROOT)]
    for name in TARGETS:
        there = os.environ | {TARGET: name}
        subprocess.run(command, check=True, env=there, stdout=subprocess.DEVNULL)
    made = [next(out.glob(f"*-py3-none-{target.tag}.whl"), None) for target in TARGETS.values()]
    return [path for path in made if path]


def main() -> int:
    """Compile the core as asked on the command line; return 1 where that fails."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--compiler", metavar="CC", help="by default $CC, cc, gcc, clang, ziglang")
    parser.add_argument("--sanitize", action="store_true", help="check addresses, undefined things")
    parser.add_argument("--warnings", action="store_true", help="take warnings for errors")
    parser.add_argument("--target", metavar="NAME", help="by zig: " + ", ".join(TARGETS))
    parser.add_argument("--all", action="store_true", help="the wheels of all targets, into dist")
    parser.add_argument("--out", type=Path, metavar="FOLDER")
    given = parser.parse_args()
    if given.compiler:
        os.environ["CC"] = given.compiler
    try:
        if given.all:
            print(*build_wheels((given.out or ROOT / "dist").resolve()), sep="\n")
            return 0
        target = target_of(given.target)
        compiler = find_zig() if given.target else find_compiler()
        if compiler is None:
            what = "ziglang is not installed" if given.target else "no C compiler was found"
            raise BuildError(f"{what}: name one with --compiler")
        made = build(
            compiler, out=(given.out or CORE).resolve(), target=target,
            warnings=given.warnings, sanitize=given.sanitize,
        )  # fmt: skip
    except (BuildError, OSError, subprocess.CalledProcessError) as error:
        print(f"hatch_build.py: {error}", file=sys.stderr)
        return 1
    print(*(made or ["nothing to compile: all libraries are up to date"]), sep="\n")
    return 0


if __name__ == "__main__":
    sys.exit(main())
