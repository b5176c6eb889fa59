"""Hold simulated responses against the exact synchronous whirls."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt
import xarray as xr

from rotor_ida.checks import check_instance
from rotor_ida.closed_forms import synchronous_response
from rotor_ida.errors import InputError
from rotor_ida.parameters import PARAMETERS
from rotor_ida.schema import RESPONSE, labelled, labelled_dataset, origin_of

Values = npt.NDArray[np.float64]

NEEDED = ("response", "amplitude", "phase_lag")
# A settled whirl lies on a branch when it is this near, as a part of its amplitude: far above
# any simulation's error, far below the distance between branches.
ON_BRANCH = 1e-5
# A double holds no more decimal digits than this.
ALL_DIGITS = 16.0


def compare(dataset: xr.Dataset) -> xr.Dataset:
    """Put each simulated response of a sweep beside every exact synchronous whirl.

    Parameters
    ----------
    dataset : Dataset
        A sweep: ``response``, ``amplitude`` and ``phase_lag`` on ``omega``, ``zeta`` and
        ``delta0`` and any further dimensions.

    Returns
    -------
    Dataset
        ``response`` says what each point does. On the dimensions of the sweep:
        ``matched_branch`` (-1 where it is on none), ``amplitude_error`` [1], ``phase_error``
        [rad] and ``digits``, NaN where it is on none. With ``branch`` added:
        ``branch_amplitude_error`` and ``branch_phase_error``. On
        ``(omega, zeta, delta0, branch)``: ``exact_amplitude``, ``exact_phase_lag``,
        ``stability`` and ``in_contact``.

    Raises
    ------
    InputError
        If the dataset is not a sweep.

    Notes
    -----
    Only a response of constant radius in contact, or a contact-free one, can lie on a branch.
    It does when the complex amplitudes ``A exp(-i theta)`` differ by less than 1e-5 of the
    exact amplitude; ``digits`` is minus the decimal logarithm of that difference.

    Examples
    --------
    >>> from rotor_ida import sweep
    >>> compared = compare(sweep(omega=1.7, zeta=0.5, delta0=0.5))
    >>> compared.matched_branch.item(), bool(abs(compared.amplitude_error.item()) < 1e-8)
    (0, True)
    """
    _check_is_sweep(dataset)
    dims = dataset["response"].dims
    exact = synchronous_response(**{name: dataset[name].values for name in PARAMETERS})
    amplitude, lag = dataset["amplitude"], dataset["phase_lag"]
    difference = _relative_distance(amplitude, lag, exact)
    allowed = exact["in_contact"] == (dataset["response"] == RESPONSE["synchronous"])
    could_lie = dataset["response"].isin([RESPONSE["synchronous"], RESPONSE["contact_free"]])
    candidates = difference.where(allowed & could_lie)
    nearest = candidates.fillna(np.inf).reduce(np.argmin, "branch")
    distance = candidates.isel(branch=nearest).drop_vars("branch")
    matched = distance < ON_BRANCH

    amplitude_error = (amplitude - exact["amplitude"]) / exact["amplitude"]
    phase_error = _wrapped(lag - exact["phase_lag"])
    columns = {
        "matched_branch": nearest.where(matched, -1).astype(np.int8),
        "amplitude_error": _at(amplitude_error, nearest).where(matched),
        "phase_error": _at(phase_error, nearest).where(matched),
        "digits": _digits(distance).where(matched),
    }
    variables = {
        name: labelled(name, dims, column.transpose(*dims).values)
        for name, column in columns.items()
    }
    with_branch = (*dims, "branch")
    for name, error in (
        ("branch_amplitude_error", amplitude_error),
        ("branch_phase_error", phase_error),
    ):
        variables[name] = labelled(name, with_branch, error.transpose(*with_branch).values)
    variables |= _exact_variables(exact)
    variables |= {name: dataset[name].variable for name in NEEDED}
    coordinates = {
        str(name): each.variable
        for name, each in {**dataset["response"].coords, "branch": exact["branch"]}.items()
    }
    title = "Simulated responses beside the exact synchronous whirls"
    return labelled_dataset(title, variables, coordinates, origin_of(dataset))


def summarise(compared: xr.Dataset) -> list[dict[str, object]]:
    """Count, for each clearance, how many responses lie on an exact branch and to how far.

    Parameters
    ----------
    compared : Dataset
        What `compare` returned.

    Returns
    -------
    list of dict
        One row for each ``delta0``, with the number of points, how many lie on a branch,
        smallest and median number of digits of those, and the number of every other kind.

    Examples
    --------
    >>> from rotor_ida import sweep
    >>> row, = summarise(compare(sweep(omega=1.7, zeta=0.5, delta0=0.5)))
    >>> row["points"], row["on_branch"], row["bouncing"]
    (1, 1, 0)
    """
    rows = []
    for delta0 in compared["delta0"].values:
        part = compared.sel(delta0=delta0)
        on_branch = part["matched_branch"].values >= 0
        digits = part["digits"].values[on_branch]
        other = part["response"].values[~on_branch]
        row: dict[str, object] = {
            "delta0": float(delta0),
            "points": int(on_branch.size),
            "on_branch": int(on_branch.sum()),
            "fewest_digits": float(digits.min()) if digits.size else float("nan"),
            "median_digits": float(np.median(digits)) if digits.size else float("nan"),
        }
        row |= {kind: int((other == flag).sum()) for kind, flag in RESPONSE.items()}
        rows.append(row)
    return rows


def _check_is_sweep(dataset: xr.Dataset) -> None:
    check_instance("dataset", dataset, xr.Dataset)
    missing = [name for name in (*NEEDED, *PARAMETERS) if name not in dataset.variables]
    missing += [name for name in PARAMETERS if name not in dataset.dims and name not in missing]
    if missing:
        names = ", ".join(missing)
        raise InputError(f"compare needs a sweep over omega, zeta and delta0; it lacks {names}")


def _relative_distance(
    amplitude: xr.DataArray, lag: xr.DataArray, exact: xr.Dataset
) -> xr.DataArray:
    """Return the distance of complex amplitudes, as a part of the exact one."""
    simulated = amplitude * np.exp(-1j * lag)
    expected = exact["amplitude"] * np.exp(-1j * exact["phase_lag"])
    distance = abs(simulated - expected)
    # A rotor at rest is exactly on its branch of amplitude 0.
    scale = exact["amplitude"].where(exact["amplitude"] != 0.0, 1.0)
    return distance / scale


def _wrapped(angle: xr.DataArray) -> xr.DataArray:
    """Return an angle in [-pi, pi)."""
    return (angle + np.pi) % (2.0 * np.pi) - np.pi


def _at(errors: xr.DataArray, branch: xr.DataArray) -> xr.DataArray:
    return errors.isel(branch=branch).drop_vars("branch")


def _digits(distance: xr.DataArray) -> xr.DataArray:
    floor = 10.0**-ALL_DIGITS
    return xr.DataArray(-np.log10(np.maximum(distance, floor)))


def _exact_variables(exact: xr.Dataset) -> dict[str, xr.Variable]:
    dims = (*PARAMETERS, "branch")
    return {
        "exact_amplitude": labelled("exact_amplitude", dims, exact["amplitude"].values),
        "exact_phase_lag": labelled("exact_phase_lag", dims, exact["phase_lag"].values),
        "stability": exact["stability"].variable,
        "in_contact": exact["in_contact"].variable,
    }
