"""Where the energy of a simulated motion goes, by quadrature over its closed forms."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from percuss.errors import ParameterError
from percuss.model.checks import Array, finite
from percuss.shown import Shown
from percuss.simulate.simulated_motion import SimulatedMotion

__all__ = ["EnergyBalance", "energy_balance", "panels"]

_TURN = 2.0 * np.pi
_POINTS, _WEIGHTS = np.polynomial.legendre.leggauss(12)


@dataclass(frozen=True)
class EnergyBalance(Shown):
    """Energy between two instants; dimensionless.

    Attributes
    ----------
    input
        Work of the load.
    damping, impacts
        Taken by damping, and by impacts, chatter and rest.
    stored
        Rise of the kinetic and elastic energy of the bar.
    """

    input: float
    damping: float
    impacts: float
    stored: float

    @property
    def imbalance(self) -> float:
        """Input less damping, impacts and what is stored: 0 but for rounding."""
        return self.input - self.damping - self.impacts - self.stored


def energy_balance(motion: SimulatedMotion, first: float | None = None, last: float | None = None) -> EnergyBalance:
    """Energy between two times; see `Trajectory.energy_balance`."""
    begin = motion.begin_time if first is None else finite("first", first)
    end = motion.end_time if last is None else finite("last", last)
    if not motion.begin_time <= begin <= end <= motion.end_time:
        accepted = f"two times in order from {motion.begin_time:.6g} to {motion.end_time:.6g}"
        raise ParameterError("first, last", f"{begin:.6g}, {end:.6g}", accepted)
    times = motion.events.time
    inside = (times > begin) & (times <= end)
    edges = np.unique(np.concatenate([[begin], times[inside], _breaks(motion, begin, end), [end]]))
    fastest = max(float(motion.spectrum.k.max(initial=1.0)), float(motion.spectrum.omega.max(initial=0.0)))
    put_in = lost = 0.0
    at_load = motion.spectrum.elastic.at_load * motion.spectrum.unit
    damped = motion.spectrum.weight * motion.spectrum.damping
    for a, b in pairwise(edges):
        if b - a <= 1e-14 * max(abs(a), 1.0):
            continue
        t, w = panels(a, b, fastest, max(motion.system.d, float(motion.spectrum.damping.max(initial=0.0))))
        velocity = motion.modal(t).velocity
        driven = velocity[0] + at_load @ velocity[1:]
        put_in += float(w @ (np.asarray(motion.system.load.value(t)) * driven))
        lost += float(w @ (motion.system.d * velocity[0] ** 2 + damped @ velocity[1:] ** 2))
    taken = float(motion.events.energy_lost[inside].sum())
    stored = motion.energy(np.array([begin, end]))
    return EnergyBalance(put_in, lost, taken, float(stored[1] - stored[0]))


def _breaks(motion: SimulatedMotion, begin: float, end: float) -> Array:
    breaks = np.asarray(motion.system.load.breaks)
    if not breaks.size:
        return breaks
    turns = np.arange(np.floor(begin / _TURN), np.floor(end / _TURN) + 1) * _TURN
    every = (turns[:, None] + breaks[None, :]).reshape(-1)
    return np.asarray(every[(every > begin) & (every < end)])


def panels(a: float, b: float, fastest: float, d: float) -> tuple[Array, Array]:
    """Gauss's rule on panels of at most two radians of the fastest wave.

    What an impact or a step of the load leaves at `a` dies out at rates up to d, the drift and overdamped modes among
    them, and its square at 2d: from 1/d after `a` on the panels double until the waves bound them.
    """
    width = 2.0 / fastest
    first = min(1.0 / d, b - a) if d > 0.0 else width
    doublings = max(int(np.ceil(np.log2(width / first))), 0) if first < width else 0
    edges = a + np.concatenate([[0.0], first * 2.0 ** np.arange(doublings)])
    edges = edges[edges < b] if doublings else np.array([a])
    count = int(np.ceil((b - edges[-1]) / width)) + 1
    edges = np.concatenate([edges[:-1], np.linspace(edges[-1], b, count + 1)])
    left, wide = edges[:-1, None], np.diff(edges)[:, None]
    return (left + 0.5 * wide * (_POINTS + 1.0)).reshape(-1), (0.5 * wide * _WEIGHTS).reshape(-1)
