"""One disc for the panels of the explorer: its run, its answers, and the code that repeats them."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt
import xarray as xr

from rotor_ida.checks import COMPONENTS
from rotor_ida.explorer.endings import (
    LAST,
    Values,
    ending_of,
    events_in,
    revolutions_in,
    samples_per_revolution,
)
from rotor_ida.explorer.messages import Answer, Question
from rotor_ida.model.equations import rotated
from rotor_ida.model.rotor import DimensionalRotor, Rotor
from rotor_ida.model.rotor_system import RotorSystem
from rotor_ida.results.question import Question as Asked
from rotor_ida.results.question import written
from rotor_ida.results.si_units import dimensional, scales_of
from rotor_ida.schema import DAMPED_EVENT_KIND, MODE
from rotor_ida.signals.forces import power_in_contact
from rotor_ida.simulation.options import Method
from rotor_ida.simulation.simulate import simulate

FloatArray = npt.NDArray[np.float64]

METHOD: Method = "taylor"
# A disc that rolls on the stator may whirl many times in a revolution: samples per whirl for a
# smooth curve, and the largest number of samples in all.
PER_WHIRL, MOST_SAMPLES_OF_WHIRLS = 32, 65_536
OF_ENDING = ("t", "x", "y", "vx", "vy", "mode", "slip_speed")
LINES = '''\
"""The run that the explorer showed: its archive and its figure."""

from rotor_ida import {rotor}, save, simulate
from rotor_ida.plot import save_figure
from rotor_ida.plot.figures import figure_of

machine = {machine}
run = {call}
save(run, "run.nc", overwrite=True)
save_figure(figure_of(run), "run", overwrite=True)
'''


@dataclass(frozen=True)
class Disc:
    """The disc of a question; a `Node` has the same methods."""

    question: Question
    changes_speed = False

    @property
    def rotor(self) -> Rotor:
        """The rotor without dimensions."""
        return self.question.rotor

    @property
    def speed(self) -> float:
        """Spin speed [dimensionless]."""
        return self.rotor.omega

    @property
    def scales(self) -> dict[str, float]:
        """The scales of a machine; none of a rotor without dimensions."""
        machine = self.question.machine
        return {} if isinstance(machine, Rotor) else scales_of(machine)

    @property
    def facts(self) -> dict[str, Any]:
        """The facts about the rotor in an answer."""
        return {"rotor": self.rotor.given, "scales": self.scales, "start": self.question.start}

    @property
    def linear(self) -> tuple[RotorSystem, tuple[float, float], list[str]]:
        """The disc as a system without contact, the speeds shown, and notes."""
        return self.rotor.system(), self.question.speeds, []

    def begin(self) -> Iterator[Answer]:
        """Yield nothing: a disc has no sketch."""
        yield from ()

    def beside(self, _run: xr.Dataset, motion: Answer) -> Iterator[Answer]:
        """Yield the panels of the run alone: on what it settles takes longer."""
        yield motion

    def run(self) -> xr.Dataset:
        """Return the run that is drawn and saved."""
        revolutions = self.question.revolutions
        run = self._sampled(each := samples_per_revolution(revolutions))
        finer = min(
            math.ceil(PER_WHIRL * whirls_per_revolution(values_of(run), self.speed)),
            MOST_SAMPLES_OF_WHIRLS // revolutions,
        )
        return run if finer <= each else self._sampled(finer)

    def _sampled(self, each: int) -> xr.Dataset:
        """Return the run with this many samples per revolution, and the first sample."""
        return simulate(
            self.rotor, start=self.question.start, duration=self.duration,
            samples=each * self.question.revolutions + 1, method=METHOD,
        )  # fmt: skip

    @property
    def duration(self) -> float:
        """The length of the run [dimensionless]."""
        return self.question.revolutions * 2.0 * math.pi / (self.speed or 1.0)

    def seen(self, run: xr.Dataset) -> Values:
        """Return the values of a run by name, with the contact force."""
        return forced(run, self.rotor)

    def probed(self, run: xr.Dataset) -> xr.Dataset:
        """Return the run as probes record it."""
        return run

    def told(self, values: Values) -> dict[str, object]:
        """Return the numbers of the last half of a run, and the state from which it goes on."""
        end = rotated(states_of(values)[-1], -self.speed * values["t"][-1])
        return {"ending": ending(values, self.rotor), "end": end.tolist()}

    def saved(self) -> xr.Dataset:
        """Return the run that is saved; of a machine in SI units."""
        run, machine = self.run(), self.question.machine
        return dimensional(run, machine) if isinstance(machine, DimensionalRotor) else run

    @property
    def asked(self) -> Asked:
        """The question whose answer is the run shown, of a machine in SI units."""
        machine, start = self.question.machine, np.array(self.question.start)
        duration = self.duration
        if isinstance(machine, DimensionalRotor):
            length, velocity = machine.length_scale, machine.velocity_scale
            start = start * (length, length, velocity, velocity)
            duration *= machine.time_scale
        return Asked("simulate", {
            "rotor": machine, "start": start, "duration": duration,
            "samples": self.run().sizes["t"], "method": METHOD,
        })  # fmt: skip

    def lines(self) -> str:
        """Return the Python script that reproduces archive and figure.

        Examples
        --------
        >>> from rotor_ida.explorer.workers import example
        >>> print(Disc(example("py", omega=1.7)).lines().splitlines()[6])
        machine = Rotor(omega=1.7, zeta=0.07, delta0=2.0)
        """
        machine = self.question.machine
        return LINES.format(rotor=type(machine).__name__, machine=written(machine),
                            call=self.asked.python("machine"))  # fmt: skip

    def command(self) -> str:
        """Return the command line that reproduces archive and figure, for a machine in SI units.

        Examples
        --------
        >>> from rotor_ida.explorer.workers import example
        >>> Disc(example("sh", omega=1.7)).command().partition(" --start")[0]
        'rotor-ida simulate --omega 1.7 --zeta 0.07 --delta0 2.0'
        """
        return f"{self.asked.command()} --out run.nc --figure run"


def whirls_per_revolution(run: Values, omega: float) -> float:
    """Return the largest number of backward whirls in a revolution.

    For a disc with friction only, which may roll; over the last half of the run.
    """
    late = run["t"] >= LAST * run["t"][-1]
    if "mode" not in run or omega == 0.0:
        return 0.0
    held = late & (run["mode"] != MODE["flight"])
    x, y, vx, vy = (run[name][held] for name in COMPONENTS)
    rate = np.abs(x * vy - y * vx) / (x**2 + y**2)
    return float(rate.max(initial=0.0)) / omega


def values_of(run: xr.Dataset) -> Values:
    """Return the values of a run by name, without labels: a slider needs a fast answer."""
    return {str(name): variable.values for name, variable in run.variables.items()}


def states_of(run: Values) -> FloatArray:
    """Return the states of a run."""
    return np.stack([run[name] for name in COMPONENTS], axis=-1)


def forced(run: xr.Dataset, rotor: Rotor) -> Values:
    """Return the values of a run of one disc, with the contact force."""
    values = values_of(run)
    return values | {"force": power_in_contact(values, rotor).normal_force}


def ending(run: Values, rotor: Rotor) -> dict[str, float]:
    """Summarize the last half of a run of one disc: see `ending_of`.

    With contact damping, add the mean energy loss of contacts that end there, the loss per
    revolution, and how often the force falls to zero before the rotor leaves the stator; with
    friction the heat.
    """
    found = ending_of(run, rotor.omega)
    begin = LAST * float(run["t"][-1])
    late = {name: run[name][run["t"] >= begin] for name in OF_ENDING if name in run}
    power = power_in_contact(late, rotor)
    revolutions = revolutions_in(run, rotor.omega)

    def per_revolution(rate: FloatArray) -> float:
        # over whole periods of a periodic motion it is as exact as the samples
        return float(np.trapezoid(rate, late["t"])) / revolutions if revolutions else math.nan

    if rotor.contact_damping > 0.0:
        losses = run["contact_loss"][run["exit_time"] >= begin]
        found["loss_per_contact"] = float(losses.mean()) if losses.size else math.nan
        found["releases"] = events_in(run, DAMPED_EVENT_KIND["release"])
        found["loss_per_revolution"] = per_revolution(power.damping)
    if rotor.friction > 0.0:
        found["heat_per_revolution"] = per_revolution(power.friction)
    return found
