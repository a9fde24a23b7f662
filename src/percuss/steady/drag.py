"""What the damping does to the motion of the bar as a whole: a drag.

External damping d is spread along the bar (B77 3). It lets the elastic modes ring down, and it brakes the rigid motion
with the force c·v: c is d in the units of here, and D·L in N·s/m. Guessed for the ringing it can be a drag that no
machine has; the other laws of damping leave the rigid motion free.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from percuss.errors import ResonanceError
from percuss.model import External, System
from percuss.model.checks import count, instance
from percuss.steady.level import level_of
from percuss.steady.orbit import Orbit
from percuss.steady.phases import Arcs, forced_response
from percuss.steady.states import MAX_PERIODS, check_pushes

__all__ = ["Drag", "drag_of", "greatest_drag"]

_HALVINGS = 30


@dataclass(frozen=True)
class Drag:
    """The drag on the rigid motion; dimensionless.

    Attributes
    ----------
    force
        At the striking speed of the rigid motion: d·w_0.
    of_mean
        The same as a fraction of the mean push p_0.
    of_input
        What all the damping takes, as a fraction of what the load puts in; None when it puts nothing in.
    """

    force: float
    of_mean: float
    of_input: float | None


def drag_of(orbit: Orbit) -> Drag:
    """The drag on a steady motion.

    Raises
    ------
    ParameterError
        For anything that is no orbit.

    Examples
    --------
    >>> from percuss import Load, System, steady_states
    >>> system = System(s=20.0, d=0.05, restitution=0.6, load=Load.harmonic(0.6, 1.0))
    >>> drag = drag_of(steady_states(system).orbits[1])
    >>> print(f"{drag.of_mean:.3f} of the mean push, {drag.of_input:.2f} of the input")
    0.196 of the mean push, 0.32 of the input
    """
    instance("orbit", orbit, Orbit)
    energy, force = orbit.energy, orbit.system.d * orbit.rigid_velocity
    put_in = energy.input if energy.input > 0.0 else None
    return Drag(force, force / orbit.system.load.mean, None if put_in is None else energy.damping / put_in)


def greatest_drag(system: System, periods: int) -> float | None:
    """The greatest d, below that of the system, with which a steady motion exists, all else kept; None without one.

    Raises
    ------
    LoadError
        When the load does not push or is constant.
    ParameterError
        For anything that is no system, and periods out of range.
    """
    check_pushes(instance("system", system, System))
    period = 2.0 * math.pi * count("periods", periods, most=MAX_PERIODS)

    def exists(d: float) -> bool:
        lighter = System(system.body.damped_by(External(d)), system.load, system.contact)
        try:
            highest = Arcs.of(forced_response(lighter)).highest
        except ResonanceError:
            return False
        return level_of(lighter, period) <= highest

    low, high = 1e-9 * system.d, system.d
    if not low > 0.0 or not exists(low):
        return None
    for _ in range(_HALVINGS):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if exists(middle) else (low, middle)
    return low
