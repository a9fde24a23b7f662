"""A machine followed load period by load period: its clock, its contacts, its state at the end of each."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np
import numpy.typing as npt

from percuss.blow.kernels.machine_motion import follow
from percuss.blow.kernels.machine_records import CONTACT, COUNT, LOAD, NOW, OFF, Chain, Machine
from percuss.blow.machine.options import Release
from percuss.model.checks import Array

__all__ = ["Course"]

_TURN = 2.0 * math.pi
_ROOM = 1024  # contacts in the log of a call
_AT_ONCE = 1 << 20  # steps between two looks at the outside


class Course:
    """A machine on its way."""

    def __init__(self, machine: Machine, release: Release) -> None:
        self.machine = machine
        self.now, self.count = np.zeros(1, NOW), np.zeros(1, COUNT)
        self._log, self._done = np.zeros(_ROOM, CONTACT), list[npt.NDArray[np.void]]()
        self._gone = 0
        wave = 0.5 * release.velocity
        machine.striker.right[:] = machine.striker.left[:] = wave
        steps, size = round(release.time / machine.step), machine.load.size
        self.periods = 0
        self.count["step"] = steps % size
        self.count["branch"] = OFF if machine.bit.gap > 0.0 else LOAD
        state = {
            "gap": release.gap,
            "momentum": release.velocity,
            "energy": 0.5 * release.velocity**2,
            "arrived": wave,
            "penetration": -machine.bit.gap,
            "time": (steps // size) * _TURN,
            "next_drag": steps % size + 0.5 * machine.drag.interval,
        }
        for name, value in state.items():
            self.now[name] = value

    def period(self) -> Iterator[None]:
        """To the end of the load's present period; stops now and then on the way."""
        while self.count["step"][0] < self.machine.load.size:
            follow(self.machine, self.now, self.count, self._log, _AT_ONCE)
            self._empty()
            yield
        self.count["step"] = 0
        self.now["time"] += _TURN
        self.now["next_drag"] = 0.5 * self.machine.drag.interval
        self.periods += 1

    def _empty(self) -> None:
        """Take all contacts but the last, which may go on, out of the log."""
        n = int(self.count["contacts"][0])
        if n > 1:
            self._done.append(self._log[: n - 1].copy())
            self._gone += n - 1
            self._log[0] = self._log[n - 1]
            self.count["contacts"] = 1

    @property
    def touching(self) -> bool:
        """Whether the faces are pressed together now."""
        return bool(self.count["touching"][0])

    @property
    def time(self) -> float:
        """In radians of the load."""
        return float(self.now["time"][0] + self.count["step"][0] * self.machine.step)

    @property
    def strikes(self) -> int:
        """Contacts from the start."""
        return self._gone + int(self.count["contacts"][0])

    @property
    def blow_over(self) -> bool:
        """Whether the tool has been fed since the last contact."""
        return not self.count["struck"][0]

    @property
    def rock_work(self) -> float:
        """That the rock keeps of all blows; of the one under way as far as it has come."""
        now, bit = self.now[0], self.machine.bit
        return float(now["rock_work"]) + 0.5 * bit.stiffness * (1.0 - bit.ratio) * float(now["greatest"]) ** 2

    @property
    def advanced(self) -> float:
        """By which the tool has been fed since the start."""
        return float(self.now["advanced"][0])

    @property
    def contacts(self) -> npt.NDArray[np.void]:
        """All contacts from the start, the one under way included."""
        return np.concatenate([*self._done, self._log[: int(self.count["contacts"][0])]])

    def contacts_since(self, time: float) -> npt.NDArray[np.void]:
        """The contacts that have ended after a time."""
        parts = [self._log[: int(self.count["contacts"][0])]]
        for part in reversed(self._done):
            if part["end"][-1] < time:
                break
            parts.append(part)
        found = np.concatenate(parts[::-1])
        return found[found["end"] >= time]

    @property
    def waves(self) -> Array:
        """f and g of all cells, in order of space, each times √(2 Z Δt), and the motion and the force of the bit.

        The sum of squares is twice the energy.
        """
        machine, now, bit = self.machine, self.now[0], self.machine.bit
        force = float(now["penetration"]) - (1.0 - bit.ratio) * float(now["greatest"])
        ends = [
            math.sqrt(bit.mass) * float(now["bit_velocity"]),
            math.sqrt(bit.stiffness / bit.ratio) * max(force, 0.0),
        ]
        return np.concatenate([*(_ordered(chain, machine.step) for chain in (machine.striker, machine.rod)), ends])

    @property
    def energy(self) -> float:
        """Of the striker, from its cells."""
        return 0.5 * float(np.sum(_ordered(self.machine.striker, self.machine.step) ** 2))

    @property
    def momentum(self) -> float:
        """Of the striker, from its cells."""
        chain = self.machine.striker
        mass = np.repeat(chain.impedance, chain.cells) * self.machine.step
        return float(np.sum(mass * (chain.right + chain.left)))


def _ordered(chain: Chain, step: float) -> Array:
    parts = [np.zeros(0)]
    for z, first, cells, slot in zip(chain.impedance, chain.first, chain.cells, chain.slot, strict=True):
        scale = math.sqrt(2.0 * z * step)
        parts += [scale * np.roll(wave[first : first + cells], -slot) for wave in (chain.right, chain.left)]
    return np.concatenate(parts)
