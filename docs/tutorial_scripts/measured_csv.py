"""
Analyse a measured CSV file
===========================

Read the signals of two probes and a keyphasor from a CSV file, and find out whether the rotor rubs, at which speeds, and
which way it whirls. You get a Bode plot, a cascade and the whirl ratio.

Open the notebook at the end of this page in Jupyter, or copy the blocks into ``python`` one by one (:doc:`/install`).

The file
--------

The file is made here, so that the correct answers are known. A machine of 4 kg with a shaft of 50,000 N/m runs up from 300 to 2500 rpm.
Its unbalance eccentricity is 10 µm and its radial clearance 25 µm. Two probes at 45° and 135° measure it with noise of half a
micrometre. A keyphasor gives one pulse a revolution.
"""

import tempfile
from pathlib import Path

import numpy as np

from rotor_ida import DimensionalRotor, dimensional, run_up

machine = DimensionalRotor(
    mass=4.0,  # kg
    contact_stiffness=3.2e7,  # N/m^1.5
    damping=89.1,  # N s/m
    eccentricity=10e-6,  # m
    clearance=25e-6,  # m
    speed=31.416,  # rad/s: 300 rpm
    shaft_stiffness=5e4,  # N/m
)
rpm = 2 * np.pi / 60
run = run_up(machine, to=2500 * rpm, rate=200 * rpm, samples=55_001)
run = dimensional(run, units={"length": "µm"})

noise = 0.5 * np.random.default_rng(1).normal(size=(2, run.sizes["t"]))
towards = np.exp(-1j * np.pi / 4) * (run.x + 1j * run.y).values
pulse = run.angle.values % (2 * np.pi) < 0.3
table = np.stack([run.t, towards.real + noise[0], towards.imag + noise[1], pulse], axis=1)
file = Path(tempfile.mkdtemp()) / "probes.csv"
np.savetxt(file, table, "%.6f", ",", header="time,probe A,probe B,tacho", comments="")
print(file.read_text()[:120])

# %%
# Read it
# -------
#
# Name the columns, their units, and the angles of the probes. The attribute ``columns`` shows which columns were
# taken.

from rotor_ida import read_signals

signals = read_signals(
    file,
    columns={"t": "time", "x": "probe A", "y": "probe B", "keyphasor": "tacho"},
    units={"t": "s", "x": "um", "y": "um"},
    probe_angles=(45, 135),
)
print(signals.attrs["columns"])

# %%
# Amplitude and phase over the speed
# ----------------------------------
#
# ``orders`` tracks chosen orders of the speed in windows of whole revolutions. The Bode plot shows order 1. Beneath it is
# the exact response of the machine, which you have if you know its data.

from rotor_ida import orders
from rotor_ida.closed_forms import response_curve
from rotor_ida.plot import plot_bode

tracked = orders(signals, [1, 2], revolutions=4)
rotor = machine.rotor()
to_omega = np.pi / 30 / machine.reference_frequency
exact = response_curve(
    zeta=rotor.zeta,
    delta0=rotor.delta0,
    shaft_stiffness=rotor.shaft_stiffness,
    limits=(300 * to_omega, 2500 * to_omega),
)
amplitude, phase = plot_bode(
    tracked, beneath=dimensional(exact, machine, units={"length": "µm", "speed": "rpm"})
).axes
figure = amplitude.figure
figure

# %%
# The amplitude follows the exact curve past the clearance and keeps growing: the rotor rubs up to the last speed. The curve also
# shows a small whirl without contact at high speeds, but the rotor stays on the large one. The largest amplitude, and where it
# exceeds the clearance:

once = tracked.sel(order=1).forward_whirl_amplitude
top = int(np.argmax(once.values))
rpm = tracked.speed.values * 30 / np.pi
print(f"largest amplitude {float(once[top]):.1f} um at {rpm[top]:.0f} rpm")
rubbing = rpm[once.values > 1e6 * machine.clearance]
print(f"larger than the clearance from {rubbing.min():.0f} to {rubbing.max():.0f} rpm")

# %%
# Which way it whirls
# -------------------
#
# ``whirl_ratio`` is whirl speed over spin speed: 1 is a forward whirl at the spin speed, a negative value a backward
# whirl. During the rub it stays at 1: this is a synchronous rub, not dry whip.

from rotor_ida import whirl_ratio

whirl = whirl_ratio(signals, revolutions=4)
in_rub = np.isin(np.arange(whirl.sizes["window"]), np.flatnonzero(once.values > 25))
ratio = whirl.whirl_over_spin.values[in_rub]
print(f"whirl over spin during the rub: {ratio.min():.2f} to {ratio.max():.2f}")

# %%
# Other lines
# -----------
#
# A cascade shows full spectra over the speed, backward whirl on the left and forward whirl on the right. A synchronous rub
# shows 1X only.

from rotor_ida.plot import plot_cascade

figure = plot_cascade(signals).figure
figure

# %%
# Next
# ----
#
# - Compare with the pictures of other rubs: :doc:`/signatures`.
# - Fit damping, clearance or stiffness to this file: :doc:`/fit`.
# - All functions for signals: :doc:`/signals`. On the command line:
#   ``rotor-ida plot probes.csv --kind bode --probe-angles 45 135 --units t=s x=um y=um``.
