"""
Five minutes for an engineer
============================

You have a machine: a disc of known mass in a ring with a clearance. You want to know which whirl you
will get, how hard the disc hits the ring, and which clearance to choose.

You need Python 3.11 or newer and two lines in a shell::

    python3 -m venv .venv
    .venv/bin/pip install . jupyterlab

in a clone of the repository; from the first release on, ``rotor-ida`` in place of the dot will do. Then open the notebook at the end of
this page with ``.venv/bin/jupyter lab``; or start ``.venv/bin/python`` and copy the blocks one by one. Where a
block ends with a figure, a notebook shows it; at the prompt of Python, save it: ``figure.savefig("name.png")``.

The machine
-----------

A disc of 4 kg whose centre of mass is 10 µm off its centre turns in a ring with 20 µm of clearance.
Everything is in SI units; the contact stiffness belongs to a Hertz contact, force = k · depth^1.5.
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
# Three dimensionless numbers say all about it: the speed ω over a reference frequency that the contact
# and the mass set, the damping ratio ζ, and the clearance δ₀ over the eccentricity. Every function takes
# such a rotor; ``machine`` knows how to lead back to SI units.
#
# What it does from rest
# ----------------------

from rotor_ida import contact_summary, dimensional, simulate
from rotor_ida.plot import plot_machine

run = simulate(machine.rotor(), start=(0, 0, 0, 0), duration=80.0, samples=4001)
in_si = dimensional(run, machine, units={"length": "µm", "time": "ms"})
figure = plot_machine(in_si)
figure

# %%
# Each entry into contact and each exit was found as a root of \|z\| = δ₀, not read off samples. So the
# contacts come as a table, with their largest force and what each takes from the disc:

columns = ["entry_time", "exit_time", "peak_force", "impulse"]
in_si[columns].to_dataframe()[columns].head()

# %%
summary = contact_summary(run)
print(f"contacts: {run.sizes['contact']}")
print(f"largest force: {float(summary.largest_force) * machine.force_scale:.2f} N")
print(f"events are timed to {float(in_si.event_time_error.max()):.1g} ms or better")

# %%
# Which whirl, how likely, how hard
# ---------------------------------
#
# A run from rest is one start of many. ``touchdown_report`` takes 200 starts, here anywhere within
# 50 µm, follows each to what it settles on, and says what that does to the machine: how likely it is, how far
# out it comes [m], the largest force [N], and much more. (Contact-free whirls come as a family, with centres
# anywhere they have room, so that they have no one radius.)

from rotor_ida import decode_flags, touchdown_report

report = touchdown_report(machine, x=(-50e-6, 50e-6), y=(-50e-6, 50e-6), starts=200)
columns = ["kind", "fraction", "radius_max", "largest_force"]
decode_flags(report)[columns].to_dataframe()[columns]

# %%
# At which speeds it jumps
# ------------------------
#
# The response curve is exact: all synchronous whirls, stable and not, with the folds where a rotor that
# is run up or down has to jump. A rotor may also settle on something that no curve shows, a limit cycle
# on which it bounces; the tutorial for researchers goes on there.

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
# Which clearance
# ---------------
#
# The same machine with other clearances, from rest: what it settles on, how far out it comes, and how
# hard it presses there on the ring.

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
    kind = decode_flags(settled.response).item()
    print(f"{clearance:4.0f} µm: {kind:13s} out to {radius:5.1f} µm, up to {force:.2f} N")

# %%
# More clearance is not less force, as the lines show: at this speed a little of it makes a rotor bounce that
# would whirl quietly without. Choose with both columns in view, over all the speeds that the machine goes
# through, and look at the candidates with ``touchdown_report``: a start from rest is only one.


# %%
# Where to go on
# --------------
#
# - Move the sliders yourself: ``pip install '.[explore]'``, then ``rotor-ida explore``
#   (:doc:`/explorer`).
# - The same from the shell: ``rotor-ida touchdown --help`` (:doc:`/command_line`).
# - All that attracts over speed and clearance: :doc:`/basins`.
