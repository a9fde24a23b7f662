"""The rounding error of the gap during a flight."""

from __future__ import annotations

from typing import NamedTuple

from percuss.compiled import inlined
from percuss.simulate.kernels.codes import EPS
from percuss.simulate.kernels.creeping import creep_sizes


class Blur(NamedTuple):
    """What the rounding error of the gap is made of, each times some eps; see `blur`.

    `rush`, `crush`: the errors of the rate and of the acceleration.
    """

    at: float
    drifting: float
    push: float
    swing: float
    ring: float
    lasting: float
    place: float
    creeps: float
    rush: float
    crush: float


@inlined
def blur_of(bar, modes, motion, osc, ring1, ring2, curve):
    """The parts of the error for a flight from the anchor.

    `ring1`, `ring2`, `curve`: bounds of the derivatives of the oscillating modes, and of the smooth curvature.
    """
    now = motion.now
    error = EPS * (8.0 + 0.125 * modes.omega.shape[0] + 0.5 * osc.shape[1])
    drifting, place, creeps, crush = abs(now.drift) + bar.sway, 0.0, 0.0, ring2
    if modes.creeping.shape[0]:
        place, creeps, rush, crush = creep_sizes(bar, modes, motion.z)
        drifting, place, creeps, crush = drifting + rush, error * place, error * creeps, ring2 + crush
    return Blur(
        error * abs(now.gap), error * drifting, error * abs(bar.mean), error * bar.swing, error * ring1, bar.lasting,
        place, creeps, error * (drifting + bar.swing + ring1), error * (curve + crush),
    )  # fmt: skip


@inlined
def blur(size, tau, first, second):
    """The rounding error of the gap at τ, where `first` and `second` are those of `drift`.

    It is some eps, already in `size`, times the sum of the absolute values of what is summed: the gap at the anchor;
    the drift b `first` + mean `second`; what the load's harmonics add, at most Σk|amplitude| τ or twice the amplitudes;
    the oscillating modes, whose phase is known to eps λτ while they last, e^{−dτ/2} τ ≤ 2/(e d); and the creeping
    ones, |q'(0)| h + |q(0)| g with h ≤ `first` and g ≤ ω² `second` (`creep`).
    """
    total = size.at + size.drifting * abs(first) + size.push * second + size.swing * min(tau, 2.0)
    total = total + size.ring * min(tau, size.lasting)
    return total + min(size.place, size.creeps * second)
