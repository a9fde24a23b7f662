"""A diagram as an xarray dataset: rows of impacts, simulated and of the branches, and the events of the branches."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from percuss.errors import MissingExtraError
from percuss.explore.diagrams.lines import DiagramBranch

if TYPE_CHECKING:
    import xarray

    from percuss.explore.axis import Axis
    from percuss.explore.diagrams.rest_lines import DiagramRestBranch
    from percuss.explore.diagrams.settled import SettledMotion

__all__ = ["dataset_of"]


class _Row(NamedTuple):
    """One impact."""

    source: str
    number: int
    label: str
    value: float
    stable: int
    impact: int
    phase: float
    speed: float
    energy: float
    speed_scale: float
    energy_scale: float
    release_phase: float = math.nan
    rest_phase: float = math.nan


def dataset_of(
    axis: Axis,
    settled: Sequence[SettledMotion],
    branches: Sequence[DiagramBranch | DiagramRestBranch],
    is_si: bool,
    about: Mapping[str, Any],
) -> xarray.Dataset:
    """A diagram over the dimensions ``row``, one impact each, and ``event``, with the attributes `about`.

    Raises
    ------
    MissingExtraError
        Without xarray.
    """
    try:
        import xarray
    except ImportError:
        raise MissingExtraError("xarray", "io") from None
    name, unit = axis.name, axis.unit or "1"
    rows = [*_simulated(settled), *(row for i, line in enumerate(branches, 1) for row in _rows(i, line))]
    table = dict(zip(_Row._fields, (np.array(column) for column in zip(*rows, strict=True)), strict=True))
    if not rows:
        table = {field: np.array([]) for field in _Row._fields}
    variables: dict[str, Any] = {
        "source": ("row", table["source"].astype(object), {"long_name": "what the impact is of: simulated or branch"}),
        "number": ("row", table["number"], {"long_name": "of the simulated motion or of the branch, from 1 on"}),
        "label": ("row", table["label"].astype(object), {"long_name": "motion label"}),
        name: ("row", table["value"], {"units": unit, "long_name": "the parameter"}),
        "stable": ("row", table["stable"], {"long_name": "1: stable, 0: unstable; what is simulated is stable"}),
        "impact": ("row", table["impact"], {"long_name": "number of the impact, from 1 on"}),
        "phase": ("row", table["phase"], {"units": "rad", "long_name": "load phase of the impact"}),
        "speed": ("row", table["speed"], {"units": "1", "long_name": "speed of the striking end just before it"}),
        "energy": ("row", table["energy"], {"units": "1", "long_name": "mean kinetic energy before a blow"}),
        "release_phase": ("row", table["release_phase"], {"units": "rad", "long_name": "when the bar was let go"}),
        "rest_phase": ("row", table["rest_phase"], {"units": "rad", "long_name": "when it comes to rest after that"}),
    }
    if is_si:
        about = {"units": "m/s", "long_name": "speed of the striking end just before it"}
        variables["speed_m_s"] = ("row", table["speed"] * table["speed_scale"], about)
        about = {"units": "J", "long_name": "mean kinetic energy before a blow"}
        variables["energy_J"] = ("row", table["energy"] * table["energy_scale"], about)
    variables |= _events(branches, unit)
    return xarray.Dataset(variables, attrs=dict(about))


def _simulated(settled: Sequence[SettledMotion]) -> Iterator[_Row]:
    for number, one in enumerate(settled, 1):
        scales = one.scales or (math.nan, math.nan)
        for i, (phase, speed) in enumerate(zip(one.phases.tolist(), one.speeds.tolist(), strict=True), 1):
            yield _Row("simulated", number, one.label, one.value, 1, i, phase, speed, one.energy, *scales)


def _rows(number: int, line: DiagramBranch | DiagramRestBranch) -> Iterator[_Row]:
    return _of_orbits(number, line) if isinstance(line, DiagramBranch) else _of_rests(number, line)


def _of_rests(number: int, line: DiagramRestBranch) -> Iterator[_Row]:
    """The first impacts after each release, numbered through the cycle."""
    scales = np.full((line.values.size, 2), math.nan) if line.scales is None else line.scales
    for m, value in enumerate(line.values.tolist()):
        energy, (speed_scale, energy_scale), i = float(line.energies[m]), scales[m].tolist(), 0
        rests = zip(line.release_phases[m].tolist(), line.rest_phases[m].tolist(), strict=True)
        for leg, (release, rest) in enumerate(rests):
            for phase, speed in zip(line.phases[m, leg].tolist(), line.speeds[m, leg].tolist(), strict=True):
                if math.isfinite(phase):
                    i += 1
                    yield _Row(
                        "branch", number, line.label, value, 1, i, phase, speed, energy, speed_scale, energy_scale,
                        release, rest,
                    )  # fmt: skip


def _of_orbits(number: int, line: DiagramBranch) -> Iterator[_Row]:
    scales = np.full((line.values.size, 2), math.nan) if line.scales is None else line.scales
    phases, stable = line.phases, line.stable
    for m in range(line.values.size):
        same = (float(line.values[m]), int(stable[m]))
        energies = (float(line.energies[m]), *scales[m].tolist())
        for i, (phase, speed) in enumerate(zip(phases[m].tolist(), line.speeds[m].tolist(), strict=True), 1):
            yield _Row("branch", number, line.label, *same, i, phase, speed, *energies)


def _events(branches: Sequence[DiagramBranch | DiagramRestBranch], unit: str) -> dict[str, Any]:
    points = [(i, point) for i, line in enumerate(branches, 1) for point in line.points]
    values = np.array([point.value for _, point in points])
    return {
        "event_branch": ("event", np.array([i for i, _ in points], dtype=np.int64), {"long_name": "of which branch"}),
        "event_type": ("event", _texts([point.kind.value for _, point in points]), {"long_name": "what happens"}),
        "event_label": ("event", _texts([point.label for _, point in points]), {"long_name": "motion label"}),
        "event_value": ("event", values, {"units": unit, "long_name": "the parameter"}),
        "event_beyond": ("event", _texts([point.beyond for _, point in points]), {"long_name": "what lies beyond"}),
    }


def _texts(values: list[str]) -> np.ndarray[Any, np.dtype[np.object_]]:
    return np.array(values, dtype=object)
