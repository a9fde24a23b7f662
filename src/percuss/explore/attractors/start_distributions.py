"""Where the motions of an experiment start: named distributions, your own file, your own function."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator
from functools import lru_cache
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from percuss.errors import ParameterError
from percuss.model.checks import Array, count, instance

if TYPE_CHECKING:
    from percuss.model import System
    from percuss.simulate import Starts

__all__ = ["BLOCK", "DISTRIBUTIONS", "FIELD_DEPTH", "FIELD_SPEED", "GENTLE_SPEED", "drawn", "named", "own"]

DISTRIBUTIONS = ("wall", "field", "gentle")
"""The named distributions of starts; all rigid, the elastic modes at rest, the load phase uniform."""

FIELD_DEPTH, FIELD_SPEED, GENTLE_SPEED = 20.0, 5.0, 0.2

BLOCK = 65_536
"""Rows that are drawn together, from a stream of their own: a portion of an experiment draws only its blocks."""

_TURN = 2.0 * np.pi


def named(system: System, distribution: str, number: int, seed: int = 0, first: int = 0) -> Starts:
    """Starts drawn from a named distribution; which they are does not depend on how many are drawn.

    ``wall``
        On the wall, leaving with the speed \\|N(0, 1)\\|·2πp_0/(1 + R), load phase uniform. 2πp_0/(1 + R) is the
        striking speed of the undamped motion with one impact in every load period.
    ``field``
        Position uniform in [−20, 0], velocity 5·N(0, 1), load phase uniform.
    ``gentle``
        On the wall, leaving with a speed uniform in (0, 0.2), load phase uniform.

    All are rigid, with the elastic modes at rest; dimensionless. A bar that leaves has a velocity below 0. Every
    column of every `BLOCK` rows has a stream of its own, spawned from the seed by numpy's `SeedSequence`.

    Parameters
    ----------
    system
        Whose load and restitution set the speed of ``wall``.
    distribution
        One of `DISTRIBUTIONS`.
    number
        How many.
    seed
        0 or greater.
    first
        Row of the endless table of this seed with which to begin.

    Raises
    ------
    ParameterError
        For an unknown name, or ``wall`` with a load that does not push.

    Examples
    --------
    >>> from percuss import Load, System
    >>> system = System(s=20.0, d=0.0, restitution=0.6, load=Load.harmonic(0.9, 1.0))
    >>> starts = named(system, "gentle", 1000, seed=1)
    >>> len(starts), bool((starts.velocity < 0.0).all()), bool((starts.gap == 0.0).all())
    (1000, True, True)
    """
    from percuss.simulate import Starts

    if distribution not in DISTRIBUTIONS:
        raise ParameterError("distribution", distribution, f"one of {', '.join(DISTRIBUTIONS)}, or a file")
    last = first + count("starts", number)
    seed = count("seed", seed, least=0)
    speed = _TURN * system.load.mean / system.contact.impulse
    if distribution == "wall" and speed <= 0.0:
        raise ParameterError(
            "distribution", "wall", "a load that pushes (mean greater than 0)", "use 'field' or 'gentle', or a file"
        )
    parts = [_block(distribution, block, seed)[:, part] for block, part in _parts(first, last)]
    position, velocity, time = np.concatenate(parts, axis=1)
    return Starts.rigid(position, speed * velocity if distribution == "wall" else velocity, time)


def _parts(first: int, last: int) -> Iterator[tuple[int, slice]]:
    """The blocks of the rows `first` … `last` − 1, and what of each is asked for."""
    for block in range(first // BLOCK, (last - 1) // BLOCK + 1):
        yield block, slice(max(first - block * BLOCK, 0), min(last - block * BLOCK, BLOCK))


@lru_cache(maxsize=4)  # a worker takes one portion of a block after the other
def _block(distribution: str, block: int, seed: int) -> Array:
    """Position, velocity and time of one block, shape (3, rows); velocities of ``wall`` over its speed."""
    first, second, third = (
        np.random.default_rng(stream) for stream in np.random.SeedSequence(seed, spawn_key=(block,)).spawn(3)
    )
    found = np.zeros((3, BLOCK))
    found[2] = _TURN * first.random(BLOCK)
    if distribution == "field":
        found[0] = -FIELD_DEPTH * second.random(BLOCK)
        found[1] = FIELD_SPEED * third.standard_normal(BLOCK)
    elif distribution == "gentle":
        found[1] = -GENTLE_SPEED * (1.0 - third.random(BLOCK))  # (0, 0.2]: never without speed
    else:
        found[1] = -np.abs(third.standard_normal(BLOCK))
    found.setflags(write=False)
    return found


def drawn(rows: Starts, number: int, seed: int = 0, first: int = 0) -> Starts:
    """`number` starts of given rows, by chance with replacement; which they are does not depend on how many."""
    from percuss.simulate import Starts

    last = first + count("starts", number)
    seed = count("seed", seed, least=0)
    which = np.concatenate([_chosen(len(rows), block, seed)[part] for block, part in _parts(first, last)])
    return Starts(rows.displacement[which], rows.velocity[which], rows.gap[which], rows.time[which])


@lru_cache(maxsize=4)
def _chosen(rows: int, block: int, seed: int) -> npt.NDArray[np.int64]:
    stream = np.random.SeedSequence(seed, spawn_key=(block, 3))  # beside the three of `_block`
    return np.random.default_rng(stream).integers(0, rows, BLOCK)


# -- one's own ------------------------------------------------------------------------------------------------------


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
    accepted = f"{', '.join(DISTRIBUTIONS)}, or a file of starts (.csv, .npz, .nc)"
    if not isinstance(source, str | os.PathLike):
        raise ParameterError("distribution", source, accepted)
    path = Path(source)
    if not path.is_file():
        why = "" if not path.exists() else "it is not a regular file"
        raise ParameterError("distribution", str(source), accepted, why or "there is no such file")
    columns = {".npz": _npz, ".nc": _netcdf}.get(path.suffix.lower(), _text)(path)
    return _starts(system, str(path), columns)


def _starts(system: System, file: str, columns: dict[str, Array]) -> Starts:
    from percuss.simulate import Starts

    modal = sorted(
        (name for name in columns if name[:2] in ("u_", "v_") and name[2:].isdecimal()), key=lambda n: int(n[2:])
    )
    rigid = [name for name in columns if name in ("position", "velocity")]
    unknown = [name for name in columns if name not in ("position", "velocity", "time", *modal)]
    remedy = "name the columns position, velocity, time, or u_0, u_1, …, v_0, v_1, …, time"
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
    return Starts(u, v, _not_beyond(file, gap_of(system, u), 1e-12 * float(np.abs(u).max())), columns.get("time", zero))


def gap_of(system: System, displacement: Array) -> Array:
    """u(1) = u_0 + Σ γ_n u_n of each row (of a uniform bar driven at its end: γ_n = 2(−1)ⁿ)."""
    from percuss.simulate.spectrum import units

    elastic = system.body.modes(displacement.shape[1] - 1, system.load.at)
    return np.asarray(displacement[:, 0] + displacement[:, 1:] @ units(elastic))


def _not_beyond(file: str, gap: Array, noise: float) -> Array:
    bad = np.flatnonzero(gap > noise)
    if bad.size:
        accepted = "a striking end at or before the wall, u(1) ≤ 0"
        raise ParameterError(file, f"u(1) = {gap[bad[0]]:.6g} in row {bad[0] + 1}", accepted)
    return np.where(gap >= -noise, 0.0, gap)


def _text(path: Path) -> dict[str, Array]:
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
            table[i] = [float(cell) for cell in cells]
        except ValueError:
            accepted = f"{len(names)} numbers ({', '.join(names)})"
            raise ParameterError(f"{path}, line {line}", text.strip(), accepted, "fix this line") from None
    return dict(zip(names, np.ascontiguousarray(table.T), strict=True))


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
