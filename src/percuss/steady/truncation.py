"""How many elastic modes the sums need, and how much the omitted ones can contribute."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from functools import cached_property
from typing import TYPE_CHECKING, Protocol

import numpy as np

from percuss.halting import look
from percuss.model.checks import Array
from percuss.shown import Shown
from percuss.steady.impact_state import ModalState, resolvent_bound
from percuss.steady.small_divisors import cubic_sum

if TYPE_CHECKING:
    from percuss.model import System
    from percuss.steady.response import Response

__all__ = ["RELEASED_MODES", "Truncation", "Untruncated", "ringing", "truncation"]

RELEASED_MODES = 512
"""Modes of the sums where an impact changes the strain: more of them hardly help."""

_PROBES = (256, 2048, 16384, 65536)
_MOST_MODES = 16384
_VAGUE = 1e-9  # share of the stroke above which the plain bound, which grows like 1/d, gives way to the sharper one
_FEW, _SOME = 1e-3, 1e-7  # shares of the stroke that a first and a second look at the motion may leave out


class Untruncated(Protocol):
    """What it takes of a motion to choose the number of its modes; `percuss.steady.motion.Motion` has it."""

    @property
    def system(self) -> System: ...
    @property
    def response(self) -> Response: ...
    @property
    def periods(self) -> int: ...
    @property
    def period(self) -> float: ...
    @property
    def phase(self) -> float: ...
    @property
    def requested_modes(self) -> int | None: ...
    @property
    def tolerance(self) -> float: ...
    @property
    def rigid_stroke(self) -> float: ...
    def modal_state(self, modes: int) -> ModalState: ...


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

    motion: Untruncated = field(repr=False)
    modes: int
    few: int
    some: int
    state: ModalState = field(repr=False)
    lost: float | None = None

    @cached_property
    def error_bound(self) -> float:
        """Bound of the position error at the striking end relative to the stroke of the rigid motion.

        A bound for a uniform bar under a smooth load whose impacts keep the strain, without damping for the first 10¹⁸
        modes, and for other bodies when their damping outlasts small divisors. Else it is an estimate, as with a load
        that jumps and with Kelvin–Voigt's damping: modes beyond the probe are taken to fall off like those inside it.
        """
        motion, lost = self.motion, self.lost
        if lost is None:  # a requested number of modes: the forced part is cut as well
            probe = max(4 * self.modes, 2048)
            lost = _forced_cut(motion, self.modes, probe) + float(_left_out(motion, probe)[self.modes])
        return lost / motion.rigid_stroke


def truncation(motion: Untruncated) -> Truncation:
    """Choose the number of modes that the tolerance asks for, or take the number requested."""
    if motion.requested_modes is not None:
        n = motion.requested_modes
        lost = None if motion.system.body.is_free else 0.0  # a structure has no other modes
        return Truncation(motion, n, n, n, motion.modal_state(n), lost)
    scale = motion.rigid_stroke
    if not motion.system.contact.keeps_strain:  # what its release sets ringing falls off like 1/n²
        return Truncation(motion, RELEASED_MODES, RELEASED_MODES, RELEASED_MODES, motion.modal_state(RELEASED_MODES))
    largest = motion.response.most_modes
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


def _left_out(motion: Untruncated, probe: int) -> Array:
    """Bound of what is lost at the striking end by keeping n = 0 … `probe` modes; shape (probe + 1,)."""
    amplitude = ringing(motion, motion.modal_state(probe).amplitude)
    coupling = np.abs(motion.system.body.modes(probe, motion.system.load.at).gamma)
    lost = np.append(np.cumsum((coupling * amplitude)[::-1])[::-1], 0.0)
    return np.asarray(2.0 * (lost + _beyond(motion, amplitude)))  # at t and, as y(0) = 0 places the wall, at 0


def _forced_cut(motion: Untruncated, modes: int, probe: int) -> float:
    """Bound of the forced motion of all modes after the first `modes`; inf when the load reaches beyond `probe`."""
    body = motion.system.body
    each = body.coupling_bound * motion.response.modal_bounds(probe)[0]
    floor = body.frequency_floor(probe)
    if floor <= 0.0:
        return math.inf
    beyond = body.coupling_bound * motion.response.displacement_tail(floor) * body.transit_time / (math.pi * floor)
    return 2.0 * (float(each[modes:].sum()) + beyond)  # twice as in _left_out


def ringing(motion: Untruncated, amplitude: Array) -> Array:
    """Amplitudes after the impact of the first modes, with those after the jumps of a piecewise load added."""
    return amplitude if motion.response.is_smooth else amplitude + motion.response.ringing(amplitude.size)


def _beyond(motion: Untruncated, amplitude: Array) -> float:
    """Bound of what all modes after the last of `amplitude` add at the striking end, or an estimate of it."""
    system, body, n = motion.system, motion.system.body, amplitude.size
    modes, floor = body.modes(n, system.load.at), body.frequency_floor(n)
    top = slice(n // 2, n)
    shares = modes.damping[top] / modes.omega[top]
    known = system.contact.keeps_strain and floor > 0.0 and shares[-1] <= shares[0]
    last = float(modes.damping[-1])
    each = motion.response.modal_velocity_bound(motion.phase, floor, last) if known else math.inf
    bound = 0.5 * body.coupling_bound * each * body.transit_time / (math.pi * floor**2) if known else math.inf
    if math.isfinite(bound):  # of Σ |f_n'|/ω_n, as |f_n'| ≤ each/ω_n² and ω_{n+j} ≥ floor + jπs
        contact, free = system.contact, not np.any(modes.damping)
        if contact.is_lossless and free:
            return bound  # nothing rings but −f_n'
        damped = resolvent_bound(system, motion.period, floor, last)
        if bound * damped <= _VAGUE * motion.rigid_stroke or (contact.is_lossless and math.isfinite(damped)):
            return bound * damped
        if body.is_harmonic and np.all(modes.damping == last):
            # hardly damped: by how near the modes come to resonance with the impacts
            full, shift = 1.0 / contact.impedance_ratio, last**2 * motion.periods / (8.0 * floor)
            near = cubic_sum(system.s, motion.periods, n, damped / full, shift)
            return float(body.coupling_bound * each / modes.omega[0] ** 3 * full * near)
    order = 3 if motion.response.is_smooth and system.contact.keeps_strain else 2
    numbers = np.arange(1, n + 1)[top]
    return body.coupling_bound * float(np.max(amplitude[top] * numbers**order)) / float((order - 1) * n ** (order - 1))
