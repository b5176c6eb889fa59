"""Give a finished file its name in one step."""

from __future__ import annotations

import os
import time
from contextlib import suppress
from pathlib import Path

# Windows replaces no file that another process reads; readers of this package take a moment.
_READERS_HOLD = os.name == "nt"
_PAUSES = (0.01, 0.03, 0.1, 0.3, 1.0)  # seconds


def put(part: Path, target: Path) -> None:
    """Give a finished file its name, also where others read the file that it replaces."""
    for pause in _PAUSES if _READERS_HOLD else ():
        with suppress(PermissionError):
            part.replace(target)
            return
        time.sleep(pause)
    part.replace(target)
