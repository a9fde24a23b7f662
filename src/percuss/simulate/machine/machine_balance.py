"""Where the energy of a machine's motion goes: work of the valve, drag and ringing, blows."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise
from typing import Protocol

import numpy as np
import numpy.typing as npt

from percuss.errors import ParameterError
from percuss.model import Machine
from percuss.model.checks import Array, finite
from percuss.simulate.balance import EnergyBalance, panels
from percuss.simulate.kernels.codes import CHATTER, REST
from percuss.simulate.machine.machine_events import MachineEvents
from percuss.simulate.machine.mechanism import Mechanism

__all__ = ["MachineBalance", "machine_balance"]


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
