"""When a blow is over: no further contact is possible, or nothing is left to pass on."""

from __future__ import annotations

import math

from percuss.blow.course import Course
from percuss.blow.kernels.layout import ENDLESS, FREE

__all__ = ["gap", "is_over", "is_spent"]

_LEFT = 1e-9
"""Share of the momentum that no longer matters."""


def is_over(course: Course) -> bool:
    """Whether the faces can never meet again after the window, which is proved by energy (Cauchy–Schwarz).

    A free bar's end is never further from where it would be without stress than sqrt(2 E G), E the energy of its
    vibration and G the compliance of the end under inertia relief. So two free bodies cannot touch once the distance
    of their unstressed ends exceeds both reaches and grows. A wall, and the face of an endless uniform rod without a
    force on it, stay where they are.
    """
    if not _unloaded(course) or course.in_contact:
        return False
    problem = course.held.problem
    free = course.has_rod and problem.end == FREE and not problem.joint_mass.any()
    stays = not course.has_rod or (problem.end == ENDLESS and course.size - course.striker == 1)
    if not (free or stays):
        return False
    reached, speed, reach = _free_body(course, 0, course.striker, True)
    distance, speed = gap(course) + reached, -speed
    if free:
        other = _free_body(course, course.striker, course.size, False)
        distance, speed, reach = distance - other[0], speed + other[1], reach + other[2]
    return speed >= 0.0 and distance > reach


def is_spent(course: Course) -> bool:
    """Whether the striker has neither momentum nor energy left, as after a long staircase."""
    if not _unloaded(course):
        return False
    before = course.energy(0, course.striker, 0)
    # Cauchy–Schwarz: the momentum is at most the square root of 2 M E
    return course.energy(0, course.striker, course.end) <= _LEFT**2 * before


def gap(course: Course) -> float:
    """Distance between the faces at the end of the window."""
    last = course.striker - 1
    back = course.transit[last]
    arrived = course.sums(2 * last, -back, course.end - back).plain
    own = arrived + course.sums(2 * last + 1, 0, course.end).plain
    other = course.travelled(course.striker, 0, course.end) if course.has_rod else 0.0
    return course.first_gap + other - own


def _unloaded(course: Course) -> bool:
    """Whether no force acts from the end of the window on."""
    problem = course.held.problem
    acting = 0.0
    for start, force in zip(problem.load_start, problem.load_force, strict=True):
        if start > course.end and force != 0.0:
            return False
        acting = force
    return acting == 0.0


def _free_body(course: Course, first: int, last: int, right: bool) -> tuple[float, float, float]:
    """Of a free body: its end's distance from where it would be without stress, mean velocity, and greatest reach."""
    time, tick = course.end, course.tick
    masses = [float(course.impedance[i]) * course.transit[i] * tick for i in range(first, last)]
    mass, before = sum(masses), 0.0
    end, compliance = 0.0, 0.0
    for i, own in zip(range(first, last), masses, strict=True):
        z, transit = float(course.impedance[i]), course.transit[i] * tick
        low, high = before / mass, (before + own) / mass
        if not right:  # the mass on the other side, with the opposite sign
            low, high = low - 1.0, high - 1.0
        f, g = course.section_sums(i, time)
        end -= high * f.plain - z / mass * f.moment - low * g.plain - z / mass * g.moment
        compliance += transit / z * (low * low + low * high + high * high) / 3.0
        before += own
    momentum, energy = course.momentum(first, last, time), course.energy(first, last, time)
    ringing = max(0.0, energy - 0.5 * momentum**2 / mass)
    return end, momentum / mass, math.sqrt(2.0 * ringing * compliance)
