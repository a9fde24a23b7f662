"""The numbers of a machine as the kernels want them, in a unit of time of its own."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property, lru_cache

import numpy as np

from percuss.model import Machine
from percuss.model.checks import Array
from percuss.simulate.damped_modes import DampedModes
from percuss.simulate.kernels.layout import Harmonics, Table
from percuss.simulate.kernels.valve_records import Gear
from percuss.simulate.tables import bar_of, tabled_modes

__all__ = ["Elastic", "Mechanism", "mechanism"]

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

    Their unit of time is a power of two, so that only exponents differ, and near the time in which the greatest force
    drives the bar from the wall to the farthest port: what the kernels take for simultaneous, or for the end of
    chatter, is measured by that.

    Parameters
    ----------
    machine, modes
        What moves, and N.
    """

    machine: Machine
    modes: int

    @cached_property
    def unit(self) -> float:
        """The unit of time, in that of the machine."""
        valve = self.machine.valve
        way = max((port.behind for port in valve.ports if port.behind is not None), default=1.0)
        push = max(abs(valve.force(name)) for name, _ in valve.pairs)
        exponent = 0.5 * (math.log2(way) - math.log2(push)) if push > 0.0 else 0.0
        return 2.0 ** min(max(round(exponent), -300), 300)

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
