"""Where a motion starts: the displacement and the velocity of the bar, and the phase of the load."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import Protocol, overload

import numpy as np
import numpy.typing as npt

from percuss.errors import ParameterError
from percuss.model import HeldBody, Load, Machine, System
from percuss.model.body import Body, UniformBar
from percuss.model.checks import Array, choice, count, finite, having, instance, non_negative, numbers, several, text
from percuss.model.load.valve import Orders
from percuss.short_repr import ShortRepr
from percuss.simulate.spectrum import state_of, units
from percuss.simulate.stop import MAX_MODES

# ---- Displacements and velocities along the bar, and the modes of which they are made

Profile = npt.ArrayLike | Callable[[Array], npt.ArrayLike]
"""A function of an array of x, or values at equal steps from x = 0 to 1, straight between them."""


def number_tuple(name: str, values: object) -> tuple[float, ...]:
    """One or more finite numbers, as they are kept in a start."""
    if isinstance(values, tuple) and len(values) == 1 and type(values[0]) is float and math.isfinite(values[0]):
        return values  # of an undeformed bar
    array = numbers(name, values, "one or more finite numbers").reshape(-1)
    if not array.size:
        raise ParameterError(name, values, "one or more finite numbers")
    return tuple(array.tolist())


def sampled(name: str, profile: Profile) -> Profile:
    """A profile that is looked at: a function as it is, a number as two equal samples."""
    if callable(profile):
        return profile
    values = np.atleast_1d(np.asarray(number_tuple(name, profile)))
    return tuple((np.repeat(values, 2) if values.size == 1 else values).tolist())


def values_at(profile: Profile, x: Array) -> Array:
    """A profile at some places; shape (len(x),)."""
    if callable(profile):
        accepted = "finite values on 0 ≤ x ≤ 1, as many as x or one"
        found = numbers("displacement or velocity", profile(x), accepted)
        if found.shape not in ((), (1,), x.shape):
            raise ParameterError("displacement or velocity", f"shape {found.shape}", accepted)
        return np.broadcast_to(found, x.shape)
    samples = np.asarray(profile, dtype=float)
    return np.asarray(np.interp(x, np.linspace(0.0, 1.0, samples.size), samples))


def modal_parts(profile: Profile, body: Body, unit: Array) -> Array:
    """u_n of a profile, n = 0 … N, with q_n = unit u_n at the striking end; shape (N+1,)."""
    # A uniform bar's are its integrals with the modes. Of other bodies they are those that fit it best along the bar,
    # every place counted by its mass: in this sense the modes are orthogonal, and the rigid velocity is the momentum.
    if body.is_uniform:
        integrals = _integrals(profile, body, unit.size)
        return np.append(integrals[0], integrals[1:] / (body.inertia(unit.size) * unit))
    x, mass = _masses(body, max(16, 2 * (unit.size + 1)))
    shapes = np.column_stack([np.ones(x.size), body.shapes(x, unit.size).displacement * unit])
    root = np.sqrt(mass)
    return np.asarray(np.linalg.lstsq(shapes * root[:, None], _finite_at(profile, x) * root)[0], dtype=float)


def _integrals(profile: Profile, bar: Body, count: int) -> Array:
    """∫₀¹ u(x) φ_n(x)/φ_n(1) dx, n = 0 … `count`: exact for straight lines between samples, else by Gauss's rule."""
    # φ'' = −(ω/s)² φ and φ' = 0 at both ends, so that ∫ u φ dx = (s/ω)² ∫ u' φ' dx, and u' is constant between samples.
    # The rule is refined until nothing changes.
    if not callable(profile):
        u = np.asarray(profile, dtype=float)
        x = np.linspace(0.0, 1.0, u.size)
        slope = np.diff(u) / np.diff(x)
        rises = np.diff(bar.shapes(x, count).displacement, axis=0)
        return np.append(np.trapezoid(u, x), (bar.s / bar.frequencies(count)) ** 2 * (slope @ rises))
    last, panels = np.full(count + 1, np.inf), max(8, count + 1)
    while True:
        x, w = _gauss(np.linspace(0.0, 1.0, panels + 1))
        values = _finite_at(profile, x)
        found = np.append(w @ values, (w * values) @ bar.shapes(x, count).displacement)
        if float(np.abs(found - last).max()) <= 1e-14 * float(np.abs(values).max()) or panels > 16384:
            return np.asarray(found)
        last, panels = found, 2 * panels


def _finite_at(profile: Profile, x: Array) -> Array:
    values = np.asarray(values_at(profile, x), dtype=float)
    if not np.all(np.isfinite(values)):
        raise ParameterError("displacement or velocity", "a function", "finite values on 0 ≤ x ≤ 1")
    return values


def _masses(body: Body, panels: int) -> tuple[Array, Array]:
    """Places along the bar, and the masses that stand for it there, in sum 1: Gauss's, and those of the ends."""
    # Between the edges of the panels, each step of the bar one, the mass is taken for evenly spread.
    edges = np.union1d(np.linspace(0.0, 1.0, panels + 1), body.places)
    before = body.mass_before(edges)
    x, w = _gauss(edges)
    density = np.diff(before) / np.diff(edges)
    mass = w * np.repeat(density, w.size // density.size)
    return np.concatenate([[0.0], x, [1.0]]), np.concatenate([before[:1], mass, np.maximum(1.0 - before[-1:], 0.0)])


def _gauss(edges: Array, points: int = 8) -> tuple[Array, Array]:
    """Points and weights of Gauss's rule on the panels between edges."""
    t, w = np.polynomial.legendre.leggauss(points)
    left, width = edges[:-1, None], np.diff(edges)[:, None]
    return (left + 0.5 * (t + 1.0) * width).reshape(-1), (0.5 * w * width).reshape(-1)


# ---- Random starts: the numbers drawn for one or many of them

DISTRIBUTIONS = ("rigid", "still", "ringing")
"""The named distributions of random starts."""

DEFAULT_RANDOM_MODES = 32  # elastic modes that a random start excites
_TURN = 2.0 * np.pi
_MOST_STARTS = 10**9


def drawn(system: System, size: int, seed: int, distribution: str, modes: int) -> tuple[Array, Array, Array, Array]:
    """u_n and u_n', each of shape (size, n), gaps and load phases, of shape (size,); see `Starts.random`."""
    instance("system", system, System)
    n, number = count("modes", modes, least=0, most=MAX_MODES), count("size", size, least=1, most=_MOST_STARTS)
    choice("distribution", distribution, *DISTRIBUTIONS)
    draw = np.random.default_rng(count("seed", seed, least=0))
    if isinstance(system.body, HeldBody):
        return _of_structure(system, system.body, system.body.chosen(n or None), number, distribution, draw)
    scale = float(np.abs(system.load.coefficients).sum())
    gap = draw.uniform(-5.0 * scale, 0.0, number)
    mean = draw.uniform(-3.0 * scale, 3.0 * scale, number) * (distribution != "still")
    time = draw.uniform(0.0, _TURN, number)
    if distribution != "ringing":
        return gap[:, None], mean[:, None], gap, time
    k = np.arange(1, n + 1)
    size_of = draw.normal(0.0, 1.0, (number, n)) * scale / (3.0 * k)
    turn = draw.uniform(0.0, _TURN, (number, n))
    elastic = system.body.modes(n, system.load.at)
    u = size_of * np.cos(turn) / elastic.omega
    v = size_of * np.sin(turn)
    first = gap - u @ units(elastic)
    return np.column_stack([first, u]), np.column_stack([mean, v]), gap, time


def _of_structure(
    system: System, body: HeldBody, modes: int, number: int, distribution: str, draw: np.random.Generator
) -> tuple[Array, Array, Array, Array]:
    """The same of a body that is held; its modes give the scales of place and velocity in place of P."""
    elastic, force = body.modes(modes, system.load.at), float(np.abs(system.load.coefficients).sum())
    reach = abs(body.gap) + force * float(np.sum(np.abs(elastic.gamma) / elastic.omega**2))
    pace = force * float(np.sum(np.abs(elastic.gamma) / elastic.omega))
    gap = draw.uniform(-3.0 * reach, 0.0, number)
    speed = draw.uniform(-3.0 * pace, 3.0 * pace, number) * (distribution != "still")
    time = draw.uniform(0.0, _TURN, number)
    u, v = state_of(body, system.load.at, modes, gap[:, None], speed[:, None], gap)
    if distribution == "ringing":
        unit = units(elastic)
        size_of = draw.normal(0.0, 1.0, (number, modes)) * pace / (3.0 * np.arange(1, modes + 1))
        turn = draw.uniform(0.0, _TURN, (number, modes))
        swing = size_of * np.cos(turn) / (elastic.omega * np.abs(unit))
        u[:, 1:] += swing - np.outer(swing @ unit, body.bent(modes, system.load.at))
        v[:, 1:] += size_of * np.sin(turn) / np.abs(unit)
    return u, v, gap, time


# ---- Where a motion starts: the displacement and the velocity of the bar, and the phase of the load

MOST = 1e12
"""The largest load phase, displacement and velocity of a start: beyond, no digit of an impact's phase is left."""

_NOISE = 1e-12  # a gap this small, relative to the displacements, is a bar on the wall


class ModalImpact(Protocol):
    """The elastic modes of a steady motion at its impact."""

    @property
    def rebound(self) -> Array: ...
    @property
    def z_velocity(self) -> Array: ...
    @property
    def forced_velocity(self) -> Array: ...


class ModalOrbit(Protocol):
    """What a start needs of a steady motion; an `Orbit` has it."""

    @property
    def system(self) -> System: ...
    @property
    def phase(self) -> float: ...
    @property
    def rigid_velocity(self) -> float: ...
    def modal_state(self, modes: int) -> ModalImpact: ...


@dataclass(frozen=True)
class Start:
    """The start of a motion. Make one with `rigid`, `modal`, `field` or `orbit`.

    Parameters
    ----------
    displacement, velocity
        u_n and u_n', n = 0, 1, …, of shape (n,), dimensionless; what a simulation has more of modes is 0.
        `u(x) = u_0 + Σ φ_n(x) φ_n(x_p) u_n`, B77's u_n: `u_0 + 2 Σ u_n cos nπx` on a uniform bar driven at its end.
    time
        Load phase (rad) at which the motion starts; any number, the clock of the events counts on from it.
    gap
        u(1), the place of the striking end; None takes it from the modes that the simulation keeps.
    source
        A steady motion that gives the state, which is then added to `displacement` and `velocity`.
    profile
        Displacement and velocity along the bar, in place of their modes.
    valve_state
        The state of a machine's valve; that with which the valve starts by default.
    orders
        The last demand on a valve, and the orders that wait, by the time that is left to each. None by default: there
        are no orders, the state was the last demand, and ports whose region is occupied demand at once, in their order.
        Where orders are given the ports have demanded before.
    modes
        N, of which the amplitudes are: a simulation with another number is refused. None: what it has more of is 0.
    pressure
        Of the supply of a machine, as a multiple of that for which its forces hold; None for what its supply says.

    Examples
    --------
    >>> Start.rigid(position=-1.0, time=0.3)
    Start.rigid(position=-1.0, velocity=0.0, time=0.3)
    """

    displacement: tuple[float, ...] = (0.0,)
    velocity: tuple[float, ...] = (0.0,)
    time: float = 0.0
    gap: float | None = None
    source: ModalOrbit | None = None
    profile: tuple[Profile, Profile] | None = None
    valve_state: str | None = None
    orders: Orders | None = None
    modes: int | None = None
    pressure: float | None = None

    def __post_init__(self) -> None:
        object.__setattr__(self, "time", finite("time", self.time))
        if abs(self.time) > MOST:
            raise ParameterError("time", self.time, f"a load phase of at most {MOST:g} radians")
        for name in ("displacement", "velocity"):
            values = number_tuple(name, getattr(self, name))
            if max(map(abs, values)) > MOST:
                raise ParameterError(name, max(values, key=abs), f"numbers of at most {MOST:g}")
            object.__setattr__(self, name, values)
        if self.source is not None:
            having("source", self.source, ("modal_state", "phase", "system"), "a steady motion, or None")
        if self.profile is not None and not (isinstance(self.profile, tuple) and len(self.profile) == 2):
            raise ParameterError("profile", self.profile, "displacement and velocity along the bar: see Start.field")
        if self.gap is not None:
            object.__setattr__(self, "gap", _not_beyond(finite("position", self.gap)))
        if self.modes is not None:
            object.__setattr__(self, "modes", count("modes", self.modes, least=0, most=MAX_MODES))
        if self.pressure is not None:
            object.__setattr__(self, "pressure", non_negative("pressure", self.pressure))
        if self.valve_state is not None:
            text("valve_state", self.valve_state, "the name of a state")
        if self.orders is not None:
            times = [time for time, _ in instance("orders", self.orders, Orders).pending]
            if any(time < 0.0 for time in times) or times != sorted(times):
                raise ParameterError("orders", self.orders, "orders that are due from now on, in order")

    # -- ways to make one --

    @classmethod
    def rigid(cls, position: float = -1.0, velocity: float = 0.0, time: float = 0.0) -> Start:
        """An undeformed bar at `position` ≤ 0, all of it with one velocity.

        A body that is held is bent by a force at its contact until this is at `position`, and moves in that shape.

        Parameters
        ----------
        position, velocity
            Of the bar; dimensionless (lengths of the bar, and those per radian). The wall is at 0.
        time
            Load phase in radians.
        """
        place = _not_beyond(finite("position", position))
        return cls((place,), (finite("velocity", velocity),), time, gap=place)

    @classmethod
    def modal(cls, displacement: npt.ArrayLike, velocity: npt.ArrayLike | None = None, time: float = 0.0) -> Start:
        """Full modal vectors u_n and u_n', n = 0 … N, for simulations with N modes: other numbers are refused."""
        u = number_tuple("modal_displacement", displacement)
        v = (0.0,) * len(u) if velocity is None else number_tuple("modal_velocity", velocity)
        if len(u) != len(v):
            raise ParameterError("modal_velocity", f"{len(v)} numbers", f"as many as modal_displacement: {len(u)}")
        return cls(u, v, time, modes=len(u) - 1)

    @classmethod
    def field(cls, displacement: Profile, velocity: Profile = 0.0, time: float = 0.0) -> Start:
        """Displacement u(x) and velocity u_t(x) along the bar, x = 0 at the driven and 1 at the striking end.

        Parameters
        ----------
        displacement, velocity
            A function of an array of x, or values at equal steps from x = 0 to 1 (straight between them), or a number.
            The place u(1) of the striking end is kept whatever the number of modes.
        time
            Load phase in radians.
        """
        profile = (sampled("displacement", displacement), sampled("velocity", velocity))
        # a wrong velocity is told of here, too
        end, _ = (float(values_at(part, np.array([1.0]))[0]) for part in profile)
        return cls(time=time, gap=finite("displacement(1)", end), profile=profile)

    @classmethod
    def orbit(cls, orbit: ModalOrbit, displacement: npt.ArrayLike = (0.0,), velocity: npt.ArrayLike = (0.0,)) -> Start:
        """Just after the impact of a steady motion, plus a perturbation of u_n and u_n', n = 0, 1, …

        A perturbation of displacement moves the striking end off the wall: it must not move it beyond.
        """
        having(
            "orbit", orbit, ("modal_state", "system"), "a steady motion, such as one of steady_states(system).orbits"
        )
        du, dv = number_tuple("displacement", displacement), number_tuple("velocity", velocity)
        return cls(du, dv, float(orbit.phase), source=orbit)

    @classmethod
    def random(
        cls, system: System, seed: int = 0, distribution: str = "rigid", modes: int = DEFAULT_RANDOM_MODES
    ) -> Start:
        """One start drawn from a named distribution; see `Starts.random`."""
        u, v, gap, time = drawn(system, 1, seed, distribution, modes)
        return cls(tuple(u[0].tolist()), tuple(v[0].tolist()), float(time[0]), gap=float(gap[0]))

    # -- the state --

    def at(self, time: float) -> Start:
        """The same state at another phase of the load."""
        return replace(self, time=time)

    def with_valve(self, state: str | None = None, orders: Orders | None = None) -> Start:
        """The same state of the bar, and one of the valve of a machine; see the parameters.

        Examples
        --------
        >>> Start.rigid(-0.3).with_valve("power").valve_state
        'power'
        """
        return replace(self, valve_state=state, orders=orders)

    def valve_of(self, machine: Machine) -> tuple[str, Orders]:
        """The state of the valve, and the orders, of a machine that has these states."""
        names = [name for name, _ in instance("machine", machine, Machine).valve.pairs]
        state = machine.valve.start if self.valve_state is None else self.valve_state
        orders = Orders(state or names[0]) if self.orders is None else self.orders
        for name in (state, orders.last, *(to for _, to in orders.pending)):
            if name not in names:
                raise ParameterError("state", name, f"one of {', '.join(map(repr, names[:6]))}")
        assert state is not None
        return state, orders

    def state(self, modes: int, system: System | Machine | None = None) -> tuple[Array, Array, float]:
        """u_n and u_n', n = 0 … `modes`, each of shape (modes+1,), and the gap y = u(1) ≤ 0.

        Parameters
        ----------
        system
            Whose modes they are; those of a uniform bar, driven at its end, by default.
        """
        size = count("modes", modes, least=0, most=1 << 20) + 1
        if self.modes not in (None, modes):
            remedy = "give amplitudes of as many, zeros for those that are not known"
            raise ParameterError("modes", modes, f"{self.modes}, of which the start has the amplitudes", remedy)
        if system is not None and not isinstance(system, Machine):
            instance("system", system, System)
        u, v = np.zeros(size), np.zeros(size)
        for name, given, into in (("displacement", self.displacement, u), ("velocity", self.velocity, v)):
            if self.gap is None and len(given) > size and any(given[size:]):
                raise ParameterError(
                    f"modal_{name}", f"{len(given)} numbers", f"at most {size} (modes 0 to {modes})", "use more modes"
                )
            into[: min(len(given), size)] = given[:size]
        body, place = (UniformBar(1.0), 0) if system is None else (system.body, place_of(system))
        elastic = body.modes(modes, place)
        unit = units(elastic)
        if isinstance(body, HeldBody) and self.source is None:
            return self._of_structure(body, place, modes, unit, u, v)
        if self.profile is not None:
            u, v = (modal_parts(profile, body, unit) for profile in self.profile)
        if self.source is not None:
            own = getattr(self.source, "requested_modes", getattr(self.source, "modes", None))
            if own not in (None, modes):  # that of a continuous bar has as many as are wanted
                raise ParameterError("modes", modes, f"{own}, the modes of the orbit from which the motion starts")
            at = self.source.modal_state(size - 1)
            driven = elastic.gamma / unit  # 1, and next to nothing where the load acts at a node of the mode
            v[1:] += (at.z_velocity + at.forced_velocity) * driven
            v[0] += self.source.system.contact.velocity_factor * self.source.rigid_velocity
            moved = float(u[0] + unit @ u[1:])
            u[1:] += at.rebound * driven
            if isinstance(body, HeldBody):  # on the wall of this system, which may stand elsewhere
                u[1:] += (body.gap - self.source.system.body.gap) * body.bent(modes, place) * driven
            u[0] = moved - float(unit @ u[1:])
            return u, v, _on_wall(moved, float(np.abs(u).max()))
        gap = float(u[0] + unit @ u[1:]) if self.gap is None else self.gap
        gap = _on_wall(gap, float(np.abs(u).max()))
        u[0] = gap - float(unit @ u[1:])
        return u, v, gap

    def _of_structure(
        self, body: HeldBody, at: int, modes: int, unit: Array, u: Array, v: Array
    ) -> tuple[Array, Array, float]:
        """`state` of a body that is held, of which u_0 is −g whatever is given."""
        if self.profile is not None:
            raise ParameterError("displacement", "along a bar", "a start of modes for a body that is held")
        given = len(self.displacement) > 1 or self.gap is None
        gap = self.gap if self.gap is not None else float(unit @ u[1:]) - body.gap
        gap = _on_wall(gap, float(np.abs(u).max()) + abs(body.gap))
        rows = (u[None], v[None]) if given else (u[None, :1], v[None, :1])
        u_rows, v_rows = state_of(body, at, modes, *rows, np.array([gap]))
        return u_rows[0], v_rows[0], gap

    def __repr__(self) -> str:
        orders = "" if self.orders is None else f", {self.orders!r}"
        valve = "" if self.valve_state is None and not orders else f".with_valve({self.valve_state!r}{orders})"
        if self.profile is not None:
            return f"Start.field(…, time={self.time!r}){valve}"
        if self.source is not None:
            return f"Start.orbit({self.source}, …){valve}"
        if len(self.displacement) == 1:
            place, velocity = self.displacement[0], self.velocity[0]
            return f"Start.rigid(position={place!r}, velocity={velocity!r}, time={self.time!r}){valve}"
        return f"Start.modal({len(self.displacement)} modes, time={self.time!r}){valve}"


@lru_cache(maxsize=16)
def _unloaded(machine: Machine) -> System:
    return System(machine.body, Load(np.array([0.0]), at=machine.at), machine.contact)


def still(hammer: System | Machine) -> System:
    """The system itself; of a machine its bar under no load, whose modes the amplitudes are."""
    return hammer if isinstance(hammer, System) else _unloaded(hammer)


def place_of(hammer: System | Machine) -> int:
    """Where a load or a valve acts: the number of the place on the bar."""
    return hammer.at if isinstance(hammer, Machine) else hammer.load.at


def _not_beyond(position: float) -> float:
    if position > 0.0:
        raise ParameterError("position", position, "0 (on the wall) or less", "the bar is on the negative side")
    return position


def _on_wall(gap: float, size: float) -> float:
    """The gap, and 0 for what is rounding of it."""
    if abs(gap) <= _NOISE * size:
        return 0.0
    if gap > 0.0:
        raise ParameterError("gap", gap, "a striking end at or before the wall, u(1) ≤ 0", "lower u_0")
    return gap


# ---- Many starts at once, as columns


@dataclass(frozen=True)
class Starts(ShortRepr):
    """Starts of many motions. Make one with `rigid`, `of` or `random`.

    Parameters
    ----------
    displacement, velocity
        u_n and u_n' of each start, shape (starts, n); what a simulation has more of modes is 0. Dimensionless.
    gap
        u(1) ≤ 0 of each, shape (starts,): it holds whatever the number of modes.
    time
        Load phase (rad) of each, shape (starts,).
    states, state
        Of a machine the names of its valve's states, and the number of each start's, shape (starts,) or one for all.
        No orders wait, and the ports whose region is occupied demand at once.
    """

    displacement: Array
    velocity: Array
    gap: Array
    time: Array
    states: tuple[str, ...] = ()
    state: npt.NDArray[np.int64] | None = None

    def __post_init__(self) -> None:
        for name, dimensions in (("displacement", 2), ("velocity", 2), ("gap", 1), ("time", 1)):
            given = getattr(self, name)
            if not (isinstance(given, np.ndarray) and given.dtype == float):
                given = numbers(name, given, f"finite numbers of at most {MOST:g}")
            values = np.array(given, order="C")
            rows = self.displacement.shape[0] if name != "displacement" else values.shape[0] if values.ndim else 1
            if values.ndim != dimensions or values.shape[0] != rows:
                accepted = f"an array of {rows} rows, {dimensions}-dimensional"
                raise ParameterError(name, f"shape {values.shape}", accepted)
            if not np.all(np.abs(values) <= MOST):
                raise ParameterError(name, values, f"finite numbers of at most {MOST:g}")
            values.setflags(write=False)
            object.__setattr__(self, name, values)
        if self.displacement.shape[1] < 1 or self.velocity.shape[1] < 1:
            raise ParameterError("displacement", f"shape {self.displacement.shape}", "at least u_0 of each start")
        if np.any(self.gap > 0.0):
            raise ParameterError("gap", float(self.gap.max()), "0 (on the wall) or less")
        if self.state is not None or self.states:
            self._check_states()

    def _check_states(self) -> None:
        names = tuple(text("states", name) for name in several("states", self.states, "the names of the states"))
        given, shape = numbers("state", self.state, "numbers of states"), (len(self),)
        if given.shape not in ((), shape):
            raise ParameterError("state", f"shape {given.shape}", f"one for each of the {shape[0]} starts, or one")
        found = np.array(np.broadcast_to(given, shape), dtype=np.int64)
        if not names or np.any(found != given) or np.any((found < 0) | (found >= len(names))):
            raise ParameterError("state", self.state, f"whole numbers from 0 to {len(names) - 1}")
        found.setflags(write=False)
        object.__setattr__(self, "states", names)
        object.__setattr__(self, "state", found)

    def with_valve(self, state: npt.ArrayLike, states: Sequence[str]) -> Starts:
        """The same states of the bars, and those of a machine's valve: their numbers in the order of `states`.

        Examples
        --------
        >>> starts = Starts.rigid([-0.2, -0.9]).with_valve([0, 1], ("return", "power"))
        >>> [start.valve_state for start in starts]
        ['return', 'power']
        """
        return replace(self, state=np.asarray(state), states=several("states", states, "names"))

    # -- ways to make them --

    @classmethod
    def rigid(cls, position: npt.ArrayLike = -1.0, velocity: npt.ArrayLike = 0.0, time: npt.ArrayLike = 0.0) -> Starts:
        """Undeformed bars at `position` ≤ 0 with one velocity; the three are broadcast against each other."""
        given = numbers("position", position), numbers("velocity", velocity), numbers("time", time)
        try:
            columns = np.broadcast_arrays(*given)
        except ValueError:
            raise ParameterError("position", position, "numbers, and shapes that go with velocity and time") from None
        if not columns[0].size:
            raise ParameterError("position", position, "one or more starts")
        u, v, t = (column.reshape(-1) for column in columns)
        return cls(u[:, None], v[:, None], u, t)

    @classmethod
    def of(cls, starts: Sequence[Start], modes: int, systems: Sequence[System] = ()) -> Starts:
        """Single starts joined, for simulations with `modes` modes of one system, or of as many as starts."""
        listed = several("starts", starts, "one or more starts")
        checked = [instance("starts", start, Start) for start in listed]
        systems = [instance("systems", system, System) for system in several("systems", systems, "a list of systems")]
        apart = len({(system.body, system.load.at) for system in systems}) > 1
        if apart and len(checked) == 1:
            checked *= len(systems)
        whose = systems if apart and len(systems) == len(checked) else [*systems, None][:1] * len(checked)
        states = [start.state(modes, system) for start, system in zip(checked, whose, strict=True)]
        if not states:
            raise ParameterError("starts", starts, "one or more starts")
        u, v, gap = (np.array([state[i] for state in states]) for i in range(3))
        return cls(u, v, gap, np.array([start.time for start in checked]))

    @classmethod
    def random(
        cls, system: System, size: int, *, seed: int = 0, distribution: str = "rigid", modes: int = DEFAULT_RANDOM_MODES
    ) -> Starts:
        """Starts drawn from a named distribution; the same seed gives the same starts.

        With the speed scale P = Σ|p_k| of the load, each number uniform and independent of the others:

        ``rigid``
            position from −5P to 0, velocity from −3P to 3P, load phase from 0 to 2π;
        ``still``
            the same with velocity 0;
        ``ringing``
            as ``rigid``, with elastic modes n = 1 … `modes` besides: velocity amplitudes normal with standard deviation
            P/(3n), phases from 0 to 2π. Position and velocity are those of the striking end and of the bar's mean.

        Parameters
        ----------
        system
            Whose load sets the scale.
        """
        return cls(*drawn(system, size, seed, distribution, modes))

    # -- as a sequence --

    @property
    def valves(self) -> list[Start]:
        """Starts with the states of the valves, of bars at rest on the wall."""
        known = [Start(valve_state=name) for name in self.states or (None,)]
        return [known[i] for i in (np.zeros(len(self), dtype=int) if self.state is None else self.state).tolist()]

    def __len__(self) -> int:
        return int(self.gap.size)

    @overload
    def __getitem__(self, i: int) -> Start: ...
    @overload
    def __getitem__(self, i: slice | npt.NDArray[np.int64] | npt.NDArray[np.intp]) -> Starts: ...
    def __getitem__(self, i: int | slice | npt.NDArray[np.int64] | npt.NDArray[np.intp]) -> Start | Starts:
        if isinstance(i, slice | np.ndarray):
            state = None if self.state is None else self.state[i]
            bars = self.displacement[i], self.velocity[i], self.gap[i], self.time[i]
            return Starts(*bars, self.states, state)
        return Start(
            tuple(self.displacement[i].tolist()),
            tuple(self.velocity[i].tolist()),
            float(self.time[i]),
            gap=float(self.gap[i]),
            valve_state=None if self.state is None else self.states[int(self.state[i])],
        )

    def __iter__(self) -> Iterator[Start]:
        return (self[i] for i in range(len(self)))


def states_of(starts: Starts | Sequence[Start], modes: int, machine: Machine) -> tuple[Array, Array, Array]:
    """`Start.state` of all: u_n and u_n', n = 0 … N, each of shape (starts, N+1), and the gaps."""
    if not isinstance(starts, Starts):
        u, v, gap = (np.array(part) for part in zip(*(start.state(modes, machine) for start in starts), strict=True))
        return u, v, gap
    u, v = np.zeros((2, len(starts), modes + 1))
    for given, into in ((starts.displacement, u), (starts.velocity, v)):
        into[:, : given.shape[1]] = given[:, : modes + 1]
    gap = np.where(np.abs(starts.gap) <= _NOISE * np.abs(u).max(axis=1), 0.0, starts.gap)
    u[:, 0] = gap - np.matmul(units(machine.body.modes(modes, machine.at)), u[:, 1:, None])[:, 0]
    return u, v, gap
