"""Starts as columns, and columns of motions as a dataset."""

from __future__ import annotations

import hashlib
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from percuss.errors import MissingExtraError
from percuss.explore.jobs.job import Column, Columns
from percuss.explore.quantities import CYCLE_KINDS

if TYPE_CHECKING:
    from collections.abc import Mapping

    import xarray

    from percuss.model import System
    from percuss.simulate import Starts

__all__ = ["dataset_of", "done", "fingerprint", "si_attributes", "some", "start_columns", "start_values", "starts_from"]

_RIGID: dict[str, Column] = {
    "position": Column(unit="bar lengths", meaning="where the bar starts; the wall is at 0"),
    "velocity": Column(unit="bar lengths/rad", meaning="of the bar at its start, positive toward the wall"),
    "time": Column(unit="rad", meaning="load phase of the start"),
}

_SI = {
    "position": ("length_scale", "m"),
    **dict.fromkeys(("velocity", "striking_speed", "impact_velocity"), ("speed_scale", "m/s")),
    "blow_energy": ("energy_scale", "J"),
    **dict.fromkeys(
        ("time", "interval_mean", "interval_std", "main_interval_mean", "main_interval_std"), ("time_scale", "s")
    ),
}
"""Scales of `System`, and what they give."""


def start_columns(displacements: int, velocities: int) -> dict[str, Column]:
    """The columns of starts with so many modal amplitudes."""
    if displacements == velocities == 1:
        return dict(_RIGID)
    return {
        "position": Column(unit="bar lengths", meaning="of the striking end at the start; the wall is at 0"),
        "start_displacement": Column(shape=(displacements,), meaning="u_n at the start"),
        "start_velocity": Column(shape=(velocities,), meaning="u_n' at the start"),
        "time": _RIGID["time"],
    }


def start_values(starts: Starts) -> Columns:
    """The starts as columns."""
    found: Columns = {"position": starts.gap.copy(), "time": starts.time.copy()}
    if starts.displacement.shape[1] == starts.velocity.shape[1] == 1:
        return {**found, "velocity": starts.velocity[:, 0].copy()}
    return {**found, "start_displacement": starts.displacement.copy(), "start_velocity": starts.velocity.copy()}


def starts_from(columns: Columns) -> Starts:
    """The starts that columns hold."""
    from percuss.simulate import Starts

    if "velocity" in columns:
        return Starts.rigid(columns["position"], columns["velocity"], columns["time"])
    return Starts(columns["start_displacement"], columns["start_velocity"], columns["position"], columns["time"])


def some(starts: Starts, rows: npt.NDArray[np.intp] | slice) -> Starts:
    """Some of the starts."""
    from percuss.simulate import Starts

    return Starts(starts.displacement[rows], starts.velocity[rows], starts.gap[rows], starts.time[rows])


def fingerprint(starts: Starts) -> str:
    """SHA-256 of starts."""
    found = hashlib.sha256()
    for values in (starts.displacement, starts.velocity, starts.gap, starts.time):
        found.update(str(values.shape).encode() + np.ascontiguousarray(values, dtype="<f8").tobytes())
    return found.hexdigest()


def done(columns: Columns) -> npt.NDArray[np.bool_]:
    """Which motions are known: of an archive that is not whole, not all are."""
    return np.asarray(columns["code"] >= 0)


def dataset_of(
    columns: Columns,
    dims: tuple[str, ...],
    number: npt.NDArray[np.int64],
    shares: Any,
    described: Mapping[str, Column],
    system: System,
    about: dict[str, Any],
) -> xarray.Dataset:
    """Columns of motions and their attractors as a dataset; `dims`: of the motions, and `number` of their shape.

    All of it is dimensionless and says so; of a system in SI it has the scales besides, as `si_scale` and `si_units` of
    each variable that has one.
    """
    try:
        import xarray
    except ImportError:
        raise MissingExtraError("xarray", "io") from None
    from percuss._version import __version__
    from percuss.simulate import OUTCOMES

    known = {**start_columns(2, 2), **_RIGID, **described}
    words = {"code": OUTCOMES, "cycle_kind": CYCLE_KINDS}
    variables: dict[str, Any] = {
        "attractor_number": (dims, number, {"long_name": "attractor that the motion settles on"}),
    }
    for name, values in columns.items():
        column = known[name]
        inner = () if values.ndim == 1 else ({"invariants": "invariant"}.get(name, f"{name}_mode"),)
        attributes = {"long_name": column.meaning, "units": column.unit or "1", **si_attributes(name, system)}
        if not column.unit and column.dtype == "float64":
            attributes["comment"] = "dimensionless"
        if name in words:
            attributes["words"] = ", ".join(words[name])
        variables[name] = ((*dims, *inner), values.reshape(*number.shape, *values.shape[1:]), attributes)
    meanings = {"label": "motion", "share": "part of the starts", "low": "its interval", "high": "its interval"}
    for name, meaning in meanings.items():
        found = np.array([getattr(share, name) for share in shares])
        variables[f"attractor_{name}" if name != "share" else "share"] = ("attractor", found, {"long_name": meaning})
    return xarray.Dataset(
        variables,
        coords={"attractor": np.arange(len(shares))},
        attrs={
            **about,
            "scaling": "dimensionless: lengths in bar lengths, times in radians of the load phase",
            **({"frequency_Hz": system.frequency} if system.is_si else {}),
            "percuss_version": __version__,
        },
    )


def si_attributes(name: str, system: System) -> dict[str, Any]:
    """What a column is to be multiplied by for SI, and the unit that it then has; nothing without scales."""
    if not system.is_si or name not in _SI:
        return {}
    scale, unit = _SI[name]
    return {"si_scale": float(getattr(system, scale)), "si_units": unit}
