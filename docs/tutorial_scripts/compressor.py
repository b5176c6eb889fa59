r"""
A compressor from ROSS, with oil films and labyrinths
=====================================================

Take a rotor that was built in ROSS, with its oil films and labyrinths as tables over the speed, and find out in ten minutes at which speed
it becomes unstable, and whether its labyrinths are wide enough. You end with a report in HTML and PDF. You need an installation
(:doc:`/install`), ROSS for the first step only, and five commands.

1. Read the rotor
-----------------

The rotor was saved in ROSS by ``rotor.save("compressor_ross.toml")``
(:download:`compressor_ross.toml </tutorial_scripts/compressor_ross.toml>`): a shaft of 1.3 m with three wheels, 153 kg, in two
oil films at nodes 1 and 5. A labyrinth seals the eye of the first wheel at node 2, another the balance piston at node 4. All four have
tables from 1,000 to 13,000 rpm. Turn it into a system file::

    rotor-ida from-ross compressor_ross.toml --out compressor.toml

Without ROSS take the files that this command has written,
:download:`compressor.toml </tutorial_scripts/compressor.toml>` and its matrices,
:download:`compressor.npz </tutorial_scripts/compressor.npz>`. ROSS knows neither the clearances of the labyrinths nor the residual
unbalance. Add them at the end of ``compressor.toml``:

.. code-block:: toml

    [[contacts]]                      # the labyrinth at the eye
    node = "2"
    clearance = "150 um"
    stiffness = "5e7 N/m"
    friction = 0.1
    radius = "110 mm"

    [[contacts]]                      # the balance piston
    node = "4"
    clearance = "120 um"
    stiffness = "5e7 N/m"
    friction = 0.1
    radius = "90 mm"

    [[unbalance]]
    node = "3"
    moment = "400 g mm"

In Python the same is
"""

from dataclasses import replace

import numpy as np

from rotor_ida import Contact, Unbalance, load_system

given = {"stiffness": 5e7, "exponent": 1.0, "friction": 0.1}
compressor = replace(
    load_system("compressor.toml"),
    contacts=[
        Contact(node="2", clearance=150e-6, radius=110e-3, **given),
        Contact(node="4", clearance=120e-6, radius=90e-3, **given),
    ],
    unbalance=[Unbalance(node="3", moment=400e-6)],  # kg m
)

# %%
# 2. Where is it stable?
# ----------------------
#
# A Campbell diagram with the coefficients at each speed::
#
#     rotor-ida campbell compressor.toml \
#         --speed 1000rpm:12000rpm:45 --modes 8 --figure campbell

from rotor_ida import campbell
from rotor_ida.plot import plot_campbell

rpm = np.pi / 30
modes = campbell(compressor, speed=np.linspace(1000, 12000, 45) * rpm, modes=8)
plot_campbell(modes)

# %%
# Circles on the dashed line are critical speeds; crosses are critical speeds damped too strongly to show a peak. Red circles are growing whirls. The slowest
# forward whirl grows, as the cross-coupled stiffness of films and labyrinths drives it. The speed at which this begins is the threshold of
# instability::
#
#     rotor-ida special-speeds compressor.toml \
#         --limits 7000rpm 12000rpm --points 40

from rotor_ida import special_speeds


def threshold(system):
    """Return the lowest unstable speed and its whirl speed, in rpm."""
    found = special_speeds(system, limits=(7000 * rpm, 12000 * rpm), points=40)
    return float(found.special_speed[0]) / rpm, float(found.whirl_speed[0]) / rpm


found = threshold(compressor)
print("unstable from {:,.0f} rpm on, with a whirl at {:,.0f} rpm".format(*found))

# %%
# The compressor runs at 7,500 to 9,000 rpm and trips at 9,900 rpm, so it is stable, with a small margin at the trip speed. If the cross-coupling of the
# balance piston doubles, as by wear, the threshold moves below the trip speed:

film, eye, piston, other_film = compressor.bearings
worn = replace(piston, stiffness=piston.stiffness * [[1.0, 2.0], [2.0, 1.0]])
worn_compressor = replace(compressor, bearings=[film, eye, worn, other_film])
found_worn = threshold(worn_compressor)
print("worn: unstable from {:,.0f} rpm on, with a whirl at {:,.0f} rpm".format(*found_worn))

# %%
# 3. How far does unbalance move it?
# ----------------------------------
#
# ::
#
#     rotor-ida synchronous-response compressor.toml \
#         --speed 1000rpm:9900rpm:90 --figure response

from rotor_ida import synchronous_response
from rotor_ida.plot.figures import figure_of

response = synchronous_response(compressor, speed=np.linspace(1000, 9900, 90) * rpm)
figure_of(response)

# %%
# The peak and its amplification factor, as API 684 measures it:

sharp = np.isfinite(response.amplification_factor.values)
for speed, factor in zip(
    response.peak_speed.values[sharp], response.amplification_factor.values[sharp], strict=True
):
    print(f"peak at {speed / rpm:,.0f} rpm, amplification factor {factor:.1f}")

# %%
# Two critical speeds, one along each principal direction of the films, merge into this one peak.
#
# 4. Are the labyrinths wide enough?
# ----------------------------------
#
# The clearance report compares the orbits with the clearances in the manner of API 617, in HTML and PDF::
#
#     rotor-ida clearance-report compressor.toml \
#         --speed 7500rpm 9000rpm 9900rpm --probes 1 5 --report page

from rotor_ida import clearance_report

report = clearance_report(compressor, speed=(7500 * rpm, 9000 * rpm, 9900 * rpm), probes=["1", "5"])
figure_of(report)

# %%
print(report.attrs["sentence"].replace(". ", ".\n"))

# %%
# Each case has the unbalance where it excites one mode most, or two modes along the two axes. Both labyrinths pass: at continuous speeds the orbit, scaled to the
# vibration limit at the probes, fills a fifth of the clearance, and three quarters are allowed. It fills two thirds on the way through the critical speed, for which
# there is no limit. What follows a touch is known in closed form only for isotropic films; here a run-up (``rotor-ida run-up compressor.toml``) shows it.
#
# The report compares clearances and does not assess stability. Add the threshold of instability to it.
#
# Next: :doc:`/bearings` is the reference on tables over the speed, :doc:`/clearance_report` that on the page, :doc:`/system_files` that on the
# file, and :doc:`/other_programs` compares rubs with those of ROSS.
