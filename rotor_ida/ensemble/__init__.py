"""Many independent jobs on all cores: one way for everything that runs them.

Results come as they end. Only a few jobs are in flight at a time, so memory does not grow with
their number. When a job fails, or the user interrupts, the rest is given up at once.
"""

from rotor_ida.ensemble.choice import choose, count_workers
from rotor_ida.ensemble.jobs import Lost, Progress, Stop
from rotor_ida.ensemble.running import run_all

__all__ = ["Lost", "Progress", "Stop", "choose", "count_workers", "run_all"]
