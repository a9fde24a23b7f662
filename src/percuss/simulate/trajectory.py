"""A simulated motion: what happened, where the bar is at any time, its energy and its sections; `run` makes one."""

from __future__ import annotations

import os
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import pairwise
from typing import TYPE_CHECKING, Any, Literal, cast

import numpy as np
import numpy.typing as npt

from percuss.errors import ParameterError, PercussError, extra_package
from percuss.model import Machine, System
from percuss.model.checks import DEFAULT_MODES, Array, array, callback, choice, count, finite, instance, unit_interval
from percuss.model.load.valve import Orders, port_at
from percuss.short_repr import ShortRepr, watched
from percuss.simulate.events import (
    CHATTER,
    IMPACT,
    KINDS,
    PORT,
    RELEASE,
    REST,
    VALVE,
    Events,
    MotionCycle,
    Summary,
    main_blows,
    summary_of,
    unresolved,
)
from percuss.simulate.spectrum import Anchor, ClockedFlights, ModalMotion, Moment, Spectrum, panels, spectrum_of
from percuss.simulate.start import Start, still
from percuss.simulate.stop import MAX_MODES, Stop, further

if TYPE_CHECKING:
    import pandas
    import xarray

    from percuss.simulate.engine import Clocked, Progress
    from percuss.simulate.oil import FlowingOil, OilFlights
    from percuss.simulate.valve import Mechanism, SelfSwitching

_TURN = 2.0 * np.pi
_LOOKS = 16  # at a motion for its crossings, in the shortest period of its modes and its load
_AT_ONCE = 1 << 20  # numbers of modes
_MOST_STEPS, _EPS = 60, 2.0**-51  # of the search for a root, and its last one, of the time
_SAME_TIME = 1e-9  # of the time since an order was given: one that is due is carried out

Side = Literal["left", "right"]


@dataclass(frozen=True)
class EnergyBalance(ShortRepr):
    """Energy between two instants; dimensionless, of a machine per unit of mass.

    Attributes
    ----------
    input
        Work of the load; of a machine that of the valve or, with a supply, of the pump, with the constant part of the
        chamber's force: the rest of the chamber's is `stored`, as ½κu(0)².
    damping, impacts
        Taken by damping, and by impacts, chatter and rest.
    stored
        Rise of the kinetic and elastic energy of the bar, and of that of a chamber and an accumulator.
    rests
        Of `impacts`, what lying down takes, with the end of chatter: motion and strain that the last blow left.
    """

    input: float
    damping: float
    impacts: float
    stored: float
    rests: float = 0.0

    @property
    def imbalance(self) -> float:
        """Input less damping, impacts and what is stored: 0 but for rounding."""
        return self.input - self.damping - self.impacts - self.stored


@dataclass(frozen=True)
class Trajectory(ShortRepr):
    """A simulated motion; made by `run`, and by `Trajectory.load` from a file.

    Of a system all quantities are dimensionless (theory §1): lengths in bar lengths, times in radians of the load's
    fundamental. Times are absolute: `begin_time` is the load phase of the start, and the load has phase t at the time
    t. Of a machine lengths are those of the bar, times in the machine's unit: seconds for a machine made from SI, with
    energies per kilogram of it and bar length squared, see `Machine`.

    Attributes
    ----------
    hammer, modes
        What moved, and N, the number of its elastic modes; see `system` and `machine`.
    states
        The state after each event in the form of the engine, shape (events, 2N + 2): gap, u_0', amplitudes; see
        `displacement` and `velocity` for u_n and u_n'. Of a machine with a supply one number more, see `pressure`.
    start, resting
        The state at the start, in the same form, and whether the bar rests on the wall there.
    outcome
        How it ended: one of `percuss.simulate.OUTCOMES`.
    label
        What motion it is at the end: ``z=p/n`` (p impacts in n load periods, no rest), ``chatter/n`` (a cycle of n
        load periods with complete chatter and rest), ``rest/n`` (with rest, but finitely many impacts), ``rest`` (for
        good), ``departed``, ``aperiodic`` (the last 64 impacts come back to no state up to 32 impacts before, to 1e-3
        of phase and speed), ``undecided``; ``rest/?`` or ``chatter/?`` where `period_unresolved`. Of a machine
        ``runs p/n``, p blows and n valve cycles in a period; ``double blow p/n`` with 2 blows or more in a valve cycle;
        ``runs rest/n``, ``runs chatter/n``; ``cycles without blow``; ``stalls (…)``, see `percuss.simulate.STALLS`;
        ``irregular``, or ``undecided`` where too little was followed to tell.
    cycle
        The periodic motion, or None when none was found.
    begin_time, end_time
        First and last time for which the motion is known.
    snapshot
        What `continued` goes on from.
    """

    hammer: System | Machine
    modes: int
    events: Events
    states: Array
    start: Anchor
    resting: bool
    snapshot: dict[str, npt.NDArray[Any]]
    outcome: str
    label: str
    cycle: MotionCycle | None
    stop: Stop
    begin_time: float
    end_time: float

    # -- what moved --

    @property
    def is_clocked(self) -> bool:
        """Whether a clock drives it, and no valve of its own."""
        return isinstance(self.hammer, System)

    @property
    def system(self) -> System:
        """The system that moved; PercussError when it was a machine."""
        if not isinstance(self.hammer, System):
            raise PercussError("a machine that switches its own valve is no system under a clock", "ask for machine")
        return self.hammer

    @property
    def machine(self) -> Machine:
        """The machine that moved; PercussError when it was a system under a clock."""
        if not isinstance(self.hammer, Machine):
            raise PercussError("a system under a clock is no machine that switches its own valve", "ask for system")
        return self.hammer

    @cached_property
    def spectrum(self) -> Spectrum:
        """Frequencies and forced response of the modes; of a machine, of its bar without a load."""
        return spectrum_of(still(self.hammer), self.modes)

    @cached_property
    def mechanism(self) -> Mechanism:
        """The numbers of a machine."""
        from percuss.simulate.valve import mechanism

        return mechanism(self.machine, self.modes)

    @cached_property
    def _flights(self) -> ClockedFlights | Mechanism | OilFlights:
        if isinstance(self.hammer, System):
            return ClockedFlights(self.spectrum)
        return self._oil or self.mechanism

    @property
    def _closed(self) -> ClockedFlights | Mechanism:
        """The flights of what has a closed form."""
        found = self._flights
        assert self._oil is None
        return cast("ClockedFlights | Mechanism", found)

    @cached_property
    def _oil(self) -> OilFlights | None:
        """The flights of a machine whose oil flows."""
        if not (isinstance(self.hammer, Machine) and self.hammer.valve.flows):
            return None
        from percuss.simulate.oil import OilFlights

        return OilFlights(self.hammer, self.modes)

    def _looked(self, times: Array) -> tuple[Array, Array]:
        """Pressure and force of oil that flows."""
        assert self._oil is not None
        pressure, force, last = np.empty(times.size), np.empty(times.size), self._last(times)
        for i in np.unique(last):
            here = last == i
            anchor = self._anchor(int(i))
            since = np.maximum(times[here] - anchor.phase, 0.0)
            _, pressure[here], force[here] = self._oil.looked(anchor, since)
        return pressure, force

    # -- what happened --

    @property
    def impacts(self) -> int:
        """The number of impacts."""
        return int(np.count_nonzero(self.events.code == IMPACT))

    @property
    def blow_times(self) -> Array:
        """When the impacts fall; shape (impacts,)."""
        return self.events.of("impact").time

    @property
    def blow_speeds(self) -> Array:
        """Striking speed of each impact; shape (impacts,)."""
        return self.events.of("impact").impact_velocity

    @property
    def blow_energies(self) -> Array:
        """Kinetic energy just before each impact; shape (impacts,)."""
        return self.events.of("impact").kinetic_energy

    @property
    def main_blows(self) -> npt.NDArray[np.bool_]:
        """Which impacts are main blows: a completed chatter counts once. Shape (impacts,)."""
        return main_blows(self.events)

    @property
    def period_unresolved(self) -> bool:
        """Whether the motion repeats, as it was released twice in the same state, in a time that hangs on rounding."""
        return self.is_clocked and self.cycle is None and unresolved(self.snapshot["count"]) > 0

    @cached_property
    def summary(self) -> Summary:
        """Blow rate, its scatter, energies of a system's motion; in SI besides for one made from SI."""
        return summary_of(self.system, self.events, self.cycle, over=self.outcome in ("rest", "departed"))

    @property
    def transient(self) -> int | None:
        """Impacts before the periodic motion; None when none was found."""
        return None if self.cycle is None else self.cycle.first

    # -- the state --

    def _anchor(self, i: int) -> Anchor:
        if i < 0:
            return self.start
        return Anchor(float(self.events.phase[i]), int(self.events.piece[i]), self.states[i])

    @cached_property
    def lies(self) -> npt.NDArray[np.bool_]:
        """Whether the bar rests on the wall after the start and each event; a valve may change while it does."""
        codes = np.concatenate([[REST if self.resting else RELEASE], self.events.code])
        told = np.where((codes == REST) | (codes == RELEASE) | (codes == IMPACT), np.arange(codes.size), 0)
        return np.asarray(codes[np.maximum.accumulate(told)] == REST)

    def _last(self, times: Array, side: Side = "right") -> npt.NDArray[np.intp]:
        """The number of the event that each time follows; −1 is the start."""
        if times.size and not (self.begin_time <= times.min() and times.max() <= self.end_time):
            accepted = f"times from {self.begin_time:.6g} to {self.end_time:.6g}"
            raise ParameterError("t", f"{times.min():.6g} … {times.max():.6g}", accepted, "simulate for longer")
        return np.searchsorted(self.events.time, times, side=side) - 1

    @cached_property
    def _modal_states(self) -> tuple[Array, Array]:
        return self._flights.states(self.states, self.events.phase, self.events.piece)

    @property
    def displacement(self) -> Array:
        """u_n after each event, n = 0 … N; shape (events, N+1)."""
        return self._modal_states[0]

    @property
    def velocity(self) -> Array:
        """u_n' after each event, n = 0 … N; shape (events, N+1)."""
        return self._modal_states[1]

    def modal(self, t: npt.ArrayLike, side: Side = "right") -> ModalMotion:
        """u_n(t) and u_n'(t), each of shape (N+1, len(t)).

        Parameters
        ----------
        t
            Times from `begin_time` to `end_time`.
        side
            At the time of an event: the state after it (``right``) or before it (``left``).
        """
        choice("side", side, "left", "right")
        times = array("t", t, -np.inf, np.inf)
        order = np.argsort(times, kind="stable")
        ordered = times[order]
        last = self._last(ordered, side)
        u, v = np.empty((self.modes + 1, times.size)), np.empty((self.modes + 1, times.size))
        for i in np.unique(last):
            here = np.flatnonzero(last == i)
            part = self._between(int(i), ordered[here])
            u[:, order[here]], v[:, order[here]] = part.displacement, part.velocity
        return ModalMotion(u, v)

    def _between(self, i: int, times: Array) -> ModalMotion:
        nothing = np.zeros((self.modes + 1, times.size))
        lies = self.lies[i + 1]
        if lies and (i < 0 or not isinstance(self.hammer, System) or self.hammer.body.is_free):
            return ModalMotion(nothing, nothing)
        if lies and self.modes > 1:
            from percuss.mechanics.held_structure import held_structure

            at = self._anchor(i)
            periods = self.events.period[i]
            since = np.maximum((times - periods * _TURN) - at.phase, 0.0)
            unit, shape = self.spectrum.unit[:, None], self._at(i)
            state = unit[:, 0] * shape[1:], nothing[1:, 0]
            place, rate = held_structure(self.system, self.modes).after(at.phase, at.piece, state, since)
            return ModalMotion(np.vstack([shape[0] + nothing[:1], place / unit]), np.vstack([nothing[:1], rate / unit]))
        # a structure of one mode rests as it was struck last; infinitely many bounces of less than 1e-9 are none
        if lies or (i + 1 < len(self.events) and self.events.code[i + 1] == CHATTER):
            return ModalMotion(self._at(i)[:, None] + nothing, nothing)
        if i >= 0:
            periods, phase = self.events.period[i], self.events.phase[i]
        else:
            periods, phase = divmod(self.begin_time, _TURN) if self.is_clocked else (0.0, self.begin_time)
        return self._flights.after(self._anchor(i), np.maximum((times - periods * _TURN) - phase, 0.0))

    def _at(self, i: int) -> Array:
        at = self._anchor(i)
        displacement, _ = self._flights.states(at.row[None], np.array([at.phase]), np.array([at.piece]))
        return np.asarray(displacement[0])

    def state(self, t: npt.ArrayLike) -> npt.NDArray[np.int64]:
        """The number of the state of a machine's valve, or of the step of a load; shape (len(t),)."""
        times = array("t", t, -np.inf, np.inf)
        last = self._last(times)
        if isinstance(self.hammer, Machine):
            return np.append(self.events.piece, self.start.piece)[last]
        load = self.hammer.load
        return np.asarray(load.piece(times) if load.is_piecewise else np.zeros(times.size), dtype=np.int64)

    def _moment(self, t: Array, side: Side = "right") -> Moment:
        modes, piece = self.modal(t, side), self.state(t)
        fed = isinstance(self.hammer, Machine) and self.hammer.valve.supply is not None
        return Moment(t, modes, piece, self._pressure(t, modes, piece) if fed else None)

    def _pressure(self, t: Array, modes: ModalMotion, piece: npt.NDArray[np.int64]) -> Array:
        if self._oil is not None:
            return self._looked(t)[0]
        last = self._last(t)
        since = np.maximum(t - np.append(self.events.time, self.begin_time)[last], 0.0)
        charge = np.append(self.states[:, -1], self.start.row[-1])[last]
        return self.mechanism.pressure(piece, charge, since, modes.displacement)

    def pressure(self, t: npt.ArrayLike) -> Array:
        """The pressure of a supply, as a multiple of that for which the forces of the states hold; shape (len(t),).

        Raises
        ------
        ParameterError
            For times outside the simulated ones.
        PercussError
            When a pump and an accumulator do not feed it.
        """
        if self.machine.valve.supply is None:
            raise PercussError("the pressure of a machine without a supply does not change", "ask for force")
        times = array("t", t, -np.inf, np.inf)
        return self._pressure(times, self.modal(times), self.state(times))

    # -- fields --

    def position(self, x: npt.ArrayLike, t: npt.ArrayLike) -> Array:
        """u(x, t), with the wall at u = 0; shape (len(x), len(t))."""
        return self._shapes(x) @ self.modal(t).displacement

    def bar_velocity(self, x: npt.ArrayLike, t: npt.ArrayLike, side: Side = "right") -> Array:
        """u_t(x, t); shape (len(x), len(t))."""
        return self._shapes(x) @ self.modal(t, side).velocity

    def strain(self, x: npt.ArrayLike, t: npt.ArrayLike) -> Array:
        """u_x(x, t), negative in compression; shape (len(x), len(t)). 0 in a bar that rests on the wall.

        The free motion has N modes; the forced one is summed over all of them, so that −s² u_x(0, t) = p(t).
        """
        places, times = array("x", x, 0.0, 1.0), array("t", t, -np.inf, np.inf)
        slopes = self.spectrum.system.body.shapes(places, self.modes).strain * self.spectrum.unit
        found = slopes @ self.modal(times).displacement[1:]
        flies = ~self._rests(times)
        if isinstance(self.hammer, Machine):
            mean = self.force(times[flies])
        else:
            load = self.hammer.load
            steps = np.asarray(load.values)
            mean = steps[load.piece(times[flies])] if steps.size else np.full(int(flies.sum()), load.mean)
        found[:, flies] += self.spectrum.forced_strain_beyond(places, times[flies], mean)
        return np.asarray(found)

    def gap(self, t: npt.ArrayLike) -> Array:
        """Gap function y(t) = u(1, t): 0 at contact, negative between; shape (len(t),).

        After a release, for the time of one wave and as long as the load pulls, the ripple of a finite number of modes
        may show above 0.
        """
        return np.asarray(self.position(1.0, t)[0])

    def centre(self, t: npt.ArrayLike) -> Array:
        """Position of the centre of mass, of a bar that is free; shape (len(t),)."""
        return np.asarray(self.modal(t).displacement[0])

    def force(self, t: npt.ArrayLike) -> Array:
        """Force on the driven end: the load or, of a machine, p_k − κu(0, t) with that of the chamber; (len(t),)."""
        times = array("t", t, -np.inf, np.inf)
        if self._oil is not None:
            return self._looked(times)[1]
        return self._closed.force(self._moment(times))

    def energy(self, t: npt.ArrayLike, side: Side = "right") -> Array:
        """Kinetic and elastic energy ½ ∫ u_t² dx + ½ s² ∫ u_x² dx of the bar; shape (len(t),).

        Of a machine that of its chamber besides, ½κu(0, t)², and of an accumulator, ½cπ².
        """
        at = self._moment(array("t", t, -np.inf, np.inf), side)
        weight = np.append(0.5, 0.5 * self.spectrum.weight)
        stiffness = 0.5 * self.spectrum.weight * self.spectrum.omega**2
        bar = weight @ at.modes.velocity**2 + stiffness @ at.modes.displacement[1:] ** 2
        return np.asarray(bar + self._flights.stored(at))

    def contact_force(self, t: npt.ArrayLike) -> Array:
        """Force with which a bar that rests presses on the wall, quasi-static p(t), or a structure; 0 elsewhere.

        Shape (len(t),).
        """
        times = array("t", t, self.begin_time, self.end_time)
        if self.spectrum.system.body.is_free:
            pressing = self.force(times)
        else:  # what would move the contact
            spectrum, at = self.spectrum, self.modal(times)
            moved = [spectrum.unit[:, None] * modes[1:] for modes in (at.displacement, at.velocity)]
            pull = spectrum.omega**2 @ moved[0] + spectrum.damping @ moved[1]
            pressing = (spectrum.elastic.gamma.sum() * self.force(times) - pull) / (1.0 / spectrum.inertia).sum()
        return np.where(self._rests(times), pressing, 0.0)

    def _rests(self, times: Array) -> npt.NDArray[np.bool_]:
        return self.lies[np.searchsorted(self.events.time, times, side="right")]

    def _shapes(self, x: npt.ArrayLike) -> Array:
        places = array("x", x, 0.0, 1.0)
        shapes = self.spectrum.system.body.shapes(places, self.modes).displacement * self.spectrum.unit
        return np.column_stack([np.ones(places.size), shapes])

    # -- another motion from here, and sections --

    def start_at(self, t: float, side: Side = "right") -> Start:
        """The state at a time as the start of another motion, of this hammer or another one, with as many modes.

        The amplitudes of the modes are kept: in another body they are another shape. `Start.field` of `position` and
        `bar_velocity` keeps the shape and takes any number of modes.

        Parameters
        ----------
        t
            From `begin_time` to `end_time`.
        side
            At the time of an event: the state after it (``right``) or before it (``left``).

        Examples
        --------
        >>> from percuss import Load, Start, Stop, System, run
        >>> system = System(s=20.0, d=0.01, restitution=0.6, load=Load.harmonic(0.7, 1.0))
        >>> motion = run(system, Start.rigid(-1.0), modes=2, stop=Stop(time=20.0))
        >>> harder = run(system.with_load_factor(0.8), motion.start_at(12.0), modes=2, stop=Stop(impacts=1))
        >>> harder.begin_time
        12.0
        """
        at = np.array([finite("t", t)])
        modes = self.modal(at, side)
        if self.modes > 1 and not self.spectrum.system.body.is_free and self.lies[self._last(at, side) + 1].any():
            remedy = "take a time at which it flies"
            raise PercussError("a structure that rests on the wall moves on, which no start can tell", remedy)
        start = Start.modal(modes.displacement[:, 0], modes.velocity[:, 0], float(at[0]))
        if not isinstance(self.hammer, Machine):
            return start
        valve, piece = self.hammer.valve, np.append(self.events.piece, self.start.piece)[self._last(at, side)]
        pressure = None if valve.supply is None else float(self._pressure(at, modes, piece)[0])
        state = valve.pairs[int(piece[0])][0]
        return replace(start, valve_state=state, orders=self._orders_at(float(at[0]), side), pressure=pressure)

    def _orders_at(self, time: float, side: Side) -> Orders:
        """The orders of a machine's valve at a time, as the record tells them; PercussError where it does not."""
        valve = self.machine.valve
        found, orders = None, Orders(valve.pairs[self.start.piece][0])
        near = _SAME_TIME * (abs(self.begin_time) + abs(self.end_time))
        pressure = self.pressure(self.events.time) if valve.delays_vary else np.ones(len(self.events))
        for i, event in enumerate(self.events):
            if found is None and (event.time > time or (event.time == time and side == "left")):
                found = orders
            changes = event.kind == "valve"
            if changes and not any(to == event.state and abs(due - event.time) <= near for due, to in orders.pending):
                raise PercussError("an order waited at the start of the motion, which is not in its record")
            carried_out = event.time + near if changes else event.time - near
            orders = replace(orders, pending=tuple(order for order in orders.pending if order[0] > carried_out))
            if event.port is not None:
                orders = orders.after(event.time, port_at(valve, event.port, float(pressure[i])))
        found = orders if found is None else found
        return replace(found, pending=tuple((max(due - time, 0.0), to) for due, to in found.pending))

    def section(
        self,
        *,
        phase: float | None = None,
        event: str | None = None,
        displacement: float | None = None,
        velocity: float | None = None,
        at: float = 1.0,
        direction: Literal["rising", "falling", "both"] = "both",
        side: Side = "right",
    ) -> PoincareSection:
        """A Poincaré section: the motion at one phase of the load, at its events, or where something has a value.

        One of the first four says which. Crossings are looked for 16 times in the shortest period of the modes and the
        load, and round each turn between two looks; what swings twice between them is missed.

        Parameters
        ----------
        phase
            Of the load, in radians: once in each of its periods.
        event
            A kind of events: ``impact``, ``rest``, ``release`` …, of a machine ``port`` and ``valve``.
        displacement, velocity
            A value of u(x, t), or of u_t(x, t).
        at
            x of the place that is looked at, 0 the driven and 1 the striking end.
        direction
            Which crossings: with a ``rising`` or a ``falling`` value, or ``both``.
        side
            The state after an event (``right``) or before it (``left``).

        Examples
        --------
        >>> from percuss import Load, Start, Stop, System, run
        >>> system = System(s=20.0, d=0.0048, restitution=0.6, load=Load.harmonic(0.7, 1.0))
        >>> motion = run(system, Start.rigid(-1.0, time=0.3), modes=2, stop=Stop(time=40.0, periodic=False))
        >>> len(motion.section(phase=0.0)), len(motion.section(displacement=-0.5, direction="rising"))
        (6, 6)
        """
        asked = {"phase": phase, "event": event, "displacement": displacement, "velocity": velocity}
        given = {name: value for name, value in asked.items() if value is not None}
        if len(given) != 1:
            raise ParameterError("section", ", ".join(given) or None, f"one of {', '.join(asked)}")
        choice("side", side, "left", "right")
        choice("direction", direction, "rising", "falling", "both")
        ((name, value),) = given.items()
        place = unit_interval("at", at)
        plane = f"{name} {value}" if event is not None else f"{name} = {finite(name, value):g}"
        if event is not None:
            choice("event", event, *(KINDS if self.events.states else KINDS[:PORT]))
            times = self.events.of(event).time
        elif phase is not None:
            if not self.is_clocked:
                raise ParameterError("phase", phase, "a load that keeps time", "ask for an event, such as 'impact'")
            first = np.ceil((self.begin_time - phase) / _TURN)
            times = phase + _TURN * np.arange(first, np.floor((self.end_time - phase) / _TURN) + 1.0)
            times = times[(times >= self.begin_time) & (times <= self.end_time)]
        elif displacement == 0.0 and place == 1.0:
            raise ParameterError("displacement", displacement, "a place before the wall", "ask for event='impact'")
        else:
            plane += f" at x = {place:g}, {direction}"
            times = self._crossings(name == "velocity", float(value), place, direction)
        modes, row = self.modal(times, side), self._shapes(place)[0]
        last = self._last(times, side)
        states, pressure = None, None
        if isinstance(self.hammer, Machine):
            piece = np.append(self.events.piece, self.start.piece)[last]
            states = np.array([state for state, _ in self.hammer.valve.pairs])[piece]
            pressure = None if self.hammer.valve.supply is None else self._pressure(times, modes, piece)
        u, v = modes.displacement, modes.velocity
        phases = times % _TURN if self.is_clocked else None
        return PoincareSection(plane, times, phases, row @ u, row @ v, u.T, v.T, states, pressure)

    def _crossings(self, of_velocity: bool, value: float, place: float, direction: str) -> Array:
        """The times at which u(x, t) or u_t(x, t) crosses a value, some flights at once."""
        row = self._shapes(place)[0]

        def rate(t: Array, side: Side = "right") -> Array:
            return np.asarray(row @ self.modal(t, side).velocity)

        def off(t: Array, side: Side = "right") -> Array:
            return np.asarray(rate(t, side) if of_velocity else row @ self.modal(t, side).displacement) - value

        begin, end = self.begin_time, self.end_time
        edges = np.unique(np.concatenate([[begin], self.events.time, self._flights.breaks(begin, end), [end]]))
        step = _TURN / (_LOOKS * self._flights.rates[0])
        looks = np.ceil(np.minimum(np.diff(edges) / step, _AT_ONCE)).astype(int) + _LOOKS
        groups = np.cumsum(looks) * (self.modes + 1) // _AT_ONCE
        found = [np.empty(0)]
        for group in np.unique(groups):
            flights = np.flatnonzero(groups == group)
            places = [np.linspace(edges[i], edges[i + 1], looks[i] + 1) for i in flights]
            a, b = (np.concatenate([t[part] for t in places]) for part in (np.s_[:-1], np.s_[1:]))
            last = np.cumsum(looks[flights]) - 1
            fa, fb = _at_both(off, a, b[last], last)
            if not of_velocity:  # what turns between two looks may have crossed twice
                va, vb = _at_both(rate, a, b[last], last)
                turns = np.flatnonzero((fa * va < 0.0) & (fb * vb > 0.0) & (fa * fb > 0.0))
                top = _roots(rate, a[turns], b[turns], va[turns], vb[turns])
                beyond = off(top) if top.size else top
                over = beyond * fa[turns] < 0.0
                turns, top, beyond = turns[over], top[over], beyond[over]
                a, b = np.append(a, top), np.append(b, b[turns])
                fa, fb = np.append(fa, beyond), np.append(fb, fb[turns])
                b[turns], fb[turns] = top, beyond
            crossed = (fa < 0.0) != (fb < 0.0)
            if direction != "both":
                crossed &= (fa < 0.0) == (direction == "rising")
            found.append(np.sort(_roots(off, a[crossed], b[crossed], fa[crossed], fb[crossed])))
        return np.concatenate(found)

    # -- energy --

    def energy_balance(self, first: float | None = None, last: float | None = None) -> EnergyBalance:
        """The energy that was put in and where it went, between two times (default: the whole motion).

        The work of the drive and of damping are integrated over the closed forms, flight by flight, with Gauss's rule.
        """
        begin = self.begin_time if first is None else finite("first", first)
        end = self.end_time if last is None else finite("last", last)
        if not self.begin_time <= begin <= end <= self.end_time:
            accepted = f"two times in order from {self.begin_time:.6g} to {self.end_time:.6g}"
            raise ParameterError("first, last", f"{begin:.6g}, {end:.6g}", accepted)
        times, flights = self.events.time, self._flights
        inside = (times > begin) & (times <= end)
        edges = np.unique(np.concatenate([[begin], times[inside], flights.breaks(begin, end), [end]]))
        put_in = lost = 0.0
        for a, b in pairwise(edges):
            if b - a <= 1e-14 * max(abs(a), abs(self.end_time - self.begin_time) if not self.is_clocked else 1.0):
                continue
            if self._oil is not None:
                anchor = self._anchor(int(self._last(np.array([a]))[0]))
                spent = [self._oil.spent(anchor, max(time - anchor.phase, 0.0)) for time in (a, b)]
                put_in, lost = put_in + spent[1][0] - spent[0][0], lost + spent[1][1] - spent[0][1]
                continue
            t, w = panels(a, b, *flights.rates)
            at = self._moment(t)
            put_in += float(w @ self._closed.put_in(at))
            lost += float(w @ self._closed.lost(at))
        lost_at = self.events.energy_lost
        lying = inside & np.isin(self.events.code, (CHATTER, REST))
        stored = self.energy(np.array([begin, end]))
        return EnergyBalance(
            put_in, lost, float(lost_at[inside].sum()), float(stored[1] - stored[0]), float(lost_at[lying].sum())
        )

    def __str__(self) -> str:
        count, gone = len(self.events), self.end_time - self.begin_time
        if not self.is_clocked:
            changes = int(np.count_nonzero(self.events.code == VALVE))
            what = f"{self.impacts} impacts and {changes} changes of the valve in {gone:.6g}"
        else:
            events = f"{count} event{'s' if count != 1 else ''}"
            what = f"{self.impacts} impacts, {events} in {gone / _TURN:.6g} load periods"
        return f"{type(self).__name__} {self.label}: {what}, {self.modes} modes, ended by {self.outcome}"

    # -- going on --

    def continued(self, stop: Stop | None = None, progress: Callable[[Progress], object] | None = None) -> Trajectory:
        """The same motion followed further, with the same bits as if it had never been interrupted.

        Parameters
        ----------
        stop
            The new rule; impacts and time count from the start of the motion, not from here. None: as many impacts
            again, whether a periodic motion is found or not.
        """
        from percuss.simulate.motion_files import continued

        callback("progress", progress)
        return replace(self, **continued(self, further(stop, self.stop, self.impacts), progress))

    # -- files --

    def to_xarray(self) -> xarray.Dataset:
        """The event table, the states and all that is needed to go on, with names and units."""
        from percuss.simulate.motion_files import to_dataset

        return to_dataset(self)

    def to_pandas(self) -> pandas.DataFrame:
        """The table of events, a row each: time, kind, and the columns of `Events`; of a machine the valve's state."""
        from percuss.simulate.motion_files import to_table

        return to_table(self)

    def save(self, path: str | os.PathLike[str]) -> None:
        """Write a NetCDF file that `Trajectory.load` reads."""
        from percuss.simulate.motion_files import write

        write(self, path)

    @classmethod
    def load(cls, path: str | os.PathLike[str]) -> Trajectory:
        """The motion in a NetCDF file; `continued` goes on from it bit for bit.

        Raises
        ------
        PercussError
            When the file cannot be read or is not a trajectory.
        """
        from percuss.simulate.motion_files import motion_from, opened

        loaded: Trajectory = motion_from(*opened(path), cls)
        return loaded


# ---- Poincaré sections


def _at_both(of: Callable[..., Array], begins: Array, ends: Array, last: npt.NDArray[np.intp]) -> tuple[Array, Array]:
    """A number at both ends of the stretches of flights; `ends` are those of the `last` ones, before their event."""
    before = of(begins)
    after = np.roll(before, -1)
    after[last] = of(ends, "left")
    return before, after


def _roots(f: Callable[[Array], Array], a: Array, b: Array, fa: Array, fb: Array) -> Array:
    """A root in each bracket, by the rule of false position (Illinois: Dowell & Jarratt, BIT 11 (1971) 168)."""
    for _ in range(_MOST_STEPS if a.size else 0):
        at = np.where(fa != fb, b - fb * (b - a) / np.where(fa != fb, fb - fa, 1.0), b)
        done = np.abs(at - b) <= _EPS * np.abs(at)
        if done.all():
            break
        here = f(at)
        stays = here * fb > 0.0
        a, fa = np.where(stays, a, b), np.where(stays, 0.5 * fa, fb)
        b, fb = at, here
    return b


@dataclass(frozen=True)
class PoincareSection(ShortRepr):
    """A Poincaré section, a point for each time at which a motion meets it; made by `Trajectory.section`.

    Attributes
    ----------
    plane
        Where it lies, in words.
    times, phases
        When the motion meets it, and the phase of the load then, None of a machine; shape (n,).
    position, speed
        u(x, t) and u_t(x, t) of the place that is looked at; shape (n,).
    displacement, velocity
        u_n and u_n'; shape (n, N+1).
    state, pressure
        Of a machine the state of its valve, and the pressure of a supply; else None.
    """

    plane: str
    times: Array
    phases: Array | None
    position: Array
    speed: Array
    displacement: Array
    velocity: Array
    state: npt.NDArray[np.str_] | None
    pressure: Array | None

    def __len__(self) -> int:
        return int(self.times.size)

    def __str__(self) -> str:
        points = f"{len(self)} point{'s' * (len(self) != 1)}"
        return f"PoincareSection at {self.plane}: {points}, {self.displacement.shape[1] - 1} modes"

    def _columns(self) -> dict[str, Any]:
        return {
            name: value
            for name in ("phases", "position", "speed", "state", "pressure")
            if (value := getattr(self, name)) is not None
        }

    def to_pandas(self) -> pandas.DataFrame:
        """A row for each point: its time and the columns; u_n and u_n' as ``u_0`` …, ``v_0`` …"""
        columns = {"time": self.times, **self._columns()}
        for name, values in (("u", self.displacement), ("v", self.velocity)):
            columns |= {f"{name}_{n}": one for n, one in enumerate(values.T)}
        table: pandas.DataFrame = extra_package("pandas", "io").DataFrame(columns)
        return table

    def to_xarray(self) -> xarray.Dataset:
        """All columns over the time, amplitudes over the number of the mode, too."""
        columns: dict[str, Any] = {name: ("time", value) for name, value in self._columns().items()}
        columns |= {name: (("time", "mode"), getattr(self, name)) for name in ("displacement", "velocity")}
        about = {"title": f"percuss section at {self.plane}"}
        made: xarray.Dataset = extra_package("xarray", "io").Dataset(columns, {"time": self.times}, about)
        return made


# ---- A motion followed from its start


def run(
    system: System | Machine,
    start: Start | None = None,
    *,
    modes: int = DEFAULT_MODES,
    stop: Stop | None = None,
    progress: Callable[[Progress], object] | None = None,
) -> Trajectory:
    """Follow the bar from a start: every impact, chatter, rest and release (B77 section 5, theory §§3, 8).

    Of a machine every port and change of the valve besides. The blow, the crossings of ports and the orders that are
    due compete, and the first one is proved to be the first, ringing included. A machine whose valve can never switch
    again stalls, which is proved too; the blows that are left are followed.

    Parameters
    ----------
    system
        What moves: a system under a clock, all of it dimensionless; or a machine that switches its own valve, with
        times in its unit.
    start
        The state and the load phase at the beginning; `Start.rigid()` by default, at rest one bar length off the wall.
        A machine starts at rest on the wall by default, with the valve's own starting state, and at the start's time.
    modes
        N, the elastic modes kept; 0 is the rigid bar.
    stop
        When to end; see `Stop`, of a machine its time in the machine's unit. By default after 2000 impacts, or when a
        periodic motion or rest for good is found.
    progress
        Called now and then with a `Progress`; the motion ends as ``interrupted`` when it returns something true.

    Raises
    ------
    ParameterError
        For a start beyond the wall, with more modes than `modes`, or with a state that the valve does not have.
    ResonanceError
        When a harmonic of the load meets an undamped elastic mode (B77 16).

    Examples
    --------
    >>> from percuss import Load, Start, Stop, System, run
    >>> system = System(s=20.0, d=0.0048, restitution=0.6, load=Load.harmonic(0.9, 1.0))
    >>> motion = run(system, Start.rigid(position=-1.0, time=0.3), modes=8)
    >>> print(motion.label, motion.outcome)
    chatter/1 periodic
    >>> from percuss.model import Kept, Machine, Port, UniformBar, Valve
    >>> ports = [Port("power", behind=1.0, side="back"), Port("return", on="impact")]
    >>> machine = Machine(UniformBar(20.0), Valve({"return": -0.4, "power": 1.8}, ports), Kept(0.2))
    >>> motion = run(machine, modes=0)
    >>> print(motion.label, round(motion.cycle.period, 6))
    runs 1/1 3.148923
    """
    if not isinstance(system, Machine):
        instance("system", system, System)
    usual = Start.rigid(0.0) if isinstance(system, Machine) else Start.rigid()
    start = usual if start is None else instance("start", start, Start)
    stop = Stop() if stop is None else instance("stop", stop, Stop)
    callback("progress", progress)
    moved, anchor, resting = _begun(system, count("modes", modes, least=0, most=MAX_MODES), start, stop)
    with watched(progress) as watch:
        made = moved.followed(stop, start.time, watch)
    return Trajectory(
        hammer=system, modes=moved.modes, start=anchor, resting=resting, stop=stop, begin_time=start.time, **made
    )


def _begun(
    system: System | Machine, modes: int, start: Start, stop: Stop
) -> tuple[Clocked | SelfSwitching | FlowingOil, Anchor, bool]:
    if isinstance(system, System):
        from percuss.simulate.engine import Clocked  # the compiler

        return Clocked.begun(system, modes, start)
    if system.valve.flows:
        from percuss.simulate.oil import FlowingOil

        return FlowingOil.begun(system, modes, start)
    from percuss.simulate.valve import SelfSwitching, mechanism  # more kernels

    return SelfSwitching.begun(mechanism(system, modes), start, stop)
