"""The report on close clearances in words: a line for each."""

from __future__ import annotations

import numpy as np
import xarray as xr

from rotor_ida.results.depths import beyond_model
from rotor_ida.results.growth_words import BEGINS
from rotor_ida.results.si_units import NOTE
from rotor_ida.schema import words_of
from rotor_ida.units import quantity

# The part of a clearance that a scaled orbit may fill.
ALLOWED = 0.75


def sentences(report: xr.Dataset) -> str:
    """Return a line for each clearance, one on critical speeds, and one on the probes if needed.

    What is not kept comes first, the worst before the others, after the first touch.
    """
    report = report.assign_coords(contact=np.arange(report.sizes["contact"]))
    found = [(_excess(report, number), _of_contact(report, number))
             for number in range(report.sizes["contact"])]  # fmt: skip
    near = _too_near(report)
    if BEGINS in report.attrs:  # before what is kept
        found.insert(0, (1.0, _of_instability(report)))
    found.append((1.0 + len(near), _of_critical_speeds(report, near)))
    if (least := float(report["scale_factor"].min())) < 1.0:
        found.append((1.0 / least if least > 0.0 else np.inf,
            "At the probes the response exceeds the vibration limit: the scale factor is "
            f"{least:.3g}, below 1."))  # fmt: skip
    lines = [line for _, line in sorted(found, key=lambda each: -max(each[0], 1.0))]
    touches = report["first_touch_speed"].values
    if np.isfinite(touches).any():
        first = report.isel(contact=int(np.nanargmin(touches)))
        when = _speed(report, first["first_touch_speed"].item())
        lines.insert(
            0, f"With the scaled unbalance contact {_place(first)} touches first, at {when}."
        )
    if "not_exact" in report.attrs:
        lines.append(
            f"Whirls that follow a touch have no closed form: {report.attrs['not_exact']}."
        )
    if beyond := beyond_model(report):
        lines.append(beyond)
    if note := report.attrs.get(NOTE):
        lines.append(f"Note: {note}.")
    return "\n".join(lines)


def _excess(report: xr.Dataset, number: int) -> float:
    """Return by what factor a clearance is filled beyond what is allowed; at most 1 if it is not.

    A touch on the way to the trip speed counts as filling it.
    """
    own = report.isel(contact=number)
    shares = (float(own["running_share"].max()) / ALLOWED, float(own["passage_share"].max()))
    return max(shares)


def _of_contact(report: xr.Dataset, number: int) -> str:
    """Return how much of a clearance is filled, and what follows a touch."""
    own = report.isel(contact=number)
    shares = own["running_share"].values
    worst = int(np.argmax(shares))
    where = _speed(report, float(own["running_share_speed"].values[worst]))
    verdict = words_of(own["clearance_verdict"])[0]
    scales, by, unscaled, most = report["scale_factor"].values, "", "", float(shares[worst])
    if (scales < 1.0).any():
        by = f" with the scale factor {scales[worst]:.3g}"
        applied = np.divide(shares, scales, out=np.full_like(shares, np.inf), where=scales > 0.0)
        most = float(applied.max())
        unscaled = f", that of the applied unbalance {_per_cent(most)}"
    said = (
        f"Contact {_place(own)} {verdict}{by}: the scaled orbit fills "
        f"at most {_per_cent(shares[worst])} of the clearance at {where}{unscaled}; 75 % are "
        f"allowed. {_sag(own, most)}{_passage(own)}"
    )
    if "not_exact" in report.attrs:
        return said
    return f"{said} {_rub(own, 'rub', 'at continuous speeds')} {_whip(report, own)}"


def _place(own: xr.Dataset) -> str:
    """Return the number and the node of a contact."""
    return f"{own['contact'].item()} at {own['contact_node'].item()!r}"


def _sag(own: xr.Dataset, share: float) -> str:
    """Return how much of a clearance the static sag fills, alone and with the largest orbit."""
    if not own.get("sag_share", 0.0) > 0.0:
        return ""
    sag = float(own["sag_share"])
    return (
        f"The static sag, which the rule leaves out, takes {_per_cent(sag)} of it: with the sag "
        f"the orbit reaches up to {_per_cent(sag + share)}. "
    )


def _passage(own: xr.Dataset) -> str:
    """Return how much is filled on the way to the trip speed, and how hard a touch there is."""
    passing = float(own["passage_share"].max())
    way = "between rest and the trip speed"
    if passing < 1.0:
        return f"It fills at most {_per_cent(passing)} {way}."
    rub = _rub(own, "passage_rub", "there") if "not_exact" not in own.attrs else ""
    return f"It touches {way}, where it would fill {_per_cent(passing)}. {rub}".rstrip()


def _rub(own: xr.Dataset, prefix: str, where: str) -> str:
    word = words_of(own[f"{prefix}_stability"])[0]
    if word == "absent":
        return f"No synchronous rub exists {where}."
    kind = "A stable" if word == "stable" else "An unstable"
    speed = _speed(own, own[f"{prefix}_speed"].item())
    return f"{kind} rub {where} presses with up to {_force(own, f'{prefix}_force')}, at {speed}."


def _whip(report: xr.Dataset, own: xr.Dataset) -> str:
    word = words_of(own["whip_stability"])[0]
    if word == "absent":
        if not own["law_friction"].item() > 0.0:
            return "Without friction there is no dry whip."
        if np.isnan(own["law_radius"].item()):
            return "Dry whip is not known without a radius."
        return "Friction cannot hold dry whip."
    where = _speed(report, float(report.attrs["running_speeds"][1]))
    whirl = _speed(own, -own["whip_speed"].item())
    unstable = "" if word == "stable" else ", but it is unstable"
    return (
        f"Friction can hold dry whip at {where}: backwards at {whirl}, with "
        f"{_force(own, 'whip_force')}{unstable}."
    )


def _of_instability(report: xr.Dataset) -> str:
    """Return from which speed beyond the trip speed the rotor is unstable without contact."""
    begins, trip = float(report.attrs[BEGINS]), float(report.attrs["running_speeds"][2])
    return (
        f"The rotor without contact is unstable from {_speed(report, begins)} on, "
        f"{_per_cent(begins / trip - 1.0)} above the trip speed."
    )


def _too_near(report: xr.Dataset) -> list[int]:
    """Return the numbers of the critical speeds that are too near to the running speeds."""
    needed = report["required_margin"].values
    near = (needed > 0.0) & (report["separation_margin"].values < needed)
    return [place for place, is_near in enumerate(near) if is_near]


def _of_critical_speeds(report: xr.Dataset, near: list[int]) -> str:
    """Return whether all critical speeds are far enough from the running speeds."""
    margin, needed = report["separation_margin"].values, report["required_margin"].values
    speeds = [_speed(report, each) for each in report["critical_speed"].values]
    told = [
        f"{speeds[i]} (amplification {report['amplification_factor'].values[i]:.3g})" for i in near
    ]
    said = (
        f"Too near to the running speeds: the critical speed at {', and that at '.join(told)}."
        if told
        else "All critical speeds keep their separation margins."
    )
    if flat := [speeds[i] for i in np.flatnonzero((needed == 0.0) & (margin < 0.0))]:
        said += f" None is asked at {' and '.join(flat)}, as there is no sharp peak."
    return said


def _per_cent(share: float) -> str:
    return f"{100.0 * share:.2g} %" if share < 0.995 else f"{100.0 * share:.3g} %"


def _speed(report: xr.Dataset, speed: float) -> str:
    """Return a speed in rpm, or as it is where it has no unit."""
    return _with_unit(report, speed, "speed", "rad/s")


def _force(report: xr.Dataset, name: str) -> str:
    return _with_unit(report, report[name].item(), "force", "N")


def _with_unit(report: xr.Dataset, value: float, what: str, unit: str) -> str:
    if report["clearance"].attrs["units"] == "m":
        return quantity(value, unit)
    return f"a {what} of {quantity(value)}"
