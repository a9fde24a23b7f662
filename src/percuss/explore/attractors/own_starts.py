"""Starts of one's own for an experiment: a file, a function of the seed, a plane."""

from __future__ import annotations

import os
import re
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from percuss.errors import ParameterError
from percuss.explore.attractors.start_distributions import DISTRIBUTIONS
from percuss.model.body import Body
from percuss.model.checks import Array, instance

if TYPE_CHECKING:
    from percuss.model import System
    from percuss.simulate import Starts

__all__ = ["MODE", "end_starts", "mode_of", "own", "table_of", "table_starts"]

MODE = re.compile(r"[uv]_([1-9]\d{0,3})")
"""The name of an amplitude of a start."""


def own(system: System, source: str | os.PathLike[str] | Starts | Callable[[int], Starts], seed: int = 0) -> Starts:
    """The rows of one's own distribution: a file, a function of the seed, or the starts themselves.

    The system is the one whose modes the amplitudes of a file belong to.

    A file is a CSV table with a heading, an ``.npz`` archive or a NetCDF file (``.nc``) with columns of one length:
    ``position``, ``velocity``, ``time`` for rigid starts (what is left out is 0), or modal amplitudes ``u_0``, ``u_1``,
    …, ``v_0``, ``v_1``, … and ``time``. The bar is at u(1) ≤ 0; the wall is at 0. Dimensionless, the time in radians.

    Raises
    ------
    ParameterError
        For a file that cannot be read or has unknown columns, and for a function that gives no `Starts`.
    """
    from percuss.simulate import Starts

    if isinstance(source, Starts):
        return source
    if callable(source):
        return instance("what the distribution gives", source(seed), Starts)
    return table_starts(system.body, system.load.at, *table_of(source))


def table_of(source: Any, states: tuple[str, ...] = ()) -> tuple[str, dict[str, Array]]:
    """The name of a file of starts, and its columns; `states`: words that its column ``state`` may have for numbers."""
    accepted = f"{', '.join(DISTRIBUTIONS)}, or a file of starts (.csv, .npz, .nc)"
    if not isinstance(source, str | os.PathLike):
        raise ParameterError("distribution", source, accepted)
    path = Path(source)
    if not path.is_file():
        why = "" if not path.exists() else "it is not a regular file"
        raise ParameterError("distribution", str(source), accepted, why or "there is no such file")
    other = {".npz": _npz, ".nc": _netcdf}.get(path.suffix.lower())
    return str(path), _text(path, states) if other is None else other(path)


def table_starts(body: Body, at: int, file: str, columns: dict[str, Array], third: str = "time") -> Starts:
    """Starts from the columns of a file, for the modes of a body driven at the place `at`, and a `third` column."""
    from percuss.simulate import Starts

    modal = sorted(
        (name for name in columns if name[:2] in ("u_", "v_") and name[2:].isdecimal()), key=lambda n: int(n[2:])
    )
    rigid = [name for name in columns if name in ("position", "velocity")]
    unknown = [name for name in columns if name not in ("position", "velocity", "time", *modal)]
    remedy = f"name the columns position, velocity, {third}, or u_0, u_1, …, v_0, v_1, …, {third}"
    if unknown:
        raise ParameterError(file, f"column '{unknown[0]}'", "columns known by their headings", remedy)
    if bool(modal) == bool(rigid):
        what = "columns of both kinds" if modal else "no column of a state"
        raise ParameterError(file, what, "rigid starts or modal amplitudes", remedy)
    sizes = {name: values.size for name, values in columns.items()}
    size = max(sizes.values())
    if min(sizes.values()) != size or not size:
        raise ParameterError(file, sizes, "columns of one length, at least one row")
    for name, values in columns.items():
        bad = np.flatnonzero(~np.isfinite(values))
        if bad.size:
            raise ParameterError(file, f"{name} in row {bad[0] + 1}", "finite numbers", "fix or delete this row")
    zero = np.zeros(size)
    if rigid:
        position = columns.get("position", zero)
        _not_beyond(file, position, 0.0)
        return Starts.rigid(position, columns.get("velocity", zero), columns.get("time", zero))
    most = max(int(name[2:]) for name in modal)
    u, v = (np.column_stack([columns.get(f"{kind}_{n}", zero) for n in range(most + 1)]) for kind in "uv")
    gap = _not_beyond(file, _gap_of(body, at, u), 1e-12 * float(np.abs(u).max()))
    return Starts(u, v, gap, columns.get("time", zero))


def _gap_of(body: Body, at: int, displacement: Array) -> Array:
    """u(1) = u_0 + Σ γ_n u_n of each row (of a uniform bar driven at its end: γ_n = 2(−1)ⁿ)."""
    from percuss.simulate.spectrum import units

    elastic = body.modes(displacement.shape[1] - 1, at)
    return np.asarray(displacement[:, 0] + displacement[:, 1:] @ units(elastic))


def _not_beyond(file: str, gap: Array, noise: float) -> Array:
    bad = np.flatnonzero(gap > noise)
    if bad.size:
        accepted = "a striking end at or before the wall, u(1) ≤ 0"
        raise ParameterError(file, f"u(1) = {gap[bad[0]]:.6g} in row {bad[0] + 1}", accepted)
    return np.where(gap >= -noise, 0.0, gap)


def _text(path: Path, states: tuple[str, ...]) -> dict[str, Array]:
    try:
        lines = path.read_text(encoding="utf-8-sig").splitlines()
    except (OSError, UnicodeDecodeError) as error:
        raise ParameterError("distribution", str(path), "a table in text (CSV), .npz or .nc", str(error)) from None
    rows = [(i + 1, line) for i, line in enumerate(lines) if line.strip() and not line.lstrip().startswith("#")]
    if len(rows) < 2:
        raise ParameterError("distribution", str(path), "a heading and at least one row of numbers")
    heading = rows[0][1]
    mark = next((mark for mark in (",", ";", "\t") if mark in heading), None)
    names = [name.strip().strip('"').lower() for name in heading.split(mark)]
    if len(set(names)) < len(names):
        raise ParameterError(str(path), heading.strip(), "every column once")
    table = np.empty((len(rows) - 1, len(names)))
    for i, (line, text) in enumerate(rows[1:]):
        cells = text.split(mark)
        try:
            if len(cells) != len(names):
                raise ValueError
            table[i] = [_value(name, cell, states) for name, cell in zip(names, cells, strict=True)]
        except ValueError:
            accepted = f"{len(names)} numbers ({', '.join(names)})"
            raise ParameterError(f"{path}, line {line}", text.strip(), accepted, "fix this line") from None
    return dict(zip(names, np.ascontiguousarray(table.T), strict=True))


def _value(name: str, cell: str, states: tuple[str, ...]) -> float:
    """A number, or that of a state that is named."""
    word = cell.strip().strip('"')
    return float(states.index(word)) if name == "state" and word in states else float(cell)


def _npz(path: Path) -> dict[str, Array]:
    try:
        with np.load(path, allow_pickle=False) as content:
            return {name.lower(): np.asarray(content[name], dtype=float).reshape(-1) for name in content.files}
    except Exception as error:  # a damaged file raises whatever it happens to hit
        raise ParameterError("distribution", str(path), "an .npz file of numbers", str(error)[:200]) from None


def _netcdf(path: Path) -> dict[str, Array]:
    try:
        import xarray
    except ImportError:
        from percuss.errors import MissingExtraError

        raise MissingExtraError("xarray", "io") from None
    try:
        with xarray.open_dataset(path, decode_times=False) as content:
            names = [str(name) for name in content.variables if str(name) not in content.indexes]
            return {name.lower(): np.asarray(content[name].values, dtype=float).reshape(-1) for name in names}
    except Exception as error:  # as above
        raise ParameterError("distribution", str(path), "a NetCDF file of numbers", str(error)[:200]) from None


# -- a plane ----------------------------------------------------------------------------------------------------------


def mode_of(name: str) -> int:
    """n of an amplitude u_n or v_n; 0 for the rest."""
    found = MODE.fullmatch(name)
    return int(found[1]) if found else 0


def end_starts(body: Body, at: int, grid: dict[str, Array]) -> Starts:
    """Starts of the striking end from columns by name, position, velocity and load phase among them, or 0."""
    from percuss.simulate import Starts
    from percuss.simulate.spectrum import units

    most, rows = max(map(mode_of, grid)), max(column.size for column in grid.values())
    nothing = np.zeros(rows)
    position = grid.get("position", nothing)
    u, v = (np.zeros((rows, most + 1)) for _ in "uv")
    for name, column in grid.items():
        if mode_of(name):
            (u if name[0] == "u" else v)[:, mode_of(name)] = column
    u[:, 0] = position - u[:, 1:] @ units(body.modes(most, at))
    v[:, 0] = grid.get("velocity", nothing)
    return Starts(u, v, position, grid.get("time", nothing))
