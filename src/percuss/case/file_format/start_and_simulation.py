"""The tables [start] and [simulation] of a case as objects: where a simulation starts, how it is made, when it ends."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any, Literal

from percuss.case.file_format.values import CaseTable, NumberOrLength, NumberOrTime, NumberOrVelocity, Numbers
from percuss.errors import CaseError, ParameterError
from percuss.model import Machine, System
from percuss.model.checks import DEFAULT_MODES, count
from percuss.units import si

if TYPE_CHECKING:
    from percuss.simulate import Start, Stop
    from percuss.steady import Orbit


class StartTable(CaseTable):
    """Where a simulation starts: rigid, modal, on a steady motion, or drawn; in SI with units, or in plain numbers."""

    position: NumberOrLength | None = None
    """Rigid: position of the bar. With `orbit`, added to that motion, and 0 unless given. Allowed: 0 (on the wall) or
    less. When left out: −1, and 0 with a load of the kind `"valve"`."""
    velocity: NumberOrVelocity | None = None
    """Rigid: velocity of the bar, positive toward the wall. With `orbit`, added to that motion. When left out: 0."""
    time: NumberOrTime | None = None
    """Load phase at the start, in radians; not allowed with `orbit`, and for a valve, which starts at 0. When left out:
    0."""
    modal_displacement: Numbers | None = None
    r"""Modal: $u_0, u_1, \dots$, where $u(x) = u_0 + 2\sum u_n\cos n\pi x$. With `orbit`, added to that
    motion. Modes beyond the list: 0. When left out: 0."""
    modal_velocity: Numbers | None = None
    r"""Modal: $u_0', u_1', \dots$. With `orbit`, added to that motion. When left out: 0."""
    orbit: int | None = None
    """Just after the impact of this steady motion, numbered as `percuss steady` does. Allowed: 1 or greater."""
    periods: int | None = None
    """With `orbit`: load periods per impact of that motion. Allowed: 1 or greater. When left out: 1."""
    random: Literal["rigid", "still", "ringing"] | None = None
    """A random start: undeformed, undeformed and at rest, or with ringing modes."""
    seed: int | None = None
    """With `random`; the same seed gives the same start. Allowed: 0 or greater. When left out: 0."""


class SimulationTable(CaseTable):
    """How a simulation is made and when it ends; times with a unit, or in radians of the load's fundamental."""

    modes: int | None = None
    """Elastic modes; 0 is a rigid bar. Allowed: 0 to 4096. When left out: 32."""
    impacts: int | None = None
    """End after this many impacts. Allowed: 0 to 1e9. When left out: 2000, or a million with `time`."""
    time: NumberOrTime | None = None
    """End after this time from the start, in radians, or in the unit of time that a dimensionless valve has. Allowed:
    greater than 0. When left out: `impacts` decides."""
    periodic: bool | None = None
    """Whether to end when a periodic motion is found. When left out: true."""
    tolerance: float | None = None
    """How closely a state must return to count as the same. Allowed: 1e-13 to 0.1. When left out: 1e-9."""


_KINDS = {
    "rigid": ("position", "velocity"),
    "modal": ("modal_displacement", "modal_velocity"),
    "orbit": ("orbit", "periods"),
    "random": ("random", "seed"),
}
"""The ways to start, each with its keys; the first key of a kind that is not rigid or modal is needed.

Beside `orbit`, the keys of rigid or of modal are a disturbance of that motion.
"""


@dataclass(frozen=True)
class Simulation:
    """What the table [simulation] says: the number of elastic modes, and the stop rule."""

    modes: int
    stop: Stop


@dataclass(frozen=True)
class _Scales:
    """What a quantity with a unit is divided by; 1 while only its sign and its form are looked at."""

    length: float = 1.0
    velocity: float = 1.0
    time: float = 1.0

    @classmethod
    def of(cls, system: System | Machine) -> _Scales:
        return cls(system.length_scale, system.speed_scale, system.time_scale) if system.is_si else cls()

    def number(self, value: float | str | None, dimension: str, name: str, default: float = 0.0) -> float:
        if value is None:
            return default
        return si(value, dimension, name) / getattr(self, dimension) if isinstance(value, str) else float(value)


# -- [simulation] ---------------------------------------------------------------------------------------------------


def checked_simulation(table: SimulationTable) -> Simulation:
    """What the table says, with times in any unit; only checks whether the table must be refused."""
    return _simulation(table, _Scales())


def simulation_of(table: SimulationTable | None, system: System | Machine) -> Simulation:
    """The table [simulation] of a case, and the defaults without it."""
    rigid = isinstance(system, Machine) and system.valve.flows
    return _simulation(table or SimulationTable(), _Scales.of(system), 0 if rigid else DEFAULT_MODES)


def _simulation(table: SimulationTable, scales: _Scales, usual: int = DEFAULT_MODES) -> Simulation:
    from percuss.simulate.stop import MAX_MODES, Stop  # a steady motion does without

    modes = usual if table.modes is None else count("modes", table.modes, least=0, most=MAX_MODES)
    options: dict[str, Any] = {"impacts": table.impacts, "periodic": table.periodic, "tolerance": table.tolerance}
    given = {name: value for name, value in options.items() if value is not None}
    time = None if table.time is None else scales.number(table.time, "time", "time")
    return Simulation(modes, Stop(time=time, **given))


# -- [start] --------------------------------------------------------------------------------------------------------


def checked_start(table: StartTable) -> None:
    """Refuse a table that describes no start."""
    kind = _kind(table)
    with _by_its_key(table):
        if kind != "random":
            _start(table, _Scales(), 0.0 if kind == "orbit" else -1.0)
    if table.orbit is not None:
        count("orbit", table.orbit)
        count("periods", 1 if table.periods is None else table.periods, most=1000)
    if table.seed is not None:
        count("seed", table.seed, least=0)


def start_of(table: StartTable | None, system: System | Machine, modes: int, file: str) -> Start:
    from percuss.simulate import Start

    if table is None:
        return Start.rigid(_place_without(system))
    kind = _kind(table)
    _check_of_machine(table, kind, system, file)
    orbit = _orbit(table, system, modes, file) if kind == "orbit" and isinstance(system, System) else None
    try:
        with _by_its_key(table):
            start = _made(table, kind, system, orbit)
            start.state(modes)
    except ParameterError as error:
        raise CaseError(file, f"start.{error.name}", error.value, f"expected {error.accepted}", error.remedy) from None
    return start


def _place_without(system: System | Machine) -> float:
    """Where a bar starts that is not placed: a machine on the wall, where its own valve must start it."""
    return -1.0 if isinstance(system, System) else 0.0


def _check_of_machine(table: StartTable, kind: str, system: System | Machine, file: str) -> None:
    """Refuse for a machine that switches itself what only a load that keeps time has."""
    if isinstance(system, Machine):
        for key in ("orbit", "random", "time"):
            if (given := getattr(table, key)) is not None:
                accepted = "expected a start by position and velocity, or by modes, of a machine that switches itself"
                raise CaseError(file, f"start.{key}", given, accepted, f"remove {key}: the valve starts at time 0")


@contextmanager
def _by_its_key(table: StartTable) -> Iterator[None]:
    """What `Start` refuses by its own names, by the key of the table that gave it."""
    try:
        yield
    except ParameterError as error:
        name, accepted = error.name, error.accepted
        if name == "gap":  # u(1), which no key gives
            name, accepted = "displacement", f"{accepted}; it is at {error.value}"
        if name not in ("displacement", "velocity"):
            raise
        if _is_modal(table):
            name = f"modal_{name}"
        elif name == "displacement":
            name = "position"
        raise ParameterError(name, getattr(table, name), accepted, error.remedy) from None


def _made(table: StartTable, kind: str, system: System | Machine, orbit: Orbit | None) -> Start:
    """The start of a kind; `orbit` is the motion that one on a steady motion begins on."""
    from percuss.simulate import Start

    if orbit is not None:
        return Start.orbit(orbit, *_vectors(table, _Scales.of(system), 0.0))
    if kind == "random":
        assert table.random is not None and isinstance(system, System)  # checked before
        start = Start.random(system, seed=table.seed or 0, distribution=table.random)
        return start if table.time is None else start.at(_Scales.of(system).number(table.time, "time", "time"))
    return _start(table, _Scales.of(system), _place_without(system))


def _start(table: StartTable, scales: _Scales, place: float) -> Start:
    """The start at the vectors of a table; beside `orbit` it stands for the disturbance."""
    from percuss.simulate import Start

    (u, v), time = _vectors(table, scales, place), scales.number(table.time, "time", "time")
    # what a simulation has more of modes is 0, as the key says
    return replace(Start.modal(u, v, time), modes=None) if _is_modal(table) else Start.rigid(u[0], v[0], time)


def _is_modal(table: StartTable) -> bool:
    return table.modal_displacement is not None or table.modal_velocity is not None


def _vectors(table: StartTable, scales: _Scales, place: float) -> tuple[tuple[float, ...], tuple[float, ...]]:
    """The u_n and u_n' of a table; what is left out is 0, but `place` for the position."""
    if _is_modal(table):
        displacement, velocity = tuple(table.modal_displacement or ()), tuple(table.modal_velocity or ())
        return displacement or (0.0,) * len(velocity), velocity or (0.0,) * len(displacement)
    position = scales.number(table.position, "length", "position", place)
    return (position,), (scales.number(table.velocity, "velocity", "velocity"),)


def _kind(table: StartTable) -> str:
    given = {kind: [key for key in keys if getattr(table, key) is not None] for kind, keys in _KINDS.items()}
    disturbance = [kind for kind in ("rigid", "modal") if given["orbit"] and given[kind]]
    if len(disturbance) == 1:
        given["orbit"] += given.pop(disturbance[0])
    kinds = [kind for kind, keys in given.items() if keys and not (kind == "orbit" and len(disturbance) == 2)]
    if len(kinds) > 1:
        ways = " or ".join(f"{' and '.join(_KINDS[kind])} ({kind})" for kind in kinds)
        extra = given[kinds[-1]]
        remedy = f"remove {' and '.join(extra)}, or {' and '.join(key for kind in kinds[:-1] for key in given[kind])}"
        raise ParameterError(extra[0], getattr(table, extra[0]), f"one kind of start: {ways}", remedy)
    kind = kinds[0] if kinds else "rigid"
    if kind in ("orbit", "random") and given[kind][0] != kind:
        example = "orbit = 1" if kind == "orbit" else 'random = "rigid"'
        raise ParameterError(given[kind][0], getattr(table, given[kind][0]), f"{kind} with it", f"add {example}")
    if kind == "orbit" and table.time is not None:
        raise ParameterError("time", table.time, "no time with orbit, which starts at its own phase", "remove time")
    return kind


def _orbit(table: StartTable, system: System, modes: int, file: str) -> Orbit:
    from percuss.steady import steady_states  # the other starts do without

    periods = 1 if table.periods is None else table.periods
    orbits = steady_states(system, periods, modes=modes).orbits
    assert table.orbit is not None
    if table.orbit > len(orbits):
        every = "every load period" if periods == 1 else f"in {periods} load periods"
        accepted = f"a number from 1 to {len(orbits)}, the steady motions with one impact {every}"
        if not orbits:
            accepted = f"a steady motion with one impact {every}, and there is none"
        raise CaseError(file, "start.orbit", table.orbit, f"expected {accepted}", f"see 'percuss steady {file}'")
    orbit = orbits[table.orbit - 1]
    if not orbit.impact_velocity > 0.0:
        remedy = "see 'percuss steady'"
        raise CaseError(file, "start.orbit", table.orbit, "this motion does not strike: it cannot happen", remedy)
    return orbit
