"""The page of errata: each error, its correction, and the evidence in numbers."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from rotor_ida.paper.errata import numbers

_HEAD = """# Errata of the paper

Look up each error in "Analytical Nonlinear Response for a Rotor with the Hertz Contact and
Clearance", Mechanika 25(6), 2019, with its correction and the numbers that show it. The program
uses the corrected formulas. The printed ones are in `rotor_ida.paper.printed`, and the gallery
shows both:

    >>> from rotor_ida import synchronous_response
    >>> from rotor_ida.paper.printed import amplitudes_18
    >>> amplitudes_18(omega=1.7, zeta=0.07).round(5)
    array([2.52403])
    >>> synchronous_response(omega=1.7, zeta=0.07, delta0=0.0).amplitude.values.ravel()[:3].round(5)
    array([1.87963, 6.19321, 9.48721])

D is the eccentricity, which the paper calls Δ. Unless stated otherwise, ζ = 0.07.
`python -m rotor_ida.paper.errata docs/errata.md` computes these numbers and writes this page; a
test compares the two.

| place | printed | correct | evidence |
|---|---|---|---|
"""


@dataclass(frozen=True, slots=True)
class Row:
    """One place where the paper is wrong."""

    place: str
    printed: str
    right: str
    # evidence, with placeholders for numbers in braces
    shows: str
    numbers: Callable[[], dict[str, float]]


ROWS = (
    Row(
        "(3)", '"Coulomb" dissipation', "Rayleigh's, viscous: it grows with the square of speed",
        "energy lost in free damped motion over 2ζ ∫ \\|z'\\|² dt: {ratio:.6f}",
        numbers.dissipation,
    ),
    Row(
        "(9)", "ω₀² = k/m", "ω₀² = k √D/m, for k in N/m^1.5",
        "a machine of 4 kg with D = 1 µm, integrated in SI units: the dimensionless run differs by "
        "less than {right_bound:.0e} of the largest displacement; with k/m by more than all "
        "of it",
        numbers.scaling,
    ),
    Row(
        "(11), Fig. 2", "f = f(x) + i f(y), falling with x",
        "f_x depends on x and y and never falls with x",
        "δ₀ = 0.5: f_x(1, 0) = {below:.4f}, f_x(1, 2) = {above:.4f}", numbers.force,
    ),
    Row(
        "Fig. 3", 'the potential is "concave"', "convex",
        "its curvatures are f(r)/r and 1.5 √(r − δ₀): at r = 1.5, δ₀ = 0.5 {low:.4f} and "
        "{high:.4f}", numbers.curvature,
    ),
    Row(
        "(13)", "\\|z\\|²/2", "\\|z'\\|²/2",
        "free orbit from (2, 0, 0.3, 0.25), δ₀ = 0.5: the right sum keeps to {drift_bound:.0e} of "
        "itself, the printed one runs from {lowest:.3f} to {highest:.2f}", numbers.conserved,
    ),
    Row(
        "(17), 3.2", '"the higher the amplitude, the longer the period"', "the shorter",
        "on a circle T = {small:.5f} at A = 2 and {large:.5f} at A = 8", numbers.periods,
    ),
    Row(
        "Fig. 5", "the period of the circle for starts on a line", "4 B(2/5, 1/2)/√5 A^(−1/4)",
        "{longer:.3f} % longer; a start (0, 0, 0, 8) comes to A = (1.25 · 8²)^0.4 = {reached:.5f}",
        numbers.portraits,
    ),
    Row(
        "(18)", "z \\|z\\|^1.5", "z \\|z\\|^0.5",
        "ω = 1.7: one amplitude, {printed:.5f}, where there are three: {small:.5f}, {middle:.5f} "
        "(unstable), {large:.5f}", numbers.single_response,
    ),
    Row(
        "(20)-(23)", "H = β e^(iθ), θ = arctan", "H = β e^(−iθ), θ = atan2 in (0, π)",
        "small whirl at ω = 1.7: arg H = {argument:.5f}, arctan = {arctangent:.5f}, phase lag "
        "{lag:.5f}; β = {modulus:.5f} is A itself, so that (22) is an equation for A",
        numbers.phases,
    ),
    Row(
        "(24)-(28)", '"general solution"',
        "none in closed form: the equation is nonlinear, and solutions do not add up; λ is defined "
        "in three ways, ε not at all, and +θ should be −θ",
        "ω = 1.7 from (10, 0, 0, 0): off by {printed:.2f} at t = 5, by more than 1 from t = "
        "{printed_from:.2f} on; with the signs corrected by {mended:.2f}, from {mended_from:.2f} "
        "on",
        numbers.transient,
    ),
    Row(
        "(29)", "z H (\\|z\\| − δ₀)^1.5", "z/\\|z\\| H (\\|z\\| − δ₀)^1.5",
        "ω = 1.2, δ₀ = 0.5: A = {printed_amplitude:.5f} where it is {amplitude:.5f}",
        numbers.with_clearance,
    ),
    Row(
        "(31)", "H (A − δ)^1.5/A²", "/A, as in (30)",
        "the same whirl: θ = {printed_lag:.5f} where it is {lag:.5f}", numbers.with_clearance,
    ),
    Row(
        "4.1.2", '"cannot obtain an unstable periodic orbit"', "it is a root of a polynomial",
        "ω = 1.7, δ₀ = 0: A = {amplitude:.5f}, growth rate {growth:.5f}", numbers.unstable,
    ),
    Row(
        "Fig. 6", "jumps", "only below the damping of a cusp",
        "no fold above ζ = {without:.9f} at δ₀ = 0, and none at any clearance above {anywhere:.6f}"
        ", which is reached at δ₀ = {at:.4f}", numbers.cusps,
    ),
    Row(
        "Fig. 7", '"like a spider"', "for starts at rest one smooth egg round the small whirl",
        "ω = 1.7, δ₀ = 0, starts every 1.5 on the two axes: those that end on the small whirl are "
        "one stretch each, x from {left:.1f} to {right:.1f} and y from {low:.1f} to {high:.1f}",
        numbers.basin_cuts,
    ),
    Row(
        "Figs 8, 9", "from (0, 0, 0, 0) the large whirl, from (10, 0, 0, 0) the small one",
        "the other way round", "A = {rest:.5f} from rest, {ten:.5f} from (10, 0, 0, 0)",
        numbers.captions,
    ),
    Row(
        "4.2.1", "more clearance lowers the amplitude",
        "true of the peak; below resonance it raises it, and above it the rotor may bounce",
        "peak {first:.2f} at δ₀ = 0, {last:.2f} at δ₀ = 2; but at ω = 1.2 A = {a:.3f}, {b:.3f}, "
        "{c:.3f}, {d:.3f} for δ₀ = 0, 0.5, 1, 2", numbers.clearance,
    ),
    Row(
        "Fig. 11", '"good agreement"',
        "at δ₀ = 0; with clearance only where the synchronous whirl attracts",
        "δ₀ = 2, from rest: the contacting branch is there at {with_branch:.0f} of {speeds:.0f} "
        "speeds from 0.75 to 2 and reached at {reached:.0f}; at ω = 2 the rotor bounces, \\|z\\| "
        "from {inner:.1f} to {outer:.1f}", numbers.agreement,
    ),
)  # fmt: skip
# Figures that depend on the last digits of an integration are given as these bounds.
BOUNDS = {"right": 5e-12, "drift": 1e-8}


def errata_page() -> str:
    """Return the page of errata in Markdown, its numbers computed anew.

    Returns
    -------
    str
        The page.

    Raises
    ------
    ValueError
        If a number is not within the bound that the page states for it.

    Notes
    -----
    It takes some seconds, because some numbers come from simulations.
    """
    return _HEAD + "".join(_line(row) for row in ROWS)


def _line(row: Row) -> str:
    found = row.numbers()
    for name, bound in BOUNDS.items():
        if name in found and f"{{{name}_bound" in row.shows:
            if not found[name] < bound:
                raise ValueError(f"{row.place}: {name} must be below {bound}, got {found[name]}")
            found[f"{name}_bound"] = bound
    cells = (row.place, row.printed, row.right, row.shows.format(**found))
    return f"| {' | '.join(cells)} |\n"
