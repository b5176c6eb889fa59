r"""
Through resonance, for an engineer
==================================

A machine has to pass its critical speed on the way to where it works. Does the rotor touch its ring on
the way up, at which speed, and how hard? How far above the critical speed does it come off again? Is the
motor strong enough to bring it through? Five minutes, from a data sheet to the answers.

You need Python 3.11 or newer and two lines in a shell::

    python3 -m venv .venv
    .venv/bin/pip install . jupyterlab

in a clone of the repository; from the first release on, ``rotor-ida`` in place of the dot will do. Then open the notebook at the end of
this page with ``.venv/bin/jupyter lab``; or start ``.venv/bin/python`` and copy the blocks one by one. Where a
block ends with a figure, a notebook shows it; at the prompt of Python, save it: ``figure.savefig("name.png")``.

The data sheet
--------------

A rotor of 8 kg sits on a shaft of 2 N/µm, with its centre of mass 20 µm off. A snubber ring of bronze on
springs of 4 N/µm leaves it 60 µm of clearance; the shaft runs in it with a radius of 50 mm and a coefficient of
friction of 0.05. It starts at 1500 rpm and works at 10,000 rpm.
"""

import math

import numpy as np

from rotor_ida import DimensionalRotor, dimensional, folds, run_up

rpm = math.pi / 30  # rad/s
machine = DimensionalRotor(
    mass=8.0,  # kg
    shaft_stiffness=2e6,  # N/m
    damping=400.0,  # N s/m
    eccentricity=20e-6,  # m
    clearance=60e-6,  # m
    contact_stiffness=4e6,  # N/m, as the exponent is 1:
    contact_exponent=1.0,  # a linear spring
    friction=0.05,
    disc_radius=0.05,  # m
    speed=1500 * rpm,  # rad/s
)
critical = math.sqrt(machine.shaft_stiffness / machine.mass) / rpm
free = machine.eccentricity * critical * rpm * machine.mass / machine.damping
print(f"critical speed of the shaft {critical:.0f} rpm")
print(f"radius of the whirl there, without a ring: {1e6 * free:.0f} µm")

# %%
# Held at its critical speed it would whirl far beyond the clearance. So it touches if it is slow enough;
# but nobody stays there, and the whirl takes time to grow.
#
# The way up
# ----------
#
# The drive takes it up by 3000 rpm in each second. ``change_of_speed`` turns that into what ``run_up`` takes,
# ``dimensional`` leads back: times in seconds, speeds in rpm, lengths in micrometres.

rotor = machine.rotor()
rest = (0, 0, 0, 0)


def up_to_speed(rate):
    """Run the machine up at a rate in rpm/s."""
    change = machine.change_of_speed(to=10_000, rate=rate, unit="rpm")
    run = run_up(rotor, start=rest, samples=6001, **change)
    return dimensional(run, machine, units={"speed": "rpm", "length": "µm"})


run = up_to_speed(3000)
speeds = run.event_speed.values
print(
    f"{run.sizes['contact']} contacts, {float(run.t[-1]):.1f} s, {float(run.revolutions):.0f} revolutions"
)
print(f"first touch at {speeds[0]:.0f} rpm, last lift off at {speeds[-1]:.0f} rpm")
print(f"largest force {float(run.peak_force.max()):.0f} N")
print(f"largest radius {float(np.hypot(run.x, run.y).max()):.0f} µm")
print(f"events are timed to {float(run.event_time_error.max()):.1g} s or better")

# %%
# It touches below the critical speed, and then does not come off when that is passed: the ring is a spring
# too. Shaft and ring together have a resonance much higher, and the rotor rides up to it.
#
# Where it has to come off
# ------------------------
#
# The whirl on which it rides is known exactly at every speed, and so is where it ends: at a fold. The curve
# below is what the rotor would settle on if it were held at each speed, the line is what it does on the
# way up.

from rotor_ida.closed_forms import response_curve
from rotor_ida.plot import panels, style

of_whirls = {
    "zeta": rotor.zeta,
    "delta0": rotor.delta0,
    "shaft_stiffness": rotor.shaft_stiffness,
    "contact_exponent": rotor.contact_exponent,
    "friction": rotor.friction,
}
to_rpm = machine.reference_frequency / rpm
to_microns = 1e6 * machine.length_scale
curve = response_curve(**of_whirls, limits=(1500 / to_rpm, 10_000 / to_rpm))
fold = to_rpm * float(folds(**of_whirls).fold_omega.max())
print(f"the whirl on the ring ends at {fold:.0f} rpm")


def draw_whirls(ax):
    """Draw the radius of every whirl, solid where it is stable."""
    omega, radius, piece = (curve[name].values.ravel() for name in ("omega", "amplitude", "piece"))
    stable = curve.stability.values.ravel() == 0
    breaks = np.flatnonzero(np.diff(piece) | np.diff(stable)) + 1
    for part in np.split(np.arange(omega.size), breaks):
        line = "-" if stable[part[0]] else "--"
        ax.plot(to_rpm * omega[part], to_microns * radius[part], "k" + line, lw=1.0)
    ax.axhline(1e6 * machine.clearance, color="0.5", lw=0.8, ls=":")
    ax.text(1600, 1e6 * machine.clearance + 3, "ring", color="0.4")
    ax.plot([], [], "k-", lw=1.0, label="exact whirl, at a speed that is held")
    ax.plot([], [], "k--", lw=1.0, label="unstable")


with style():
    figure, (ax,) = panels(1, 1, width=6.6, height=3.6)
    draw_whirls(ax)
    ax.plot(
        run.speed,
        np.hypot(run.x, run.y),
        color="#bd1f01",
        lw=1.0,
        label="on the way up, 3000 rpm/s",
    )
    ax.plot(
        speeds[[0, -1]], [60, 60], "o", color="#bd1f01", ms=4, label="first touch, last lift off"
    )
    ax.axvline(fold, color="0.5", lw=0.8)
    ax.text(fold - 80, 8, "fold", color="0.4", ha="right")
    ax.set(xlabel="speed [rpm]", ylabel="radius [µm]", xlim=(1500, 10_000), ylim=(0, 250))
    ax.legend(loc="upper left")
figure

# %%
# The rotor comes off late: it has passed the end of the whirl before it begins to fall, and needs some
# revolutions for it. How late depends on the rate.
#
# Faster, or slower?
# ------------------

print("   rate    first touch     lift off   beyond the fold   largest force   in contact")
for rate in (2000, 4000, 8000, 16_000):
    run_at = up_to_speed(rate)
    first, last = run_at.event_speed.values[[0, -1]]
    touching = float((run_at.exit_time - run_at.entry_time).sum())
    force = float(run_at.peak_force.max())
    print(f"{rate:6d} rpm/s {first:7.0f} rpm {last:8.0f} rpm {last - fold:12.0f} rpm "
          f"{force:13.0f} N {touching:10.2f} s")  # fmt: skip

# %%
# A higher rate does not keep this rotor off the ring. It shortens the time in contact, and makes it come off
# at a higher speed. So plan the first speed at which anything is measured, or held, well above the fold.
#
# Is the motor strong enough?
# ---------------------------
#
# So far the drive gave whatever torque the ramp took. A motor does not: its torque falls with the speed. Riding
# on the ring costs torque, for the friction on the ring and for the damping of the whirl, and on the exact whirl
# both are known:

omega = curve.omega.values.ravel() * machine.reference_frequency
radius = curve.amplitude.values.ravel() * machine.length_scale
force = machine.contact_stiffness * np.maximum(radius - machine.clearance, 0.0)
needed = machine.damping * omega * radius**2 + machine.friction * force * (
    radius + machine.disc_radius
)
print(
    f"the most that it needs: {np.nanmax(needed):.2f} N m, at {omega[np.nanargmax(needed)] / rpm:.0f} rpm"
)

# %%
# Two motors are offered, with 3 and with 6 N m at rest, both falling evenly to nothing at 12,000 rpm. All that
# turns has a moment of inertia of 0.01 kg m².

no_load = 12_000 * rpm
driven = {}
for stall in (3.0, 6.0):
    change = machine.change_of_speed(torque=(stall, stall / no_load), inertia=0.01, duration=12.0)
    run = run_up(rotor, start=rest, samples=1001, **change)
    driven[stall] = dimensional(run, machine, units={"speed": "rpm"})
    last = driven[stall].speed.values[-1]
    touching = driven[stall].event_kind.values[-1] > 0  # the last event is an entry, and no exit
    print(f"{stall:.0f} N m: {last:.0f} rpm after 12 s, {'on the ring' if touching else 'free'}, "
          f"largest force {float(driven[stall].peak_force.max()):.0f} N")  # fmt: skip

# %%
stable = curve.stability.values.ravel() == 0
with style():
    figure, (first, second) = panels(1, 2, width=7.2, height=3.3, shared=False)
    first.plot(
        omega / rpm, np.where(stable, needed, np.nan), "k-", lw=1.2, label="needed on the whirl"
    )
    for (stall, run), colour in zip(driven.items(), ("#bd1f01", "#1f6fb8"), strict=True):
        ends = np.array([1500, 10_000])
        first.plot(ends, stall * (1 - ends / 12_000), color=colour, lw=1.0)
        first.text(1650, 0.875 * stall + 0.12, f"motor of {stall:.0f} N m", color=colour)
        second.plot(run.t, run.speed, color=colour, lw=1.2, label=f"motor of {stall:.0f} N m")
    second.axhline(fold, color="0.5", lw=0.8)
    second.text(11.8, fold + 130, "fold", color="0.4", ha="right")
    first.set(xlabel="speed [rpm]", ylabel="torque [N m]", xlim=(1500, 10_000), ylim=(0, 6))
    second.set(xlabel="time [s]", ylabel="speed [rpm]", xlim=(0, 12), ylim=(1000, 13_000))
    first.legend(loc="upper right")
    second.legend(loc="lower right")
figure

# %%
# The weaker motor has torque enough at every speed at which the rotor is free, and still gets stuck: its line meets
# the curve below the fold, and there it stays, with the rotor on the ring. That is Sommerfeld's effect with rub. The
# stronger one has torque left all the way, and once the rotor has come off the ring all of it goes into speed.
# Where the curves meet is known without any simulation:

for stall in driven:
    left = stall * (1 - omega / no_load) - needed
    meets = stable & (force > 0.0) & (left < 0.0)
    where = f"stays at about {omega[meets].min() / rpm:.0f} rpm" if meets.any() else "comes through"
    print(f"motor of {stall:.0f} N m: {where}")

# %%
# Where to go on
# --------------
#
# - What a run-up computes, and how it was checked: :doc:`/run_up`.
# - Run it up by a button, and see it fall off the curve: ``rotor-ida explore`` (:doc:`/explorer`).
# - More friction may throw a disc into dry whip, backwards: :doc:`/rub`.
# - The same from the shell, in rpm: ``rotor-ida run-up --help`` (:doc:`/command_line`).
