"""How many elastic modes the sums need, and what the ones left out can amount to."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from percuss.model.checks import Array
from percuss.steady.harmonic import HarmonicResponse
from percuss.steady.impact_state import ModalState, resolvent_bound
from percuss.steady.oscillator import mode_frequencies

if TYPE_CHECKING:
    from percuss.steady.orbit import Orbit

__all__ = ["Truncation", "truncation"]

_PROBES = (256, 2048, 16384, 65536)
_LARGEST_MATRIX = 1 << 21  # harmonics × modes of one probe
_MOST_MODES = 16384
_PIECEWISE_MODES = 1024  # the ringing after a jump falls off like 1/n²: more modes hardly help
_FEW, _SOME = 1e-3, 1e-7  # shares of the stroke that a first and a second look at the motion may leave out


@dataclass(frozen=True)
class Truncation:
    """The modes kept and the modes left out of an orbit's sums.

    Parameters
    ----------
    orbit
        The orbit that they belong to.
    modes
        N, the modes kept.
    few, some
        Smaller numbers of modes that already give the position to 1e-3 and 1e-7 of the stroke.
    state
        State of the modes kept.
    lost
        Bound of the position that the modes left out add at the striking end, where it is known already.
    """

    orbit: Orbit
    modes: int
    few: int
    some: int
    state: ModalState
    lost: float | None = None

    @cached_property
    def error_bound(self) -> float:
        """Bound of the position error at the striking end relative to the stroke of the rigid motion.

        Rigorous when d > 0 and the load is smooth. Without damping, or with a load that jumps, modes beyond the probe
        are bounded by the way those inside it fall off.
        """
        orbit, lost = self.orbit, self.lost
        if lost is None:  # a requested number of modes: the forced part is cut as well
            force = abs(orbit.system.load.mean) + orbit.response.rigid_bounds()[1]
            cut = 2.0 * force / ((math.pi * orbit.system.s) ** 2 * max(self.modes, 1))
            lost = cut + float(_left_out(orbit, max(4 * self.modes, 2048))[self.modes])
        return lost / orbit.rigid_stroke


def truncation(orbit: Orbit) -> Truncation:
    """Choose the number of modes that the orbit's tolerance asks for, or take the number requested."""
    if orbit.requested_modes is not None:
        n = orbit.requested_modes
        return Truncation(orbit, n, n, n, orbit.modal_state(n))
    scale = orbit.rigid_stroke
    largest = _largest_probe(orbit)
    for probe in [p for p in _PROBES if p < largest] + [largest]:
        left_out = _left_out(orbit, probe)
        if left_out[-1] <= 0.5 * orbit.tolerance * scale:
            break
    most = min(probe, _MOST_MODES)

    def enough(share: float) -> int:
        found = np.flatnonzero(left_out <= share * scale)
        return min(most, max(8, int(found[0]))) if found.size else most

    modes = enough(orbit.tolerance)
    lost = float(left_out[modes])
    return Truncation(orbit, modes, enough(_FEW), enough(_SOME), orbit.modal_state(modes), lost)


def _left_out(orbit: Orbit, probe: int) -> Array:
    """Bound of what is lost at the striking end by keeping n = 0 … `probe` modes; shape (probe + 1,)."""
    amplitude = _amplitude(orbit, probe)
    lost = np.append(2.0 * np.cumsum(amplitude[::-1])[::-1], 0.0)
    return np.asarray(lost + _beyond(orbit, amplitude))


def _largest_probe(orbit: Orbit) -> int:
    if not isinstance(orbit.response, HarmonicResponse):
        return _PIECEWISE_MODES
    return max(1024, min(_PROBES[-1], _LARGEST_MATRIX // max(1, orbit.response.k.size)))


def _amplitude(orbit: Orbit, modes: int) -> Array:
    """Bound over time of the free motion of each mode at the striking end; shape (modes,)."""
    amplitude = orbit.modal_state(modes).amplitude
    if isinstance(orbit.response, HarmonicResponse):
        return amplitude
    u, v = orbit.response.knots(modes)
    return np.asarray(amplitude + np.hypot(u, v / mode_frequencies(orbit.system.s, modes)).max(axis=0))


def _beyond(orbit: Orbit, amplitude: Array) -> float:
    """Bound of what all modes after the last of `amplitude` add at the striking end."""
    n = amplitude.size
    top = slice(n // 2, n)
    numbers = np.arange(1, n + 1)[top]
    if not isinstance(orbit.response, HarmonicResponse):
        return 2.0 * float(np.max(amplitude[top] * numbers**2)) / n
    base = math.pi * orbit.system.s
    load = orbit.response.modal_velocity_bound(orbit.phase, base * n)
    bound = load * resolvent_bound(orbit.system, orbit.period, base * n) / (base**3 * n**2)
    seen = 2.0 * float(np.max(amplitude[top] * numbers**2)) / n  # small divisors grow no faster than they did
    return bound if math.isfinite(bound) else seen
