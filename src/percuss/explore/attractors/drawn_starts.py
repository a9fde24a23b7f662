"""Where the motions of an experiment start: named distributions, and rows drawn from one's own."""

from __future__ import annotations

import hashlib
import math
import os
import re
from collections.abc import Iterator
from functools import lru_cache
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from percuss.errors import Interrupted, MissingExtraError, ParameterError, extra_package
from percuss.explore.jobs.job import Column, Columns
from percuss.model import Machine, System
from percuss.model.body import Body
from percuss.model.checks import Array, count
from percuss.recordings.file_formats import netcdf_content

if TYPE_CHECKING:
    from percuss.simulate import Starts


# ---- Starts as columns

UNIT_OF_TIME = "machine's unit of time"  # of a hammer that no clock drives


def start_columns(displacements: int, velocities: int, clock: bool = True) -> dict[str, Column]:
    """The columns of starts with so many modal amplitudes, and the load phase; without a clock the valve's state."""
    rigid, unit = displacements == velocities == 1, "rad" if clock else UNIT_OF_TIME
    last = {"time": Column(unit="rad", meaning="load phase of the start")}
    if not clock:
        last = {"state": Column("int64", meaning="state of the valve at the start, by its number")}
    where = "where the bar starts" if rigid else "of the striking end at the start"
    place = {"position": Column(unit="bar lengths", meaning=f"{where}; the wall is at 0")}
    if rigid:
        toward = Column(unit=f"bar lengths/{unit}", meaning="of the bar at its start, positive toward the wall")
        return {**place, "velocity": toward, **last}
    return {
        **place,
        "start_displacement": Column(shape=(displacements,), meaning="u_n at the start"),
        "start_velocity": Column(shape=(velocities,), meaning="u_n' at the start"),
        **last,
    }


def start_values(starts: Starts) -> Columns:
    """The starts as columns."""
    found: Columns = {"position": starts.gap.copy()}
    found |= {"time": starts.time.copy()} if starts.state is None else {"state": starts.state.copy()}
    if starts.displacement.shape[1] == starts.velocity.shape[1] == 1:
        return {**found, "velocity": starts.velocity[:, 0].copy()}
    return {**found, "start_displacement": starts.displacement.copy(), "start_velocity": starts.velocity.copy()}


def starts_from(columns: Columns, states: tuple[str, ...]) -> Starts:
    """The starts that columns hold, of a machine whose valve has these states, or under a clock without any."""
    from percuss.simulate import Starts

    gap = columns["position"]
    time = np.zeros(gap.shape) if states else columns["time"]
    if "velocity" in columns:
        bars = Starts.rigid(gap, columns["velocity"], time)
    else:
        bars = Starts(columns["start_displacement"], columns["start_velocity"], gap, time)
    return bars.with_valve(columns["state"], states) if states else bars


def states_of(what: System | Machine) -> tuple[str, ...]:
    """The names of the valve's states; none under a clock."""
    return tuple(name for name, _ in what.valve.pairs) if isinstance(what, Machine) else ()


def fingerprint(starts: Starts) -> str:
    """SHA-256 of starts."""
    found = hashlib.sha256()
    states = () if starts.state is None else (starts.state.astype(float),)
    for values in (starts.displacement, starts.velocity, starts.gap, starts.time, *states):
        found.update(str(values.shape).encode() + np.ascontiguousarray(values, dtype="<f8").tobytes())
    return found.hexdigest()


def done(columns: Columns) -> npt.NDArray[np.bool_]:
    """Which motions are known: of an archive that is not whole, not all are."""
    return np.asarray(columns["code"] >= 0)


# ---- Where the motions of an experiment start: named distributions, and rows drawn from one's own

DISTRIBUTIONS = ("wall", "field", "gentle")
"""The named distributions of starts; all rigid, the elastic modes at rest."""

FIELD_DEPTH, FIELD_SPEED, GENTLE_SPEED = 20.0, 5.0, 0.2
GENTLE_SHARE = 0.05  # greatest speed of `gentle` starts of a machine, over its scale of speeds

BLOCK = 65_536
"""Rows that are drawn together, from a stream of their own: a portion of an experiment draws only its blocks."""

_TURN = 2.0 * np.pi


def named(what: System | Machine, distribution: str, number: int, seed: int = 0, first: int = 0) -> Starts:
    """Starts drawn from a named distribution; which they are does not depend on how many are drawn.

    ``wall``
        On the wall, leaving with the speed \\|N(0, 1)\\|·V. Under a clock V = 2πp_0/(1 + R), the striking speed of the
        undamped motion with one impact in every load period; of a machine V = √(2 Δp S), see `speed_scale`, with S the
        distance of its farthest port.
    ``field``
        Position uniform in [−20, 0], velocity 5·N(0, 1); of a machine in [−2S, 0], V·N(0, 1).
    ``gentle``
        On the wall, leaving with a speed uniform in (0, 0.2); of a machine in (0, V/20).

    The load phase is uniform; of a machine the state of the valve is one of its states at random, no orders wait, and
    ports whose region is occupied demand at once. All are rigid, with the elastic modes at rest; dimensionless. A bar
    that leaves has a velocity below 0. Every column of every `BLOCK` rows has a stream of its own, spawned from the
    seed by numpy's `SeedSequence`.

    They are `number` rows from row `first` on of the endless table of the seed. ParameterError for ``wall`` with a load
    that does not push, and for starts on the wall of a machine whose states all push alike: they have no scale.
    """
    from percuss.simulate import Starts

    if distribution not in DISTRIBUTIONS:
        raise ParameterError("distribution", distribution, f"one of {', '.join(DISTRIBUTIONS)}, or a file")
    last = first + count("starts", number)
    seed = count("seed", seed, least=0)
    blocks = [_block(distribution, block, seed)[:, part] for block, part in _parts(first, last)]
    position, velocity, turn = np.concatenate(blocks, axis=1)
    if not isinstance(what, Machine):
        speed = _TURN * what.load.mean / what.contact.impulse
        if distribution == "wall" and speed <= 0.0:
            accepted = "a load that pushes (mean greater than 0)"
            raise ParameterError("distribution", "wall", accepted, "use 'field' or 'gentle', or a file")
        return Starts.rigid(position, speed * velocity if distribution == "wall" else velocity, turn)
    speed, names = speed_scale(what), states_of(what)
    if speed == 0.0 and distribution != "field":
        accepted = "a valve whose states have different forces"
        raise ParameterError("distribution", distribution, accepted, "use 'field', or a file of starts")
    unit = {"wall": 1.0, "field": 1.0 / FIELD_SPEED, "gentle": GENTLE_SHARE / GENTLE_SPEED}[distribution]
    state = np.minimum(turn / _TURN * len(names), len(names) - 1).astype(np.int64)
    place = 2.0 * farthest_port(what) / FIELD_DEPTH * position
    return Starts.rigid(place, speed * unit * velocity).with_valve(state, names)


def farthest_port(machine: Machine) -> float:
    """Distance of the farthest port behind the wall; one bar length where every port is the blow."""
    return max((port.behind for port in machine.valve.ports if port.behind is not None), default=1.0)


def speed_scale(machine: Machine) -> float:
    """√(2 Δp S), a blow's speed without delay, drag and R, by the work of the valve's forces; 0 for one force."""
    forces = [force for _, force in machine.valve.pairs]
    return math.sqrt(2.0 * (max(forces) - min(forces)) * farthest_port(machine))


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
    last = first + count("starts", number)
    seed = count("seed", seed, least=0)
    which = np.concatenate([_chosen(len(rows), block, seed)[part] for block, part in _parts(first, last)])
    return rows[which]


@lru_cache(maxsize=4)
def _chosen(rows: int, block: int, seed: int) -> npt.NDArray[np.int64]:
    stream = np.random.SeedSequence(seed, spawn_key=(block, 3))  # beside the three of `_block`
    return np.random.default_rng(stream).integers(0, rows, BLOCK)


# ---- Starts of one's own for an experiment: a file, a function of the seed, a plane

MODE = re.compile(r"[uv]_([1-9]\d{0,3})")  # the name of an amplitude of a start


def own(what: System | Machine, source: Any, seed: int = 0) -> Starts:
    """The rows of one's own distribution: a file, a function of the seed, or the starts themselves."""
    # A file is a CSV table with a heading, an ``.npz`` archive or a NetCDF file (``.nc``) with columns of one length:
    # ``position``, ``velocity``, ``time`` for rigid starts (what is left out is 0), or modal amplitudes ``u_0``,
    # ``u_1``, …, ``v_0``, ``v_1``, … of the modes of the hammer, and ``time``. The bar is at u(1) ≤ 0; the wall is at
    # 0. Dimensionless, the time in radians.
    # Instead of a load phase a table of a machine has the column ``state``: the name of the valve's state or its number
    # from 0. Without it all start with the valve's own starting state, as `Starts` do.
    # ParameterError for a file that cannot be read or has unknown columns, a state that the valve does not have, and
    # for a function that gives no starts.
    from percuss.simulate import Starts

    names = states_of(what)
    if callable(source) and not isinstance(source, Starts):
        source = source(seed)
        if not isinstance(source, Starts):
            raise ParameterError("what the distribution gives", source, "a Starts")
    if not isinstance(what, Machine):
        if isinstance(source, Starts):
            return source
        return table_starts(what.body, what.load.at, *table_of(source))
    usual = names.index(what.valve.start or names[0])
    one_of = f"one of {', '.join(map(repr, names[:6]))}"
    if isinstance(source, Starts):
        if source.state is None:
            return source.with_valve(usual, names)
        if source.states != names:
            raise ParameterError("distribution", f"starts with states {', '.join(source.states)}", one_of)
        return source
    file, columns = table_of(source, names)
    if "time" in columns:
        remedy = f"no clock drives it: remove the column; 'state' is one of {', '.join(names)}"
        raise ParameterError(file, "column 'time'", "starts of a machine that switches its own valve", remedy)
    given = columns.pop("state", None)
    bars = table_starts(what.body, what.at, file, columns, "state")
    state = np.full(len(bars), float(usual)) if given is None else given
    if state.size != len(bars):
        raise ParameterError(file, f"{state.size} states of {len(bars)} starts", "columns of one length")
    wrong = np.flatnonzero(~np.isin(state, np.arange(len(names))))
    if wrong.size:
        raise ParameterError(file, f"state in row {wrong[0] + 1}", f"{one_of}, or its number from 0")
    return bars.with_valve(state.astype(np.int64), names)


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
    if other is None:
        return str(path), _text(path, states)
    try:
        return str(path), other(path)
    except (Interrupted, MissingExtraError):
        raise
    except Exception as error:  # a damaged file raises whatever it happens to hit
        accepted = f"a {path.suffix.lower()} file of numbers"
        raise ParameterError("distribution", str(path), accepted, str(error)[:200]) from None


def table_starts(body: Body, at: int, file: str, columns: dict[str, Array], third: str = "time") -> Starts:
    """Starts from the columns of a file, for the modes of a body driven at the place `at`, and a `third` column."""
    from percuss.simulate import Starts
    from percuss.simulate.spectrum import units

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
    gap = np.asarray(u[:, 0] + u[:, 1:] @ units(body.modes(most, at)))  # u(1) = u_0 + Σ γ_n u_n
    gap = _not_beyond(file, gap, 1e-12 * float(np.abs(u).max()))
    return Starts(u, v, gap, columns.get("time", zero))


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
            words = [cell.strip().strip('"') for cell in cells]
            table[i] = [
                states.index(word) if name == "state" and word in states else float(cell)
                for name, word, cell in zip(names, words, cells, strict=True)
            ]
        except ValueError:
            accepted = f"{len(names)} numbers ({', '.join(names)})"
            raise ParameterError(f"{path}, line {line}", text.strip(), accepted, "fix this line") from None
    return dict(zip(names, np.ascontiguousarray(table.T), strict=True))


def _npz(path: Path) -> dict[str, Array]:
    with np.load(path, allow_pickle=False) as content:
        return {name.lower(): np.asarray(content[name], dtype=float).reshape(-1) for name in content.files}


def _netcdf(path: Path) -> dict[str, Array]:
    xarray = extra_package("xarray", "io")
    with path.open("rb") as file:
        classic = file.read(3) == b"CDF"  # read by Python itself
    content = xarray.load_dataset(path, decode_cf=False) if classic else netcdf_content(path)
    content = xarray.decode_cf(content, decode_times=False)
    names = [str(name) for name in content.variables if str(name) not in content.indexes]
    return {name.lower(): np.asarray(content[name].values, dtype=float).reshape(-1) for name in names}


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
