"""What a person must know of a motion by waves before using its figures."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from percuss.case.answers.numerals import number, percent

if TYPE_CHECKING:
    from percuss.blow.machine import MachineMotion

__all__ = ["waves_warnings"]

_RINGING = 0.05  # of a blow's energy: beyond, the next blow is not that of a bar at rest in itself
_UNSURE = 1e-3  # radians of phase between two lattices
_APART = 0.05  # of two restitutions
_PRESSED = 0.2 * 2.0 * math.pi  # what lasts longer is no blow: the load presses


def waves_warnings(motion: MachineMotion) -> list[str]:
    """One sentence each; none for a settled motion that two lattices and the law agree about."""
    from percuss.blow.machine import Ending

    found = []
    if motion.ending is Ending.CANCELLED:
        found.append("ended early: interrupted; the figures are those of the part that was computed")
    elif motion.settled is None and motion.limits.settled:
        found.append("no periodic motion found: simulate for longer, or look at the ringing that blows leave behind")
    own = motion.cycle
    found += _restitution(motion)
    left = float(np.median(own.ringing_share)) if own.size else 0.0
    if left > _RINGING and motion.settled is None and not motion.quiet:
        found.append(f"a blow leaves {percent(left)} of its energy as ringing (median), which damping must end in time")
    unsure = motion.uncertainty
    if unsure is not None and unsure.phase is None:
        found.append(f"a lattice with half the cells settles on {unsure.label}: give more cells")
    elif unsure is not None and unsure.phase is not None and unsure.phase > _UNSURE:
        found.append(f"a lattice with half the cells has phases {unsure.phase:.2g} rad from these: give more cells")
    return found


def _restitution(motion: MachineMotion) -> list[str]:
    """That the restitution of the law is not that of the main blows, those of half the greatest impulse or more."""
    own, assumed = motion.cycle, motion.system.restitution
    short = np.isfinite(own.restitution) & (own.duration < _PRESSED)
    main = short & (own.impulse >= 0.5 * own.impulse[short].max(initial=0.0))
    found = own.restitution[main]
    by_waves = float(np.median(found)) if found.size else assumed
    if motion.rests or math.isclose(by_waves, assumed, rel_tol=0.0, abs_tol=_APART):
        return []
    remedy = 'restitution = "from the blow" gives the law that of one blow on the tool'
    return [f"the blows have R = {number(by_waves, 3)} (median), the law beside them {number(assumed, 3)}: {remedy}"]
