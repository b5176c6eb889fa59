"""Two-sided spectra: backward whirl on the left, forward whirl on the right."""

from __future__ import annotations

from collections.abc import Mapping

import xarray as xr
from matplotlib.axes import Axes

from rotor_ida.checks import check_positive
from rotor_ida.plot.appearance import (
    BLUE,
    GREY,
    ORANGE,
    axes_or_new,
    check_dataset,
    own_legend,
    style,
)
from rotor_ida.plot.units import label_of, scale_of, suited

# Below this part of the largest the side lobes of the flat-top window lie.
FLOOR = 3e-5


def plot_spectrum(
    lines: xr.Dataset,
    *,
    span: float = 4.0,
    units: Mapping[str, str] | None = None,
    ax: Axes | None = None,
) -> Axes:
    """Draw the amplitude of forward and backward whirl over the frequency.

    Parameters
    ----------
    lines : Dataset
        What `rotor_ida.spectrum` returned.
    span : float
        Largest frequency shown, over the spin speed; over one if the rotor does not turn [1].
    units : mapping of str to str, optional
        Units for a dataset of `rotor_ida.dimensional`, such as ``{"length": "mm"}``; by default
        those with the SI prefix that suits.
    ax : Axes, optional
        Where to draw; by default on a new figure.

    Returns
    -------
    Axes
        Where it was drawn. The amplitude, on a logarithmic scale, is shown down to 3e-5 of the
        largest.

    Raises
    ------
    InputError
        If the dataset is no spectrum.

    Examples
    --------
    >>> from rotor_ida import Rotor, simulate, spectrum
    >>> run = simulate(Rotor(omega=1.7, zeta=0.07, delta0=0.5), start=(0, 0, 0, 0), duration=60)
    >>> plot_spectrum(spectrum(run)).get_yscale()
    'log'
    """
    lines = check_dataset("lines", lines, ("frequency", "whirl_amplitude"))
    lines = suited(lines, ["whirl_amplitude"], units=units, ax=ax)
    limit = check_positive("span", span)
    over = "frequency_over_omega" if "frequency_over_omega" in lines.variables else "frequency"
    frequency, height = lines[over].values, lines["whirl_amplitude"].values
    highest = float(height.max(initial=0.0)) or 1.0
    with style():
        ax = axes_or_new(ax)
        for words, colour, chosen in (
            ("backward whirl", ORANGE, frequency <= 0.0),
            ("forward whirl", BLUE, frequency >= 0.0),
        ):
            ax.semilogy(frequency[chosen], height[chosen], color=colour, lw=0.9, label=words)
        if over == "frequency_over_omega":
            ax.axvline(1.0, color=GREY, lw=0.7, ls=(0, (4, 2)), zorder=1.5, label="spin speed")
        else:
            limit *= scale_of(lines, "rate")
        ax.set_xlim(-limit, limit)
        # room for the legend
        ax.set_ylim(FLOOR * highest, 30.0 * highest)
        ax.set_xlabel(label_of(over, lines[over]))
        ax.set_ylabel(label_of("whirl_amplitude", lines["whirl_amplitude"]))
        own_legend(ax).set_loc("upper left")
    return ax
