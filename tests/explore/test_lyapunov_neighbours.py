"""Lyapunov exponents under any law of contact and of damping, beside motions that start a little apart."""

from __future__ import annotations

import numpy as np
import pytest

from percuss import Load, Start, Stop, System, Trajectory, run
from percuss.explore.lyapunov import lyapunov_exponent
from percuss.model.body import Body, External, KelvinVoigt, Ratio, SteppedBar, Table, UniformBar
from percuss.model.checks import Array
from percuss.model.contact import Contact, Kept, Reversed

MODES, IMPACTS, DISCARD, APART = 4, 20, 2, 1e-7


def size(system: System, displacement: Array, velocity: Array) -> float:
    """What the growth of a difference is measured by: of u_0, u_0', ω_n q_n and q_n', all together."""
    modes = system.body.modes(MODES, system.load.at)
    q, rate = modes.gamma * displacement[1:], modes.gamma * velocity[1:]
    return float(np.linalg.norm([displacement[0], velocity[0], *(modes.omega * q), *rate]))


def growths_of_a_neighbour(motion: Trajectory) -> list[float]:
    """Logarithms of the growth of a small difference from impact to impact, after the second one.

    It begins as the tangent vector does. After each impact a neighbour starts anew, nearer, before the wall.
    """
    system, times = motion.system, motion.events.time[motion.events.kind == "impact"]
    modes, n = system.body.modes(MODES, system.load.at), np.arange(MODES)
    u = np.append(1.0, 1.0 / (n + 2.0) / modes.gamma)
    v = np.append(1.0, (modes.omega - 0.5 * modes.damping) / (n + 2.0) / modes.gamma)
    time, found = float(times[1]), []
    for following in times[2 : IMPACTS + DISCARD + 1]:
        nearer = -np.copysign(APART / size(system, u, v), u[0] + modes.gamma @ u[1:])
        here = motion.modal([time])
        start = Start.modal(here.displacement[:, 0] + nearer * u, here.velocity[:, 0] + nearer * v, time=time)
        beside = run(system, start, modes=MODES, stop=Stop(impacts=2, periodic=False))
        time = max(float(following), float(beside.events.time[0]))
        u, v = (
            (getattr(beside.modal([time]), name) - getattr(motion.modal([time]), name))[:, 0]
            for name in ("displacement", "velocity")
        )
        found.append(float(np.log(size(system, u, v) / APART)))
    return found


@pytest.mark.parametrize(
    ("body", "contact", "factor"),
    [
        (UniformBar(3.0, External(0.02)), Kept(0.6), 0.66),
        (UniformBar(3.0, External(0.02)), Reversed(0.6), 0.6),
        (UniformBar(0.9, Ratio(0.03)), Reversed(0.5), 0.66),
        (UniformBar(3.0, Ratio(0.03)), Kept(0.6), 0.66),
        (UniformBar(2.0, KelvinVoigt(0.2)), Kept(0.6), 0.66),  # overdamped modes
        (UniformBar(2.0, KelvinVoigt(0.2)), Reversed(0.6), 0.66),
        (UniformBar(2.0, Table((0.5, 0.0, 30.0, 0.1))), Reversed(0.6), 0.6),
        (SteppedBar(3.0, (2.0, 1.0), (0.4, 0.6), Ratio(0.02)), Kept(0.6), 0.5),
    ],
)
def test_neighbours_part_as_the_exponent_says(body: Body, contact: Contact, factor: float) -> None:
    system, start = System(body, Load.harmonic(factor, 1.0), contact), Start.rigid(-0.5, time=0.3)
    motion = run(system, start, modes=MODES, stop=Stop(impacts=IMPACTS + DISCARD + 2, periodic=False))
    assert set(motion.events.kind.tolist()) == {"impact"}
    growth = growths_of_a_neighbour(motion)[1:]
    t = np.arange(1, IMPACTS + 1) / (IMPACTS + 1.0)
    weight = np.exp(-1.0 / (t * (1.0 - t)))
    found = lyapunov_exponent(system, start, modes=MODES, impacts=IMPACTS, discard=DISCARD)
    assert found.impacts == IMPACTS == len(growth)
    assert found.exponent == pytest.approx(float(weight @ growth / weight.sum()), abs=1e-5)
