"""The command by which this process was started, as far as it helps to repeat it elsewhere."""

from __future__ import annotations

import re
import shlex
import sys
from collections.abc import Sequence
from pathlib import PurePath

# The folder part of an absolute path, also behind --option=; it means nothing on another machine.
_FOLDERS = re.compile(r"^(--?[\w-]+=)?(?:[/~]|[A-Za-z]:[\\/]).*[\\/](?=[^\\/])")


def command() -> str:
    """Return the script or program that runs, with its arguments, without folders.

    Returns
    -------
    str
        As for a shell; in words where nothing could be typed again.

    Examples
    --------
    >>> isinstance(command(), str)
    True
    """
    spec = getattr(sys.modules.get("__main__"), "__spec__", None)
    return described(sys.argv, module=spec.name if spec else "")


def described(arguments: Sequence[str], *, module: str = "") -> str:
    """Return a command line without what only this machine knows.

    Parameters
    ----------
    arguments : sequence of str
        As in ``sys.argv``.
    module : str
        Name of the module that ``python -m`` runs; empty for a script.

    Examples
    --------
    >>> described(["/home/me/bin/rotor-ida", "simulate", "--omega", "2", "--out=/tmp/run.nc"])
    'rotor-ida simulate --omega 2 --out=run.nc'
    >>> described(["/usr/lib/study/__main__.py", "--quick"], module="study.__main__")
    'python -m study --quick'
    >>> described([""]), described(["/lib/ipykernel_launcher.py", "-f", "kernel.json"])
    ('interactive Python', 'a notebook')
    """
    program, *rest = arguments or [""]
    name = PurePath(program).name
    if "ipykernel" in name or module.startswith("ipykernel"):
        return "a notebook"
    if not name:
        return "interactive Python"
    if name in {"-", "-c"}:
        return f"python {name}"
    started = ["python", "-m", module.removesuffix(".__main__")] if module else [name]
    shown = shlex.join([*started, *(_FOLDERS.sub(r"\1", word) for word in rest)])
    # Arguments may be bytes that are no text, which an attribute cannot hold.
    return shown.encode("utf-8", "backslashreplace").decode().replace("\n", " ")
