"""
Set up your own study
=====================

Vary parameters over a grid, keep the result while it is computed, resume it, and compare it with exact responses. You get the steady
state over speed and friction, and an archive that anyone can recompute.

Open the notebook at the end of this page in Jupyter, or copy the blocks into ``python`` one by one (:doc:`/install`).

The question
------------

A rotor with a clearance of half an eccentricity rubs at all speeds. How does friction change the rub? Each point of the grid is one
simulation from rest that is followed until it settles.
"""

import tempfile
from pathlib import Path

import numpy as np

from rotor_ida import sweep

speeds = np.linspace(1.0, 2.0, 21)
frictions = [0.0, 0.02, 0.05, 0.1, 0.2]
study = Path(tempfile.mkdtemp()) / "friction"
found = sweep(
    omega=speeds,
    zeta=0.07,
    delta0=0.5,
    friction=frictions,
    disc_radius=10.0,
    method="taylor",
    study=study,
)
dict(found.response.sizes)

# %%
# Every argument may be a number or an axis, and each axis becomes a dimension of the result. The study keeps each finished point on disk.
# After an interruption, ``resume`` continues it, also from another Python session or with ``rotor-ida resume``:

from rotor_ida import resume, status

print(status(study)["done"], "of", status(study)["points"], "points done")
resume(study).equals(found)

# %%
# The answer
# ----------
#
# ``response`` classifies the steady state of each point, and ``radius_max`` is its largest radius.

import pandas as pd

from rotor_ida.schema import RESPONSE

words = {number: word for word, number in RESPONSE.items()}
kinds = pd.DataFrame(
    {friction: found.response.sel(friction=friction).values.ravel() for friction in frictions}
)
kinds.apply(lambda column: column.map(words).value_counts()).fillna(0).astype(int)

# %%

from rotor_ida.plot import panels, style

radius = found.radius_max.squeeze()
with style():
    figure, (ax,) = panels(1, 1, width=6.4, height=3.6)
    for friction in frictions:
        ax.plot(speeds, radius.sel(friction=friction), "o-", ms=3, label=f"friction {friction:g}")
    ax.axhline(0.5, color="0.5", lw=0.8, ls=":")
    ax.set(xlabel="speed ω", ylabel="largest radius")
    ax.legend()
figure

# %%
# A little friction lowers the speed at which the rotor leaves the large rub. At a friction of a tenth the
# large rub begins to oscillate, and near its end it leaves the stator or rolls. Twice that friction leads from rest into dry
# whip, a rolling backward whirl, at every speed.
#
# Check it
# --------
#
# ``compare`` matches each steady state with every exact whirl and limit cycle of the same rotor, and counts the digits that agree.

from rotor_ida import compare

compared = compare(found)
digits = compared.digits.values.ravel()
print(f"{np.isfinite(digits).sum()} of {digits.size} points lie on an exact response")
print(f"with {np.nanmin(digits):.0f} digits or more")

# %%
# The folds of the exact response bound the rub without any simulation:

from rotor_ida import folds

ends = folds(zeta=0.07, delta0=0.5, friction=frictions).fold_omega.squeeze()
for friction in frictions:
    speeds_of_folds = ends.sel(friction=friction).values
    print(
        f"friction {friction:4.2f}:",
        ", ".join(f"{each:.3f}" for each in speeds_of_folds[np.isfinite(speeds_of_folds)]),
    )

# %%
# Keep it
# -------
#
# Save the result as an archive. It records all arguments and versions, so ``rotor-ida verify friction.nc`` recomputes it and compares.

from rotor_ida import load, save

archive = save(found, study.parent / "friction.nc")
load(archive).equals(found)

# %%
# Next
# ----
#
# - Run larger studies: :doc:`/studies`, on several machines: :doc:`/clusters`.
# - Map which starts lead to which motion: :doc:`basins_and_branches`.
# - The variables of a sweep: :doc:`/datasets`.
