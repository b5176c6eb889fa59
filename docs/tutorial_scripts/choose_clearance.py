"""
Choose a clearance
==================

Find out which motion a machine settles on, how hard the disc hits the stator, and how both change with the clearance.

Open the notebook at the end of this page in Jupyter, or copy the blocks into ``python`` one by one (:doc:`/install`).

The machine
-----------

A disc of 4 kg with an unbalance eccentricity of 10 µm spins in a stator with a radial clearance of 20 µm. All values are in SI
units. The contact stiffness is that of a Hertz contact, force = k · depth^1.5.
"""

import math

from rotor_ida import DimensionalRotor

machine = DimensionalRotor(
    mass=4.0,  # kg
    contact_stiffness=3.2e7,  # N/m^1.5
    damping=89.1,  # N s/m
    eccentricity=10e-6,  # m
    clearance=20e-6,  # m
    speed=3000.0 * 2.0 * math.pi / 60.0,  # rad/s
)
machine.rotor()

# %%
# Three dimensionless numbers describe this rotor: the speed ω over a reference frequency of contact and mass, the damping
# ratio ζ, and the clearance δ₀ over the eccentricity. Every function takes such a rotor; ``machine`` converts back to SI units.
#
# Start from rest
# ---------------

from rotor_ida import contact_summary, dimensional, simulate
from rotor_ida.plot import plot_run

run = simulate(machine.rotor(), start=(0, 0, 0, 0), duration=80.0, samples=4001)
in_si = dimensional(run, machine, units={"length": "µm", "time": "ms"})
figure = plot_run(in_si)
figure

# %%
# Each contact entry and exit is a root of \|z\| = δ₀, not read from samples. The contacts are a table with their largest
# force and impulse:

columns = ["entry_time", "exit_time", "peak_force", "impulse"]
in_si[columns].to_dataframe()[columns].head()

# %%
summary = contact_summary(run)
print(f"contacts: {run.sizes['contact']}")
print(f"largest force: {float(summary.largest_force) * machine.force_scale:.2f} N")
print(f"events are timed to {float(in_si.event_time_error.max()):.1g} ms or better")

# %%
# All motions, their probability and force
# ----------------------------------------
#
# A run from rest is one start of many. ``touchdown_report`` takes 200 starts, here within 50 µm, and follows each until it settles.
# For each motion it returns the probability, the largest radius [m], the largest force [N], and more. (Contact-free whirls are
# a family with different centres, so they have no single radius.)

from rotor_ida import touchdown_report

report = touchdown_report(machine, x=(-50e-6, 50e-6), y=(-50e-6, 50e-6), starts=200)
from rotor_ida.schema import RESPONSE

kinds = {number: word for word, number in RESPONSE.items()}
columns = ["fraction", "radius_max", "largest_force"]
table = report[columns].to_dataframe()[columns]
table.insert(0, "kind", [kinds[int(kind)] for kind in report.kind])
table

# %%
# Speeds of jumps
# ---------------
#
# The response curve is exact: all synchronous whirls, stable and unstable, with the folds where the rotor jumps during a run-up or
# run-down. A rotor may also settle on a limit cycle on which it bounces: see :doc:`basins_and_branches`.

from rotor_ida import folds
from rotor_ida.closed_forms import response_curve
from rotor_ida.plot import panels, plot_amplitude

rotor = machine.rotor()
curve = response_curve(zeta=rotor.zeta, delta0=rotor.delta0, limits=(0.05, 4.0))
figure, (ax,) = panels(1, 1, width=6.4, height=3.6)
plot_amplitude(curve, ax=ax)
figure

# %%
to_rpm = machine.reference_frequency * 60.0 / (2.0 * math.pi)
speeds = folds(zeta=rotor.zeta, delta0=rotor.delta0).fold_omega.values.ravel() * to_rpm
print("folds at", ", ".join(f"{speed:.1f} rpm" for speed in speeds))

# %%
# Compare clearances
# ------------------
#
# The same machine with other clearances, from rest: steady state, largest radius and largest force.

import numpy as np

from rotor_ida import sweep
from rotor_ida.model.contact import contact_force

clearances = np.array([0.0, 5.0, 10.0, 15.0, 20.0, 30.0])  # µm
found = sweep(omega=rotor.omega, zeta=rotor.zeta, delta0=clearances * 1e-6 / machine.eccentricity)
for number, clearance in enumerate(clearances):
    settled = found.isel(delta0=number).squeeze()
    farthest = float(settled.radius_max)
    radius = 1e6 * farthest * machine.length_scale
    force = float(contact_force(farthest, float(settled.delta0))) * machine.force_scale
    kind = kinds[int(settled.response)]
    print(
        f"{clearance:4.0f} µm: {kind:13s} radius up to {radius:5.1f} µm, force up to {force:.2f} N"
    )

# %%
# More clearance does not always mean less force: at this speed a small clearance makes a rotor bounce that would whirl steadily
# without one. Compare both columns over all speeds of the machine. Check candidates with ``touchdown_report``, since a start from rest is only
# one of many.


# %%
# Next
# ----
#
# - Move the sliders yourself: ``pip install '.[explore]'``, then ``rotor-ida explore`` (:doc:`/explorer`).
# - The same on the command line: ``rotor-ida touchdown --help`` (:doc:`/command_line`).
# - All attractors over speed and clearance: :doc:`/basins`.
