"""Files without a seal, tried in a process of their own, which may crash, loop or grow.

Such are archives of format 1 and what another program has written or changed.
"""

from __future__ import annotations

import contextlib
import os
import subprocess
import sys
from pathlib import Path

from rotor_ida.errors import ArchiveError

READING_SPEED = 10e6  # bytes of a file per second of computing, a tenth of what is usual
PATIENCE = 2  # seconds of computing
LARGEST_GROWTH = 512 * 2**20  # bytes of memory

_REFUSED = 3


def refuse_what_cannot_be_read(source: Path, *, check: bool) -> None:
    """Read a file in another process, to its end if `check` is true.

    Raises
    ------
    ArchiveError
        If that process refuses the file, crashes, or takes too much time or memory.
    """
    if not sys.executable:
        return
    seconds = PATIENCE + int(source.stat().st_size / READING_SPEED)
    arguments = [str(source), "check" if check else "open", str(seconds)]
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join(path or "." for path in sys.path)}
    try:
        ended = subprocess.run(
            [sys.executable, "-P", "-m", __name__, *arguments],
            env=environment,
            capture_output=True,
            check=False,
            # On a busy machine the clock says nothing; elsewhere the processor's time is limited.
            timeout=60 + 10 * seconds if os.name == "nt" else None,
        )
    except subprocess.TimeoutExpired:
        raise ArchiveError(f"cannot read {source}: it takes too long") from None
    if ended.returncode == _REFUSED:
        raise ArchiveError(ended.stdout.decode(errors="replace"))
    if ended.returncode < 0:
        raise ArchiveError(
            f"{source} is damaged: the HDF5 library cannot read it to its end in the time and "
            "memory that it should take"
        )
    if ended.returncode > 0:
        last = ended.stderr.decode(errors="replace").strip().rpartition("\n")[2]
        raise ArchiveError(f"cannot read {source} in a process of its own: {last}")


def main(path: str, check: str, seconds: str) -> int:
    """Read a file within limits; print why it is refused."""
    from rotor_ida.storage.archive.reading import open_unguarded  # noqa: PLC0415 - it imports this module

    _limit(int(seconds))
    try:
        open_unguarded(Path(path), check=check == "check").close()
    except ArchiveError as error:
        sys.stdout.buffer.write(str(error).encode(errors="replace"))
        return _REFUSED
    return 0


def _limit(seconds: int) -> None:
    try:
        import resource  # noqa: PLC0415 - not on Windows
    except ImportError:
        return
    __import__("netCDF4")  # counted before the limits begin
    used = resource.getrusage(resource.RUSAGE_SELF)
    at_most = int(used.ru_utime + used.ru_stime) + 1 + seconds
    resource.setrlimit(resource.RLIMIT_CPU, (at_most, at_most))
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
    with contextlib.suppress(OSError):
        pages = int(Path("/proc/self/statm").read_text().split()[0])
        most = pages * resource.getpagesize() + LARGEST_GROWTH
        resource.setrlimit(resource.RLIMIT_AS, (most, most))


if __name__ == "__main__":
    raise SystemExit(main(*sys.argv[1:]))
