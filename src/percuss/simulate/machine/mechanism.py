"""The numbers of a machine as the kernels want them, in a unit of time of its own."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property, lru_cache
from itertools import pairwise
from typing import Protocol

import numpy as np
import numpy.typing as npt

from percuss.errors import ParameterError
from percuss.model import Machine
from percuss.model.checks import Array, finite
from percuss.simulate.kernels.motion_records import CHATTER, REST, Gear, Harmonics, Table
from percuss.simulate.machine.machine_events import MachineEvents
from percuss.simulate.simulated_motion import EnergyBalance, drift, free_motion, panels
from percuss.simulate.spectrum import DampedModes
from percuss.simulate.tables import bar_of, tabled_modes

_NODE = 1e-12
_SOFTEST = 1e-100  # frequency of a chamber that is none


@dataclass(frozen=True)
class Elastic(DampedModes):
    """The elastic modes of a machine as q_i, what m_i moves the striking end by; each array of shape (N,).

    Parameters
    ----------
    omega, damping
        ω_i and d_i.
    end, driven
        As of `MachineModes`.
    """

    omega: Array
    damping: Array
    end: Array
    driven: Array

    @cached_property
    def statics(self) -> Array:
        """q_i under a constant unit force."""
        return np.asarray(self.end * self.driven / self.omega**2)

    @property
    def unit(self) -> Array:
        """q_i of q_i = 1."""
        return np.ones(self.omega.size)

    @cached_property
    def inertia(self) -> Array:
        """What q_i'²/2 is multiplied by to be a kinetic energy."""
        return np.asarray(1.0 / self.end**2)


@dataclass(frozen=True)
class Mechanism:
    """A machine cut at mode N, in the units of the kernels; made by `mechanism`.

    Their unit of time is a power of two, so that only exponents differ: `Valve.time_unit`.

    Parameters
    ----------
    machine, modes
        What moves, and N.
    """

    machine: Machine
    modes: int

    @property
    def unit(self) -> float:
        """The unit of time, in that of the machine."""
        return self.machine.valve.time_unit

    @cached_property
    def end(self) -> Array:
        """What m_i = 1 moves the striking end by, shape (N+1,); next to nothing, not 0, where a mode has a node."""
        end = self.machine.modes(self.modes).end
        return np.where(np.abs(end) < _NODE, _NODE, end)

    @cached_property
    def forces(self) -> Array:
        """Forces of the states, with that of the chamber; in the unit of the machine."""
        valve = self.machine.valve
        return np.array([valve.force(name) for name, _ in valve.pairs])

    def states(self) -> list[str]:
        """The names of the valve's states, in order."""
        return [name for name, _ in self.machine.valve.pairs]

    @property
    def spring(self) -> float:
        """ω_0 on the gas of the chamber; 0 without one."""
        found = float(self.machine.modes(self.modes).omega[0])
        return found if found * self.unit > _SOFTEST else 0.0

    def elastic(self, unit: float = 1.0) -> Elastic:
        """The elastic modes, in a unit of time."""
        own = self.machine.modes(self.modes)
        return Elastic(own.omega[1:] * unit, own.damping[1:] * unit, self.end[1:], own.driven[1:])

    @cached_property
    def slow(self) -> Elastic:
        """The elastic modes in the machine's unit of time."""
        return self.elastic()

    @cached_property
    def tables(self) -> tuple[Table, Table]:
        """The kernels' tables of the machine, and of its rigid motion alone; their `bar`s are to be copied."""
        return self._table(self.elastic(self.unit)), self._table(Elastic(*np.empty((4, 0))))

    def _table(self, elastic: Elastic) -> Table:
        machine, unit = self.machine, self.unit
        bar = bar_of(machine.body, elastic)
        bar["damping"] *= unit
        bar["wave"], bar["contact"] = bar["wave"] / unit, bar["contact"] / unit
        bar["spring"], bar["whole"] = self.spring * unit, 1.0 / self.end[0] ** 2
        bar["restitution"] = -machine.contact.velocity_factor
        bar["strain"] = machine.contact.strain_factor
        bar["force"] = float(np.abs(self.forces).max()) * unit**2
        bar["pushing"] = np.inf
        none = np.empty(0)
        return Table(
            bar,
            tabled_modes(elastic, bar),
            Harmonics(*(none.copy() for _ in range(6))),
            np.empty((0, 2, elastic.omega.size)),
            none,
            none,
            none,
        )

    @cached_property
    def gear(self) -> Gear:
        """The kernels' table of the valve."""
        machine, unit, ports = self.machine, self.unit, self.machine.valve.ports
        own, names = machine.modes(self.modes), self.states()
        rows = [
            own.centre if port.reads == "centre" else own.at(machine.body, np.array([port.reads]))[0] for port in ports
        ]
        ratio = np.array(rows, dtype=float).reshape(len(ports), self.modes + 1) / self.end
        sides = {"back": -1.0, "front": 1.0, None: 0.0}
        return Gear(
            forces=self.forces * unit**2,
            to=np.array([names.index(port.to) for port in ports], dtype=np.int64),
            edge=np.array([port.behind or 0.0 for port in ports]),
            side=np.array([sides[port.side] for port in ports]),
            delay=np.array([port.delay / unit for port in ports]),
            ratio=ratio,
            rigid=np.array([not row[1:].any() for row in ratio], dtype=np.int64),
            gain=float(self.end[0] * own.driven[0]),
            **self._reaches(ratio * self.end),
        )

    def _reaches(self, weights: Array) -> dict[str, Array]:
        """Of what the ports read: its place under a unit force, and how far a unit of energy drives it from there."""
        own, unit = self.machine.modes(self.modes), self.unit
        if self.spring == 0.0:
            return {"still": np.zeros(len(weights)), "sway": np.full(len(weights), np.inf)}
        soft = weights / (own.omega * unit) ** 2
        far = np.sqrt((weights**2 / (own.omega * unit) ** 2).sum(axis=1))
        return {"still": soft @ own.driven, "sway": far * (1.0 + 1e-12)}

    # -- the state in two forms: B77's u_n, and the kernels' amplitudes of the free motion --

    @cached_property
    def own_units(self) -> Array:
        """What B77's u_n = 1 is in the body's coordinates of modal mass 1, shape (N+1,)."""
        from percuss.simulate.spectrum import units

        own = self.machine.body.modes(self.modes, self.machine.at)
        return np.concatenate([[1.0], units(own) / own.end])

    def ends(self, displacement: Array) -> Array:
        """q_i of B77's u_n; both of shape (N+1,)."""
        own = self.machine.modes(self.modes)
        return np.asarray(self.end * (own.mixing.T @ (self.own_units * displacement)))

    def bars(self, ends: Array) -> Array:
        """B77's u_n of q_i; both of shape (N+1, …)."""
        own = self.machine.modes(self.modes)
        return np.asarray(((own.mixing @ (ends.T / self.end).T).T / self.own_units).T)

    def placed(self, row: Array, state: int) -> tuple[Array, Array]:
        """q_i and q_i' of a state that the kernels have left, in the machine's unit of time; each of shape (N+1,)."""
        n, e, unit = self.modes, self.slow, self.unit
        z0, z1 = row[2 : 2 + n], row[2 + n :]
        q = z0 + self.forces[state] * e.statics
        rate = np.where(e.creeps, z1 / unit, -e.lam * z1 - 0.5 * e.damping * z0)
        return np.append(row[0] - q.sum(), q), np.append(row[1] / unit, rate)


@lru_cache(maxsize=16)
def mechanism(machine: Machine, modes: int) -> Mechanism:
    """The numbers of a machine, kept for the next motion of it."""
    return Mechanism(machine, modes)


# ---- The motion of a machine in closed form from an event on: no engine, only the formulas

_TERMS = 24


def flight(mechanism: Mechanism, displacement: Array, velocity: Array, force: float, tau: Array) -> tuple[Array, Array]:
    """q_i and q_i', each of shape (N+1, len(tau)), at times `tau` ≥ 0 after a state, under a constant force.

    As long as the bar touches nothing. `displacement`, `velocity`: q_i and q_i' there, shape (N+1,).
    """
    elastic, machine = mechanism.slow, mechanism.machine
    d, w, b = machine.drag, mechanism.spring, velocity[0]
    pull = mechanism.gear.gain * force - w * w * displacement[0]
    h, integral = sway(d, w, tau)
    place = displacement[0] + b * h + pull * integral
    rate = b * (1.0 - d * h - w * w * integral) + pull * h
    if not elastic.omega.size:
        return place[None], rate[None]
    left, answer, answer_rate = free_motion(elastic, tau)
    still = force * elastic.statics[:, None]
    z, v = displacement[1:, None] - still, velocity[1:, None]
    q = still + z * left + v * answer
    q_rate = v * answer_rate - z * (elastic.omega[:, None] ** 2 * answer)
    return np.vstack([place, q]), np.vstack([rate, q_rate])


def sway(d: float, w: float, tau: Array) -> tuple[Array, Array]:
    """The answer to a unit push of a damped motion on a spring, h(0) = 0 and h'(0) = 1, and its integral; smooth in w.

    By the power series where little has happened, else by the closed form.
    """
    if w == 0.0:
        return drift(d, tau)
    half = 0.5 * d
    kappa = np.sqrt(complex(half * half - w * w))
    brief = (w * tau < 0.5) & (d * tau < 1.0)
    h, integral = np.empty(tau.shape), np.empty(tau.shape)
    t = tau[brief]
    x, y = d * t, (w * t) ** 2
    before, term = np.zeros(t.size), np.ones(t.size)
    h_series, sum_series = np.ones(t.size), np.full(t.size, 0.5)
    for k in range(1, _TERMS):
        before, term = term, -(x * term + y * before / k) / (k + 1.0)
        h_series += term
        sum_series += term / (k + 2.0)
    h[brief], integral[brief] = t * h_series, t * t * sum_series
    t = tau[~brief]
    if kappa.real > 1e-3 * half:  # the slow rate without cancellation
        rate = w * w / (half + kappa.real)
        slow = np.exp(-rate * t)
        answer = slow * -np.expm1(-2.0 * kappa.real * t) / (2.0 * kappa.real)
        fallen = -np.expm1(-rate * t) - rate * answer
    else:
        fade = np.exp(-half * t)
        turn = kappa * t
        small = np.abs(turn) < 1e-6
        sinh = np.where(small, 1.0 + turn * turn / 6.0, np.sinh(turn) / np.where(small, 1.0, turn)).real
        answer = fade * t * sinh
        fallen = 1.0 - fade * np.cosh(turn).real - half * answer
    h[~brief], integral[~brief] = answer, fallen / w**2
    return h, integral


# ---- Where the energy of a machine's motion goes: work of the valve, drag and ringing, blows


@dataclass(frozen=True)
class MachineBalance(EnergyBalance):
    """Energy between two instants, as an `EnergyBalance`; per unit of mass.

    `input` is the work of the valve with the constant part of the chamber's force; the rest of the chamber's is
    `stored`, as ½κu(0)².

    Attributes
    ----------
    rests
        Of `impacts`, what lying down takes, with the end of chatter: motion and strain that the last blow left.
    """

    rests: float = 0.0


class Motion(Protocol):
    """What is asked of a motion; a `MachineTrajectory` has it."""

    @property
    def machine(self) -> Machine: ...
    @property
    def modes(self) -> int: ...
    @property
    def mechanism(self) -> Mechanism: ...
    @property
    def events(self) -> MachineEvents: ...
    @property
    def begin_time(self) -> float: ...
    @property
    def end_time(self) -> float: ...
    def state(self, t: npt.ArrayLike) -> npt.NDArray[np.int64]: ...
    def position(self, x: npt.ArrayLike, t: npt.ArrayLike) -> Array: ...
    def before(self, x: npt.ArrayLike, t: float) -> float: ...
    def ends(self, t: npt.ArrayLike) -> tuple[Array, Array]: ...
    def energy(self, t: npt.ArrayLike) -> Array: ...


def machine_balance(motion: Motion, first: float | None = None, last: float | None = None) -> MachineBalance:
    """Energy between two times; see `MachineTrajectory.energy_balance`.

    The work of the valve is Σ p_k (u(0) at the end − at the begin of a flight); that of damping is integrated over the
    closed forms with Gauss's rule.
    """
    begin = motion.begin_time if first is None else finite("first", first)
    end = motion.end_time if last is None else finite("last", last)
    if not motion.begin_time <= begin <= end <= motion.end_time:
        accepted = f"two times in order from {motion.begin_time:.6g} to {motion.end_time:.6g}"
        raise ParameterError("first, last", f"{begin:.6g}, {end:.6g}", accepted)
    times, own = motion.events.time, motion.machine.modes(motion.modes)
    inside = (times > begin) & (times <= end)
    edges = np.unique(np.concatenate([[begin], times[inside], [end]]))
    place = motion.machine.body.place(motion.machine.at)
    fastest = max(float(own.omega.max()), 1e-300)
    put_in = lost = 0.0
    for a, b in pairwise(edges):
        middle = np.array([0.5 * (a + b)])
        force = float(motion.mechanism.forces[motion.state(middle)][0])
        ends = np.array([a, b])
        left, right = motion.position(place, ends)[0, 0], motion.before(place, b)
        put_in += force * (right - left)
        if own.damping.any():
            t, w = panels(a, b, fastest, float(own.damping.max()))
            speed = (motion.ends(t)[1].T / motion.mechanism.end).T
            lost += float(w @ (own.damping @ speed**2))
    taken = float(motion.events.energy_lost[inside].sum())
    lying = inside & np.isin(motion.events.code, (CHATTER, REST))
    stored = motion.energy(np.array([begin, end]))
    by_rest = float(motion.events.energy_lost[lying].sum())
    return MachineBalance(put_in, lost, taken, float(stored[1] - stored[0]), by_rest)
