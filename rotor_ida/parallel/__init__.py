"""Run many independent jobs on all cores.

Results arrive as jobs end. Only a few jobs are in progress at a time, so memory does not grow with
their number. If a job fails or the user interrupts, the rest are cancelled at once.
"""

from rotor_ida.arrays import Stop
from rotor_ida.parallel.executors import Workers, choose, count_workers, run_all
from rotor_ida.parallel.interruptible import interruptible, percentage, run_with_progress
from rotor_ida.parallel.jobs import FailedJob, Progress, shows_progress

__all__ = [
    "FailedJob",
    "Progress",
    "Stop",
    "Workers",
    "choose",
    "count_workers",
    "interruptible",
    "percentage",
    "run_all",
    "run_with_progress",
    "shows_progress",
]
