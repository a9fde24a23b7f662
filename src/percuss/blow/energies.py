"""Where the energy and the momentum of a blow are at its end, and how well both close."""

from __future__ import annotations

from dataclasses import dataclass

from percuss.blow.course import Course
from percuss.blow.kernels.layout import ENDLESS, FREE, ROCK

__all__ = ["Balance", "RockState", "balance", "rock_state"]


@dataclass(frozen=True)
class RockState:
    """Penetrations, and the work that the rock has taken."""

    greatest: float
    residual: float
    after: float
    force: float
    work: float
    dissipated: float


@dataclass(frozen=True)
class Balance:
    """Energies and momenta at the end of the window, in the scales of the blow."""

    energy_before: float
    momentum_before: float
    momentum_after: float
    load_impulse: float
    load_work: float
    impulse: float
    rigid_after: float
    vibration_after: float
    through_face: float
    rod_energy: float
    rod_momentum: float
    bit_energy: float
    momentum_error: float
    energy_error: float


def balance(course: Course, rock: RockState | None) -> Balance:
    """The balance of a blow.

    Striker and rod are summed from the waves in them, the work through the face from those that passed it, and the
    rock's from its law: the two errors compare what has been computed in different ways.
    """
    striker, size, end = course.striker, course.size, course.end
    before, momentum = course.energy(0, striker, 0), course.momentum(0, striker, 0)
    after, left = course.energy(0, striker, end), course.momentum(0, striker, end)
    impulse = course.sums(2 * size, 0, end).plain
    load_impulse, load_work = _load(course)
    rigid = 0.5 * left * left / course.mass
    through, rod, rod_momentum, lumped, bit = 0.0, 0.0, 0.0, 0.0, 0.0
    if course.has_rod:
        through = _through_face(course)
        rod, rod_momentum = course.energy(striker, size, end), course.momentum(striker, size, end)
        lumped, bit = _lumped(course)
    taken = 0.0 if rock is None else rock.work
    scale = max(before, abs(load_work), abs(through), 1e-300)
    errors = before + load_work - after - through, through - rod - lumped - bit - taken
    push = max(abs(momentum), abs(impulse), abs(load_impulse), (course.mass * before) ** 0.5, 1e-300)
    return Balance(
        energy_before=before,
        momentum_before=momentum,
        momentum_after=left,
        load_impulse=load_impulse,
        load_work=load_work,
        impulse=impulse,
        rigid_after=rigid,
        vibration_after=max(0.0, after - rigid),
        through_face=through,
        rod_energy=rod + lumped,
        rod_momentum=rod_momentum,
        bit_energy=bit,
        momentum_error=abs(momentum + load_impulse - left - impulse) / push,
        energy_error=max(map(abs, errors)) / scale,
    )


def _through_face(course: Course) -> float:
    """∫ N v dt of the rod's face: the power of a wave is Z f² − Z g²."""
    row, back = 2 * course.striker, course.transit[course.striker]
    sent = course.sums(row, 0, course.end).square
    returned = 0.0 if course.endless(course.striker) else course.sums(row + 1, -back, course.end - back).square
    return float(course.impedance[course.striker]) * (sent - returned)


def _load(course: Course) -> tuple[float, float]:
    """Impulse and work of the load."""
    problem, impulse, work = course.held.problem, 0.0, 0.0
    ends = [*(int(t) for t in problem.load_start[1:]), course.end]
    for start, stop, force in zip(problem.load_start, ends, problem.load_force, strict=False):
        begin, end = int(start), min(int(stop), course.end)
        if end > begin:
            impulse += float(force) * (end - begin) * course.tick
            work += float(force) * course.travelled(problem.load_node, begin, end)
    return impulse, work


def _lumped(course: Course) -> tuple[float, float]:
    """Kinetic energy of the masses at the joints, and of the bit."""
    problem, joints = course.held.problem, 0.0
    for node in range(course.striker + 1, course.size):
        if problem.joint_mass[node] > 0.0:
            joints += 0.5 * problem.joint_mass[node] * course.node_velocity(node, course.end) ** 2
    bit = 0.5 * float(problem.joint_mass[-1]) * bit_velocity(course) ** 2 if problem.joint_mass[-1] > 0.0 else 0.0
    return joints, bit


def bit_velocity(course: Course) -> float:
    """Velocity of the far end at the end of the window."""
    if course.held.problem.end == ENDLESS:
        return 0.0
    row = 2 * course.size - 2
    return course.value(row, course.end - course.transit[-1]) + course.value(row + 1, course.end)


def rock_state(course: Course) -> RockState | None:
    """What the bit has done to the rock; None without one."""
    problem = course.held.problem
    if problem.end != ROCK:
        return None
    greatest = _greatest_penetration(course)
    force = course.value(2 * course.size + 2, course.end)
    dissipated = 0.5 * (1.0 - problem.ratio) * problem.stiffness * greatest**2
    stored = 0.5 * force**2 / problem.unloading
    return RockState(
        greatest=greatest,
        residual=(1.0 - problem.ratio) * greatest,
        after=course.value(2 * course.size + 1, course.end),
        force=force,
        work=dissipated + stored,
        dissipated=dissipated,
    )


def _greatest_penetration(course: Course) -> float:
    """So far, at least 0; from its pieces where the bit has been followed beyond the window."""
    if course.held.state.time[course.size] == course.end:
        return float(course.held.state.now[0].greatest)
    trace = course.trace(2 * course.size + 1)
    return max(0.0, float(trace.before(trace.times[1:]).max()))


def has_moving_end(course: Course) -> bool:
    """Whether a bit is at the far end."""
    return course.held.problem.end in (FREE, ROCK)
