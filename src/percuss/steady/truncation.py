"""How many elastic modes the sums need, and how much the omitted ones can contribute."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from percuss.halting import look
from percuss.model.checks import Array
from percuss.shown import Shown
from percuss.steady.harmonic import HarmonicResponse
from percuss.steady.impact_state import ModalState, resolvent_bound
from percuss.steady.oscillator import mode_frequencies
from percuss.steady.small_divisors import cubic_sum

if TYPE_CHECKING:
    from percuss.steady.motion import Motion

__all__ = ["Truncation", "ringing", "truncation"]

_PROBES = (256, 2048, 16384, 65536)
_LARGEST_MATRIX = 1 << 21  # harmonics × modes of one probe
_MOST_MODES = 16384
_PIECEWISE_MODES = 512  # the ringing after a jump falls off like 1/n²: more modes hardly help
_VAGUE = 1e-9  # share of the stroke above which the plain bound, which grows like 1/d, gives way to the sharper one
_FEW, _SOME = 1e-3, 1e-7  # shares of the stroke that a first and a second look at the motion may leave out


@dataclass(frozen=True)
class Truncation(Shown):
    """The modes kept and the modes left out of a motion's sums.

    Parameters
    ----------
    motion
        The motion that they belong to.
    modes
        N, the modes kept.
    few, some
        Smaller numbers of modes that already give the position to 1e-3 and 1e-7 of the stroke.
    state
        State of the modes kept.
    lost
        Bound of the position that the modes left out add at the striking end, where it is known already.
    """

    motion: Motion = field(repr=False)
    modes: int
    few: int
    some: int
    state: ModalState = field(repr=False)
    lost: float | None = None

    @cached_property
    def error_bound(self) -> float:
        """Bound of the position error at the striking end relative to the stroke of the rigid motion.

        A bound when the load is smooth, without damping for the first 10¹⁸ modes. With a load that jumps it is an
        estimate: modes beyond the probe are taken to fall off like those inside it.
        """
        motion, lost = self.motion, self.lost
        if lost is None:  # a requested number of modes: the forced part is cut as well
            probe = max(4 * self.modes, 2048)
            lost = _forced_cut(motion, self.modes, probe) + float(_left_out(motion, probe)[self.modes])
        return lost / motion.rigid_stroke


def truncation(motion: Motion) -> Truncation:
    """Choose the number of modes that the tolerance asks for, or take the number requested."""
    if motion.requested_modes is not None:
        n = motion.requested_modes
        return Truncation(motion, n, n, n, motion.modal_state(n))
    scale = motion.rigid_stroke
    largest = _largest_probe(motion)
    for probe in [p for p in _PROBES if p < largest] + [largest]:
        look()
        left_out = _left_out(motion, probe)
        if left_out[-1] <= 0.5 * motion.tolerance * scale:
            break
    most = min(probe, _MOST_MODES)

    def enough(share: float) -> int:
        found = np.flatnonzero(left_out <= share * scale)
        return min(most, max(8, int(found[0]))) if found.size else most

    modes = enough(motion.tolerance)
    lost = float(left_out[modes])
    return Truncation(motion, modes, enough(_FEW), enough(_SOME), motion.modal_state(modes), lost)


def _left_out(motion: Motion, probe: int) -> Array:
    """Bound of what is lost at the striking end by keeping n = 0 … `probe` modes; shape (probe + 1,)."""
    amplitude = _amplitude(motion, probe)
    lost = np.append(2.0 * np.cumsum(amplitude[::-1])[::-1], 0.0)
    return np.asarray(2.0 * (lost + _beyond(motion, amplitude)))  # at t and, as y(0) = 0 places the wall, at 0


def _forced_cut(motion: Motion, modes: int, probe: int) -> float:
    """Bound of the forced motion of all modes after the first `modes`; inf when the load reaches beyond `probe`."""
    load, response = motion.system.load, motion.response
    square = mode_frequencies(motion.system.s, probe) ** 2
    if not isinstance(response, HarmonicResponse):  # its ringing is counted with the free motion
        greatest, room = float(np.abs(response.values).max()), 1.0
        each = greatest / square
    else:
        each = abs(load.mean) / square + np.abs(response.gains(probe)) @ np.abs(response.p)
        greatest = abs(load.mean) + float(np.abs(response.p).sum())
        room = 1.0 - float(np.abs(response.k * (response.k - 1j * motion.system.d)).max()) / float(square[-1])
    if room <= 0.0:
        return math.inf
    beyond = greatest / (room * (math.pi * motion.system.s) ** 2 * probe)
    return 4.0 * (float(each[modes:].sum()) + beyond)  # twice for the mode shape, twice as in _left_out


def _largest_probe(motion: Motion) -> int:
    if not isinstance(motion.response, HarmonicResponse):
        return _PIECEWISE_MODES
    return max(1024, min(_PROBES[-1], _LARGEST_MATRIX // max(1, motion.response.k.size)))


def _amplitude(motion: Motion, modes: int) -> Array:
    """Bound over time of the free motion of each mode at the striking end; shape (modes,)."""
    return ringing(motion, motion.modal_state(modes).amplitude)


def ringing(motion: Motion, amplitude: Array) -> Array:
    """Amplitudes after the impact of the first modes, with those after the jumps of a piecewise load added."""
    response, modes = motion.response, amplitude.size
    if isinstance(response, HarmonicResponse):
        return amplitude
    u, v = response.knots(modes)
    return np.asarray(amplitude + np.hypot(u, v / mode_frequencies(motion.system.s, modes)).max(axis=0))


def _beyond(motion: Motion, amplitude: Array) -> float:
    """Bound of what all modes after the last of `amplitude` add at the striking end."""
    n = amplitude.size
    top = slice(n // 2, n)
    numbers = np.arange(1, n + 1)[top]
    if not isinstance(motion.response, HarmonicResponse):
        return 2.0 * float(np.max(amplitude[top] * numbers**2)) / n
    system, periods = motion.system, motion.periods
    base, r = math.pi * system.s, system.restitution
    each = motion.response.modal_velocity_bound(motion.phase, base * n) / base**3  # |f_n'|/ω_n ≤ each/n³
    if r == 1.0 and system.d == 0.0:
        return each / n**2  # nothing rings but −f_n'
    damped = resolvent_bound(system, motion.period, base * n)
    if each * damped / n**2 <= _VAGUE * motion.rigid_stroke or r == 1.0:
        return each * damped / n**2
    # hardly damped: by how near the modes come to resonance with the impacts
    full = (1.0 + r) / (1.0 - r)
    return 2.0 * each * full * cubic_sum(system.s, periods, n, damped / full, system.d**2 * periods / (8.0 * base * n))
