"""What the tests of the machine share: systems, one blow from rest, the modes of what the cells hold."""

from __future__ import annotations

import math

from percuss.blow import Rod
from percuss.blow.periods import Impacts, run_by_waves
from percuss.blow.periods.lattice import machine_record
from percuss.blow.periods.wave_motion import LatticeRun, rigid_state
from percuss.model import Kept, Load, System
from percuss.model.body import SteppedBar, UniformBar
from percuss.simulate import Start, Stop

TURN = 2.0 * math.pi
S = 10.0 / TURN
"""Ten transit times to 2π, which no lattice need round."""

QUIET_LOAD = Load.harmonic(0.0, 0.0)
DRIFTER = (1.2566, 1.9635, 0.9503), (0.0731, 0.2187, 0.1493)


def bar(s, impedances=(1.0,), times=(1.0,), load=QUIET_LOAD, **more):
    """A system; its contact law has no part in the waves."""
    return System(SteppedBar(s, impedances, times, **more), load, Kept(0.5))


def uniform(s, load, damping=None):
    return System(UniformBar(s) if damping is None else UniformBar(s, damping), load, Kept(0.5))


def rod_for(system, ratio):
    """An endless rod of so many times the impedance of the striking end."""
    body = system.body
    z = body.s if isinstance(body, UniformBar) else body.sections.impedance[-1]
    return Rod.of_impedance(ratio * float(z))


def one_blow(system, target, cells, gap=0.0123 / S) -> Impacts:
    """The contacts, each told singly, of a striker that comes at unit speed, within a period of time."""
    return run_by_waves(system, target, Start.rigid(-gap, 1.0), Stop(time=TURN, tolerance=1e-6), cells=cells).impacts


def contacts_of_blow(system, target, cells, gap=0.0123 / S):
    """The record of every contact in the first 2π of a striker that comes at unit speed."""
    course = followed(system, target, cells, Start.rigid(-gap, 1.0))
    return course.contacts


def followed(system, target, cells, start, periods=1, **how):
    options = {"pushed_back": False, "quiet": False} | how
    course = LatticeRun(machine_record(system, target, cells, **options)[1], *rigid_state(start, system))
    for _ in range(periods):
        for _ in course.period():
            pass
    return course


def settled(system, target, start=None, cells=100, **more):
    """The periodic motion from a start, which must be there."""
    motion = run_by_waves(system, target, Start.rigid(-2.0, 0.0, 0.3) if start is None else start, cells=cells, **more)
    assert motion.cycle is not None, motion
    return motion
